//! The learned deviation in a dictionary's file.

use inhand_model::{
    Bandwidths, Calibration, DeviationPredictor, PredictorWeights, Residual, SegmentLayout,
    SmoothCurve, Validation, ends_len,
};
use nalgebra::{DMatrix, DVector};

use super::Decoder;
use crate::error::ChannelError;
use crate::messages;

pub(super) fn to_message(residual: &Residual) -> messages::Residual {
    let expectation = &residual.expectation;
    let mut start = 0;
    let primitives = (expectation.blocks().iter().enumerate())
        .map(|(block, &count)| {
            let rows: Vec<_> = residual.layout.part_rows(block).collect();
            let columns = start..start + count;
            start += count;
            messages::DeviationPrimitives {
                count: count as u64,
                primitives: columns
                    .flat_map(|j| rows.iter().map(move |&row| (row, j)))
                    .map(|place| residual.primitives[place])
                    .collect(),
            }
        })
        .collect();
    let (bandwidths, weights) = (expectation.bandwidths(), expectation.weights());
    let validation = residual.validation;
    messages::Residual {
        ends_mean: residual.ends_mean.as_slice().to_vec(),
        ends_covariance: residual.ends_covariance.as_slice().to_vec(),
        primitives,
        profile: expectation.profile().as_slice().to_vec(),
        demonstration_ends: expectation.ends().as_slice().to_vec(),
        demonstration_answers_m: expectation.answers_m().as_slice().to_vec(),
        hand_bandwidth: bandwidths.hand,
        finger_bandwidth: bandwidths.finger,
        profile_weight: weights.profile,
        hand_weight: weights.hand,
        finger_weight: weights.finger,
        covariance_m2: residual.covariance_m2.as_slice().to_vec(),
        unexplained_m2: residual.unexplained_m2,
        calibration: (residual.calibration.iter())
            .map(|calibration| messages::CorridorWidth {
                share: calibration.share,
                mahalanobis: calibration.mahalanobis,
            })
            .collect(),
        validation_folds: validation.folds as u64,
        validation_segments: validation.segments as u64,
        validation_smooth_error_m: validation.smooth_error_m,
        validation_error_m: validation.error_m,
        validation_standard_error_m: validation.standard_error_m,
        curve: messages::SmoothCurve::from(residual.curve).into(),
    }
}

impl Decoder<'_> {
    pub(super) fn residual(
        &self,
        message: messages::Residual,
        layout: SegmentLayout,
    ) -> Result<Residual, ChannelError> {
        let ends = ends_len(layout);
        let (blocks, primitives) = self.primitives(&message.primitives, layout)?;
        let rank = primitives.ncols();
        let count = message.demonstration_ends.len() / ends;
        let bandwidths = Bandwidths {
            hand: message.hand_bandwidth,
            finger: message.finger_bandwidth,
        };
        for width in [bandwidths.hand, bandwidths.finger] {
            if !(width.is_finite() && width > 0.0) {
                return Err(self.error("positive widths of the kernels", width));
            }
        }
        let weights = PredictorWeights {
            profile: message.profile_weight,
            hand: message.hand_weight,
            finger: message.finger_weight,
        };
        let not_negative = [
            weights.profile,
            weights.hand,
            weights.finger,
            message.unexplained_m2,
        ];
        if let Some(number) = (not_negative.iter()).find(|v| !(v.is_finite() && **v >= 0.0)) {
            return Err(self.error("weights and squares not below zero", number));
        }
        let conditions = "demonstrations' boundary conditions";
        let activations = "demonstrations' activations";
        let expectation = DeviationPredictor::new(
            layout,
            blocks,
            self.matrix("profile", (rank, ends), message.profile)?,
            self.matrix(conditions, (ends, count), message.demonstration_ends)?,
            self.matrix(activations, (rank, count), message.demonstration_answers_m)?,
        )
        .weighted(bandwidths, weights);
        let mean = self.matrix("mean boundary conditions", (ends, 1), message.ends_mean)?;
        let covariance = "boundary conditions' covariance";
        Ok(Residual {
            layout,
            // Older versions knew one curve, and stated none.
            curve: match message.curve {
                0 => SmoothCurve::default(),
                curve => messages::SmoothCurve::to_model(curve)
                    .ok_or_else(|| self.error("a smooth curve", curve))?,
            },
            ends_mean: mean.column(0).into_owned(),
            ends_covariance: self.matrix(covariance, (ends, ends), message.ends_covariance)?,
            primitives,
            expectation,
            covariance_m2: self.matrix(
                "deviations' covariance",
                (rank, rank),
                message.covariance_m2,
            )?,
            unexplained_m2: message.unexplained_m2,
            calibration: (message.calibration.iter())
                .map(|width| Calibration {
                    share: width.share,
                    mahalanobis: width.mahalanobis,
                })
                .collect(),
            validation: Validation {
                folds: message.validation_folds as usize,
                segments: message.validation_segments as usize,
                smooth_error_m: message.validation_smooth_error_m,
                error_m: message.validation_error_m,
                standard_error_m: message.validation_standard_error_m,
            },
        })
    }

    /// Sizes of the blocks, and all primitives as columns of whole segments.
    fn primitives(
        &self,
        messages: &[messages::DeviationPrimitives],
        layout: SegmentLayout,
    ) -> Result<(Vec<usize>, DMatrix<f64>), ChannelError> {
        let expected = layout.parts();
        if messages.len() != expected {
            let expected = format!("primitives of {expected} parts");
            return Err(self.error(expected, messages.len()));
        }
        let (mut blocks, mut columns) = (Vec::new(), Vec::new());
        for (block, message) in messages.iter().enumerate() {
            let rows: Vec<_> = layout.part_rows(block).collect();
            let (height, numbers) = (rows.len(), &message.primitives);
            let count = numbers.len() / height.max(1);
            if message.count != count as u64 || count * height != numbers.len() {
                return Err(self.error(
                    format!("{} primitives of {height} numbers", message.count),
                    format!("{} numbers", numbers.len()),
                ));
            }
            if let Some(number) = numbers.iter().find(|number| !number.is_finite()) {
                return Err(self.error("finite numbers in the primitives of deviations", number));
            }
            for values in numbers.chunks_exact(height.max(1)) {
                let mut column = DVector::zeros(layout.rows());
                for (&row, value) in rows.iter().zip(values) {
                    column[row] = *value;
                }
                columns.push(column);
            }
            blocks.push(count);
        }
        // A matrix cannot be made of no columns at all.
        let mut primitives = DMatrix::zeros(layout.rows(), columns.len());
        for (mut place, column) in primitives.column_iter_mut().zip(&columns) {
            place.copy_from(column);
        }
        Ok((blocks, primitives))
    }
}
