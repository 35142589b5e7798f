//! Markers as TRC.

use std::io::{self, Write};

use inhand_model::{Position, Recording, UpAxis, World};

use super::MAGIC;
use crate::error::CaptureError;

/// Bytes of rows gathered before they are handed to the writer.
const FLUSH_BYTES: usize = 64 * 1024;

/// Writes the markers of a recording as TRC: metres, frames from 1, blank cells for missing samples.
///
/// Y is up, which readers take for granted because the format cannot say it: a recording whose Z is
/// up is turned by a quarter about X, (x, y, z) becomes (x, z, -y), which changes no digit.
///
/// Numbers have as many digits as it takes to read them back unchanged. What the format cannot hold
/// is lost: bodies, qualities, the mark on filled samples, the start time, findings.
///
/// # Errors
///
/// [`CaptureError::Output`] where `out` fails.
pub fn write(recording: &Recording, out: &mut impl Write) -> Result<(), CaptureError> {
    rows(recording, out).map_err(|source| CaptureError::Output {
        format: "TRC",
        source,
    })
}

fn rows(recording: &Recording, out: &mut impl Write) -> io::Result<()> {
    let mut buffer = Vec::with_capacity(FLUSH_BYTES + 4096);
    header(recording, &mut buffer)?;
    let up_axis = recording.source.up_axis;
    for k in 0..recording.len() {
        write!(buffer, "{}\t{:.6}", k + 1, recording.clock.time_s(k))?;
        for marker in &recording.markers {
            match marker.track.get(k).map(|position| y_up(position, up_axis)) {
                Some([x, y, z]) => write!(buffer, "\t{x}\t{y}\t{z}")?,
                None => buffer.extend_from_slice(b"\t\t\t"),
            }
        }
        buffer.extend_from_slice(b"\r\n");
        if buffer.len() >= FLUSH_BYTES {
            out.write_all(&buffer)?;
            buffer.clear();
        }
    }
    out.write_all(&buffer)?;
    out.flush()
}

/// Coordinates with Y up: the inverse of [`UpAxis::upright_from_world`] for Y, exactly.
fn y_up(position: Position<World>, up_axis: UpAxis) -> [f64; 3] {
    let [x, y, z] = position.to_array();
    match up_axis {
        UpAxis::Y => [x, y, z],
        UpAxis::Z => [x, z, -y],
    }
}

fn header(recording: &Recording, out: &mut Vec<u8>) -> io::Result<()> {
    let (rate_hz, frames) = (recording.clock.rate_hz(), recording.len());
    let markers = recording.markers.len();
    write!(
        out,
        "{MAGIC}\t4\t(X/Y/Z)\t{}.trc\r\n",
        cell(&recording.name)
    )?;
    out.extend_from_slice(
        b"DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\t\
          OrigNumFrames\r\n",
    );
    write!(
        out,
        "{rate_hz}\t{rate_hz}\t{frames}\t{markers}\tm\t{rate_hz}\t1\t{frames}\r\n"
    )?;
    out.extend_from_slice(b"Frame#\tTime");
    for marker in &recording.markers {
        // A name stands above the first of its three columns.
        write!(out, "\t{}\t\t", cell(&marker.name))?;
    }
    out.extend_from_slice(b"\r\n\t");
    for number in 1..=markers {
        write!(out, "\tX{number}\tY{number}\tZ{number}")?;
    }
    out.extend_from_slice(b"\r\n\r\n");
    Ok(())
}

/// A text that stays within its cell.
fn cell(text: &str) -> String {
    text.replace(|c: char| c.is_control(), " ")
}
