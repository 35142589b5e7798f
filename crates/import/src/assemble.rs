//! Series with samples to markers and bodies.

use inhand_model::{
    BodyKind, Finding, LengthUnit, Marker, MarkerKind, PointTrack, Pose, PoseTrack, Position,
    TrackedBody, World,
};
use nalgebra::{Isometry3, Point3};

use crate::place::Placed;
use crate::reading::Kind;
use crate::series::{As, Gathered, Series};
use crate::topics::ImportSettings;
use crate::tree::{Link, isometry, links_above};

/// Markers and bodies of a take.
#[derive(Default)]
pub(crate) struct Entities {
    /// With the series that each comes from.
    pub(crate) markers: Vec<(usize, Marker)>,
    pub(crate) bodies: Vec<(usize, TrackedBody)>,
    pub(crate) findings: Vec<Finding>,
}

/// Markers and bodies from series and the samples that their messages belong to.
pub(crate) fn entities(
    gathered: &Gathered<'_>,
    used: &[usize],
    placed: &[Placed],
    samples: usize,
    settings: &ImportSettings,
) -> Entities {
    let unit = settings.length_unit.unwrap_or(LengthUnit::Metres);
    let mut entities = Entities::default();
    for (at, chain) in links_above(gathered, used).into_iter().enumerate() {
        let index = used[at];
        let series = &gathered.series[index];
        let place = place_of(gathered, series);
        let findings = &mut entities.findings;
        let (is_marker, is_body) = becomes(series, settings, &place, findings);
        if series.other_frames > 0 {
            let left_out = match series.kind {
                Kind::Transform => ": left those out",
                _ => "",
            };
            let message = format!(
                "its frame is \"{}\" at first and another one in {} messages{left_out}",
                series.frame, series.other_frames
            );
            findings.push(Finding::warning(place.clone(), message));
        }
        let chain = match chain {
            Some((links, _)) => links,
            None if series.kind == Kind::Transform => {
                let message = "its frames are in each other in a circle or too deep: left out";
                findings.push(Finding::warning(place, message));
                continue;
            }
            None => Vec::new(),
        };
        let placed = PlacedSeries {
            gathered,
            used,
            placed,
            at,
            chain,
            unit,
        };
        let (mut at_origin, mut no_rotation) = (0, 0);
        if is_body {
            let body = placed.body(samples, &mut at_origin, &mut no_rotation);
            entities.bodies.push((index, body));
        }
        if is_marker {
            // Counted once: both are missing at the same samples.
            at_origin = 0;
            let marker = placed.marker(samples, &mut at_origin);
            entities.markers.push((index, marker));
        }
        for (count, what) in [
            (at_origin, "it is exactly at the origin"),
            (no_rotation, "its quaternion is not of unit length"),
        ] {
            if count > 0 {
                let message = format!("{what} in {count} samples: taken as missing");
                let findings = &mut entities.findings;
                findings.push(Finding::warning(place.clone(), message));
            }
        }
    }
    entities
}

/// The topic and, where it carries several, the name of a series.
pub(crate) fn place_of(gathered: &Gathered<'_>, series: &Series) -> String {
    let topic = &gathered.topics[series.topic].name;
    if series.name == *topic {
        topic.clone()
    } else {
        format!("{topic}, \"{}\"", series.name)
    }
}

/// Whether a series becomes a marker, and whether a body: as the user says; else points become
/// markers, poses bodies. A pose that is never turned is a point, and one that is called like a
/// fingertip serves as both.
fn becomes(
    series: &Series,
    settings: &ImportSettings,
    place: &str,
    findings: &mut Vec<Finding>,
) -> (bool, bool) {
    const MARKER: (bool, bool) = (true, false);
    const BODY: (bool, bool) = (false, true);
    let is_point = matches!(series.kind, Kind::Marker | Kind::BodyMarker);
    match series.becomes {
        As::Marker => MARKER,
        As::Body if is_point => {
            let message = "set to be a body, but its messages hold positions alone: it is a marker";
            findings.push(Finding::warning(place, message));
            MARKER
        }
        As::Body => BODY,
        As::Suggested if is_point => MARKER,
        As::Suggested if never_turned(series) => {
            let message = "its rotation is none at all times, as where a driver sends a point as a \
                           pose: it is a marker";
            findings.push(Finding::info(place, message));
            MARKER
        }
        As::Suggested if (settings.is_point)(&series.name) => {
            let message =
                "a pose that is called like a fingertip: it is a marker as well as a body";
            findings.push(Finding::info(place, message));
            (true, true)
        }
        As::Suggested => BODY,
    }
}

/// Whether no pose has a rotation: all are zero or the identity. A transform may well be none.
fn never_turned(series: &Series) -> bool {
    let none = |q: &[f64; 4]| *q == [0.0; 4] || *q == [0.0, 0.0, 0.0, 1.0];
    series.kind != Kind::Transform && series.rotation.iter().all(none)
        || series.rotation.iter().all(|q| *q == [0.0; 4])
}

/// Whether a driver without a notion of missing means that it sees nothing: exactly the origin.
fn is_untracked(series: &Series, position: [f64; 3]) -> bool {
    series.kind != Kind::Transform && position == [0.0; 3]
}

/// A series with its place in the tree of frames.
struct PlacedSeries<'a> {
    gathered: &'a Gathered<'a>,
    used: &'a [usize],
    placed: &'a [Placed],
    /// Its place among those used.
    at: usize,
    /// The transforms between its frame and the world, next one first.
    chain: Vec<Link>,
    unit: LengthUnit,
}

impl PlacedSeries<'_> {
    fn series(&self) -> &Series {
        &self.gathered.series[self.used[self.at]]
    }

    fn marker(&self, samples: usize, at_origin: &mut usize) -> Marker {
        let series = self.series();
        let track = (0..samples).map(|k| {
            let (position, _) = self.sample(self.at, k)?;
            let seen = position.iter().all(|c| c.is_finite());
            if !seen || is_untracked(series, position) {
                *at_origin += usize::from(seen);
                return None;
            }
            let moved = match self.chain.is_empty() {
                true => position,
                false => (self.above(k)? * Point3::from(position)).coords.into(),
            };
            Some(Position::<World>::from(
                moved.map(|c| self.unit.to_metres(c)),
            ))
        });
        Marker {
            track: PointTrack::from_measured(track),
            name: series.name.clone(),
            id: series.id.clone(),
            kind: match series.kind {
                Kind::BodyMarker => MarkerKind::RigidBodyMarker,
                _ if series.has_name => MarkerKind::Labelled,
                _ => MarkerKind::Unlabelled,
            },
            quality: None,
        }
    }

    fn body(&self, samples: usize, at_origin: &mut usize, no_rotation: &mut usize) -> TrackedBody {
        let series = self.series();
        let track = (0..samples).map(|k| {
            let (position, rotation) = self.sample(self.at, k)?;
            if is_untracked(series, position) {
                *at_origin += 1;
                return None;
            }
            let pose = isometry(position, rotation);
            let seen = position.iter().all(|c| c.is_finite());
            *no_rotation += usize::from(seen && pose.is_none());
            let mut pose = match self.chain.is_empty() {
                true => pose?,
                false => self.above(k)? * pose?,
            };
            (pose.translation.vector).apply(|c| *c = self.unit.to_metres(*c));
            Some(Pose::new(pose))
        });
        TrackedBody {
            track: PoseTrack::from_measured(track),
            name: series.name.clone(),
            id: series.id.clone(),
            kind: BodyKind::RigidBody,
            marker_error_m: None,
        }
    }

    /// Position and rotation of a series in its frame at sample `k`.
    fn sample(&self, at: usize, k: usize) -> Option<([f64; 3], [f64; 4])> {
        let series = &self.gathered.series[self.used[at]];
        let found = self.placed[at].get(k)?;
        Some((series.position[found], series.rotation[found]))
    }

    /// The transform from its frame to the world at sample `k`.
    fn above(&self, k: usize) -> Option<Isometry3<f64>> {
        let mut above = Isometry3::identity();
        for link in &self.chain {
            let link = match *link {
                Link::Fixed(pose) => pose,
                Link::Moving(at) => {
                    let (position, rotation) = self.sample(at, k)?;
                    isometry(position, rotation)?
                }
            };
            above = link * above;
        }
        Some(above)
    }
}
