//! Topics and messages of a take.

use std::collections::BTreeSet;
use std::io::Write;
use std::ops::Range;

use inhand_container::MetadataRecord;
use inhand_model::{BodySource, Clock, Finger, Pose, TrackedBody};
use nalgebra::{Isometry3, UnitQuaternion};

use super::bag::{BagWriter, Ros2Bag};
use super::cdr::Cdr;
use super::content::{Ros2Method, Ros2Take};
use super::scene::Scene;
use crate::error::ExportError;

/// Frame above `world` whose z points up.
const UPRIGHT: &str = "upright";
/// Frame of the hand where it is no rigid body.
const HAND: &str = "hand";
const WORLD: &str = "world";

/// Markers for viewers are written at most so many times a second.
const MARKERS_HZ: f64 = 50.0;

/// Writes a take as a bag, with these metadata records.
///
/// # Errors
///
/// [`ExportError::Container`] where writing fails.
pub fn write_ros2(
    out: &mut dyn Write,
    take: &Ros2Take<'_>,
    records: &[MetadataRecord],
) -> Result<Ros2Bag, ExportError> {
    let names = Names::new(take);
    let scene = Scene::new(take, (WORLD, Isometry3::identity()), &names.hand);
    let mut bag = BagWriter::new(out, records)?;
    write_static(&mut bag, take)?;
    let has_frames = !take.recording.bodies.is_empty() || take.motion.is_some();
    let tf = has_frames.then(|| bag.topic("/tf", "tf2_msgs/TFMessage"));
    let tf = tf.transpose()?;
    let mut topics = |names: &[String], leaf: &str, kind: &str| {
        let topic = |name: &String| bag.topic(&format!("/{name}/{leaf}"), kind);
        names.iter().map(topic).collect::<Result<Vec<_>, _>>()
    };
    let poses = topics(&names.bodies, "pose", "geometry_msgs/PoseStamped")?;
    let points = topics(&names.markers, "point", "geometry_msgs/PointStamped")?;
    let methods: Vec<_> = take.methods.iter().map(|m| token(m.name)).collect();
    let methods: Vec<_> = methods.iter().map(|m| format!("generated/{m}")).collect();
    let kind = "trajectory_msgs/MultiDOFJointTrajectory";
    let trajectories = topics(&methods, "trajectory", kind)?;
    let markers = (take.markers).then(|| bag.topic("/markers", "visualization_msgs/MarkerArray"));
    let markers = markers.transpose()?;
    let mut events = Events::new(&mut bag, take.events)?;
    let starts = take.starts();
    let (clock, stride) = (take.recording.clock, stride(take.recording.clock));
    for k in 0..take.recording.len() {
        let at = clock.unix_nanos(k);
        events.write_until(at, &mut bag)?;
        let frames = names.frames(take, k);
        if let Some(tf) = tf.filter(|_| !frames.is_empty()) {
            bag.message(tf, at, |cdr| transforms(cdr, at, &frames))?;
        }
        for (body, &topic) in take.recording.bodies.iter().zip(&poses) {
            if let Some(pose) = body.track.get(k) {
                let pose = pose.isometry();
                bag.message(topic, at, |cdr| {
                    cdr.header(at, WORLD).pose(&pose);
                })?;
            }
        }
        for (marker, &topic) in take.recording.markers.iter().zip(&points) {
            if let Some(position) = marker.track.get(k) {
                let position = position.to_array();
                bag.message(topic, at, |cdr| {
                    cdr.header(at, WORLD).f64s(position);
                })?;
            }
        }
        if let Some(markers) = markers.filter(|_| k.is_multiple_of(stride)) {
            bag.message(markers, at, |cdr| scene.write(cdr, k))?;
        }
        for (method, &topic) in take.methods.iter().zip(&trajectories) {
            if let Some(samples) = method.trajectory_from(k, &starts) {
                bag.message(topic, at, |cdr| {
                    trajectory(cdr.header(at, &names.hand), method, samples, clock);
                })?;
            }
        }
    }
    events.write_until(u64::MAX, &mut bag)?;
    bag.finish()
}

/// Writes a bag of a take's markers alone on this topic, in a frame that has this pose in the take's `world`.
///
/// # Errors
///
/// As [`write_ros2`].
pub fn write_ros2_markers(
    out: &mut dyn Write,
    take: &Ros2Take<'_>,
    topic: &str,
    (frame, world_from_frame): (&str, Isometry3<f64>),
) -> Result<(), ExportError> {
    let scene = Scene::new(take, (frame, world_from_frame.inverse()), HAND);
    let mut bag = BagWriter::new(out, &[])?;
    let topic = bag.topic(topic, "visualization_msgs/MarkerArray")?;
    let clock = take.recording.clock;
    for k in (0..take.recording.len()).step_by(stride(clock)) {
        bag.message(topic, clock.unix_nanos(k), |cdr| scene.write(cdr, k))?;
    }
    bag.finish().map(drop)
}

/// Every how many samples markers for viewers are written.
fn stride(clock: Clock) -> usize {
    // A tiny slack keeps 100.0001 Hz at two.
    ((clock.rate_hz() / MARKERS_HZ - 1e-3).ceil() as usize).max(1)
}

/// Places the frames that do not move.
fn write_static(bag: &mut BagWriter<'_>, take: &Ros2Take<'_>) -> Result<(), ExportError> {
    let up = take.recording.source.up_axis.upright_from_world();
    let up = UnitQuaternion::from_rotation_matrix(&up);
    let mut frames = vec![(
        UPRIGHT,
        WORLD,
        Isometry3::from_parts(Default::default(), up),
    )];
    if !take.is_recorded() && !take.methods.is_empty() {
        // Planned motion alone: the hand is nowhere in the world.
        frames.push((WORLD, HAND, Isometry3::identity()));
    }
    let at = take.recording.clock.unix_nanos(0);
    let topic = bag.topic("/tf_static", "tf2_msgs/TFMessage")?;
    bag.message(topic, at, |cdr| transforms(cdr, at, &frames))
}

/// A frame's parent, its name, and its pose in the parent.
type Placed<'a> = (&'a str, &'a str, Isometry3<f64>);

/// Writes a `tf2_msgs/TFMessage`.
fn transforms(cdr: &mut Cdr<'_>, unix_nanos: u64, frames: &[Placed<'_>]) {
    cdr.u32(frames.len());
    for (parent, child, pose) in frames {
        cdr.header(unix_nanos, parent).text(child).pose(pose);
    }
}

/// Writes the trajectory over these samples: fingers as joints without rotation.
fn trajectory(cdr: &mut Cdr<'_>, method: &Ros2Method<'_>, samples: Range<usize>, clock: Clock) {
    cdr.u32(Finger::ALL.len());
    for finger in Finger::ALL {
        cdr.text(finger.name());
    }
    cdr.u32(samples.len());
    for k in samples.clone() {
        let tips = method.positions_m[&k].as_chunks::<3>().0;
        cdr.u32(tips.len());
        for &tip in tips {
            cdr.pose(&Isometry3::translation(tip[0], tip[1], tip[2]));
        }
        // Central differences; of two samples at the ends.
        let before = k.saturating_sub(1).max(samples.start);
        let after = (k + 1).min(samples.end - 1);
        let seconds = clock.time_s(after - before).max(1.0 / clock.rate_hz());
        let [from_m, to_m] = [before, after].map(|k| &method.positions_m[&k]);
        let velocity_m_s: Vec<f64> = (to_m.iter().zip(from_m))
            .map(|(to, from)| (to - from) / seconds)
            .collect();
        cdr.u32(tips.len());
        for linear in velocity_m_s.as_chunks::<3>().0 {
            cdr.f64s(linear.iter().copied()).f64s([0.0; 3]);
        }
        cdr.u32(0); // No accelerations.
        cdr.time(clock.unix_nanos(k) - clock.unix_nanos(samples.start));
    }
}

/// Events that are still to be written.
struct Events<'a> {
    topic: Option<usize>,
    left: &'a [(u64, String)],
}

impl<'a> Events<'a> {
    fn new(bag: &mut BagWriter<'_>, events: &'a [(u64, String)]) -> Result<Self, ExportError> {
        let topic = (!events.is_empty()).then(|| bag.topic("/annotations", "std_msgs/String"));
        Ok(Self {
            topic: topic.transpose()?,
            left: events,
        })
    }

    /// Writes those that begin before or at this time.
    fn write_until(&mut self, unix_nanos: u64, bag: &mut BagWriter<'_>) -> Result<(), ExportError> {
        let due = self.left.partition_point(|(at, _)| *at <= unix_nanos);
        let (due, left) = self.left.split_at(due);
        self.left = left;
        for ((at, json), topic) in due.iter().zip(self.topic.iter().cycle()) {
            bag.message(*topic, *at, |cdr| {
                cdr.text(json);
            })?;
        }
        Ok(())
    }
}

/// Names of entities as ROS can have them in topics and frames.
struct Names {
    bodies: Vec<String>,
    markers: Vec<String>,
    /// Frame of the hand, and its body where it has one.
    hand: String,
    hand_body: Option<usize>,
}

impl Names {
    fn new(take: &Ros2Take<'_>) -> Self {
        let recording = take.recording;
        let hand_body = take.roles.and_then(|roles| match &roles.hand {
            BodySource::RigidBody(name) => recording.bodies.iter().position(|b| b.name == *name),
            BodySource::Markers(_) => None,
        });
        // A hand that is no body has a frame of its own.
        let fitted = hand_body.is_none() && (take.motion.is_some() || !take.methods.is_empty());
        let bodies = distinct(
            recording.bodies.iter().map(|body| body.name.as_str()),
            [WORLD, UPRIGHT].into_iter().chain(fitted.then_some(HAND)),
        );
        Self {
            hand: hand_body.map_or_else(|| HAND.to_owned(), |body| bodies[body].clone()),
            hand_body,
            markers: distinct(
                recording.markers.iter().map(|marker| marker.name.as_str()),
                [WORLD, UPRIGHT],
            ),
            bodies,
        }
    }

    /// Frames that are placed at sample `k`: bodies, the hand's as in the motion, gaps filled.
    fn frames<'a>(&'a self, take: &Ros2Take<'_>, k: usize) -> Vec<Placed<'a>> {
        let hand = take
            .motion
            .map(|motion| motion.hand.get(k).map(Pose::isometry));
        let body = |(n, body): (usize, &TrackedBody)| {
            let recorded = body.track.get(k).map(Pose::isometry);
            let pose = match self.hand_body == Some(n) {
                true => hand.unwrap_or(recorded),
                false => recorded,
            };
            Some((WORLD, self.bodies[n].as_str(), pose?))
        };
        let bodies = take.recording.bodies.iter().enumerate().filter_map(body);
        let fitted = hand.flatten().filter(|_| self.hand_body.is_none());
        bodies
            .chain(fitted.map(|pose| (WORLD, self.hand.as_str(), pose)))
            .collect()
    }
}

/// Names as ROS can have them, each once and none that is taken.
fn distinct<'a>(
    names: impl Iterator<Item = &'a str>,
    taken: impl IntoIterator<Item = &'a str>,
) -> Vec<String> {
    let mut used: BTreeSet<String> = taken.into_iter().map(str::to_owned).collect();
    let names = names.map(|name| {
        let name = token(name);
        let numbered = (2..).map(|n| format!("{name}_{n}"));
        let mut free = std::iter::once(name.clone()).chain(numbered);
        let free = free.find(|name| used.insert(name.clone()));
        free.unwrap_or(name)
    });
    names.collect()
}

/// A name as a part of a topic: letters, digits and single `_`, a letter first.
fn token(name: &str) -> String {
    let parts = name.split(|c: char| !c.is_ascii_alphanumeric());
    let token = parts
        .filter(|part| !part.is_empty())
        .collect::<Vec<_>>()
        .join("_");
    match token.chars().next() {
        Some(first) if first.is_ascii_alphabetic() => token,
        _ => format!("n{token}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_parts_of_topics_and_distinct() {
        let names = [
            "Hand:Marker 1",
            "hand_marker__1",
            "Hand_Marker_1",
            "1042",
            "手",
            "world",
        ];
        let expected = [
            "Hand_Marker_1",
            "hand_marker_1",
            "Hand_Marker_1_2",
            "n1042",
            "n",
            "world_2",
        ];
        assert_eq!(distinct(names.into_iter(), [WORLD]), expected);
        let taken = distinct(["hand", "hand_2", "hand"].into_iter(), [HAND]);
        assert_eq!(taken, ["hand_2", "hand_2_2", "hand_3"]);
    }
}
