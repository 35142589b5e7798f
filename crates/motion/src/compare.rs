//! Two motions of one take, sample by sample.

use std::ops::Range;

use inhand_model::{Frame, Motion, Pose, Position, Sample, Track};

/// A sample at which two motions are apart.
#[derive(Clone, Debug, PartialEq)]
pub struct Deviation {
    /// Name of the finger, `object` or `hand`.
    pub part: &'static str,
    /// The sample.
    pub sample: usize,
    /// Distance of the positions, metres, or difference of a component of unit quaternions where that is larger;
    /// infinite where only one of both has a value.
    pub by: f64,
}

/// Samples in `within` at which two motions are farther apart than `tolerance`: fingertips, and with `bodies` object and
/// hand as well.
pub fn deviations(
    a: &Motion,
    b: &Motion,
    within: &Range<usize>,
    bodies: bool,
    tolerance: f64,
) -> Vec<Deviation> {
    let mut found = Vec::new();
    for (finger, track) in a.fingertips.iter() {
        let other = &b.fingertips[finger];
        let apart = far(track, other, within, tolerance, Position::distance_m);
        found.extend(apart.map(|(sample, by)| (finger.name(), sample, by)));
    }
    if bodies {
        let apart = far(&a.hand, &b.hand, within, tolerance, poses_apart);
        found.extend(apart.map(|(sample, by)| ("hand", sample, by)));
        if let (Some(a), Some(b)) = (&a.object, &b.object) {
            let apart = far(a, b, within, tolerance, poses_apart);
            found.extend(apart.map(|(sample, by)| ("object", sample, by)));
        }
    }
    (found.into_iter())
        .map(|(part, sample, by)| Deviation { part, sample, by })
        .collect()
}

fn far<T: Sample>(
    a: &Track<T>,
    b: &Track<T>,
    within: &Range<usize>,
    tolerance: f64,
    apart: impl Fn(T, T) -> f64,
) -> impl Iterator<Item = (usize, f64)> {
    let by = move |k| match (a.get(k), b.get(k)) {
        (Some(a), Some(b)) => apart(a, b),
        (None, None) => 0.0,
        _ => f64::INFINITY,
    };
    let samples = within.clone().map(move |k| (k, by(k)));
    samples.filter(move |(_, by)| *by > tolerance)
}

fn poses_apart<To: Frame, From: Frame>(a: Pose<To, From>, b: Pose<To, From>) -> f64 {
    let parts = a.quaternion_xyzw().into_iter().zip(b.quaternion_xyzw());
    // A quaternion and its negative are the same rotation.
    let sign = parts.clone().map(|(a, b)| a * b).sum::<f64>().signum();
    let turned = parts.map(|(a, b)| (a - sign * b).abs()).fold(0.0, f64::max);
    a.origin().distance_m(b.origin()).max(turned)
}
