//! Filling gaps of markers.
//!
//! A gap is a run of missing samples with a present one on either side; what is missing at the start
//! or end of a take stays so. Every gap up to a limit is filled by one method, and every sample so made is
//! [`Status::Filled`]. Filled samples never support the filling of another gap of the same marker.
//!
//! Fingertips are filled in the frame of the hand wherever the hand is known all through the gap:
//! while a fingertip is hidden the hand goes on moving, which is known, and only the motion within the
//! hand has to be guessed. Other markers are filled in the world. The hand is taken as recorded; where
//! it jumps within the gap its frame is of no use.

mod cluster;
mod neighbours;

use std::ops::Range;

use inhand_model::{
    Change, ChangeKind, Frame, Hand, MarkerKind, PerFinger, PointTrack, Pose, PoseTrack, Position,
    Recording, Roles, Status, World, named,
};
use inhand_motion::{GapFill, MotionError, fingertip_markers, gap_samples};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::continuity::parabola;
use crate::lookup::{Flips, finger_of, hand_breaks, hand_poses, in_hand};

/// Samples on each side from which its velocity is taken: the slope of a parabola there. A cubic through
/// two samples on each side has a velocity of noise: over a gap of 0.1 s at 100 Hz it triples the jitter
/// of the samples; from nine the slope is three times as sure, and still follows a turn.
const SIDE: usize = 9;
/// From fewer samples than this the slope is that of a line.
const PARABOLA: usize = 6;

named! {
    /// How gaps are filled.
    #[derive(Serialize, Deserialize)]
    #[serde(rename_all = "lowercase")]
    pub enum FillMethod {
        /// Not at all.
        None = "none",
        /// The straight line from the sample before to the sample after.
        Linear = "linear",
        /// The cubic that leaves and arrives with the velocities of the motion on both sides, each
        /// taken from up to five samples.
        Cubic = "cubic",
        /// Where the other markers of the same rigid cluster say it is: markers of the clusters that
        /// roles name, and of rigid bodies. Three others at least, or the body's pose, are needed all
        /// through the gap; other markers stay as they are.
        Cluster = "cluster",
        /// Where the other fingertips say it is, by a regression on their motion in the hand before
        /// and after the gap; joined to both sides. For fingertips; other markers stay as they are.
        Neighbours = "neighbours",
    }
}

/// What is filled and how.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FillSettings {
    /// How gaps are filled.
    pub method: FillMethod,
    /// Longest gap that is filled, seconds.
    pub limit_s: f64,
}

/// Fills gaps of the labelled markers, and by [`FillMethod::Cluster`] those of rigid bodies' markers.
///
/// # Errors
///
/// [`MotionError`], also where a cluster with a gap has too few other markers.
pub fn fill(
    recording: &mut Recording,
    roles: &Roles,
    settings: &FillSettings,
) -> Result<Vec<Change>, MotionError> {
    let limit = gap_samples("fill limit", settings.limit_s, recording.clock.rate_hz())?;
    let tips = fingertip_markers(recording, roles)?;
    let filled = match settings.method {
        FillMethod::None => Vec::new(),
        FillMethod::Linear | FillMethod::Cubic => {
            along_its_way(recording, roles, &tips, settings.method, limit)?
        }
        FillMethod::Cluster => cluster::from_clusters(recording, roles, &tips, limit)?,
        FillMethod::Neighbours => {
            let hand = hand_poses(recording, roles, Flips::Kept)?;
            let mut filled = neighbours::from_neighbours(recording, &hand, &tips, limit);
            let breaks = hand_breaks(recording, roles);
            filled.retain(|filled| !crosses(&filled.gap, &breaks));
            filled
        }
    };
    let mut changes = Vec::new();
    for filled in filled {
        let target = &mut recording.markers[filled.marker];
        for (k, value) in filled.gap.clone().zip(filled.values) {
            target.track.set(k, Some(value), Status::Filled);
        }
        let (count, method) = (filled.gap.len(), settings.method.name());
        let plural = if count == 1 { "" } else { "s" };
        changes.push(Change {
            kind: ChangeKind::Filled,
            entity: target.name.clone(),
            message: format!("{count} missing sample{plural} filled ({method})"),
            samples: filled.gap,
        });
    }
    changes.sort_by(|a, b| (a.samples.start, &a.entity).cmp(&(b.samples.start, &b.entity)));
    Ok(changes)
}

/// Values for one gap of one marker.
struct Filled {
    marker: usize,
    gap: Range<usize>,
    values: Vec<Position<World>>,
}

/// Gaps up to the limit with present samples on both sides.
fn inner_gaps<F: Frame>(track: &PointTrack<F>, limit: usize) -> impl Iterator<Item = Range<usize>> {
    let len = track.len();
    (track.gaps().into_iter())
        .filter(move |gap| gap.start > 0 && gap.end < len && gap.len() <= limit)
}

/// Whether the hand jumps somewhere from the sample before a gap to the sample after.
fn crosses(gap: &Range<usize>, breaks: &[Range<usize>]) -> bool {
    (breaks.iter()).any(|jump| jump.start < gap.end && gap.start <= jump.end)
}

fn along_its_way(
    recording: &Recording,
    roles: &Roles,
    tips: &PerFinger<usize>,
    method: FillMethod,
    limit: usize,
) -> Result<Vec<Filled>, MotionError> {
    let hand = hand_poses(recording, roles, Flips::Kept)?;
    let hand_from_world = hand.map(Pose::inverse);
    let breaks = hand_breaks(recording, roles);
    let mut filled = Vec::new();
    for (marker, source) in recording.markers.iter().enumerate() {
        if source.kind != MarkerKind::Labelled {
            continue;
        }
        let in_the_hand = finger_of(tips, marker).map(|_| in_hand(&hand_from_world, &source.track));
        for gap in inner_gaps(&source.track, limit) {
            let known = |k: usize| hand.get(k).is_some();
            let by_hand = (in_the_hand.as_ref())
                .filter(|_| (gap.start - 1..=gap.end).all(known) && !crosses(&gap, &breaks))
                .and_then(|track| to_world(&hand, &gap, one_gap(track, &gap, method)));
            let values = by_hand.unwrap_or_else(|| one_gap(&source.track, &gap, method));
            filled.push(Filled {
                marker,
                gap,
                values,
            });
        }
    }
    Ok(filled)
}

fn one_gap<F: Frame>(
    track: &PointTrack<F>,
    gap: &Range<usize>,
    method: FillMethod,
) -> Vec<Position<F>> {
    if method == FillMethod::Cubic {
        return cubic(track, gap);
    }
    let mut piece = track.slice(gap.start - 1..gap.end + 1);
    inhand_motion::fill_points(&mut piece, gap.len(), GapFill::Linear);
    (1..=gap.len()).map(|k| piece.value(k)).collect()
}

/// Values inside a gap that has present samples on both sides: Hermite's cubic with the velocities
/// there, the line's where a side has a single sample.
fn cubic<F: Frame>(track: &PointTrack<F>, gap: &Range<usize>) -> Vec<Position<F>> {
    let at = |k: usize| track.get(k).map(Position::coords_m);
    let [from, to] = [gap.start - 1, gap.end].map(|k| track.value(k).coords_m());
    let steps = (gap.len() + 1) as f64;
    let line = (to - from) / steps;
    let before =
        (0..SIDE).map_while(|back| Some((-(back as f64), at((gap.start - 1).checked_sub(back)?)?)));
    let after = (0..SIDE).map_while(|ahead| Some((ahead as f64, at(gap.end + ahead)?)));
    let leaves = slope_at_zero(before).unwrap_or(line) * steps;
    let arrives = slope_at_zero(after).unwrap_or(line) * steps;
    gap.clone()
        .map(|k| {
            let s = (k + 1 - gap.start) as f64 / steps;
            let (s2, s3) = (s * s, s * s * s);
            Position::from_coords(
                from * (2.0 * s3 - 3.0 * s2 + 1.0)
                    + leaves * (s3 - 2.0 * s2 + s)
                    + to * (3.0 * s2 - 2.0 * s3)
                    + arrives * (s3 - s2),
            )
        })
        .collect()
}

/// Slope at time 0 of the curve of least squares, a sample; `None` for a single sample.
fn slope_at_zero(samples: impl Iterator<Item = (f64, Vector3<f64>)>) -> Option<Vector3<f64>> {
    let samples: Vec<_> = samples.collect();
    if samples.len() < 2 {
        return None;
    }
    let [_, slope, _] = parabola(&samples, samples.len() >= PARABOLA)?;
    Some(slope)
}

/// Adds to a guess at every sample of a gap what it is off by on both sides, in proportion.
fn join<F: Frame>(
    gap: &Range<usize>,
    off_before: Vector3<f64>,
    off_after: Vector3<f64>,
    guess: impl Fn(usize) -> Vector3<f64>,
) -> Vec<Position<F>> {
    let steps = (gap.len() + 1) as f64;
    gap.clone()
        .map(|k| {
            let part = (k + 1 - gap.start) as f64 / steps;
            Position::from_coords(guess(k) + off_before * (1.0 - part) + off_after * part)
        })
        .collect()
}

/// A track in the hand's frame back in the world.
fn to_world(
    hand: &PoseTrack<World, Hand>,
    gap: &Range<usize>,
    values: Vec<Position<Hand>>,
) -> Option<Vec<Position<World>>> {
    (gap.clone().zip(values))
        .map(|(k, at)| Some(hand.get(k)? * at))
        .collect()
}
