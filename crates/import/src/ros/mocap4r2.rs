//! Package `mocap4r2_msgs`: markers and rigid bodies of motion capture.

use super::{Cdr, ROS, decode, header, limited, point, pose};
use crate::reading::{Fault, Item, Kind, Label, MOTION_CAPTURE, MessageKind, Readings, Stored};

// The second name of each is that of the package before it was renamed.
pub(super) const KINDS: &[MessageKind] = &[
    MessageKind::new(
        ROS,
        &["mocap4r2_msgs/Markers", "mocap_msgs/Markers"],
        MOTION_CAPTURE,
        |message| {
            frame(message, MARKER_BYTES, |cdr, items| {
                items.push(marker(cdr, None)?);
                Ok(())
            })
        },
    ),
    MessageKind::new(
        ROS,
        &["mocap4r2_msgs/RigidBodies", "mocap_msgs/RigidBodies"],
        MOTION_CAPTURE,
        |message| frame(message, BODY_BYTES, body),
    ),
];

/// Fewest bytes of a marker: kind, number, length of the name, three coordinates.
const MARKER_BYTES: usize = 36;
/// Fewest bytes of a rigid body: lengths of name and markers, pose.
const BODY_BYTES: usize = 64;

/// `id_type` of a marker that its number alone identifies.
const USE_INDEX: i8 = 1;
/// `id_type` of a marker that name and number identify.
const USE_BOTH: i8 = 2;

/// A message of mocap4r2: header, number of the frame, a sequence.
fn frame<'a>(
    message: Stored<'a>,
    element_bytes: usize,
    mut element: impl FnMut(&mut Cdr<'a>, &mut Vec<Item<'a>>) -> Result<(), Fault>,
) -> Readings<'a> {
    decode(message, |cdr| {
        let mut reading = header(cdr)?;
        cdr.u32()?; // Counts messages in some drivers and is always 0 in others.
        for _ in 0..limited(cdr.count(element_bytes)?)? {
            element(cdr, &mut reading.items)?;
            limited(reading.items.len())?;
        }
        Ok(vec![reading])
    })
}

/// A marker, of the rigid body of that name where there is one.
fn marker<'a>(cdr: &mut Cdr<'a>, body: Option<&str>) -> Result<Item<'a>, Fault> {
    let id_type = cdr.i8()?;
    let number = i64::from(cdr.i32()?);
    let name = cdr.text()?;
    let label = match body {
        Some(body) if id_type == USE_INDEX || name.is_empty() => {
            Label::Name(format!("{body}:{number}").into(), Some(number))
        }
        Some(body) => Label::Name(format!("{body}:{name}").into(), None),
        None if id_type == USE_INDEX || name.is_empty() => Label::Number(number),
        None => Label::Name(name, (id_type == USE_BOTH).then_some(number)),
    };
    let kind = match body {
        Some(_) => Kind::BodyMarker,
        None => Kind::Marker,
    };
    point(cdr, label, kind)
}

fn body<'a>(cdr: &mut Cdr<'a>, items: &mut Vec<Item<'a>>) -> Result<(), Fault> {
    let name = cdr.text()?;
    for _ in 0..limited(cdr.count(MARKER_BYTES)?)? {
        items.push(marker(cdr, Some(&name))?);
    }
    items.push(pose(cdr, Label::Name(name, None), Kind::Pose)?);
    Ok(())
}
