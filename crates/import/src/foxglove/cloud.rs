//! Points of a `foxglove.PointCloud` as markers.

use ::foxglove::messages::PointCloud;
use ::foxglove::messages::packed_element_field::NumericType;
use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion};

use super::{coordinates, rotation, stamp};
use crate::reading::{Fault, Item, Kind, Label, Reading, Readings, limited};

/// Fields that number a marker, the first that a cloud has.
const NUMBER_FIELDS: [&str; 5] = ["id", "marker_id", "marker", "index", "label"];

/// The points, by their number where the cloud has one, else by their place.
pub(super) fn points(cloud: &PointCloud) -> Readings<'static> {
    let axes = ["x", "y", "z"].map(|axis| NumberField::find(cloud, axis));
    let [Some(x), Some(y), Some(z)] = axes else {
        let names = cloud
            .fields
            .iter()
            .take(20)
            .map(|field| field.name.as_str());
        return Err(Fault::new(
            "fields x, y and z, each with a numeric type and inside the point",
            format!("the fields {:?}", names.collect::<Vec<_>>()),
        ));
    };
    let number = (NUMBER_FIELDS.iter()).find_map(|name| NumberField::find(cloud, name));
    let stride = cloud.point_stride as usize;
    let points = cloud.data.chunks_exact(stride);
    if !points.remainder().is_empty() {
        return Err(Fault::new(
            format!("data of a multiple of {stride} bytes, the size of a point"),
            format!("{} bytes", cloud.data.len()),
        ));
    }
    limited(points.len(), "points")?;
    let frame_from_cloud = pose(cloud)?;
    let items = points.enumerate().map(|(place, point)| Item {
        label: number.map_or(Label::Place(place), |number| {
            Label::Number(number.value(point) as i64)
        }),
        kind: Kind::Marker,
        position: {
            let [x, y, z] = [x, y, z].map(|column| column.value(point));
            (frame_from_cloud * Point3::new(x, y, z)).coords.into()
        },
        rotation: [0.0; 4],
    });
    Ok(vec![Reading {
        stamp_nanos: stamp(cloud.timestamp),
        frame: cloud.frame_id.clone().into(),
        items: items.collect(),
    }])
}

/// Position and rotation of the cloud in its frame.
fn pose(cloud: &PointCloud) -> Result<Isometry3<f64>, Fault> {
    let Some(pose) = &cloud.pose else {
        return Ok(Isometry3::identity());
    };
    let translation = (pose.position).map_or([0.0; 3], |position| coordinates(Some(position)));
    let [x, y, z, w] = rotation(pose.orientation);
    let rotation = if [x, y, z, w] == [0.0; 4] {
        UnitQuaternion::identity()
    } else {
        UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 1e-6).ok_or_else(|| {
            let found = format!("quaternion {x}, {y}, {z}, {w}");
            Fault::new("a pose with a rotation", found)
        })?
    };
    Ok(Isometry3::from_parts(
        Translation3::from(translation),
        rotation,
    ))
}

/// A number of every point.
#[derive(Clone, Copy)]
struct NumberField {
    offset: usize,
    numeric: NumericType,
}

impl NumberField {
    /// The field of that name, if all of it is inside a point.
    fn find(cloud: &PointCloud, name: &str) -> Option<Self> {
        let field = (cloud.fields.iter()).find(|field| field.name.eq_ignore_ascii_case(name))?;
        let numeric = NumericType::try_from(field.r#type).ok()?;
        let offset = field.offset as usize;
        let fits = offset.checked_add(size(numeric)?)? <= cloud.point_stride as usize;
        fits.then_some(Self { offset, numeric })
    }

    fn value(self, point: &[u8]) -> f64 {
        fn array<const N: usize>(bytes: &[u8]) -> [u8; N] {
            // `find` has made sure that the number is inside the point.
            bytes.first_chunk().copied().unwrap_or([0; N])
        }
        let bytes = &point[self.offset..];
        match self.numeric {
            NumericType::Unknown => f64::NAN,
            NumericType::Uint8 => array::<1>(bytes)[0].into(),
            NumericType::Int8 => i8::from_le_bytes(array(bytes)).into(),
            NumericType::Uint16 => u16::from_le_bytes(array(bytes)).into(),
            NumericType::Int16 => i16::from_le_bytes(array(bytes)).into(),
            NumericType::Uint32 => u32::from_le_bytes(array(bytes)).into(),
            NumericType::Int32 => i32::from_le_bytes(array(bytes)).into(),
            NumericType::Float32 => f32::from_le_bytes(array(bytes)).into(),
            NumericType::Float64 => f64::from_le_bytes(array(bytes)),
        }
    }
}

fn size(numeric: NumericType) -> Option<usize> {
    match numeric {
        NumericType::Unknown => None,
        NumericType::Uint8 | NumericType::Int8 => Some(1),
        NumericType::Uint16 | NumericType::Int16 => Some(2),
        NumericType::Uint32 | NumericType::Int32 | NumericType::Float32 => Some(4),
        NumericType::Float64 => Some(8),
    }
}
