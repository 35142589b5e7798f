//! Folds: groups of segments that are predicted from the others.

use std::collections::BTreeMap;

use inhand_model::SegmentOrigin;

/// Most groups of takes.
const MOST_FOLDS: usize = 8;
/// Intervals of a single take that are left out in turn.
const INTERVALS: usize = 5;
/// Most segments predicted, over all groups.
const MOST_SEGMENTS: usize = 600;

/// One group of segments that is predicted from others.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fold {
    /// Segments to learn from.
    pub known: Vec<usize>,
    /// Segments to predict: none overlaps another, or one of `known`.
    pub left_out: Vec<usize>,
}

/// Groups of segments for cross-validation, from where each segment starts and how many samples it
/// has. Groups by take; with a single take, intervals of it, and segments that reach into the left-out
/// interval are in neither list. Groups without a segment on one side are dropped.
pub fn folds(origins: &[SegmentOrigin], samples: usize) -> Vec<Fold> {
    let mut takes: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (segment, origin) in origins.iter().enumerate() {
        takes.entry(origin.take).or_default().push(segment);
    }
    let mut folds = if takes.len() > 1 {
        by_take(&takes)
    } else {
        by_interval(origins, samples)
    };
    for fold in &mut folds {
        fold.left_out = apart(&fold.left_out, origins, samples);
    }
    folds.retain(|fold| !fold.known.is_empty() && !fold.left_out.is_empty());
    thin(&mut folds);
    folds
}

fn by_take(takes: &BTreeMap<usize, Vec<usize>>) -> Vec<Fold> {
    let count = takes.len().min(MOST_FOLDS);
    (0..count)
        .map(|fold| {
            let (mut known, mut left_out) = (Vec::new(), Vec::new());
            for (i, segments) in takes.values().enumerate() {
                let list = if i % count == fold {
                    &mut left_out
                } else {
                    &mut known
                };
                list.extend_from_slice(segments);
            }
            known.sort_unstable();
            Fold { known, left_out }
        })
        .collect()
}

fn by_interval(origins: &[SegmentOrigin], samples: usize) -> Vec<Fold> {
    let starts = || origins.iter().map(|origin| origin.start);
    let (Some(first), Some(last)) = (starts().min(), starts().max()) else {
        return Vec::new();
    };
    let length = (last + samples - first).div_ceil(INTERVALS);
    (0..INTERVALS)
        .map(|i| {
            let (from, to) = (first + i * length, first + (i + 1) * length);
            let inside = |start: usize| start >= from && start + samples <= to;
            let outside = |start: usize| start + samples <= from || start >= to;
            let those = |test: &dyn Fn(usize) -> bool| {
                let segments = origins.iter().enumerate();
                (segments.filter(|(_, origin)| test(origin.start)))
                    .map(|(segment, _)| segment)
                    .collect()
            };
            Fold {
                known: those(&outside),
                left_out: those(&inside),
            }
        })
        .collect()
}

/// The segments in order of time, without those that overlap the one before.
pub(super) fn apart(segments: &[usize], origins: &[SegmentOrigin], samples: usize) -> Vec<usize> {
    let mut ordered = segments.to_vec();
    ordered.sort_by_key(|&segment| (origins[segment].take, origins[segment].start));
    let mut kept: Vec<usize> = Vec::new();
    for segment in ordered {
        let clear = kept.last().is_none_or(|&last| {
            origins[last].take != origins[segment].take
                || origins[last].start + samples <= origins[segment].start
        });
        if clear {
            kept.push(segment);
        }
    }
    kept
}

/// Keeps every k-th segment of each group, so that the work has a bound.
fn thin(folds: &mut [Fold]) {
    let total: usize = folds.iter().map(|fold| fold.left_out.len()).sum();
    let step = total.div_ceil(MOST_SEGMENTS).max(1);
    for fold in folds {
        fold.left_out = fold.left_out.iter().copied().step_by(step).collect();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn origins(takes: usize, per_take: usize, stride: usize) -> Vec<SegmentOrigin> {
        (0..takes)
            .flat_map(|take| {
                (0..per_take).map(move |i| SegmentOrigin {
                    take,
                    start: i * stride,
                })
            })
            .collect()
    }

    #[test]
    fn takes_are_left_out_whole() {
        let origins = origins(3, 20, 10);
        let folds = folds(&origins, 100);
        assert_eq!(folds.len(), 3);
        for (take, fold) in folds.iter().enumerate() {
            assert!(fold.known.iter().all(|&s| origins[s].take != take));
            assert_eq!(fold.known.len(), 40);
            // Starts 0 and 100 of 0, 10, .., 190.
            let starts: Vec<_> = fold.left_out.iter().map(|&s| origins[s].start).collect();
            assert_eq!(starts, [0, 100]);
        }
    }

    #[test]
    fn intervals_of_one_take_share_no_sample() {
        let origins = origins(1, 200, 7);
        let folds = folds(&origins, 100);
        assert_eq!(folds.len(), INTERVALS);
        for fold in &folds {
            for &left_out in &fold.left_out {
                for &known in &fold.known {
                    assert!(origins[left_out].start.abs_diff(origins[known].start) >= 100);
                }
            }
        }
    }

    #[test]
    fn too_little_to_leave_anything_out_gives_no_fold() {
        assert!(folds(&origins(1, 1, 1), 100).is_empty());
        assert!(folds(&[], 100).is_empty());
    }

    #[test]
    fn many_segments_are_thinned() {
        let folds = folds(&origins(20, 120, 100), 100);
        assert_eq!(folds.len(), MOST_FOLDS);
        let total: usize = folds.iter().map(|fold| fold.left_out.len()).sum();
        assert_eq!(total, MOST_SEGMENTS);
    }
}
