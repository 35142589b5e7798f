//! Messages of package `foxglove`, in protobuf or JSON.

use foxglove::messages::{
    FrameTransform, FrameTransforms, Pose, PoseInFrame, PosesInFrame, Quaternion, Timestamp,
    Vector3,
};
use prost::Message;

use super::cloud;
use super::json;
use super::reading::{Fault, Item, Kind, Label, MAX_ITEMS, Reading, nanos};

/// Message types that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ViewerType {
    Pose,
    Poses,
    Transform,
    Transforms,
    Cloud,
}

impl ViewerType {
    /// The type of that schema name.
    pub(super) fn of(schema: &str) -> Option<Self> {
        Some(match schema {
            "foxglove.PoseInFrame" => ViewerType::Pose,
            "foxglove.PosesInFrame" => ViewerType::Poses,
            "foxglove.FrameTransform" => ViewerType::Transform,
            "foxglove.FrameTransforms" => ViewerType::Transforms,
            "foxglove.PointCloud" => ViewerType::Cloud,
            _ => return None,
        })
    }

    /// What a message in protobuf says.
    pub(super) fn read_protobuf(self, message: &[u8]) -> Result<Vec<Reading<'static>>, Fault> {
        match self {
            ViewerType::Pose => pose(decode(message)?),
            ViewerType::Poses => poses(decode(message)?),
            ViewerType::Transform => Ok(vec![transform(decode(message)?)]),
            ViewerType::Transforms => transforms(decode(message)?),
            ViewerType::Cloud => cloud::points(&decode(message)?),
        }
    }

    /// What a message in JSON says.
    pub(super) fn read_json(self, message: &[u8]) -> Result<Vec<Reading<'static>>, Fault> {
        let value = &json::parse(message)?;
        match self {
            ViewerType::Pose => pose(json::pose_in_frame(value)?),
            ViewerType::Poses => poses(json::poses_in_frame(value)?),
            ViewerType::Transform => Ok(vec![transform(json::frame_transform(value)?)]),
            ViewerType::Transforms => transforms(json::frame_transforms(value)?),
            ViewerType::Cloud => cloud::points(&json::point_cloud(value)?),
        }
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
