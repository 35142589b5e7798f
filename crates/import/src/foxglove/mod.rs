//! Messages of package `foxglove`, in protobuf or JSON.

mod cloud;
mod json;

use ::foxglove::messages::{
    FrameTransform, FrameTransforms, Pose, PoseInFrame, PosesInFrame, Quaternion, Timestamp,
    Vector3,
};
use prost::Message;
use serde_json::Value;

pub(crate) use self::json::parse as parse_json;
use crate::format::{CLOUDS, Decode, MessageKind, POSES, TRANSFORMS};
use crate::reading::{Fault, Item, Kind, Label, MAX_ITEMS, Reading, nanos};

pub(super) const KINDS: &[MessageKind] = &[
    protobuf(&["foxglove.PoseInFrame"], POSES, |m| pose(decode(m)?)),
    json(&["foxglove.PoseInFrame"], POSES, |m| {
        pose(json::pose_in_frame(m)?)
    }),
    protobuf(&["foxglove.PosesInFrame"], POSES, |m| poses(decode(m)?)),
    json(&["foxglove.PosesInFrame"], POSES, |m| {
        poses(json::poses_in_frame(m)?)
    }),
    protobuf(&["foxglove.FrameTransform"], TRANSFORMS, |m| {
        Ok(vec![transform(decode(m)?)])
    }),
    json(&["foxglove.FrameTransform"], TRANSFORMS, |m| {
        Ok(vec![transform(json::frame_transform(m)?)])
    }),
    protobuf(&["foxglove.FrameTransforms"], TRANSFORMS, |m| {
        transforms(decode(m)?)
    }),
    json(&["foxglove.FrameTransforms"], TRANSFORMS, |m| {
        transforms(json::frame_transforms(m)?)
    }),
    protobuf(&["foxglove.PointCloud"], CLOUDS, |m| {
        cloud::points(&decode(m)?)
    }),
    json(&["foxglove.PointCloud"], CLOUDS, |m| {
        cloud::points(&json::point_cloud(m)?)
    }),
];

const fn protobuf(
    schemas: &'static [&'static str],
    rank: u8,
    read: fn(&[u8]) -> Result<Vec<Reading<'static>>, Fault>,
) -> MessageKind {
    MessageKind {
        schemas,
        decode: Decode::Protobuf(read),
        rank,
    }
}

const fn json(
    schemas: &'static [&'static str],
    rank: u8,
    read: fn(&Value) -> Result<Vec<Reading<'static>>, Fault>,
) -> MessageKind {
    MessageKind {
        schemas,
        decode: Decode::Json(read),
        rank,
    }
}

fn decode<M: Message + Default>(message: &[u8]) -> Result<M, Fault> {
    M::decode(message).map_err(|error| Fault::new("a protobuf message", error.to_string()))
}

fn pose(message: PoseInFrame) -> Result<Vec<Reading<'static>>, Fault> {
    Ok(vec![Reading {
        stamp_nanos: stamp(message.timestamp),
        frame: message.frame_id.into(),
        items: (message.pose.iter())
            .map(|pose| item(pose, Label::Topic))
            .collect(),
    }])
}

fn poses(message: PosesInFrame) -> Result<Vec<Reading<'static>>, Fault> {
    limited(message.poses.len(), "poses")?;
    let items = (message.poses.iter().enumerate()).map(|(k, pose)| item(pose, Label::Place(k)));
    Ok(vec![Reading {
        stamp_nanos: stamp(message.timestamp),
        frame: message.frame_id.into(),
        items: items.collect(),
    }])
}

fn transforms(message: FrameTransforms) -> Result<Vec<Reading<'static>>, Fault> {
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
    let frame = message.parent_frame_id.into();
    Reading::one(stamp(message.timestamp), frame, item)
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
