//! Rows of numbers on an even clock: the tracks of a take.

mod frames;
mod series;

use std::collections::VecDeque;
use std::ops::Range;
use std::sync::Arc;

use inhand_model::{Annotations, Clock, Finding, Recording, Source};
use rayon::prelude::*;

use self::frames::{Grid, TimeCheck};
pub(crate) use self::series::{RotationColumns, Series};
use crate::error::CaptureError;
use crate::table::Rows;
use crate::trial::{FirstFrame, TrialEvent};

/// Everything that a header says about a take.
pub(crate) struct Take {
    pub(crate) name: String,
    /// The clock of the trial: the first frame may be later.
    pub(crate) clock: Clock,
    /// Number of a trial's first frame in this format.
    pub(crate) counts_from: i64,
    pub(crate) events: Vec<TrialEvent>,
    pub(crate) source: Source,
    /// Markers and bodies.
    pub(crate) series: Vec<Series>,
    /// Whether a marker exactly at the origin is a missing one.
    pub(crate) zero_is_missing: bool,
    /// Error of the time column that is no finding, beside its rounding, seconds.
    pub(crate) time_tolerance_s: f64,
    /// Key under which the header promises a number of rows, and that number.
    pub(crate) declared_rows: Option<(&'static str, u64)>,
    pub(crate) findings: Vec<Finding>,
}

/// A take while its rows come in.
pub(crate) struct Assembly {
    file: String,
    /// Values of a row.
    width: usize,
    take: Take,
    grid: Grid,
    times: TimeCheck,
    /// Samples that have their place, but are not in the series yet.
    pending: VecDeque<Step>,
    /// Samples in the series.
    pub(crate) samples: usize,
    /// Samples taken out of the series.
    taken: usize,
    /// Events on the time line of the take; complete with the first row.
    pub(crate) annotations: Annotations,
}

/// Samples left out, then rows without a gap between them.
struct Step {
    gap: usize,
    rows: Arc<Rows>,
    range: Range<usize>,
}

impl Assembly {
    /// A take of rows of `width` values.
    pub(crate) fn new(file: &str, take: Take, width: usize, rows_at_most: u64) -> Self {
        Self {
            file: file.to_owned(),
            width,
            grid: Grid::new(file, rows_at_most, take.series.len()),
            times: TimeCheck::new(take.clock.rate_hz(), take.time_tolerance_s),
            take,
            pending: VecDeque::new(),
            samples: 0,
            taken: 0,
            annotations: Annotations::default(),
        }
    }

    /// Gives the next rows of the file their places.
    ///
    /// # Errors
    ///
    /// Frame numbers do not rise or leave out too much.
    pub(crate) fn add(&mut self, rows: Rows) -> Result<(), CaptureError> {
        if self.grid.rows == 0 && !rows.lines.is_empty() {
            let first = FirstFrame {
                number: rows.frames.first().copied(),
                time_s: rows.times_s.first().copied(),
                counts_from: self.take.counts_from,
            };
            let part = first.part(self.take.clock, &self.take.events, &self.file)?;
            self.take.clock = part.clock;
            self.take.findings.extend(part.findings);
            self.annotations = part.annotations;
        }
        if let Some(line) = rows.cut {
            let message = "the last row is cut off and left out: the file was cut";
            (self.take.findings).push(Finding::warning(format!("line {line}"), message));
        }
        let gaps = self.grid.place(&rows)?;
        self.times.look_at(&rows, &self.grid);
        let rows = Arc::new(rows);
        for (k, gap) in gaps.into_iter().enumerate() {
            match self.pending.back_mut() {
                Some(step) if k > 0 && gap == 0 => step.range.end += 1,
                _ => self.pending.push_back(Step {
                    gap,
                    rows: Arc::clone(&rows),
                    range: k..k + 1,
                }),
            }
        }
        Ok(())
    }

    /// Whether there are samples that are not in the series yet.
    pub(crate) fn has_pending(&self) -> bool {
        !self.pending.is_empty()
    }

    /// Puts the next samples into the series, at most so many.
    pub(crate) fn fill(&mut self, at_most: usize) {
        let (mut steps, mut left) = (Vec::new(), at_most);
        while left > 0
            && let Some(next) = self.pending.front_mut()
        {
            let gap = next.gap.min(left);
            let rows = next.range.len().min(left - gap);
            let start = next.range.start;
            next.gap -= gap;
            next.range.start += rows;
            left -= gap + rows;
            steps.push(Step {
                gap,
                rows: Arc::clone(&next.rows),
                range: start..start + rows,
            });
            if next.gap == 0 && next.range.is_empty() {
                self.pending.pop_front();
            }
        }
        self.samples += at_most - left;
        let (width, unit) = (self.width, self.take.source.length_unit);
        let zero_is_missing = self.take.zero_is_missing;
        self.take.series.par_iter_mut().for_each(|series| {
            for Step { gap, rows, range } in &steps {
                series.push_missing(*gap);
                series.push(rows, range.clone(), width, unit, zero_is_missing);
            }
        });
    }

    /// Takes the samples out of the series, as a take of its own without findings. The series get
    /// room for so many more.
    pub(crate) fn take_block(&mut self, room: usize) -> Result<Recording, CaptureError> {
        let (mut markers, mut bodies) = (Vec::new(), Vec::new());
        for series in &mut self.take.series {
            series.take(room, &mut markers, &mut bodies);
        }
        let block = Recording::new(
            self.take.name.clone(),
            self.take.clock.starting_at(self.taken),
            self.take.source.clone(),
            self.samples,
            markers,
            bodies,
        );
        self.taken += std::mem::take(&mut self.samples);
        block.map_err(|error| CaptureError::in_file(&self.file, error))
    }

    /// The end of the file.
    ///
    /// # Errors
    ///
    /// There was no row.
    pub(crate) fn end(&self) -> Result<(), CaptureError> {
        if self.grid.rows == 0 {
            return Err(CaptureError::no_samples(&self.file));
        }
        Ok(())
    }

    /// The whole take.
    pub(crate) fn finish(mut self) -> Result<Recording, CaptureError> {
        self.fill(usize::MAX);
        self.end()?;
        let mut recording = self.take_block(0)?;
        recording.findings = self.findings();
        recording.annotations = self.annotations;
        Ok(recording)
    }

    /// Findings so far.
    pub(crate) fn findings(&self) -> Vec<Finding> {
        let mut findings = self.take.findings.clone();
        if let Some((key, declared)) = self.take.declared_rows
            && declared != self.grid.rows
        {
            let found = self.grid.rows;
            let how = match found < declared {
                true => "read what is there; the file was cut or edited after the export",
                false => "read all; the file was edited after the export",
            };
            let message = format!("the header promises {declared} rows, found {found}: {how}");
            findings.push(Finding::warning(key, message));
        }
        findings.extend(self.grid.finding());
        findings.extend(self.times.finding());
        findings.extend(self.take.series.iter().flat_map(Series::findings));
        findings
    }
}
