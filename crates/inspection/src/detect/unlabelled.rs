//! Lost fingertips among unlabelled markers.
//!
//! A piece of an unlabelled marker is a fingertip if it lies where the fingertip is missing, begins or
//! ends where it was last seen or is next seen, as its motion there says, and lies where that finger
//! can be in the hand. Pieces are taken in order of time, each as the finger's from then on, so that
//! several pieces can follow each other in one gap.

use std::ops::Range;

use inhand_model::{Finger, Hand, MarkerKind, PerFinger, PointTrack, Recording, Roles};

use super::Unlabelled;
use crate::continuity::{End, UsualJumps, end_after, end_before, jump_m};
use crate::error::CleaningError;
use crate::geometry::Geometry;
use crate::lookup::{Flips, hand_poses, in_hand, tips};
use crate::repair;

/// An end of a piece says whose it is if the finger was seen within this time of it, seconds.
const NEAR_S: f64 = 0.15;
/// An end fits if it is off by no more than this many times the usual.
const FITS_RATIO: f64 = 6.0;
/// And by no more than this, metres: less than half a fingertip, so that no neighbour fits.
const FITS_M: f64 = 0.006;
/// Farthest from a finger's usual place, in usual deviations.
const FARTHEST_DEVIATIONS: f64 = 8.0;
/// Holes of so many samples do not end a piece.
const HOLE_SAMPLES: usize = 2;
/// Fewer samples are no piece: one or two may be anything.
const LEAST_SAMPLES: usize = 3;

/// Pieces of unlabelled markers that look like lost fingertips, with flips, swaps and spikes set
/// aside.
///
/// # Errors
///
/// [`CleaningError::NotInTake`], [`CleaningError::Hand`].
pub fn unlabelled(recording: &Recording, roles: &Roles) -> Result<Vec<Unlabelled>, CleaningError> {
    Ok(super::all(recording, roles)?.unlabelled)
}

pub(crate) fn unlabelled_of_clean_tips(
    recording: &Recording,
    roles: &Roles,
) -> Result<Vec<Unlabelled>, CleaningError> {
    let pieces = pieces(recording);
    if pieces.is_empty() {
        return Ok(Vec::new());
    }
    let hand = hand_poses(recording, roles, Flips::SetAside)?;
    let tips = tips(recording, roles)?;
    let mut fingers = PerFinger::from_fn(|f| in_hand(&hand, &recording.markers[tips[f]].track));
    let rate_hz = recording.clock.rate_hz();
    let search = Search {
        usual: UsualJumps::measured(&fingers.as_array().each_ref(), rate_hz),
        places: Geometry::of(&fingers.each_ref()),
        rate_hz,
    };
    let mut found = Vec::new();
    for (marker, samples) in pieces {
        let source = &recording.markers[marker];
        let piece = in_hand(&hand, &source.track.slice_as_track(&samples));
        let best = (Finger::ALL.into_iter())
            .filter_map(|finger| {
                Some((
                    search.fit(&fingers[finger], finger, &piece, &samples)?,
                    finger,
                ))
            })
            .min_by(|(a, _), (b, _)| a.ratio.total_cmp(&b.ratio));
        let Some((fit, finger)) = best else { continue };
        repair::take_over(&mut fingers[finger], &piece, &samples);
        found.push(Unlabelled {
            marker,
            name: source.name.clone(),
            finger,
            samples,
            jump_m: fit.jump_m,
            score: FITS_RATIO / fit.ratio.max(1e-3),
        });
    }
    Ok(found)
}

trait Masked {
    /// A track of the same length that is missing outside `samples`.
    fn slice_as_track(&self, samples: &Range<usize>) -> Self;
}

impl Masked for PointTrack<inhand_model::World> {
    fn slice_as_track(&self, samples: &Range<usize>) -> Self {
        let mut track = PointTrack::missing(self.len());
        repair::take_over(&mut track, self, samples);
        track
    }
}

/// Pieces of all unlabelled markers, in order of their first sample.
fn pieces(recording: &Recording) -> Vec<(usize, Range<usize>)> {
    let mut pieces = Vec::new();
    for (index, marker) in recording.markers.iter().enumerate() {
        if marker.kind != MarkerKind::Unlabelled {
            continue;
        }
        let mut open: Option<Range<usize>> = None;
        for k in (0..marker.track.len()).filter(|&k| marker.track.get(k).is_some()) {
            open = match open {
                Some(piece) if k <= piece.end + HOLE_SAMPLES => Some(piece.start..k + 1),
                done => {
                    pieces.extend(done.map(|piece| (index, piece)));
                    Some(k..k + 1)
                }
            };
        }
        pieces.extend(open.map(|piece| (index, piece)));
    }
    pieces.retain(|(_, piece)| piece.len() >= LEAST_SAMPLES);
    pieces.sort_by_key(|(marker, piece)| (piece.start, *marker));
    pieces
}

struct Search {
    usual: UsualJumps,
    places: Geometry,
    rate_hz: f64,
}

/// How a piece fits a finger.
struct Fit {
    /// The larger jump at its ends, metres.
    jump_m: f64,
    /// The same in usual jumps.
    ratio: f64,
}

impl Search {
    /// `None` if the piece cannot be this finger's.
    fn fit(
        &self,
        finger_track: &PointTrack<Hand>,
        finger: Finger,
        piece: &PointTrack<Hand>,
        samples: &Range<usize>,
    ) -> Option<Fit> {
        if samples.clone().any(|k| finger_track.get(k).is_some()) {
            return None;
        }
        let mut places: Vec<f64> = (samples.clone().filter_map(|k| piece.get(k)))
            .map(|at| self.places.deviations(finger, at))
            .collect();
        if places.is_empty() || crate::statistics::median(&mut places) > FARTHEST_DEVIATIONS {
            return None;
        }
        let near = (NEAR_S * self.rate_hz).round() as usize;
        let first = samples.clone().find(|&k| piece.get(k).is_some())?;
        let last = samples.clone().rev().find(|&k| piece.get(k).is_some())?;
        let before = (first.saturating_sub(near)..first)
            .rev()
            .find(|&k| finger_track.get(k).is_some());
        let after = (last + 1..(last + 1 + near).min(finger_track.len()))
            .find(|&k| finger_track.get(k).is_some());
        let start =
            before.and_then(|k| Some((end_before(finger_track, k)?, end_after(piece, first)?)));
        let end = after.and_then(|k| Some((end_before(piece, last)?, end_after(finger_track, k)?)));
        let fits: Vec<Fit> = [start, end]
            .into_iter()
            .flatten()
            .map(|ends| self.joint(&ends))
            .collect();
        let all_fit = fits
            .iter()
            .all(|fit| fit.ratio <= FITS_RATIO && fit.jump_m <= FITS_M);
        if fits.is_empty() || !all_fit {
            return None;
        }
        fits.into_iter().max_by(|a, b| a.ratio.total_cmp(&b.ratio))
    }

    fn joint(&self, (before, after): &(End, End)) -> Fit {
        Fit {
            jump_m: jump_m(before, after, self.rate_hz),
            ratio: self.usual.ratio(before, after),
        }
    }
}
