//! Fingertip labels that change places.
//!
//! Which finger each label is on is a hidden state: an order of the five, of 120. It may change,
//! by two labels at a time, only where something happens to a label: a jump, or a gap. Two kinds of
//! evidence weigh the states, both in nats and both measured against what is usual in the take:
//!
//! * **motion**: exchanging two labels at an instant joins the motion before of each with the motion
//!   after of the other. The cost of those joints stands against that of going on as labelled
//!   (`continuity`);
//! * **geometry**: each finger keeps to its part of the hand's frame. A label that lies where another
//!   finger usually is costs for as long as it does.
//!
//! The likeliest sequence of states is found by dynamic programming (Viterbi 1967). Motion alone
//! could not tell on which side of a jump the labels are right, nor geometry alone where a short swap
//! begins; together they need no thresholds but the price of a change.
//!
//! Spikes are set aside before, so that no label is judged by one.

use std::ops::Range;

use inhand_model::{Finger, Hand, PerFinger, PointTrack, Pose, Recording, Roles, Status};
use inhand_motion::{MotionError, fingertip_markers};
use rayon::prelude::*;

use super::spikes::spikes_in;
use crate::continuity::{UsualJumps, end_after, end_before};
use crate::geometry::{Geometry, INDEPENDENT_S};
use crate::lookup::{Flips, hand_poses, in_hand};
use crate::suspect::{Suspect, SuspectKind};

/// What a change of two labels costs, nats: a change is as rare as one in some thousand places where
/// it might be.
const CHANGE_NATS: f64 = 8.0;
/// A jump of this many times the usual, and of this many metres, is a place for a change; two
/// fingertips are never as near as that.
const JUMP_RATIO: f64 = 3.0;
const JUMP_M: f64 = 0.003;
/// Longest time that a label is looked for on another finger within one gap, seconds.
const LONGEST_VISIT_S: f64 = 2.5;
/// What it costs to begin with labels on wrong fingers, nats.
const WRONG_START_NATS: f64 = 6.0;

/// Fingertip labels that look exchanged, with flips of the hand's body set aside.
///
/// Cost: linear in the samples, and some thousand operations for each gap and jump.
///
/// # Errors
///
/// [`MotionError`].
pub fn swaps(recording: &Recording, roles: &Roles) -> Result<Vec<Suspect>, MotionError> {
    let hand = hand_poses(recording, roles, Flips::SetAside)?.map(Pose::inverse);
    let tips = fingertip_markers(recording, roles)?;
    let labels: Vec<PointTrack<Hand>> = (tips.as_array().par_iter())
        .map(|&marker| {
            let track = &recording.markers[marker].track;
            let mut label = in_hand(&hand, track);
            for k in (spikes_in(track, false).into_iter()).flat_map(|run| run.samples) {
                label.set(k, None, Status::Missing);
            }
            label
        })
        .collect();
    let rate_hz = recording.clock.rate_hz();
    let search = Search::new(&labels, rate_hz);
    let mut swaps = search.swaps();
    let visits = search.visits(&swaps, rate_hz);
    swaps.extend(visits);
    swaps.sort_by(|a, b| (a.samples.start, &a.fingers).cmp(&(b.samples.start, &b.fingers)));
    let suspect = |swap: Swap| Suspect {
        kind: SuspectKind::Swap {
            fingers: swap.fingers,
        },
        samples: swap.samples,
        score: swap.score,
    };
    Ok(swaps.into_iter().map(suspect).collect())
}

/// Labels in a cycle of fingers, each on the next finger, and by how many nats that is likelier than as
/// labelled.
struct Swap {
    fingers: Vec<Finger>,
    samples: Range<usize>,
    score: f64,
}

/// Which finger each label is on, by index.
type Order = [u8; Finger::COUNT];

struct Search<'a> {
    labels: &'a [PointTrack<Hand>],
    usual: UsualJumps,
    /// Samples at which something happens to a label, ascending.
    events: Vec<usize>,
    /// For each event and label, where it was last seen before and where it is seen next.
    joints: Vec<[Option<(usize, usize)>; Finger::COUNT]>,
    /// For each label and finger, what it costs that the one lies where the other does, summed up to
    /// each event, and to the end of the take.
    geometry: Vec<[[f64; Finger::COUNT]; Finger::COUNT]>,
    orders: Vec<Order>,
    /// For each order and pair of labels, the order with the two exchanged.
    exchanged: Vec<[usize; PAIRS.len()]>,
}

const PAIRS: [(usize, usize); 10] = [
    (0, 1),
    (0, 2),
    (0, 3),
    (0, 4),
    (1, 2),
    (1, 3),
    (1, 4),
    (2, 3),
    (2, 4),
    (3, 4),
];

impl<'a> Search<'a> {
    fn new(labels: &'a [PointTrack<Hand>], rate_hz: f64) -> Self {
        let tracks: Vec<_> = labels.iter().collect();
        let usual = UsualJumps::measured(&tracks, rate_hz);
        let events = events(labels, &usual);
        let places = Geometry::new(&PerFinger::from_fn(|finger| &labels[finger.index()]));
        let geometry = summed(labels, &places, &events, rate_hz);
        let orders = orders();
        let exchanged = (orders.iter())
            .map(|order| {
                PAIRS.map(|(a, b)| {
                    let mut other = *order;
                    other.swap(a, b);
                    orders.iter().position(|o| *o == other).unwrap_or(0)
                })
            })
            .collect();
        Self {
            joints: joints(labels, &events),
            labels,
            usual,
            events,
            geometry,
            orders,
            exchanged,
        }
    }

    fn swaps(&self) -> Vec<Swap> {
        let (path, gains) = self.likeliest();
        let end = self.labels.first().map_or(0, PointTrack::len);
        let bounds: Vec<usize> = [0]
            .into_iter()
            .chain(self.events.iter().copied())
            .chain([end])
            .collect();
        let mut swaps: Vec<Swap> = Vec::new();
        for (i, &state) in path.iter().enumerate() {
            let samples = bounds[i]..bounds[i + 1];
            for cycle in cycles(&self.orders[state]) {
                let score = gains[i];
                // The same cycle an interval before goes on.
                match (swaps.iter_mut())
                    .find(|s| s.samples.end == samples.start && s.fingers == cycle)
                {
                    Some(swap) => {
                        swap.samples.end = samples.end;
                        swap.score += score;
                    }
                    None => swaps.push(Swap {
                        fingers: cycle,
                        samples: samples.clone(),
                        score,
                    }),
                }
            }
        }
        swaps.retain(|swap| !swap.samples.is_empty());
        swaps
    }

    /// Swaps that begin and end in one gap of a label, in what these swaps leave.
    fn visits(&self, swaps: &[Swap], rate_hz: f64) -> Vec<Swap> {
        let mut labels = self.labels.to_vec();
        for swap in swaps {
            for k in swap.samples.clone() {
                let sample = |label: &Finger| {
                    let track = &labels[label.index()];
                    (track.get(k), track.status(k))
                };
                let mut carried: Vec<_> = swap.fingers.iter().map(sample).collect();
                carried.rotate_right(1);
                for (finger, (value, status)) in swap.fingers.iter().zip(carried) {
                    labels[finger.index()].set(k, value, status);
                }
            }
        }
        let mut found = self.visits_of(&labels, (LONGEST_VISIT_S * rate_hz) as usize);
        // Within another swap of the same labels a visit would have to be told in terms of that one.
        found.retain(|visit| {
            swaps.iter().all(|swap| {
                swap.samples.end <= visit.samples.start
                    || visit.samples.end <= swap.samples.start
                    || !swap
                        .fingers
                        .iter()
                        .any(|finger| visit.fingers.contains(finger))
            })
        });
        found
    }

    /// Visits of up to `longest` samples among labels that are otherwise on their own fingers. A visit begins
    /// and ends inside one gap of the other label, so that there is no instant at which the motions of both
    /// are joined crosswise. What there is: the visitor jumps away and back, its own finger's motion goes on
    /// across the visit, and the other finger's motion leads through it.
    fn visits_of(&self, labels: &[PointTrack<Hand>], longest: usize) -> Vec<Swap> {
        let mut found: Vec<Swap> = Vec::new();
        for (visitor, track) in labels.iter().enumerate() {
            for interval in pieces(track, &jumps(track, &self.usual), longest) {
                let best = (0..labels.len())
                    .filter(|&other| other != visitor)
                    .filter_map(|other| Some((self.gain(track, &labels[other], &interval)?, other)))
                    .max_by(|(a, _), (b, _)| a.total_cmp(b));
                let Some((score, other)) = best.filter(|(gain, _)| *gain > 0.0) else {
                    continue;
                };
                let pair = [visitor.min(other), visitor.max(other)];
                found.push(Swap {
                    fingers: pair.map(|finger| Finger::ALL[finger]).to_vec(),
                    samples: interval,
                    score,
                });
            }
        }
        found
    }

    /// By how many nats the take is likelier if the visitor's interval is the other finger's; `None` where
    /// the other label is there itself, or either is not seen on both sides.
    fn gain(
        &self,
        visitor: &PointTrack<Hand>,
        other: &PointTrack<Hand>,
        interval: &Range<usize>,
    ) -> Option<f64> {
        if interval.clone().any(|k| other.get(k).is_some()) {
            return None;
        }
        let sides = |track: &PointTrack<Hand>| {
            let before = (0..interval.start)
                .rev()
                .find(|&k| track.get(k).is_some())?;
            let after = (interval.end..track.len()).find(|&k| track.get(k).is_some())?;
            Some((end_before(track, before)?, end_after(track, after)?))
        };
        let (own_before, own_after) = sides(visitor)?;
        let (other_before, other_after) = sides(other)?;
        let first = end_after(visitor, interval.start)?;
        let last = end_before(visitor, interval.end - 1)?;
        let cost = |before, after| self.usual.cost(before, after);
        let kept =
            cost(&own_before, &first) + cost(&last, &own_after) + cost(&other_before, &other_after);
        let visiting =
            cost(&other_before, &first) + cost(&last, &other_after) + cost(&own_before, &own_after);
        Some(kept - visiting - 2.0 * CHANGE_NATS)
    }

    /// The likeliest order before, between and after the events, and by how much each interval is likelier
    /// than as labelled: its geometry, and the changes at its start.
    fn likeliest(&self) -> (Vec<usize>, Vec<f64>) {
        let count = self.orders.len();
        let mut costs: Vec<f64> = (0..count)
            .map(|s| if s == 0 { 0.0 } else { WRONG_START_NATS })
            .collect();
        let mut came_from: Vec<Vec<u8>> = Vec::with_capacity(self.events.len());
        /// Among ways to come, that of no change.
        const STAYED: u8 = PAIRS.len() as u8;
        let mut changes = Vec::with_capacity(self.events.len());
        let mut joints_before = [None; PAIRS.len()];
        for i in 0..self.events.len() {
            for (state, cost) in costs.iter_mut().enumerate() {
                *cost += self.place_cost(state, i);
            }
            let seen = &self.joints[i];
            let joints = PAIRS.map(|(a, b)| Some([seen[a]?, seen[b]?]));
            let change: [f64; PAIRS.len()] = std::array::from_fn(|pair| {
                // Between two events at which neither label was seen, one change is as good as the
                // other, and two would count the same joints twice.
                let same = i > 0 && joints[pair] == joints_before[pair];
                if same {
                    f64::INFINITY
                } else {
                    self.change_cost(PAIRS[pair], joints[pair])
                }
            });
            joints_before = joints;
            let mut next = costs.clone();
            let mut from = vec![STAYED; count];
            for state in 0..count {
                for (pair, change) in change.iter().enumerate() {
                    let cost = costs[self.exchanged[state][pair]] + change;
                    if cost < next[state] {
                        next[state] = cost;
                        from[state] = pair as u8;
                    }
                }
            }
            costs = next;
            came_from.push(from);
            changes.push(change);
        }
        let last = self.events.len();
        for (state, cost) in costs.iter_mut().enumerate() {
            *cost += self.place_cost(state, last);
        }
        let best = (0..count).min_by(|&a, &b| costs[a].total_cmp(&costs[b]));
        let mut path = vec![best.unwrap_or(0); last + 1];
        let mut gains = vec![0.0; last + 1];
        for i in (0..last).rev() {
            let state = path[i + 1];
            let pair = came_from[i][state];
            if pair == STAYED {
                path[i] = state;
            } else {
                path[i] = self.exchanged[state][usize::from(pair)];
                let gain = -changes[i][usize::from(pair)];
                // A change belongs to the intervals that it opens and closes.
                for interval in [i, i + 1] {
                    if path[interval] != 0 {
                        gains[interval] += gain;
                    }
                }
            }
        }
        for (i, gain) in gains.iter_mut().enumerate() {
            if path[i] != 0 {
                *gain += self.place_cost(0, i) - self.place_cost(path[i], i);
            }
        }
        (path, gains)
    }

    /// What the places of the labels cost in interval `i` (before event `i`) if they are on these fingers.
    fn place_cost(&self, state: usize, i: usize) -> f64 {
        let order = &self.orders[state];
        (0..Finger::COUNT)
            .map(|label| {
                let finger = usize::from(order[label]);
                let until = self.geometry[i + 1][label][finger];
                until - self.geometry[i][label][finger]
            })
            .sum()
    }

    /// What it costs to exchange two labels between where both were last and are next seen, against
    /// leaving them.
    fn change_cost(&self, (a, b): (usize, usize), joints: Option<[(usize, usize); 2]>) -> f64 {
        let ends = |label: usize, (last, next): (usize, usize)| {
            let track = &self.labels[label];
            end_before(track, last).zip(end_after(track, next))
        };
        let both = joints.and_then(|[of_a, of_b]| ends(a, of_a).zip(ends(b, of_b)));
        // A label that is never seen again, or was never seen, says nothing.
        both.map_or(CHANGE_NATS, |((a_before, a_after), (b_before, b_after))| {
            let cost = |before, after| self.usual.cost(before, after);
            let crossed = cost(&a_before, &b_after) + cost(&b_before, &a_after);
            let kept = cost(&a_before, &a_after) + cost(&b_before, &b_after);
            crossed - kept + CHANGE_NATS
        })
    }
}

/// Stretches of a label between a jump or gap and the next one, up to a length; those between two gaps
/// without a jump are left out, since nothing happened to them.
fn pieces(track: &PointTrack<Hand>, breaks: &[usize], longest: usize) -> Vec<Range<usize>> {
    let gaps = track.gaps();
    let mut bounds: Vec<(usize, bool)> = (gaps.iter())
        .flat_map(|gap| [(gap.start, false), (gap.end, false)])
        .chain(breaks.iter().map(|&k| (k, true)))
        .collect();
    bounds.sort_unstable();
    (bounds.windows(2))
        .filter(|pair| pair[0].1 || pair[1].1)
        .map(|pair| pair[0].0..pair[1].0)
        .filter(|interval| !interval.is_empty() && interval.len() <= longest)
        .filter(|interval| track.get(interval.start).is_some())
        .collect()
}

/// Samples at which a label jumps, and the first and last of every gap.
fn events(labels: &[PointTrack<Hand>], usual: &UsualJumps) -> Vec<usize> {
    let mut events = Vec::new();
    for label in labels {
        for gap in label.gaps() {
            events.extend([gap.start, gap.end]);
        }
        events.extend(jumps(label, usual));
    }
    let len = labels.first().map_or(0, PointTrack::len);
    events.retain(|&k| k > 0 && k < len);
    events.sort_unstable();
    events.dedup();
    events
}

/// Samples at which a label jumps from the sample before.
fn jumps(label: &PointTrack<Hand>, usual: &UsualJumps) -> Vec<usize> {
    (1..label.len())
        .filter(|&k| {
            // Cheap first: nearly all samples are near the one before.
            let near = (label.get(k - 1).zip(label.get(k)))
                .is_none_or(|(before, after)| before.distance_m(after) < JUMP_M);
            !near
                && (end_before(label, k - 1).zip(end_after(label, k)))
                    .is_some_and(|(before, after)| usual.ratio(&before, &after) >= JUMP_RATIO)
        })
        .collect()
}

/// Where each label was last seen before each event, and where it is seen next.
fn joints(
    labels: &[PointTrack<Hand>],
    events: &[usize],
) -> Vec<[Option<(usize, usize)>; Finger::COUNT]> {
    let mut joints = vec![[None; Finger::COUNT]; events.len()];
    for (label, track) in labels.iter().enumerate() {
        let present: Vec<usize> = (0..track.len())
            .filter(|&k| track.get(k).is_some())
            .collect();
        for (joint, event) in joints.iter_mut().zip(events) {
            let next = present.partition_point(|k| k < event);
            let last = next.checked_sub(1).map(|last| present[last]);
            joint[label] = last.zip(present.get(next).copied());
        }
    }
    joints
}

/// Cost of each label as each finger, summed up to the start, each event and the end.
fn summed(
    labels: &[PointTrack<Hand>],
    places: &Geometry,
    events: &[usize],
    rate_hz: f64,
) -> Vec<[[f64; Finger::COUNT]; Finger::COUNT]> {
    // Samples nearer than this in time say the same.
    let weight = 1.0 / (INDEPENDENT_S * rate_hz).max(1.0);
    let len = labels.first().map_or(0, PointTrack::len);
    let mut sums = Vec::with_capacity(events.len() + 2);
    let mut sum = [[0.0; Finger::COUNT]; Finger::COUNT];
    sums.push(sum);
    let mut from = 0;
    for until in events.iter().copied().chain([len]) {
        for (label, track) in labels.iter().enumerate() {
            for finger in Finger::ALL {
                let samples = (from..until).filter_map(|k| track.get(k));
                sum[label][finger.index()] += weight * places.cost(finger, samples);
            }
        }
        sums.push(sum);
        from = until;
    }
    sums
}

/// Every order of five, that of the labels' own fingers first.
fn orders() -> Vec<Order> {
    let mut orders: Vec<Order> = vec![[0, 1, 2, 3, 4]];
    let mut next = 0;
    while next < orders.len() {
        for (a, b) in PAIRS {
            let mut other = orders[next];
            other.swap(a, b);
            if !orders.contains(&other) {
                orders.push(other);
            }
        }
        next += 1;
    }
    orders
}

/// The cycles of an order that move fingers, each from its first finger.
fn cycles(order: &Order) -> Vec<Vec<Finger>> {
    let mut seen = [false; Finger::COUNT];
    let mut cycles = Vec::new();
    for first in 0..Finger::COUNT {
        let mut cycle = Vec::new();
        let mut at = first;
        while !seen[at] {
            seen[at] = true;
            cycle.push(Finger::ALL[at]);
            at = usize::from(order[at]);
        }
        if cycle.len() > 1 {
            cycles.push(cycle);
        }
    }
    cycles
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_are_120_orders_and_cycles_read_labels_first() {
        let all = orders();
        assert_eq!((all.len(), all[0]), (120, [0, 1, 2, 3, 4]));
        assert!(cycles(&all[0]).is_empty());
        // Label index is on middle, label middle on ring, label ring on index.
        let cycle = cycles(&[0, 2, 3, 1, 4]);
        assert_eq!(cycle, [[Finger::Index, Finger::Middle, Finger::Ring]]);
        assert_eq!(cycles(&[1, 0, 2, 4, 3]).len(), 2);
    }
}
