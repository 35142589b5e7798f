//! Series with samples to markers and bodies.

use inhand_model::{
    BodyKind, Finding, LengthUnit, Marker, MarkerKind, PointTrack, Pose, PoseTrack, Position,
    Status, TrackedBody, World,
};
use nalgebra::Isometry3;

use crate::gather::{As, Gathered, Series};
use crate::place::Placed;
use crate::reading::Kind;
use crate::topics::ImportSettings;
use crate::tree::{Link, isometry, links_above};

/// What a series becomes.
#[derive(Default)]
struct Becomes {
    marker: bool,
    body: bool,
}

/// Markers and bodies of a take.
#[derive(Default)]
pub(crate) struct Entities {
    /// With the series that each comes from.
    pub(crate) markers: Vec<(usize, Marker)>,
    pub(crate) bodies: Vec<(usize, TrackedBody)>,
    pub(crate) findings: Vec<Finding>,
}

/// Why samples of a series are missing though there is a message.
#[derive(Default)]
struct Unusable {
    at_origin: usize,
    no_rotation: usize,
}

/// Markers and bodies from series and the samples that their messages belong to.
pub(crate) fn entities(
    gathered: &Gathered<'_>,
    used: &[usize],
    placed: &[Placed],
    samples: usize,
    settings: &ImportSettings,
) -> Entities {
    let scale = Scale::of(settings.length_unit.unwrap_or(LengthUnit::Metres));
    let chains = links_above(gathered, used);
    let mut entities = Entities::default();
    for (at, &index) in used.iter().enumerate() {
        let series = &gathered.series[index];
        let place = place_of(gathered, series);
        let becomes = becomes(series, settings, &place, &mut entities.findings);
        if series.other_frames > 0 {
            entities.findings.push(Finding::warning(
                place.clone(),
                format!(
                    "its frame is \"{}\" at first and another one in {} messages{}",
                    series.frame,
                    series.other_frames,
                    if series.kind == Kind::Transform {
                        ": left those out"
                    } else {
                        ""
                    }
                ),
            ));
        }
        let chain: &[Link] = match &chains[at] {
            Some((links, _)) => links,
            None if series.kind == Kind::Transform => {
                entities.findings.push(Finding::warning(
                    place,
                    "its frames stand in each other in a circle or too deep: left out",
                ));
                continue;
            }
            None => &[],
        };
        let mut unusable = Unusable::default();
        if becomes.marker {
            let track = (0..samples).map(|k| {
                let above = above(gathered, used, placed, chain, k)?;
                let position = series.position[placed[at].get(k)?];
                let seen = position.iter().all(|c| c.is_finite());
                if !seen || is_untracked(series, position) {
                    unusable.at_origin += usize::from(seen && !becomes.body);
                    return None;
                }
                let moved = if chain.is_empty() {
                    position
                } else {
                    (above * nalgebra::Point3::from(position)).coords.into()
                };
                Some(Position::<World>::from(scale.metres(moved)))
            });
            let marker = Marker {
                track: PointTrack::from_measured(track),
                ..marker(series)
            };
            entities.markers.push((index, marker));
        }
        if becomes.body {
            let mut track = PoseTrack::with_capacity(samples);
            for k in 0..samples {
                let found = placed[at]
                    .get(k)
                    .map(|s| (series.position[s], series.rotation[s]));
                let pose = found.and_then(|(position, rotation)| {
                    if is_untracked(series, position) {
                        unusable.at_origin += 1;
                        return None;
                    }
                    let pose = isometry(position, rotation);
                    let no_rotation = pose.is_none() && position.iter().all(|c| c.is_finite());
                    unusable.no_rotation += usize::from(no_rotation);
                    if chain.is_empty() {
                        return pose;
                    }
                    Some(above(gathered, used, placed, chain, k)? * pose?)
                });
                let pose = pose.map(|pose| Pose::new(scale.isometry(pose)));
                track.push(pose, Status::Measured);
            }
            let body = TrackedBody {
                name: series.name.clone(),
                id: series.id.clone(),
                kind: BodyKind::RigidBody,
                track,
                marker_error_m: None,
            };
            entities.bodies.push((index, body));
        }
        entities
            .findings
            .extend(unusable.findings(&place_of(gathered, series)));
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

fn marker(series: &Series) -> Marker {
    Marker {
        name: series.name.clone(),
        id: series.id.clone(),
        kind: match series.kind {
            Kind::BodyMarker => MarkerKind::RigidBodyMarker,
            _ if series.has_name => MarkerKind::Labelled,
            _ => MarkerKind::Unlabelled,
        },
        track: PointTrack::missing(0),
        quality: None,
    }
}

/// As the user says; else points become markers, poses bodies. A pose that is never turned is a
/// point, and one that is called like a fingertip serves as both.
fn becomes(
    series: &Series,
    settings: &ImportSettings,
    place: &str,
    findings: &mut Vec<Finding>,
) -> Becomes {
    let is_point = matches!(series.kind, Kind::Marker | Kind::BodyMarker);
    let marker = Becomes {
        marker: true,
        body: false,
    };
    let body = Becomes {
        marker: false,
        body: true,
    };
    match series.becomes {
        As::Marker => marker,
        As::Body if is_point => {
            let message = "set to be a body, but its messages hold positions alone: it is a marker";
            findings.push(Finding::warning(place, message));
            marker
        }
        As::Body => body,
        As::Suggested if is_point => marker,
        As::Suggested if never_turned(series) => {
            findings.push(Finding::info(
                place,
                "its rotation is none at all times, as where a driver sends a point as a pose: it \
                 is a marker",
            ));
            marker
        }
        As::Suggested if (settings.is_point)(&series.name) => {
            findings.push(Finding::info(
                place,
                "a pose that is called like a fingertip: it is a marker as well as a body",
            ));
            Becomes {
                marker: true,
                body: true,
            }
        }
        As::Suggested => body,
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

/// What lies between a transform's frame and the world at sample `k`.
fn above(
    gathered: &Gathered<'_>,
    used: &[usize],
    placed: &[Placed],
    chain: &[Link],
    k: usize,
) -> Option<Isometry3<f64>> {
    let mut above = Isometry3::identity();
    for link in chain {
        let link = match *link {
            Link::Fixed(pose) => pose,
            Link::Moving(at) => {
                let series = &gathered.series[used[at]];
                let found = placed[at].get(k)?;
                isometry(series.position[found], series.rotation[found])?
            }
        };
        above = link * above;
    }
    Some(above)
}

impl Unusable {
    fn findings(&self, place: &str) -> Vec<Finding> {
        let counted = [
            (self.at_origin, "it is exactly at the origin"),
            (self.no_rotation, "its quaternion is not of unit length"),
        ];
        (counted.into_iter().filter(|(count, _)| *count > 0))
            .map(|(count, what)| {
                let message = format!("{what} in {count} samples: taken as missing");
                Finding::warning(place, message)
            })
            .collect()
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

    fn metres(self, coordinates: [f64; 3]) -> [f64; 3] {
        coordinates.map(|c| c * self.factor / self.divisor)
    }

    fn isometry(self, mut pose: Isometry3<f64>) -> Isometry3<f64> {
        let metres = |c: f64| c * self.factor / self.divisor;
        pose.translation.vector.apply(|c| *c = metres(*c));
        pose
    }
}
