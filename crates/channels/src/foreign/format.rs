//! Which messages can be read at all.

use super::reading::{Fault, Reading};
use super::ros::RosType;
use super::viewer::ViewerType;

/// Type and encoding of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    Ros(RosType),
    Protobuf(ViewerType),
    Json(ViewerType),
}

impl Format {
    /// The format of a channel, by the name of its schema and its encoding.
    pub(super) fn of(schema: &str, encoding: &str) -> Option<Self> {
        match encoding {
            "cdr" => RosType::of(schema).map(Format::Ros),
            "protobuf" => ViewerType::of(schema).map(Format::Protobuf),
            "json" => ViewerType::of(schema).map(Format::Json),
            _ => None,
        }
    }

    /// What a message says.
    pub(super) fn read(self, message: &[u8]) -> Result<Vec<Reading<'_>>, Fault> {
        match self {
            Format::Ros(ros) => ros.read(message),
            Format::Protobuf(viewer) => viewer.read_protobuf(message),
            Format::Json(viewer) => viewer.read_json(message),
        }
    }

    pub(super) fn is_cloud(self) -> bool {
        matches!(
            self,
            Format::Protobuf(ViewerType::Cloud) | Format::Json(ViewerType::Cloud)
        )
    }

    /// How much a topic of this kind says about a take, 0 most: messages made for motion capture,
    /// poses and points, clouds, and transforms, which robots send of all their parts.
    pub(super) fn rank(self) -> u8 {
        match self {
            Format::Ros(RosType::Markers | RosType::Bodies) => 0,
            Format::Ros(RosType::Pose | RosType::Point | RosType::Poses)
            | Format::Protobuf(ViewerType::Pose | ViewerType::Poses)
            | Format::Json(ViewerType::Pose | ViewerType::Poses) => 1,
            Format::Protobuf(ViewerType::Cloud) | Format::Json(ViewerType::Cloud) => 2,
            Format::Ros(RosType::Transform | RosType::Transforms)
            | Format::Protobuf(ViewerType::Transform | ViewerType::Transforms)
            | Format::Json(ViewerType::Transform | ViewerType::Transforms) => 3,
        }
    }
}
