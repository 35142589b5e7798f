//! One marker or body while its rows come in.

use std::ops::Range;

use inhand_model::{
    Body, Finding, LengthUnit, Marker, PointTrack, Pose, PoseTrack, Position, Status, TrackedBody,
    World,
};
use nalgebra::{Isometry3, Translation3, Vector3};

use super::rotation::{euler, unit_quaternion};
use super::{Entity, RotationColumns};
use crate::table::Rows;

/// From the source's unit to metres. Decimal units divide, so that 110.763 mm becomes the number
/// nearest to 0.110763 m, which a product with 0.001 misses.
#[derive(Clone, Copy)]
pub(super) struct Scale {
    factor: f64,
    divisor: f64,
}

impl Scale {
    pub(super) fn of(unit: LengthUnit) -> Self {
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

pub(super) enum Tracked {
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
pub(super) struct Series {
    pub(super) track: Tracked,
    slots: Slots,
    partial: Occurrences,
    no_rotation: Occurrences,
    at_origin: Occurrences,
}

impl Series {
    pub(super) fn new(entity: Entity, capacity: usize, zero_is_missing: bool) -> Self {
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

    /// Appends samples that the file leaves out.
    pub(super) fn push_missing(&mut self, samples: usize) {
        let nothing = || std::iter::repeat_n(f64::NAN, samples);
        match &mut self.track {
            Tracked::Marker(marker) => {
                for _ in 0..samples {
                    marker.track.push(None, Status::Missing);
                }
                marker.quality.iter_mut().for_each(|q| q.extend(nothing()));
            }
            Tracked::Body(body) => {
                for _ in 0..samples {
                    body.track.push(None, Status::Missing);
                }
                (body.marker_error_m.iter_mut()).for_each(|e| e.extend(nothing()));
            }
        }
    }

    /// Appends some rows, of `width` values each.
    pub(super) fn push(&mut self, rows: &Rows, range: Range<usize>, width: usize, scale: Scale) {
        for k in range {
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
                    marker.track.push(sample, Status::Measured);
                    if let (Some(series), Some(slot)) = (&mut marker.quality, quality) {
                        series.push(values[slot]);
                    }
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
                    body.track.push(sample, Status::Measured);
                    if let (Some(series), Some(slot)) = (&mut body.marker_error_m, marker_error) {
                        series.push(scale.metres(values[slot]));
                    }
                }
                // `Series::new` makes both of the same kind.
                _ => {}
            }
        }
    }

    /// The samples so far; the series goes on behind them.
    pub(super) fn take(&mut self) -> Tracked {
        let emptied = |series: &mut Option<Vec<f64>>| {
            let room = series
                .as_ref()
                .map(|values| Vec::with_capacity(values.len()));
            std::mem::replace(series, room)
        };
        match &mut self.track {
            Tracked::Marker(marker) => {
                let room = PointTrack::with_capacity(marker.track.len());
                Tracked::Marker(Marker {
                    name: marker.name.clone(),
                    id: marker.id.clone(),
                    kind: marker.kind,
                    track: std::mem::replace(&mut marker.track, room),
                    quality: emptied(&mut marker.quality),
                })
            }
            Tracked::Body(body) => {
                let room = PoseTrack::with_capacity(body.track.len());
                Tracked::Body(TrackedBody {
                    name: body.name.clone(),
                    id: body.id.clone(),
                    kind: body.kind,
                    track: std::mem::replace(&mut body.track, room),
                    marker_error_m: emptied(&mut body.marker_error_m),
                })
            }
        }
    }

    pub(super) fn findings(&self) -> impl Iterator<Item = Finding> + use<> {
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
