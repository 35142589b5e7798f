//! Package `geometry_msgs`: poses and points with a header.

use super::{ROS, decode, header, limited, one, point, pose};
use crate::reading::{Kind, Label, MessageKind, POSES, Readings, Stored};

pub(super) const KINDS: &[MessageKind] = &[
    MessageKind::new(ROS, &["geometry_msgs/PoseStamped"], POSES, |message| {
        one(message, |cdr| pose(cdr, Label::Topic, Kind::Pose))
    }),
    MessageKind::new(ROS, &["geometry_msgs/PointStamped"], POSES, |message| {
        one(message, |cdr| point(cdr, Label::Topic, Kind::Marker))
    }),
    MessageKind::new(ROS, &["geometry_msgs/PoseArray"], POSES, poses),
];

/// Bytes of a position and a quaternion.
const POSE_BYTES: usize = 56;

fn poses(message: Stored<'_>) -> Readings<'_> {
    decode(message, |cdr| {
        let mut reading = header(cdr)?;
        for place in 0..limited(cdr.count(POSE_BYTES)?)? {
            let pose = pose(cdr, Label::Place(place), Kind::Pose)?;
            reading.items.push(pose);
        }
        Ok(vec![reading])
    })
}
