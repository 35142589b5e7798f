//! Velocities between neighbouring samples, m/s, hand frame.

use inhand_model::{
    Configuration, Finger, Motion, SEGMENT_COORDINATES, Trajectory, VelocityBounds,
};

/// The least and the greatest velocity of each coordinate over all motions, between neighbouring
/// samples that are both present (measured or filled): `(x(k + 1) - x(k)) * rate`.
///
/// `None` unless every finger has at least one such pair: a coordinate never seen moving has no
/// bounds. The motions may have different rates.
pub fn extremes<'a>(motions: impl IntoIterator<Item = &'a Motion>) -> Option<VelocityBounds> {
    let mut min_m_s = [f64::INFINITY; SEGMENT_COORDINATES];
    let mut max_m_s = [f64::NEG_INFINITY; SEGMENT_COORDINATES];
    for motion in motions {
        let rate_hz = motion.clock.rate_hz();
        for finger in Finger::ALL {
            let base = finger.index() * 3;
            let values = motion.fingertips[finger].values();
            for (earlier, later) in values.clone().zip(values.skip(1)) {
                let step_m = later.coords_m() - earlier.coords_m();
                for (axis, &step_m) in step_m.iter().enumerate() {
                    // A step to or from a missing sample is NaN and changes neither.
                    min_m_s[base + axis] = min_m_s[base + axis].min(step_m * rate_hz);
                    max_m_s[base + axis] = max_m_s[base + axis].max(step_m * rate_hz);
                }
            }
        }
    }
    (min_m_s.iter().chain(&max_m_s))
        .all(|v| v.is_finite())
        .then_some(VelocityBounds { min_m_s, max_m_s })
}

/// The velocity of each step of a trajectory, N - 1 of them: `(x(t + 1) - x(t)) * rate`, m/s, in the
/// order of a configuration (finger, then axis).
pub fn steps(trajectory: &Trajectory) -> Vec<Configuration> {
    let rate_hz = trajectory.layout().rate_hz;
    let values_m = trajectory.values_m();
    let next_m = values_m.get(SEGMENT_COORDINATES..).unwrap_or(&[]);
    next_m
        .chunks_exact(SEGMENT_COORDINATES)
        .zip(values_m.chunks_exact(SEGMENT_COORDINATES))
        .map(|(next_m, now_m)| std::array::from_fn(|i| (next_m[i] - now_m[i]) * rate_hz))
        .collect()
}
