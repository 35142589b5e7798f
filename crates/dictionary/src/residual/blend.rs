//! Weights of predictions, by the distance that matters: least sum of Euclidean distances.

use nalgebra::{DMatrix, DVector};

/// Rounds of reweighted least squares; the error is flat near its minimum, so a few settle it.
const ROUNDS: usize = 8;
/// Distances below this weigh as if they were this large, metres: where a prediction is already
/// exact to a hundredth of a millimetre nothing is to be gained.
const SMALLEST_M: f64 = 1e-5;

/// Points in space with what was predicted of them: `wanted` and each prediction are lists of
/// coordinates, three a point, metres.
pub(super) struct Points<'a> {
    pub(super) wanted: &'a [f64],
    pub(super) predictions: &'a [&'a [f64]],
}

/// Non-negative weights `w` that minimise the mean of `|wanted - sum_k w_k prediction_k|`, and that
/// mean, metres.
///
/// The function is convex. Minimised by iteratively reweighted least squares (E. Weiszfeld, Tohoku
/// Mathematical Journal 43, 1937): each round is a least-squares problem under signs, in as many
/// unknowns as there are predictions.
pub(super) fn blend(points: &Points<'_>) -> (Vec<f64>, f64) {
    let count = points.predictions.len();
    let mut weights = vec![0.0; count];
    let mut error = mean_distance(points, &weights);
    let mut factors = vec![1.0; points.wanted.len() / 3];
    for _ in 0..ROUNDS {
        let (squares, products) = normal_equations(points, &factors);
        let next = non_negative_least_squares(&squares, &products);
        let next_error = mean_distance(points, &next);
        distances(points, &next, |i, distance| {
            factors[i] = distance.max(SMALLEST_M).recip();
        });
        if next_error < error {
            (weights, error) = (next, next_error);
        }
    }
    (weights, error)
}

/// Mean distance with these weights, metres.
pub(super) fn mean_distance(points: &Points<'_>, weights: &[f64]) -> f64 {
    let mut sum = 0.0;
    distances(points, weights, |_, distance| sum += distance);
    sum / (points.wanted.len() / 3).max(1) as f64
}

/// Calls `see` with each point's number and distance.
fn distances(points: &Points<'_>, weights: &[f64], mut see: impl FnMut(usize, f64)) {
    for (i, wanted) in points.wanted.as_chunks::<3>().0.iter().enumerate() {
        let mut left = *wanted;
        for (weight, prediction) in weights.iter().zip(points.predictions) {
            for (left, value) in left.iter_mut().zip(&prediction[3 * i..]) {
                *left -= weight * value;
            }
        }
        see(i, left.iter().map(|v| v * v).sum::<f64>().sqrt());
    }
}

fn normal_equations(points: &Points<'_>, factors: &[f64]) -> (DMatrix<f64>, DVector<f64>) {
    let count = points.predictions.len();
    let mut squares = DMatrix::zeros(count, count);
    let mut products = DVector::zeros(count);
    for (k, a) in points.predictions.iter().enumerate() {
        products[k] = weighted(a, points.wanted, factors);
        for (l, b) in points.predictions.iter().enumerate().take(k + 1) {
            squares[(k, l)] = weighted(a, b, factors);
            squares[(l, k)] = squares[(k, l)];
        }
    }
    (squares, products)
}

/// Scalar product, each point with its factor.
fn weighted(a: &[f64], b: &[f64], factors: &[f64]) -> f64 {
    (a.as_chunks::<3>().0.iter().zip(b.as_chunks::<3>().0))
        .zip(factors)
        .map(|((a, b), factor)| factor * (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]))
        .sum()
}

/// Minimises `1/2 wᵀ squares w - productsᵀ w` over `w >= 0` for a handful of unknowns: the best of
/// the solutions over all subsets.
fn non_negative_least_squares(squares: &DMatrix<f64>, products: &DVector<f64>) -> Vec<f64> {
    let count = products.len();
    let mut best = (vec![0.0; count], 0.0);
    for subset in 1_u32..1 << count {
        let used: Vec<usize> = (0..count).filter(|k| subset >> k & 1 == 1).collect();
        let part = squares.select_rows(&used).select_columns(&used);
        let Some(solution) = part
            .cholesky()
            .map(|c| c.solve(&products.select_rows(&used)))
        else {
            continue;
        };
        let value = -0.5 * solution.dot(&products.select_rows(&used));
        if value < best.1 && solution.iter().all(|w| *w >= 0.0 && w.is_finite()) {
            let mut weights = vec![0.0; count];
            for (&k, &w) in used.iter().zip(solution.iter()) {
                weights[k] = w;
            }
            best = (weights, value);
        }
    }
    best.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_predictions_get_their_weights() {
        let a: Vec<f64> = (0..300).map(|i| (i as f64 * 0.7).sin() * 1e-3).collect();
        let b: Vec<f64> = (0..300).map(|i| (i as f64 * 1.3).cos() * 1e-3).collect();
        let wanted: Vec<f64> = a.iter().zip(&b).map(|(a, b)| 0.8 * a + 0.3 * b).collect();
        let points = Points {
            wanted: &wanted,
            predictions: &[&a, &b],
        };
        let (weights, error) = blend(&points);
        assert!((weights[0] - 0.8).abs() < 1e-9 && (weights[1] - 0.3).abs() < 1e-9);
        assert!(error < 1e-12);
    }

    #[test]
    fn a_prediction_that_points_the_wrong_way_gets_none() {
        let wanted: Vec<f64> = (0..30).map(|i| 1e-3 * f64::from(i)).collect();
        let wrong: Vec<f64> = wanted.iter().map(|v| -v).collect();
        let points = Points {
            wanted: &wanted,
            predictions: &[&wrong],
        };
        assert_eq!(blend(&points).0, [0.0]);
    }

    #[test]
    fn the_minimum_is_that_of_a_fine_search() {
        // One prediction; the sum of distances is minimised by a weighted median, not the mean.
        let prediction = [1e-3, 0.0, 0.0].repeat(5);
        let wanted: Vec<f64> = [0.1e-3, 0.2e-3, 0.3e-3, 0.4e-3, 50e-3]
            .iter()
            .flat_map(|x| [*x, 0.0, 0.0])
            .collect();
        let points = Points {
            wanted: &wanted,
            predictions: &[&prediction],
        };
        let (weights, error) = blend(&points);
        let searched = (0..10_000)
            .map(|i| mean_distance(&points, &[f64::from(i) * 1e-3]))
            .fold(f64::INFINITY, f64::min);
        assert!(error <= searched * 1.01, "{weights:?} {error} {searched}");
    }
}
