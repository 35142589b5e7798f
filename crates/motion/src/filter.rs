//! Filters without delay, on one coordinate of one interval of present samples, and on tracks.
//!
//! Each takes an interval without gaps and gives one as long; nothing is assumed beyond its ends (no
//! zeros, no repeated samples). What each does there instead is its edge rule.

mod butterworth;
mod median;
mod savitzky_golay;

use std::ops::Range;

use inhand_model::{Frame, PointTrack, Pose, PoseTrack, Position, Sample, Track};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector4};
use rayon::prelude::*;

pub use butterworth::Butterworth;
pub use median::Median;
pub use savitzky_golay::SavitzkyGolay;

use crate::error::MotionError;
use crate::settings::Filter;

/// Norm below which a filtered quaternion names no orientation: the window then held orientations
/// half a turn and more apart. (Samples of one orientation keep norm 1.)
const MIN_QUATERNION_NORM: f64 = 1e-3;

/// A filter with everything computed that does not depend on the data: from an interval to one as long.
pub(crate) type Smoother = Box<dyn Fn(&[f64]) -> Vec<f64> + Send + Sync>;

/// The filter that settings ask for.
pub(crate) fn smoother(filter: Filter, rate_hz: f64) -> Result<Smoother, MotionError> {
    Ok(match filter {
        Filter::None => Box::new(<[f64]>::to_vec),
        Filter::Median { window } => {
            let filter = Median::new(window)?;
            Box::new(move |interval| filter.apply(interval))
        }
        Filter::SavitzkyGolay { window, order } => {
            let filter = SavitzkyGolay::new(window, order)?;
            Box::new(move |interval| filter.apply(interval))
        }
        Filter::Butterworth { cutoff_hz, order } => {
            let filter = Butterworth::new(cutoff_hz, order, rate_hz)?;
            Box::new(move |interval| filter.apply(interval))
        }
    })
}

/// Filters positions. A sample keeps its status, whatever the samples around it are.
pub(crate) fn smooth_points<F: Frame>(track: &PointTrack<F>, smoother: &Smoother) -> PointTrack<F> {
    let columns = (0..3)
        .map(|axis| (track.values().map(|p| p.coords_m()[axis])).collect())
        .collect();
    let columns = smooth_columns(columns, &track.present(), smoother);
    rebuilt(track, |k| {
        Some(Position::new(columns[0][k], columns[1][k], columns[2][k]))
    })
}

/// Filters poses: positions, and orientations as sign-continuous quaternions, component by
/// component, then normalised. A sample keeps its status, except that it is missing where the
/// filtered quaternion vanishes.
pub(crate) fn smooth_poses<To: Frame, From: Frame>(
    track: &PoseTrack<To, From>,
    smoother: &Smoother,
) -> PoseTrack<To, From> {
    let mut columns: Vec<Vec<f64>> = (0..3)
        .map(|axis| {
            track
                .values()
                .map(|pose| pose.isometry().translation.vector[axis])
                .collect()
        })
        .collect();
    let quaternions = sign_continuous(track);
    columns.extend((0..4).map(|i| quaternions.iter().map(|q| q[i]).collect()));
    let columns = smooth_columns(columns, &track.present(), smoother);
    rebuilt(track, |k| {
        let [x, y, z, i, j, l, w] = std::array::from_fn(|column| columns[column][k]);
        let rotation = UnitQuaternion::try_new(Quaternion::new(w, i, j, l), MIN_QUATERNION_NORM)?;
        let translation = Translation3::new(x, y, z);
        Some(Pose::new(Isometry3::from_parts(translation, rotation)))
    })
}

/// Quaternions (x, y, z, w) whose signs are such that neighbours are on one side of the sphere, the
/// first with `w >= 0`; also across gaps, for a reader who goes on from the last one seen.
fn sign_continuous<To: Frame, From: Frame>(track: &PoseTrack<To, From>) -> Vec<Vector4<f64>> {
    let mut last = Vector4::w();
    track
        .values()
        .map(|pose| {
            let q = pose.isometry().rotation.coords;
            // Also false for a missing sample, which is NaN and must not be gone on from.
            if q.dot(&last) < 0.0 {
                last = -q;
                -q
            } else {
                if !q.x.is_nan() {
                    last = q;
                }
                q
            }
        })
        .collect()
}

fn smooth_columns(
    columns: Vec<Vec<f64>>,
    intervals: &[Range<usize>],
    smoother: &Smoother,
) -> Vec<Vec<f64>> {
    columns
        .into_par_iter()
        .map(|mut column| {
            for interval in intervals {
                let smooth = smoother(&column[interval.clone()]);
                column[interval.clone()].copy_from_slice(&smooth);
            }
            column
        })
        .collect()
}

/// A track with the statuses of another.
fn rebuilt<T: Sample>(track: &Track<T>, value: impl Fn(usize) -> Option<T>) -> Track<T> {
    let statuses = track.statuses().iter().enumerate();
    statuses.map(|(k, &status)| (value(k), status)).collect()
}
