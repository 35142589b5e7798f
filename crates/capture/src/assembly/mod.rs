//! From rows of numbers to tracks on an even clock.

mod frames;
mod rotation;
mod series;

use std::collections::VecDeque;
use std::io::Read;
use std::ops::Range;

use inhand_model::{BodyKind, Clock, Finding, MarkerKind, Recording, Source};
use rayon::prelude::*;

use self::frames::{Grid, TimeCheck};
use self::series::{Scale, Series, Tracked};
use crate::error::CaptureError;
use crate::lines::Lines;
use crate::settings::ReadSettings;
use crate::table::{Extent, Rows, Table};
use crate::text::{self, excerpt};

/// Where a body's rotation stands among the values of a row.
#[derive(Clone, Copy, Debug)]
pub(crate) enum RotationColumns {
    /// x, y, z, w.
    Quaternion([usize; 4]),
    /// Angles about x, y, z in degrees, and the axes in the order in which the intrinsic rotations
    /// follow each other.
    Euler { angles: [usize; 3], axes: [u8; 3] },
}

/// Where a marker or body stands among the values of a row.
#[derive(Debug)]
pub(crate) enum Entity {
    Marker {
        name: String,
        id: String,
        kind: MarkerKind,
        position: [usize; 3],
        quality: Option<usize>,
    },
    Body {
        name: String,
        id: String,
        kind: BodyKind,
        rotation: RotationColumns,
        position: [usize; 3],
        marker_error: Option<usize>,
    },
}

/// Everything a header says about a take.
#[derive(Debug)]
pub(crate) struct Take {
    pub(crate) name: String,
    pub(crate) clock: Clock,
    pub(crate) source: Source,
    pub(crate) entities: Vec<Entity>,
    /// Whether a marker exactly at the origin is a missing one.
    pub(crate) zero_is_missing: bool,
    /// How many rows the header promises, and under which key.
    pub(crate) declared_rows: Option<(&'static str, u64)>,
    pub(crate) findings: Vec<Finding>,
}

/// How many rows a header promises. Nothing depends on it, so text that is no count is a finding.
pub(crate) fn declared_rows(
    key: &'static str,
    text: Option<&str>,
    findings: &mut Vec<Finding>,
) -> Option<(&'static str, u64)> {
    let text = text.filter(|text| !text.is_empty())?;
    let count = text.parse().ok();
    if count.is_none() {
        findings.push(Finding::warning(
            key,
            format!(
                "expected a count, found \"{}\": counted what is there",
                excerpt(text.as_bytes())
            ),
        ));
    }
    count.map(|count| (key, count))
}

/// What a header says: of its columns, of its take, and where the rows start.
#[derive(Debug)]
pub(crate) struct Opened {
    pub(crate) table: Table,
    pub(crate) take: Take,
    /// Bytes above the first row.
    pub(crate) data_start: usize,
    /// Line of the first row, from 1.
    pub(crate) first_data_line: usize,
}

/// Where rows of numbers come from.
pub(crate) trait Pieces {
    /// The next rows, and what is wrong behind them; `None` at the end.
    fn next(&mut self) -> Result<Option<Parsed>, CaptureError>;
}

/// Consecutive rows, and what is wrong with the one that follows them.
pub(crate) type Parsed = (Vec<Rows>, Result<(), CaptureError>);

/// Rows of one kind below a header.
pub(crate) struct Text<R> {
    pub(crate) lines: Lines<R>,
    pub(crate) table: Table,
}

impl<R: Read> Pieces for Text<R> {
    fn next(&mut self) -> Result<Option<Parsed>, CaptureError> {
        let run = self.lines.next_run()?;
        Ok(run.map(|run| self.table.parse(&run)))
    }
}

/// A take while its rows come in.
pub(crate) struct Assembly<P> {
    pieces: P,
    file: String,
    /// Values of a row.
    width: usize,
    scale: Scale,
    name: String,
    clock: Clock,
    source: Source,
    declared_rows: Option<(&'static str, u64)>,
    header_findings: Vec<Finding>,
    series: Vec<Series>,
    grid: Grid,
    times: TimeCheck,
    /// Rows that have their place, but are not in the series yet.
    pending: VecDeque<Placed>,
    next: Next,
    /// Samples in the series.
    samples: usize,
    /// Samples taken out of the series.
    taken: usize,
}

/// Rows and how many frames are left out before each.
struct Placed {
    rows: Rows,
    gaps: Vec<usize>,
}

/// The first sample that is not in the series yet.
#[derive(Clone, Copy, Default)]
struct Next {
    /// Row of the first pending piece.
    row: usize,
    /// Samples left out before that row that are in the series.
    gap_done: usize,
}

/// Samples left out, then rows without a gap between them.
struct Step {
    piece: usize,
    gap: usize,
    rows: Range<usize>,
}

impl<R: Read> Assembly<Text<R>> {
    /// `lines` go on behind the header. `extent` is that of the whole file; the tracks get room for
    /// as many samples as it can hold if `whole`.
    pub(crate) fn of_text(lines: Lines<R>, opened: Opened, extent: Extent, whole: bool) -> Self {
        let Opened { table, take, .. } = opened;
        let below = extent.below(opened.data_start, opened.first_data_line - 1);
        let rows_at_most = table.rows_at_most(below);
        let file = table.file.clone();
        let width = table.values();
        let capacity = if whole { rows_at_most } else { 0 };
        Self::new(
            Text { lines, table },
            &file,
            take,
            width,
            rows_at_most,
            capacity,
        )
    }
}

impl<P: Pieces> Assembly<P> {
    /// A take of rows of `width` values; its tracks get room for `capacity` samples.
    pub(crate) fn new(
        pieces: P,
        file: &str,
        take: Take,
        width: usize,
        rows_at_most: u64,
        capacity: u64,
    ) -> Self {
        let series: Vec<Series> = (take.entities.into_iter())
            .map(|entity| Series::new(entity, capacity as usize, take.zero_is_missing))
            .collect();
        Self {
            pieces,
            file: file.to_owned(),
            width,
            scale: Scale::of(take.source.length_unit),
            grid: Grid::new(file, rows_at_most, series.len()),
            times: TimeCheck::new(take.clock.rate_hz()),
            name: take.name,
            clock: take.clock,
            source: take.source,
            declared_rows: take.declared_rows,
            header_findings: take.findings,
            series,
            pending: VecDeque::new(),
            next: Next::default(),
            samples: 0,
            taken: 0,
        }
    }

    /// Puts more rows into the series, up to `at_most` samples; false at the end of the file.
    ///
    /// # Errors
    ///
    /// [`CaptureError`] where a row is damaged, frame numbers do not rise or leave out too much, or
    /// there is no row at all.
    pub(crate) fn advance(&mut self, at_most: usize) -> Result<bool, CaptureError> {
        while self.pending.is_empty() {
            let Some((pieces, result)) = self.pieces.next()? else {
                if self.grid.rows == 0 {
                    return Err(CaptureError::NoSamples {
                        file: self.file.clone(),
                    });
                }
                return Ok(false);
            };
            for rows in pieces {
                // Rows before a damaged one may hold an earlier error.
                let gaps = self.grid.place(&rows)?;
                self.times.look_at(&rows, &self.grid);
                if rows.len() > 0 {
                    self.pending.push_back(Placed { rows, gaps });
                }
            }
            result?;
        }
        let steps = self.plan(at_most);
        let (pending, width, scale) = (&self.pending, self.width, self.scale);
        self.series.par_iter_mut().for_each(|series| {
            for step in &steps {
                series.push_missing(step.gap);
                let rows = &pending[step.piece].rows;
                series.push(rows, step.rows.clone(), width, scale);
            }
        });
        let added = steps.iter().map(|step| step.gap + step.rows.len());
        self.samples += added.sum::<usize>();
        let finished = |placed: &Placed, next: Next| next.row == placed.gaps.len();
        if let Some(last) = steps.last() {
            self.pending.drain(..last.piece);
        }
        if (self.pending.front()).is_some_and(|placed| finished(placed, self.next)) {
            self.pending.pop_front();
            self.next = Next::default();
        }
        Ok(true)
    }

    /// The next samples, at most so many, and moves on behind them.
    fn plan(&mut self, at_most: usize) -> Vec<Step> {
        let mut steps = Vec::new();
        let mut left = at_most;
        for (piece, Placed { gaps, .. }) in self.pending.iter().enumerate() {
            if piece > 0 {
                if left == 0 {
                    break;
                }
                self.next = Next::default();
            }
            while self.next.row < gaps.len() && left > 0 {
                let first = self.next.row;
                let gap = (gaps[first] - self.next.gap_done).min(left);
                left -= gap;
                self.next.gap_done += gap;
                let mut rows = first..first;
                if self.next.gap_done == gaps[first] && left > 0 {
                    let more = gaps[first + 1..].iter().take(left - 1);
                    let more = more.take_while(|&&gap| gap == 0).count();
                    rows.end += 1 + more;
                    left -= rows.len();
                    self.next = Next {
                        row: rows.end,
                        gap_done: 0,
                    };
                }
                steps.push(Step { piece, gap, rows });
            }
        }
        steps
    }

    /// Takes the samples out of the series, as a take of its own without findings.
    pub(crate) fn take_block(&mut self) -> Result<Recording, CaptureError> {
        let (mut markers, mut bodies) = (Vec::new(), Vec::new());
        for series in &mut self.series {
            match series.take() {
                Tracked::Marker(marker) => markers.push(marker),
                Tracked::Body(body) => bodies.push(body),
            }
        }
        let block = Recording::new(
            self.name.clone(),
            self.clock.starting_at(self.taken),
            self.source.clone(),
            self.samples,
            markers,
            bodies,
        );
        self.taken += std::mem::take(&mut self.samples);
        block.map_err(|source| CaptureError::Recording {
            file: self.file.clone(),
            source,
        })
    }

    /// The whole take.
    pub(crate) fn read_whole(&mut self) -> Result<Recording, CaptureError> {
        while self.advance(usize::MAX)? {}
        let mut recording = self.take_block()?;
        recording.findings = self.findings();
        Ok(recording)
    }

    /// What was odd so far.
    pub(crate) fn findings(&self) -> Vec<Finding> {
        let mut findings = self.header_findings.clone();
        if let Some((key, declared)) = self.declared_rows
            && declared != self.grid.rows
        {
            findings.push(Finding::warning(
                key,
                format!(
                    "the header promises {declared} rows, found {}: read what is there; the file \
                     was cut or edited after the export",
                    self.grid.rows
                ),
            ));
        }
        findings.extend(self.grid.finding());
        findings.extend(self.times.finding());
        findings.extend(self.series.iter().flat_map(Series::findings));
        findings
    }
}

/// Reads a header from the beginning of a file without byte-order mark.
pub(crate) type Open = fn(&[u8], &str, &ReadSettings) -> Result<Opened, CaptureError>;

/// Reads a whole take of rows from memory.
pub(crate) fn read_text(
    open: Open,
    bytes: &[u8],
    file_name: &str,
    settings: &ReadSettings,
) -> Result<Recording, CaptureError> {
    let text = text::without_byte_order_mark(bytes, file_name)?;
    let opened = open(text, file_name, settings)?;
    let mut extent = Extent::default();
    extent.add(text);
    let mut lines = Lines::new(&text[opened.data_start..], file_name);
    lines.skip_head(0, opened.first_data_line);
    let mut assembly = Assembly::of_text(lines, opened, extent, true);
    assembly.read_whole()
}
