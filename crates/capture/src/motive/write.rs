//! Recordings as Motive CSV 1.23.

use std::io::{self, Write};

use inhand_model::{
    BodyKind, Marker, MarkerKind, Pose, Position, Recording, StartTime, TrackedBody, UpAxis,
};

use super::UP_AXIS_KEY;
use crate::error::CaptureError;
use crate::start_time;

/// Bytes of rows gathered before they are handed to the writer.
const FLUSH_BYTES: usize = 64 * 1024;

/// Facts passed on from the source's header as they stand there, with what Motive would say
/// otherwise.
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
/// # Errors
///
/// [`CaptureError::Write`] where `out` fails.
pub fn write(recording: &Recording, out: &mut impl Write) -> Result<(), CaptureError> {
    let entities = in_motive_order(recording);
    write_header(recording, &entities, out)?;
    let mut buffer = Vec::with_capacity(FLUSH_BYTES + 4096);
    let rate_hz = recording.clock.rate_hz();
    for k in 0..recording.len() {
        write!(buffer, "{k},{:.6}", k as f64 / rate_hz)?;
        for entity in &entities {
            match entity {
                Entity::Body(body) => {
                    let pose = body.track.get(k);
                    cells(&mut buffer, pose.map(Pose::quaternion_xyzw))?;
                    cells(&mut buffer, pose.map(|pose| pose.origin().to_array()))?;
                    quality(&mut buffer, body.marker_error_m.as_deref(), k)?;
                }
                Entity::Marker(marker) => {
                    cells(&mut buffer, marker.track.get(k).map(Position::to_array))?;
                    quality(&mut buffer, marker.quality.as_deref(), k)?;
                }
            }
        }
        buffer.extend_from_slice(b"\r\n");
        if buffer.len() >= FLUSH_BYTES {
            out.write_all(&buffer)?;
            buffer.clear();
        }
    }
    out.write_all(&buffer)?;
    out.flush()?;
    Ok(())
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

fn write_header(
    recording: &Recording,
    entities: &[Entity<'_>],
    out: &mut impl Write,
) -> io::Result<()> {
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
    let mut facts = vec![
        ("Format Version", "1.23"),
        ("Take Name", recording.name.as_str()),
        (TAKE_NOTES, fact(TAKE_NOTES).unwrap_or_default()),
        (CAPTURE_RATE, fact(CAPTURE_RATE).unwrap_or(&rate)),
        ("Export Frame Rate", &rate),
        ("Capture Start Time", start.as_deref().unwrap_or_default()),
    ];
    if let Some(frame) = fact(START_FRAME) {
        facts.push((START_FRAME, frame));
    }
    facts.extend([
        ("Total Frames in Take", samples.as_str()),
        ("Total Exported Frames", samples.as_str()),
        ("Rotation Type", "Quaternion"),
        ("Length Units", "Meters"),
        (SPACE, fact(SPACE).unwrap_or("Global")),
    ]);
    if recording.source.up_axis != UpAxis::Y {
        facts.push((UP_AXIS_KEY, recording.source.up_axis.name()));
    }

    let [mut types, mut names, mut ids] = ["Type", "Name", "ID"].map(|label| vec!["", label]);
    let mut kinds = vec!["", ""];
    let mut axes = vec!["Frame", "Time (Seconds)"];
    for entity in entities {
        let first = kinds.len();
        let (of, name, id) = match entity {
            Entity::Body(body) => {
                kinds.extend(["Rotation"; 4]);
                kinds.extend(["Position"; 3]);
                axes.extend(["X", "Y", "Z", "W", "X", "Y", "Z"]);
                if body.marker_error_m.is_some() {
                    kinds.push("Mean Marker Error");
                    axes.push("");
                }
                let of = match body.kind {
                    BodyKind::RigidBody => "Rigid Body",
                    BodyKind::Bone => "Bone",
                };
                (of, &body.name, &body.id)
            }
            Entity::Marker(marker) => {
                kinds.extend(["Position"; 3]);
                axes.extend(["X", "Y", "Z"]);
                if marker.quality.is_some() {
                    kinds.push("Marker Quality");
                    axes.push("");
                }
                let of = match marker.kind {
                    MarkerKind::RigidBodyMarker => "Rigid Body Marker",
                    MarkerKind::Labelled | MarkerKind::Unlabelled => "Marker",
                };
                (of, &marker.name, &marker.id)
            }
        };
        let columns = kinds.len() - first;
        for (row, label) in [(&mut types, of), (&mut names, name), (&mut ids, id)] {
            row.extend(std::iter::repeat_n(label, columns));
        }
    }

    let mut csv = csv::WriterBuilder::new()
        .flexible(true)
        .terminator(csv::Terminator::CRLF)
        .from_writer(Vec::new());
    csv.write_record(facts.iter().flat_map(|&(key, value)| [key, value]))?;
    out.write_all(&csv.into_inner().map_err(csv::IntoInnerError::into_error)?)?;
    out.write_all(b"\r\n")?;
    let mut csv = csv::WriterBuilder::new()
        .terminator(csv::Terminator::CRLF)
        .from_writer(Vec::new());
    for row in [types, names, ids, kinds, axes] {
        csv.write_record(row)?;
    }
    out.write_all(&csv.into_inner().map_err(csv::IntoInnerError::into_error)?)
}

fn cells<const N: usize>(buffer: &mut Vec<u8>, numbers: Option<[f64; N]>) -> io::Result<()> {
    match numbers {
        Some(numbers) => numbers
            .iter()
            .try_for_each(|number| write!(buffer, ",{number}")),
        None => {
            buffer.extend_from_slice(&[b','; N]);
            Ok(())
        }
    }
}

fn quality(buffer: &mut Vec<u8>, series: Option<&[f64]>, k: usize) -> io::Result<()> {
    series.map_or(Ok(()), |series| {
        let number = series.get(k).copied().filter(|number| number.is_finite());
        cells(buffer, number.map(|number| [number]))
    })
}
