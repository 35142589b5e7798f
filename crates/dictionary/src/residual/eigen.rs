//! The leading eigenvectors of a symmetric matrix, without the others.
//!
//! Reduction to tridiagonal form by reflections (A. S. Householder, Journal of the ACM 5, 1958),
//! eigenvalues by bisection with Sturm's counts and eigenvectors by inverse iteration (J. H.
//! Wilkinson, "The Algebraic Eigenvalue Problem", 1965, chapter 5). For the tenth of the vectors that is
//! wanted here it takes a third of the time of all of them.

use nalgebra::{DMatrix, DMatrixView, DVector};

use crate::product::dot;

/// Halvings of an interval of eigenvalues: more than a double has digits.
const HALVINGS: usize = 60;
/// Solves of inverse iteration for each vector: one is nearly always enough.
const SOLVES: usize = 4;
/// How far `T s` may be from `lambda s`, relative to the size of the matrix.
const TOLERANCE: f64 = 1e-13;

/// At most `count` of the largest eigenvalues (descending), with orthonormal eigenvectors as
/// columns; `None` where a vector did not converge.
///
/// Only the lower triangle of the matrix is read. Cost: `4/3 n³` for the reduction, `n²` a vector.
pub(super) fn leading(matrix: DMatrix<f64>, count: usize) -> Option<(Vec<f64>, DMatrix<f64>)> {
    let n = matrix.nrows();
    let count = count.min(n);
    let (tridiagonal, reflections) = reduced(matrix);
    let values: Vec<f64> = (0..count).map(|k| tridiagonal.eigenvalue(k)).collect();
    let mut vectors = DMatrix::zeros(n, count);
    for (k, &value) in values.iter().enumerate() {
        let vector = tridiagonal.eigenvector(value, vectors.columns(0, k), k)?;
        vectors.set_column(k, &vector);
    }
    for mut vector in vectors.column_iter_mut() {
        for (first, reflection) in reflections.iter().enumerate().rev() {
            reflection.apply(&mut vector.as_mut_slice()[first + 1..]);
        }
    }
    Some((values, vectors))
}

/// `I - factor v vᵀ`.
struct Reflection {
    axis: Vec<f64>,
    factor: f64,
}

impl Reflection {
    fn apply(&self, vector: &mut [f64]) {
        let along = self.factor * dot(&self.axis, vector);
        for (value, axis) in vector.iter_mut().zip(&self.axis) {
            *value -= along * axis;
        }
    }
}

/// A symmetric tridiagonal matrix.
struct Tridiagonal {
    diagonal: Vec<f64>,
    /// Beside the diagonal: one number less.
    beside: Vec<f64>,
}

/// `Q T Qᵀ`, `Q` as the product of reflections; the k-th acts on the rows from k + 1.
fn reduced(mut a: DMatrix<f64>) -> (Tridiagonal, Vec<Reflection>) {
    let n = a.nrows();
    let (mut beside, mut reflections) = (Vec::new(), Vec::new());
    for k in 0..n.saturating_sub(1) {
        let mut v = a.as_slice()[k * n + k + 1..(k + 1) * n].to_vec();
        let length = dot(&v, &v).sqrt();
        // Away from the number that is there, so that nothing cancels.
        let onto = if v[0] > 0.0 { -length } else { length };
        v[0] -= onto;
        let squared = dot(&v, &v);
        let factor = if squared > 0.0 { 2.0 / squared } else { 0.0 };
        beside.push(onto);

        // A <- A - v wᵀ - w vᵀ with w = p - (factor/2 pᵀv) v, p = factor A v.
        let mut w = vec![0.0; v.len()];
        for j in 0..v.len() {
            let column = &a.as_slice()[(k + 1 + j) * n + k + 1 + j..(k + 2 + j) * n];
            w[j] += column[0] * v[j] + dot(&column[1..], &v[j + 1..]);
            for (w, value) in w[j + 1..].iter_mut().zip(&column[1..]) {
                *w += value * v[j];
            }
        }
        for w in &mut w {
            *w *= factor;
        }
        let along = 0.5 * factor * dot(&w, &v);
        for (w, v) in w.iter_mut().zip(&v) {
            *w -= along * v;
        }
        for j in 0..v.len() {
            let column = &mut a.as_mut_slice()[(k + 1 + j) * n + k + 1 + j..(k + 2 + j) * n];
            let (vj, wj) = (v[j], w[j]);
            for ((value, v), w) in column.iter_mut().zip(&v[j..]).zip(&w[j..]) {
                *value -= v * wj + w * vj;
            }
        }
        reflections.push(Reflection { axis: v, factor });
    }
    let diagonal = a.diagonal().as_slice().to_vec();
    (Tridiagonal { diagonal, beside }, reflections)
}

impl Tridiagonal {
    /// Largest absolute row sum: no eigenvalue is larger.
    fn size(&self) -> f64 {
        (0..self.diagonal.len())
            .map(|i| {
                let before = i.checked_sub(1).map_or(0.0, |i| self.beside[i].abs());
                let after = self.beside.get(i).map_or(0.0, |v| v.abs());
                before + self.diagonal[i].abs() + after
            })
            .fold(0.0, f64::max)
    }

    /// Eigenvalues above `x`: positive numbers on the diagonal of the factors of `T - x I`.
    fn above(&self, x: f64, smallest: f64) -> usize {
        let (mut count, mut pivot) = (0, f64::INFINITY);
        for (i, diagonal) in self.diagonal.iter().enumerate() {
            let before = i.checked_sub(1).map_or(0.0, |i| self.beside[i]);
            pivot = diagonal - x - before * (before / pivot);
            if pivot.abs() < smallest {
                pivot = -smallest;
            }
            count += usize::from(pivot > 0.0);
        }
        count
    }

    /// The k-th largest eigenvalue.
    fn eigenvalue(&self, k: usize) -> f64 {
        let size = self.size();
        let (mut low, mut high) = (-size, size);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if self.above(
                middle,
                (f64::EPSILON * f64::EPSILON * size).max(f64::MIN_POSITIVE),
            ) > k
            {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    }

    /// The eigenvector of an eigenvalue that is orthogonal to those that are known.
    fn eigenvector(
        &self,
        value: f64,
        known: DMatrixView<'_, f64>,
        k: usize,
    ) -> Option<DVector<f64>> {
        let n = self.diagonal.len();
        let size = self.size();
        let factors = Factors::new(self, value, (f64::EPSILON * size).max(f64::MIN_POSITIVE));
        // Any start will do that is not orthogonal to the answer; another one for each, since
        // neighbours of equal eigenvalues are told apart by nothing else.
        let mut vector = DVector::from_fn(n, |i, _| {
            1.0 + 0.5 * ((i + 1) as f64 * (k as f64 + 1.7)).sin()
        });
        for _ in 0..SOLVES {
            factors.solve(vector.as_mut_slice());
            let length = vector.amax();
            vector /= length;
            for _ in 0..2 {
                for other in known.column_iter() {
                    let along = dot(other.as_slice(), vector.as_slice());
                    vector.axpy(-along, &other, 1.0);
                }
            }
            let length = vector.norm();
            if !(length > 0.0 && length.is_finite()) {
                return None;
            }
            vector /= length;
            if self.residual(value, vector.as_slice()) <= TOLERANCE * size {
                return Some(vector);
            }
        }
        None
    }

    /// Largest number of `T s - value s`.
    fn residual(&self, value: f64, s: &[f64]) -> f64 {
        (0..s.len())
            .map(|i| {
                let before = i
                    .checked_sub(1)
                    .map_or(0.0, |before| self.beside[before] * s[before]);
                let after = self.beside.get(i).map_or(0.0, |b| b * s[i + 1]);
                (before + (self.diagonal[i] - value) * s[i] + after).abs()
            })
            .fold(0.0, f64::max)
    }
}

/// `T - value I` in triangular factors, with rows exchanged where the pivot would be the smaller.
struct Factors {
    /// Diagonal of the upper factor and the two beside it.
    upper: Vec<[f64; 3]>,
    /// Multiplier of each row, and whether it changed places with the next.
    lower: Vec<(f64, bool)>,
}

impl Factors {
    fn new(matrix: &Tridiagonal, value: f64, smallest: f64) -> Self {
        let n = matrix.diagonal.len();
        let beside = |i: usize| matrix.beside.get(i).copied().unwrap_or(0.0);
        let not_zero = |pivot: f64| {
            if pivot.abs() < smallest {
                smallest
            } else {
                pivot
            }
        };
        let (mut upper, mut lower) = (Vec::with_capacity(n), Vec::with_capacity(n));
        let mut row = [matrix.diagonal[0] - value, beside(0), 0.0];
        for i in 1..n {
            let mut next = [beside(i - 1), matrix.diagonal[i] - value, beside(i)];
            let exchange = next[0].abs() > row[0].abs();
            if exchange {
                (row, next) = (next, row);
            }
            row[0] = not_zero(row[0]);
            let factor = next[0] / row[0];
            lower.push((factor, exchange));
            upper.push(row);
            row = [next[1] - factor * row[1], next[2] - factor * row[2], 0.0];
        }
        row[0] = not_zero(row[0]);
        upper.push(row);
        Self { upper, lower }
    }

    fn solve(&self, x: &mut [f64]) {
        for (i, &(factor, exchange)) in self.lower.iter().enumerate() {
            if exchange {
                x.swap(i, i + 1);
            }
            x[i + 1] -= factor * x[i];
        }
        for i in (0..x.len()).rev() {
            let [pivot, first, second] = self.upper[i];
            let later = |j: usize| x.get(j).copied().unwrap_or(0.0);
            x[i] = (x[i] - first * later(i + 1) - second * later(i + 2)) / pivot;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::SymmetricEigen;

    fn check(matrix: &DMatrix<f64>, count: usize) {
        let (values, vectors) = leading(matrix.clone(), count).unwrap();
        let count = count.min(matrix.nrows());
        assert_eq!((values.len(), vectors.ncols()), (count, count));
        let mut all: Vec<f64> = SymmetricEigen::new(matrix.clone())
            .eigenvalues
            .iter()
            .copied()
            .collect();
        all.sort_by(|a, b| b.total_cmp(a));
        let size = matrix.norm().max(f64::MIN_POSITIVE);
        for (value, expected) in values.iter().zip(&all) {
            assert!(
                (value - expected).abs() <= 1e-13 * size,
                "{value} {expected}"
            );
        }
        let errors = matrix * &vectors - &vectors * DMatrix::from_diagonal(&DVector::from(values));
        assert!(errors.amax() <= 1e-13 * size);
        let orthonormal = vectors.tr_mul(&vectors) - DMatrix::identity(count, count);
        assert!(orthonormal.amax() <= 1e-13);
    }

    fn of_spectrum(values: &[f64]) -> DMatrix<f64> {
        let n = values.len();
        let any = DMatrix::from_fn(n, n, |i, j| ((i * 31 + j * 17 + i * j) as f64).sin());
        let q = any.qr().q();
        let matrix =
            &q * DMatrix::from_diagonal(&DVector::from_column_slice(values)) * q.transpose();
        (&matrix + matrix.transpose()) * 0.5
    }

    #[test]
    fn all_kinds_of_spectra() {
        let decaying: Vec<f64> = (0..60).map(|i| 0.7_f64.powi(i)).collect();
        let steep: Vec<f64> = (0..40).map(|i| 0.2_f64.powi(i)).collect();
        let mut clusters = vec![1.0; 30];
        clusters.extend([0.5; 10]);
        clusters.extend([0.5 + 1e-12, 0.5 - 1e-12, 0.0, 0.0, 0.0]);
        let flat: Vec<f64> = (0..50).map(|i| 1.0 + 1e-3 * f64::from(i)).collect();
        for spectrum in [decaying, steep, clusters, flat, vec![3.0], vec![2.0, 1.0]] {
            for count in [1, 2, 12, 100] {
                check(&of_spectrum(&spectrum), count);
            }
        }
    }

    #[test]
    fn matrices_that_fall_apart() {
        check(&DMatrix::identity(20, 20), 5);
        check(&DMatrix::zeros(20, 20), 5);
        // Coordinates that know nothing of each other, and rows that are zero throughout.
        let block = of_spectrum(&[4.0, 3.0, 1.0, 0.5]);
        let mut apart = DMatrix::zeros(14, 14);
        for start in [0, 5, 9] {
            apart.view_mut((start, start), (4, 4)).copy_from(&block);
        }
        check(&apart, 9);
    }

    #[test]
    fn any_scale() {
        for scale in [1e-24, 1e-8, 1e12] {
            check(&(of_spectrum(&[5.0, 2.0, 1.0, 0.1, 0.01]) * scale), 4);
        }
    }

    #[test]
    fn no_number_does_not_converge() {
        let mut matrix = of_spectrum(&[5.0, 2.0, 1.0, 0.1]);
        matrix[(2, 1)] = f64::NAN;
        assert!(leading(matrix, 2).is_none());
    }
}
