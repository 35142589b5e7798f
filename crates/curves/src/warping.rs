//! Dynamic time warping: how far two motions are apart when they need not keep the same pace.
//!
//! The symmetric form of H. Sakoe and S. Chiba, *Dynamic programming algorithm optimization for spoken
//! word recognition*, IEEE Trans. ASSP 26(1), 1978 (table I, symmetric, P = 0). With `d(i, j)` the
//! Euclidean distance of sample i of one motion and sample j of the other, N and M samples:
//!
//! ```text
//! g(0, 0) = 2 d(0, 0)
//! g(i, j) = min( g(i-1, j) + d(i, j),  g(i-1, j-1) + 2 d(i, j),  g(i, j-1) + d(i, j) )
//! D       = g(N-1, M-1) / (N + M)
//! ```
//!
//! Every path from corner to corner has weight N + M in all, so that `D` is a weighted mean distance
//! along the path, in metres, that does not grow with length, and the smallest sum is also the smallest
//! mean. With weight 1 for every step (as in tslearn) neither holds: dividing that sum by the length of
//! its path gives the mean along a path which was not chosen for its mean. Distances are not squared.
//! Weights belong to the pair that a step leads to, so that both motions backwards can differ a little.
//!
//! A sample is an array of `D` coordinates in metres: 3 for one fingertip, 15 for a
//! configuration, where `d` is the root of the summed squares over the fingers.

use std::cell::OnceCell;

/// A lower bound is a sum of as many terms as the distance but in another order; only one this much
/// beyond, relatively, rules a candidate out. Rounding of sums of 1e5 terms stays below.
const BOUND_ROUNDING: f64 = 1e-9;

/// Samples that the quick bound takes together.
const BLOCK: usize = 25;

/// More than rounding can do to the sum of a block, relatively: the quick bound is a difference of sums.
const SUM_ROUNDING: f64 = 1e-12;

/// The nearest of several motions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// Its place among the candidates; the first of those equally near.
    pub index: usize,
    /// Its [`distance_m`], metres.
    pub distance_m: f64,
}

/// Normalised time-warped distance `D` of two motions, metres (see the [module](self)).
///
/// Only pairs with `|i - j| <= band` (samples; Sakoe and Chiba's adjustment window) are matched: band 0
/// compares sample by sample, `usize::MAX` all with all.
///
/// `None` if one of them is empty, a coordinate is not finite, or they differ in length by more than the
/// band, so that no path stays in it. Time O(N M), memory O(M).
///
/// ```
/// use inhand_curves::warping::distance_m;
///
/// // The same way, the second with a pause: no distance once time is warped.
/// let steady = [[0.00], [0.01], [0.02], [0.03]];
/// let paused = [[0.00], [0.01], [0.01], [0.01], [0.02], [0.03]];
/// assert_eq!(distance_m(&steady, &paused, usize::MAX), Some(0.0));
/// // 1 mm aside throughout is 1 mm.
/// let aside = steady.map(|[x]| [x, 0.001]);
/// let steady = steady.map(|[x]| [x, 0.0]);
/// assert!((distance_m(&steady, &aside, usize::MAX).unwrap() - 0.001).abs() < 1e-15);
/// ```
pub fn distance_m<const D: usize>(a: &[[f64; D]], b: &[[f64; D]], band: usize) -> Option<f64> {
    if !are_sound(a) || !are_sound(b) {
        return None;
    }
    sum_up_to(a, b, band, f64::INFINITY).map(|sum| sum / (a.len() + b.len()) as f64)
}

/// Motions among which the nearest to others is searched, made ready once; the result is that of computing
/// [`distance_m`] of all.
///
/// Most are ruled out early: by two lower bounds, a quick and a close one, and by leaving a comparison once no
/// path through it can be as short as the best one. Both bounds split the weight 2 of a diagonal step into 1 for
/// the new row and 1 for the new column. Then each sample of either motion is charged once with its distance to
/// some sample of the other inside the band.
///
/// * The close bound (after E. Keogh and C. A. Ratanamahatana, *Exact indexing of dynamic time warping*, Knowl.
///   Inf. Syst. 7, 2005): that distance is at least the one to the box around all samples inside the band.
/// * The quick bound, of motions of the same length: that distance is at least the one to the sample of the same
///   time, less the farthest that the other motion moves inside the band about it. Summed over a block of samples
///   it is at least twice the distance of the two sums over the block, less what both motions move there.
///
/// ```
/// use inhand_curves::warping::Candidates;
///
/// let (far, near) = ([[0.05], [0.06], [0.07]], [[0.01], [0.02], [0.03]]);
/// let candidates = Candidates::new([&far[..], &near[..]], 1);
/// let found = candidates.nearest(&[[0.01], [0.02], [0.04]]).unwrap();
/// assert_eq!(found.index, 1);
/// // The last pair is 10 mm apart and has weight 2 of 6.
/// assert!((found.distance_m - 0.01 / 3.0).abs() < 1e-15);
/// ```
#[derive(Clone, Debug)]
pub struct Candidates<'a, const D: usize> {
    sound: Vec<Candidate<'a, D>>,
    band: usize,
}

#[derive(Clone, Debug)]
struct Candidate<'a, const D: usize> {
    index: usize,
    samples: &'a [[f64; D]],
    boxes: Boxes<'a, D>,
    blocks: Vec<Block<D>>,
}

impl<'a, const D: usize> Candidates<'a, D> {
    /// Makes candidates ready. One without samples, or with a coordinate that is not finite, is near to nothing.
    pub fn new(candidates: impl IntoIterator<Item = &'a [[f64; D]]>, band: usize) -> Self {
        let sound = (candidates.into_iter().enumerate())
            .filter(|(_, samples)| are_sound(samples))
            .map(|(index, samples)| Candidate {
                index,
                samples,
                boxes: Boxes::around(samples, band),
                blocks: blocks(samples, band),
            })
            .collect();
        Self { sound, band }
    }

    /// The one nearest to `query`; `None` where none has a distance to it.
    pub fn nearest(&self, query: &[[f64; D]]) -> Option<Nearest> {
        if !are_sound(query) {
            return None;
        }
        let of_query = OnceCell::new();
        let blocks = blocks(query, self.band);
        let fits = |candidate: &&Candidate<'a, D>| {
            query.len().abs_diff(candidate.samples.len()) <= self.band
        };
        let mut left: Vec<(f64, &Candidate<'a, D>)> = (self.sound.iter().filter(fits))
            .map(|candidate| {
                let weight = (query.len() + candidate.samples.len()) as f64;
                let same_times = query.len() == candidate.samples.len();
                let bound = if same_times {
                    quick_bound(&blocks, &candidate.blocks)
                } else {
                    0.0
                };
                (bound / weight, candidate)
            })
            .collect();
        let mut best: Option<Nearest> = None;
        // Most are ruled out by the first one: they are not worth the time to sort.
        while let Some(next) = (0..left.len()).min_by(|&a, &b| left[a].0.total_cmp(&left[b].0)) {
            let (_, candidate) = left.swap_remove(next);
            let best_m = best.map_or(f64::INFINITY, |best| best.distance_m);
            let samples = candidate.samples;
            let weight = (query.len() + samples.len()) as f64;
            // Rounded up, so that multiplying by the weight cannot rule out an equal.
            let limit = best_m * weight * (1.0 + BOUND_ROUNDING);
            if limit.is_finite() {
                let one_way = candidate.boxes.distance_m(query, limit);
                let of_query = of_query.get_or_init(|| Boxes::around(query, self.band));
                if one_way > limit || one_way + of_query.distance_m(samples, limit) > limit {
                    continue;
                }
            }
            let Some(sum) = sum_up_to(query, samples, self.band, limit) else {
                continue;
            };
            let (index, distance_m) = (candidate.index, sum / weight);
            let is_first = best.is_none_or(|best| index < best.index);
            if distance_m < best_m || (distance_m == best_m && is_first) {
                best = Some(Nearest { index, distance_m });
                left.retain(|(bound_m, _)| *bound_m <= distance_m * (1.0 + BOUND_ROUNDING));
            }
        }
        best
    }
}

/// Smallest and largest coordinates.
type CoordinateRange<const D: usize> = ([f64; D], [f64; D]);

/// Smallest and largest coordinates of the samples that each sample of another motion may be matched with.
#[derive(Clone, Debug)]
struct Boxes<'a, const D: usize> {
    samples: &'a [[f64; D]],
    band: usize,
    /// By the sample of the other motion, as far as it is about as long.
    boxes: Vec<CoordinateRange<D>>,
}

impl<'a, const D: usize> Boxes<'a, D> {
    fn around(samples: &'a [[f64; D]], band: usize) -> Self {
        // Of each sample, with room before and after the motion; then of twice as many samples from each on, until
        // two of them overlap to the whole window.
        let (n, reach) = (samples.len(), band.min(samples.len()));
        let mut boxes = vec![around(&[]); n + 3 * reach];
        for (own, sample) in boxes[reach..].iter_mut().zip(samples) {
            *own = (*sample, *sample);
        }
        let (width, mut span) = (2 * reach + 1, 1);
        while 2 * span <= width {
            join_ahead(&mut boxes, span);
            span *= 2;
        }
        join_ahead(&mut boxes, width - span);
        boxes.truncate(n + reach);
        Self {
            samples,
            band,
            boxes,
        }
    }

    /// Sum of the distances of the samples of another motion to their boxes, metres; whatever it has come to
    /// once it is beyond `limit`.
    fn distance_m(&self, other: &[[f64; D]], limit: f64) -> f64 {
        let mut sum = 0.0;
        for (i, sample) in other.iter().enumerate() {
            let (low, high) = (self.boxes.get(i).copied())
                .unwrap_or_else(|| around(&self.samples[window(i, self.samples.len(), self.band)]));
            let nearest = std::array::from_fn(|k| sample[k].max(low[k]).min(high[k]));
            sum += between_m(sample, &nearest);
            if sum > limit {
                break;
            }
        }
        sum
    }
}

/// Some neighbouring samples of a motion taken together.
#[derive(Clone, Debug)]
struct Block<const D: usize> {
    /// Sum of the samples.
    sum: [f64; D],
    /// Sum of how far the motion gets from each of them inside the band, and what rounding can do to `sum`.
    moved_m: f64,
}

fn blocks<const D: usize>(samples: &[[f64; D]], band: usize) -> Vec<Block<D>> {
    let n = samples.len();
    let mut moved_m2 = vec![0.0; n];
    for i in 0..n {
        for j in i + 1..window(i, n, band).end {
            let moved = between_m2(&samples[i], &samples[j]);
            moved_m2[i] = larger(moved_m2[i], moved);
            moved_m2[j] = larger(moved_m2[j], moved);
        }
    }
    (0..n)
        .step_by(BLOCK)
        .map(|start| {
            let end = (start + BLOCK).min(n);
            let mut sum = [0.0; D];
            for sample in &samples[start..end] {
                sum = std::array::from_fn(|k| sum[k] + sample[k]);
            }
            Block {
                sum,
                moved_m: moved_m2[start..end].iter().map(|m2| m2.sqrt()).sum::<f64>()
                    + SUM_ROUNDING * between_m(&sum, &[0.0; D]),
            }
        })
        .collect()
}

/// The quick bound of two motions of the same length, as the weighted sum of a path, metres.
fn quick_bound<const D: usize>(a: &[Block<D>], b: &[Block<D>]) -> f64 {
    (a.iter().zip(b))
        .map(|(a, b)| (2.0 * between_m(&a.sum, &b.sum) - a.moved_m - b.moved_m).max(0.0))
        .sum()
}

fn are_sound<const D: usize>(samples: &[[f64; D]]) -> bool {
    !samples.is_empty() && samples.iter().flatten().all(|x| x.is_finite())
}

fn between_m<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    between_m2(a, b).sqrt()
}

/// Squared, in square metres.
fn between_m2<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

/// Samples of the other motion that sample `i` may be matched with.
fn window(i: usize, other: usize, band: usize) -> std::ops::Range<usize> {
    let end = i.saturating_add(band).saturating_add(1).min(other);
    i.saturating_sub(band).min(end)..end
}

/// The least weighted sum `g(N-1, M-1)`; `None` if every path is longer than `limit`, or there is none.
fn sum_up_to<const D: usize>(
    a: &[[f64; D]],
    b: &[[f64; D]],
    band: usize,
    limit: f64,
) -> Option<f64> {
    let mut before = vec![f64::INFINITY; b.len()];
    let mut now = before.clone();
    for (i, sample) in a.iter().enumerate() {
        now.fill(f64::INFINITY);
        let mut least = f64::INFINITY;
        for j in window(i, b.len(), band) {
            let step = between_m(sample, &b[j]);
            let diagonal = match (i, j) {
                (0, 0) => 0.0,
                (0, _) | (_, 0) => f64::INFINITY,
                _ => before[j - 1],
            };
            let left = if j > 0 { now[j - 1] } else { f64::INFINITY };
            let from_before = smaller(diagonal + 2.0 * step, before[j] + step);
            now[j] = smaller(left + step, from_before);
            least = smaller(now[j], least);
        }
        // Sums only grow along a path, and every path goes through this row.
        if least > limit {
            return None;
        }
        std::mem::swap(&mut before, &mut now);
    }
    (before.last().copied()).filter(|&sum| sum.is_finite() && sum <= limit)
}

/// Smallest and largest coordinates of samples.
fn around<const D: usize>(samples: &[[f64; D]]) -> CoordinateRange<D> {
    let start = ([f64::INFINITY; D], [f64::NEG_INFINITY; D]);
    samples
        .iter()
        .fold(start, |range, sample| joined(&range, &(*sample, *sample)))
}

fn joined<const D: usize>(a: &CoordinateRange<D>, b: &CoordinateRange<D>) -> CoordinateRange<D> {
    (
        std::array::from_fn(|k| smaller(a.0[k], b.0[k])),
        std::array::from_fn(|k| larger(a.1[k], b.1[k])),
    )
}

/// Joins each range with the one this many places after it, as that was before.
fn join_ahead<const D: usize>(ranges: &mut [CoordinateRange<D>], places: usize) {
    for i in places..ranges.len() {
        ranges[i - places] = joined(&ranges[i - places], &ranges[i]);
    }
}

/// The larger of two numbers, neither of which is NaN: one instruction, unlike [`f64::max`].
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The smaller one, likewise.
fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}
