//! Where the points of each frame lie, and what they say.

use inhand_model::{Finding, LengthUnit, PointTrack, Position, Status, World};

use super::number::Processor;
use super::parameters::Parameters;
use super::{BLOCK_BYTES, damaged, disagree};
use crate::error::CaptureError;

/// Numbers of a point: three coordinates, and one of residual and cameras.
const NUMBERS: usize = 4;

/// A count that a word cannot hold is written as this.
const FULL_WORD: u64 = 65535;

/// The frames of a file.
#[derive(Debug)]
pub(super) struct Layout {
    pub(super) frames: usize,
    processor: Processor,
    points: usize,
    /// What integers are times; `None` for floating point.
    scale: Option<f64>,
    start: usize,
    frame_bytes: usize,
}

impl Layout {
    /// Where the frames lie by header and parameters, as far as the file goes.
    pub(super) fn of(
        parameters: &Parameters,
        bytes: &[u8],
        file: &str,
        findings: &mut Vec<Finding>,
    ) -> Result<Self, CaptureError> {
        let header = &parameters.header;
        let mut number = |name: &str, from_header: f64, usable: fn(f64) -> bool| match parameters
            .number("POINT", name)
            .filter(|&value| usable(value))
        {
            Some(value) if value != from_header => {
                let place = format!("POINT:{name}");
                findings.push(disagree(&place, from_header, value, "the parameter"));
                value
            }
            Some(value) => value,
            None => from_header,
        };
        let points = number("USED", header.points.into(), |n| n >= 0.0) as usize;
        let scale = number("SCALE", header.scale.into(), |n| n.is_finite() && n != 0.0);
        let block = number("DATA_START", header.data_block.into(), |n| n >= 1.0) as usize;
        if points == 0 {
            return Err(damaged(
                file,
                2,
                "points".to_owned(),
                "none: analog data alone is no motion".to_owned(),
            ));
        }
        if !scale.is_finite() || scale == 0.0 {
            let found = scale.to_string();
            let expected = "a scale of points other than zero".to_owned();
            return Err(damaged(file, 12, expected, found));
        }
        let start = block.saturating_sub(1) * BLOCK_BYTES;
        let Some(data) = bytes.get(start..).filter(|_| block > 0) else {
            return Err(damaged(
                file,
                16,
                format!(
                    "a block of data within the {} bytes of the file",
                    bytes.len()
                ),
                format!("block {block}"),
            ));
        };
        let width = if scale < 0.0 { 4 } else { 2 };
        let bytes_of = |analog: usize| (NUMBERS * points + analog) * width;
        let declared = declared_frames(parameters, findings);
        let analog = analog_numbers(parameters, |analog| {
            (declared as u128) * (bytes_of(analog) as u128) <= data.len() as u128
        });
        let frame_bytes = bytes_of(analog);
        let held = data.len() / frame_bytes;
        let frames = usize::try_from(declared).unwrap_or(usize::MAX).min(held);
        if frames == 0 {
            return Err(CaptureError::NoSamples {
                file: file.to_owned(),
            });
        }
        if (frames as u64) < declared {
            findings.push(Finding::warning(
                "POINT:FRAMES",
                format!(
                    "the file promises {declared} frames of {points} points and holds {held}: read \
                     what is there; the file was cut"
                ),
            ));
        }
        Ok(Self {
            frames,
            processor: parameters.processor,
            points,
            scale: (scale > 0.0).then_some(scale),
            start,
            frame_bytes,
        })
    }

    /// The points over all frames, metres.
    pub(super) fn tracks(
        &self,
        bytes: &[u8],
        unit: LengthUnit,
        findings: &mut Vec<Finding>,
    ) -> Vec<PointTrack<World>> {
        let mut tracks: Vec<PointTrack<World>> = (0..self.points)
            .map(|_| PointTrack::with_capacity(self.frames))
            .collect();
        let mut at_origin = 0_usize;
        let data = bytes.get(self.start..).unwrap_or_default();
        let width = if self.scale.is_some() { 2 } else { 4 };
        for frame in data.chunks_exact(self.frame_bytes).take(self.frames) {
            let points = frame.chunks_exact(NUMBERS * width);
            for (track, point) in tracks.iter_mut().zip(points) {
                let seen = self.point(point);
                let origin = seen == Some([0.0; 3]);
                at_origin += usize::from(origin);
                let position = seen
                    .filter(|_| !origin)
                    .map(|coordinates| Position::from(coordinates.map(|c| metres(c, unit))));
                track.push(position, Status::Measured);
            }
        }
        if at_origin > 0 {
            findings.push(Finding::warning(
                "points",
                format!("{at_origin} samples lie exactly at the origin: taken as missing"),
            ));
        }
        tracks
    }

    /// The coordinates of a point in the file's unit, unless its residual says that it is missing.
    fn point(&self, bytes: &[u8]) -> Option<[f64; 3]> {
        match self.scale {
            Some(scale) => {
                let word = |k: usize| self.processor.i16([bytes[2 * k], bytes[2 * k + 1]]);
                let coordinates = [0, 1, 2].map(|k| f64::from(word(k)) * scale);
                (word(3) >= 0).then_some(coordinates)
            }
            None => {
                let real = |k: usize| {
                    let at = 4 * k;
                    let bytes = [bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]];
                    f64::from(self.processor.f32(bytes))
                };
                let coordinates = [0, 1, 2].map(real);
                // Residual and cameras; a number that is none is no residual.
                let valid = real(3) >= 0.0 && coordinates.iter().all(|c| c.is_finite());
                valid.then_some(coordinates)
            }
        }
    }
}

/// Metres, decimal units by division: 110.763 mm becomes the number nearest to 0.110763 m.
fn metres(length: f64, unit: LengthUnit) -> f64 {
    match unit {
        LengthUnit::Centimetres => length / 100.0,
        LengthUnit::Millimetres => length / 1000.0,
        _ => length * unit.metres(),
    }
}

/// Frames by what counts them best: the trial's ends, where a word could not hold the count, then
/// the parameter, then the header.
fn declared_frames(parameters: &Parameters, findings: &mut Vec<Finding>) -> u64 {
    let header = &parameters.header;
    let from_header = (u64::from(header.last_frame) + 1).saturating_sub(header.first_frame.into());
    let parameter = parameters
        .long("POINT", "FRAMES")
        .filter(|&frames| frames > 0);
    let trial = parameters
        .long("TRIAL", "ACTUAL_END_FIELD")
        .zip(parameters.long("TRIAL", "ACTUAL_START_FIELD"))
        .map(|(end, start)| (end + 1).saturating_sub(start))
        .filter(|&frames| frames > 0);
    let word_is_full = parameter.is_none_or(|frames| frames == FULL_WORD)
        || u64::from(header.last_frame) == FULL_WORD;
    match (trial, parameter) {
        (Some(trial), _) if word_is_full => trial,
        (_, Some(parameter)) => {
            if parameter != from_header {
                let (header, parameter) = (from_header as f64, parameter as f64);
                findings.push(disagree("POINT:FRAMES", header, parameter, "the parameter"));
            }
            parameter
        }
        (_, None) => from_header,
    }
}

/// Analog numbers in a frame: by the parameters, unless the file is too short for them.
fn analog_numbers(parameters: &Parameters, fits: impl Fn(usize) -> bool) -> usize {
    let header = &parameters.header;
    let from_header = usize::from(header.analog_per_frame);
    let samples = usize::from(header.analog_samples);
    let used = parameters.number("ANALOG", "USED");
    let by_parameters = used.map(|used| used as usize * samples);
    match by_parameters {
        Some(analog) if fits(analog) || !fits(from_header) => analog,
        _ => from_header,
    }
}
