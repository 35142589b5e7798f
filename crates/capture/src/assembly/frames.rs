//! The frame column as an even grid, and the time column as a check of it.

use inhand_model::Finding;

use crate::error::CaptureError;
use crate::table::Rows;

/// A jump in the frame column becomes missing samples as long as all jumps together leave out at
/// most this many times the rows that the file can hold...
const LEFT_OUT_PER_ROW: u64 = 10;

/// ...or this many samples over all entities, whichever is more: a file cut by hand to a few rows
/// still reads, and no small file asks for memory without bound.
const LEFT_OUT_SAMPLES: u64 = 100_000;

/// Steps to which software rounds the time column: some versions of Motive write milliseconds, TRC
/// files three to six decimals. Both the row's time and the first row's carry half a step at most.
const TIME_STEPS_S: [f64; 4] = [1e-3, 1e-4, 1e-5, 1e-6];

/// Largest distance of a rounded time from a multiple of its step, in single precision included.
const TIME_ON_STEP_S: f64 = 1e-7;

/// Largest error of a time column beyond its rounding.
const TIME_MARGIN_S: f64 = 1e-6;

/// Relative precision of a time kept in single precision before it was printed.
const TIME_SINGLE_PRECISION: f64 = 1.2e-7;

/// Rows on the even grid of frames.
#[derive(Default)]
pub(super) struct Grid {
    file: String,
    rows_at_most: u64,
    limit: u64,
    pub(super) rows: u64,
    first_frame: i64,
    last_frame: i64,
    left_out: u64,
    jumps: usize,
    first_jump: Option<(usize, i64, i64)>,
}

impl Grid {
    pub(super) fn new(file: &str, rows_at_most: u64, entities: usize) -> Self {
        let by_rows = LEFT_OUT_PER_ROW.saturating_mul(rows_at_most);
        Self {
            file: file.to_owned(),
            rows_at_most,
            limit: by_rows.max(LEFT_OUT_SAMPLES / entities.max(1) as u64),
            ..Self::default()
        }
    }

    /// The number of frames left out before each row.
    pub(super) fn place(&mut self, rows: &Rows) -> Result<Vec<usize>, CaptureError> {
        let mut gaps = Vec::with_capacity(rows.lines.len());
        for (k, &line) in rows.lines.iter().enumerate() {
            // Without a frame column the rows are the frames.
            let frame = rows.frames.get(k).copied().unwrap_or(self.last_frame + 1);
            gaps.push(self.gap_before(frame, line)?);
            self.rows += 1;
            self.last_frame = frame;
        }
        Ok(gaps)
    }

    fn gap_before(&mut self, frame: i64, line: usize) -> Result<usize, CaptureError> {
        if self.rows == 0 {
            self.first_frame = frame;
            return Ok(0);
        }
        let previous = self.last_frame;
        let step = frame - previous;
        if step < 1 {
            let problem = format!(
                "frame {frame} follows frame {previous}: expected rising frame numbers; are two \
                 takes joined in this file?"
            );
            return Err(CaptureError::in_line(&self.file, line, problem));
        }
        let gap = step.unsigned_abs() - 1;
        if gap > 0 {
            self.left_out += gap;
            self.jumps += 1;
            self.first_jump.get_or_insert((line, previous, frame));
        }
        match usize::try_from(gap) {
            Ok(gap) if self.left_out <= self.limit => Ok(gap),
            _ => {
                let problem = format!(
                    "frame {frame} follows frame {previous}: {} frames left out in a file of {} \
                     rows cannot be one take (at most {} are taken as missing samples); split the \
                     file there",
                    self.left_out, self.rows_at_most, self.limit
                );
                Err(CaptureError::in_line(&self.file, line, problem))
            }
        }
    }

    pub(super) fn finding(&self) -> Option<Finding> {
        let (line, previous, frame) = self.first_jump?;
        Some(Finding::warning(
            format!("line {line}"),
            format!(
                "frame {frame} follows frame {previous}; in all the frame column jumps {} times \
                 and leaves out {} frames: taken as missing samples",
                self.jumps, self.left_out
            ),
        ))
    }
}

/// The time column against `(frame - first frame) / rate`.
#[derive(Default)]
pub(super) struct TimeCheck {
    rate_hz: f64,
    tolerance_s: f64,
    first_time_s: Option<(f64, i64)>,
    /// Index of the coarsest of [`TIME_STEPS_S`] that all times so far are multiples of.
    step: usize,
    worst_s: f64,
    worst: Option<(usize, f64, f64)>,
}

impl TimeCheck {
    pub(super) fn new(rate_hz: f64, tolerance_s: f64) -> Self {
        Self {
            rate_hz,
            tolerance_s,
            ..Self::default()
        }
    }

    pub(super) fn look_at(&mut self, rows: &Rows, grid: &Grid) {
        for (k, &time_s) in rows.times_s.iter().enumerate() {
            if time_s.is_nan() {
                continue;
            }
            let frame = rows.frames.get(k).copied();
            let frame = frame
                .unwrap_or(grid.first_frame + (grid.rows as i64) - (rows.lines.len() - k) as i64);
            while self.step + 1 < TIME_STEPS_S.len()
                && !is_multiple(time_s, TIME_STEPS_S[self.step])
            {
                self.step += 1;
            }
            let (first_s, first_frame) = *self.first_time_s.get_or_insert((time_s, frame));
            let expected_s = first_s + (frame - first_frame) as f64 / self.rate_hz;
            let off_s = (time_s - expected_s).abs() - TIME_SINGLE_PRECISION * time_s.abs();
            if off_s > self.worst_s {
                self.worst_s = off_s;
                self.worst = Some((rows.lines[k], time_s, expected_s));
            }
        }
    }

    pub(super) fn finding(&self) -> Option<Finding> {
        let rounding_s = (TIME_STEPS_S[self.step] + TIME_MARGIN_S).max(self.tolerance_s);
        let (line, found_s, expected_s) = self.worst.filter(|_| self.worst_s > rounding_s)?;
        Some(Finding::warning(
            format!("line {line}"),
            format!(
                "the time column says {found_s:.6} s where frame and rate ({} Hz) give \
                 {expected_s:.6} s; this is the worst row: times are taken from the frames",
                self.rate_hz
            ),
        ))
    }
}

fn is_multiple(time_s: f64, step_s: f64) -> bool {
    let steps = time_s / step_s;
    (steps - steps.round()).abs() * step_s < TIME_ON_STEP_S
}
