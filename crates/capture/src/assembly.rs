//! From rows of numbers to tracks on an even clock.

use inhand_model::{
    Body, BodyKind, Clock, Finding, LengthUnit, Marker, MarkerKind, PointTrack, Pose, PoseTrack,
    Position, Recording, Source, Status, TrackedBody, World,
};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use rayon::prelude::*;

use crate::error::CaptureError;
use crate::table::{Rows, Table};

/// A jump in the frame column becomes missing samples as long as all jumps together leave out at
/// most this many times the rows that the file can hold...
const LEFT_OUT_PER_ROW: u64 = 10;

/// ...or this many samples over all entities, whichever is more: a file cut by hand to a few rows
/// still reads, and no small file asks for memory without bound.
const LEFT_OUT_SAMPLES: u64 = 100_000;

/// Some versions of Motive round the time column to a millisecond. Both the row's time and the
/// first row's carry half of that at most.
const TIME_ROUNDED_TO_MS_S: f64 = 1e-3;

/// Half of the sixth decimal for the row's time and for the first row's, and a margin.
const TIME_SIX_DECIMALS_S: f64 = 2e-6;

/// Relative precision of a time kept in single precision before it was printed.
const TIME_SINGLE_PRECISION: f64 = 1.2e-7;

/// A quaternion whose length is further from 1 than this is no rotation: six decimals leave 1e-6,
/// a spreadsheet set to three decimals 1e-3.
const QUATERNION_LENGTH_TOLERANCE: f64 = 1e-2;

/// Squared length up to which a quaternion counts as normalised already and is kept bit by bit.
const NORMALISED: f64 = 4.0 * f64::EPSILON;

/// Where a body's rotation stands among the values of a row.
#[derive(Clone, Copy, Debug)]
pub(crate) enum RotationColumns {
    /// x, y, z, w.
    Quaternion([usize; 4]),
    /// Angles about x, y, z in degrees, and the axes in the order in which the intrinsic rotations
    /// follow each other.
    Euler { angles: [usize; 3], axes: [u8; 3] },
}

/// Where a marker or body stands among the values of a row.
#[derive(Debug)]
pub(crate) enum Entity {
    Marker {
        name: String,
        id: String,
        kind: MarkerKind,
        position: [usize; 3],
        quality: Option<usize>,
    },
    Body {
        name: String,
        id: String,
        kind: BodyKind,
        rotation: RotationColumns,
        position: [usize; 3],
        marker_error: Option<usize>,
    },
}

/// Everything a header says about a take.
#[derive(Debug)]
pub(crate) struct Take {
    pub(crate) name: String,
    pub(crate) clock: Clock,
    pub(crate) source: Source,
    pub(crate) entities: Vec<Entity>,
    /// Whether a marker exactly at the origin is a missing one.
    pub(crate) zero_is_missing: bool,
    /// How many rows the header promises, and under which key.
    pub(crate) declared_rows: Option<(&'static str, u64)>,
    pub(crate) findings: Vec<Finding>,
}

/// Reads the rows of `table` into the entities of `take`.
///
/// # Errors
///
/// [`CaptureError`] where a row is damaged, frame numbers do not rise or leave out too much, or
/// there is no row at all.
pub(crate) fn assemble(table: &Table<'_>, take: Take) -> Result<Recording, CaptureError> {
    let rows_at_most = table.rows_at_most();
    let width = table.values();
    let scale = Scale::of(take.source.length_unit);
    let zero_is_missing = take.zero_is_missing;
    let mut series: Vec<Series> = take
        .entities
        .into_iter()
        .map(|entity| Series::new(entity, rows_at_most, zero_is_missing))
        .collect();
    let mut grid = Grid::new(table.file, rows_at_most, series.len());
    let mut times = TimeCheck::new(take.clock.rate_hz());

    table.for_each_batch(|batch| {
        let mut gaps = Vec::with_capacity(batch.len());
        for rows in batch {
            gaps.push(grid.place(rows)?);
            times.look_at(rows, &grid);
        }
        series.par_iter_mut().for_each(|series| {
            for (rows, gaps) in batch.iter().zip(&gaps) {
                series.push(rows, gaps, width, scale);
            }
        });
        Ok(())
    })?;

    if grid.rows == 0 {
        return Err(CaptureError::NoSamples {
            file: table.file.to_owned(),
        });
    }
    let mut findings = take.findings;
    if let Some((key, declared)) = take.declared_rows
        && declared != grid.rows
    {
        findings.push(Finding::warning(
            key,
            format!(
                "the header promises {declared} rows, found {}: read what is there; the file was \
                 cut or edited after the export",
                grid.rows
            ),
        ));
    }
    findings.extend(grid.finding());
    findings.extend(times.finding());
    let (mut markers, mut bodies) = (Vec::new(), Vec::new());
    for series in series {
        findings.extend(series.findings());
        match series.track {
            Tracked::Marker(marker) => markers.push(marker),
            Tracked::Body(body) => bodies.push(body),
        }
    }
    let mut recording = Recording::new(
        take.name,
        take.clock,
        take.source,
        grid.samples,
        markers,
        bodies,
    )
    .map_err(|source| CaptureError::Recording {
        file: table.file.to_owned(),
        source,
    })?;
    recording.findings = findings;
    Ok(recording)
}

/// Rows on the even grid of frames.
struct Grid<'a> {
    file: &'a str,
    rows_at_most: usize,
    limit: u64,
    rows: u64,
    samples: usize,
    first_frame: i64,
    last_frame: i64,
    left_out: u64,
    jumps: usize,
    first_jump: Option<(usize, i64, i64)>,
}

impl<'a> Grid<'a> {
    fn new(file: &'a str, rows_at_most: usize, entities: usize) -> Self {
        let by_rows = LEFT_OUT_PER_ROW.saturating_mul(rows_at_most as u64);
        Self {
            file,
            rows_at_most,
            limit: by_rows.max(LEFT_OUT_SAMPLES / entities.max(1) as u64),
            rows: 0,
            samples: 0,
            first_frame: 0,
            last_frame: 0,
            left_out: 0,
            jumps: 0,
            first_jump: None,
        }
    }

    /// The number of frames left out before each row.
    fn place(&mut self, rows: &Rows) -> Result<Vec<usize>, CaptureError> {
        let mut gaps = Vec::with_capacity(rows.len());
        for k in 0..rows.len() {
            // Without a frame column the rows are the frames.
            let frame = rows.frames.get(k).copied().unwrap_or(self.last_frame + 1);
            let gap = self.gap_before(frame, rows.line(k))?;
            gaps.push(gap);
            self.rows += 1;
            self.samples += gap + 1;
            self.last_frame = frame;
        }
        Ok(gaps)
    }

    fn gap_before(&mut self, frame: i64, line: usize) -> Result<usize, CaptureError> {
        if self.rows == 0 {
            self.first_frame = frame;
            return Ok(0);
        }
        let previous = self.last_frame;
        let step = frame - previous;
        if step < 1 {
            return Err(CaptureError::FrameOrder {
                file: self.file.to_owned(),
                line,
                previous,
                found: frame,
            });
        }
        let gap = step.unsigned_abs() - 1;
        if gap > 0 {
            self.left_out += gap;
            self.jumps += 1;
            self.first_jump.get_or_insert((line, previous, frame));
        }
        match usize::try_from(gap) {
            Ok(gap) if self.left_out <= self.limit => Ok(gap),
            _ => Err(CaptureError::FrameJump {
                file: self.file.to_owned(),
                line,
                previous,
                found: frame,
                left_out: self.left_out,
                rows: self.rows_at_most,
                limit: self.limit,
            }),
        }
    }

    fn finding(&self) -> Option<Finding> {
        let (line, previous, frame) = self.first_jump?;
        Some(Finding::warning(
            format!("line {line}"),
            format!(
                "frame {frame} follows frame {previous}; in all the frame column jumps {} times \
                 and leaves out {} frames: taken as missing samples",
                self.jumps, self.left_out
            ),
        ))
    }
}

/// The time column against `(frame - first frame) / rate`.
struct TimeCheck {
    rate_hz: f64,
    first_time_s: Option<(f64, i64)>,
    whole_milliseconds: bool,
    worst_s: f64,
    worst: Option<(usize, f64, f64)>,
}

impl TimeCheck {
    fn new(rate_hz: f64) -> Self {
        Self {
            rate_hz,
            first_time_s: None,
            whole_milliseconds: true,
            worst_s: 0.0,
            worst: None,
        }
    }

    fn look_at(&mut self, rows: &Rows, grid: &Grid<'_>) {
        for (k, &time_s) in rows.times_s.iter().enumerate() {
            if time_s.is_nan() {
                continue;
            }
            let frame = rows.frames.get(k).copied();
            let frame =
                frame.unwrap_or(grid.first_frame + (grid.rows as i64) - (rows.len() - k) as i64);
            let millis = time_s * 1e3;
            self.whole_milliseconds &= (millis - millis.round()).abs() < 1e-4;
            let (first_s, first_frame) = *self.first_time_s.get_or_insert((time_s, frame));
            let expected_s = first_s + (frame - first_frame) as f64 / self.rate_hz;
            let off_s = (time_s - expected_s).abs() - TIME_SINGLE_PRECISION * time_s.abs();
            if off_s > self.worst_s {
                self.worst_s = off_s;
                self.worst = Some((rows.line(k), time_s, expected_s));
            }
        }
    }

    fn finding(&self) -> Option<Finding> {
        let rounding_s = if self.whole_milliseconds {
            TIME_ROUNDED_TO_MS_S + TIME_SIX_DECIMALS_S
        } else {
            TIME_SIX_DECIMALS_S
        };
        let (line, found_s, expected_s) = self.worst.filter(|_| self.worst_s > rounding_s)?;
        Some(Finding::warning(
            format!("line {line}"),
            format!(
                "the time column says {found_s:.6} s where frame and rate ({} Hz) give \
                 {expected_s:.6} s, more than its rounding; this is the worst row: times are \
                 taken from the frames",
                self.rate_hz
            ),
        ))
    }
}

/// From the source's unit to metres. Decimal units divide, so that 110.763 mm becomes the number
/// nearest to 0.110763 m, which a product with 0.001 misses.
#[derive(Clone, Copy)]
struct Scale {
    factor: f64,
    divisor: f64,
}

impl Scale {
    fn of(unit: LengthUnit) -> Self {
        let (factor, divisor) = match unit {
            LengthUnit::Centimetres => (1.0, 100.0),
            LengthUnit::Millimetres => (1.0, 1000.0),
            _ => (unit.metres(), 1.0),
        };
        Self { factor, divisor }
    }

    fn metres(self, length: f64) -> f64 {
        length * self.factor / self.divisor
    }
}

enum Tracked {
    Marker(Marker),
    Body(TrackedBody),
}

#[derive(Clone, Copy)]
enum Slots {
    Marker {
        position: [usize; 3],
        quality: Option<usize>,
        zero_is_missing: bool,
    },
    Body {
        rotation: RotationColumns,
        position: [usize; 3],
        marker_error: Option<usize>,
    },
}

/// How often something happened, and where first.
#[derive(Clone, Copy, Default)]
struct Occurrences {
    count: usize,
    first_line: usize,
}

impl Occurrences {
    fn note(&mut self, line: usize) {
        if self.count == 0 {
            self.first_line = line;
        }
        self.count += 1;
    }
}

/// A marker or body while its rows come in.
struct Series {
    track: Tracked,
    slots: Slots,
    partial: Occurrences,
    no_rotation: Occurrences,
    at_origin: Occurrences,
}

impl Series {
    fn new(entity: Entity, capacity: usize, zero_is_missing: bool) -> Self {
        let column = |slot: Option<usize>| slot.map(|_| Vec::with_capacity(capacity));
        let (track, slots) = match entity {
            Entity::Marker {
                name,
                id,
                kind,
                position,
                quality,
            } => (
                Tracked::Marker(Marker {
                    name,
                    id,
                    kind,
                    track: PointTrack::with_capacity(capacity),
                    quality: column(quality),
                }),
                Slots::Marker {
                    position,
                    quality,
                    zero_is_missing,
                },
            ),
            Entity::Body {
                name,
                id,
                kind,
                rotation,
                position,
                marker_error,
            } => (
                Tracked::Body(TrackedBody {
                    name,
                    id,
                    kind,
                    track: PoseTrack::with_capacity(capacity),
                    marker_error_m: column(marker_error),
                }),
                Slots::Body {
                    rotation,
                    position,
                    marker_error,
                },
            ),
        };
        Self {
            track,
            slots,
            partial: Occurrences::default(),
            no_rotation: Occurrences::default(),
            at_origin: Occurrences::default(),
        }
    }

    /// Appends the rows of a block, each after the samples left out before it.
    fn push(&mut self, rows: &Rows, gaps: &[usize], width: usize, scale: Scale) {
        for (k, &gap) in gaps.iter().enumerate() {
            let values = &rows.values[k * width..][..width];
            match (&mut self.track, self.slots) {
                (
                    Tracked::Marker(marker),
                    Slots::Marker {
                        position,
                        quality,
                        zero_is_missing,
                    },
                ) => {
                    let coords = position.map(|slot| values[slot]);
                    let mut sample = None;
                    if coords.iter().all(|c| c.is_finite()) {
                        if zero_is_missing && coords == [0.0; 3] {
                            self.at_origin.note(rows.line(k));
                        } else {
                            sample = Some(Position::from(coords.map(|c| scale.metres(c))));
                        }
                    } else if coords.iter().any(|c| c.is_finite()) {
                        self.partial.note(rows.line(k));
                    }
                    for _ in 0..gap {
                        marker.track.push(None, Status::Missing);
                    }
                    marker.track.push(sample, Status::Measured);
                    append(&mut marker.quality, quality, values, gap, |quality| quality);
                }
                (
                    Tracked::Body(body),
                    Slots::Body {
                        rotation,
                        position,
                        marker_error,
                    },
                ) => {
                    let sample = match pose(values, rotation, position, scale) {
                        Ok(pose) => Some(pose),
                        Err(NoPose::Blank) => None,
                        Err(NoPose::Partial) => {
                            self.partial.note(rows.line(k));
                            None
                        }
                        Err(NoPose::NoRotation) => {
                            self.no_rotation.note(rows.line(k));
                            None
                        }
                    };
                    for _ in 0..gap {
                        body.track.push(None, Status::Missing);
                    }
                    body.track.push(sample, Status::Measured);
                    append(
                        &mut body.marker_error_m,
                        marker_error,
                        values,
                        gap,
                        |error| scale.metres(error),
                    );
                }
                // `Series::new` makes both of the same kind.
                _ => {}
            }
        }
    }

    fn findings(&self) -> impl Iterator<Item = Finding> {
        let entity = match &self.track {
            Tracked::Marker(marker) => format!("marker \"{}\"", marker.name),
            Tracked::Body(body) => format!("body \"{}\"", body.name),
        };
        [
            (self.partial, "some of its cells are blank"),
            (self.no_rotation, "its quaternion is not of unit length"),
            (self.at_origin, "it is exactly at the origin"),
        ]
        .into_iter()
        .filter(|(occurrences, _)| occurrences.count > 0)
        .map(move |(occurrences, what)| {
            Finding::warning(
                entity.clone(),
                format!(
                    "{what} in {} rows, first on line {}: taken as missing",
                    occurrences.count, occurrences.first_line
                ),
            )
        })
    }
}

/// Appends a quality value, and NaN for each sample left out before it.
fn append(
    series: &mut Option<Vec<f64>>,
    slot: Option<usize>,
    values: &[f64],
    gap: usize,
    convert: impl Fn(f64) -> f64,
) {
    if let (Some(series), Some(slot)) = (series, slot) {
        series.extend(std::iter::repeat_n(f64::NAN, gap));
        series.push(convert(values[slot]));
    }
}

enum NoPose {
    Blank,
    Partial,
    NoRotation,
}

fn pose(
    values: &[f64],
    rotation: RotationColumns,
    position: [usize; 3],
    scale: Scale,
) -> Result<Pose<World, Body>, NoPose> {
    let coords = position.map(|slot| values[slot]);
    let present = |slots: &[usize]| {
        slots
            .iter()
            .filter(|&&slot| values[slot].is_finite())
            .count()
    };
    let (found, expected) = match &rotation {
        RotationColumns::Quaternion(slots) => (present(slots) + present(&position), 7),
        RotationColumns::Euler { angles, .. } => (present(angles) + present(&position), 6),
    };
    if found == 0 {
        return Err(NoPose::Blank);
    }
    if found < expected {
        return Err(NoPose::Partial);
    }
    let rotation = match rotation {
        RotationColumns::Quaternion(slots) => {
            unit_quaternion(slots.map(|slot| values[slot])).ok_or(NoPose::NoRotation)?
        }
        RotationColumns::Euler { angles, axes } => euler(angles.map(|slot| values[slot]), axes),
    };
    let translation = Translation3::from(Vector3::from(coords.map(|c| scale.metres(c))));
    Ok(Pose::new(Isometry3::from_parts(translation, rotation)))
}

/// A rotation from x, y, z, w, unless their length is nowhere near 1. Its sign is kept.
fn unit_quaternion([x, y, z, w]: [f64; 4]) -> Option<UnitQuaternion<f64>> {
    let quaternion = Quaternion::new(w, x, y, z);
    let squared = quaternion.norm_squared();
    if (squared - 1.0).abs() <= NORMALISED {
        return Some(UnitQuaternion::new_unchecked(quaternion));
    }
    let length = squared.sqrt();
    ((length - 1.0).abs() <= QUATERNION_LENGTH_TOLERANCE)
        .then(|| UnitQuaternion::new_unchecked(quaternion / length))
}

/// A rotation from intrinsic Euler angles: `angles_deg` about x, y, z, the rotation about `axes[0]`
/// first, each next one about the axis that the ones before have turned; as matrices
/// `R(axes[0]) R(axes[1]) R(axes[2])`.
pub(crate) fn euler(angles_deg: [f64; 3], axes: [u8; 3]) -> UnitQuaternion<f64> {
    let about = |axis: u8| {
        let angle = angles_deg[usize::from(axis)].to_radians();
        match axis {
            0 => UnitQuaternion::from_axis_angle(&Vector3::x_axis(), angle),
            1 => UnitQuaternion::from_axis_angle(&Vector3::y_axis(), angle),
            _ => UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle),
        }
    };
    about(axes[0]) * about(axes[1]) * about(axes[2])
}
