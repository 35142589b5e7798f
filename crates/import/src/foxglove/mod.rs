//! Messages of package `foxglove`, in protobuf or JSON.

mod cloud;
mod json;

use ::foxglove::messages::{
    FrameTransform, FrameTransforms, Pose, PoseInFrame, PosesInFrame, Quaternion, Timestamp,
    Vector3,
};
use prost::Message;

use crate::reading::{
    CLOUDS, Fault, Item, Kind, Label, MessageKind, POSES, Reading, Readings, Stored, TRANSFORMS,
    limited, nanos,
};

const PROTOBUF: &[&str] = &["protobuf"];
const JSON: &[&str] = &["json"];

const POSE: &[&str] = &["foxglove.PoseInFrame"];
const POSES_IN_FRAME: &[&str] = &["foxglove.PosesInFrame"];
const TRANSFORM: &[&str] = &["foxglove.FrameTransform"];
const TRANSFORM_LIST: &[&str] = &["foxglove.FrameTransforms"];
const CLOUD: &[&str] = &["foxglove.PointCloud"];

pub(super) const KINDS: &[MessageKind] = &[
    MessageKind::new(PROTOBUF, POSE, POSES, |m| pose(decode(m)?)),
    MessageKind::new(JSON, POSE, POSES, |m| {
        pose(json::decode(m.bytes, json::pose_in_frame)?)
    }),
    MessageKind::new(PROTOBUF, POSES_IN_FRAME, POSES, |m| poses(decode(m)?)),
    MessageKind::new(JSON, POSES_IN_FRAME, POSES, |m| {
        poses(json::decode(m.bytes, json::poses_in_frame)?)
    }),
    MessageKind::new(PROTOBUF, TRANSFORM, TRANSFORMS, |m| {
        Ok(vec![transform(decode(m)?)])
    }),
    MessageKind::new(JSON, TRANSFORM, TRANSFORMS, |m| {
        Ok(vec![transform(json::decode(
            m.bytes,
            json::frame_transform,
        )?)])
    }),
    MessageKind::new(PROTOBUF, TRANSFORM_LIST, TRANSFORMS, |m| {
        transforms(decode(m)?)
    }),
    MessageKind::new(JSON, TRANSFORM_LIST, TRANSFORMS, |m| {
        transforms(json::decode(m.bytes, json::frame_transforms)?)
    }),
    MessageKind::new(PROTOBUF, CLOUD, CLOUDS, |m| cloud::points(&decode(m)?)),
    MessageKind::new(JSON, CLOUD, CLOUDS, |m| {
        cloud::points(&json::decode(m.bytes, json::point_cloud)?)
    }),
];

fn decode<M: Message + Default>(message: Stored<'_>) -> Result<M, Fault> {
    M::decode(message.bytes).map_err(|error| Fault::new("a protobuf message", error.to_string()))
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

pub(super) fn stamp(time: Option<Timestamp>) -> u64 {
    time.map_or(0, |time| nanos(time.sec().into(), time.nsec().into()))
}

pub(super) fn coordinates(vector: Option<Vector3>) -> [f64; 3] {
    vector.map_or([f64::NAN; 3], |v| [v.x, v.y, v.z])
}

pub(super) fn rotation(quaternion: Option<Quaternion>) -> [f64; 4] {
    quaternion.map_or([0.0; 4], |q| [q.x, q.y, q.z, q.w])
}
