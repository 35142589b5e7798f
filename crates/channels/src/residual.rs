//! The learned deviation in a dictionary's file.

use inhand_model::{
    Bandwidths, Calibration, Expectation, ExpectationWeights, Finger, OBJECT_COORDINATES, Residual,
    SEGMENT_COORDINATES, SegmentLayout, Validation, ends_len,
};
use nalgebra::{DMatrix, DVector};

use crate::dictionary::{Unfit, matrix};
use crate::messages;

/// Rows of one block of primitives: where each of its numbers stands in a segment's column.
fn block_rows(layout: SegmentLayout, block: usize) -> Vec<usize> {
    let (start, stride, width) = if block < Finger::COUNT {
        (3 * block, SEGMENT_COORDINATES, 3)
    } else {
        (layout.finger_rows(), OBJECT_COORDINATES, OBJECT_COORDINATES)
    };
    (0..layout.samples)
        .flat_map(|t| {
            let first = start + t * stride;
            first..first + width
        })
        .collect()
}

pub(crate) fn to_message(residual: &Residual) -> messages::Residual {
    let expectation = &residual.expectation;
    let mut start = 0;
    let primitives = (expectation.blocks().iter().enumerate())
        .map(|(block, &count)| {
            let rows = block_rows(residual.layout, block);
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
    }
}

pub(crate) fn from_message(
    message: messages::Residual,
    layout: SegmentLayout,
) -> Result<Residual, Unfit> {
    let ends = ends_len(layout);
    let (blocks, primitives) = primitives(&message.primitives, layout)?;
    let rank = primitives.ncols();
    let count = message.demonstration_ends.len() / ends;
    for width in [message.hand_bandwidth, message.finger_bandwidth] {
        if !(width.is_finite() && width > 0.0) {
            return Err(Unfit::new("positive widths of the kernels", width));
        }
    }
    let weights = [
        message.profile_weight,
        message.hand_weight,
        message.finger_weight,
        message.unexplained_m2,
    ];
    if let Some(number) = weights.iter().find(|v| !(v.is_finite() && **v >= 0.0)) {
        return Err(Unfit::new("weights and squares not below zero", number));
    }
    let bandwidths = Bandwidths {
        hand: message.hand_bandwidth,
        finger: message.finger_bandwidth,
    };
    let weights = ExpectationWeights {
        profile: message.profile_weight,
        hand: message.hand_weight,
        finger: message.finger_weight,
    };
    let profile = finite("profile", matrix("profile", rank, ends, message.profile)?)?;
    let demonstrations = matrix(
        "demonstrations' end conditions",
        ends,
        count,
        message.demonstration_ends,
    )?;
    let answers = matrix(
        "demonstrations' activations",
        rank,
        count,
        message.demonstration_answers_m,
    )?;
    let expectation = Expectation::new(
        layout,
        blocks,
        profile,
        finite("demonstrations' end conditions", demonstrations)?,
        finite("demonstrations' activations", answers)?,
    )
    .weighted(bandwidths, weights);
    let covariance = |what, size, numbers| finite(what, matrix(what, size, size, numbers)?);
    let ends_mean = matrix("mean end conditions", ends, 1, message.ends_mean)?;
    Ok(Residual {
        layout,
        ends_mean: DVector::from_column_slice(finite("mean end conditions", ends_mean)?.as_slice()),
        ends_covariance: covariance("end conditions' covariance", ends, message.ends_covariance)?,
        primitives,
        expectation,
        covariance_m2: covariance("deviations' covariance", rank, message.covariance_m2)?,
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
    messages: &[messages::DeviationPrimitives],
    layout: SegmentLayout,
) -> Result<(Vec<usize>, DMatrix<f64>), Unfit> {
    let expected = Finger::COUNT + usize::from(layout.object);
    if messages.len() != expected {
        return Err(Unfit::new(
            format!("primitives of {expected} parts"),
            messages.len(),
        ));
    }
    let mut blocks = Vec::new();
    for (block, message) in messages.iter().enumerate() {
        let height = block_rows(layout, block).len();
        let count = message.primitives.len() / height.max(1);
        if message.count != count as u64 || count * height != message.primitives.len() {
            return Err(Unfit::new(
                format!("{} primitives of {height} numbers", message.count),
                format!("{} numbers", message.primitives.len()),
            ));
        }
        blocks.push(count);
    }
    let mut primitives = DMatrix::zeros(layout.rows(), blocks.iter().sum());
    let mut start = 0;
    for (block, message) in messages.iter().enumerate() {
        let rows = block_rows(layout, block);
        for (j, column) in message.primitives.chunks_exact(rows.len()).enumerate() {
            for (&row, value) in rows.iter().zip(column) {
                primitives[(row, start + j)] = *value;
            }
        }
        start += blocks[block];
    }
    Ok((blocks, finite("primitives of deviations", primitives)?))
}

fn finite(what: &str, matrix: DMatrix<f64>) -> Result<DMatrix<f64>, Unfit> {
    match matrix.as_slice().iter().find(|v| !v.is_finite()) {
        None => Ok(matrix),
        Some(number) => Err(Unfit::new(format!("finite numbers in the {what}"), number)),
    }
}
