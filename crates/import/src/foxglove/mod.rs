//! Messages of package `foxglove`, in protobuf or JSON.

mod cloud;
mod json;

use ::foxglove::messages::{
    FrameTransform, FrameTransforms, Pose, PoseInFrame, PosesInFrame, Quaternion, Timestamp,
    Vector3,
};
use prost::Message;

use crate::reading::{
    CLOUDS, Fault, Item, Kind, Label, MAX_ITEMS, MessageKind, POSES, Reading, Readings, TRANSFORMS,
    nanos,
};

const POSE: &[&str] = &["foxglove.PoseInFrame"];
const POSES_IN_FRAME: &[&str] = &["foxglove.PosesInFrame"];
const TRANSFORM: &[&str] = &["foxglove.FrameTransform"];
const TRANSFORM_LIST: &[&str] = &["foxglove.FrameTransforms"];
const CLOUD: &[&str] = &["foxglove.PointCloud"];

pub(super) const KINDS: &[MessageKind] = &[
    protobuf(POSE, POSES, |m| pose(decode(m)?)),
    json(POSE, POSES, |m| pose(json::decode(m, json::pose_in_frame)?)),
    protobuf(POSES_IN_FRAME, POSES, |m| poses(decode(m)?)),
    json(POSES_IN_FRAME, POSES, |m| {
        poses(json::decode(m, json::poses_in_frame)?)
    }),
    protobuf(TRANSFORM, TRANSFORMS, |m| Ok(vec![transform(decode(m)?)])),
    json(TRANSFORM, TRANSFORMS, |m| {
        Ok(vec![transform(json::decode(m, json::frame_transform)?)])
    }),
    protobuf(TRANSFORM_LIST, TRANSFORMS, |m| transforms(decode(m)?)),
    json(TRANSFORM_LIST, TRANSFORMS, |m| {
        transforms(json::decode(m, json::frame_transforms)?)
    }),
    protobuf(CLOUD, CLOUDS, |m| cloud::points(&decode(m)?)),
    json(CLOUD, CLOUDS, |m| {
        cloud::points(&json::decode(m, json::point_cloud)?)
    }),
];

const fn protobuf(
    schemas: &'static [&'static str],
    rank: u8,
    read: for<'a> fn(&'a [u8]) -> Readings<'a>,
) -> MessageKind {
    MessageKind {
        schemas,
        encoding: "protobuf",
        rank,
        read,
    }
}

const fn json(
    schemas: &'static [&'static str],
    rank: u8,
    read: for<'a> fn(&'a [u8]) -> Readings<'a>,
) -> MessageKind {
    MessageKind {
        encoding: "json",
        ..protobuf(schemas, rank, read)
    }
}

fn decode<M: Message + Default>(message: &[u8]) -> Result<M, Fault> {
    M::decode(message).map_err(|error| Fault::new("a protobuf message", error.to_string()))
}

fn pose(message: PoseInFrame) -> Readings<'static> {
    Ok(vec![Reading {
        stamp_nanos: stamp(message.timestamp),
        frame: message.frame_id.into(),
        items: (message.pose.iter())
            .map(|pose| item(pose, Label::Topic))
            .collect(),
    }])
}

fn poses(message: PosesInFrame) -> Readings<'static> {
    limited(message.poses.len(), "poses")?;
    let items = (message.poses.iter().enumerate()).map(|(k, pose)| item(pose, Label::Place(k)));
    Ok(vec![Reading {
        stamp_nanos: stamp(message.timestamp),
        frame: message.frame_id.into(),
        items: items.collect(),
    }])
}

fn transforms(message: FrameTransforms) -> Readings<'static> {
    limited(message.transforms.len(), "transforms")?;
    Ok(message.transforms.into_iter().map(transform).collect())
}

fn transform(message: FrameTransform) -> Reading<'static> {
    let item = Item {
        label: Label::Name(message.child_frame_id.into(), None),
        kind: Kind::Transform,
        position: coordinates(message.translation),
        rotation: rotation(message.rotation),
    };
    Reading {
        stamp_nanos: stamp(message.timestamp),
        frame: message.parent_frame_id.into(),
        items: vec![item],
    }
}

fn item(pose: &Pose, label: Label<'static>) -> Item<'static> {
    Item {
        label,
        kind: Kind::Pose,
        position: coordinates(pose.position),
        rotation: rotation(pose.orientation),
    }
}

/// Refuses messages that hold more than motion capture has.
pub(super) fn limited(count: usize, what: &str) -> Result<(), Fault> {
    if count <= MAX_ITEMS {
        return Ok(());
    }
    Err(Fault::new(
        format!("at most {MAX_ITEMS} {what} in a message"),
        count.to_string(),
    ))
}

pub(super) fn stamp(time: Option<Timestamp>) -> u64 {
    time.map_or(0, |time| nanos(time.sec().into(), time.nsec().into()))
}

pub(super) fn coordinates(vector: Option<Vector3>) -> [f64; 3] {
    vector.map_or([f64::NAN; 3], |v| [v.x, v.y, v.z])
}

pub(super) fn rotation(quaternion: Option<Quaternion>) -> [f64; 4] {
    quaternion.map_or([0.0; 4], |q| [q.x, q.y, q.z, q.w])
}
