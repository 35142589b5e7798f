//! The cubic that goes on with the motion of both sides.

use std::ops::Range;

use inhand_model::{Frame, PointTrack, Position};
use nalgebra::Vector3;

use crate::continuity::parabola;

/// Samples on each side from which its velocity is taken: the slope of a parabola there. A cubic through
/// two samples on each side has a velocity of noise: over a gap of 0.1 s at 100 Hz it triples the jitter
/// of the samples; from nine the slope is three times as sure, and still follows a turn.
const SIDE: usize = 9;
/// From fewer samples than this the slope is that of a line.
const PARABOLA: usize = 6;

/// Values inside a gap that has present samples on both sides: Hermite's cubic with the velocities
/// there, the line's where a side has a single sample.
pub(super) fn across<F: Frame>(track: &PointTrack<F>, gap: &Range<usize>) -> Vec<Position<F>> {
    let at = |k: usize| track.get(k).map(Position::coords_m);
    let values = track.values();
    let (from, to) = (values[gap.start - 1].coords_m(), values[gap.end].coords_m());
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
