//! The vertical axis, by things that rest.
//!
//! A thing that lies still while the hand moves lies on something, and from there it can only be
//! taken up. So the direction in which its resting places are the lowest points of its track, while
//! it goes both ways along the other axes, is up. Where nothing rests, or more than one direction
//! would do, there is no evidence: an object in the fingers says nothing about gravity.

use std::ops::Range;

use inhand_model::{Body, PoseTrack, Recording, Setting, UpAxis, World, runs};
use inhand_motion::BodyRole;
use nalgebra::Vector3;

use super::checkup::{CheckResult, Level};
use super::subject::Subject;
use super::words::length;

/// Shortest rest, seconds.
const REST_S: f64 = 0.5;

/// How far a resting thing may seem to move, metres.
const STILL_M: f64 = 1e-3;

/// How far the hand has to move during a rest, metres: else both may just hold still.
const HAND_MOVES_M: f64 = 0.02;

/// How far above its resting place a thing has to be taken, metres.
const LIFT_M: f64 = 0.05;

/// How far below a resting place a track may go: a table is flat within this, metres.
const FLAT_M: f64 = 0.015;

/// The up axis by the rests of the object.
pub(crate) fn up_axis(subject: &Subject<'_>) -> Option<CheckResult> {
    let object = subject.body(BodyRole::Object)?;
    let hand = subject.body(BodyRole::Hand)?;
    let recording = subject.recording;
    let stated = recording.source.up_axis;
    let rests = rests(recording, object, hand);
    let found = directions(object, &rests);
    let samples: usize = rests.iter().map(Range::len).sum();
    let base = |level| {
        CheckResult::new("up-axis", level, "")
            .expected(format!("+{} up, as stated or assumed", stated.name()))
            .at(&recording.clock, &rests)
            .number("rests", rests.len() as f64, samples)
    };
    let [(axis, sign, lift_m)] = found[..] else {
        let why = if rests.is_empty() {
            "the object never lies still while the hand moves"
        } else if found.is_empty() {
            "the object lies still but is never lifted from there, or lies at different heights"
        } else {
            "from where the object lies still it goes one way along more than one axis"
        };
        return Some(base(Level::Info).found(format!("no evidence on which axis is up: {why}")));
    };
    let name = format!(
        "{}{}",
        if sign > 0.0 { '+' } else { '-' },
        ["x", "y", "z"][axis]
    );
    let lift = length(lift_m);
    let result = |level| base(level).number("lift_mm", 1e3 * lift_m, samples);
    let up = match (axis, sign > 0.0) {
        (1, true) => Some(UpAxis::Y),
        (2, true) => Some(UpAxis::Z),
        _ => None,
    };
    if up == Some(stated) {
        let found = format!("{name} is up: the object is lifted {lift} from where it rests");
        return Some(result(Level::Ok).found(found));
    }
    let setting = Setting::Up;
    let advice = up.map_or_else(
        || "export again with y or z up: views stand on their side".to_owned(),
        |up| {
            format!(
                "read it with {setting} {} if the file does not state it",
                up.name()
            )
        },
    );
    let found =
        format!("{name} looks like up: the object is lifted {lift} along it from where it rests");
    Some(result(Level::Warn).found(found).advice(advice))
}

/// Ranges in which the object lies still and the hand does not.
fn rests(
    recording: &Recording,
    object: &PoseTrack<World, Body>,
    hand: &PoseTrack<World, Body>,
) -> Vec<Range<usize>> {
    let n = recording.len();
    let window = ((REST_S * recording.clock.rate_hz()).round() as usize).max(2);
    let place =
        |track: &PoseTrack<World, Body>, k: usize| track.get(k).map(|p| p.origin().coords_m());
    // A sample rests where it stays within reach of the sample a window later, and of the middle.
    let still = |k: usize| {
        let Some(here) = place(object, k) else {
            return false;
        };
        [k + window / 2, k + window].iter().all(|&later| {
            place(object, later).is_some_and(|there| (there - here).norm() <= STILL_M)
        })
    };
    let mut found = Vec::new();
    for run in runs(0..n.saturating_sub(window), still) {
        let rest = run.start..run.end + window;
        // Slow motion passes the test above step by step, but not over the whole rest.
        let (low, high) = extent(rest.clone().filter_map(|k| place(object, k)));
        let (hand_low, hand_high) = extent(rest.clone().filter_map(|k| place(hand, k)));
        if (high - low).norm() <= 4.0 * STILL_M && (hand_high - hand_low).norm() >= HAND_MOVES_M {
            found.push(rest);
        }
    }
    found
}

/// Smallest and largest coordinates.
fn extent(places: impl Iterator<Item = Vector3<f64>>) -> (Vector3<f64>, Vector3<f64>) {
    let start = (
        Vector3::repeat(f64::INFINITY),
        Vector3::repeat(f64::NEG_INFINITY),
    );
    places.fold(start, |(low, high), place| {
        (low.inf(&place), high.sup(&place))
    })
}

/// Directions (axis, sign, lift in metres) along which every rest is the lowest place of the track.
fn directions(object: &PoseTrack<World, Body>, rests: &[Range<usize>]) -> Vec<(usize, f64, f64)> {
    let place = |k: usize| object.get(k).map(|pose| pose.origin().coords_m());
    let resting: Vec<_> = (rests.iter())
        .filter_map(|rest| place(rest.start + rest.len() / 2))
        .collect();
    if resting.is_empty() {
        return Vec::new();
    }
    let (low, high) = extent((0..object.len()).filter_map(place));
    let (lowest_rest, highest_rest) = extent(resting.into_iter());
    let mut found = Vec::new();
    for axis in 0..3 {
        for (sign, bottom, top, highest) in [
            (1.0, low[axis], high[axis], highest_rest[axis]),
            (-1.0, -high[axis], -low[axis], -lowest_rest[axis]),
        ] {
            if highest - bottom <= FLAT_M && top - highest >= LIFT_M {
                found.push((axis, sign, top - highest));
            }
        }
    }
    found
}
