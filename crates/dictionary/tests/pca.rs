//! Principal components.

use inhand_dictionary::{activations, learn_pca};
use inhand_model::{Dictionary, DictionaryKind, StopReason};
use nalgebra::DMatrix;
use serde_json::Value;

use crate::segments::{demonstrated, motion, segments};

fn learn(columns: DMatrix<f64>, rank: usize) -> Dictionary {
    learn_pca(&segments(columns), demonstrated(), rank).unwrap()
}

pub(crate) fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(values) => values.iter().flat_map(numbers).collect(),
        other => vec![other.as_f64().unwrap()],
    }
}

pub(crate) fn reference(part: &str) -> Value {
    serde_json::from_str::<Value>(include_str!("reference/reference.json")).unwrap()[part].clone()
}

#[test]
fn agrees_with_scikit_learn() {
    let r = reference("pca");
    let dictionary = learn(DMatrix::from_vec(15, 8, numbers(&r["data"])), 3);
    let close = |found: &[f64], part: &str| {
        let expected = numbers(&r[part]);
        assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(expected) {
            assert!(
                (found - expected).abs() < 1e-10,
                "{part}: {found} {expected}"
            );
        }
    };
    close(dictionary.offset_m.as_slice(), "mean");
    close(dictionary.primitives.as_slice(), "primitives");
    close(
        dictionary.activation_covariance_m2.diagonal().as_slice(),
        "variances",
    );
}

#[test]
fn agrees_with_the_singular_values_on_both_sides() {
    // More rows than columns, more columns than rows, more columns than a block.
    for (samples, count, rank) in [(4, 25, 6), (1, 80, 6), (1, 2100, 6)] {
        let columns = motion(samples, count);
        let dictionary = learn(columns.clone(), rank);
        dictionary.validate().unwrap();
        assert_eq!(dictionary.kind, DictionaryKind::Pca);
        assert_eq!(dictionary.learning.stop_reason, StopReason::ClosedForm);
        let gram = dictionary.primitives.transpose() * &dictionary.primitives;
        assert!((gram - DMatrix::identity(rank, rank)).amax() < 1e-13);

        let mean = columns.column_mean();
        let centred = DMatrix::from_fn(columns.nrows(), count, |r, c| columns[(r, c)] - mean[r]);
        let mut singular: Vec<f64> = centred.singular_values().iter().copied().collect();
        singular.sort_by(|a, b| b.total_cmp(a));
        for (j, s) in singular.iter().take(rank).enumerate() {
            let variance = dictionary.activation_covariance_m2[(j, j)];
            assert!((variance - s * s / count as f64).abs() < 1e-10 * variance);
        }
        // Eckart and Young: what is left are the other singular values.
        let left: f64 = singular.iter().skip(rank).map(|s| s * s).sum();
        let rms = (left / centred.len() as f64).sqrt();
        assert!((dictionary.learning.rms_m - rms).abs() < 1e-9 * rms);
    }
}

#[test]
fn at_full_rank_segments_come_back() {
    let columns = motion(3, 10);
    let dictionary = learn(columns.clone(), 9);
    assert!(dictionary.learning.relative_error < 1e-10);
    for column in columns.column_iter() {
        let h = activations(&dictionary, column.clone_owned().as_slice()).unwrap();
        let back = &dictionary.offset_m + &dictionary.primitives * h;
        assert!((back - column).amax() < 1e-12);
    }
}
