//! Training data: where it is read from, checks, and the shift that makes it non-negative.

use std::ops::Range;

use inhand_model::{
    Finger, OBJECT_COORDINATES, SEGMENT_COORDINATES, SegmentLayout, SegmentOrigin, Segments,
};

use crate::block::BLOCK_COLUMNS;
use crate::error::{LearnError, check_setting};

/// Result of a look through the columns: the smallest and largest value of each coordinate of a sample,
/// metres (the 15 of the fingertips, and with the object its 6), and how many numbers are missing.
pub(crate) struct Survey {
    pub(crate) min_m: Vec<f64>,
    max_m: Vec<f64>,
    pub(crate) missing: usize,
}

/// Looks through the columns and checks that they can teach.
///
/// A fingertip that keeps a coordinate throughout is no fingertip. An object may: one that is only
/// pushed does not turn.
pub(crate) fn survey(columns: &dyn Columns, may_miss: bool) -> Result<Survey, LearnError> {
    let (layout, count) = (columns.layout(), columns.count());
    if count == 0 || layout.samples == 0 {
        return Err(LearnError::Data(format!(
            "no training segments ({} left out for missing samples): cannot learn primitives",
            columns.left_out()
        )));
    }
    let rows = layout.rows();
    let coordinates = SEGMENT_COORDINATES + layout.object_rows() / layout.samples;
    let mut survey = Survey {
        min_m: vec![f64::INFINITY; coordinates],
        max_m: vec![f64::NEG_INFINITY; coordinates],
        missing: 0,
    };
    let mut columns_m = vec![0.0; BLOCK_COLUMNS.min(count) * rows];
    for first in (0..count).step_by(BLOCK_COLUMNS) {
        let block = first..(first + BLOCK_COLUMNS).min(count);
        let columns_m = &mut columns_m[..block.len() * rows];
        columns.read(block.clone(), columns_m)?;
        for (segment, column) in block.zip(columns_m.chunks_exact(rows)) {
            survey.missing += check_numbers(columns, segment, column, may_miss)?;
            let (fingers, object) = column.split_at(layout.finger_rows());
            survey.widen(0, fingers.as_chunks::<SEGMENT_COORDINATES>().0);
            survey.widen(
                SEGMENT_COORDINATES,
                object.as_chunks::<OBJECT_COORDINATES>().0,
            );
        }
    }
    for i in 0..SEGMENT_COORDINATES {
        // With all its numbers missing a coordinate is constant as well.
        if survey.min_m[i] >= survey.max_m[i] {
            return Err(LearnError::Data(format!(
                "{} is {} m in every sample of {count} training segments: expected a fingertip that \
                 moves; check the marker, or leave these takes out",
                named(i),
                survey.min_m[i]
            )));
        }
    }
    Ok(survey)
}

/// Number of missing numbers of a column.
fn check_numbers(
    columns: &dyn Columns,
    segment: usize,
    column: &[f64],
    may_miss: bool,
) -> Result<usize, LearnError> {
    if column.iter().all(|v| v.is_finite()) {
        return Ok(0);
    }
    let wrong = |v: &f64| !(v.is_finite() || may_miss && v.is_nan());
    if let Some(row) = column.iter().position(wrong) {
        let origin = columns.origin(segment);
        let (t, coordinate) = place(columns.layout(), row);
        return Err(LearnError::Data(format!(
            "training segment {segment} (take {}, sample {}): {} is {}, expected a finite number of \
             metres",
            origin.take,
            origin.start + t,
            named(coordinate),
            column[row]
        )));
    }
    Ok(column.iter().filter(|v| v.is_nan()).count())
}

impl Survey {
    /// Takes samples of N coordinates, the first of them number `first`, into the range.
    fn widen<const N: usize>(&mut self, first: usize, samples: &[[f64; N]]) {
        let (min_m, max_m) = (&mut self.min_m[first..], &mut self.max_m[first..]);
        for sample in samples {
            for ((v, min), max) in sample.iter().zip(&mut *min_m).zip(&mut *max_m) {
                *min = min.min(*v);
                *max = max.max(*v);
            }
        }
    }
}

/// Sample of a row of a column, and which of the sample's coordinates it is.
pub(crate) fn place(layout: SegmentLayout, row: usize) -> (usize, usize) {
    match row.checked_sub(layout.finger_rows()) {
        None => (row / SEGMENT_COORDINATES, row % SEGMENT_COORDINATES),
        Some(row) => (
            row / OBJECT_COORDINATES,
            SEGMENT_COORDINATES + row % OBJECT_COORDINATES,
        ),
    }
}

/// Which one a coordinate of a sample is.
pub(crate) fn named(coordinate: usize) -> String {
    let body = match coordinate / 3 {
        finger if finger < Finger::COUNT => Finger::ALL[finger].name(),
        Finger::COUNT => "object position",
        _ => "object rotation",
    };
    format!("{body} axis {}", coordinate % 3)
}

/// A whole column from one number for each coordinate of a sample, the same at every sample.
pub(crate) fn at_every_sample(layout: SegmentLayout, coordinates: &[f64]) -> Vec<f64> {
    (0..layout.rows())
        .map(|row| coordinates[place(layout, row).1])
        .collect()
}

/// Refuses rank 0.
pub(crate) fn check_any_rank(rank: usize) -> Result<(), LearnError> {
    let expected = "1 or more: a dictionary has at least one primitive";
    check_setting(rank > 0, "rank", expected, rank as f64)
}

/// Checks a rank against the largest possible one.
pub(crate) fn check_rank(
    rank: usize,
    largest: usize,
    segments: usize,
    rows: usize,
    kind: &'static str,
) -> Result<(), LearnError> {
    check_any_rank(rank)?;
    if rank > largest {
        return Err(LearnError::RankTooLarge {
            rank,
            largest,
            segments,
            rows,
            kind,
        });
    }
    Ok(())
}

/// Training columns, in memory or not.
///
/// Learning asks for whole blocks in order, again and again, and now and then for a single column.
/// The same range has to give the same numbers each time.
pub trait Columns: Sync {
    /// Shape of every segment.
    fn layout(&self) -> SegmentLayout;

    /// Number of segments (n).
    fn count(&self) -> usize;

    /// Take and sample that a segment was cut from, for messages.
    fn origin(&self, segment: usize) -> SegmentOrigin;

    /// Segments that the takes would have given without gaps in addition, for messages.
    fn left_out(&self) -> usize;

    /// Copies some of the columns (rows x range), metres, one after the other; what is missing is
    /// NaN.
    ///
    /// # Errors
    ///
    /// [`LearnError::Data`] where they cannot be had.
    fn read(&self, segments: Range<usize>, into_m: &mut [f64]) -> Result<(), LearnError>;
}

impl Columns for Segments {
    fn layout(&self) -> SegmentLayout {
        Segments::layout(self)
    }

    fn count(&self) -> usize {
        self.len()
    }

    fn origin(&self, segment: usize) -> SegmentOrigin {
        self.origins()[segment]
    }

    fn left_out(&self) -> usize {
        self.left_out
    }

    fn read(&self, segments: Range<usize>, into_m: &mut [f64]) -> Result<(), LearnError> {
        let rows = Segments::layout(self).rows();
        let columns = &self.columns_m().as_slice()[segments.start * rows..segments.end * rows];
        into_m.copy_from_slice(columns);
        Ok(())
    }
}
