//! TRC files (track, row, column): marker positions as Cortex, Motive, OpenSim and many scripts
//! write them.
//!
//! Three lines of facts, two rows of column labels, an optional blank line, then a row for each
//! frame, all separated by tabs:
//!
//! ```text
//! PathFileType  4  (X/Y/Z)  take.trc
//! DataRate  CameraRate  NumFrames  NumMarkers  Units  OrigDataRate  OrigDataStartFrame  ...
//! 100       100         2          2           mm     100           1                   ...
//! Frame#  Time  Thumb          Index
//!               X1   Y1   Z1   X2   Y2   Z2
//!
//! 1       0.00  1.0  2.0  3.0  4.0  5.0  6.0
//! ```
//!
//! The second row of labels says which columns make a marker, the first one what it is called.
//! Columns between `Time` and the first marker, as some software has them, are passed over.
//!
//! # Conventions
//!
//! * **Lengths** are in `Units` and become metres.
//! * **Time** of a sample is `(frame - first frame) / DataRate`. The time column is a check and no
//!   more. The file states no start time.
//! * **Missing** samples are blank cells, a row that ends behind its time, `nan`, or, as programs
//!   without a notion of missing write them, a marker exactly at the origin in all three
//!   coordinates, which is counted in a finding.
//! * **Axes** are not stated: Y is up, as Motive and OpenSim have it, with a finding, unless the user
//!   says it, as for most exports of Cortex. What is written is turned so that Y is up.

mod header;
mod layout;
mod write;

use inhand_model::{Finding, LengthUnit, MarkerKind, Recording, Setting, Source, UpAxis};

use self::header::{Header, Lines};
use self::layout::{LEADING_COLUMNS, Layout};
use crate::assembly::{Entity, Opened, Take};
use crate::error::CaptureError;
use crate::settings::ReadSettings;
use crate::table::Table;
use crate::{assembly, start_time, text};

pub use self::write::write;

/// How every file starts.
const MAGIC: &str = "PathFileType";

/// Whether the bytes start as a TRC file does.
pub(crate) fn looks_like(bytes: &[u8]) -> bool {
    bytes
        .strip_prefix(MAGIC.as_bytes())
        .is_some_and(|rest| rest.first().is_none_or(u8::is_ascii_whitespace))
}

/// Reads a TRC file.
///
/// # Errors
///
/// [`CaptureError`] where it is no such file, its header is cut or leaves open what `settings` do
/// not say, or a row is damaged.
pub fn read(
    bytes: &[u8],
    file_name: &str,
    settings: &ReadSettings,
) -> Result<Recording, CaptureError> {
    assembly::read_text(open, bytes, file_name, settings)
}

/// Reads the header, from the beginning of a file without byte-order mark.
pub(crate) fn open(
    bytes: &[u8],
    file_name: &str,
    settings: &ReadSettings,
) -> Result<Opened, CaptureError> {
    if !looks_like(bytes) {
        return Err(CaptureError::UnknownFormat {
            file: file_name.to_owned(),
            found: text::beginning(bytes),
        });
    }
    let mut lines = Lines::new(bytes, file_name);
    let header = Header::parse(&mut lines)?;
    let layout = Layout::parse(&mut lines)?;

    let length_unit = match header.length_unit(file_name, settings)? {
        Some(unit) => unit,
        // Without any marker there is no length to misread.
        None if layout.marker_names.is_empty() => LengthUnit::Metres,
        None => {
            return Err(CaptureError::NoUnits {
                file: file_name.to_owned(),
                key: "Units",
            });
        }
    };
    let start = start_time::parse("", None);
    let clock = start.clock(header.rate_hz(file_name)?, file_name)?;

    let mut findings: Vec<Finding> = start.finding.clone().into_iter().collect();
    findings.extend(header.version_finding());
    if settings.up_axis.is_none() {
        findings.push(Finding::info(
            "",
            format!(
                "TRC does not say which axis points up: y is assumed; set {} to y or z",
                Setting::Up
            ),
        ));
    }
    let declared_rows = header.count("NumFrames", &mut findings);
    if let Some(declared) = header.count("NumMarkers", &mut findings)
        && declared != layout.marker_names.len() as u64
    {
        findings.push(Finding::warning(
            "NumMarkers",
            format!(
                "the header promises {declared} markers and has columns for {}: read those that \
                 have columns",
                layout.marker_names.len()
            ),
        ));
    }

    let table = Table {
        file: file_name.to_owned(),
        delimiter: b'\t',
        columns: layout.columns,
        labels: layout.labels,
        // Cortex ends a row there before the first marker is seen.
        may_end_after: Some(LEADING_COLUMNS),
    };
    let entities = (layout.marker_names.into_iter().enumerate())
        .map(|(m, name)| Entity::Marker {
            kind: if name.is_empty() || text::is_unlabelled(&name) {
                MarkerKind::Unlabelled
            } else {
                MarkerKind::Labelled
            },
            name,
            id: String::new(),
            position: [3 * m, 3 * m + 1, 3 * m + 2],
            quality: None,
        })
        .collect();
    Ok(Opened {
        table,
        data_start: bytes.len() - lines.rest().len(),
        first_data_line: lines.number + 1,
        take: Take {
            name: text::stem(file_name).to_owned(),
            clock,
            source: Source {
                format: "TRC".to_owned(),
                length_unit,
                up_axis: settings.up_axis.unwrap_or(UpAxis::Y),
                rotation: None,
                header: header.facts,
            },
            entities,
            zero_is_missing: true,
            declared_rows: declared_rows.map(|count| ("NumFrames", count)),
            findings,
        },
    })
}
