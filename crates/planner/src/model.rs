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
use nalgebra::DVector;

use crate::MM_PER_M;
use crate::basis::Basis;
use crate::completion::Completion;
use crate::error::{PlanError, check_size};
use crate::method::Method;
use crate::precision::{Precision, inverse_of_covariance};
use crate::target_values::{End, TargetPart};

/// Expectation of the unknowns.
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
            return Err(PlanError::Model(
                "the dictionary has no primitives: planning needs at least one".to_owned(),
            ));
        }
        let (mean_mm, precision) = match method {
            // As printed, activations are drawn to zero.
            Method::Paper => (DVector::zeros(rank), Precision::Ridge(ridge)),
            Method::Prior => (
                &dictionary.activation_mean_m * MM_PER_M,
                Precision::Blocks(vec![(
                    0,
                    inverse_of_covariance("activations", &dictionary.activation_covariance_m2)?,
                )]),
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
        let ends = inverse_of_covariance("end conditions", &residual.ends_covariance)?;
        let activations = inverse_of_covariance("activations", &residual.covariance_m2)?;
        let precision = Precision::Blocks(vec![(0, ends), (ends_len(layout), activations)]);
        Ok(Self {
            layout,
            basis: Basis::smooth(&residual.curve.basis(layout), residual.primitives.clone()),
            base_mm: vec![0.0; layout.rows()],
            signs: false,
            precision,
            expected: Expected::ByEnds(Box::new(residual.clone())),
            unexplained_mm2: residual.unexplained_m2 * (MM_PER_M * MM_PER_M),
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

    /// What one axis of a part of a segment is as a linear function of the unknowns: adds its row of
    /// factors to `row` and returns its value where they are zero, mm or mm/s.
    pub(crate) fn observe(&self, part: TargetPart, axis: usize, row: &mut [f64]) -> f64 {
        let samples = self.layout.samples;
        match part {
            TargetPart::Position { sample, finger } => {
                let at = SegmentLayout::row(sample, finger, axis);
                self.basis.add_row(at, 1.0, row);
                self.base_mm[at]
            }
            TargetPart::Velocity { end, finger } => {
                let coordinate = SegmentLayout::row(0, finger, axis);
                if let Expected::ByEnds(_) = self.expected {
                    row[end.velocity_part() * SEGMENT_COORDINATES + coordinate] = 1.0;
                    return 0.0;
                }
                let sample = match end {
                    End::First => 0,
                    End::Last => samples - 2,
                };
                self.observe_step(sample, coordinate, row)
            }
            TargetPart::Step { sample, finger } => {
                self.observe_step(sample, SegmentLayout::row(0, finger, axis), row)
            }
            TargetPart::ObjectPosition { end } | TargetPart::ObjectRotation { end } => {
                let sample = match end {
                    End::First => 0,
                    End::Last => samples - 1,
                };
                let first = match part {
                    TargetPart::ObjectPosition { .. } => 0,
                    _ => 3,
                };
                let at = self.layout.object_row(sample, first + axis);
                self.basis.add_row(at, 1.0, row);
                self.base_mm[at]
            }
        }
    }

    /// The velocity of a coordinate from a sample to the next one, as [`MotionModel::observe`].
    fn observe_step(&self, sample: usize, coordinate: usize, row: &mut [f64]) -> f64 {
        let from = sample * SEGMENT_COORDINATES + coordinate;
        let rate = self.layout.rate_hz;
        self.basis.add_row(from + SEGMENT_COORDINATES, rate, row);
        self.basis.add_row(from, -rate, row);
        (self.base_mm[from + SEGMENT_COORDINATES] - self.base_mm[from]) * rate
    }

    /// How end conditions that the target leaves open follow from what it gives: prepared once.
    pub(crate) fn completion(&self, pattern: &[TargetPart]) -> Option<Completion> {
        match &self.expected {
            Expected::Always(_) => None,
            Expected::ByEnds(residual) => Some(Completion::new(residual, pattern, |part, axis| {
                let mut row = vec![0.0; self.unknowns()];
                self.observe(part, axis, &mut row);
                row
            })),
        }
    }

    /// `mu` for given values (mm, three for each part of the pattern), mm.
    pub(crate) fn mean_mm(&self, completion: Option<&Completion>, values: &[f64]) -> DVector<f64> {
        let residual = match &self.expected {
            Expected::Always(mean) => return mean.clone(),
            Expected::ByEnds(residual) => residual,
        };
        let ends = &residual.ends_mean;
        let mut mean_m = ends.clone().resize_vertically(self.unknowns(), 0.0);
        if let Some(completion) = completion {
            let expected_m = residual.expected_m(&completion.likely(residual, values));
            mean_m.rows_range_mut(ends.len()..).copy_from(&expected_m);
        }
        mean_m * MM_PER_M
    }
}

fn check_layout(layout: SegmentLayout) -> Result<(), PlanError> {
    let SegmentLayout {
        samples, rate_hz, ..
    } = layout;
    if samples < 2 || !(rate_hz.is_finite() && rate_hz > 0.0) {
        return Err(PlanError::Model(format!(
            "the dictionary's segments have {samples} samples at {rate_hz} Hz: \
             planning needs at least 2 samples and a positive rate"
        )));
    }
    Ok(())
}

fn check_residual(residual: &Residual) -> Result<(), PlanError> {
    let rows = residual.layout.rows();
    let ends = ends_len(residual.layout);
    let rank = residual.primitives.ncols();
    let check_shape = |what: &str, expected: (usize, usize), found: (usize, usize)| {
        check_size(&format!("rows of the {what}"), expected.0, found.0)?;
        check_size(&format!("columns of the {what}"), expected.1, found.1)
    };
    check_shape("primitives", (rows, rank), residual.primitives.shape())?;
    let found = residual.ends_mean.len();
    check_size("length of the mean end conditions", ends, found)?;
    let covariance = residual.ends_covariance.shape();
    check_shape("end conditions' covariance", (ends, ends), covariance)?;
    let (activations, conditions) = residual.expectation.profile().shape();
    check_size("number of expected activations", rank, activations)?;
    let what = "number of end conditions that expectations are for";
    check_size(what, ends, conditions)?;
    let covariance = residual.covariance_m2.shape();
    check_shape("activations' covariance", (rank, rank), covariance)?;
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
            return Err(PlanError::Model(format!(
                "the {what} to plan with hold {value}: expected finite numbers"
            )));
        }
    }
    Ok(())
}
