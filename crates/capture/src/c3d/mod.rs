//! C3D files: marker positions as most capture software and laboratories exchange them.
//!
//! Blocks of 512 bytes: a header, parameters in groups, then for each frame its points, followed by
//! analog samples, which are passed over.
//!
//! # Conventions
//!
//! * **Numbers** are those of Intel, DEC (VAX) or MIPS processors, points are integers times
//!   `POINT:SCALE` or, where that is negative, floating point.
//! * **Header and parameters** say some things twice. Where they disagree the parameter counts, as
//!   the format has it, and a finding says so. What the size of the file disproves does not count.
//! * **Frames** beyond 65535 are counted by `POINT:LONG_FRAMES`, or else by `TRIAL:ACTUAL_START_FIELD` and
//!   `ACTUAL_END_FIELD`. Whole frames behind those that are counted are not read, and a finding says so.
//! * **Time** of a sample is `(frame - first frame) / POINT:RATE`: the first one is at 0 s whatever
//!   its number, and a finding says so where that is not 0 or 1. The file states no start time.
//! * **Events** are those of the group `EVENT`, minutes and seconds from frame 1 of the trial, with their label,
//!   context, subject and description.
//! * **Model outputs** are stored as points and are none: those named in `POINT:ANGLES`, `FORCES`, `MOMENTS`, `POWERS`
//!   and `SCALARS` are left out, and a finding names them.
//! * **Names** are `POINT:LABELS`; a point without label is called by its number, from 1.
//! * **Lengths** are in `POINT:UNITS` and become metres.
//! * **Up** is `POINT:Y_SCREEN`, where it is Y or Z; else Z with a finding, unless the user says it.
//! * **Missing** samples have a negative residual, are no numbers or, as programs without a notion of
//!   missing write them, are exactly at the origin, which is counted in a finding.

mod events;
mod number;
mod parameters;
mod points;
mod write;

use std::collections::BTreeSet;
use std::fmt::Display;

use inhand_model::{
    Finding, LengthUnit, Marker, MarkerKind, PointTrack, Recording, Setting, Source, UpAxis, World,
};

use self::parameters::Parameters;
use self::points::Points;
pub use self::write::write;
use crate::error::CaptureError;
use crate::settings::{ReadSettings, parse_length_unit, settle};
use crate::trial::FirstFrame;
use crate::{start_time, text};

/// Bytes of a block.
const BLOCK_BYTES: usize = 512;

/// Second byte of every file.
const KEY: u8 = 0x50;

/// Whether the bytes start as a C3D file does: the block of its parameters, which is the second or
/// one soon after it, then the key 0x50. No text starts with such a control character.
pub(crate) fn looks_like(bytes: &[u8]) -> bool {
    matches!(bytes, [2..=8, KEY, ..])
}

/// Reads a C3D file.
pub(crate) fn read(
    bytes: &[u8],
    file: &str,
    settings: &ReadSettings,
) -> Result<Recording, CaptureError> {
    let parameters = Parameters::read(bytes, file)?;
    let start = start_time::parse("", None);
    let mut findings: Vec<Finding> = start.finding.clone().into_iter().collect();
    let points = Points::find(&parameters, bytes, file, &mut findings)?;
    let trial = start.clock(rate_hz(&parameters, &mut findings), file)?;
    let events = events::stated(&parameters, &mut findings);
    let first = FirstFrame {
        number: Some(points::first_frame(&parameters, file)?),
        time_s: None,
        counts_from: 1,
    };
    let part = first.part(trial, &events, file)?;
    findings.extend(part.findings);
    let stated = parameters
        .text("POINT", "UNITS")
        .and_then(parse_length_unit);
    let given = settings.length_unit;
    let length_unit = settle(file, Setting::Units, stated, given, LengthUnit::name)?
        .ok_or_else(|| CaptureError::no_units(file, "POINT:UNITS"))?;
    let up_axis = up_axis(&parameters, file, settings, &mut findings)?;
    let labels = parameters.texts("POINT", "LABELS");
    let is_output = model_outputs(&parameters, &labels, points.count(), &mut findings);
    let tracks = points.tracks(bytes, length_unit, &is_output, &mut findings);
    let mut header = parameters.facts();
    let processor = parameters.processor.name();
    header.insert("processor".to_owned(), processor.to_owned());
    let source = Source {
        format: "C3D".to_owned(),
        length_unit,
        up_axis,
        rotation: None,
        header,
    };
    let markers = markers(&labels, tracks, points.count(), &mut findings);
    let name = text::stem(file).to_owned();
    let mut recording =
        Recording::new(name, part.clock, source, points.frames, markers, Vec::new())
            .map_err(|error| CaptureError::in_file(file, error))?;
    recording.findings = findings;
    recording.annotations = part.annotations;
    Ok(recording)
}

/// An error about bytes that do not make sense.
fn damaged(file: &str, offset: usize, expected: impl Display, found: impl Display) -> CaptureError {
    let problem = format_args!(
        "not a sound C3D file: at byte {offset} expected {expected}, found {found}; copy the file \
         again or export the take anew"
    );
    CaptureError::in_file(file, problem)
}

/// Says that header and parameter disagree, and which one counts.
fn disagree(what: &str, header: f64, parameter: f64, counts: &str) -> Finding {
    Finding::warning(
        what,
        format!("the header says {header}, the parameter {parameter}: {counts} counts"),
    )
}

fn rate_hz(parameters: &Parameters, findings: &mut Vec<Finding>) -> f64 {
    let header = f64::from(parameters.header.rate_hz);
    match parameters.number("POINT", "RATE") {
        Some(rate_hz) if rate_hz.is_finite() && rate_hz > 0.0 => {
            if (rate_hz - header).abs() > 1e-4 * rate_hz {
                findings.push(disagree("POINT:RATE", header, rate_hz, "the parameter"));
            }
            rate_hz
        }
        _ => header,
    }
}

fn up_axis(
    parameters: &Parameters,
    file: &str,
    settings: &ReadSettings,
    findings: &mut Vec<Finding>,
) -> Result<UpAxis, CaptureError> {
    let stated = match parameters.text("POINT", "Y_SCREEN") {
        Some("+Z" | "Z") => Some(UpAxis::Z),
        Some("+Y" | "Y") => Some(UpAxis::Y),
        Some(other) if !other.is_empty() => {
            let message = format!("expected +Y or +Z, found {other:?}");
            findings.push(Finding::warning("POINT:Y_SCREEN", message));
            None
        }
        _ => None,
    };
    let up_axis = settle(file, Setting::Up, stated, settings.up_axis, UpAxis::name)?;
    if up_axis.is_none() {
        let message = format!(
            "the file does not say which axis points up: z is assumed; set {} to y or z",
            Setting::Up
        );
        findings.push(Finding::info("POINT:Y_SCREEN", message));
    }
    Ok(up_axis.unwrap_or(UpAxis::Z))
}

/// Parameters of group POINT that list the labels of what a model computed: stored as points, but degrees, newtons,
/// newton millimetres or watts, and no positions.
const MODEL_OUTPUTS: [&str; 5] = ["ANGLES", "FORCES", "MOMENTS", "POWERS", "SCALARS"];

/// Whether each point is a model output.
fn model_outputs(
    parameters: &Parameters,
    labels: &[String],
    points: usize,
    findings: &mut Vec<Finding>,
) -> Vec<bool> {
    let outputs = MODEL_OUTPUTS.map(|name| parameters.texts("POINT", name));
    let outputs: BTreeSet<&String> = (outputs.iter().flatten())
        .filter(|label| !label.is_empty())
        .collect();
    let is_output = |k: usize| labels.get(k).is_some_and(|label| outputs.contains(label));
    let is_output: Vec<bool> = (0..points).map(is_output).collect();
    let named = labels.iter().zip(&is_output).filter(|(_, output)| **output);
    let names: Vec<&str> = named.map(|(label, _)| label.as_str()).collect();
    if !names.is_empty() {
        let message = format!(
            "{} of {points} points are outputs of a model and no positions: left out: {}",
            names.len(),
            names.join(", ")
        );
        findings.push(Finding::info("points", message));
    }
    is_output
}

/// The points that have a track, by their number in the file.
fn markers(
    labels: &[String],
    tracks: Vec<(usize, PointTrack<World>)>,
    points: usize,
    findings: &mut Vec<Finding>,
) -> Vec<Marker> {
    if labels.len() < points {
        let message = format!(
            "{} labels for {points} points: the others are called by their numbers and stay \
             unlabelled",
            labels.len(),
        );
        findings.push(Finding::warning("POINT:LABELS", message));
    }
    let named = |(k, track)| {
        let label = labels.get(k).map_or("", String::as_str);
        // Vicon writes a star before the number of a marker that it cannot name.
        let unlabelled = label.is_empty() || label.starts_with('*') || text::is_unlabelled(label);
        Marker {
            name: text::name_or_number(label, k).into_owned(),
            id: String::new(),
            kind: match unlabelled {
                true => MarkerKind::Unlabelled,
                false => MarkerKind::Labelled,
            },
            track,
            quality: None,
        }
    };
    tracks.into_iter().map(named).collect()
}
