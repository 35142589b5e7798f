//! Lost fingertips among unlabelled markers.
//!
//! A piece of an unlabelled marker is a fingertip if it lies where the fingertip is missing, begins or
//! ends where it was last seen or is next seen, as its motion there says, and lies where that finger
//! can be in the hand. Pieces are taken in order of time, each as the finger's from then on, so that
//! several pieces can follow each other in one gap.

use std::ops::Range;

use inhand_model::{Finger, Hand, MarkerKind, PerFinger, PointTrack, Pose, Recording, Roles};
use inhand_motion::{MotionError, fingertip_markers};

use crate::continuity::{End, UsualJumps, end_after, end_before, jump_m};
use crate::geometry::Geometry;
use crate::lookup::{Flips, hand_poses, in_hand};
use crate::statistics::median;
use crate::suspect::{Suspect, SuspectKind, take_over};

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
/// [`MotionError`].
pub fn unlabelled(recording: &Recording, roles: &Roles) -> Result<Vec<Suspect>, MotionError> {
    let [_, _, unlabelled] = super::fingertips(recording, roles)?;
    Ok(unlabelled)
}

pub(crate) fn unlabelled_of_clean_tips(
    recording: &Recording,
    roles: &Roles,
) -> Result<Vec<Suspect>, MotionError> {
    let pieces = pieces(recording);
    if pieces.is_empty() {
        return Ok(Vec::new());
    }
    let hand = hand_poses(recording, roles, Flips::SetAside)?.map(Pose::inverse);
    let tips = fingertip_markers(recording, roles)?;
    let mut fingers = PerFinger::from_fn(|f| in_hand(&hand, &recording.markers[tips[f]].track));
    let rate_hz = recording.clock.rate_hz();
    let search = Search {
        usual: UsualJumps::measured(&fingers.as_array().each_ref(), rate_hz),
        places: Geometry::new(&fingers.each_ref()),
        rate_hz,
    };
    let mut found = Vec::new();
    for (marker, samples) in pieces {
        let source = &recording.markers[marker];
        let mut piece = PointTrack::missing(source.track.len());
        take_over(&mut piece, &source.track, &samples);
        let piece = in_hand(&hand, &piece);
        let best = (Finger::ALL.into_iter())
            .filter_map(|finger| {
                let ratio = search.ratio(&fingers[finger], finger, &piece, &samples)?;
                Some((ratio, finger))
            })
            .min_by(|(a, _), (b, _)| a.total_cmp(b));
        let Some((ratio, finger)) = best else {
            continue;
        };
        take_over(&mut fingers[finger], &piece, &samples);
        found.push(Suspect {
            kind: SuspectKind::Unlabelled {
                marker,
                name: source.name.clone(),
                finger,
            },
            samples,
            score: FITS_RATIO / ratio.max(1e-3),
        });
    }
    Ok(found)
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

impl Search {
    /// The larger jump at the ends of a piece in usual jumps, if the piece can be this finger's.
    fn ratio(
        &self,
        finger_track: &PointTrack<Hand>,
        finger: Finger,
        piece: &PointTrack<Hand>,
        samples: &Range<usize>,
    ) -> Option<f64> {
        if samples.clone().any(|k| finger_track.get(k).is_some()) {
            return None;
        }
        // A piece has samples; the hand may be missing at all of them.
        let places = samples.clone().filter_map(|k| piece.get(k));
        let deviations = places.map(|at| self.places.deviations(finger, at));
        if median(deviations) > FARTHEST_DEVIATIONS {
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
        let ends: Vec<(End, End)> = [start, end].into_iter().flatten().collect();
        let fits = |(before, after): &(End, End)| {
            self.usual.ratio(before, after) <= FITS_RATIO
                && jump_m(before, after, self.rate_hz) <= FITS_M
        };
        let ratios = ends
            .iter()
            .map(|(before, after)| self.usual.ratio(before, after));
        (ends.iter().all(fits))
            .then(|| ratios.max_by(f64::total_cmp))
            .flatten()
    }
}
