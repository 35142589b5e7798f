//! Package `geometry_msgs`: poses and points with a header.

use super::{Cdr, header, kind, limited, one, point, pose};
use crate::format::{MessageKind, POSES};
use crate::reading::{Fault, Kind, Label, Reading};

pub(super) const KINDS: &[MessageKind] = &[
    kind(&["geometry_msgs/PoseStamped"], POSES, |cdr| {
        one(cdr, |cdr| pose(cdr, Label::Topic, Kind::Pose))
    }),
    kind(&["geometry_msgs/PointStamped"], POSES, |cdr| {
        one(cdr, |cdr| point(cdr, Label::Topic, Kind::Marker))
    }),
    kind(&["geometry_msgs/PoseArray"], POSES, poses),
];

/// Bytes of a position and a quaternion.
const POSE_BYTES: usize = 56;

fn poses<'a>(cdr: &mut Cdr<'a>) -> Result<Vec<Reading<'a>>, Fault> {
    let mut reading = header(cdr)?;
    for place in 0..limited(cdr.count(POSE_BYTES)?)? {
        reading
            .items
            .push(pose(cdr, Label::Place(place), Kind::Pose)?);
    }
    Ok(vec![reading])
}
