//! Weights of predictions, by the distance that matters: least sum of Euclidean distances.

use nalgebra::{DMatrix, DVector};

/// Rounds of reweighted least squares; the error is flat near its minimum, so a few settle it.
const ROUNDS: usize = 8;
/// Distances below this weigh as if they were this large, metres: where a prediction is already
/// exact to a hundredth of a millimetre nothing is to be gained.
const SMALLEST_M: f64 = 1e-5;

/// Points in space with what was predicted of them: `wanted` and each prediction are lists of
/// coordinates, three a point, metres.
pub(super) struct Points<'a, const K: usize> {
    pub(super) wanted: &'a [f64],
    pub(super) predictions: [&'a [f64]; K],
}

/// Non-negative weights `w` that minimise the mean of `|wanted - sum_k w_k prediction_k|`, and that
/// mean, metres.
///
/// The function is convex. Minimised by iteratively reweighted least squares (E. Weiszfeld, Tohoku
/// Mathematical Journal 43, 1937): each round is a least-squares problem under signs, in as many
/// unknowns as there are predictions. Weights are zero where none are better than that.
pub(super) fn blend<const K: usize>(points: &Points<'_, K>) -> ([f64; K], f64) {
    let mut weights = [0.0; K];
    let (mut error, mut sums) = pass(points, &weights, |_| 1.0);
    for _ in 0..ROUNDS {
        let next = non_negative_least_squares(&sums);
        let (next_error, next_sums) =
            pass(points, &next, |distance| distance.max(SMALLEST_M).recip());
        if next_error < error {
            (weights, error) = (next, next_error);
        }
        sums = next_sums;
    }
    (weights, error)
}

/// Normal equations of weighted least squares: the matrix and the right-hand side.
type Equations<const K: usize> = ([[f64; K]; K], [f64; K]);

impl<const K: usize> Points<'_, K> {
    fn len(&self) -> usize {
        self.wanted.len() / 3
    }

    /// Remainder of a point less the weighted predictions.
    fn left(&self, i: usize, weights: &[f64; K]) -> [f64; 3] {
        let mut left = point(self.wanted, i);
        for (weight, prediction) in weights.iter().zip(self.predictions) {
            for (left, value) in left.iter_mut().zip(point(prediction, i)) {
                *left -= weight * value;
            }
        }
        left
    }
}

/// Mean distance with these weights, and the normal equations with a factor for each point that
/// depends on its distance: one pass, since reading the points is most of the work.
fn pass<const K: usize>(
    points: &Points<'_, K>,
    weights: &[f64; K],
    factor: impl Fn(f64) -> f64,
) -> (f64, Equations<K>) {
    let mut distances = 0.0;
    let (mut squares, mut products) = ([[0.0; K]; K], [0.0; K]);
    for i in 0..points.len() {
        let distance = length(points.left(i, weights));
        distances += distance;
        let factor = factor(distance);
        let wanted = point(points.wanted, i);
        let predictions = points.predictions.map(|prediction| point(prediction, i));
        let places = squares.iter_mut().zip(&mut products);
        for ((squares, product), prediction) in places.zip(predictions) {
            let scaled = prediction.map(|v| factor * v);
            *product += dot(scaled, wanted);
            for (square, other) in squares.iter_mut().zip(predictions) {
                *square += dot(scaled, other);
            }
        }
    }
    let mean_m = distances / points.len().max(1) as f64;
    (mean_m, (squares, products))
}

fn point(coordinates: &[f64], i: usize) -> [f64; 3] {
    coordinates.as_chunks::<3>().0[i]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn length(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

/// Minimises `1/2 wᵀ squares w - productsᵀ w` over `w >= 0` for a handful of unknowns: the best of
/// the solutions over all subsets.
fn non_negative_least_squares<const K: usize>((squares, products): &Equations<K>) -> [f64; K] {
    let mut best = ([0.0; K], 0.0);
    for subset in 1_u32..1 << K {
        let used: Vec<usize> = (0..K).filter(|k| subset >> k & 1 == 1).collect();
        let count = used.len();
        let part = DMatrix::from_fn(count, count, |i, j| squares[used[i]][used[j]]);
        let products = DVector::from_fn(count, |i, _| products[used[i]]);
        let Some(solution) = part.cholesky().map(|c| c.solve(&products)) else {
            continue;
        };
        let value = -0.5 * solution.dot(&products);
        if value < best.1 && solution.iter().all(|w| *w >= 0.0 && w.is_finite()) {
            let mut weights = [0.0; K];
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
            predictions: [&a, &b],
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
            predictions: [&wrong],
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
            predictions: [&prediction],
        };
        let (weights, error) = blend(&points);
        let searched = (0..10_000)
            .map(|i| pass(&points, &[f64::from(i) * 1e-3], |_| 1.0).0)
            .fold(f64::INFINITY, f64::min);
        assert!(error <= searched * 1.01, "{weights:?} {error} {searched}");
    }
}
