//! Boundary conditions as numbers, checked against the segments they belong to.

use inhand_model::{
    OBJECT_COORDINATES, Protocol, SEGMENT_COORDINATES, SegmentLayout, Segments, ends_len,
};
use nalgebra::{DMatrix, DVector};

use crate::covariance::moments_of;
use crate::data::named;
use crate::error::{LearnError, check_setting};

/// Largest distance of a segment's first and last sample from its boundary conditions, metres: a marker is
/// known no better. The cubic Hermite baseline leads from one boundary condition to the other, so a segment that
/// begins elsewhere would have a deviation with a jump.
const TOLERANCE_M: f64 = 1e-6;

/// Boundary conditions as columns (d x n).
///
/// The object's rotation is that of the segment's column: it is the same, but for a segment in which
/// the object turns by more than half a turn, where the two poses alone would tell the way back.
pub(super) fn ends_matrix(segments: &Segments) -> Result<DMatrix<f64>, LearnError> {
    let layout = segments.layout();
    let mut matrix = DMatrix::zeros(ends_len(layout), segments.len());
    for (segment, ends) in segments.ends().iter().enumerate() {
        let mut numbers = (ends.to_vector(layout)).ok_or_else(|| {
            LearnError::Data(format!(
                "training segment {segment} has no object pose at its ends, but its layout has the \
                 object: cut segments that carry it, or learn without the object"
            ))
        })?;
        if layout.object {
            let from = layout.object_row(layout.samples - 1, 3);
            let turned = &segments.column_m(segment)[from..from + 3];
            let place = numbers.len() - 3;
            numbers.as_mut_slice()[place..].copy_from_slice(turned);
        }
        check_finite(segments, segment, &numbers)?;
        if segments.protocol() == Protocol::Published {
            check_same(segments, segment, &numbers)?;
        }
        matrix.column_mut(segment).copy_from(&numbers);
    }
    Ok(matrix)
}

fn check_finite(
    segments: &Segments,
    segment: usize,
    numbers: &DVector<f64>,
) -> Result<(), LearnError> {
    let Some(i) = numbers.iter().position(|v| !v.is_finite()) else {
        return Ok(());
    };
    let (condition, coordinate) = match (i / SEGMENT_COORDINATES, i % SEGMENT_COORDINATES) {
        (0, c) => ("first position", c),
        (1, c) => ("last position", c),
        (2, c) => ("first velocity", c),
        (3, c) => ("last velocity", c),
        (_, c @ 0..3) => ("first position", SEGMENT_COORDINATES + c),
        (_, c) => ("last position", SEGMENT_COORDINATES + c - 3),
    };
    Err(LearnError::Data(format!(
        "training segment {segment} (take {}): the {condition} of {} is {}, expected a finite number",
        segments.origins()[segment].take,
        named(coordinate),
        numbers[i]
    )))
}

/// Checks that the segment begins and ends where its boundary conditions say.
fn check_same(
    segments: &Segments,
    segment: usize,
    numbers: &DVector<f64>,
) -> Result<(), LearnError> {
    let layout = segments.layout();
    let column = segments.column_m(segment);
    let last = layout.samples - 1;
    let fingers = (0..2 * SEGMENT_COORDINATES).map(|i| {
        let (end, c) = (i / SEGMENT_COORDINATES, i % SEGMENT_COORDINATES);
        (i, end * last, end * last * SEGMENT_COORDINATES + c, c)
    });
    let object = (0..if layout.object { OBJECT_COORDINATES } else { 0 }).map(|i| {
        let (t, c) = (i / 3 * last, i % 3);
        (
            4 * SEGMENT_COORDINATES + i,
            t,
            layout.object_row(t, c),
            SEGMENT_COORDINATES + c,
        )
    });
    for (number, t, row, coordinate) in fingers.chain(object) {
        if (numbers[number] - column[row]).abs() > TOLERANCE_M {
            let origin = segments.origins()[segment];
            return Err(LearnError::Data(format!(
                "training segment {segment} (take {}, sample {}): {} is {} m, but the boundary conditions say \
                 {} m: give each segment its own boundary conditions",
                origin.take,
                origin.start + t,
                named(coordinate),
                column[row],
                numbers[number]
            )));
        }
    }
    Ok(())
}

/// Mean and covariance of the boundary conditions, shrunk in units of their standard deviations:
/// positions and velocities have no common scale.
pub(super) fn ends_moments(
    ends: &DMatrix<f64>,
) -> Result<(DVector<f64>, DMatrix<f64>), LearnError> {
    let mean = ends.column_mean();
    let deviation = DVector::from_fn(ends.nrows(), |i, _| {
        // Not nalgebra's `column_variance`, which loses digits where the mean is large. A coordinate
        // that never changed is taken to be known to a micrometre (or micrometre a second).
        let squares: f64 = ends.row(i).iter().map(|v| (v - mean[i]).powi(2)).sum();
        (squares / ends.ncols() as f64).sqrt().max(1e-6)
    });
    let mut scaled = ends.clone();
    for mut column in scaled.column_iter_mut() {
        column.component_div_assign(&deviation);
    }
    let moments = moments_of(1, ends.nrows(), |_| Ok(scaled.as_slice().to_vec()))?;
    let mut covariance = moments.covariance;
    for j in 0..covariance.ncols() {
        for i in 0..covariance.nrows() {
            covariance[(i, j)] *= deviation[i] * deviation[j];
        }
    }
    Ok((moments.mean.component_mul(&deviation), covariance))
}

/// Checks that there is time between the first and the last sample.
pub(super) fn check_layout(layout: SegmentLayout) -> Result<(), LearnError> {
    let (samples, rate_hz) = (layout.samples, layout.rate_hz);
    let expected = "2 or more: a curve has a first and a last one";
    check_setting(
        samples >= 2,
        "samples of a segment",
        expected,
        samples as f64,
    )?;
    let positive = rate_hz.is_finite() && rate_hz > 0.0;
    let name = "rate of the segments in Hz";
    check_setting(positive, name, "a positive number", rate_hz)
}
