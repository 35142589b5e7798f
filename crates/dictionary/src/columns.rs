//! Sources of training columns.

use std::ops::Range;

use inhand_model::{SegmentLayout, SegmentOrigin, Segments};

use crate::error::LearnError;

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
