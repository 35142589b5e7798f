//! Explained variance against NumPy (`reference/make_explained.py`) and against what dictionaries leave.

use inhand_dictionary::{explained_variance, learn_pca};
use nalgebra::DMatrix;
use serde_json::Value;

use crate::pca::numbers;
use crate::segments::{demonstrated, motion, segments};

#[test]
fn agrees_with_numpy() {
    let cases: Value = serde_json::from_str(include_str!("reference/explained.json")).unwrap();
    for case in cases.as_array().unwrap() {
        let rows = case["rows"].as_u64().unwrap() as usize;
        let columns = numbers(&case["columns"]);
        let count = columns.len() / rows;
        let segments = segments(DMatrix::from_vec(rows, count, columns));
        let ranks: Vec<usize> = (1..=rows.min(count - 1)).collect();
        let rms_m = case["rms"].as_f64().unwrap();
        let explained = explained_variance(&segments, &ranks, (4, rms_m)).unwrap();

        assert_eq!(explained.segments, count);
        assert_eq!(explained.principal.len(), ranks.len());
        let expected = numbers(&case["share"]);
        for (rank, share) in explained.principal {
            assert!(
                (share - expected[rank - 1]).abs() < 1e-12,
                "{rank}: {share}"
            );
        }
        let (rank, share) = explained.learned;
        assert_eq!(rank, 4);
        assert!((share - case["learned"].as_f64().unwrap()).abs() < 1e-12);
    }
}

/// A dictionary of principal components is the best of its rank; one as bad as the mean explains nothing.
#[test]
fn dictionaries_stand_on_the_curve() {
    let segments = segments(motion(4, 25));
    let dictionary = learn_pca(&segments, demonstrated(), 5).unwrap();
    let explained = explained_variance(&segments, &[5], (5, dictionary.learning.rms_m)).unwrap();
    assert!((explained.principal[0].1 - explained.learned.1).abs() < 1e-12);

    let columns = segments.columns_m();
    let mean = columns.column_mean();
    let squares: f64 = (columns.column_iter())
        .map(|column| (column - &mean).norm_squared())
        .sum();
    let rms_m = (squares / columns.len() as f64).sqrt();
    let explained = explained_variance(&segments, &[], (1, rms_m)).unwrap();
    assert!(explained.learned.1.abs() < 1e-12);
    assert!(explained.principal.is_empty());
}

#[test]
fn ranks_that_segments_do_not_have_are_left_out() {
    let segments = segments(motion(4, 8));
    let explained = explained_variance(&segments, &[0, 3, 7, 8, 200], (2, 1e-3)).unwrap();
    let ranks: Vec<usize> = explained.principal.iter().map(|(rank, _)| *rank).collect();
    assert_eq!(ranks, [3, 7]);
    assert!((explained.principal[1].1 - 1.0).abs() < 1e-12);
}

#[test]
fn missing_numbers_are_no_variance() {
    let mut columns = motion(4, 8);
    columns[(3, 2)] = f64::NAN;
    let found = explained_variance(&segments(columns), &[1], (1, 0.0));
    let error = found.unwrap_err().to_string();
    assert!(error.starts_with("training segment 2 "), "{error}");
}
