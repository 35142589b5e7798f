//! Leading eigenpairs of a symmetric matrix.
//!
//! Where a few of many are wanted, most of a full decomposition is rotations of vectors that nobody reads. Here the
//! matrix is made tridiagonal by reflections, whose update of rank two shares its pass over the matrix with
//! the product that the next reflection needs; eigenvalues follow by bisection (W. Barth, R. S. Martin and J. H.
//! Wilkinson, Numerische Mathematik 9, 1967), vectors by inverse iteration, made orthogonal to those
//! before. As exact as a full decomposition: no gap between eigenvalues is assumed.

use crate::lanes::{InstructionSet, Kernel, multiply_add};
use crate::random::{keyed, uniform};

/// Numbers side by side in sums and bisections.
const LANES: usize = 8;
/// Rows of columns that are updated together.
const COLUMNS: usize = 4;
/// Halvings of an interval: more than a double has digits.
const HALVINGS: usize = 128;
/// Solves of inverse iteration: the first brings all digits but for bad luck with the start.
const SOLVES: usize = 3;

/// The `wanted` largest eigenvalues of a symmetric matrix (n x n, whole), largest first, with their
/// eigenvectors (n x wanted), orthonormal to rounding.
///
/// Cost: `2 n³` operations and `4 n² wanted`.
pub(crate) fn leading(symmetric: &[f64], n: usize, wanted: usize) -> (Vec<f64>, Vec<f64>) {
    let mut found = (Vec::new(), Vec::new());
    let wanted = wanted.min(n);
    InstructionSet::of_this_cpu().run::<f64, 1, _>(Leading {
        symmetric,
        n,
        wanted,
        found: &mut found,
    });
    found
}

struct Leading<'a> {
    symmetric: &'a [f64],
    n: usize,
    wanted: usize,
    found: &'a mut (Vec<f64>, Vec<f64>),
}

impl Kernel for Leading<'_> {
    #[inline(always)]
    fn run<const L: usize, const V: usize, const FUSED: bool>(self) {
        let n = self.n;
        let reduced = reduce::<FUSED>(self.symmetric, n);
        let values = reduced.largest(self.wanted);
        let mut vectors: Vec<f64> = Vec::with_capacity(n * values.len());
        for &value in &values {
            let vector = reduced.vector::<FUSED>(value, &vectors);
            vectors.extend(vector);
        }
        reduced.turn_back::<FUSED>(&mut vectors);
        *self.found = (values, vectors);
    }
}

/// A tridiagonal matrix and the reflections that lead to it.
struct Tridiagonal {
    n: usize,
    /// Rows of a column of `reflections`, a multiple of [`LANES`].
    rows: usize,
    diagonal: Vec<f64>,
    /// Beside the diagonal; `n - 1` numbers.
    beside: Vec<f64>,
    /// Normals `u` of the reflections `I - scale u uᵀ`, each in its column.
    reflections: Vec<f64>,
    scales: Vec<f64>,
}

/// Householder's reduction. The update of rank two that a reflection causes waits for the next one, whose product
/// with the matrix is formed in the same pass.
#[inline(always)]
fn reduce<const FUSED: bool>(symmetric: &[f64], n: usize) -> Tridiagonal {
    let rows = n.next_multiple_of(LANES);
    let mut a = vec![0.0; rows * n];
    for (to, from) in a.chunks_exact_mut(rows).zip(symmetric.chunks_exact(n)) {
        to[..n].copy_from_slice(from);
    }
    let (mut diagonal, mut beside, mut scales) = (vec![0.0; n], Vec::new(), Vec::new());
    // The waiting update is v wᵀ + w vᵀ.
    let [mut u, mut v, mut w, mut product] = [(); 4].map(|()| vec![0.0; rows]);
    for k in 0..n {
        let (done, rest) = a.split_at_mut((k + 1) * rows);
        let column = &mut done[k * rows..];
        let (vk, wk) = (v[k], w[k]);
        for ((to, v), w) in column.iter_mut().zip(&v).zip(&w) {
            *to -= v * wk + w * vk;
        }
        diagonal[k] = column[k];
        if k + 1 == n {
            break;
        }
        u.fill(0.0);
        u[k + 1..n].copy_from_slice(&column[k + 1..n]);
        let length = dot::<FUSED>(&u, &u).sqrt();
        let to = if u[k + 1] > 0.0 { -length } else { length };
        u[k + 1] -= to;
        let half = length * u[k + 1].abs();
        let scale = if half > 0.0 { half.recip() } else { 0.0 };
        column.copy_from_slice(&u);
        beside.push(to);
        scales.push(scale);

        // What lies above the first row of the rest stays, as u, v and w are zero there.
        let from = (k + 1) / LANES * LANES;
        (v[k], w[k]) = (0.0, 0.0);
        product.fill(0.0);
        for (group, columns) in rest.chunks_mut(COLUMNS * rows).enumerate() {
            let first = k + 1 + group * COLUMNS;
            let mut columns = columns.chunks_exact_mut(rows);
            if columns.len() == COLUMNS {
                let columns =
                    [(); COLUMNS].map(|()| &mut columns.next().unwrap_or_default()[from..]);
                pass::<COLUMNS, FUSED>(columns, first, from, (&u, &v, &w), &mut product);
            } else {
                for (column, place) in columns.zip(first..) {
                    pass::<1, FUSED>(
                        [&mut column[from..]],
                        place,
                        from,
                        (&u, &v, &w),
                        &mut product,
                    );
                }
            }
        }
        product[..=k].fill(0.0);
        let along = 0.5 * scale * dot::<FUSED>(&product, &u);
        for ((w, product), u) in w.iter_mut().zip(&product).zip(&u) {
            *w = scale * (product - along * u);
        }
        std::mem::swap(&mut u, &mut v);
    }
    Tridiagonal {
        n,
        rows,
        diagonal,
        beside,
        reflections: a,
        scales,
    }
}

/// Takes `v wᵀ + w vᵀ` off some columns, from a row on, and adds their products with `u` to `product`.
#[inline(always)]
fn pass<const C: usize, const FUSED: bool>(
    columns: [&mut [f64]; C],
    first: usize,
    from: usize,
    (u, v, w): (&[f64], &[f64], &[f64]),
    product: &mut [f64],
) {
    let (mut us, mut vs, mut ws) = ([0.0; C], [0.0; C], [0.0; C]);
    for c in 0..C {
        (us[c], vs[c], ws[c]) = (u[first + c], v[first + c], w[first + c]);
    }
    let (v, _) = v[from..].as_chunks::<LANES>();
    let (w, _) = w[from..].as_chunks::<LANES>();
    let product = product[from..].as_chunks_mut::<LANES>().0;
    let columns = columns.map(|column| column.as_chunks_mut::<LANES>().0);
    for (i, ((product, v), w)) in product.iter_mut().zip(v).zip(w).enumerate() {
        // In copies: what is written through references might be the same, and is not kept in registers.
        let (mut sum, v, w) = (*product, *v, *w);
        for c in 0..C {
            let mut column = columns[c][i];
            for lane in 0..LANES {
                column[lane] = multiply_add::<f64, FUSED>(-v[lane], ws[c], column[lane]);
            }
            for lane in 0..LANES {
                column[lane] = multiply_add::<f64, FUSED>(-w[lane], vs[c], column[lane]);
            }
            for lane in 0..LANES {
                sum[lane] = multiply_add::<f64, FUSED>(column[lane], us[c], sum[lane]);
            }
            columns[c][i] = column;
        }
        *product = sum;
    }
}

#[inline(always)]
fn dot<const FUSED: bool>(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; LANES];
    let (a, a_rest) = a.as_chunks::<LANES>();
    let (b, b_rest) = b.as_chunks::<LANES>();
    for (a, b) in a.iter().zip(b) {
        for lane in 0..LANES {
            sums[lane] = multiply_add::<f64, FUSED>(a[lane], b[lane], sums[lane]);
        }
    }
    let rest = a_rest.iter().zip(b_rest).map(|(a, b)| a * b);
    sums.iter().sum::<f64>() + rest.sum::<f64>()
}

impl Tridiagonal {
    /// Largest absolute sum of a row: no eigenvalue is farther from zero.
    fn bound(&self) -> f64 {
        let beside = |i: usize| self.beside.get(i).map_or(0.0, |v| v.abs());
        let sums = (0..self.n).map(|i| {
            let before = i.checked_sub(1).map_or(0.0, beside);
            before + self.diagonal[i].abs() + beside(i)
        });
        sums.fold(0.0, f64::max)
    }

    /// The largest eigenvalues, largest first.
    #[inline(always)]
    fn largest(&self, wanted: usize) -> Vec<f64> {
        let bound = self.bound();
        // Smallest pivot: what a double of the matrix cannot tell from zero.
        let smallest = (f64::EPSILON * bound).powi(2).max(f64::MIN_POSITIVE);
        let squares: Vec<f64> = self.beside.iter().map(|v| v * v).collect();
        let mut values = Vec::with_capacity(wanted + LANES);
        while values.len() < wanted {
            // Lane i brackets the eigenvalue below which there are `below[i]` others.
            let below: [f64; LANES] =
                std::array::from_fn(|lane| self.n as f64 - 1.0 - (values.len() + lane) as f64);
            let (mut low, mut high) = ([-bound; LANES], [bound; LANES]);
            for _ in 0..HALVINGS {
                let middle: [f64; LANES] =
                    std::array::from_fn(|lane| 0.5 * (low[lane] + high[lane]));
                let inside =
                    (0..LANES).any(|lane| low[lane] < middle[lane] && middle[lane] < high[lane]);
                if !inside {
                    break;
                }
                let counts = self.below(&squares, middle, smallest);
                for lane in 0..LANES {
                    let above = counts[lane] <= below[lane];
                    low[lane] = if above { middle[lane] } else { low[lane] };
                    high[lane] = if above { high[lane] } else { middle[lane] };
                }
            }
            values.extend((0..LANES).map(|lane| 0.5 * (low[lane] + high[lane])));
        }
        values.truncate(wanted);
        values
    }

    /// Numbers of eigenvalues below each of some numbers: signs of the pivots of the matrix less them.
    #[inline(always)]
    fn below(&self, squares: &[f64], of: [f64; LANES], smallest: f64) -> [f64; LANES] {
        let (mut pivots, mut counts) = ([1.0; LANES], [0.0; LANES]);
        let squares = std::iter::once(&0.0).chain(squares);
        for (diagonal, square) in self.diagonal.iter().zip(squares) {
            for lane in 0..LANES {
                let pivot = diagonal - of[lane] - square / pivots[lane];
                let pivot = if pivot.abs() < smallest {
                    -smallest
                } else {
                    pivot
                };
                counts[lane] += if pivot < 0.0 { 1.0 } else { 0.0 };
                pivots[lane] = pivot;
            }
        }
        counts
    }

    /// An eigenvector of length one, orthogonal to those found before.
    #[inline(always)]
    fn vector<const FUSED: bool>(&self, value: f64, before: &[f64]) -> Vec<f64> {
        let n = self.n;
        let shifted = Shifted::new(self, value, f64::EPSILON * self.bound());
        // Any start that is orthogonal to no vector, and none of those before, will do.
        let mut random = keyed(before.len() as u64, n);
        let mut vector: Vec<f64> = (0..n).map(|_| 0.5 + uniform(&mut random)).collect();
        for _ in 0..SOLVES {
            shifted.solve(&mut vector);
            // Twice: what is left of a vector in a cluster may be short.
            for _ in 0..2 {
                scale_to_unit::<FUSED>(&mut vector);
                for other in before.chunks_exact(n) {
                    let along = dot::<FUSED>(other, &vector);
                    for (v, other) in vector.iter_mut().zip(other) {
                        *v -= along * other;
                    }
                }
            }
            scale_to_unit::<FUSED>(&mut vector);
        }
        vector
    }

    /// Vectors of the tridiagonal matrix to those of the matrix that it was made from.
    #[inline(always)]
    fn turn_back<const FUSED: bool>(&self, vectors: &mut [f64]) {
        for (k, scale) in self.scales.iter().enumerate().rev() {
            let normal = &self.reflections[k * self.rows..][k + 1..self.n];
            for vector in vectors.chunks_exact_mut(self.n) {
                let vector = &mut vector[k + 1..];
                let along = scale * dot::<FUSED>(normal, vector);
                for (v, u) in vector.iter_mut().zip(normal) {
                    *v = multiply_add::<f64, FUSED>(-along, *u, *v);
                }
            }
        }
    }
}

#[inline(always)]
fn scale_to_unit<const FUSED: bool>(vector: &mut [f64]) {
    // A solve next to an eigenvalue gives numbers up to 1e300: their squares would be none.
    let largest = vector.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    if largest > 0.0 {
        vector.iter_mut().for_each(|v| *v /= largest);
        let length = dot::<FUSED>(vector, vector).sqrt();
        vector.iter_mut().for_each(|v| *v /= length);
    }
}

/// `T - value I` as the factors of Gaussian elimination with exchanges of neighbouring rows.
struct Shifted {
    /// Rows of the upper factor: the diagonal and the two numbers behind it.
    upper: Vec<[f64; 3]>,
    /// For each row but the last, its factor of the elimination, and whether it changed places with the next.
    steps: Vec<(f64, bool)>,
}

impl Shifted {
    fn new(matrix: &Tridiagonal, value: f64, smallest: f64) -> Self {
        let n = matrix.n;
        let beside = |i: usize| matrix.beside.get(i).copied().unwrap_or(0.0);
        let smallest = smallest.max(f64::MIN_POSITIVE);
        let (mut upper, mut steps) = (Vec::with_capacity(n), Vec::with_capacity(n));
        let mut row = [matrix.diagonal[0] - value, beside(0), 0.0];
        for i in 1..n {
            let next = [beside(i - 1), matrix.diagonal[i] - value, beside(i)];
            let exchanged = next[0].abs() > row[0].abs();
            let (pivot, other) = if exchanged { (next, row) } else { (row, next) };
            let factor = if pivot[0] == 0.0 {
                0.0
            } else {
                other[0] / pivot[0]
            };
            row = [
                other[1] - factor * pivot[1],
                other[2] - factor * pivot[2],
                0.0,
            ];
            upper.push(pivot);
            steps.push((factor, exchanged));
        }
        upper.push(row);
        // A pivot of zero is an exact eigenvalue: the next best number.
        for [pivot, ..] in &mut upper {
            if pivot.abs() < smallest {
                *pivot = smallest.copysign(*pivot);
            }
        }
        Self { upper, steps }
    }

    fn solve(&self, x: &mut [f64]) {
        for (i, &(factor, exchanged)) in self.steps.iter().enumerate() {
            if exchanged {
                x.swap(i, i + 1);
            }
            x[i + 1] -= factor * x[i];
        }
        let (mut next, mut after) = (0.0, 0.0);
        for (x, [pivot, a, b]) in x.iter_mut().zip(&self.upper).rev() {
            *x = (*x - a * next - b * after) / pivot;
            (next, after) = (*x, next);
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector, SymmetricEigen};

    use super::leading;

    fn check(matrix: &DMatrix<f64>, wanted: usize) {
        let n = matrix.nrows();
        let (values, vectors) = leading(matrix.as_slice(), n, wanted);
        assert_eq!((values.len(), vectors.len()), (wanted, wanted * n));
        let mut expected = SymmetricEigen::new(matrix.clone()).eigenvalues;
        expected.as_mut_slice().sort_by(|a, b| b.total_cmp(a));
        let size = expected.amax().max(f64::MIN_POSITIVE);
        for (found, expected) in values.iter().zip(expected.iter()) {
            assert!(
                (found - expected).abs() < 1e-13 * size,
                "{found} {expected}"
            );
        }
        let vectors = DMatrix::from_vec(n, wanted, vectors);
        let values = DMatrix::from_diagonal(&DVector::from_vec(values));
        let left = (matrix * &vectors - &vectors * values).amax();
        assert!(left < 1e-13 * size, "{left:e}");
        let unit = (vectors.tr_mul(&vectors) - DMatrix::identity(wanted, wanted)).amax();
        assert!(unit < 1e-12, "{unit:e}");
    }

    /// A matrix with these eigenvalues and some orthonormal vectors.
    fn with_values(values: &[f64]) -> DMatrix<f64> {
        let n = values.len();
        let some = DMatrix::from_fn(n, n, |r, c| (1.3 * (r * n + c + 1) as f64).sin());
        let vectors = some.qr().q();
        &vectors * DMatrix::from_diagonal(&DVector::from_column_slice(values)) * vectors.transpose()
    }

    #[test]
    fn pairs_are_those_of_a_full_decomposition() {
        for n in [1, 2, 3, 8, 29, 75] {
            let falling: Vec<f64> = (0..n).map(|i| 0.8_f64.powi(i)).collect();
            check(&with_values(&falling), (n as usize).min(28));
            let spread: Vec<f64> = (0..n).map(|i| 2.0 - 0.01 * f64::from(i)).collect();
            check(&with_values(&spread), n as usize);
        }
    }

    #[test]
    fn equal_values_have_orthogonal_vectors() {
        let values: Vec<f64> = (0..40).map(|i| f64::from(4 - i / 10)).collect();
        check(&with_values(&values), 25);
        check(&DMatrix::identity(30, 30), 12);
        check(&DMatrix::zeros(9, 9), 4);
        // Nothing between two halves, each with the same values.
        let half = with_values(&[3.0, 2.0, 1.0, 0.5]);
        let mut whole = DMatrix::zeros(8, 8);
        whole.view_mut((0, 0), (4, 4)).copy_from(&half);
        whole.view_mut((4, 4), (4, 4)).copy_from(&half);
        check(&whole, 6);
    }

    #[test]
    fn sizes_of_the_numbers_do_not_matter() {
        for size in [1e-18, 1e-6, 1e12] {
            check(&(with_values(&[5.0, 3.0, 1.0, 0.2, 1e-9, 0.0]) * size), 5);
        }
    }
}
