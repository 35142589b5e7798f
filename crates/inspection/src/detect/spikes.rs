//! Samples that are off their way and come back to it.
//!
//! A run of one to three samples is a spike where the curve through the samples on both sides passes
//! all of them by far while it goes through its own samples closely. Fast motion is distinguished
//! from a spike by that: a fingertip in motion bends the curve on both sides too. Labels that change places
//! do not come back within three samples.
//!
//! Beside a gap there is one side only. There a run is a spike where it breaks away from the line of
//! the side that is there.

use std::collections::BTreeMap;
use std::ops::Range;

use inhand_model::{MarkerKind, PointTrack, Position, Recording, Status, World};
use nalgebra::Vector3;
use rayon::prelude::*;

use crate::continuity::{End, end_after, end_before, parabola};
use crate::statistics::median;
use crate::suspect::{Suspect, SuspectKind};

/// Most samples of a spike. A wrong reconstruction lasts a frame or a few; what stays longer is a
/// label on something else.
const MAX_SAMPLES: usize = 3;
/// Samples on each side that the curve goes through.
const SIDE: usize = 3;
/// Least distance that is called a spike, metres: ten times the jitter of a good system, and more
/// than the curve misses by in the fastest turns of a fingertip (some 6 m/s² over 45 ms).
const LEAST_M: f64 = 0.003;
/// Beside a gap: the line of four samples is carried on by one more.
const LEAST_BESIDE_GAP_M: f64 = 0.0035;
/// A spike is this many times farther off than samples usually are from the line through their neighbours,
/// over half a second about it: some twenty times the jitter of a still marker, and fast motion raises it.
const TIMES_USUAL: f64 = 4.0;
/// How much nearer the curve goes to its own samples than to the spike: a curve that climbs a step from one
/// level to another is off its own samples by a third of what it misses the first one by.
const TIMES_OWN: f64 = 5.0;
/// How much farther off than the line's own samples: a line through a spike misses its samples by a
/// third of the spike.
const TIMES_LINE: f64 = 5.0;
/// Samples on each side that say what is usual.
const ABOUT: usize = 25;

/// Spikes of all labelled markers, in the world: a hand that is flipped does not matter. Linear in
/// the samples.
pub fn spikes(recording: &Recording) -> Vec<Suspect> {
    let labelled = (recording.markers.par_iter().enumerate())
        .filter(|(_, marker)| marker.kind == MarkerKind::Labelled);
    let mut found: Vec<Suspect> = labelled
        .flat_map_iter(|(index, marker)| {
            let spike = move |run: Run| Suspect {
                kind: SuspectKind::Spike {
                    marker: index,
                    name: marker.name.clone(),
                    off_m: run.off_m,
                },
                samples: run.samples,
                score: run.score,
            };
            spikes_in(&marker.track, true).into_iter().map(spike)
        })
        .collect();
    sort(&mut found);
    found
}

/// Orders spikes by time, those of one sample by marker.
pub(super) fn sort(spikes: &mut [Suspect]) {
    spikes.sort_by_key(|spike| {
        let SuspectKind::Spike { marker, .. } = spike.kind else {
            return (spike.samples.start, 0);
        };
        (spike.samples.start, marker)
    });
}

/// A spike of one marker.
#[derive(Clone, Debug)]
pub(crate) struct Run {
    pub(crate) samples: Range<usize>,
    off_m: f64,
    score: f64,
}

/// Spikes of one track, in order, none overlapping another; those beside gaps only if wanted.
pub(crate) fn spikes_in(track: &PointTrack<World>, beside_gaps: bool) -> Vec<Run> {
    let usual = Usual::new(track);
    let mut runs = all_between(track, 2, &usual);
    if beside_gaps {
        // A line through a spike would be none: those found before are set aside each time. Where a
        // single sample is left before a gap, the run is a spike if that sample is not.
        let gaps = track.gaps();
        let mut rest = without(track.clone(), &runs);
        let at_gaps = best_of(at_gaps(&rest, &gaps, &usual));
        rest = without(rest, &at_gaps);
        runs.extend(at_gaps);
        runs.extend(all_between(&rest, 1, &usual));
        runs = best_of(runs);
    }
    runs.sort_by_key(|run| run.samples.start);
    runs
}

/// Runs that the curve through both sides passes, with this many samples on each side at least.
fn all_between(track: &PointTrack<World>, least_side: usize, usual: &Usual) -> Vec<Run> {
    let mut candidates = Vec::new();
    for start in 0..track.len() {
        // Nothing is off where the sample goes on from the one before, which is nearly everywhere.
        if !usual.suspicious(start) {
            continue;
        }
        for len in 1..=MAX_SAMPLES.min(track.len() - start) {
            candidates.extend(between(track, &(start..start + len), least_side, usual));
        }
    }
    best_of(candidates)
}

fn without(mut track: PointTrack<World>, runs: &[Run]) -> PointTrack<World> {
    for k in runs.iter().flat_map(|run| run.samples.clone()) {
        track.set(k, None, Status::Missing);
    }
    track
}

/// The farthest off for their thresholds, none touching another, in order; of equal ones the shorter.
fn best_of(mut candidates: Vec<Run>) -> Vec<Run> {
    candidates.sort_by(|a, b| {
        b.score
            .total_cmp(&a.score)
            .then(a.samples.len().cmp(&b.samples.len()))
    });
    // Those taken lie apart, so that only the nearest on either side can touch another.
    let mut runs: BTreeMap<usize, Run> = BTreeMap::new();
    for run in candidates {
        let Range { start, end } = run.samples;
        let before = runs.range(..start).next_back();
        let after = runs.range(start..).next();
        let apart = before.is_none_or(|(_, other)| other.samples.end < start)
            && after.is_none_or(|(_, other)| end < other.samples.start);
        if apart {
            runs.insert(start, run);
        }
    }
    runs.into_values().collect()
}

/// How far samples usually are from the line through their neighbours.
struct Usual {
    /// Distance of each sample from the line through the two before or after, whichever is nearer.
    off_m: Vec<f64>,
}

impl Usual {
    fn new(track: &PointTrack<World>) -> Self {
        let at = |k: usize| track.get(k).map(Position::coords_m);
        let off_m = (0..track.len()).map(|k| {
            let here = at(k);
            let from = |a: Option<Vector3<f64>>, b: Option<Vector3<f64>>| {
                Some((here? - (a? * 2.0 - b?)).norm())
            };
            let before = (k >= 2).then(|| from(at(k - 1), at(k - 2))).flatten();
            let after = from(at(k + 1), at(k + 2));
            (before.into_iter().chain(after))
                .reduce(f64::max)
                .unwrap_or(f64::NAN)
        });
        Self {
            off_m: off_m.collect(),
        }
    }

    fn suspicious(&self, k: usize) -> bool {
        self.off_m[k] > 0.5 * LEAST_M
    }

    /// Median over half a second about the run.
    fn about(&self, samples: &Range<usize>) -> f64 {
        let from = samples.start.saturating_sub(ABOUT);
        let to = (samples.end + ABOUT).min(self.off_m.len());
        median(self.off_m[from..to].iter().copied())
    }
}

/// The run as a spike between samples on both sides.
fn between(
    track: &PointTrack<World>,
    samples: &Range<usize>,
    least_side: usize,
    usual: &Usual,
) -> Option<Run> {
    let at = |k: usize| track.get(k).map(Position::coords_m);
    let middle = 0.5 * (samples.start + samples.end - 1) as f64;
    let mut side: Vec<(f64, Vector3<f64>)> = Vec::with_capacity(2 * SIDE);
    let timed = |k: usize| Some((k as f64 - middle, at(k)?));
    side.extend((1..=SIDE).map_while(|back| timed(samples.start.checked_sub(back)?)));
    let count_before = side.len();
    side.extend((samples.end..samples.end + SIDE).map_while(timed));
    let count_after = side.len() - count_before;
    if count_before.min(count_after) < least_side || side.len() < 4 {
        return None;
    }
    let [c0, c1, c2] = parabola(&side, true)?;
    let curve = |t: f64| c0 + (c1 + c2 * t) * t;
    let own_m = (side.iter())
        .map(|(t, p)| (curve(*t) - p).norm())
        .fold(0.0, f64::max);
    let (mut least_m, mut most_m) = (f64::INFINITY, 0.0_f64);
    for k in samples.clone() {
        let off_m = (curve(k as f64 - middle) - at(k)?).norm();
        least_m = least_m.min(off_m);
        most_m = most_m.max(off_m);
    }
    let threshold_m = LEAST_M
        .max(TIMES_USUAL * usual.about(samples))
        .max(TIMES_OWN * own_m);
    (least_m >= threshold_m).then(|| Run {
        samples: samples.clone(),
        off_m: most_m,
        score: least_m / threshold_m,
    })
}

/// Runs between a gap and a break.
fn at_gaps(track: &PointTrack<World>, gaps: &[Range<usize>], usual: &Usual) -> Vec<Run> {
    let mut runs = Vec::new();
    for gap in gaps {
        for len in 1..=MAX_SAMPLES {
            let after_gap = gap.end..gap.end + len;
            if after_gap.end < track.len() {
                let line = end_after(track, after_gap.end);
                let beside = after_gap.end - 1;
                runs.extend(broken(track, after_gap, beside, -1.0, line, usual));
            }
            if gap.start > len {
                let before_gap = gap.start - len..gap.start;
                let line = end_before(track, before_gap.start - 1);
                let beside = before_gap.start;
                runs.extend(broken(track, before_gap, beside, 1.0, line, usual));
            }
        }
    }
    runs
}

/// A run beside a gap, if its sample `beside` breaks away from the line of the other side carried on by
/// `step` samples.
fn broken(
    track: &PointTrack<World>,
    samples: Range<usize>,
    beside: usize,
    step: f64,
    line: Option<End>,
    usual: &Usual,
) -> Option<Run> {
    let line = line?;
    let present = samples.clone().all(|k| track.get(k).is_some());
    let expected = line.position_m + line.velocity? * step;
    let off_m = (track.get(beside).filter(|_| present)?.coords_m() - expected).norm();
    let threshold_m = LEAST_BESIDE_GAP_M
        .max(TIMES_USUAL * usual.about(&samples))
        .max(TIMES_LINE * line.misfit_m);
    (off_m >= threshold_m).then(|| Run {
        samples,
        off_m,
        score: off_m / threshold_m,
    })
}
