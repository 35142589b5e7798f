//! A label that visits another finger while that finger's own label is lost.
//!
//! Such a swap begins and ends inside one gap of the other label, so that there is no instant at which
//! the motions of both are joined crosswise. What there is: the visitor jumps away and back, its own
//! finger's motion goes on across the visit, and the other finger's motion leads through it.

use std::ops::Range;

use inhand_model::{Finger, Hand, PointTrack};

use super::swaps::Swap;
use crate::continuity::{UsualJumps, end_after, end_before};

/// Longest visit, samples at any rate that matter: seconds times rate are given by the caller.
pub(super) struct Visits<'a> {
    pub(super) usual: &'a UsualJumps,
    /// Longest visit, samples.
    pub(super) longest: usize,
    /// What a change of labels costs, nats.
    pub(super) change_nats: f64,
}

impl Visits<'_> {
    /// Visits among labels that are otherwise on their own fingers; `breaks` are the samples at which
    /// each label jumps, ascending.
    pub(super) fn find(&self, labels: &[PointTrack<Hand>], breaks: &[Vec<usize>]) -> Vec<Swap> {
        let mut found: Vec<Swap> = Vec::new();
        for (visitor, track) in labels.iter().enumerate() {
            for interval in pieces(track, &breaks[visitor], self.longest) {
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
        Some(kept - visiting - 2.0 * self.change_nats)
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
