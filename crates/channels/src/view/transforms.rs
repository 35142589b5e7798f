//! The tree of frames.

use foxglove::messages::{FrameTransform, FrameTransforms, Quaternion, Vector3};
use inhand_model::{BodySource, Frame, Hand, Object, Pose, World, stored};
use nalgebra::{Isometry3, UnitQuaternion};

use crate::error::ChannelError;
use crate::streams::{Instant, Sampling, Streams};
use crate::take::Outline;
use crate::take::TakeFile;
use crate::topic;
use crate::view::draw::shown;
use crate::wire::viewer_time;

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
    streams: &mut Streams<'_>,
) -> Result<(), ChannelError> {
    let isometry = Isometry3::from_parts(nalgebra::Translation3::identity(), upright_from_child);
    let message = FrameTransforms {
        transforms: vec![transform(UPRIGHT, child, isometry, unix_nanos)],
    };
    streams.once(topic::TF_STATIC, None, unix_nanos, &message)
}

/// Parent, child, and the pose of the child seen from the parent.
pub(crate) type Edge<'a> = (
    &'static str,
    &'static str,
    Box<dyn Fn(&Instant<'_>) -> Option<Isometry3<f64>> + 'a>,
);

/// Adds a channel that places frames, where they are placed.
pub(crate) fn add_edges<'a>(
    edges: Vec<Edge<'a>>,
    sampling: Sampling,
    streams: &mut Streams<'a>,
) -> Result<(), ChannelError> {
    streams.sampled(topic::TF, None, sampling, move |at| {
        let transforms: Vec<_> = (edges.iter())
            .filter_map(|(parent, child, pose)| {
                Some(transform(parent, child, pose(at)?, at.unix_nanos))
            })
            .collect();
        (!transforms.is_empty()).then_some(FrameTransforms { transforms })
    })
}

/// Adds the tree of a take.
pub(crate) fn add<'a>(
    file: &TakeFile<'a>,
    outline: &Outline,
    sampling: Sampling,
    streams: &mut Streams<'a>,
) -> Result<Tree, ChannelError> {
    let recording = file.recording;
    let start = recording.clock.unix_nanos(0);
    let recorded = file.motion.is_some()
        || file.roles.is_some()
        || !(recording.markers.is_empty() && recording.bodies.is_empty());
    if !recorded && !file.generated.is_empty() {
        // Planned motion alone: the hand is nowhere in the world, so the tree is the hand.
        write_static(Hand::NAME, UnitQuaternion::identity(), start, streams)?;
        return Ok(Tree {
            hand: true,
            object: false,
        });
    }
    let upright_from_world = recording.source.up_axis.upright_from_world();
    let rotation = UnitQuaternion::from_rotation_matrix(&upright_from_world);
    write_static(World::NAME, rotation, start, streams)?;
    let edges = edges(file, outline, sampling);
    let has = |child| edges.iter().any(|edge| edge.1 == child);
    let tree = Tree {
        hand: has(Hand::NAME),
        object: has(Object::NAME),
    };
    if !edges.is_empty() {
        add_edges(edges, sampling, streams)?;
    }
    Ok(tree)
}

/// Frames that a sample of the views places: one that no message would place must not be in the tree.
fn edges<'a>(file: &TakeFile<'a>, outline: &Outline, sampling: Sampling) -> Vec<Edge<'a>> {
    let mut edges: Vec<Edge<'a>> = Vec::new();
    if let Some(motion) = file.motion {
        let hand = |k| motion.hand.get(k).map(Pose::isometry);
        // Where the hand is not placed, neither is what hangs under it.
        let object = move |k| {
            let pose = motion.object.as_ref()?.get(k)?;
            hand(k).map(|_| pose.isometry())
        };
        let mut samples = (0..sampling.samples).step_by(sampling.stride);
        if samples.clone().any(|k| hand(k).is_some()) {
            edges.push((World::NAME, Hand::NAME, Box::new(move |at| hand(at.k))));
        }
        if samples.any(|k| object(k).is_some()) {
            edges.push((Hand::NAME, Object::NAME, Box::new(move |at| object(at.k))));
        }
        return edges;
    }
    // Before processing, hand and object are where their rigid bodies are.
    let hand = file.roles.map(|roles| (Hand::NAME, &roles.hand));
    let object = file.roles.and_then(|roles| roles.object.as_ref());
    for (child, source) in (hand.into_iter()).chain(object.map(|object| (Object::NAME, object))) {
        let BodySource::RigidBody(name) = source else {
            continue;
        };
        let body = (file.recording.bodies.iter()).position(|body| body.name == *name);
        let Some(n) = body.filter(|&n| outline.shown_bodies.get(n) == Some(&true)) else {
            continue;
        };
        let pose = move |at: &Instant<'_>| {
            let (recording, row) = at.recorded(None)?;
            recording.bodies[n].track.get(row).map(Pose::isometry)
        };
        edges.push((World::NAME, child, Box::new(pose)));
    }
    edges
}

/// The pose of `child` seen from `parent`: takes coordinates in the child to the parent.
pub(crate) fn transform(
    parent: &str,
    child: &str,
    parent_from_child: Isometry3<f64>,
    unix_nanos: u64,
) -> FrameTransform {
    let [x, y, z] = <[f64; 3]>::from(parent_from_child.translation.vector).map(shown);
    let [qx, qy, qz, qw] = <[f64; 4]>::from(parent_from_child.rotation.coords).map(stored);
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
