//! The filter at work: a few seconds before and after it, how far it moves positions, and spectra.

use std::ops::Range;

use inhand_model::{Filtering, Finger, Hand, Motion, PerFinger, PointTrack, Spectrum, Status};
use inhand_motion::{MotionError, Welch};
use inhand_statistics::quantiles::statistics;

/// Length of the interval that is shown, seconds.
const SHOWN_S: f64 = 4.0;

/// Places a second at which an interval may begin.
const PLACES_A_SECOND: f64 = 2.0;

/// Samples of a window of the spectra: at 100 Hz frequencies 0.4 Hz apart.
const WINDOW: usize = 256;

const AXES: [&str; 3] = ["x", "y", "z"];

/// What the filter does to test takes.
#[derive(Clone, Debug, Default)]
pub struct Smoothing {
    /// An interval before and after it.
    pub filtering: Option<Filtering>,
    /// How motion and noise spread over frequencies.
    pub spectrum: Option<Spectrum>,
}

/// Looks at takes before and after the filter, both in the same order.
///
/// # Errors
///
/// [`MotionError`] for takes without a rate.
pub fn smoothing(before: &[&Motion], after: &[&Motion]) -> Result<Smoothing, MotionError> {
    let (filtering, spectrum) =
        rayon::join(|| filtering(before, after), || spectrum(before, after));
    Ok(Smoothing {
        filtering,
        spectrum: spectrum?,
    })
}

/// A coordinate of a fingertip over an interval of a take.
#[derive(Clone, Debug)]
struct Place {
    take: usize,
    finger: Finger,
    axis: usize,
    samples: Range<usize>,
}

/// The interval without gaps in which a filtered coordinate covers the longest way from its least to its
/// largest value; of equal ones the first.
fn most_moved(motions: &[&Motion]) -> Option<Place> {
    let mut most: Option<(f64, Place)> = None;
    for (take, motion) in motions.iter().enumerate() {
        let rate_hz = motion.clock.rate_hz();
        let samples = (SHOWN_S * rate_hz).round() as usize;
        let step = (rate_hz / PLACES_A_SECOND).round().max(1.0) as usize;
        for finger in Finger::ALL {
            let track = &motion.fingertips[finger];
            for start in (0..(track.len() + 1).saturating_sub(samples)).step_by(step) {
                let interval = start..start + samples;
                let present = |k| track.status(k).is_present();
                if samples == 0 || !interval.clone().all(present) {
                    continue;
                }
                for axis in 0..3 {
                    let reach = reach(&coordinate(track, axis, interval.clone()));
                    if most.as_ref().is_none_or(|(best, _)| reach > *best) {
                        let samples = interval.clone();
                        most = Some((
                            reach,
                            Place {
                                take,
                                finger,
                                axis,
                                samples,
                            },
                        ));
                    }
                }
            }
        }
    }
    most.map(|(_, place)| place)
}

fn reach(values: &[f64]) -> f64 {
    let (low, high) = (values.iter()).fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
        (low.min(*v), high.max(*v))
    });
    high - low
}

/// A coordinate over an interval, metres; NaN where it is missing.
fn coordinate(track: &PointTrack<Hand>, axis: usize, samples: Range<usize>) -> Vec<f64> {
    samples.map(|k| track.value(k).to_array()[axis]).collect()
}

fn filtering(before: &[&Motion], after: &[&Motion]) -> Option<Filtering> {
    let Place {
        take,
        finger,
        axis,
        samples,
    } = most_moved(after)?;
    let of = |motion: &Motion| coordinate(&motion.fingertips[finger], axis, samples.clone());
    let clock = after[take].clock;
    Some(Filtering {
        take: after[take].name.clone(),
        finger,
        axis: AXES[axis],
        time_s: samples.clone().map(|k| clock.time_s(k)).collect(),
        before_m: of(before.get(take)?),
        after_m: of(after[take]),
        moved: PerFinger::from_fn(|finger| {
            let tracks = before.iter().zip(after);
            let tracks = tracks.map(|(b, a)| (&b.fingertips[finger], &a.fingertips[finger]));
            let (mut moved_m, mut filled, mut left_out) = (Vec::new(), 0, 0);
            for (before, after) in tracks {
                for k in 0..after.len() {
                    match before.get(k).zip(after.get(k)) {
                        Some((before, after)) => moved_m.push(before.distance_m(after)),
                        None => left_out += 1,
                    }
                    filled += usize::from(after.status(k) == Status::Filled);
                }
            }
            statistics(moved_m, filled, left_out)
        }),
    })
}

fn spectrum(before: &[&Motion], after: &[&Motion]) -> Result<Option<Spectrum>, MotionError> {
    let (before, after) = rayon::join(|| welch(before), || welch(after));
    let (Some(before), Some(after)) = (before?, after?) else {
        return Ok(None);
    };
    let Some((before_m2_hz, after_m2_hz)) = before.density().zip(after.density()) else {
        return Ok(None); // No interval is long enough.
    };
    let frequencies = 0..after.frequencies();
    Ok(Some(Spectrum {
        frequency_hz: frequencies.map(|k| after.frequency_hz(k)).collect(),
        before_m2_hz,
        after_m2_hz,
        window: WINDOW,
        windows: after.windows(),
    }))
}

fn welch(motions: &[&Motion]) -> Result<Option<Welch>, MotionError> {
    let Some(first) = motions.first() else {
        return Ok(None);
    };
    let mut welch = Welch::new(WINDOW, first.clock.rate_hz())?;
    for motion in motions {
        for finger in Finger::ALL {
            welch.add_points(&motion.fingertips[finger]);
        }
    }
    Ok(Some(welch))
}

#[cfg(test)]
mod tests {
    use inhand_model::{Clock, Pose, PoseTrack, Position, StartTime};

    use super::*;

    /// A take of ten seconds at 50 Hz whose middle finger swings along y from 5 s on, the more the longer.
    fn take(noise_m: f64) -> Motion {
        let at = |finger: Finger, k: usize| {
            let swing = f64::from(u8::from(finger == Finger::Middle));
            let late_s = (k as f64 / 50.0 - 5.0).max(0.0);
            let sign = if k.is_multiple_of(2) { 1.0 } else { -1.0 };
            let y = 0.001 * swing * late_s * (6.0 * late_s).sin() + sign * noise_m;
            Position::<Hand>::new(0.08, y, 0.02)
        };
        Motion {
            name: "take".into(),
            clock: Clock::new(0, StartTime::Unknown, 50.0).expect("a rate"),
            fingertips: PerFinger::from_fn(|finger| {
                PointTrack::from_measured((0..500).map(|k| Some(at(finger, k))))
            }),
            object: None,
            hand: PoseTrack::from_measured(vec![Some(Pose::identity()); 500]),
            selected: None,
        }
    }

    #[test]
    fn the_coordinate_that_moves_most_is_shown() {
        let (noisy, clean) = (take(1e-4), take(0.0));
        let found = smoothing(&[&noisy], &[&clean]).expect("the takes have a rate");
        let filtering = found.filtering.expect("ten seconds are enough");
        assert_eq!((filtering.finger, filtering.axis), (Finger::Middle, "y"));
        // The last four seconds.
        assert_eq!(filtering.time_s.len(), 200);
        assert!((filtering.time_s[0] - 6.0).abs() < 1e-9);
        let moved = filtering.moved[Finger::Thumb];
        assert_eq!((moved.n, moved.n_filled, moved.n_left_out), (500, 0, 0));
        assert!((moved.p50 - 1e-4).abs() < 1e-12 && (moved.max - 1e-4).abs() < 1e-12);

        // Noise that turns its sign at every sample is at half the rate.
        let spectrum = found.spectrum.expect("there is a window");
        assert_eq!((spectrum.window, spectrum.windows), (256, 2 * 15));
        let last = spectrum.frequency_hz.len() - 1;
        assert!((spectrum.frequency_hz[last] - 25.0).abs() < 1e-9);
        assert!(spectrum.before_m2_hz[last] > 1e6 * spectrum.after_m2_hz[last]);
    }

    #[test]
    fn gaps_and_short_takes_show_nothing() {
        let mut short = take(0.0);
        for finger in Finger::ALL {
            for k in (0..500).step_by(100) {
                short.fingertips[finger].set(k, None, Status::Missing);
            }
        }
        let found = smoothing(&[&short], &[&short]).expect("the takes have a rate");
        assert_eq!(found.filtering, None);
        assert_eq!(found.spectrum, None);
        assert_eq!(smoothing(&[], &[]).expect("nothing").spectrum, None);
    }
}
