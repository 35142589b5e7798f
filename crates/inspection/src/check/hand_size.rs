//! The unit of length, by the size of the hand.

use inhand_model::{Finger, LengthUnit, Motion, Pose, Recording, Setting};
use nalgebra::Vector3;

use super::CheckSettings;
use super::checkup::{CheckResult, Level};
use super::words::{length, names};
use crate::statistics::Finite;

/// Reach of a hand in the middle of what is plausible, metres: what a unit that fits best comes
/// nearest to.
const TYPICAL_REACH_M: f64 = 0.13;

/// Fewest samples that prove anything.
const MIN_SAMPLES: usize = 10;

/// Fingertips that a sample has to show.
const MIN_FINGERS: usize = 3;

/// Farthest that the fingertips of one hand come apart, and nearest that five of them stay, metres.
const SPREAD_M: [f64; 2] = [0.01, 0.28];

/// How many times further than the finger in the middle one has to be to be another marker.
const FAR: f64 = 2.0;

/// Farthest that coordinates lie from the origin of any capture volume, metres.
const VOLUME_M: f64 = 100.0;

/// The hand against the stated unit.
pub(crate) fn hand_size(
    recording: &Recording,
    motion: &Motion,
    settings: &CheckSettings,
) -> Vec<CheckResult> {
    let far = misplaced(motion, settings);
    let (mut reach, mut spread) = (Vec::new(), Vec::new());
    for k in 0..motion.len() {
        let tips: Vec<_> = (motion.fingertips.iter())
            .filter(|(finger, _)| !far.iter().any(|(other, ..)| other == finger))
            .filter_map(|(_, track)| Some(track.get(k)?.coords_m()))
            .collect();
        if tips.len() < MIN_FINGERS {
            continue;
        }
        let pairs = (tips.iter().enumerate())
            .flat_map(|(k, a)| tips[k + 1..].iter().map(move |b| (a - b).norm_squared()));
        reach.push(farthest_m(tips.iter().map(Vector3::norm_squared)));
        spread.push(farthest_m(pairs));
    }
    let n = reach.len();
    if n < MIN_SAMPLES {
        return vec![
            CheckResult::new("units", Level::Info, "")
                .found("no evidence on the unit of length: hand and fingertips are hardly seen together")
                .number("samples", n as f64, motion.len()),
        ];
    }
    let reach_m = Finite::new(reach).median();
    let spread_m = Finite::new(spread).median();
    let stated = recording.source.length_unit;
    let [least, most] = settings.hand_reach_m;
    let base = |level| {
        let (least, most) = (length(least), length(most));
        CheckResult::new("units", level, "")
            .expected(format!(
                "{least} to {most} from the back of the hand to the furthest fingertip"
            ))
            .number("hand_mm", 1e3 * reach_m, n)
            .number("finger_spread_mm", 1e3 * spread_m, n)
    };
    if !(least..=most).contains(&reach_m) {
        return vec![wrong_unit(base(Level::Warn), reach_m, stated, settings)];
    }
    let (unit, reach) = (stated.name(), length(reach_m));
    let mut results = vec![base(Level::Ok).found(format!("{unit} agree with a hand of {reach}"))];
    results.extend(finger_place(&far, settings));
    if !(SPREAD_M[0]..=SPREAD_M[1]).contains(&spread_m) {
        let [nearest, farthest] = SPREAD_M.map(length);
        let apart = length(spread_m);
        results.push(
            CheckResult::new("finger-spread", Level::Warn, "")
                .expected(format!("fingertips {nearest} to {farthest} apart"))
                .found(format!("the fingertips furthest apart are {apart} apart"))
                .advice("see which marker is on which finger")
                .number("finger_spread_mm", 1e3 * spread_m, n),
        );
    }
    results
}

/// The largest of distances, from their squares.
fn farthest_m(squares_m2: impl Iterator<Item = f64>) -> f64 {
    squares_m2.fold(0.0, f64::max).sqrt()
}

fn wrong_unit(
    result: CheckResult,
    reach_m: f64,
    stated: LengthUnit,
    settings: &CheckSettings,
) -> CheckResult {
    let [least, most] = settings.hand_reach_m;
    // Numbers of the file times the metres of another unit.
    let in_unit = |unit: LengthUnit| reach_m / stated.metres() * unit.metres();
    let off = |unit: &LengthUnit| (in_unit(*unit) / TYPICAL_REACH_M).ln().abs();
    let fitting = LengthUnit::ALL
        .into_iter()
        .filter(|&unit| (least..=most).contains(&in_unit(unit)));
    let best = fitting.min_by(|a, b| off(a).total_cmp(&off(b)));
    let size = format!("the hand measures {} in {}", length(reach_m), stated.name());
    let Some(best) = best else {
        return result
            .found(format!("{size}, and no unit makes it a hand"))
            .advice("see which body is the hand and which markers are fingertips");
    };
    let (then, unit) = (length(in_unit(best)), best.name());
    let (setting, symbol) = (Setting::Units, symbol(best));
    result
        .found(format!("{size}; it would be {then} in {unit}"))
        .advice(format!(
            "read it with {setting} {symbol} if the file does not state a unit; else export again"
        ))
        .number("hand_then_mm", 1e3 * in_unit(best), 1)
}

const fn symbol(unit: LengthUnit) -> &'static str {
    match unit {
        LengthUnit::Metres => "m",
        LengthUnit::Centimetres => "cm",
        LengthUnit::Millimetres => "mm",
        LengthUnit::Inches => "in",
        LengthUnit::Feet => "ft",
    }
}

/// Single fingers that are too far from a hand whose other fingers are not, with their distance in
/// the middle of the take and how many samples it rests on. In a wrong unit all of them are.
fn misplaced(motion: &Motion, settings: &CheckSettings) -> Vec<(Finger, f64, usize)> {
    let distances = motion.fingertips.iter().map(|(finger, track)| {
        let mut distances = Finite::new(track.iter().flatten().map(|tip| tip.coords_m().norm()));
        (finger, distances.median(), distances.len())
    });
    let mut fingers: Vec<_> = distances.collect();
    let typical_m = Finite::new(fingers.iter().map(|&(_, median, _)| median)).median();
    let limit_m = settings.hand_reach_m[1].max(FAR * typical_m);
    fingers.retain(|&(_, median, _)| median > limit_m);
    fingers
}

fn finger_place(far: &[(Finger, f64, usize)], settings: &CheckSettings) -> Option<CheckResult> {
    let &(_, worst_m, n) = far.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
    let fingers = names(far.iter().map(|(finger, ..)| finger.name()));
    let (limit, worst) = (length(settings.hand_reach_m[1]), length(worst_m));
    let setting = Setting::Fingers;
    Some(
        CheckResult::new("finger-place", Level::Warn, fingers)
            .expected(format!("at most {limit} from the back of the hand"))
            .found(format!("{worst} from the back of the hand"))
            .advice(format!(
                "another marker may be meant: {setting} FINGER=MARKER"
            ))
            .number("distance_mm", 1e3 * worst_m, n),
    )
}

/// Coordinates that no capture volume has, where there is no hand to measure.
pub(crate) fn volume(recording: &Recording) -> Option<CheckResult> {
    let markers = (recording.markers.iter()).flat_map(|m| m.track.iter().flatten());
    let bodies = (recording.bodies.iter()).flat_map(|b| b.track.iter().flatten().map(Pose::origin));
    let places = markers.chain(bodies).map(|place| place.coords_m().amax());
    // Far off by a unit is far off at every sample: some are enough.
    let all = recording.len() * (recording.markers.len() + recording.bodies.len());
    let mut coordinates = Finite::new(places.step_by(all / 100_000 + 1));
    let middle_m = coordinates.median();
    if middle_m.is_nan() || middle_m <= VOLUME_M {
        return None;
    }
    let (middle, limit, unit) = (
        length(middle_m),
        length(VOLUME_M),
        recording.source.length_unit.name(),
    );
    let setting = Setting::Units;
    Some(
        CheckResult::new("volume", Level::Warn, "")
            .expected(format!("coordinates within {limit} of the origin"))
            .found(format!(
                "half of all coordinates are further than {middle} out, in {unit}"
            ))
            .advice(format!("the unit of length is probably another: {setting}"))
            .number("median_m", middle_m, coordinates.len()),
    )
}
