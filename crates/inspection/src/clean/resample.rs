//! A recording at another rate.
//!
//! Between two samples there is a value only if both are there: nothing is made up in gaps, and what is
//! beside a gap is computed from its own side alone.
//!
//! * **Up** (or at the same rate): positions by the cubic through the four samples about the instant,
//!   rotations by slerp between the two.
//! * **Down**: motion faster than the new rate can show would come back as slower motion that never was.
//!   So each new sample is the mean of the samples about it, weighted by a low-pass filter: a sinc
//!   under a Hann window that reaches over eight new samples, with its 6 dB point at 0.8 of the highest
//!   frequency that the new rate can show. At the ends of an interval the samples are mirrored through its last one, so that a
//!   steady motion goes on steadily. Rotations take the same mean of their rotation vectors about the
//!   nearest sample.
//!
//! A new sample is [`Status::Filled`] if one of the two samples about it is. Qualities and marker
//! errors are interpolated by a line.

use inhand_model::{
    Change, ChangeKind, Clock, Frame, PointTrack, Pose, PoseTrack, Position, Recording, Sample,
    Status, Track,
};
use inhand_motion::{MotionError, lagrange_weight};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

/// Rates that a recording can be brought to, Hz.
const RATES_HZ: std::ops::RangeInclusive<f64> = 1.0..=10_000.0;
/// Most samples of the result, for memory.
const MAX_SAMPLES: f64 = 2e7;
/// The 6 dB point of the filter, as a share of half the new rate.
const CUT_OFF: f64 = 0.8;
/// How far the filter reaches on each side, in new samples.
const REACH: f64 = 4.0;
/// Instants nearer to a sample than this, in samples, are that sample.
const AT_SAMPLE: f64 = 1e-9;

/// The recording at another rate, over the same time.
///
/// # Errors
///
/// [`MotionError`] for a rate out of 1 to 10000 Hz or too many samples.
pub fn resample(recording: &Recording, rate_hz: f64) -> Result<(Recording, Change), MotionError> {
    let from_hz = recording.clock.rate_hz();
    let wrong = |found: String| {
        let expected = "1 to 10000 Hz, for 20 million samples at most";
        Err(MotionError::setting("resample rate", found, expected))
    };
    if !RATES_HZ.contains(&rate_hz) {
        return wrong(format!("{rate_hz} Hz"));
    }
    let last = recording.len().saturating_sub(1) as f64;
    let count = (last * rate_hz / from_hz + AT_SAMPLE).floor() + 1.0;
    if count > MAX_SAMPLES {
        return wrong(format!("{rate_hz} Hz, which makes {count} samples"));
    }
    let samples = if recording.is_empty() {
        0
    } else {
        count as usize
    };
    let step = from_hz / rate_hz;
    let grid = Grid { samples, step };
    let (start, kind) = (
        recording.clock.start_unix_nanos(),
        recording.clock.start_time(),
    );
    let resampled = recording.with_samples(
        Clock::new(start, kind, rate_hz).expect("a rate of 1 Hz or more is positive"),
        samples,
        |points| grid.points(points),
        |poses| grid.poses(poses),
        |numbers| grid.numbers(numbers),
    );
    let change = Change {
        kind: ChangeKind::Resampled,
        entity: "all markers and bodies".to_owned(),
        samples: 0..recording.len(),
        message: format!("from {from_hz} Hz to {rate_hz} Hz"),
    };
    Ok((resampled, change))
}

/// Instants of the new samples.
struct Grid {
    samples: usize,
    /// Old samples from one new sample to the next.
    step: f64,
}

/// An instant between samples of an interval without gap.
struct Instant {
    /// The interval.
    first: usize,
    last: usize,
    /// The sample at the instant or before it, and the part of the way to the next.
    before: usize,
    part: f64,
    status: Status,
}

impl Grid {
    /// Calls `value` at every instant that lies in an interval.
    fn track<T: Sample>(&self, track: &Track<T>, value: impl Fn(&Instant) -> T) -> Track<T> {
        let mut gaps = track.gaps().into_iter().peekable();
        let mut first = 0;
        let mut result = Track::with_capacity(self.samples);
        for j in 0..self.samples {
            let time = j as f64 * self.step;
            let mut before = time.floor() as usize;
            let mut part = time - before as f64;
            if part > 1.0 - AT_SAMPLE {
                (before, part) = (before + 1, 0.0);
            } else if part < AT_SAMPLE {
                part = 0.0;
            }
            while let Some(gap) = gaps.next_if(|gap| gap.end <= before) {
                first = gap.end;
            }
            let end = gaps.peek().map_or(track.len(), |gap| gap.start);
            let after = if part > 0.0 { before + 1 } else { before };
            if before < first || after >= end {
                result.push(None, Status::Missing);
                continue;
            }
            let instant = Instant {
                first,
                last: end - 1,
                before,
                part,
                status: track.status(before).and(track.status(after)),
            };
            result.push(Some(value(&instant)), instant.status);
        }
        result
    }

    fn points<F: Frame>(&self, track: &PointTrack<F>) -> PointTrack<F> {
        self.track(track, |instant| {
            let at = |k: usize| track.value(k).coords_m();
            Position::from_coords(self.value(instant, at))
        })
    }

    fn poses<To: Frame, From: Frame>(&self, track: &PoseTrack<To, From>) -> PoseTrack<To, From> {
        self.track(track, |instant| {
            let pose = |k: usize| track.value(k).isometry();
            let place = self.value(instant, |k| pose(k).translation.vector);
            let near = pose(instant.before).rotation;
            let rotation = if self.step > 1.0 {
                let turn = |k: usize| (near.inverse() * pose(k).rotation).scaled_axis();
                near * UnitQuaternion::from_scaled_axis(self.value(instant, turn))
            } else {
                let next = pose((instant.before + 1).min(instant.last)).rotation;
                // The shorter way, whatever the signs of the quaternions.
                near * (near.inverse() * next).powf(instant.part)
            };
            Pose::new(Isometry3::from_parts(Translation3::from(place), rotation))
        })
    }

    fn value(&self, instant: &Instant, at: impl Fn(usize) -> Vector3<f64>) -> Vector3<f64> {
        if self.step > 1.0 {
            self.filtered(instant, at)
        } else {
            cubic(instant, at)
        }
    }

    /// The mean about the instant, weighted by the low-pass filter.
    fn filtered(&self, instant: &Instant, at: impl Fn(usize) -> Vector3<f64>) -> Vector3<f64> {
        let reach = REACH * self.step;
        let time = instant.before as f64 + instant.part;
        let (from, to) = ((time - reach).ceil() as i64, (time + reach).floor() as i64);
        let (first, last) = (instant.first as i64, instant.last as i64);
        // The samples do not lie evenly about the instant. What the weights would shift a steady motion
        // by is taken out with the window's own first moment, which leaves the filter as it is otherwise.
        let (mut moment, mut spread) = (0.0, 0.0);
        for off in (from..=to).map(|k| k as f64 - time) {
            let (window, sinc) = self.weight(off);
            moment += window * sinc * off;
            spread += window * off * off;
        }
        let tilt = if spread > 0.0 { moment / spread } else { 0.0 };
        let (mut sum, mut weights) = (Vector3::zeros(), 0.0);
        for k in from..=to {
            let off = k as f64 - time;
            let (window, sinc) = self.weight(off);
            let weight = window * (sinc - tilt * off);
            // Through the end: as far on the other side of it in value as in time.
            let value = if k < first {
                at(first as usize) * 2.0 - at((2 * first - k).min(last) as usize)
            } else if k > last {
                at(last as usize) * 2.0 - at((2 * last - k).max(first) as usize)
            } else {
                at(k as usize)
            };
            sum += value * weight;
            weights += weight;
        }
        sum / weights
    }

    /// Window and sinc at a sample `off` old samples from the instant; their product is its weight.
    fn weight(&self, off: f64) -> (f64, f64) {
        use std::f64::consts::PI;
        let window = 0.5 * (1.0 + (PI * off / (REACH * self.step)).cos());
        let x = PI * CUT_OFF * off / self.step;
        (window, if x.abs() < 1e-12 { 1.0 } else { x.sin() / x })
    }

    fn numbers(&self, values: &[f64]) -> Vec<f64> {
        (0..self.samples)
            .map(|j| {
                let time = j as f64 * self.step;
                let before = (time.floor() as usize).min(values.len() - 1);
                let part = time - before as f64;
                let after = (before + 1).min(values.len() - 1);
                if part < AT_SAMPLE {
                    values[before]
                } else if part > 1.0 - AT_SAMPLE {
                    values[after]
                } else {
                    values[before] + part * (values[after] - values[before])
                }
            })
            .collect()
    }
}

/// The cubic through the four samples about the instant; the parabola or line where the interval ends.
fn cubic(instant: &Instant, at: impl Fn(usize) -> Vector3<f64>) -> Vector3<f64> {
    if instant.part == 0.0 {
        return at(instant.before);
    }
    let from = instant.before.saturating_sub(1).max(instant.first);
    let to = (instant.before + 2).min(instant.last);
    let time = instant.before as f64 + instant.part;
    (from..=to)
        .map(|own| at(own) * lagrange_weight(from..=to, own, time))
        .sum()
}
