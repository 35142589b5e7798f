//! Motive CSV (OptiTrack), format versions 1.21 and later: reads them, writes 1.23. The row-typed
//! versions 1 and 1.1 are read too; how is told in the module `row_typed`.
//!
//! A file is a line of facts as key and value in turn, a blank line, rows of types, names, IDs (and
//! parents, from 1.25), a row of `Rotation` and `Position`, a row of axes, and one row for each
//! frame. The header rows drive the reader: columns may be in any order, come and go.
//!
//! # Conventions
//!
//! * **Lengths** are in the header's `Length Units` and become metres, also those of `Error Per
//!   Marker` and `Mean Marker Error`. `Marker Quality` is a number from 0 to 1 and stays.
//! * **Quaternions** stand as X, Y, Z, W, rotate from the body to the world, and flip sign between
//!   frames; signs are kept.
//! * **Euler angles** are in degrees and intrinsic, in the order that `Rotation Type` names; the
//!   column labelled X holds the angle about X, wherever it stands. With `XYZ` and angles of
//!   (90, 90, 0) the body's x axis, turned about its y first, becomes the world's y:
//!
//! ```
//! use nalgebra::Vector3;
//! # let csv = "\
//! # Format Version,1.23,Take Name,demo,Export Frame Rate,100,Rotation Type,XYZ,Length Units,Meters\n\
//! # ,Type,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body\n\
//! # ,Name,Hand,Hand,Hand,Hand,Hand,Hand\n\
//! # ,ID,A,A,A,A,A,A\n\
//! # ,,Rotation,Rotation,Rotation,Position,Position,Position\n\
//! # Frame,Time (Seconds),X,Y,Z,X,Y,Z\n\
//! # 0,0,90,90,0,0,0,0\n";
//! let recording = inhand_capture::motive::read(csv.as_bytes(), "demo.csv", &Default::default())?;
//! let world_from_body = recording.bodies[0].track.get(0).expect("measured").isometry();
//! assert!((world_from_body * Vector3::x() - Vector3::y()).norm() < 1e-12);
//! # Ok::<(), inhand_capture::CaptureError>(())
//! ```
//!
//!   Of all orders and both readings (intrinsic, extrinsic) this one keeps the markers of a body
//!   still in the body's frame in exports that hold both.
//! * **Time** of a sample is `(frame - first frame) / Export Frame Rate` after `Capture Start
//!   Time`, which has no zone and is taken as UTC. The time column, which some versions round to
//!   a millisecond, is a check and no more.
//! * **Missing** samples are blank cells (or `NaN`); a pose or position of which only a part is
//!   there is missing too.
//! * **Axes** are not stated. Motive exports Y up unless told otherwise.

mod header;
mod layout;
mod row_typed;
mod write;

pub use write::write;

use inhand_model::{Finding, LengthUnit, Recording, RotationOrder, Source, UpAxis};

use self::header::Header;
use crate::assembly::{self, Opened, Take};
use crate::error::CaptureError;
use crate::settings::{ReadSettings, parse_length_unit, parse_rotation_order, parse_up_axis};
use crate::table::Table;
use crate::{start_time, text};

/// Key under which [`write`] states an up axis other than Motive's own default.
const UP_AXIS_KEY: &str = "Up Axis";

/// Reads a Motive CSV file.
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
    let text = text::without_byte_order_mark(bytes, file_name)?;
    if row_typed::looks_like(text) {
        return row_typed::read(text, file_name, settings);
    }
    assembly::read_text(open, bytes, file_name, settings)
}

/// Whether the bytes start as the format from 1.2 on does.
pub(crate) fn looks_like(bytes: &[u8]) -> bool {
    header::looks_like(bytes)
}

/// Reads the header, from the beginning of a file without byte-order mark.
pub(crate) fn open(
    bytes: &[u8],
    file_name: &str,
    settings: &ReadSettings,
) -> Result<Opened, CaptureError> {
    let header = header::parse(bytes, file_name)?;
    let rotation_order = rotation_order(&header, file_name, settings)?;
    let length_unit = length_unit(&header, file_name, settings)?;
    let layout = layout::resolve(&header, file_name, rotation_order).map_err(|mut error| {
        // Both at once, so that nobody has to come back twice.
        if let CaptureError::NoRotationOrder { no_units, .. } = &mut error {
            *no_units = length_unit.is_none();
        }
        error
    })?;

    let length_unit = match length_unit {
        Some(unit) => unit,
        // Without any entity there is no length to misread.
        None if layout.entities.is_empty() => LengthUnit::Metres,
        None => {
            return Err(CaptureError::NoUnits {
                file: file_name.to_owned(),
                key: "Length Units",
            });
        }
    };
    let stated_up = header.fact(UP_AXIS_KEY).and_then(parse_up_axis);
    let up_axis = settings.settle_up_axis(file_name, stated_up)?;

    let mut findings = layout.findings;
    let format = format!(
        "Motive CSV {}",
        header.fact("Format Version").unwrap_or_default()
    );
    let version = header.fact("Format Version").unwrap_or_default();
    if !header::is_known_version(version) {
        findings.push(Finding::info(
            "Format Version",
            format!("{version} is none of 1.21 to 1.25: read as its header rows say"),
        ));
    }
    if header.is_fact("Coordinate Space", "Local") {
        let local = [
            (
                layout.has_bones,
                "poses of bones are relative to their parent bone",
            ),
            (
                layout.has_fitted_markers,
                "positions of rigid-body markers may be relative to their body",
            ),
        ];
        let local: Vec<_> = local
            .iter()
            .filter(|(has, _)| *has)
            .map(|(_, what)| *what)
            .collect();
        if !local.is_empty() {
            findings.push(Finding::warning(
                "Coordinate Space",
                format!(
                    "Local: {}, not to the world: kept as they are",
                    local.join(", ")
                ),
            ));
        }
    }
    let start = start_time::parse("Capture Start Time", header.fact("Capture Start Time"));
    findings.extend(start.finding.clone());
    let clock = start.clock(header.rate_hz(file_name)?, file_name)?;
    let name = match header.facts.get("Take Name") {
        Some(name) if !name.trim().is_empty() => name.as_str(),
        _ => text::stem(file_name),
    }
    .to_owned();

    let table = Table {
        file: file_name.to_owned(),
        delimiter: b',',
        columns: layout.columns,
        labels: layout.labels,
        may_end_after: None,
    };
    const ROWS: &str = "Total Exported Frames";
    let declared_rows = assembly::declared_rows(ROWS, header.fact(ROWS), &mut findings);
    Ok(Opened {
        table,
        data_start: header.data_start,
        first_data_line: header.first_data_line,
        take: Take {
            name,
            clock,
            source: Source {
                format,
                length_unit,
                up_axis: up_axis.unwrap_or(UpAxis::Y),
                rotation: layout.rotation,
                header: header.facts,
            },
            entities: layout.entities,
            zero_is_missing: false,
            declared_rows,
            findings,
        },
    })
}

fn rotation_order(
    header: &Header,
    file: &str,
    settings: &ReadSettings,
) -> Result<Option<RotationOrder>, CaptureError> {
    let stated = match header.fact("Rotation Type") {
        None | Some("") => None,
        Some(name) => {
            Some(
                parse_rotation_order(name).ok_or_else(|| CaptureError::HeaderValue {
                    file: file.to_owned(),
                    line: 1,
                    key: "Rotation Type",
                    expected: "Quaternion, XYZ, XZY, YXZ, YZX, ZXY or ZYX",
                    found: format!("\"{name}\""),
                })?,
            )
        }
    };
    settings.settle_rotation_order(file, stated)
}

fn length_unit(
    header: &Header,
    file: &str,
    settings: &ReadSettings,
) -> Result<Option<LengthUnit>, CaptureError> {
    let stated = match header.fact("Length Units") {
        None | Some("") => None,
        Some(name) => Some(
            parse_length_unit(name).ok_or_else(|| CaptureError::HeaderValue {
                file: file.to_owned(),
                line: 1,
                key: "Length Units",
                expected: "Meters, Centimeters, Millimeters, Inches or Feet",
                found: format!("\"{name}\""),
            })?,
        ),
    };
    settings.settle_length_unit(file, stated)
}
