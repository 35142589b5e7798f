//! Training data: checks, and the shift that makes it non-negative.

use inhand_model::{Finger, OBJECT_COORDINATES, SEGMENT_COORDINATES, SegmentLayout, Segments};

use crate::block::{BLOCK_COLUMNS, Block};
use crate::error::{Coordinate, LearnError};

/// Smallest and largest value of each coordinate of a sample, metres: the 15 of the fingertips, and
/// with the object its 6.
#[derive(Clone, Debug)]
pub(crate) struct Range {
    /// Smallest.
    pub(crate) min_m: Vec<f64>,
    /// Largest.
    pub(crate) max_m: Vec<f64>,
}

/// Checks that the segments can teach, and returns the range of each coordinate.
///
/// A fingertip that keeps a coordinate throughout is no fingertip. An object may: one that is only
/// pushed does not turn.
pub(crate) fn checked_range(segments: &Segments) -> Result<Range, LearnError> {
    let layout = segments.layout();
    if segments.is_empty() || layout.samples == 0 {
        return Err(LearnError::NoSegments {
            left_out: segments.left_out,
        });
    }
    let mut range = Range {
        min_m: vec![f64::INFINITY; coordinates(layout)],
        max_m: vec![f64::NEG_INFINITY; coordinates(layout)],
    };
    for segment in 0..segments.len() {
        let column = segments.column_m(segment);
        if let Some(row) = column.iter().position(|v| !v.is_finite()) {
            let origin = segments.origins()[segment];
            let (t, coordinate) = place(layout, row);
            return Err(LearnError::NotFinite {
                segment,
                take: origin.take,
                sample: origin.start + t,
                coordinate: named(coordinate),
                found: column[row],
            });
        }
        let (fingers, object) = column.split_at(layout.finger_rows());
        range.widen(0, fingers.as_chunks::<SEGMENT_COORDINATES>().0);
        range.widen(
            SEGMENT_COORDINATES,
            object.as_chunks::<OBJECT_COORDINATES>().0,
        );
    }
    for i in 0..SEGMENT_COORDINATES {
        if range.min_m[i] == range.max_m[i] {
            return Err(LearnError::ConstantCoordinate {
                finger: Finger::ALL[i / 3],
                axis: i % 3,
                value_m: range.min_m[i],
                segments: segments.len(),
            });
        }
    }
    Ok(range)
}

impl Range {
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

/// Coordinates of a sample: 15, with the object 21.
fn coordinates(layout: SegmentLayout) -> usize {
    SEGMENT_COORDINATES + if layout.object { OBJECT_COORDINATES } else { 0 }
}

/// Sample of a row of a column, and which of the sample's coordinates it is.
fn place(layout: SegmentLayout, row: usize) -> (usize, usize) {
    match row.checked_sub(layout.finger_rows()) {
        None => (row / SEGMENT_COORDINATES, row % SEGMENT_COORDINATES),
        Some(row) => (
            row / OBJECT_COORDINATES,
            SEGMENT_COORDINATES + row % OBJECT_COORDINATES,
        ),
    }
}

/// Which one a coordinate of a sample is.
pub(crate) fn named(coordinate: usize) -> Coordinate {
    let axis = coordinate % 3;
    match coordinate / 3 {
        body if body < Finger::COUNT => Coordinate::Fingertip {
            finger: Finger::ALL[body],
            axis,
        },
        Finger::COUNT => Coordinate::ObjectPosition { axis },
        _ => Coordinate::ObjectRotation { axis },
    }
}

/// A whole column from one number for each coordinate of a sample, the same at every sample.
pub(crate) fn at_every_sample(layout: SegmentLayout, coordinates: &[f64]) -> Vec<f64> {
    (0..layout.rows())
        .map(|row| coordinates[place(layout, row).1])
        .collect()
}

/// Checks a rank against the largest possible one.
pub(crate) fn check_rank(
    rank: usize,
    largest: usize,
    segments: &Segments,
    kind: &'static str,
) -> Result<(), LearnError> {
    if rank == 0 {
        return Err(LearnError::RankZero);
    }
    if rank > largest {
        return Err(LearnError::RankTooLarge {
            rank,
            largest,
            segments: segments.len(),
            rows: segments.layout().rows(),
            kind,
        });
    }
    Ok(())
}

/// The columns minus an offset column, in fixed blocks.
pub(crate) fn shifted_blocks(segments: &Segments, offset_m: &[f64]) -> Vec<Block> {
    let rows = segments.layout().rows();
    segments
        .columns_m()
        .as_slice()
        .chunks(BLOCK_COLUMNS * rows)
        .map(|columns| {
            let mut data = columns.to_vec();
            for column in data.chunks_exact_mut(rows) {
                for (v, offset) in column.iter_mut().zip(offset_m) {
                    *v -= offset;
                }
            }
            Block::new(data, rows)
        })
        .collect()
}
