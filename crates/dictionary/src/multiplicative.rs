//! Multiplicative updates (Lee and Seung 2001), for comparison with older work.

use rayon::prelude::*;

use crate::matrix_view::{View, chunk_width, multiply};
use crate::real::Real;
use crate::settings::Penalty;

/// What a zero denominator is replaced by: the single-precision machine epsilon, as scikit-learn
/// does, so that the two can be compared number by number.
const ZERO_DENOMINATOR: f64 = f32::EPSILON as f64;

/// One update `x <- x * p / (G x + l1 + l2 x)`, element by element, of every column of `factor`
/// (`rank` x count) with the Gram matrix `gram` (`rank` x `rank`) and the linear terms `linear` (as
/// `factor`); `l1` and `l2` are those of the penalty. Numbers that are zero stay zero.
pub(crate) fn update_all<T: Real>(
    gram: &[T],
    linear: &[T],
    penalty: Penalty,
    factor: &mut [T],
    rank: usize,
) {
    let width = chunk_width(factor.len() / rank.max(1));
    factor
        .par_chunks_mut(width * rank)
        .zip(linear.par_chunks(width * rank))
        .for_each(|(factor, linear)| update(gram, linear, penalty, factor, rank));
}

/// The update of [`update_all`] for one chunk of columns.
pub(crate) fn update<T: Real>(
    gram: &[T],
    linear: &[T],
    penalty: Penalty,
    factor: &mut [T],
    rank: usize,
) {
    let (l1, l2) = (T::of(penalty.l1), T::of(penalty.l2));
    let mut denominator = vec![T::ZERO; factor.len()];
    multiply(
        View::columns(gram, rank),
        View::columns(factor, rank),
        &mut denominator,
    );
    for ((x, p), d) in factor.iter_mut().zip(linear).zip(denominator) {
        let d = d + (l1 + l2 * *x);
        *x *= *p
            / if d == T::ZERO {
                T::of(ZERO_DENOMINATOR)
            } else {
                d
            };
    }
}

#[cfg(test)]
mod tests {
    use serde_json::Value;

    use super::update_all;
    use crate::matrix_view::View;
    use crate::packed::Packed;
    use crate::product::{cross, gram};
    use crate::settings::Penalty;

    fn numbers(value: &Value) -> Vec<f64> {
        match value {
            Value::Array(values) => values.iter().flat_map(numbers).collect(),
            other => vec![other.as_f64().unwrap()],
        }
    }

    #[test]
    fn penalised_updates_agree_with_scikit_learn() {
        let text = include_str!("../tests/reference/reference.json");
        let reference: Value = serde_json::from_str(text).unwrap();
        let plain = &reference["multiplicative"];
        let (rows, rank) = (20, 4);
        let data = numbers(&plain["data"]);
        let count = data.len() / rows;
        let iterations = plain["iterations"].as_u64().unwrap();
        let close = |found: &[f64], expected: &Value| {
            let expected = numbers(expected);
            assert_eq!(found.len(), expected.len());
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - expected).abs() < 1e-8, "{found} {expected}");
            }
        };
        let cases = reference["penalised"].as_array().unwrap();
        assert_eq!(cases.len(), 3);
        for case in cases {
            let number = |name: &str| case[name].as_f64().unwrap();
            // scikit-learn weighs a penalty by the length of what it multiplies.
            let weights = |name: &str, length: usize| {
                let weight = number(name) * length as f64;
                Penalty {
                    l1: weight * number("l1_ratio"),
                    l2: weight * (1.0 - number("l1_ratio")),
                }
            };
            let of_activations = weights("alpha_activations", rows);
            let of_primitives = weights("alpha_primitives", count);
            let mut activations = numbers(&plain["start_activations"]);
            let start =
                nalgebra::DMatrix::from_vec(rows, rank, numbers(&plain["start_primitives"]));
            let mut primitives = start.transpose().as_slice().to_vec();
            let update_activations = |primitives: &[f64], activations: &mut [f64]| {
                let mut linear = vec![0.0; activations.len()];
                Packed::new(primitives, rank).times(View::columns(&data, rows), &mut linear);
                let gram = gram(primitives, rank);
                update_all(&gram, &linear, of_activations, activations, rank);
            };
            for _ in 0..iterations {
                update_activations(&primitives, &mut activations);
                let linear = cross(&activations, rank, &data, rows);
                let gram = gram(&activations, rank);
                update_all(&gram, &linear, of_primitives, &mut primitives, rank);
            }
            update_activations(&primitives, &mut activations);
            let columns = nalgebra::DMatrix::from_vec(rank, rows, primitives.clone()).transpose();
            close(columns.as_slice(), &case["primitives"]);
            close(&activations, &case["activations"]);
        }
    }
}
