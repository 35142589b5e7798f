//! The tree of frames.

use foxglove::messages::{FrameTransform, FrameTransforms, Quaternion, Vector3};
use inhand_model::{
    BodySource, Frame, Hand, Motion, Object, Pose, PoseTrack, Recording, Roles, World,
};
use nalgebra::{Isometry3, UnitQuaternion};

use crate::error::ChannelError;
use crate::outline::Outline;
use crate::output::{ChannelId, Output};
use crate::take::TakeFile;
use crate::topic;
use crate::wire::viewer_time;
use crate::write::{Instant, Stream, Streams};

/// Root of every tree: z points up.
pub(crate) const UPRIGHT: &str = "upright";

/// Which frames a take's tree has beside `upright` and `world`.
pub(crate) struct Tree {
    pub(crate) hand: bool,
    pub(crate) object: bool,
}

/// One static edge, on its own topic: inside `/tf` it would be lost to a viewer that jumps.
pub(crate) fn write_static(
    child: &str,
    upright_from_child: UnitQuaternion<f64>,
    unix_nanos: u64,
    output: &mut Output,
) -> Result<(), ChannelError> {
    let isometry = Isometry3::from_parts(nalgebra::Translation3::identity(), upright_from_child);
    let message = FrameTransforms {
        transforms: vec![transform(UPRIGHT, child, isometry, unix_nanos)],
    };
    let channel = output.channel::<FrameTransforms>(topic::TF_STATIC, None)?;
    output.message(channel, 0, unix_nanos, &message)
}

pub(crate) fn add<'a>(
    file: &TakeFile<'a>,
    outline: &Outline,
    stride: usize,
    output: &mut Output,
    streams: &mut Streams<'a>,
) -> Result<Tree, ChannelError> {
    let recording = file.recording;
    let start = recording.clock.unix_nanos(0);
    let edges: Vec<Edge> = match file.motion {
        Some(motion) => motion_edges(motion),
        None => file
            .roles
            .map_or_else(Vec::new, |roles| role_edges(recording, roles)),
    };
    // A frame that no message would place must not be in the tree; the object hangs under the hand
    // only if the hand does.
    let edges: Vec<Edge> = (edges.into_iter())
        .filter(|edge| edge.is_shown(outline, stride))
        .collect();
    let recorded = file.motion.is_some()
        || file.roles.is_some()
        || !(recording.markers.is_empty() && recording.bodies.is_empty());
    if !recorded && !file.generated.is_empty() {
        // Planned motion alone: the hand is nowhere in the world, so the tree is the hand.
        write_static(Hand::NAME, UnitQuaternion::identity(), start, output)?;
        return Ok(Tree {
            hand: true,
            object: false,
        });
    }
    let upright_from_world = recording.source.up_axis.upright_from_world();
    let rotation = UnitQuaternion::from_rotation_matrix(&upright_from_world);
    write_static(World::NAME, rotation, start, output)?;
    let has = |child| edges.iter().any(|edge| edge.child == child);
    let tree = Tree {
        hand: has(Hand::NAME),
        object: has(Object::NAME),
    };
    if !edges.is_empty() {
        streams.push(Box::new(Transforms {
            channel: output.channel::<FrameTransforms>(topic::TF, None)?,
            stride,
            edges,
        }));
    }
    Ok(tree)
}

fn motion_edges(motion: &Motion) -> Vec<Edge<'_>> {
    let hand = Edge {
        parent: World::NAME,
        child: Hand::NAME,
        pose: PoseSource::Hand(&motion.hand),
    };
    let object = motion.object.as_ref().map(|track| Edge {
        parent: Hand::NAME,
        child: Object::NAME,
        // Where the hand is not placed, neither is what hangs under it.
        pose: PoseSource::Object(track, &motion.hand),
    });
    [hand].into_iter().chain(object).collect()
}

/// Before processing, hand and object are where their rigid bodies are.
fn role_edges<'a>(recording: &Recording, roles: &Roles) -> Vec<Edge<'a>> {
    let body = |source: &BodySource| match source {
        BodySource::RigidBody(name) => {
            (recording.bodies.iter()).position(|body| body.name == *name)
        }
        BodySource::Markers(_) => None,
    };
    let hand = body(&roles.hand).map(|body| (Hand::NAME, body));
    let object = (roles.object.as_ref().and_then(body)).map(|body| (Object::NAME, body));
    (hand.into_iter().chain(object))
        .map(|(child, body)| Edge {
            parent: World::NAME,
            child,
            pose: PoseSource::Body(body),
        })
        .collect()
}

enum PoseSource<'a> {
    Hand(&'a PoseTrack<World, Hand>),
    Object(&'a PoseTrack<Hand, Object>, &'a PoseTrack<World, Hand>),
    /// Which of the take's bodies.
    Body(usize),
}

struct Edge<'a> {
    parent: &'static str,
    child: &'static str,
    pose: PoseSource<'a>,
}

impl Edge<'_> {
    /// The pose of the child seen from the parent.
    fn at(&self, at: &Instant<'_>) -> Option<Isometry3<f64>> {
        match self.pose {
            PoseSource::Body(n) => at
                .block
                .bodies
                .get(n)?
                .track
                .get(at.row)
                .map(Pose::isometry),
            _ => self.of_motion(at.k),
        }
    }

    /// The pose at sample `k`, where it is one of the motion's.
    fn of_motion(&self, k: usize) -> Option<Isometry3<f64>> {
        match self.pose {
            PoseSource::Hand(track) => track.get(k).map(Pose::isometry),
            PoseSource::Object(track, hand) => {
                let pose = track.get(k).map(Pose::isometry);
                pose.filter(|_| hand.status(k).is_present())
            }
            PoseSource::Body(_) => None,
        }
    }

    /// Whether any sample that views show has the pose.
    fn is_shown(&self, outline: &Outline, stride: usize) -> bool {
        match self.pose {
            PoseSource::Body(n) => outline.shown_bodies.get(n).is_some_and(|&shown| shown),
            _ => {
                let mut samples = (0..outline.samples).step_by(stride);
                samples.any(|k| self.of_motion(k).is_some())
            }
        }
    }
}

struct Transforms<'a> {
    channel: ChannelId,
    stride: usize,
    edges: Vec<Edge<'a>>,
}

impl Stream for Transforms<'_> {
    fn sample(&mut self, at: &Instant<'_>, output: &mut Output) -> Result<(), ChannelError> {
        let &Instant { k, unix_nanos, .. } = at;
        if !k.is_multiple_of(self.stride) {
            return Ok(());
        }
        let transforms: Vec<_> = (self.edges.iter())
            .filter_map(|edge| Some(transform(edge.parent, edge.child, edge.at(at)?, unix_nanos)))
            .collect();
        if transforms.is_empty() {
            return Ok(());
        }
        output.message(self.channel, k, unix_nanos, &FrameTransforms { transforms })
    }
}

/// The pose of `child` seen from `parent`: takes coordinates in the child to the parent.
pub(crate) fn transform(
    parent: &str,
    child: &str,
    parent_from_child: Isometry3<f64>,
    unix_nanos: u64,
) -> FrameTransform {
    let [x, y, z]: [f64; 3] = parent_from_child.translation.vector.into();
    let [qx, qy, qz, qw]: [f64; 4] = parent_from_child.rotation.coords.into();
    FrameTransform {
        timestamp: Some(viewer_time(unix_nanos)),
        parent_frame_id: parent.to_owned(),
        child_frame_id: child.to_owned(),
        translation: Some(Vector3 { x, y, z }),
        rotation: Some(Quaternion {
            x: qx,
            y: qy,
            z: qz,
            w: qw,
        }),
    }
}
