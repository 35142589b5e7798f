//! Quantiles and summaries.

use inhand_model::Statistics;
use inhand_statistics::quantiles::{quantile, statistics};
use proptest::prelude::*;

use crate::{number, numbers, reference};

/// Every field that is a length, by name.
fn lengths(s: &Statistics) -> [(&'static str, f64); 11] {
    [
        ("mean", s.mean),
        ("rmse", s.rmse),
        ("min", s.min),
        ("p5", s.p5),
        ("p25", s.p25),
        ("p50", s.p50),
        ("p75", s.p75),
        ("p95", s.p95),
        ("max", s.max),
        ("whisker_low", s.whisker_low),
        ("whisker_high", s.whisker_high),
    ]
}

#[test]
fn agree_with_numpy() {
    let reference = reference();
    let distributions = reference["distributions"].as_array().unwrap();
    assert_eq!(distributions.len(), 8);
    for expected in distributions {
        let values = numbers(&expected["values"]);
        for (field, found) in lengths(&statistics(values.clone(), 0, 0)) {
            let expected = number(&expected[field]);
            assert!(
                (found - expected).abs() <= 1e-14 * expected.abs().max(1.0),
                "{field} of {values:?}: {found}, expected {expected}"
            );
        }
    }
}

#[test]
fn nothing_has_no_quantile() {
    assert_eq!(quantile(&[], 0.5), None);
    for q in [-0.001, 1.001, f64::NAN] {
        assert_eq!(quantile(&[1.0, 2.0], q), None, "{q}");
    }
    assert_eq!(quantile(&[4.0], 0.3), Some(4.0));
    assert_eq!(quantile(&[1.0, 2.0], 0.0), Some(1.0));
    assert_eq!(quantile(&[1.0, 2.0], 1.0), Some(2.0));
}

#[test]
fn a_summary_of_no_numbers_is_no_number() {
    for (values, n) in [
        (vec![], 0),
        (vec![1.0, f64::NAN, 2.0], 3),
        (vec![1.0, f64::INFINITY], 2),
    ] {
        let summary = statistics(values, 2, 5);
        assert_eq!((summary.n, summary.n_filled, summary.n_left_out), (n, 2, 5));
        assert!(lengths(&summary).iter().all(|(_, value)| value.is_nan()));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    /// Selecting gives what sorting gives, to the last bit, ties and signed zeros included.
    #[test]
    fn selection_agrees_with_a_full_sort(
        values in prop::collection::vec(prop_oneof![-1.0..1.0, Just(0.0), Just(-0.0), Just(0.5)], 1..200)
    ) {
        let mut sorted = values.clone();
        sorted.sort_by(f64::total_cmp);
        let s = statistics(values, 0, 0);
        for (q, found) in [(0.05, s.p5), (0.25, s.p25), (0.5, s.p50), (0.75, s.p75), (0.95, s.p95)] {
            prop_assert_eq!(Some(found.to_bits()), quantile(&sorted, q).map(f64::to_bits));
        }
        let ascending = [s.min, s.p5, s.p25, s.p50, s.p75, s.p95, s.max];
        prop_assert!(ascending.is_sorted());
        prop_assert!(sorted.contains(&s.whisker_low) && sorted.contains(&s.whisker_high));
        prop_assert!(s.rmse >= s.mean.abs() - 1e-15);
    }
}
