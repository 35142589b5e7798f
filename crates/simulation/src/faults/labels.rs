//! Faults of fingertip labels: swaps, lost labels, ghosts, spikes, gaps.

use std::ops::Range;

use inhand_model::{Finger, Hand, MarkerKind, PointTrack, Position, Status};
use nalgebra::Vector3;

use super::{MAX_DRAWS, Planting, log_uniform};
use crate::camera_system::{draw_gaps, marker};
use crate::error::SimulationError;
use crate::random::{Purpose, Random};
use crate::settings::GapSettings;
use crate::take::{Fault, FaultKind};

const SWAP_RANGE_S: (f64, f64) = (0.05, 2.0);
const NEIGHBOUR_CHANCE: f64 = 0.7;
/// Places drawn for a swap, of which that with the nearest fingers is taken.
const SWAP_PLACES: usize = 4;
const LOST_AT_SWAP_CHANCE: f64 = 0.3;
const LOST_AT_SWAP_RANGE_S: (f64, f64) = (0.01, 0.12);
const UNLABELLED_RANGE_S: (f64, f64) = (0.1, 3.0);
const MAX_LOST_AT_UNLABELLED: usize = 3;
const GHOST_RANGE_S: (f64, f64) = (0.1, 1.0);
/// Distance of a ghost from the middle of the fingers, metres, and the scatter of its samples.
const GHOST_RANGE_M: (f64, f64) = (0.03, 0.15);
const GHOST_SCATTER_M: f64 = 3e-4;
const SPIKE_RANGE_M: (f64, f64) = (0.005, 0.05);
const MAX_SPIKE_SAMPLES: usize = 3;
/// Scatter of a spike's direction from sample to sample, as a share of its length.
const SPIKE_SCATTER: f64 = 0.1;
const BESIDE_GAP_CHANCE: f64 = 0.2;
/// Samples between two spikes of a marker.
const SPIKES_APART: usize = 6;
/// Time between intervals in which a finger's label is not its own, seconds.
const APART_S: f64 = 0.1;

impl Planting<'_> {
    pub(super) fn swaps(
        &mut self,
        count: usize,
        random: &mut Random,
    ) -> Result<(), SimulationError> {
        for number in 1..=count {
            let pair = draw_pair(random);
            let len = self.in_samples(log_uniform(SWAP_RANGE_S, random));
            let mut best: Option<(f64, Range<usize>)> = None;
            for _ in 0..SWAP_PLACES {
                let stretch = (self.free_of(&pair, len, random))
                    .ok_or_else(|| self.crowded("swap", number, count))?;
                let [a, b] = pair.map(|f| self.clean.truth.fingertips[f][stretch.start]);
                let apart_m = a.distance_m(b);
                if best.as_ref().is_none_or(|(least_m, _)| apart_m < *least_m) {
                    best = Some((apart_m, stretch));
                }
            }
            let Some((_, stretch)) = best else { continue };
            self.exchange(pair, &stretch);
            for end in [stretch.start, stretch.end] {
                self.lose_about(&pair, end, random);
            }
            for finger in pair {
                self.taken[finger].push(stretch.clone());
            }
            self.add(FaultKind::Swap, self.names(&pair), stretch);
        }
        Ok(())
    }

    fn exchange(&mut self, [a, b]: [Finger; 2], stretch: &Range<usize>) {
        let (a, b) = (self.tips[a], self.tips[b]);
        for k in stretch.clone() {
            let of = |marker: usize| {
                let track = &self.recording.markers[marker].track;
                (track.get(k), track.status(k))
            };
            let (of_a, of_b) = (of(a), of(b));
            (self.recording.markers[a].track).set(k, of_b.0, of_b.1);
            (self.recording.markers[b].track).set(k, of_a.0, of_a.1);
        }
    }

    /// Perhaps loses one label or both for a moment in which they change.
    fn lose_about(&mut self, pair: &[Finger; 2], end: usize, random: &mut Random) {
        if !random.chance(LOST_AT_SWAP_CHANCE) {
            return;
        }
        let lost: &[Finger] = match random.below(3) {
            0 => &pair[..1],
            1 => &pair[1..],
            _ => pair,
        };
        for &finger in lost {
            let len = self.in_samples(random.between(LOST_AT_SWAP_RANGE_S));
            let start = end.saturating_sub(random.below(len + 1));
            self.lost[finger].push(start..(start + len).min(self.recording.len()));
        }
    }

    pub(super) fn unlabelled(
        &mut self,
        count: usize,
        random: &mut Random,
    ) -> Result<(), SimulationError> {
        for number in 1..=count {
            let finger = Finger::ALL[random.below(Finger::COUNT)];
            let len = self.in_samples(log_uniform(UNLABELLED_RANGE_S, random));
            let stretch = (self.free_of(&[finger], len, random))
                .ok_or_else(|| self.crowded("unlabelled stretch", number, count))?;
            let lost = [(); 2].map(|()| random.below(MAX_LOST_AT_UNLABELLED + 1));
            let seen = stretch.start + lost[0].min(len - 1)..stretch.end;
            let seen = seen.start..seen.end.saturating_sub(lost[1]).max(seen.start + 1);
            let own = &mut self.recording.markers[self.tips[finger]].track;
            let mut track = PointTrack::missing(own.len());
            for k in stretch.clone() {
                if seen.contains(&k) {
                    track.set(k, own.get(k), own.status(k));
                }
                own.set(k, None, Status::Missing);
            }
            let mut entities = self.names(&[finger]);
            entities.push(self.add_unlabelled(track));
            self.taken[finger].push(stretch.clone());
            self.add(FaultKind::Unlabelled, entities, stretch);
        }
        Ok(())
    }

    pub(super) fn ghosts(
        &mut self,
        count: usize,
        random: &mut Random,
    ) -> Result<(), SimulationError> {
        let samples = self.recording.len();
        for number in 1..=count {
            let len = self.in_samples(log_uniform(GHOST_RANGE_S, random));
            let stretch = (self.free_stretch(len, 1, &[], random))
                .ok_or_else(|| self.crowded("ghost", number, count))?;
            let truth = &self.clean.truth;
            let hand_from_world = truth.world_from_hand[stretch.start].inverse();
            let tip = |f: Finger| (hand_from_world * truth.fingertips[f][stretch.start]).coords_m();
            let middle = Finger::ALL.iter().map(|&f| tip(f)).sum::<Vector3<f64>>() / 5.0;
            let away = unit(random) * random.between(GHOST_RANGE_M);
            let place = Position::<Hand>::from_coords(middle + away);
            let mut track = PointTrack::missing(samples);
            for k in stretch.clone() {
                let at = (truth.world_from_hand[k] * place).coords_m();
                let seen = at + random.normal3(GHOST_SCATTER_M);
                track.set(k, Some(Position::from_coords(seen)), Status::Measured);
            }
            let entities = vec![self.add_unlabelled(track)];
            self.add(FaultKind::Ghost, entities, stretch);
        }
        Ok(())
    }

    fn add_unlabelled(&mut self, track: PointTrack<inhand_model::World>) -> String {
        let name = format!("Unlabeled {}", self.next_unlabelled);
        self.next_unlabelled += 1;
        let marker = marker(name.clone(), MarkerKind::Unlabelled, track);
        self.recording.markers.push(marker);
        name
    }

    /// Gaps of the settings and those where labels change, as faults.
    pub(super) fn gaps(&mut self, gaps: &GapSettings, seed: u64) -> Result<(), SimulationError> {
        let samples = self.recording.len();
        for finger in Finger::ALL {
            let mut random = Random::new(seed, Purpose::Gaps(finger));
            let drawn = draw_gaps(gaps, samples, &mut random)?;
            let track = &mut self.recording.markers[self.tips[finger]].track;
            let lost = std::mem::take(&mut self.lost[finger]);
            for k in drawn.into_iter().chain(lost).flatten() {
                track.set(k, None, Status::Missing);
            }
            // What went to an unlabelled marker is no gap.
            let unlabelled = |gap: &Range<usize>| {
                self.faults.iter().any(|fault| {
                    fault.kind == FaultKind::Unlabelled
                        && fault.entities[0] == crate::take::marker_name(finger)
                        && fault.samples.start < gap.end
                        && gap.start < fault.samples.end
                })
            };
            let own: Vec<_> = track
                .gaps()
                .into_iter()
                .filter(|g| !unlabelled(g))
                .collect();
            let entities = self.names(&[finger]);
            self.faults.extend(own.into_iter().map(|samples| Fault {
                kind: FaultKind::Gap,
                entities: entities.clone(),
                samples,
            }));
        }
        // Labels that were lost all the while were not seen in wrong places.
        let markers = &self.recording.markers;
        self.faults.retain(|fault| {
            fault.kind != FaultKind::Swap
                || fault.samples.clone().any(|k| {
                    (markers.iter())
                        .filter(|marker| fault.entities.contains(&marker.name))
                        .any(|marker| marker.track.get(k).is_some())
                })
        });
        Ok(())
    }

    pub(super) fn spikes(
        &mut self,
        count: usize,
        random: &mut Random,
    ) -> Result<(), SimulationError> {
        let mut spiked: Vec<(Finger, Range<usize>)> = Vec::new();
        for number in 1..=count {
            let (finger, stretch) = (0..MAX_DRAWS)
                .map(|_| self.draw_spike(random))
                .find(|(finger, stretch)| self.has_room(*finger, stretch, &spiked))
                .ok_or_else(|| self.crowded("spike", number, count))?;
            let off_m = random.between(SPIKE_RANGE_M);
            let direction = unit(random);
            let track = &mut self.recording.markers[self.tips[finger]].track;
            let mut was_m = Vec::with_capacity(stretch.len());
            let mut most_m: f64 = 0.0;
            for k in stretch.clone() {
                let Some(was) = track.get(k) else { continue };
                was_m.push(was.to_array());
                let off = (direction + random.normal3(SPIKE_SCATTER)) * off_m;
                most_m = most_m.max(off.norm());
                let seen = Position::from_coords(was.coords_m() + off);
                track.set(k, Some(seen), Status::Measured);
            }
            let kind = FaultKind::Spike {
                off_m: most_m,
                was_m,
            };
            self.add(kind, self.names(&[finger]), stretch.clone());
            spiked.push((finger, stretch));
        }
        Ok(())
    }

    /// A finger and a run of samples, one of five beside a gap.
    fn draw_spike(&self, random: &mut Random) -> (Finger, Range<usize>) {
        let finger = Finger::ALL[random.below(Finger::COUNT)];
        let len = 1 + random.below(MAX_SPIKE_SAMPLES);
        let beside_gap = random.chance(BESIDE_GAP_CHANCE);
        let before = random.chance(0.5);
        let gaps = self.recording.markers[self.tips[finger]].track.gaps();
        let start = if beside_gap && !gaps.is_empty() {
            let gap = &gaps[random.below(gaps.len())];
            if before {
                gap.start.saturating_sub(len)
            } else {
                gap.end
            }
        } else {
            random.below(self.recording.len())
        };
        (finger, start..start + len)
    }

    /// Whether all samples are there, with others on one side at least, and no spike is near.
    fn has_room(
        &self,
        finger: Finger,
        stretch: &Range<usize>,
        spiked: &[(Finger, Range<usize>)],
    ) -> bool {
        let track = &self.recording.markers[self.tips[finger]].track;
        let present = |range: Range<usize>| range.into_iter().all(|k| track.get(k).is_some());
        let inside = stretch.start >= SPIKES_APART && stretch.end + SPIKES_APART <= track.len();
        inside
            && present(stretch.clone())
            && (present(stretch.start - SPIKES_APART..stretch.start)
                || present(stretch.end..stretch.end + SPIKES_APART))
            && (spiked.iter()).all(|(other, samples)| {
                *other != finger
                    || samples.end + SPIKES_APART <= stretch.start
                    || stretch.end + SPIKES_APART <= samples.start
            })
    }

    /// An interval in which the labels of these fingers are their own.
    fn free_of(&self, fingers: &[Finger], len: usize, random: &mut Random) -> Option<Range<usize>> {
        let taken = fingers
            .iter()
            .flat_map(|&finger| self.taken[finger].clone());
        self.free_stretch(
            len,
            self.in_samples(APART_S),
            &taken.collect::<Vec<_>>(),
            random,
        )
    }
}

fn draw_pair(random: &mut Random) -> [Finger; 2] {
    if random.chance(NEIGHBOUR_CHANCE) {
        let first = random.below(Finger::COUNT - 1);
        return [Finger::ALL[first], Finger::ALL[first + 1]];
    }
    let first = random.below(Finger::COUNT);
    let other = (first + 1 + random.below(Finger::COUNT - 1)) % Finger::COUNT;
    [first.min(other), first.max(other)].map(|index| Finger::ALL[index])
}

fn unit(random: &mut Random) -> Vector3<f64> {
    random
        .normal3(1.0)
        .try_normalize(0.0)
        .unwrap_or(Vector3::x())
}
