//! The lines of a row-typed file.

use memchr::memchr;

use crate::error::CaptureError;
use crate::lines::MAX_LINE_BYTES;
use crate::table::{cell_number, frame};
use crate::text::{self, excerpt};

/// Contents of a line.
pub(super) enum TypedRow<'a> {
    /// A comment, or nothing.
    Nothing,
    LeftHanded,
    Info {
        key: &'a str,
        value: &'a str,
    },
    Definition(Definition<'a>),
    Frame(FrameLine<'a>),
    Body(BodyLine<'a>),
}

/// A body as defined above the frames.
pub(super) struct Definition<'a> {
    pub(super) name: &'a str,
    pub(super) id: &'a str,
    /// Markers that it has.
    pub(super) markers: usize,
}

/// Bodies and markers at one frame.
pub(super) struct FrameLine<'a> {
    pub(super) number: i64,
    /// NaN where blank.
    pub(super) time_s: f64,
    /// ID, position and quaternion of each body, x, y, z, w last.
    pub(super) bodies: Vec<(&'a str, [f64; 7])>,
    pub(super) markers: Vec<SeenMarker<'a>>,
}

pub(super) struct SeenMarker<'a> {
    pub(super) position: [f64; 3],
    pub(super) id: &'a str,
    /// Empty in version 1.
    pub(super) name: &'a str,
}

/// More about a body at one frame.
pub(super) struct BodyLine<'a> {
    pub(super) frame: i64,
    pub(super) id: &'a str,
    /// Whether the pose is that of this frame.
    pub(super) tracked: bool,
    /// Positions of its markers by the fit.
    pub(super) fitted: Vec<[f64; 3]>,
    /// Positions as seen, NaN where they were not.
    pub(super) seen: Vec<[f64; 3]>,
    pub(super) quality: Vec<f64>,
}

/// The lines of a file in memory.
pub(super) struct TypedLines<'a> {
    file: &'a str,
    rest: &'a [u8],
    number: usize,
    /// Whether a frame was passed: from there on rows of bodies are no definitions.
    in_frames: bool,
}

impl<'a> TypedLines<'a> {
    pub(super) fn new(bytes: &'a [u8], file: &'a str) -> Self {
        Self {
            file,
            rest: bytes,
            number: 0,
            in_frames: false,
        }
    }

    /// The next line and its number; `None` at the end.
    pub(super) fn next_row(&mut self) -> Result<Option<(usize, TypedRow<'a>)>, CaptureError> {
        if self.rest.is_empty() {
            return Ok(None);
        }
        self.number += 1;
        let end = memchr(b'\n', self.rest).unwrap_or(self.rest.len());
        if end > MAX_LINE_BYTES {
            let (file, line) = (self.file, self.number);
            return Err(CaptureError::line_too_long(file, line, MAX_LINE_BYTES));
        }
        let line = &self.rest[..end];
        self.rest = self.rest.get(end + 1..).unwrap_or_default();
        let row = self.row(line.strip_suffix(b"\r").unwrap_or(line))?;
        Ok(Some((self.number, row)))
    }

    fn row(&mut self, line: &'a [u8]) -> Result<TypedRow<'a>, CaptureError> {
        let mut cells = Cells {
            file: self.file,
            line: self.number,
            rest: Some(line),
            column: 0,
        };
        let kind = cells.bytes("a row type")?;
        match kind.trim_ascii().to_ascii_lowercase().as_slice() {
            b"" | b"comment" | b"righthanded" => Ok(TypedRow::Nothing),
            b"lefthanded" => Ok(TypedRow::LeftHanded),
            b"info" => Ok(TypedRow::Info {
                key: cells.text("a key")?,
                value: cells.text("a value")?,
            }),
            b"frame" => {
                self.in_frames = true;
                cells.frame_line().map(TypedRow::Frame)
            }
            b"rigidbody" | b"trackable" if self.in_frames => cells.body_line().map(TypedRow::Body),
            b"rigidbody" | b"trackable" => cells.definition().map(TypedRow::Definition),
            _ => Err(cells.error(
                "comment, info, rigidbody, trackable, frame, righthanded or lefthanded",
                kind,
            )),
        }
    }
}

/// The cells of a line, taken one after the other.
struct Cells<'a> {
    file: &'a str,
    line: usize,
    /// The rest of the line; `None` behind the last cell.
    rest: Option<&'a [u8]>,
    /// Cells taken.
    column: usize,
}

impl<'a> Cells<'a> {
    fn definition(&mut self) -> Result<Definition<'a>, CaptureError> {
        let name = self.text("a name")?;
        let id = self.text("an ID")?;
        let markers = self.count("a count of markers")?;
        self.expect_more(markers, 3)?;
        Ok(Definition { name, id, markers })
    }

    fn frame_line(&mut self) -> Result<FrameLine<'a>, CaptureError> {
        let number = self.frame_number()?;
        let time_s = self.number("a time in seconds")?;
        let bodies = self.count("a count of bodies")?;
        self.expect_more(bodies, 11)?;
        let bodies = (0..bodies).map(|_| {
            let id = self.text("the ID of a body")?;
            let pose = self.numbers()?;
            // Yaw, pitch and roll say the same again.
            self.numbers::<3>()?;
            Ok((id, pose))
        });
        let bodies = bodies.collect::<Result<_, CaptureError>>()?;
        let markers = self.count("a count of markers")?;
        let named = self.expect_each(markers, [4, 5])? == 5;
        let markers = (0..markers).map(|_| {
            Ok(SeenMarker {
                position: self.numbers()?,
                id: self.text("the ID of a marker")?,
                name: if named { self.text("a name")? } else { "" },
            })
        });
        Ok(FrameLine {
            number,
            time_s,
            bodies,
            markers: markers.collect::<Result<_, CaptureError>>()?,
        })
    }

    fn body_line(&mut self) -> Result<BodyLine<'a>, CaptureError> {
        let frame = self.frame_number()?;
        self.number("a time in seconds")?;
        self.text("a name")?;
        let id = self.text("an ID")?;
        let tracked = self.number("frames since the body was tracked")? == 0.0;
        let markers = self.count("a count of markers")?;
        // Eight or nine cells for each marker, and the mean error behind them.
        let (left, nine) = (self.left(), markers.saturating_mul(9));
        let with_ids = left == nine.saturating_add(1) || (left == nine && markers > 1);
        if !with_ids {
            self.expect_more(markers, 8)?;
        }
        let mut fitted = Vec::new();
        for _ in 0..markers {
            fitted.push(self.numbers()?);
            if with_ids {
                self.text("the ID of a marker")?;
            }
        }
        let seen = (0..markers)
            .map(|_| self.numbers())
            .collect::<Result<_, _>>()?;
        for _ in 0..markers {
            self.number("1 or 0")?;
        }
        let quality = (0..markers).map(|_| self.number("a quality"));
        Ok(BodyLine {
            frame,
            id,
            tracked,
            fitted,
            seen,
            quality: quality.collect::<Result<_, _>>()?,
        })
    }

    fn bytes(&mut self, expected: &'static str) -> Result<&'a [u8], CaptureError> {
        let Some(rest) = self.rest else {
            let place = format_args!("{} (the row is cut off)", self.column + 1);
            let problem = format_args!("expected {expected}, found \"\"");
            return Err(CaptureError::in_cell(self.file, self.line, place, problem));
        };
        self.column += 1;
        // A quoted cell may hold commas.
        let quoted = rest
            .strip_prefix(b"\"")
            .and_then(|inner| memchr(b'"', inner).map(|end| (&inner[..end], &inner[end + 1..])));
        if let Some((cell, behind)) = quoted
            && behind.first().is_none_or(|&byte| byte == b',')
        {
            self.rest = behind.get(1..);
            return Ok(cell);
        }
        match memchr(b',', rest) {
            Some(end) => {
                self.rest = Some(&rest[end + 1..]);
                Ok(&rest[..end])
            }
            None => {
                self.rest = None;
                Ok(rest)
            }
        }
    }

    fn text(&mut self, expected: &'static str) -> Result<&'a str, CaptureError> {
        let cell = self.bytes(expected)?;
        text::header_text(cell, self.line, self.file).map(str::trim)
    }

    fn number(&mut self, expected: &'static str) -> Result<f64, CaptureError> {
        let cell = self.bytes(expected)?;
        cell_number(cell).ok_or_else(|| self.error(expected, cell))
    }

    fn numbers<const N: usize>(&mut self) -> Result<[f64; N], CaptureError> {
        let mut numbers = [f64::NAN; N];
        for number in &mut numbers {
            *number = self.number("a number")?;
        }
        Ok(numbers)
    }

    fn frame_number(&mut self) -> Result<i64, CaptureError> {
        const EXPECTED: &str = "a frame number";
        let cell = self.bytes(EXPECTED)?;
        cell_number(cell)
            .and_then(frame)
            .ok_or_else(|| self.error(EXPECTED, cell))
    }

    fn count(&mut self, expected: &'static str) -> Result<usize, CaptureError> {
        let cell = self.bytes(expected)?;
        let count = std::str::from_utf8(cell).ok();
        count
            .and_then(|count| count.trim().parse().ok())
            .ok_or_else(|| self.error(expected, cell))
    }

    /// Cells that are left.
    fn left(&self) -> usize {
        let rest = self.rest.map(<[u8]>::trim_ascii_end);
        rest.map_or(0, |rest| memchr::memchr_iter(b',', rest).count() + 1)
    }

    /// Whether `count` things of `each` cells can follow: a count may be anything.
    fn expect_more(&self, count: usize, each: usize) -> Result<(), CaptureError> {
        let left = self.left();
        if count <= left / each {
            return Ok(());
        }
        let expected = count.saturating_mul(each).saturating_add(self.column);
        let (file, line) = (self.file, self.line);
        Err(CaptureError::too_few_cells(
            file,
            line,
            expected,
            self.column + left,
        ))
    }

    /// Which of two numbers of cells the `count` things that end the line have each.
    fn expect_each(&self, count: usize, each: [usize; 2]) -> Result<usize, CaptureError> {
        let left = self.left();
        let fits = each
            .into_iter()
            .find(|each| count.checked_mul(*each) == Some(left));
        match fits {
            Some(each) => Ok(each),
            None if count == 0 => Ok(each[0]),
            None => {
                self.expect_more(count, each[0])?;
                let expected = self.column + count * each[0];
                let found = excerpt(self.rest.unwrap_or_default());
                let (file, line) = (self.file, self.line);
                Err(CaptureError::too_many_cells(file, line, expected, &found))
            }
        }
    }

    fn error(&self, expected: &'static str, cell: &[u8]) -> CaptureError {
        let place = format_args!("{} (row-typed format)", self.column);
        let found = excerpt(cell);
        let problem = format_args!("expected {expected}, found {found:?}");
        CaptureError::in_cell(self.file, self.line, place, problem)
    }
}
