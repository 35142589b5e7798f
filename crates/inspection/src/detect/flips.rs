//! Bodies that jump to a wrong solution and back.
//!
//! A wrong solution is a fixed turn away from the right one, in the body's own frame: while a body
//! is wrong it goes on moving, but the turn by which it went is the turn by which it comes back. Both
//! jumps are turns that no motion of the take explains.

use std::ops::Range;

use inhand_model::{Body, Pose, PoseTrack, Recording, TrackedBody, World};
use nalgebra::{Isometry3, Translation3, UnitQuaternion};

use crate::statistics::{median, quantile};
use crate::suspect::{FlipRepair, Suspect, SuspectKind};

/// Turns below this between two samples are never called jumps, radians (25 degrees). Wrong solutions
/// of bodies that can be distinguished at all are larger.
const LEAST_JUMP_RAD: f64 = 0.436;
/// Nor are turns slower than this, radians a second (2500 degrees): a wrist reaches about 1500, and a
/// thing in its fingers little more.
const FASTEST_RAD_S: f64 = 44.0;
/// Beyond both, a jump turns this many times farther than the fast motion of the take (its 99th
/// percentile).
const TIMES_FAST: f64 = 2.0;
/// Longest time without the body over which a turn is still a jump, seconds. Fingers turn a thing by a
/// quarter in little more, and then nothing tells which pose is wrong.
const LONGEST_UNSEEN_S: f64 = 0.1;
/// How fast a body may turn while it is not seen, radians a second (600 degrees).
const UNSEEN_RAD_S: f64 = 10.5;
/// How well the way back has to match the way there, radians (20 degrees).
const MATCH_RAD: f64 = 0.35;
/// Longest time that a wrong solution lasts, seconds; what jumps and stays is another body, or the
/// jump itself was wrong.
const LONGEST_S: f64 = 10.0;
/// Longest interval that is removed for a jump alone, seconds.
const SHORT_S: f64 = 1.0;
/// A marker error of this many times the take's median says that a pose is wrong.
const WRONG_ERROR_RATIO: f64 = 2.0;
/// Samples from which the motion before a jump is carried on.
const CARRIED_SAMPLES: usize = 4;
/// Longest time over which a body is carried on by its velocity, seconds.
const CARRIED_S: f64 = 0.1;

/// A turn that is no motion, from one present sample to the next.
#[derive(Clone, Copy, Debug)]
struct Jump {
    from: usize,
    to: usize,
    /// From the body after to the body as it was carried on from before: `before_from_after`.
    turn: Isometry3<f64>,
    /// How many times the least jump.
    score: f64,
}

/// Bodies of a recording that jump to a wrong pose, and what it would take to turn them back.
///
/// Linear in the samples. Turns while a body is not seen for more than a tenth of a second are left
/// alone, for it may have been turned. A body that jumps and does not come back by the same turn within ten seconds
/// is found, with [`FlipRepair::Remove`], where one side of the jump lasts a second at most or has a
/// marker error that says that it is wrong.
pub fn flips(recording: &Recording) -> Vec<Suspect> {
    let rate_hz = recording.clock.rate_hz();
    let mut found = Vec::new();
    for (index, body) in recording.bodies.iter().enumerate() {
        found.extend(flips_of(body, rate_hz).into_iter().map(|flip| Suspect {
            kind: SuspectKind::Flip {
                body: index,
                name: body.name.clone(),
                turn_rad: flip.jump.turn.rotation.angle(),
                repair: flip.repair,
            },
            samples: flip.samples,
            score: flip.jump.score,
        }));
    }
    // Stable: those of one sample stay in the order of bodies.
    found.sort_by_key(|flip| flip.samples.start);
    found
}

/// A body in a wrong pose from a jump on.
struct Flip {
    samples: Range<usize>,
    jump: Jump,
    repair: FlipRepair,
}

fn flips_of(body: &TrackedBody, rate_hz: f64) -> Vec<Flip> {
    let seen = seen_ranges(body, rate_hz);
    let jumps = jumps_of(body, rate_hz);
    let mut flips = Vec::new();
    for range in seen {
        let from = jumps.partition_point(|jump| jump.from < range.start);
        let to = jumps.partition_point(|jump| jump.from < range.end);
        flips_within(body, rate_hz, &range, &jumps[from..to], &mut flips);
    }
    flips
}

/// Flips within a range that is seen without a long gap, from its jumps.
fn flips_within(
    body: &TrackedBody,
    rate_hz: f64,
    range: &Range<usize>,
    jumps: &[Jump],
    flips: &mut Vec<Flip>,
) {
    let longest = (LONGEST_S * rate_hz) as usize;
    let mut next = 0;
    while next < jumps.len() {
        let jump = jumps[next];
        match way_back(&jumps[next..], longest) {
            Some(turns) => {
                // Between the jumps the body is wrong by the turns so far.
                for (pair, &turn) in jumps[next..].windows(2).zip(&turns) {
                    flips.push(Flip {
                        samples: pair[0].to..pair[1].from + 1,
                        jump,
                        repair: FlipRepair::TurnBack(turn),
                    });
                }
                next += turns.len() + 1;
            }
            None => {
                let until = (jumps.get(next + 1)).map_or(range.end, |after| after.from + 1);
                let since = (next.checked_sub(1)).map_or(range.start, |before| jumps[before].to);
                let sides = [since..jump.from + 1, jump.to..until];
                flips.extend(wrong_side(body, sides, rate_hz).map(|samples| Flip {
                    samples,
                    jump,
                    repair: FlipRepair::Remove,
                }));
                next += 1;
            }
        }
    }
}

/// Which side of a jump without a way back is wrong, if that can be said: the shorter one where it is
/// short and the error of the other does not say otherwise, or one whose error says so.
fn wrong_side(
    body: &TrackedBody,
    mut sides: [Range<usize>; 2],
    rate_hz: f64,
) -> Option<Range<usize>> {
    sides.sort_by_key(ExactSizeIterator::len);
    let [shorter, longer] = sides;
    let says_wrong = |side: &Range<usize>| {
        side.len() as f64 <= LONGEST_S * rate_hz
            && error_ratio(body, side).is_some_and(|ratio| ratio >= WRONG_ERROR_RATIO)
    };
    if says_wrong(&shorter) {
        return Some(shorter);
    }
    if says_wrong(&longer) {
        return Some(longer);
    }
    (shorter.len() as f64 <= SHORT_S * rate_hz).then_some(shorter)
}

/// Ranges between gaps over which a turn says nothing, from the first present sample to one after the
/// last.
fn seen_ranges(body: &TrackedBody, rate_hz: f64) -> Vec<Range<usize>> {
    let mut ranges: Vec<Range<usize>> = Vec::new();
    for k in (0..body.track.len()).filter(|&k| body.track.get(k).is_some()) {
        match ranges.last_mut() {
            Some(last) if bridges(k - last.end, rate_hz) => last.end = k + 1,
            _ => ranges.push(k..k + 1),
        }
    }
    ranges
}

/// Whether a turn over that many missing samples can be called a jump.
fn bridges(unseen: usize, rate_hz: f64) -> bool {
    /// A whole number of samples must not be lost to rounding.
    const SLACK_SAMPLES: f64 = 1e-6;
    unseen as f64 <= LONGEST_UNSEEN_S * rate_hz + SLACK_SAMPLES
}

/// The least turn from one sample to the next that no body makes, radians.
fn least_turn_rad(rate_hz: f64) -> f64 {
    LEAST_JUMP_RAD.max(FASTEST_RAD_S / rate_hz)
}

/// Jumps of a body by more than its motion explains, in order.
fn jumps_of(body: &TrackedBody, rate_hz: f64) -> Vec<Jump> {
    let present: Vec<usize> = (0..body.track.len())
        .filter(|&k| body.track.get(k).is_some())
        .collect();
    let turn_of = |from: usize, to: usize| {
        let pose = |k: usize| body.track.value(k).isometry();
        pose(from).rotation.angle_to(&pose(to).rotation)
    };
    let turns = (present.windows(2))
        .filter(|pair| pair[1] == pair[0] + 1)
        .map(|pair| turn_of(pair[0], pair[1]));
    let least_rad = least_turn_rad(rate_hz);
    // A body that is wrong at every other sample must not hide its own jumps.
    let fast_rad = quantile(turns, 0.99).min(least_rad);
    let base_rad = least_rad.max(TIMES_FAST * fast_rad);
    let unseen_rad = (UNSEEN_RAD_S / rate_hz).max(TIMES_FAST * fast_rad);
    (present.windows(2))
        .filter(|pair| bridges(pair[1] - pair[0] - 1, rate_hz))
        .filter_map(|pair| {
            let (from, to) = (pair[0], pair[1]);
            let unseen = (to - from - 1) as f64;
            let score = turn_of(from, to) / (base_rad + unseen_rad * unseen);
            (score >= 1.0).then(|| Jump {
                from,
                to,
                turn: carried_on(body, from, to, rate_hz).inverse()
                    * body.track.value(to).isometry(),
                score,
            })
        })
        .collect()
}

/// From the sample before to the sample after each jump of a body, in order.
pub(crate) fn breaks(body: &TrackedBody, rate_hz: f64) -> Vec<Range<usize>> {
    let jumps = jumps_of(body, rate_hz);
    jumps.iter().map(|jump| jump.from..jump.to).collect()
}

/// Where the body would be at sample `to` by its motion before `from`.
fn carried_on(body: &TrackedBody, from: usize, to: usize, rate_hz: f64) -> Isometry3<f64> {
    let last = body.track.value(from).isometry();
    let run = (1..CARRIED_SAMPLES)
        .take_while(|&back| {
            from.checked_sub(back)
                .is_some_and(|k| body.track.get(k).is_some())
        })
        .last();
    let earlier = run.map(|back| (back, body.track.value(from - back).isometry()));
    let Some((back, earlier)) =
        earlier.filter(|(_, e)| e.rotation.angle_to(&last.rotation) < least_turn_rad(rate_hz))
    else {
        return last;
    };
    let steps = ((to - from) as f64).min(CARRIED_S * rate_hz) / back as f64;
    let turn = (last.rotation * earlier.rotation.inverse()).scaled_axis() * steps;
    let moved = (last.translation.vector - earlier.translation.vector) * steps;
    Isometry3::from_parts(
        Translation3::from(last.translation.vector + moved),
        UnitQuaternion::from_scaled_axis(turn) * last.rotation,
    )
}

/// The turns that a body is wrong by from each jump to the next until it is back, if it comes back by
/// the way it went: at most a few jumps later, and before `longest` samples are over.
fn way_back(jumps: &[Jump], longest: usize) -> Option<Vec<Isometry3<f64>>> {
    const MOST_JUMPS: usize = 4;
    let first = jumps.first()?;
    let mut turns = vec![first.turn];
    for jump in jumps.iter().take(MOST_JUMPS).skip(1) {
        if jump.to > first.to + longest {
            return None;
        }
        let wrong = *turns.last()?;
        let left = wrong * jump.turn;
        if left.rotation.angle() < MATCH_RAD {
            // Both jumps tell the same turn, each with the noise of its samples.
            let back = jump.turn.inverse();
            let middle = Isometry3::from_parts(
                Translation3::from((wrong.translation.vector + back.translation.vector) / 2.0),
                wrong.rotation.slerp(&back.rotation, 0.5),
            );
            *turns.last_mut()? = middle;
            return Some(turns);
        }
        turns.push(left);
    }
    None
}

fn error_ratio(body: &TrackedBody, samples: &Range<usize>) -> Option<f64> {
    let errors = body.marker_error_m.as_ref()?;
    let usual_m = median(errors.iter().copied());
    let here = &errors[samples.clone()];
    let known = usual_m > 0.0 && here.iter().any(|error| error.is_finite());
    known.then(|| median(here.iter().copied()) / usual_m)
}

/// The poses of a body with its flips undone, or missing where that is not possible.
pub(crate) fn without_flips(body: &TrackedBody, rate_hz: f64) -> PoseTrack<World, Body> {
    let mut track = body.track.clone();
    for flip in flips_of(body, rate_hz) {
        flip.repair.apply(&mut track, &flip.samples);
    }
    track
}

impl FlipRepair {
    /// Repairs the poses of a body at some samples.
    pub(crate) fn apply(&self, track: &mut PoseTrack<World, Body>, samples: &Range<usize>) {
        for k in samples.clone() {
            let turned = match self {
                FlipRepair::TurnBack(turn) => {
                    (track.get(k)).map(|pose| Pose::new(pose.isometry() * turn.inverse()))
                }
                FlipRepair::Remove => None,
            };
            track.set(k, turned, track.status(k));
        }
    }
}
