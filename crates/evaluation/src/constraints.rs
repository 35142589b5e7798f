//! Reachability, finger collisions and velocities of planned motion.

use inhand_curves::velocity;
use inhand_model::{
    Collision, Finger, MethodRows, PerFinger, Reachability, SEGMENT_COORDINATES, Trajectory,
    VelocityBounds, VelocityCheck,
};
use rayon::prelude::*;

use crate::instants::NearestPair;
use crate::known::{Counts, finger_statistics};
use crate::recorded::Recorded;

/// How far a velocity may pass its bound, relative to the bound: solvers keep bounds to their
/// tolerance, not to the last digit.
const VELOCITY_TOLERANCE: f64 = 1e-6;

/// The same for bounds of zero, m/s: a difference of two positions in a hand's reach, rounded, times
/// a rate of at most some kHz.
const VELOCITY_ROUNDING_M_S: f64 = 1e-12;

/// Whether each fingertip stays where training has been (P1, reachability).
pub(crate) fn reachability(
    rows: &MethodRows,
    recorded: &Recorded,
    tolerance_m: f64,
    counts: Counts,
) -> Reachability {
    let judged = || {
        (rows.hull_distance_m.iter())
            .zip(&recorded.rows.recorded_hull_distance_m)
            .filter(|(planned, _)| is_known(planned))
    };
    let n = judged().count();
    let share = |inside: &dyn Fn(Finger) -> usize| {
        PerFinger::from_fn(|finger| inside(finger) as f64 / n as f64)
    };
    let distance = finger_statistics(&rows.hull_distance_m, &recorded.rows.filled, counts);
    Reachability {
        n,
        inside: share(&|finger| judged().filter(|(d, _)| d[finger] <= tolerance_m).count()),
        worst_outside_m: PerFinger::from_fn(|finger| match n {
            0 => f64::NAN,
            _ => distance[finger].max.max(0.0),
        }),
        recorded_inside: share(&|finger| {
            judged().filter(|(_, d)| d[finger] <= tolerance_m).count()
        }),
        distance,
    }
}

/// Whether every finger's value is known.
pub(crate) fn is_known(values: &PerFinger<f64>) -> bool {
    values.as_array().iter().all(|value| value.is_finite())
}

/// Whether fingertips come nearer than `limit_m` (P1, finger collision).
pub(crate) fn collision(
    pairs: &[NearestPair],
    recorded: &Recorded,
    limit_m: f64,
    samples: usize,
) -> Collision {
    let judged: Vec<(&NearestPair, f64)> = (pairs.iter())
        .zip(recorded.rows.recorded_nearest_pair_m.iter().copied())
        .filter(|(planned, _)| planned.0.is_finite())
        .collect();
    let nearest = (judged.iter().map(|judged| judged.0)).min_by(|a, b| a.0.total_cmp(&b.0));
    let recorded_nearest_m = (judged.iter().map(|judged| judged.1)).min_by(f64::total_cmp);
    let is_collision = |pair: &NearestPair| pair.0 < limit_m;
    Collision {
        n: judged.len(),
        limit_m,
        instants: judged.iter().filter(|(pair, _)| is_collision(pair)).count(),
        trajectories: (pairs.chunks(samples.max(1)))
            .filter(|trajectory| trajectory.iter().any(is_collision))
            .count(),
        nearest_m: nearest.map_or(f64::NAN, |pair| pair.0),
        nearest_pair: nearest.map(|pair| (pair.1, pair.2)),
        recorded_instants: judged.iter().filter(|judged| judged.1 < limit_m).count(),
        recorded_nearest_m: recorded_nearest_m.unwrap_or(f64::NAN),
    }
}

/// Whether every step of every trajectory keeps to the bounds.
///
/// The ratio of a velocity is to the bound on its side of zero, infinite where that bound is zero or
/// on the other side.
pub(crate) fn check_velocity(
    trajectories: &[Option<&Trajectory>],
    bounds: &VelocityBounds,
) -> VelocityCheck {
    let beyond = |bound: f64| VELOCITY_TOLERANCE * bound.abs() + VELOCITY_ROUNDING_M_S;
    let lowest = bounds.min_m_s.map(|min| min - beyond(min));
    let highest = bounds.max_m_s.map(|max| max + beyond(max));
    let checks: Vec<(usize, usize, f64)> = trajectories
        .par_iter()
        .flatten()
        .map(|trajectory| {
            let (mut n, mut outside) = (0, 0);
            let mut least = [0.0_f64; SEGMENT_COORDINATES];
            let mut greatest = least;
            for step in velocity::steps(trajectory) {
                n += SEGMENT_COORDINATES;
                for (c, v) in step.into_iter().enumerate() {
                    outside += usize::from(v > highest[c] || v < lowest[c]);
                    least[c] = least[c].min(v);
                    greatest[c] = greatest[c].max(v);
                }
            }
            let worst = (0..SEGMENT_COORDINATES)
                .map(|c| {
                    ratio(greatest[c], bounds.max_m_s[c]).max(ratio(-least[c], -bounds.min_m_s[c]))
                })
                .fold(0.0, f64::max);
            (n, outside, worst)
        })
        .collect();
    let n = checks.iter().map(|check| check.0).sum();
    let worst_ratio = checks.iter().map(|check| check.2).fold(0.0, f64::max);
    VelocityCheck {
        n,
        outside: checks.iter().map(|check| check.1).sum(),
        trajectories_outside: checks.iter().filter(|check| check.1 > 0).count(),
        worst_ratio: if n > 0 { worst_ratio } else { f64::NAN },
    }
}

/// Ratio of a speed to its bound, both towards the same side.
fn ratio(speed: f64, bound: f64) -> f64 {
    if speed <= VELOCITY_ROUNDING_M_S {
        0.0
    } else if bound > 0.0 {
        speed / bound
    } else {
        f64::INFINITY
    }
}
