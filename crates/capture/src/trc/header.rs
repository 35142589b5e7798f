//! The three lines of facts of a TRC file.

use std::collections::BTreeMap;

use inhand_model::{Finding, LengthUnit};

use super::MAGIC;
use crate::error::CaptureError;
use crate::settings::{ReadSettings, parse_length_unit};
use crate::text;

/// Line of the facts' values.
const VALUES_LINE: usize = 3;

const CUT: &str = "the header is cut or edited; export the take again";

/// The lines of the header, one after the other.
pub(super) struct Lines<'a> {
    bytes: &'a [u8],
    pub(super) file: &'a str,
    at: usize,
    /// Lines taken so far: the number of the last one.
    pub(super) number: usize,
}

impl<'a> Lines<'a> {
    pub(super) fn new(bytes: &'a [u8], file: &'a str) -> Self {
        Self {
            bytes,
            file,
            at: 0,
            number: 0,
        }
    }

    /// The cells of the next line, without spaces around them and without blank ones at the end.
    pub(super) fn cells(&mut self, expected: &str) -> Result<Vec<&'a str>, CaptureError> {
        self.number += 1;
        let rest = self.rest();
        if rest.is_empty() {
            return Err(self.error(expected.to_owned(), "the end of the file".to_owned()));
        }
        let length = memchr::memchr(b'\n', rest).map_or(rest.len(), |end| end + 1);
        self.at += length;
        let line = text::header_text(&rest[..length], self.number, self.file)?;
        let mut cells: Vec<&str> = line.split('\t').map(str::trim).collect();
        let used = cells.iter().rposition(|cell| !cell.is_empty());
        cells.truncate(used.map_or(0, |last| last + 1));
        Ok(cells)
    }

    pub(super) fn rest(&self) -> &'a [u8] {
        &self.bytes[self.at..]
    }

    /// What is wrong with the line taken last.
    pub(super) fn error(&self, expected: String, found: String) -> CaptureError {
        CaptureError::Header {
            file: self.file.to_owned(),
            line: self.number,
            expected,
            found,
            hint: CUT,
        }
    }
}

/// A cell by its column, counted from 1, for a message.
pub(super) fn describe(cells: &[&str], index: usize) -> String {
    match cells.get(index) {
        None => "the end of the line".to_owned(),
        Some(&"") => "a blank cell".to_owned(),
        Some(cell) => format!("\"{}\"", text::excerpt(cell.as_bytes())),
    }
}

/// The three lines of facts.
pub(super) struct Header {
    pub(super) facts: BTreeMap<String, String>,
    version: String,
}

impl Header {
    pub(super) fn parse(lines: &mut Lines<'_>) -> Result<Self, CaptureError> {
        let first = lines.cells(MAGIC)?;
        // Some scripts put spaces here and tabs everywhere else.
        let mut words = first
            .iter()
            .flat_map(|cell| cell.split_whitespace())
            .skip(1);
        let version = words.next().unwrap_or_default();
        let order = words.next().unwrap_or_default();
        if !order.is_empty() && !order.eq_ignore_ascii_case("(X/Y/Z)") {
            return Err(CaptureError::UnsupportedFormat {
                file: lines.file.to_owned(),
                found: format!(
                    "a TRC file with coordinates \"{}\" (line 1)",
                    text::excerpt(order.as_bytes())
                ),
                hint: "export it with coordinates (X/Y/Z)",
            });
        }
        let mut facts = BTreeMap::from([(
            MAGIC.to_owned(),
            first.join(" ").split_off(MAGIC.len()).trim().to_owned(),
        )]);
        let keys = lines.cells("a line of keys (DataRate, CameraRate, NumFrames, ...)")?;
        if !keys.contains(&"DataRate") {
            return Err(lines.error(
                "a line of keys with DataRate among them, separated by tabs".to_owned(),
                describe(&keys, 0),
            ));
        }
        let values = lines.cells("a line of values for the keys of line 2")?;
        for (key, value) in keys.iter().zip(&values) {
            if !key.is_empty() {
                facts
                    .entry((*key).to_owned())
                    .or_insert_with(|| (*value).to_owned());
            }
        }
        Ok(Self {
            facts,
            version: version.to_owned(),
        })
    }

    fn fact(&self, key: &str) -> Option<&str> {
        self.facts
            .get(key)
            .map(String::as_str)
            .filter(|value| !value.is_empty())
    }

    pub(super) fn rate_hz(&self, file: &str) -> Result<f64, CaptureError> {
        const KEY: &str = "DataRate";
        let rate = self.fact(KEY);
        rate.and_then(|rate| rate.parse().ok())
            .filter(|rate: &f64| rate.is_finite() && *rate > 0.0)
            .ok_or_else(|| value_error(file, KEY, "a rate in Hz, such as 100.00", rate))
    }

    pub(super) fn length_unit(
        &self,
        file: &str,
        settings: &ReadSettings,
    ) -> Result<Option<LengthUnit>, CaptureError> {
        let stated = match self.fact("Units") {
            None => None,
            Some(name) => Some(
                parse_length_unit(name)
                    .ok_or_else(|| value_error(file, "Units", "m, cm, mm, in or ft", Some(name)))?,
            ),
        };
        settings.settle_length_unit(file, stated)
    }

    /// A count to compare with what is there. Nothing depends on it, so text that is none is a
    /// finding.
    pub(super) fn count(&self, key: &'static str, findings: &mut Vec<Finding>) -> Option<u64> {
        let text = self.fact(key)?;
        let count = text.parse().ok();
        if count.is_none() {
            findings.push(Finding::warning(
                key,
                format!(
                    "expected a count, found \"{}\": counted what is there",
                    text::excerpt(text.as_bytes())
                ),
            ));
        }
        count
    }

    pub(super) fn version_finding(&self) -> Option<Finding> {
        // Both are laid out the same.
        (!["3", "4"].contains(&self.version.as_str())).then(|| {
            Finding::info(
                MAGIC,
                format!(
                    "expected type 4, found \"{}\": read as type 4",
                    text::excerpt(self.version.as_bytes())
                ),
            )
        })
    }
}

fn value_error(
    file: &str,
    key: &'static str,
    expected: &'static str,
    found: Option<&str>,
) -> CaptureError {
    CaptureError::HeaderValue {
        file: file.to_owned(),
        line: VALUES_LINE,
        key,
        expected,
        found: found.map_or("missing".to_owned(), |value| {
            format!("\"{}\"", text::excerpt(value.as_bytes()))
        }),
    }
}
