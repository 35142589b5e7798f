//! Recordings as Motive CSV 1.23.

use std::io::{self, Write};

use inhand_model::{
    BodyKind, Marker, MarkerKind, Pose, Position, Recording, StartTime, TrackedBody, UpAxis,
};

use super::UP_AXIS_KEY;
use crate::error::CaptureError;
use crate::start_time;

/// Facts passed on from the source's header as they are there, with what Motive would say otherwise.
const TAKE_NOTES: &str = "Take Notes";
const CAPTURE_RATE: &str = "Capture Frame Rate";
const START_FRAME: &str = "Capture Start Frame";
const SPACE: &str = "Coordinate Space";

/// One group of columns.
enum Entity<'a> {
    Body(&'a TrackedBody),
    Marker(&'a Marker),
}

/// Writes a recording as Motive CSV 1.23: metres, quaternions, CRLF, blank cells for missing
/// samples, columns as Motive orders them (each body, then its markers, then the rest).
///
/// Numbers have as many digits as it takes to read them back unchanged. What the format cannot
/// hold is lost: the mark on filled samples, the zone of the start time, findings. An up axis other
/// than Y, which Motive never states, is added to the header as `Up Axis`.
///
/// `out` should be buffered.
///
/// # Errors
///
/// [`CaptureError::Output`] where `out` fails.
pub fn write(recording: &Recording, out: &mut dyn Write) -> Result<(), CaptureError> {
    write_all(recording, out).map_err(|source| CaptureError::Output {
        format: "Motive CSV",
        source,
    })
}

fn write_all(recording: &Recording, out: &mut dyn Write) -> io::Result<()> {
    let entities = in_motive_order(recording);
    write_facts(recording, out)?;
    write_labels(&entities, out)?;
    let rate_hz = recording.clock.rate_hz();
    for k in 0..recording.len() {
        write!(out, "{k},{:.6}", k as f64 / rate_hz)?;
        for entity in &entities {
            match entity {
                Entity::Body(body) => {
                    let pose = body.track.get(k);
                    cells(out, pose.map(Pose::quaternion_xyzw))?;
                    cells(out, pose.map(|pose| pose.origin().to_array()))?;
                    quality(out, body.marker_error_m.as_deref(), k)?;
                }
                Entity::Marker(marker) => {
                    cells(out, marker.track.get(k).map(Position::to_array))?;
                    quality(out, marker.quality.as_deref(), k)?;
                }
            }
        }
        out.write_all(b"\r\n")?;
    }
    out.flush()
}

/// Bodies and markers, each in the recording's order, a body's fitted markers right after it.
fn in_motive_order(recording: &Recording) -> Vec<Entity<'_>> {
    let mut entities = Vec::with_capacity(recording.bodies.len() + recording.markers.len());
    let mut markers = recording.markers.iter().peekable();
    for body in &recording.bodies {
        entities.push(Entity::Body(body));
        while let Some(marker) = markers.next_if(|marker| {
            marker.kind == MarkerKind::RigidBodyMarker && marker.name.starts_with(&body.name)
        }) {
            entities.push(Entity::Marker(marker));
        }
    }
    entities.extend(markers.map(Entity::Marker));
    entities
}

fn write_facts(recording: &Recording, out: &mut dyn Write) -> io::Result<()> {
    let samples = recording.len().to_string();
    let rate = format!("{:.6}", recording.clock.rate_hz());
    // As written, unless six decimals are not enough to say the rate.
    let rate = match rate.parse::<f64>() {
        Ok(written) if written == recording.clock.rate_hz() => rate,
        _ => recording.clock.rate_hz().to_string(),
    };
    let start = match recording.clock.start_time() {
        StartTime::Unknown => None,
        _ => start_time::format(recording.clock.start_unix_nanos()),
    };
    let fact = |key: &str| recording.source.header.get(key).map(String::as_str);
    let up_axis = Some(recording.source.up_axis).filter(|&axis| axis != UpAxis::Y);
    let facts = [
        ("Format Version", Some("1.23")),
        ("Take Name", Some(recording.name.as_str())),
        (TAKE_NOTES, fact(TAKE_NOTES).or(Some(""))),
        (CAPTURE_RATE, fact(CAPTURE_RATE).or(Some(&rate))),
        ("Export Frame Rate", Some(&rate)),
        ("Capture Start Time", start.as_deref().or(Some(""))),
        (START_FRAME, fact(START_FRAME)),
        ("Total Frames in Take", Some(&samples)),
        ("Total Exported Frames", Some(&samples)),
        ("Rotation Type", Some("Quaternion")),
        ("Length Units", Some("Meters")),
        (SPACE, fact(SPACE).or(Some("Global"))),
        (UP_AXIS_KEY, up_axis.map(UpAxis::name)),
    ];
    let stated = facts.iter().filter_map(|&(key, value)| Some([key, value?]));
    write_rows([stated.flatten()], out)?;
    out.write_all(b"\r\n")
}

/// Writes the rows of types, names, IDs, kinds and axes.
fn write_labels(entities: &[Entity<'_>], out: &mut dyn Write) -> io::Result<()> {
    let mut columns = vec![["", "", "", "", "Frame"]];
    columns.push(["Type", "Name", "ID", "", "Time (Seconds)"]);
    for entity in entities {
        let (of, name, id) = match entity {
            Entity::Body(body) => {
                let of = match body.kind {
                    BodyKind::RigidBody => "Rigid Body",
                    BodyKind::Bone => "Bone",
                };
                (of, &body.name, &body.id)
            }
            Entity::Marker(marker) => {
                let of = match marker.kind {
                    MarkerKind::RigidBodyMarker => "Rigid Body Marker",
                    MarkerKind::Labelled | MarkerKind::Unlabelled => "Marker",
                };
                (of, &marker.name, &marker.id)
            }
        };
        let (rotation, extra): (&[&str], _) = match entity {
            Entity::Body(body) => {
                let error = body.marker_error_m.as_ref().map(|_| "Mean Marker Error");
                (&["X", "Y", "Z", "W"], error)
            }
            Entity::Marker(marker) => (&[], marker.quality.as_ref().map(|_| "Marker Quality")),
        };
        let rotation = rotation.iter().map(|&axis| ("Rotation", axis));
        let position = ["X", "Y", "Z"].map(|axis| ("Position", axis));
        let extra = extra.map(|kind| (kind, ""));
        let all = rotation.chain(position).chain(extra);
        columns.extend(all.map(|(kind, axis)| [of, name, id, kind, axis]));
    }
    let row = |place: usize| columns.iter().map(move |column| column[place]);
    write_rows((0..5).map(row), out)
}

fn write_rows<'a>(
    rows: impl IntoIterator<Item = impl Iterator<Item = &'a str>>,
    out: &mut dyn Write,
) -> io::Result<()> {
    let mut csv = csv::WriterBuilder::new()
        .terminator(csv::Terminator::CRLF)
        .from_writer(out);
    for row in rows {
        csv.write_record(row)?;
    }
    csv.flush()
}

fn cells<const N: usize>(out: &mut dyn Write, numbers: Option<[f64; N]>) -> io::Result<()> {
    match numbers {
        Some(numbers) => (numbers.iter()).try_for_each(|number| write!(out, ",{number}")),
        None => out.write_all(&[b','; N]),
    }
}

fn quality(out: &mut dyn Write, series: Option<&[f64]>, k: usize) -> io::Result<()> {
    let Some(series) = series else {
        return Ok(());
    };
    let number = series.get(k).copied().filter(|number| number.is_finite());
    cells(out, number.map(|number| [number]))
}
