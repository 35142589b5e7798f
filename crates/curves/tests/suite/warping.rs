//! Time-warped distances and the nearest of many.

use inhand_curves::warping::{Candidates, Nearest, distance_m};
use proptest::prelude::*;

use crate::{motion_reference, number, numbers};

const FREE: usize = usize::MAX;

fn nearest<'a, const D: usize>(
    query: &[[f64; D]],
    candidates: impl IntoIterator<Item = &'a [[f64; D]]>,
    band: usize,
) -> Option<Nearest> {
    Candidates::new(candidates, band).nearest(query)
}

#[test]
fn agree_with_numpy() {
    let reference = motion_reference();
    let warpings = reference["warpings"].as_array().unwrap();
    assert_eq!(warpings.len(), 7);
    for expected in warpings {
        let [a, b] = ["a", "b"].map(|name| numbers(&expected[name]));
        let [a, b] = [&a, &b].map(|flat| flat.as_chunks::<15>().0);
        let band = expected["band"].as_u64().map_or(FREE, |band| band as usize);
        let found = distance_m(a, b, band).unwrap();
        assert!((found - number(&expected["distance_m"])).abs() < 1e-14);
        for (finger, expected) in numbers(&expected["by_finger_m"]).into_iter().enumerate() {
            let tip = |sample: &[f64; 15]| sample.as_chunks::<3>().0[finger];
            let [a, b] = [a, b].map(|path| path.iter().map(tip).collect::<Vec<_>>());
            let found = distance_m(&a, &b, band).unwrap();
            assert!((found - expected).abs() < 1e-14, "{finger}");
        }
    }
}

#[test]
fn closed_forms() {
    // Band 0 on the same number of samples is the mean distance.
    let a = [[0.0], [1.0], [2.0]];
    let b = [[0.5], [1.5], [3.0]];
    assert_eq!(distance_m(&a, &b, 0), Some(2.0 / 3.0));
    // One sample against three is matched with each: weights 2, 1 and 1 of 4.
    assert_eq!(
        distance_m(&[[0.0]], &[[1.0], [2.0], [4.0]], FREE),
        Some(2.0)
    );
    // A jump of 2 between rests: each side waits for the other, no distance.
    let early = [[0.0], [2.0], [2.0], [2.0]];
    let late = [[0.0], [0.0], [0.0], [2.0]];
    assert_eq!(distance_m(&early, &late, FREE), Some(0.0));
    assert_eq!(distance_m(&early, &late, 2), Some(0.0));
    // With a window of one sample one pair 2 apart cannot be avoided, reached diagonally: weight 2 of 8.
    assert_eq!(distance_m(&early, &late, 1), Some(4.0 / 8.0));
}

#[test]
fn what_cannot_be_matched_has_no_distance() {
    let a = [[0.0, 1.0], [1.0, 1.0]];
    assert_eq!(distance_m(&a, &[], FREE), None);
    assert_eq!(distance_m::<2>(&[], &[], FREE), None);
    assert_eq!(distance_m(&a, &[[f64::NAN, 0.0]], FREE), None);
    assert_eq!(distance_m(&a, &[[0.0, 0.0]; 5], 2), None);
    assert!(distance_m(&a, &[[0.0, 0.0]; 5], 3).is_some());
    assert!(distance_m(&a, &[[0.0, 0.0]; 5], usize::MAX).is_some());

    let none: [&[[f64; 2]]; 0] = [];
    assert_eq!(nearest(&a, none, FREE), None);
    let bad: [&[[f64; 2]]; 2] = [&[], &[[f64::INFINITY, 0.0]]];
    assert_eq!(nearest(&a, bad, FREE), None);
    assert_eq!(nearest(&[[f64::NAN; 2]], [&a[..]], FREE), None);
    // The first of those equally near, however they are ruled out.
    let far = [[5.0, 5.0], [6.0, 6.0]];
    let found = nearest(&a, [&far[..], &a[..], &a[..]], FREE);
    assert_eq!(
        found,
        Some(Nearest {
            index: 1,
            distance_m: 0.0
        })
    );
}

fn walks(count: std::ops::Range<usize>) -> impl Strategy<Value = Vec<Vec<[f64; 2]>>> {
    let walk = (
        -2.0..2.0,
        prop::collection::vec((-0.5..0.5, -0.5..0.5), 1..14),
    );
    prop::collection::vec(walk, count).prop_map(|walks| {
        let walk = |(start, steps): (f64, Vec<(f64, f64)>)| {
            let mut at = [start, -start];
            let step = |(x, y): (f64, f64)| {
                at = [at[0] + x, at[1] + y];
                at
            };
            steps.into_iter().map(step).collect()
        };
        walks.into_iter().map(walk).collect()
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn symmetric_and_never_farther_than_without_warping(walks in walks(2..3), band in 0..14_usize) {
        let (a, b) = (&walks[0], &walks[1]);
        let free = distance_m(a, b, FREE).unwrap();
        prop_assert!((free - distance_m(b, a, FREE).unwrap()).abs() < 1e-12);
        prop_assert_eq!(distance_m(a, a, FREE), Some(0.0));
        let banded = distance_m(a, b, band);
        prop_assert_eq!(banded.is_some(), a.len().abs_diff(b.len()) <= band);
        prop_assert!(banded.is_none_or(|banded| banded >= free));
        prop_assert_eq!(distance_m(a, b, 14), Some(free));
    }

    /// Ruling out changes nothing, to the last bit, ties included.
    #[test]
    fn nearest_agrees_with_computing_all(
        mut walks in walks(3..24),
        repeats in 1..6_usize,
        band in prop_oneof![0..10_usize, Just(FREE)],
    ) {
        // Long enough for several blocks, every other one as long as the query.
        let length = repeats * walks[0].len();
        for (n, walk) in walks.iter_mut().enumerate() {
            let length = if n % 2 == 0 { length } else { repeats * walk.len() };
            *walk = walk.iter().copied().cycle().take(length).collect();
        }
        let copy = walks[2].clone();
        walks.push(copy);
        let (query, candidates) = walks.split_first().unwrap();
        let mut expected: Option<Nearest> = None;
        for (index, candidate) in candidates.iter().enumerate() {
            let Some(distance_m) = distance_m(query, candidate, band) else { continue };
            if expected.is_none_or(|best| distance_m < best.distance_m) {
                expected = Some(Nearest { index, distance_m });
            }
        }
        let found = nearest(query, candidates.iter().map(Vec::as_slice), band);
        prop_assert_eq!(found, expected);
    }
}
