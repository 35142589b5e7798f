//! One marker or body while its rows come in.

use std::ops::Range;

use inhand_model::{
    Body, BodyKind, Finding, LengthUnit, Marker, MarkerKind, PointTrack, Pose, PoseTrack, Position,
    Status, TrackedBody, World, rotation_from_xyzw,
};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use crate::table::Rows;

/// Places of a body's rotation among the values of a row.
#[derive(Clone, Copy)]
pub(crate) enum RotationColumns {
    /// x, y, z, w.
    Quaternion([usize; 4]),
    /// Angles about x, y, z in degrees, and the axes in the order in which the intrinsic rotations
    /// follow each other.
    Euler { angles: [usize; 3], axes: [u8; 3] },
}

enum Samples {
    Points(MarkerKind, PointTrack<World>),
    Poses(BodyKind, RotationColumns, PoseTrack<World, Body>),
}

/// Reasons for a missing sample though some of its cells are not blank.
#[derive(Clone, Copy)]
enum Oddity {
    Partial,
    NoRotation,
    AtOrigin,
}

/// Text of the finding of each [`Oddity`].
const ODDITIES: [&str; 3] = [
    "some of its cells are blank",
    "its quaternion is not of unit length",
    "it is exactly at the origin",
];

/// A marker or body while its rows come in.
pub(crate) struct Series {
    name: String,
    id: String,
    /// Places of the position among the values of a row.
    position: [usize; 3],
    samples: Samples,
    /// Place and values of a marker's quality or a body's error.
    extra: Option<(usize, Vec<f64>)>,
    /// Number of samples with each [`Oddity`], and line of the first.
    odd: [(usize, usize); 3],
}

impl Series {
    pub(crate) fn marker(
        name: &str,
        id: &str,
        kind: MarkerKind,
        position: [usize; 3],
        quality: Option<usize>,
    ) -> Self {
        let samples = Samples::Points(kind, PointTrack::missing(0));
        Self::new(name, id, samples, position, quality)
    }

    pub(crate) fn body(
        name: &str,
        id: &str,
        kind: BodyKind,
        rotation: RotationColumns,
        position: [usize; 3],
        marker_error: Option<usize>,
    ) -> Self {
        let samples = Samples::Poses(kind, rotation, PoseTrack::missing(0));
        Self::new(name, id, samples, position, marker_error)
    }

    fn new(
        name: &str,
        id: &str,
        samples: Samples,
        position: [usize; 3],
        extra: Option<usize>,
    ) -> Self {
        Self {
            name: name.to_owned(),
            id: id.to_owned(),
            position,
            samples,
            extra: extra.map(|column| (column, Vec::new())),
            odd: [(0, 0); 3],
        }
    }

    /// Appends samples that the file leaves out.
    pub(super) fn push_missing(&mut self, samples: usize) {
        for _ in 0..samples {
            match &mut self.samples {
                Samples::Points(_, track) => track.push(None, Status::Missing),
                Samples::Poses(_, _, track) => track.push(None, Status::Missing),
            }
        }
        if let Some((_, values)) = &mut self.extra {
            values.extend(std::iter::repeat_n(f64::NAN, samples));
        }
    }

    /// Appends some rows, of `width` values each.
    pub(super) fn push(
        &mut self,
        rows: &Rows,
        range: Range<usize>,
        width: usize,
        unit: LengthUnit,
        zero_is_missing: bool,
    ) {
        for k in range {
            let values = &rows.values[k * width..][..width];
            let coords = self.position.map(|slot| values[slot]);
            let odd = match &mut self.samples {
                Samples::Points(_, track) => {
                    let found = point(coords, unit, zero_is_missing);
                    track.push(found.ok().flatten(), Status::Measured);
                    found.err()
                }
                Samples::Poses(_, rotation, track) => {
                    let found = pose(values, coords, *rotation, unit);
                    track.push(found.ok().flatten(), Status::Measured);
                    found.err()
                }
            };
            if let Some(odd) = odd {
                let (count, first_line) = &mut self.odd[odd as usize];
                if *count == 0 {
                    *first_line = rows.lines[k];
                }
                *count += 1;
            }
            if let Some((column, extra)) = &mut self.extra {
                extra.push(match self.samples {
                    Samples::Points(..) => values[*column],
                    Samples::Poses(..) => unit.to_metres(values[*column]),
                });
            }
        }
    }

    /// Moves the samples so far into a marker or body; the series goes on behind them, with room for
    /// some.
    pub(super) fn take(
        &mut self,
        room: usize,
        markers: &mut Vec<Marker>,
        bodies: &mut Vec<TrackedBody>,
    ) {
        let (name, id) = (self.name.clone(), self.id.clone());
        let extra = (self.extra.as_mut())
            .map(|(_, values)| std::mem::replace(values, Vec::with_capacity(room)));
        match &mut self.samples {
            Samples::Points(kind, track) => markers.push(Marker {
                name,
                id,
                kind: *kind,
                track: std::mem::replace(track, PointTrack::with_capacity(room)),
                quality: extra,
            }),
            Samples::Poses(kind, _, track) => bodies.push(TrackedBody {
                name,
                id,
                kind: *kind,
                track: std::mem::replace(track, PoseTrack::with_capacity(room)),
                marker_error_m: extra,
            }),
        }
    }

    pub(super) fn findings(&self) -> impl Iterator<Item = Finding> {
        let entity = match &self.samples {
            Samples::Points(..) => format!("marker \"{}\"", self.name),
            Samples::Poses(..) => format!("body \"{}\"", self.name),
        };
        (self.odd.into_iter().zip(ODDITIES))
            .filter(|((count, _), _)| *count > 0)
            .map(move |((count, first_line), what)| {
                let message =
                    format!("{what} in {count} rows, first on line {first_line}: taken as missing");
                Finding::warning(entity.clone(), message)
            })
    }
}

/// A point in metres; `None` where all cells are blank.
fn point(
    coords: [f64; 3],
    unit: LengthUnit,
    zero_is_missing: bool,
) -> Result<Option<Position<World>>, Oddity> {
    match coords.iter().filter(|c| c.is_finite()).count() {
        0 => Ok(None),
        3 if zero_is_missing && coords == [0.0; 3] => Err(Oddity::AtOrigin),
        3 => Ok(Some(Position::from(coords.map(|c| unit.to_metres(c))))),
        _ => Err(Oddity::Partial),
    }
}

/// A pose in metres; `None` where all cells are blank.
fn pose(
    values: &[f64],
    coords: [f64; 3],
    rotation: RotationColumns,
    unit: LengthUnit,
) -> Result<Option<Pose<World, Body>>, Oddity> {
    let slots = match &rotation {
        RotationColumns::Quaternion(slots) => &slots[..],
        RotationColumns::Euler { angles, .. } => angles,
    };
    let rotations = slots.iter().map(|&slot| values[slot]);
    let present = rotations.chain(coords).filter(|c| c.is_finite()).count();
    if present == 0 {
        return Ok(None);
    }
    if present < slots.len() + coords.len() {
        return Err(Oddity::Partial);
    }
    let rotation = match rotation {
        RotationColumns::Quaternion(slots) => {
            rotation_from_xyzw(slots.map(|slot| values[slot])).ok_or(Oddity::NoRotation)?
        }
        RotationColumns::Euler { angles, axes } => euler(angles.map(|slot| values[slot]), axes),
    };
    let translation = Translation3::from(Vector3::from(coords.map(|c| unit.to_metres(c))));
    let isometry = Isometry3::from_parts(translation, rotation);
    Ok(Some(Pose::new(isometry)))
}

/// A rotation from intrinsic Euler angles: `angles_deg` about x, y, z, the rotation about `axes[0]`
/// first, each next one about the axis that the ones before have turned; as matrices
/// `R(axes[0]) R(axes[1]) R(axes[2])`.
fn euler(angles_deg: [f64; 3], axes: [u8; 3]) -> UnitQuaternion<f64> {
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
