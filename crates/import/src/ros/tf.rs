//! Transforms between frames.

use super::{Cdr, ROS, decode, header, limited, pose};
use crate::reading::{Fault, Kind, Label, MessageKind, Reading, TRANSFORMS};

pub(super) const KINDS: &[MessageKind] = &[
    MessageKind::new(
        ROS,
        &["geometry_msgs/TransformStamped"],
        TRANSFORMS,
        |message| decode(message, |cdr| Ok(vec![transform(cdr)?])),
    ),
    MessageKind::new(
        ROS,
        &["tf2_msgs/TFMessage", "tf/tfMessage"],
        TRANSFORMS,
        |message| {
            decode(message, |cdr| {
                let count = limited(cdr.count(TRANSFORM_BYTES)?)?;
                (0..count).map(|_| transform(cdr)).collect()
            })
        },
    ),
];

/// Fewest bytes of a transform: header, name of the child, pose.
const TRANSFORM_BYTES: usize = 72;

fn transform<'a>(cdr: &mut Cdr<'a>) -> Result<Reading<'a>, Fault> {
    let mut reading = header(cdr)?;
    let label = Label::Name(cdr.text()?, None);
    reading.items.push(pose(cdr, label, Kind::Transform)?);
    Ok(reading)
}
