//! Mean and covariance of activations, shrunk towards a scaled identity.

use nalgebra::{DMatrix, DVector};

use crate::error::LearnError;
use crate::product::{add, gram, squared_norm};

/// Mean and covariance of a set of vectors.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Moments {
    /// Mean (`rank`), in the unit of the vectors.
    pub(crate) mean: DVector<f64>,
    /// Covariance (`rank` x `rank`), positive definite.
    pub(crate) covariance: DMatrix<f64>,
    /// Weight of the scaled identity in it, 0 to 1.
    pub(crate) shrinkage: f64,
}

/// Smallest weight of the identity: where Ledoit and Wolf's weight is zero (or smaller) the matrix
/// may still be singular, as for a primitive that no segment uses, and planners invert it. Bounds
/// the condition number by `rank` times 1e9.
const SMALLEST_SHRINKAGE: f64 = 1e-9;

/// Variance that stands in for none at all, relative to the mean square of the mean: all vectors
/// equal, as for a single segment. A millionth of the size of the activations as standard deviation.
const VARIANCE_OF_EQUAL_VECTORS: f64 = 1e-12;

/// Variance where even the mean is zero, m²: a nanometre, small beside any motion, large enough for
/// its inverse.
const SMALLEST_VARIANCE_M2: f64 = 1e-18;

/// Mean and covariance (denominator n) of vectors given in blocks (each `rank` x its count), summed
/// in block order.
///
/// The covariance is always shrunk by Ledoit and Wolf's weight, not only where there are fewer
/// vectors than coordinates: the weight tends to zero by itself as the vectors become many, and
/// between those ends it makes a better and far better conditioned prior (with 595 segments and 200
/// primitives the weight is 0.05 and the condition number falls from 1e5 to below 1e3). The result
/// is positive definite for any input.
///
/// Cost: `n rank²` operations, no copy beyond one block.
///
/// # Errors
///
/// What `block` returns; it is asked for each block twice, in order.
pub(crate) fn moments_of(
    blocks: usize,
    rank: usize,
    mut block: impl FnMut(usize) -> Result<Vec<f64>, LearnError>,
) -> Result<Moments, LearnError> {
    let (mut mean, mut count) = (vec![0.0; rank], 0_usize);
    for i in 0..blocks {
        for vector in block(i)?.chunks_exact(rank) {
            add(&mut mean, vector);
            count += 1;
        }
    }
    let mut scatter = Scatter::about(mean.iter().map(|v| v / count as f64).collect());
    // A second pass, so that no digits cancel.
    for i in 0..blocks {
        scatter.add(block(i)?);
    }
    Ok(scatter.shrunk())
}

/// The same of vectors in memory with the mean taken to be zero: the mean square of what is left after a
/// prediction, where a mean that is not zero is an error like any other.
pub(crate) fn moments_about_zero(vectors: &[f64], rank: usize) -> Moments {
    let mut scatter = Scatter::about(vec![0.0; rank]);
    scatter.add(vectors.to_vec());
    scatter.shrunk()
}

/// Sums over vectors less their mean, and what the shrinkage weight needs besides.
struct Scatter {
    mean: Vec<f64>,
    /// Sum of products, column-major.
    products: Vec<f64>,
    /// Sum of the fourth powers of the centred vectors' lengths.
    fourth_powers: f64,
    count: usize,
}

impl Scatter {
    fn about(mean: Vec<f64>) -> Self {
        Self {
            products: vec![0.0; mean.len() * mean.len()],
            mean,
            fourth_powers: 0.0,
            count: 0,
        }
    }

    fn add(&mut self, mut vectors: Vec<f64>) {
        for vector in vectors.chunks_exact_mut(self.mean.len()) {
            for (v, mean) in vector.iter_mut().zip(&self.mean) {
                *v -= mean;
            }
            self.fourth_powers += squared_norm(vector).powi(2);
            self.count += 1;
        }
        add(&mut self.products, &gram(&vectors, self.mean.len()));
    }

    fn shrunk(self) -> Moments {
        let (rank, count) = (self.mean.len(), self.count as f64);
        let mut covariance = DMatrix::from_vec(rank, rank, self.products);
        covariance /= count;
        let scale = covariance.diagonal().iter().sum::<f64>() / rank as f64;
        let weight = ledoit_wolf_weight(&covariance, self.fourth_powers, count, scale);
        let shrinkage = weight.max(SMALLEST_SHRINKAGE);
        let mean = DVector::from_vec(self.mean);
        let identity = if scale > 0.0 {
            scale
        } else {
            VARIANCE_OF_EQUAL_VECTORS * mean.norm_squared() / rank as f64 + SMALLEST_VARIANCE_M2
        };
        covariance *= 1.0 - shrinkage;
        for i in 0..rank {
            covariance[(i, i)] += shrinkage * identity;
        }
        Moments {
            mean,
            covariance,
            shrinkage,
        }
    }
}

/// Weight of the scaled identity by Ledoit and Wolf (2004), "A well-conditioned estimator for
/// large-dimensional covariance matrices", lemma 3.2 to 3.4: `min(b², d²) / d²` with
/// `d² = |S - m I|²` and `b² = 1/n² sum_t |x_t x_tᵀ - S|²`.
fn ledoit_wolf_weight(
    covariance: &DMatrix<f64>,
    fourth_powers: f64,
    count: f64,
    scale: f64,
) -> f64 {
    let squared = squared_norm(covariance.as_slice());
    // |S - m I|² = |S|² - p m², because m is the mean of the diagonal.
    let distance = squared - covariance.nrows() as f64 * scale * scale;
    let spread = (fourth_powers / count - squared) / count;
    if distance > 0.0 {
        (spread / distance).clamp(0.0, 1.0)
    } else {
        // S is a multiple of the identity already.
        0.0
    }
}
