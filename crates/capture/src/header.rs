//! Headers of text files: lines, facts by key, and what they say of a take.

use std::collections::BTreeMap;
use std::fmt::Display;

use inhand_model::{Clock, Finding, LengthUnit, MarkerKind, Setting, Source};

use crate::assembly::{Series, Take};
use crate::error::CaptureError;
use crate::settings::{ReadSettings, parse_length_unit, settle};
use crate::table::{Table, cell_number};
use crate::text::{excerpt, header_text, name_or_number, stem};

/// Contents of a header: columns, take, and its own length.
pub(crate) struct Opened {
    pub(crate) table: Table,
    pub(crate) take: Take,
    /// Bytes above the first row.
    pub(crate) header_bytes: usize,
    /// Lines above the first row.
    pub(crate) header_lines: usize,
}

/// Adds the X, Y and Z of markers to a table. A marker without a name is called by its number, from 1.
pub(crate) fn add_markers(
    table: &mut Table,
    names: Vec<&str>,
    is_unlabelled: impl Fn(&str) -> bool,
) -> Vec<Series> {
    let marker = |(k, name): (usize, &str)| {
        let kind = match name.is_empty() || is_unlabelled(name) {
            true => MarkerKind::Unlabelled,
            false => MarkerKind::Labelled,
        };
        let name = name_or_number(name, k);
        Series::marker(&name, "", kind, table.push_marker(&name), None)
    };
    names.into_iter().enumerate().map(marker).collect()
}

/// The lines of a header, one after the other.
pub(crate) struct HeaderLines<'a> {
    rest: &'a [u8],
    pub(crate) file: &'a str,
    /// Bytes of the lines taken.
    pub(crate) bytes: usize,
    /// Lines taken so far: the number of the last one.
    pub(crate) number: usize,
}

impl<'a> HeaderLines<'a> {
    pub(crate) fn new(bytes: &'a [u8], file: &'a str) -> Self {
        Self {
            rest: bytes,
            file,
            bytes: 0,
            number: 0,
        }
    }

    /// The next line with its end, without taking it; empty at the end of the file.
    pub(crate) fn peek(&self) -> &'a [u8] {
        let end = memchr::memchr(b'\n', self.rest).map_or(self.rest.len(), |end| end + 1);
        &self.rest[..end]
    }

    /// Takes the next line, without its end; `None` at the end of the file.
    pub(crate) fn next_line(&mut self) -> Result<Option<&'a str>, CaptureError> {
        let line = self.peek();
        self.number += 1;
        if line.is_empty() {
            return Ok(None);
        }
        self.rest = &self.rest[line.len()..];
        self.bytes += line.len();
        let line = header_text(line, self.number, self.file)?;
        Ok(Some(line.trim_end_matches(['\r', '\n'])))
    }

    /// A take of markers, whose header is the lines taken so far. These formats count frames from 1 and
    /// write zeros for a missing marker.
    pub(crate) fn opened(
        &self,
        table: Table,
        series: Vec<Series>,
        clock: Clock,
        source: Source,
        declared_rows: Option<(&'static str, u64)>,
        findings: Vec<Finding>,
    ) -> Opened {
        Opened {
            table,
            header_bytes: self.bytes,
            header_lines: self.number,
            take: Take {
                name: stem(self.file).to_owned(),
                clock,
                counts_from: 1,
                events: Vec::new(),
                source,
                series,
                zero_is_missing: true,
                time_tolerance_s: 0.0,
                declared_rows,
                findings,
            },
        }
    }

    /// The error that the line taken last is not what belongs there.
    pub(crate) fn error(&self, expected: impl Display, found: impl Display) -> CaptureError {
        CaptureError::header(self.file, self.number, expected, found)
    }
}

/// The facts of a header by key.
pub(crate) struct Facts<'a> {
    pub(crate) file: &'a str,
    /// Line of their values, for messages.
    pub(crate) line: usize,
    pub(crate) by_key: BTreeMap<String, String>,
}

impl Facts<'_> {
    /// The value of a key, unless it is blank.
    pub(crate) fn get(&self, key: &str) -> Option<&str> {
        let value = self.by_key.get(key)?.trim();
        (!value.is_empty()).then_some(value)
    }

    /// A value that only makes sense if it can be parsed.
    pub(crate) fn parsed<T>(
        &self,
        key: &str,
        expected: &str,
        parse: impl Fn(&str) -> Option<T>,
    ) -> Result<Option<T>, CaptureError> {
        let parsed = self.get(key).map(|value| {
            let found = || format!("\"{}\"", excerpt(value.as_bytes()));
            parse(value).ok_or_else(|| self.error(key, expected, found()))
        });
        parsed.transpose()
    }

    fn error(&self, key: &str, expected: &str, found: impl Display) -> CaptureError {
        let problem = format_args!("\"{key}\" is {found}: expected {expected}");
        CaptureError::in_line(self.file, self.line, problem)
    }

    /// A rate, which every file must state.
    pub(crate) fn rate_hz(&self, key: &str, expected: &str) -> Result<f64, CaptureError> {
        let sound = |&hz: &f64| hz.is_finite() && hz > 0.0;
        let rate = |text: &str| cell_number(text.as_bytes()).filter(sound);
        let stated = self.parsed(key, expected, rate)?;
        stated.ok_or_else(|| self.error(key, expected, "missing"))
    }

    /// The unit of length that the file states, else the one that is set.
    pub(crate) fn length_unit(
        &self,
        key: &str,
        expected: &str,
        settings: &ReadSettings,
    ) -> Result<Option<LengthUnit>, CaptureError> {
        let stated = self.parsed(key, expected, parse_length_unit)?;
        let given = settings.length_unit;
        settle(self.file, Setting::Units, stated, given, LengthUnit::name)
    }

    /// A count to compare with what is there. Nothing depends on it, so text that is no count is a
    /// finding.
    pub(crate) fn count(
        &self,
        key: &'static str,
        findings: &mut Vec<Finding>,
    ) -> Option<(&'static str, u64)> {
        let text = self.get(key)?;
        let count = text.parse().ok();
        if count.is_none() {
            let found = excerpt(text.as_bytes());
            let message = format!("expected a count, found \"{found}\": counted what is there");
            findings.push(Finding::warning(key, message));
        }
        count.map(|count| (key, count))
    }

    /// Compares the number of markers that a header promises with those that it has.
    pub(crate) fn check_markers(&self, key: &'static str, has: usize, findings: &mut Vec<Finding>) {
        if let Some((_, declared)) = self.count(key, findings)
            && declared != has as u64
        {
            let message = format!(
                "the header promises {declared} markers and has columns for {has}: read those that \
                 have columns"
            );
            findings.push(Finding::warning(key, message));
        }
    }
}
