//! Motive CSV (OptiTrack), format versions 1.21 and later: reads them, writes 1.23. The row-typed
//! versions 1 and 1.1 are read too, by the module `row_typed`.
//!
//! A file is a line of facts as key and value in turn, a blank line, rows of types, names, IDs (and
//! parents, from 1.25), a row of `Rotation` and `Position`, a row of axes, and one row for each
//! frame. The header rows drive the reader: columns may be in any order, come and go.
//!
//! # Conventions
//!
//! * **Lengths** are in the header's `Length Units` and become metres, also those of `Error Per
//!   Marker` and `Mean Marker Error`. `Marker Quality` is a number from 0 to 1 and stays.
//! * **Quaternions** are X, Y, Z, W, rotate from the body to the world, and flip sign between
//!   frames; signs are kept.
//! * **Euler angles** are in degrees and intrinsic, in the order that `Rotation Type` names; the
//!   column labelled X holds the angle about X, wherever it is. With `XYZ` and angles of
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
//! let recording = inhand_capture::read(csv.as_bytes(), "demo.csv", &Default::default())?;
//! let world_from_body = recording.bodies[0].track.get(0).expect("measured").isometry();
//! assert!((world_from_body * Vector3::x() - Vector3::y()).norm() < 1e-12);
//! # Ok::<(), inhand_capture::CaptureError>(())
//! ```
//!
//!   Of all orders and both readings (intrinsic, extrinsic) this one keeps the markers of a body
//!   still in the body's frame in exports that hold both.
//! * **Time** of a sample is `frame / Export Frame Rate` after `Capture Start Time`, which has no zone
//!   and is taken as UTC: an export of a range starts later than the capture. The time column, which
//!   some versions round to a millisecond, is only a check.
//! * **Missing** samples are blank cells (or `NaN`); a pose or position of which only a part is
//!   there is missing too.
//! * **Axes** are not stated. Motive exports Y up unless set otherwise.

mod header;
mod layout;
pub(crate) mod row_typed;
mod write;

pub use write::write;

use inhand_model::{Finding, LengthUnit, RotationOrder, Setting, Source, UpAxis};

use self::header::Header;
pub(crate) use self::header::looks_like;
use self::layout::ColumnLayout;
use crate::assembly::Take;
use crate::error::CaptureError;
use crate::header::Opened;
use crate::settings::{ReadSettings, parse_rotation_order, parse_up_axis, settle};
use crate::{start_time, text};

/// Key under which [`write()`] states an up axis other than Motive's own default.
const UP_AXIS_KEY: &str = "Up Axis";

/// Versions whose layout has been seen.
const KNOWN_VERSIONS: [&str; 5] = ["1.21", "1.22", "1.23", "1.24", "1.25"];

/// Reads the header, from the beginning of a file without byte-order mark.
pub(crate) fn open(
    bytes: &[u8],
    file: &str,
    settings: &ReadSettings,
) -> Result<Opened, CaptureError> {
    let header = Header::parse(bytes, file)?;
    let facts = &header.facts;
    let units = "Meters, Centimeters, Millimeters, Inches or Feet";
    let length_unit = facts.length_unit("Length Units", units, settings)?;
    let layout = ColumnLayout::new(&header, rotation_order(&header, settings)?, length_unit)?;
    let length_unit = match length_unit {
        Some(unit) => unit,
        // Without any entity there is no length to misread.
        None if layout.series.is_empty() => LengthUnit::Metres,
        None => return Err(CaptureError::no_units(file, "Length Units")),
    };
    let stated_up = facts.get(UP_AXIS_KEY).and_then(parse_up_axis);
    let up_axis = settle(file, Setting::Up, stated_up, settings.up_axis, UpAxis::name)?;

    let version = facts.get("Format Version").unwrap_or_default();
    let mut findings = layout.findings;
    if !KNOWN_VERSIONS.contains(&version) {
        let message = format!("{version} is none of 1.21 to 1.25: read as its header rows say");
        findings.push(Finding::info("Format Version", message));
    }
    findings.extend(layout.local_space);
    let start = start_time::parse("Capture Start Time", facts.get("Capture Start Time"));
    findings.extend(start.finding.clone());
    let expected = "the rate of the rows in Hz, such as 100.000000";
    let rate_hz = facts.rate_hz("Export Frame Rate", expected)?;
    let clock = start.clock(rate_hz, file)?;
    let declared_rows = facts.count("Total Exported Frames", &mut findings);
    let name = facts.by_key.get("Take Name").map(String::as_str);
    let name = name.filter(|name| !name.trim().is_empty());
    Ok(Opened {
        table: layout.table,
        header_bytes: header.bytes,
        header_lines: header.lines,
        take: Take {
            name: name.unwrap_or(text::stem(file)).to_owned(),
            clock,
            counts_from: 0,
            events: Vec::new(),
            source: Source {
                format: format!("Motive CSV {version}"),
                length_unit,
                up_axis: up_axis.unwrap_or(UpAxis::Y),
                rotation: layout.rotation,
                header: header.facts.by_key,
            },
            series: layout.series,
            zero_is_missing: false,
            time_tolerance_s: 0.0,
            declared_rows,
            findings,
        },
    })
}

fn rotation_order(
    header: &Header<'_>,
    settings: &ReadSettings,
) -> Result<Option<RotationOrder>, CaptureError> {
    let expected = "Quaternion, XYZ, XZY, YXZ, YZX, ZXY or ZYX";
    let facts = &header.facts;
    let stated = facts.parsed("Rotation Type", expected, parse_rotation_order)?;
    let given = settings.rotation_order;
    settle(facts.file, Setting::RotationOrder, stated, given, |o| o)
}
