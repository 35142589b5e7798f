//! Training data: checks, and the shift that makes it non-negative.

use inhand_model::{Configuration, Finger, SEGMENT_COORDINATES, Segments};

use crate::block::{BLOCK_COLUMNS, Block};
use crate::error::LearnError;

/// Smallest and largest value of each coordinate, metres.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Range {
    /// Smallest.
    pub(crate) min_m: Configuration,
    /// Largest.
    pub(crate) max_m: Configuration,
}

/// Checks that the segments can teach, and returns the range of each coordinate.
pub(crate) fn checked_range(segments: &Segments) -> Result<Range, LearnError> {
    if segments.is_empty() || segments.layout().samples == 0 {
        return Err(LearnError::NoSegments {
            left_out: segments.left_out,
        });
    }
    let mut range = Range {
        min_m: [f64::INFINITY; SEGMENT_COORDINATES],
        max_m: [f64::NEG_INFINITY; SEGMENT_COORDINATES],
    };
    for segment in 0..segments.len() {
        let column = segments.column_m(segment);
        if let Some(row) = column.iter().position(|v| !v.is_finite()) {
            let origin = segments.origins()[segment];
            let (finger, axis) = coordinate(row % SEGMENT_COORDINATES);
            return Err(LearnError::NotFinite {
                segment,
                take: origin.take,
                sample: origin.start + row / SEGMENT_COORDINATES,
                finger,
                axis,
                found: column[row],
            });
        }
        for configuration in column.as_chunks::<SEGMENT_COORDINATES>().0 {
            for (i, v) in configuration.iter().enumerate() {
                range.min_m[i] = range.min_m[i].min(*v);
                range.max_m[i] = range.max_m[i].max(*v);
            }
        }
    }
    for i in 0..SEGMENT_COORDINATES {
        if range.min_m[i] == range.max_m[i] {
            let (finger, axis) = coordinate(i);
            return Err(LearnError::ConstantCoordinate {
                finger,
                axis,
                value_m: range.min_m[i],
                segments: segments.len(),
            });
        }
    }
    Ok(range)
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

/// Finger and axis of one of the 15 coordinates.
fn coordinate(index: usize) -> (Finger, usize) {
    (Finger::ALL[index / 3], index % 3)
}

/// The columns minus a 15-number offset that repeats at every sample, in fixed blocks.
pub(crate) fn shifted_blocks(segments: &Segments, offset_m: &Configuration) -> Vec<Block> {
    let rows = segments.layout().rows();
    segments
        .columns_m()
        .as_slice()
        .chunks(BLOCK_COLUMNS * rows)
        .map(|columns| {
            let mut data = columns.to_vec();
            for configuration in data.as_chunks_mut::<SEGMENT_COORDINATES>().0 {
                for (v, offset) in configuration.iter_mut().zip(offset_m) {
                    *v -= offset;
                }
            }
            Block::new(data, rows)
        })
        .collect()
}
