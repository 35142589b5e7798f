//! Messages of ROS 2 in CDR.

use super::cdr::Cdr;
use super::reading::{Fault, Item, Kind, Label, MAX_ITEMS, Reading, nanos};

/// Message types that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RosType {
    Pose,
    Point,
    Poses,
    Transform,
    Transforms,
    Markers,
    Bodies,
}

/// Names of the message types, without the folder `msg` that ROS 2 puts in.
const TYPES: [(&str, RosType); 10] = [
    ("geometry_msgs/PoseStamped", RosType::Pose),
    ("geometry_msgs/PointStamped", RosType::Point),
    ("geometry_msgs/PoseArray", RosType::Poses),
    ("geometry_msgs/TransformStamped", RosType::Transform),
    ("tf2_msgs/TFMessage", RosType::Transforms),
    ("mocap4r2_msgs/Markers", RosType::Markers),
    ("mocap4r2_msgs/RigidBodies", RosType::Bodies),
    // The name of the package before it was renamed.
    ("mocap_msgs/Markers", RosType::Markers),
    ("mocap_msgs/RigidBodies", RosType::Bodies),
    ("tf/tfMessage", RosType::Transforms),
];

/// Fewest bytes of a marker: kind, number, length of the name, three coordinates.
const MARKER_BYTES: usize = 36;
/// Fewest bytes of a rigid body: lengths of name and markers, pose.
const BODY_BYTES: usize = 64;
/// Bytes of a position and a quaternion.
const POSE_BYTES: usize = 56;
/// Fewest bytes of a transform: header, name of the child, pose.
const TRANSFORM_BYTES: usize = 72;

/// `id_type` of a marker that goes by its number alone.
const USE_INDEX: i8 = 1;
/// `id_type` of a marker that goes by name and number.
const USE_BOTH: i8 = 2;

impl RosType {
    /// The type of that schema name, with or without `/msg/`.
    pub(super) fn of(schema: &str) -> Option<Self> {
        let name = schema.replacen("/msg/", "/", 1);
        let known = TYPES.iter().find(|(known, _)| *known == name);
        known.map(|&(_, ros_type)| ros_type)
    }

    /// What a message of this type says.
    pub(super) fn read(self, message: &[u8]) -> Result<Vec<Reading<'_>>, Fault> {
        let cdr = &mut Cdr::new(message)?;
        let readings = match self {
            RosType::Pose => one(cdr, |cdr| pose(cdr, Label::Topic, Kind::Pose)),
            RosType::Point => one(cdr, |cdr| point(cdr, Label::Topic, Kind::Marker)),
            RosType::Poses => several(cdr, POSE_BYTES, |cdr, place, items| {
                items.push(pose(cdr, Label::Place(place), Kind::Pose)?);
                Ok(())
            }),
            RosType::Transform => Ok(vec![transform(cdr)?]),
            RosType::Transforms => {
                let count = limited(cdr.count(TRANSFORM_BYTES)?)?;
                (0..count).map(|_| transform(cdr)).collect()
            }
            RosType::Markers => frame_of(cdr, MARKER_BYTES, |cdr, items| {
                items.push(marker(cdr, None)?);
                Ok(())
            }),
            RosType::Bodies => frame_of(cdr, BODY_BYTES, body),
        }?;
        cdr.end()?;
        Ok(readings)
    }
}

fn one<'a>(
    cdr: &mut Cdr<'a>,
    item: impl FnOnce(&mut Cdr<'a>) -> Result<Item<'a>, Fault>,
) -> Result<Vec<Reading<'a>>, Fault> {
    let mut reading = header(cdr)?;
    reading.items.push(item(cdr)?);
    Ok(vec![reading])
}

fn several<'a>(
    cdr: &mut Cdr<'a>,
    element_bytes: usize,
    mut element: impl FnMut(&mut Cdr<'a>, usize, &mut Vec<Item<'a>>) -> Result<(), Fault>,
) -> Result<Vec<Reading<'a>>, Fault> {
    let mut reading = header(cdr)?;
    for place in 0..limited(cdr.count(element_bytes)?)? {
        element(cdr, place, &mut reading.items)?;
    }
    Ok(vec![reading])
}

/// A message of mocap4r2: header, number of the frame, a sequence.
fn frame_of<'a>(
    cdr: &mut Cdr<'a>,
    element_bytes: usize,
    mut element: impl FnMut(&mut Cdr<'a>, &mut Vec<Item<'a>>) -> Result<(), Fault>,
) -> Result<Vec<Reading<'a>>, Fault> {
    let mut reading = header(cdr)?;
    cdr.u32()?; // Counts messages in some drivers and is always 0 in others.
    for _ in 0..limited(cdr.count(element_bytes)?)? {
        element(cdr, &mut reading.items)?;
        limited(reading.items.len())?;
    }
    Ok(vec![reading])
}

fn limited(count: usize) -> Result<usize, Fault> {
    if count <= MAX_ITEMS {
        return Ok(count);
    }
    Err(Fault::new(
        format!("at most {MAX_ITEMS} markers or bodies in a message"),
        count.to_string(),
    ))
}

/// A header and no items yet.
fn header<'a>(cdr: &mut Cdr<'a>) -> Result<Reading<'a>, Fault> {
    let (seconds, nanoseconds) = (cdr.i32()?, cdr.u32()?);
    Ok(Reading {
        stamp_nanos: nanos(seconds.into(), nanoseconds.into()),
        frame: cdr.text()?,
        items: Vec::new(),
    })
}

fn pose<'a>(cdr: &mut Cdr<'a>, label: Label<'a>, kind: Kind) -> Result<Item<'a>, Fault> {
    Ok(Item {
        label,
        kind,
        position: cdr.f64s()?,
        rotation: cdr.f64s()?,
    })
}

fn point<'a>(cdr: &mut Cdr<'a>, label: Label<'a>, kind: Kind) -> Result<Item<'a>, Fault> {
    Ok(Item {
        label,
        kind,
        position: cdr.f64s()?,
        rotation: [0.0; 4],
    })
}

fn transform<'a>(cdr: &mut Cdr<'a>) -> Result<Reading<'a>, Fault> {
    let Reading {
        stamp_nanos, frame, ..
    } = header(cdr)?;
    let label = Label::Name(cdr.text()?, None);
    let item = pose(cdr, label, Kind::Transform)?;
    Ok(Reading::one(stamp_nanos, frame, item))
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
