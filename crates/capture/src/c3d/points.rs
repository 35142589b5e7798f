//! Point section of a C3D file: where it is and how its values are stored.

use inhand_model::{Finding, LengthUnit, PointTrack, Position, Status, World};

use super::number::Processor;
use super::parameters::Parameters;
use super::{BLOCK_BYTES, damaged, disagree};
use crate::error::CaptureError;

/// Numbers of a point: three coordinates, and one of residual and cameras.
const NUMBERS: usize = 4;

/// A count that a word cannot hold is written as this.
const FULL_WORD: u64 = 65535;

/// Points, analog channels and blocks at most: what a word can count.
const MOST: u32 = 65535;

/// The number of the first frame in its trial.
const START: (&str, &str) = ("TRIAL", "ACTUAL_START_FIELD");

/// The points of a file: where they are and how they are stored.
pub(super) struct Points {
    pub(super) frames: usize,
    processor: Processor,
    /// Points of a frame.
    points: usize,
    /// Factor of integers; `None` for floating point.
    scale: Option<f64>,
    start: usize,
    frame_bytes: usize,
}

impl Points {
    /// Finds the points by header and parameters, as far as the file goes.
    pub(super) fn find(
        parameters: &Parameters,
        bytes: &[u8],
        file: &str,
        findings: &mut Vec<Finding>,
    ) -> Result<Self, CaptureError> {
        let (points, scale, start) = layout(parameters, bytes, file, findings)?;
        let data_bytes = (bytes.len() - start) as u64;
        let width: u64 = if scale < 0.0 { 4 } else { 2 };
        let bytes_of = |analog: u64| {
            let numbers = ((NUMBERS * points) as u64).saturating_add(analog);
            numbers.saturating_mul(width)
        };
        let declared = declared_frames(parameters, file, findings)?;
        let analog = analog_numbers(parameters, file, |analog| {
            declared.saturating_mul(bytes_of(analog)) <= data_bytes
        })?;
        // A frame that no memory holds is longer than the file.
        let frame_bytes = usize::try_from(bytes_of(analog)).unwrap_or(usize::MAX);
        let held = data_bytes / frame_bytes as u64;
        let frames = declared.min(held);
        if frames == 0 {
            return Err(CaptureError::no_samples(file));
        }
        let rest = data_bytes.saturating_sub(declared.saturating_mul(frame_bytes as u64));
        let message = if frames < declared {
            format!(
                "the file promises {declared} frames of {points} points and has {held}: read what \
                 is there; the file was cut"
            )
        } else if held > declared && rest >= BLOCK_BYTES as u64 {
            // Less than a block fills up the last one.
            format!(
                "the file counts {declared} frames of {points} points and has room for {held}: read those \
                 that are counted; export the take again where the others are missed"
            )
        } else {
            String::new()
        };
        if !message.is_empty() {
            findings.push(Finding::warning("POINT:FRAMES", message));
        }
        Ok(Self {
            frames: frames as usize,
            processor: parameters.processor,
            points,
            scale: (scale > 0.0).then_some(scale),
            start,
            frame_bytes,
        })
    }

    /// Points of a frame.
    pub(super) fn count(&self) -> usize {
        self.points
    }

    /// The points over all frames, metres, by their index; without those that are left out.
    pub(super) fn tracks(
        &self,
        bytes: &[u8],
        unit: LengthUnit,
        left_out: &[bool],
        findings: &mut Vec<Finding>,
    ) -> Vec<(usize, PointTrack<World>)> {
        let read = (0..self.points).filter(|&k| !left_out[k]);
        let mut tracks: Vec<(usize, PointTrack<World>)> = read
            .map(|k| (k, PointTrack::with_capacity(self.frames)))
            .collect();
        let mut at_origin = 0_usize;
        let data = bytes.get(self.start..).unwrap_or_default();
        let width = if self.scale.is_some() { 2 } else { 4 };
        for frame in data.chunks_exact(self.frame_bytes).take(self.frames) {
            for (k, track) in &mut tracks {
                let seen = self.point(&frame[NUMBERS * width * *k..]);
                let origin = seen == Some([0.0; 3]);
                at_origin += usize::from(origin);
                let position = seen
                    .filter(|_| !origin)
                    .map(|coordinates| Position::from(coordinates.map(|c| unit.to_metres(c))));
                track.push(position, Status::Measured);
            }
        }
        if at_origin > 0 {
            let message =
                format!("{at_origin} samples are exactly at the origin: taken as missing");
            findings.push(Finding::warning("points", message));
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

/// Points of a frame, their scale (negative for floating point) and the first byte of the first frame:
/// where header and parameter disagree the parameter counts.
fn layout(
    parameters: &Parameters,
    bytes: &[u8],
    file: &str,
    findings: &mut Vec<Finding>,
) -> Result<(usize, f64, usize), CaptureError> {
    let header = &parameters.header;
    let mut preferred = |name: &str, from_header: f64, parameter: Option<f64>| match parameter {
        Some(value) if value != from_header => {
            let place = format!("POINT:{name}");
            findings.push(disagree(&place, from_header, value, "the parameter"));
            value
        }
        _ => from_header,
    };
    let count = |name: &str| {
        let count = parameters.count(file, ("POINT", name), MOST)?;
        Ok::<_, CaptureError>(count.map(|count| count as f64))
    };
    let points = preferred("USED", header.points.into(), count("USED")?) as usize;
    let scale = parameters.number("POINT", "SCALE");
    let scale = scale.filter(|scale| scale.is_finite() && *scale != 0.0);
    let scale = preferred("SCALE", header.scale.into(), scale);
    let block = count("DATA_START")?.filter(|&block| block > 0.0);
    let block = preferred("DATA_START", header.data_block.into(), block) as usize;
    if points == 0 {
        let found = "none: analog data alone is no motion";
        return Err(damaged(file, 2, "points", found));
    }
    if !scale.is_finite() || scale == 0.0 {
        return Err(damaged(
            file,
            12,
            "a scale of points other than zero",
            scale,
        ));
    }
    let start = block.saturating_sub(1).saturating_mul(BLOCK_BYTES);
    if block == 0 || start > bytes.len() {
        let bytes = bytes.len();
        let expected = format_args!("a block of data within the {bytes} bytes of the file");
        return Err(damaged(file, 16, expected, format_args!("block {block}")));
    }
    Ok((points, scale, start))
}

/// Frames by what counts them best: the parameter made for counts that no word holds, the trial's ends, where a word
/// could not hold the count, then the usual parameter, then the header.
fn declared_frames(
    parameters: &Parameters,
    file: &str,
    findings: &mut Vec<Finding>,
) -> Result<u64, CaptureError> {
    let header = &parameters.header;
    let from_header = header.frames();
    let long = (parameters.long(file, ("POINT", "LONG_FRAMES"))?).filter(|&frames| frames > 0);
    let parameter = (parameters.long(file, ("POINT", "FRAMES"))?).filter(|&frames| frames > 0);
    let trial = parameters
        .long(file, ("TRIAL", "ACTUAL_END_FIELD"))?
        .zip(parameters.long(file, START)?)
        .map(|(end, start)| end.saturating_add(1).saturating_sub(start))
        .filter(|&frames| frames > 0);
    let word_is_full = parameter.is_none_or(|frames| frames == FULL_WORD)
        || u64::from(header.last_frame) == FULL_WORD;
    if let Some(long) = long {
        return Ok(long);
    }
    Ok(match (trial, parameter) {
        (Some(trial), _) if word_is_full => trial,
        (_, Some(parameter)) => {
            // A full word disagrees with nothing.
            if parameter != from_header && from_header != FULL_WORD {
                let (header, parameter) = (from_header as f64, parameter as f64);
                findings.push(disagree("POINT:FRAMES", header, parameter, "the parameter"));
            }
            parameter
        }
        (_, None) => from_header,
    })
}

/// The number of the first frame in its trial.
pub(super) fn first_frame(parameters: &Parameters, file: &str) -> Result<i64, CaptureError> {
    let stated = parameters.long(file, START)?;
    Ok(match stated.and_then(|start| i64::try_from(start).ok()) {
        // Two words of a negative number.
        Some(start) if start > i64::from(i32::MAX) => start - (1 << 32),
        Some(start) => start,
        None => parameters.header.first_frame(),
    })
}

/// Analog numbers in a frame: by the parameters, unless the file is too short for them.
fn analog_numbers(
    parameters: &Parameters,
    file: &str,
    fits: impl Fn(u64) -> bool,
) -> Result<u64, CaptureError> {
    let header = &parameters.header;
    let from_header = u64::from(header.analog_per_frame);
    let samples = u64::from(header.analog_samples);
    let used = parameters.count(file, ("ANALOG", "USED"), MOST)?;
    let by_parameters = used.map(|used| used.saturating_mul(samples));
    Ok(match by_parameters {
        Some(analog) if fits(analog) || !fits(from_header) => analog,
        _ => from_header,
    })
}
