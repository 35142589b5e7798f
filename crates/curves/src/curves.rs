//! Motion between given ends with nothing learned: the baselines of every comparison.
//!
//! With N samples at `rate`, sample `t` is at `s = t / (N - 1)` of the way and a segment lasts
//! `T = (N - 1) / rate`. Each of the 15 coordinates is a function of its own end conditions alone:
//!
//! | curve | knows | value at `s` |
//! | --- | --- | --- |
//! | [`hold`] | last | `last` |
//! | [`line()`] | first, last | `first + s (last - first)` |
//! | [`minimum_jerk`] | first, last | `first + (10 s³ - 15 s⁴ + 6 s⁵) (last - first)` |
//! | [`hermite`] | first, last, velocities | `h00 first + h10 T v_first + h01 last + h11 T v_last` |
//!
//! A layout of one sample gives the first configuration ([`hold`]: the last), one of no sample an
//! empty trajectory.
//!
//! # Panics
//!
//! Each curve panics if an end condition is NaN, infinite, or so large that the curve leaves the
//! range of `f64`. Segments are cut from present samples alone, so theirs are always finite.

use inhand_model::{Configuration, EndConditions, SEGMENT_COORDINATES, SegmentLayout, Trajectory};

/// The last configuration throughout: what doing nothing at all scores.
pub fn hold(ends: &EndConditions, layout: SegmentLayout) -> Trajectory {
    curve(layout, |_| ends.last_m)
}

/// The straight line from the first to the last configuration at constant speed.
pub fn line(ends: &EndConditions, layout: SegmentLayout) -> Trajectory {
    curve(layout, |s| between(ends, s))
}

/// The curve of least squared jerk from rest to rest: Flash and Hogan, *The coordination of arm
/// movements*, J. Neurosci. 5(7), 1985.
pub fn minimum_jerk(ends: &EndConditions, layout: SegmentLayout) -> Trajectory {
    curve(layout, |s| {
        between(ends, s * s * s * (10.0 + s * (6.0 * s - 15.0)))
    })
}

/// The cubic (Hermite) through both configurations with the given end velocities.
pub fn hermite(ends: &EndConditions, layout: SegmentLayout) -> Trajectory {
    let duration_s = layout.duration_s();
    curve(layout, |s| {
        let h00 = (2.0 * s - 3.0) * s * s + 1.0;
        let h10 = ((s - 2.0) * s + 1.0) * s * duration_s;
        let h01 = (3.0 - 2.0 * s) * s * s;
        let h11 = (s - 1.0) * s * s * duration_s;
        std::array::from_fn(|i| {
            h00 * ends.first_m[i]
                + h10 * ends.first_velocity_m_s[i]
                + h01 * ends.last_m[i]
                + h11 * ends.last_velocity_m_s[i]
        })
    })
}

/// The configuration a share of the way; exactly the last one at `share` 1, which
/// `first + (last - first)` would miss by rounding.
fn between(ends: &EndConditions, share: f64) -> Configuration {
    std::array::from_fn(|i| (1.0 - share) * ends.first_m[i] + share * ends.last_m[i])
}

fn curve(layout: SegmentLayout, at: impl Fn(f64) -> Configuration) -> Trajectory {
    // The divisor of a single sample is of no consequence: it is at s = 0.
    let intervals = layout.samples.saturating_sub(1).max(1) as f64;
    let mut values_m = Vec::with_capacity(SEGMENT_COORDINATES * layout.samples);
    for t in 0..layout.samples {
        values_m.extend_from_slice(&at(t as f64 / intervals));
    }
    Trajectory::new(layout, values_m)
        .expect("15 numbers a sample by construction, finite because the end conditions are")
}
