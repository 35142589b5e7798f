//! Weights of predictions, by the distance that matters: least sum of Euclidean distances.

use nalgebra::{DMatrix, DVector};

use crate::lanes::{InstructionSet, Kernel};

/// Rounds of reweighted least squares; the error is flat near its minimum, so a few settle it.
const ROUNDS: usize = 8;
/// Distances below this weigh as if they were this large, metres: where a prediction is already
/// exact to a hundredth of a millimetre nothing is to be gained.
const SMALLEST_M: f64 = 1e-5;

/// Numbers side by side in sums.
const LANES: usize = 8;

/// Points in space, metres, each axis by itself, filled up with zeros to whole lanes.
pub(super) struct Points {
    count: usize,
    axes: [Vec<[f64; LANES]>; 3],
}

impl Points {
    /// Points from a list of coordinates, three a point.
    pub(super) fn new(coordinates: &[f64]) -> Self {
        let points = coordinates.as_chunks::<3>().0;
        let axis = |axis: usize| {
            let lanes = points.chunks(LANES).map(|points| {
                let mut lanes = [0.0; LANES];
                for (lane, point) in lanes.iter_mut().zip(points) {
                    *lane = point[axis];
                }
                lanes
            });
            lanes.collect()
        };
        Self {
            count: points.len(),
            axes: [axis(0), axis(1), axis(2)],
        }
    }
}

/// Non-negative weights `w` that minimise the mean of `|wanted - sum_k w_k prediction_k|`, and that
/// mean, metres.
///
/// The function is convex. Minimised by iteratively reweighted least squares (E. Weiszfeld, Tohoku
/// Mathematical Journal 43, 1937): each round is a least-squares problem under signs, in as many
/// unknowns as there are predictions. Weights are zero where none are better than that.
pub(super) fn blend<const K: usize>(wanted: &Points, predictions: [&Points; K]) -> ([f64; K], f64) {
    let mut weights = [0.0; K];
    let (mut error, mut equations) = pass(wanted, predictions, &weights, false);
    for _ in 0..ROUNDS {
        let next = non_negative_least_squares(&equations);
        let (next_error, next_equations) = pass(wanted, predictions, &next, true);
        if next_error < error {
            (weights, error) = (next, next_error);
        }
        equations = next_equations;
    }
    (weights, error)
}

/// Normal equations of weighted least squares: the matrix and the right-hand side.
type Equations<const K: usize> = ([[f64; K]; K], [f64; K]);

/// Mean distance with these weights, and the normal equations, each point divided by its distance where
/// `reweighted`: one pass, since reading the points is most of the work.
fn pass<const K: usize>(
    wanted: &Points,
    predictions: [&Points; K],
    weights: &[f64; K],
    reweighted: bool,
) -> (f64, Equations<K>) {
    let mut found = (0.0, ([[0.0; K]; K], [0.0; K]));
    InstructionSet::of_this_cpu().run::<f64, 1, _>(Pass {
        wanted,
        predictions,
        weights,
        reweighted,
        found: &mut found,
    });
    found
}

/// The arguments of [`pass`], and its result.
struct Pass<'a, const K: usize> {
    wanted: &'a Points,
    predictions: [&'a Points; K],
    weights: &'a [f64; K],
    reweighted: bool,
    found: &'a mut (f64, Equations<K>),
}

impl<const K: usize> Kernel for Pass<'_, K> {
    #[inline(always)]
    fn run<const L: usize, const V: usize, const FUSED: bool>(self) {
        let mut distances = [0.0; LANES];
        let (mut squares, mut products) = ([[[0.0; LANES]; K]; K], [[0.0; LANES]; K]);
        for i in 0..self.wanted.axes[0].len() {
            // Loops and no closures: maps of arrays are calls, and copies.
            let (mut wanted, mut predictions) = ([[0.0; LANES]; 3], [[[0.0; LANES]; 3]; K]);
            for axis in 0..3 {
                wanted[axis] = self.wanted.axes[axis][i];
                for (to, from) in predictions.iter_mut().zip(self.predictions) {
                    to[axis] = from.axes[axis][i];
                }
            }
            let mut left = wanted;
            for (weight, prediction) in self.weights.iter().zip(&predictions) {
                for axis in 0..3 {
                    for lane in 0..LANES {
                        left[axis][lane] -= weight * prediction[axis][lane];
                    }
                }
            }
            let mut lengths = dot(&left, &left);
            for length in &mut lengths {
                *length = length.sqrt();
            }
            let mut factors = [1.0; LANES];
            for lane in 0..LANES {
                distances[lane] += lengths[lane];
                let factor = 1.0 / lengths[lane].max(SMALLEST_M);
                factors[lane] = if self.reweighted { factor } else { 1.0 };
            }
            for k in 0..K {
                let product = dot(&predictions[k], &wanted);
                for lane in 0..LANES {
                    products[k][lane] += factors[lane] * product[lane];
                }
                for other in 0..=k {
                    let square = dot(&predictions[k], &predictions[other]);
                    for lane in 0..LANES {
                        squares[k][other][lane] += factors[lane] * square[lane];
                    }
                }
            }
        }
        let sum = |lanes: [f64; LANES]| lanes.iter().sum::<f64>();
        let mean_m = sum(distances) / self.wanted.count.max(1) as f64;
        let matrix =
            std::array::from_fn(|i| std::array::from_fn(|j| sum(squares[i.max(j)][i.min(j)])));
        *self.found = (mean_m, (matrix, products.map(sum)));
    }
}

/// Scalar products of vectors in lanes.
#[inline(always)]
fn dot(a: &[[f64; LANES]; 3], b: &[[f64; LANES]; 3]) -> [f64; LANES] {
    let mut products = [0.0; LANES];
    for lane in 0..LANES {
        products[lane] =
            a[0][lane] * b[0][lane] + a[1][lane] * b[1][lane] + a[2][lane] * b[2][lane];
    }
    products
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
        let [wanted, a, b] = [wanted, a, b].map(|list| Points::new(&list));
        let (weights, error) = blend(&wanted, [&a, &b]);
        assert!((weights[0] - 0.8).abs() < 1e-9 && (weights[1] - 0.3).abs() < 1e-9);
        assert!(error < 1e-12);
    }

    #[test]
    fn a_prediction_that_points_the_wrong_way_gets_none() {
        let wanted: Vec<f64> = (0..30).map(|i| 1e-3 * f64::from(i)).collect();
        let wrong: Vec<f64> = wanted.iter().map(|v| -v).collect();
        let [wanted, wrong] = [wanted, wrong].map(|list| Points::new(&list));
        assert_eq!(blend(&wanted, [&wrong]).0, [0.0]);
    }

    #[test]
    fn the_minimum_is_that_of_a_fine_search() {
        // One prediction; the sum of distances is minimised by a weighted median, not the mean.
        let prediction = [1e-3, 0.0, 0.0].repeat(5);
        let wanted: Vec<f64> = [0.1e-3, 0.2e-3, 0.3e-3, 0.4e-3, 50e-3]
            .iter()
            .flat_map(|x| [*x, 0.0, 0.0])
            .collect();
        let (wanted, prediction) = (Points::new(&wanted), Points::new(&prediction));
        let (weights, error) = blend(&wanted, [&prediction]);
        let searched = (0..10_000)
            .map(|i| pass(&wanted, [&prediction], &[f64::from(i) * 1e-3], false).0)
            .fold(f64::INFINITY, f64::min);
        assert!(error <= searched * 1.01, "{weights:?} {error} {searched}");
    }
}
