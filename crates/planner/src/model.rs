//! One form for all methods: motion as a linear function of unknowns, and what is expected of them.
//!
//! ```text
//! v = base + W h,    h ~ N(mu, Λ⁻¹)
//! ```
//!
//! For a [`Dictionary`] `W` are its primitives and `h` their activations. For a [`Residual`] `h` are
//! the end conditions `x` and the activations `z` of the deviation, and `W = [S | B]`; the
//! expectation of `z` depends on the end conditions that the target gives, and on the most likely
//! values of those it does not. Lengths in mm, velocities in mm/s.

use inhand_model::{
    Dictionary, DictionaryKind, Residual, SEGMENT_COORDINATES, SegmentLayout, ends_len,
};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use crate::basis::Basis;
use crate::error::PlanError;
use crate::given::{End, Given};
use crate::method::Method;

pub(crate) const MM_PER_M: f64 = 1e3;

/// How strongly unknowns are drawn to their mean.
#[derive(Clone, Debug)]
pub(crate) enum Precision {
    /// The same for every unknown, on its own.
    Ridge(f64),
    /// Inverses of covariances along the diagonal.
    Blocks(Vec<DMatrix<f64>>),
}

impl Precision {
    /// `Λ v`.
    pub(crate) fn times(&self, v: &DVector<f64>) -> DVector<f64> {
        match self {
            Precision::Ridge(ridge) => v * *ridge,
            Precision::Blocks(blocks) => {
                let mut product = DVector::zeros(v.len());
                let mut at = 0;
                for block in blocks {
                    let n = block.nrows();
                    product
                        .rows_mut(at, n)
                        .gemv(1.0, block, &v.rows(at, n), 0.0);
                    at += n;
                }
                product
            }
        }
    }

    /// Adds `Λ` to a matrix (n x n).
    pub(crate) fn add_to(&self, matrix: &mut DMatrix<f64>) {
        match self {
            Precision::Ridge(ridge) => {
                for i in 0..matrix.nrows() {
                    matrix[(i, i)] += ridge;
                }
            }
            Precision::Blocks(blocks) => {
                let mut at = 0;
                for block in blocks {
                    let n = block.nrows();
                    let mut place = matrix.view_mut((at, at), (n, n));
                    place += block;
                    at += n;
                }
            }
        }
    }
}

/// What is expected of the unknowns.
#[derive(Clone, Debug)]
enum Expected {
    /// The same for every target, mm.
    Always(DVector<f64>),
    /// Activations as the end conditions have it.
    ByEnds(Box<Residual>),
}

/// Motion as a linear function of unknowns, and what is expected of them.
#[derive(Clone, Debug)]
pub(crate) struct MotionModel {
    pub(crate) layout: SegmentLayout,
    pub(crate) basis: Basis,
    /// The motion where all unknowns are zero, mm.
    pub(crate) base_mm: Vec<f64>,
    /// Unknowns must not be negative (NMF).
    pub(crate) signs: bool,
    /// `Λ`, 1/mm².
    pub(crate) precision: Precision,
    expected: Expected,
    /// Mean square of what the model cannot express, per fingertip coordinate, mm².
    pub(crate) unexplained_mm2: f64,
}

impl MotionModel {
    pub(crate) fn of_dictionary(
        dictionary: &Dictionary,
        method: Method,
        ridge: f64,
    ) -> Result<Self, PlanError> {
        check_layout(dictionary.layout)?;
        dictionary.validate()?;
        let rank = dictionary.rank();
        if rank == 0 {
            return Err(PlanError::NoPrimitives);
        }
        let (mean_mm, precision) = match method {
            // As printed, activations are drawn to zero.
            Method::Paper => (DVector::zeros(rank), Precision::Ridge(ridge)),
            Method::Prior => (
                &dictionary.activation_mean_m * MM_PER_M,
                Precision::Blocks(vec![inverse_of_covariance(
                    "activations",
                    &(&dictionary.activation_covariance_m2 * (MM_PER_M * MM_PER_M)),
                )?]),
            ),
        };
        Ok(Self {
            layout: dictionary.layout,
            basis: Basis::dense(dictionary.primitives.clone()),
            base_mm: dictionary.offset_m.iter().map(|v| v * MM_PER_M).collect(),
            signs: dictionary.kind == DictionaryKind::Nmf,
            precision,
            expected: Expected::Always(mean_mm),
            unexplained_mm2: 0.0,
        })
    }

    pub(crate) fn of_residual(residual: &Residual) -> Result<Self, PlanError> {
        let layout = residual.layout;
        check_layout(layout)?;
        check_residual(residual)?;
        let squared = MM_PER_M * MM_PER_M;
        let precision = Precision::Blocks(vec![
            inverse_of_covariance("end conditions", &(&residual.ends_covariance * squared))?,
            inverse_of_covariance("activations", &(&residual.covariance_m2 * squared))?,
        ]);
        Ok(Self {
            layout,
            basis: Basis::smooth(layout, residual.primitives.clone()),
            base_mm: vec![0.0; layout.rows()],
            signs: false,
            precision,
            expected: Expected::ByEnds(Box::new(residual.clone())),
            unexplained_mm2: residual.unexplained_m2 * squared,
        })
    }

    /// Number of unknowns (n).
    pub(crate) fn unknowns(&self) -> usize {
        self.basis.unknowns()
    }

    /// The motion, mm (all rows).
    pub(crate) fn motion_mm(&self, unknowns: &DVector<f64>) -> Vec<f64> {
        self.basis.motion_mm(&self.base_mm, unknowns)
    }

    /// What one axis of something given is as a linear function of the unknowns: adds its row of
    /// factors to `row` and returns its value where they are zero, mm or mm/s.
    pub(crate) fn observe(&self, given: Given, axis: usize, row: &mut [f64]) -> f64 {
        let samples = self.layout.samples;
        match given {
            Given::Position { sample, finger } => {
                let at = SegmentLayout::row(sample, finger, axis);
                self.basis.add_row(at, 1.0, row);
                self.base_mm[at]
            }
            Given::Velocity { end, finger } => {
                let coordinate = SegmentLayout::row(0, finger, axis);
                if let Expected::ByEnds(_) = self.expected {
                    row[end.velocity_part() * SEGMENT_COORDINATES + coordinate] = 1.0;
                    return 0.0;
                }
                let from = match end {
                    End::First => coordinate,
                    End::Last => (samples - 2) * SEGMENT_COORDINATES + coordinate,
                };
                let rate = self.layout.rate_hz;
                self.basis.add_row(from + SEGMENT_COORDINATES, rate, row);
                self.basis.add_row(from, -rate, row);
                (self.base_mm[from + SEGMENT_COORDINATES] - self.base_mm[from]) * rate
            }
            Given::ObjectPosition { end } | Given::ObjectRotation { end } => {
                let sample = match end {
                    End::First => 0,
                    End::Last => samples - 1,
                };
                let first = match given {
                    Given::ObjectPosition { .. } => 0,
                    _ => 3,
                };
                let at = self.layout.object_row(sample, first + axis);
                self.basis.add_row(at, 1.0, row);
                self.base_mm[at]
            }
        }
    }

    /// What end conditions the target leaves open depends on: prepared once for what it gives.
    pub(crate) fn completion(&self, given: &[Given]) -> Option<Completion> {
        match &self.expected {
            Expected::Always(_) => None,
            Expected::ByEnds(residual) => Some(Completion::new(residual, given)),
        }
    }

    /// `mu` for given values (mm, three for each of `given`), mm.
    pub(crate) fn mean_mm(&self, completion: Option<&Completion>, values: &[f64]) -> DVector<f64> {
        match (&self.expected, completion) {
            (Expected::ByEnds(residual), Some(completion)) => {
                let likely = completion.likely(&residual.ends_mean, values);
                let activations = residual.expected_m(&likely);
                DVector::from_iterator(
                    self.unknowns(),
                    residual
                        .ends_mean
                        .iter()
                        .chain(activations.iter())
                        .map(|v| v * MM_PER_M),
                )
            }
            (Expected::Always(mean), _) => mean.clone(),
            (Expected::ByEnds(residual), None) => {
                let ends = residual.ends_mean.len();
                let mut mean = DVector::zeros(self.unknowns());
                mean.rows_mut(0, ends)
                    .copy_from(&(&residual.ends_mean * MM_PER_M));
                mean
            }
        }
    }
}

/// The end conditions that a target gives, and how those it does not give follow from them.
#[derive(Clone, Debug)]
pub(crate) struct Completion {
    /// End condition and place among the given values, of each known number.
    known: Vec<(usize, usize)>,
    /// End conditions that are not given.
    open: Vec<usize>,
    /// `C_ok C_kk⁻¹` (open x known).
    regression: DMatrix<f64>,
}

impl Completion {
    fn new(residual: &Residual, given: &[Given]) -> Self {
        let layout = residual.layout;
        let mut known = Vec::new();
        for (index, given) in given.iter().enumerate() {
            if let Some(first) = given.end_condition(layout) {
                known.extend((0..3).map(|axis| (first + axis, 3 * index + axis)));
            }
        }
        let open: Vec<usize> = (0..ends_len(layout))
            .filter(|i| known.iter().all(|(k, _)| k != i))
            .collect();
        let columns: Vec<usize> = known.iter().map(|(k, _)| *k).collect();
        let covariance = &residual.ends_covariance;
        let across = covariance.select_rows(&open).select_columns(&columns);
        let own = covariance.select_rows(&columns).select_columns(&columns);
        // A part of a positive definite covariance is one too.
        let regression = match Cholesky::<f64, Dyn>::new(own) {
            Some(factor) => factor.solve(&across.transpose()).transpose(),
            None => DMatrix::zeros(open.len(), columns.len()),
        };
        Self {
            known,
            open,
            regression,
        }
    }

    /// All end conditions (m, m/s): the given ones, and the conditional mean of the others.
    fn likely(&self, mean: &DVector<f64>, values: &[f64]) -> DVector<f64> {
        let mut ends = mean.clone();
        for &(end, place) in &self.known {
            ends[end] = values[place] / MM_PER_M;
        }
        let away = DVector::from_iterator(
            self.known.len(),
            self.known.iter().map(|&(end, _)| ends[end] - mean[end]),
        );
        for (&end, change) in self.open.iter().zip((&self.regression * away).iter()) {
            ends[end] += change;
        }
        ends
    }
}

fn check_layout(layout: SegmentLayout) -> Result<(), PlanError> {
    let SegmentLayout {
        samples, rate_hz, ..
    } = layout;
    if samples < 2 || !(rate_hz.is_finite() && rate_hz > 0.0) {
        return Err(PlanError::Layout { samples, rate_hz });
    }
    Ok(())
}

fn check_residual(residual: &Residual) -> Result<(), PlanError> {
    let rows = residual.layout.rows();
    let ends = ends_len(residual.layout);
    let rank = residual.primitives.ncols();
    for (what, expected, found) in [
        ("rows of the primitives", rows, residual.primitives.nrows()),
        (
            "length of the mean end conditions",
            ends,
            residual.ends_mean.len(),
        ),
        (
            "rows of the end conditions' covariance",
            ends,
            residual.ends_covariance.nrows(),
        ),
        (
            "columns of the end conditions' covariance",
            ends,
            residual.ends_covariance.ncols(),
        ),
        (
            "rows of the activations' covariance",
            rank,
            residual.covariance_m2.nrows(),
        ),
        (
            "columns of the activations' covariance",
            rank,
            residual.covariance_m2.ncols(),
        ),
    ] {
        if expected != found {
            return Err(PlanError::Shape {
                what,
                expected,
                found,
            });
        }
    }
    for (what, numbers) in [
        ("primitives", residual.primitives.as_slice()),
        ("mean end conditions", residual.ends_mean.as_slice()),
        (
            "end conditions' covariance",
            residual.ends_covariance.as_slice(),
        ),
        ("activations' covariance", residual.covariance_m2.as_slice()),
        ("unexplained variance", &[residual.unexplained_m2]),
    ] {
        if let Some(&value) = numbers.iter().find(|v| !v.is_finite()) {
            return Err(PlanError::NotFinite { what, value });
        }
    }
    Ok(())
}

/// Inverse of a covariance, 1/mm².
fn inverse_of_covariance(
    what: &'static str,
    covariance_mm2: &DMatrix<f64>,
) -> Result<DMatrix<f64>, PlanError> {
    inverse(covariance_mm2.clone()).ok_or_else(|| PlanError::Covariance {
        what,
        order: covariance_mm2.nrows(),
        smallest_m2: covariance_mm2.clone().symmetric_eigenvalues().min() / (MM_PER_M * MM_PER_M),
    })
}

/// Inverse of a symmetric positive definite matrix, exactly symmetric; `None` where it is not
/// positive definite.
pub(crate) fn inverse(matrix: DMatrix<f64>) -> Option<DMatrix<f64>> {
    let mut inverse = Cholesky::<f64, Dyn>::new(matrix)?.inverse();
    make_symmetric(&mut inverse);
    inverse.iter().all(|v| v.is_finite()).then_some(inverse)
}

/// Takes the mean of entries across the diagonal, which differ by rounding.
pub(crate) fn make_symmetric(matrix: &mut DMatrix<f64>) {
    for j in 0..matrix.ncols() {
        for i in 0..j {
            let mean = 0.5 * (matrix[(i, j)] + matrix[(j, i)]);
            (matrix[(i, j)], matrix[(j, i)]) = (mean, mean);
        }
    }
}
