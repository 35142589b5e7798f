//! Filling short gaps.
//!
//! A gap is a run of missing samples with a present one on either side; what is missing at the start
//! or the end of a take stays so, for filling it would be extrapolating. With the samples `a` before
//! and `b` after the gap, the cubic goes through `a - 1`, `a`, `b`, `b + 1`. Where one of the outer
//! two is missing itself (another gap, the end of the take), the polynomial goes through the ones
//! there are: a parabola through three, a line through two. Filled samples never support a later
//! fill, so the result does not depend on the order of filling.
//!
//! Orientations are interpolated as rotation vectors relative to the sample before the gap (the
//! tangent space there), by the same polynomial; the line is then slerp. A body turns far less than
//! half a turn in a gap short enough to fill, so the shorter way round is taken, whatever the signs
//! of the quaternions.

use inhand_model::{Frame, PointTrack, Pose, PoseTrack, Position, Sample, Status, Track};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use crate::settings::GapFill;

/// Fills gaps of at most `max_samples` in positions: by the polynomial through the samples beside a
/// gap, two on each side for [`GapFill::Cubic`], one for [`GapFill::Linear`].
pub fn fill_points<F: Frame>(track: &mut PointTrack<F>, max_samples: usize, fill: GapFill) {
    fill_track(track, max_samples, fill, |track, polynomial, k| {
        let terms = polynomial.weights(k);
        Position::from_coords(
            terms
                .map(|(at, weight)| track.value(at).coords_m() * weight)
                .sum(),
        )
    });
}

/// Fills gaps of at most `max_samples` in poses, as [`fill_points`] does; orientations as rotation
/// vectors from the sample before the gap, so that the line is slerp.
pub fn fill_poses<To: Frame, From: Frame>(
    track: &mut PoseTrack<To, From>,
    max_samples: usize,
    fill: GapFill,
) {
    fill_track(track, max_samples, fill, |track, polynomial, k| {
        let reference = track.value(polynomial.last_before).isometry().rotation;
        let (mut position, mut turn) = (Vector3::zeros(), Vector3::zeros());
        for (at, weight) in polynomial.weights(k) {
            let support = track.value(at).isometry();
            position += support.translation.vector * weight;
            turn += (reference.inverse() * support.rotation).scaled_axis() * weight;
        }
        Pose::new(Isometry3::from_parts(
            Translation3::from(position),
            reference * UnitQuaternion::from_scaled_axis(turn),
        ))
    });
}

/// Fills gaps; `value` evaluates the polynomial through values of the track at a sample.
fn fill_track<T: Sample>(
    track: &mut Track<T>,
    max_samples: usize,
    fill: GapFill,
    value: impl Fn(&Track<T>, &Polynomial, usize) -> T,
) {
    let reach = match fill {
        GapFill::Cubic => 2,
        GapFill::Linear => 1,
        GapFill::None => return,
    };
    let gaps = track.gaps();
    for (i, gap) in gaps.iter().enumerate() {
        let inside = gap.start > 0 && gap.end < track.len();
        if !inside || gap.len() > max_samples {
            continue;
        }
        // The neighbouring gaps bound what was there before anything was filled.
        let from = if i == 0 { 0 } else { gaps[i - 1].end };
        let to = gaps.get(i + 1).map_or(track.len(), |next| next.start);
        let polynomial = Polynomial {
            last_before: gap.start - 1,
            supports: (from.max(gap.start.saturating_sub(reach))..gap.start)
                .chain(gap.end..to.min(gap.end + reach))
                .collect(),
        };
        for k in gap.clone() {
            let filled = value(track, &polynomial, k);
            track.set(k, Some(filled), Status::Filled);
        }
    }
}

/// The weight of sample `own` in the value at instant `at` (in samples) of the polynomial through the
/// samples `supports` (Lagrange's form).
pub fn lagrange_weight(supports: impl IntoIterator<Item = usize>, own: usize, at: f64) -> f64 {
    let others = supports.into_iter().filter(|&other| other != own);
    let factors = others.map(|other| (at - other as f64) / (own as f64 - other as f64));
    factors.product()
}

/// The polynomial through the samples on both sides of a gap.
struct Polynomial {
    /// The last sample before the gap.
    last_before: usize,
    /// All samples that it goes through, ascending.
    supports: Vec<usize>,
}

impl Polynomial {
    /// Each support with its weight in the value at sample `k`.
    fn weights(&self, k: usize) -> impl Iterator<Item = (usize, f64)> {
        let supports = self.supports.iter().copied();
        supports
            .clone()
            .map(move |own| (own, lagrange_weight(supports.clone(), own, k as f64)))
    }
}
