//! A take as it was measured.

use std::collections::BTreeMap;
use std::fmt;
use std::ops::Range;

use nalgebra::{Rotation3, Vector3};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::annotations::Annotations;
use crate::clock::Clock;
use crate::finding::Finding;
use crate::frame::{Body, World};
use crate::names::named;
use crate::track::{PointTrack, PoseTrack};

named! {
    /// Unit of length of a source file.
    #[derive(Serialize, Deserialize)]
    #[serde(rename_all = "lowercase")]
    pub enum LengthUnit {
        /// Metres.
        Metres = "metres",
        /// Centimetres.
        Centimetres = "centimetres",
        /// Millimetres.
        Millimetres = "millimetres",
        /// Inches.
        Inches = "inches",
        /// Feet.
        Feet = "feet",
    }
}

impl LengthUnit {
    /// Metres in one such unit.
    pub const fn metres(self) -> f64 {
        match self {
            LengthUnit::Metres => 1.0,
            LengthUnit::Centimetres => 0.01,
            LengthUnit::Millimetres => 0.001,
            LengthUnit::Inches => 0.0254,
            LengthUnit::Feet => 0.3048,
        }
    }

    /// A length in this unit in metres. Decimal units divide, so that 110.763 mm becomes the number
    /// nearest to 0.110763 m, which a product with 0.001 misses.
    #[inline]
    pub fn to_metres(self, length: f64) -> f64 {
        match self {
            LengthUnit::Centimetres => length / 100.0,
            LengthUnit::Millimetres => length / 1000.0,
            unit => length * unit.metres(),
        }
    }
}

named! {
    /// Axis of the source's world that points up.
    #[derive(Serialize, Deserialize)]
    #[serde(rename_all = "lowercase")]
    pub enum UpAxis {
        /// Y points up, as Motive exports by default.
        Y = "y",
        /// Z points up.
        Z = "z",
    }
}

impl UpAxis {
    /// The proper rotation that stands the source's world upright, z up: for [`UpAxis::Y`] a
    /// quarter turn about x, so that (0, 1, 0) becomes (0, 0, 1).
    pub fn upright_from_world(self) -> Rotation3<f64> {
        match self {
            UpAxis::Y => {
                Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::FRAC_PI_2)
            }
            UpAxis::Z => Rotation3::identity(),
        }
    }
}

/// How a source writes rotations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum RotationOrder {
    /// Quaternions.
    Quaternion,
    /// Intrinsic Euler angles in degrees, about these axes (0 = x) one after the other.
    Euler([u8; 3]),
}

impl fmt::Display for RotationOrder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            RotationOrder::Quaternion => f.write_str("quaternion"),
            RotationOrder::Euler(axes) => axes
                .iter()
                .try_for_each(|&axis| f.write_str(["X", "Y", "Z"][usize::from(axis)])),
        }
    }
}

impl From<RotationOrder> for String {
    fn from(order: RotationOrder) -> Self {
        order.to_string()
    }
}

impl TryFrom<String> for RotationOrder {
    type Error = &'static str;

    fn try_from(text: String) -> Result<Self, Self::Error> {
        if text == RotationOrder::Quaternion.to_string() {
            return Ok(RotationOrder::Quaternion);
        }
        let axes: Option<Vec<u8>> = (text.chars())
            .map(|axis| "XYZ".find(axis).map(|index| index as u8))
            .collect();
        (axes
            .and_then(|axes| axes.try_into().ok())
            .map(RotationOrder::Euler))
        .ok_or("expected quaternion or an axis order such as XYZ")
    }
}

/// Where a recording comes from and how the source wrote it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Source {
    /// Format and version, such as `Motive CSV 1.23`.
    pub format: String,
    /// Unit of length in the source; inside, everything is metres.
    pub length_unit: LengthUnit,
    /// Which axis points up, as stated or assumed.
    pub up_axis: UpAxis,
    /// How the source writes rotations; `None` where it has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotation: Option<RotationOrder>,
    /// Every other fact of the source's header, verbatim.
    pub header: BTreeMap<String, String>,
}

named! {
    /// What kind of marker it is.
    #[derive(Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum MarkerKind {
        /// A marker with a name of its own.
        Labelled = "labelled",
        /// A marker of a rigid body, as the body's fit places it.
        RigidBodyMarker = "rigid_body_marker",
        /// A marker that the capture software could not name.
        Unlabelled = "unlabelled",
    }
}

/// A marker over a take.
#[derive(Clone, Debug)]
pub struct Marker {
    /// Name in the source; not always unique.
    pub name: String,
    /// Identifier in the source, empty where it has none.
    pub id: String,
    /// What kind of marker it is.
    pub kind: MarkerKind,
    /// Where it was.
    pub track: PointTrack<World>,
    /// The source's quality of each sample (Motive `Marker Quality`, 0 to 1), NaN where missing.
    pub quality: Option<Vec<f64>>,
}

named! {
    /// What kind of body it is.
    #[derive(Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum BodyKind {
        /// A rigid body.
        RigidBody = "rigid_body",
        /// A bone of a skeleton.
        Bone = "bone",
    }
}

/// A rigid body or bone over a take.
#[derive(Clone, Debug)]
pub struct TrackedBody {
    /// Name in the source.
    pub name: String,
    /// Identifier in the source, empty where it has none.
    pub id: String,
    /// What kind of body it is.
    pub kind: BodyKind,
    /// Its pose.
    pub track: PoseTrack<World, Body>,
    /// Mean distance between the body's markers and their place in the fit, metres, NaN where
    /// missing.
    pub marker_error_m: Option<Vec<f64>>,
}

/// A take as it was measured: every marker and body at every sample.
#[derive(Clone, Debug)]
pub struct Recording {
    /// The take's name.
    pub name: String,
    /// When its samples were taken.
    pub clock: Clock,
    /// Where it comes from.
    pub source: Source,
    /// Markers, in the source's order.
    pub markers: Vec<Marker>,
    /// Bodies, in the source's order.
    pub bodies: Vec<TrackedBody>,
    /// What was odd about the source.
    pub findings: Vec<Finding>,
    /// Events that a vendor file states; those of MCAP files are beside their recording.
    pub annotations: Annotations,
    samples: usize,
}

/// A track that is longer or shorter than its take.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{entity} has {found} samples: expected {expected}, as the take has")]
pub struct RecordingError {
    /// Which marker or body, and which of its series.
    pub entity: String,
    /// Samples of the take.
    pub expected: usize,
    /// Samples of the track.
    pub found: usize,
}

impl Recording {
    /// A recording of nothing, for motion that was never recorded: metres, z up.
    pub fn empty(name: &str, format: &str, clock: Clock, samples: usize) -> Self {
        let source = Source {
            format: format.to_owned(),
            length_unit: LengthUnit::Metres,
            up_axis: UpAxis::Z,
            rotation: None,
            header: BTreeMap::new(),
        };
        Self::new(
            name.to_owned(),
            clock,
            source,
            samples,
            Vec::new(),
            Vec::new(),
        )
        .expect("nothing has no other length")
    }

    /// A recording of `samples` samples.
    ///
    /// # Errors
    ///
    /// [`RecordingError`] where a track or quality series has another length.
    pub fn new(
        name: String,
        clock: Clock,
        source: Source,
        samples: usize,
        markers: Vec<Marker>,
        bodies: Vec<TrackedBody>,
    ) -> Result<Self, RecordingError> {
        let check = |what: &str, name: &str, found: usize| match found == samples {
            true => Ok(()),
            false => Err(RecordingError {
                entity: format!("{what} \"{name}\""),
                expected: samples,
                found,
            }),
        };
        let series = |numbers: &Option<Vec<f64>>| numbers.as_ref().map_or(samples, Vec::len);
        for marker in &markers {
            check("marker", &marker.name, marker.track.len())?;
            check("quality of marker", &marker.name, series(&marker.quality))?;
        }
        for body in &bodies {
            check("body", &body.name, body.track.len())?;
            check(
                "marker error of body",
                &body.name,
                series(&body.marker_error_m),
            )?;
        }
        Ok(Self {
            name,
            clock,
            source,
            markers,
            bodies,
            findings: Vec::new(),
            annotations: Annotations::default(),
            samples,
        })
    }

    /// Samples in the take.
    pub const fn len(&self) -> usize {
        self.samples
    }

    /// Whether the take has no sample.
    pub const fn is_empty(&self) -> bool {
        self.samples == 0
    }

    /// The first labelled marker of that name, else the first of any kind.
    pub fn marker(&self, name: &str) -> Option<&Marker> {
        self.marker_index(name).map(|index| &self.markers[index])
    }

    /// Place of [`Recording::marker`] among the markers.
    pub fn marker_index(&self, name: &str) -> Option<usize> {
        let named = |marker: &Marker| marker.name == name;
        let labelled = |marker: &Marker| named(marker) && marker.kind == MarkerKind::Labelled;
        let markers = &self.markers;
        (markers.iter().position(labelled)).or_else(|| markers.iter().position(named))
    }

    /// The first body of that name.
    pub fn body(&self, name: &str) -> Option<&TrackedBody> {
        self.bodies.iter().find(|b| b.name == name)
    }
}

impl Recording {
    /// The samples `range` as a take of its own, which starts when its first sample was taken.
    /// A range that goes past the end is cut there.
    #[must_use]
    pub fn slice(&self, range: Range<usize>) -> Recording {
        let end = range.end.min(self.samples);
        let range = range.start.min(end)..end;
        self.with_samples(
            self.clock.starting_at(range.start),
            range.len(),
            |points| points.slice(range.clone()),
            |poses| poses.slice(range.clone()),
            |numbers| numbers[range.clone()].to_vec(),
        )
    }

    /// The recording with other samples: `points`, `poses` and `numbers` make those of tracks, qualities
    /// and marker errors.
    ///
    /// # Panics
    ///
    /// If they make another number of samples.
    #[must_use]
    pub fn with_samples(
        &self,
        clock: Clock,
        samples: usize,
        points: impl Fn(&PointTrack<World>) -> PointTrack<World>,
        poses: impl Fn(&PoseTrack<World, Body>) -> PoseTrack<World, Body>,
        numbers: impl Fn(&[f64]) -> Vec<f64>,
    ) -> Recording {
        let series = |values: &Option<Vec<f64>>| values.as_ref().map(|values| numbers(values));
        let markers = self.markers.iter().map(|marker| Marker {
            name: marker.name.clone(),
            id: marker.id.clone(),
            kind: marker.kind,
            track: points(&marker.track),
            quality: series(&marker.quality),
        });
        let bodies = self.bodies.iter().map(|body| TrackedBody {
            name: body.name.clone(),
            id: body.id.clone(),
            kind: body.kind,
            track: poses(&body.track),
            marker_error_m: series(&body.marker_error_m),
        });
        let (name, source) = (self.name.clone(), self.source.clone());
        let made = Self::new(
            name,
            clock,
            source,
            samples,
            markers.collect(),
            bodies.collect(),
        );
        let mut made = made.expect("every track and series has `samples` samples");
        made.findings.clone_from(&self.findings);
        made.annotations.clone_from(&self.annotations);
        made
    }
}
