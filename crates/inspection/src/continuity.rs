//! Continuity of marker intervals, relative to what is usual in a take.

use inhand_model::{Frame, PointTrack, Position};
use nalgebra::{Matrix3, Vector3};

use crate::statistics::median;

/// Samples beside a boundary from which the velocity there is taken, and how far they may lie apart.
const VELOCITY_SAMPLES: usize = 4;
/// Longest time over which that velocity is trusted, seconds: a fingertip turns round in less than
/// three tenths of a second.
const VELOCITY_LASTS_S: f64 = 0.1;
/// Lengths of boundaries at which the usual distance is measured, samples.
const MEASURED_STEPS: [usize; 7] = [1, 2, 4, 8, 16, 32, 64];
/// Boundaries of each length that are looked at, at most.
const MAX_MEASURED: usize = 4000;
/// Distances below this say nothing, metres: jitter of markers and of the hand's pose.
const LEAST_SCALE_M: f64 = 3e-4;

/// Position and velocity of a marker beside a boundary.
#[derive(Clone, Copy, Debug)]
pub(crate) struct End {
    /// The sample.
    pub(crate) at: usize,
    pub(crate) position_m: Vector3<f64>,
    /// Metres a sample; `None` where too few neighbours are there.
    pub(crate) velocity: Option<Vector3<f64>>,
    /// How far the samples that the velocity is from are off their line at most, metres.
    pub(crate) misfit_m: f64,
}

/// The end of an interval at sample `k`, looking back at what was before.
pub(crate) fn end_before<F: Frame>(track: &PointTrack<F>, k: usize) -> Option<End> {
    let run = (0..VELOCITY_SAMPLES)
        .map_while(|back| Some((-(back as f64), at(track, k.checked_sub(back)?)?)));
    end(k, run)
}

/// The start of an interval at sample `k`, looking at what comes after.
pub(crate) fn end_after<F: Frame>(track: &PointTrack<F>, k: usize) -> Option<End> {
    let run = (0..VELOCITY_SAMPLES).map_while(|ahead| Some((ahead as f64, at(track, k + ahead)?)));
    end(k, run)
}

fn at<F: Frame>(track: &PointTrack<F>, k: usize) -> Option<Vector3<f64>> {
    track.get(k).map(Position::coords_m)
}

fn end(k: usize, samples: impl Iterator<Item = (f64, Vector3<f64>)>) -> Option<End> {
    let (mut run, mut len) = ([(0.0, Vector3::zeros()); VELOCITY_SAMPLES], 0);
    for (place, sample) in run.iter_mut().zip(samples) {
        *place = sample;
        len += 1;
    }
    let run = &run[..len];
    let &(_, position_m) = run.first()?;
    // The line of least squares needs three samples, lest noise pass for motion.
    let line = (run.len() >= 3).then(|| {
        let n = run.len() as f64;
        let time = run.iter().map(|(t, _)| t).sum::<f64>() / n;
        let mean = run.iter().map(|(_, p)| p).sum::<Vector3<f64>>() / n;
        let spread: f64 = run.iter().map(|(t, _)| (t - time).powi(2)).sum();
        let moved: Vector3<f64> = run.iter().map(|(t, p)| (p - mean) * (t - time)).sum();
        let velocity = moved / spread;
        let misfits = (run.iter()).map(|(t, p)| (p - mean - velocity * (t - time)).norm());
        (velocity, misfits.fold(0.0, f64::max))
    });
    Some(End {
        at: k,
        position_m,
        velocity: line.map(|(velocity, _)| velocity),
        misfit_m: line.map_or(0.0, |(_, misfit_m)| misfit_m),
    })
}

/// How far two ends are from being one motion, metres: the least of the distance between them, and
/// of where either end's velocity leads to from the other. Zero velocity and both velocities are all
/// usual, so each gets the benefit of the doubt.
pub(crate) fn jump_m(before: &End, after: &End, rate_hz: f64) -> f64 {
    let steps = after.at.saturating_sub(before.at) as f64;
    let lasts = steps.min(VELOCITY_LASTS_S * rate_hz);
    let gap = after.position_m - before.position_m;
    let led = |velocity: Option<Vector3<f64>>| {
        velocity.map_or(f64::INFINITY, |v| (gap - v * lasts).norm())
    };
    let both = (before.velocity.zip(after.velocity)).map_or(f64::INFINITY, |(a, b)| {
        (gap - (a + b) * (0.5 * lasts)).norm()
    });
    gap.norm()
        .min(led(before.velocity))
        .min(led(after.velocity))
        .min(both)
}

/// What jumps are usual over boundaries of each length, from the take itself.
#[derive(Clone, Debug)]
pub(crate) struct UsualJumps {
    rate_hz: f64,
    /// Median jump over each of [`MEASURED_STEPS`], metres, never falling.
    median_m: [f64; MEASURED_STEPS.len()],
}

impl UsualJumps {
    /// Measures jumps over boundaries of known length at places spread over the tracks. Medians: a few
    /// wrong labels among them do not matter.
    pub(crate) fn measured<F: Frame>(tracks: &[&PointTrack<F>], rate_hz: f64) -> Self {
        let total: usize = tracks.iter().map(|track| track.len()).sum();
        let stride = total.div_ceil(MAX_MEASURED).max(1);
        let mut floor_m = LEAST_SCALE_M;
        let mut jumps_m = MEASURED_STEPS.map(|_| Vec::with_capacity(MAX_MEASURED));
        for track in tracks {
            for k in (0..track.len()).step_by(stride) {
                let Some(before) = end_before(track, k) else {
                    continue;
                };
                for (jumps_m, steps) in jumps_m.iter_mut().zip(MEASURED_STEPS) {
                    let after = end_after(track, k + steps);
                    jumps_m.extend(after.map(|after| jump_m(&before, &after, rate_hz)));
                }
            }
        }
        let median_m = jumps_m.map(|jumps_m| {
            floor_m = median(jumps_m).max(floor_m);
            floor_m
        });
        Self { rate_hz, median_m }
    }

    /// The usual jump over `steps` samples, metres.
    pub(crate) fn usual_m(&self, steps: usize) -> f64 {
        let last = MEASURED_STEPS.len() - 1;
        let upper = MEASURED_STEPS.partition_point(|&s| s < steps).min(last);
        let lower = upper.saturating_sub(1);
        let (from, to) = (MEASURED_STEPS[lower] as f64, MEASURED_STEPS[upper] as f64);
        if upper == lower {
            return self.median_m[upper];
        }
        let part = ((steps as f64 - from) / (to - from)).clamp(0.0, 1.0);
        self.median_m[lower] + part * (self.median_m[upper] - self.median_m[lower])
    }

    /// How many times the usual the jump between two ends is.
    pub(crate) fn ratio(&self, before: &End, after: &End) -> f64 {
        jump_m(before, after, self.rate_hz) / self.usual_m(after.at.saturating_sub(before.at))
    }

    /// What a jump costs, in nats: minus the logarithm of the density of a t distribution of three
    /// dimensions with three degrees of freedom, without its constant. Its tails are heavy, as those of real motion
    /// are: a jump of ten times the usual costs 11 nats, of a hundred 25.
    pub(crate) fn cost(&self, before: &End, after: &End) -> f64 {
        /// The median radius of that distribution is near 1.8 of its scale.
        const MEDIAN_RADIUS: f64 = 1.8;
        const FREEDOM: f64 = 3.0;
        let radius = MEDIAN_RADIUS * self.ratio(before, after);
        let scale = self.usual_m(after.at.saturating_sub(before.at));
        0.5 * (FREEDOM + 3.0) * (radius * radius / FREEDOM).ln_1p() + 3.0 * scale.ln()
    }
}

/// Coefficients of the curve of least squares, rising with the power of time: a parabola if it bends, else
/// a line. `None` for fewer different times than that needs.
pub(crate) fn parabola(points: &[(f64, Vector3<f64>)], bends: bool) -> Option<[Vector3<f64>; 3]> {
    let (mut normal, mut right) = (Matrix3::zeros(), Matrix3::zeros());
    for (t, p) in points {
        let powers = Vector3::new(1.0, *t, if bends { t * t } else { 0.0 });
        normal += powers * powers.transpose();
        right += powers * p.transpose();
    }
    if !bends {
        normal[(2, 2)] = 1.0;
    }
    let solved = normal.try_inverse()? * right;
    Some([0, 1, 2].map(|row| solved.row(row).transpose()))
}
