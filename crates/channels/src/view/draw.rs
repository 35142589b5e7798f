//! Shapes of scenes and points of clouds, as viewers draw them.

use foxglove::messages::packed_element_field::NumericType;
use foxglove::messages::{
    Color, LinePrimitive, PackedElementField, Point3, PointCloud, Pose, Quaternion, SceneEntity,
    SceneUpdate, SpherePrimitive, TextPrimitive, Vector3, line_primitive,
};

use crate::colour::Rgb;
use crate::error::ChannelError;
use crate::streams::{Instant, Sampling, Streams};
use crate::wire::viewer_time;

/// Diameter of a fingertip, metres: about that of a marker, so that neighbours stay apart.
pub(crate) const SPHERE_M: f64 = 0.005;
/// Thickness of a trail, metres.
pub(crate) const TRAIL_M: f64 = 0.001;

/// A colour and its opacity.
pub(crate) type Paint = (Rgb, f64);

/// Adding it leaves whole micrometres of a length, about: multiples of 2^-20 m, the rest is for no eye.
const ROUNDING_M: f64 = 1.5 * (1_u64 << 32) as f64;

/// A coordinate as views show it, metres.
pub(crate) fn shown(metres: f64) -> f64 {
    (metres + ROUNDING_M) - ROUNDING_M
}

pub(crate) fn pose(position_m: [f64; 3]) -> Pose {
    let [x, y, z] = position_m.map(shown);
    Pose {
        position: Some(Vector3 { x, y, z }),
        orientation: Some(Quaternion {
            x: 0.0,
            y: 0.0,
            z: 0.0,
            w: 1.0,
        }),
    }
}

pub(crate) fn size([x, y, z]: [f64; 3]) -> Vector3 {
    Vector3 { x, y, z }
}

pub(crate) fn point(position_m: [f64; 3]) -> Point3 {
    let [x, y, z] = position_m.map(shown);
    Point3 { x, y, z }
}

pub(crate) fn colour((rgb, alpha): Paint) -> Color {
    let [r, g, b] = rgb.map(|channel| f64::from(channel) / 255.0);
    Color { r, g, b, a: alpha }
}

/// A message that draws these entities.
pub(crate) fn scene(entities: Vec<SceneEntity>) -> SceneUpdate {
    SceneUpdate {
        deletions: Vec::new(),
        entities,
    }
}

/// An entity that replaces the one of the same id and moves with its frame.
pub(crate) fn entity(frame: &str, id: &str, unix_nanos: u64) -> SceneEntity {
    SceneEntity {
        timestamp: Some(viewer_time(unix_nanos)),
        frame_id: frame.to_owned(),
        id: id.to_owned(),
        frame_locked: true,
        ..SceneEntity::default()
    }
}

pub(crate) fn sphere(position_m: [f64; 3], diameter_m: f64, paint: Paint) -> SpherePrimitive {
    SpherePrimitive {
        pose: Some(pose(position_m)),
        size: Some(size([diameter_m; 3])),
        color: Some(colour(paint)),
    }
}

/// A line through all points.
pub(crate) fn strip(points: Vec<Point3>, thickness_m: f64, paint: Paint) -> LinePrimitive {
    LinePrimitive {
        r#type: line_primitive::Type::LineStrip.into(),
        pose: Some(pose([0.0; 3])),
        thickness: thickness_m,
        points,
        color: Some(colour(paint)),
        ..LinePrimitive::default()
    }
}

/// Letters of this height that face the viewer.
pub(crate) fn text(position_m: [f64; 3], height_m: f64, rgb: Rgb, text: String) -> TextPrimitive {
    TextPrimitive {
        pose: Some(pose(position_m)),
        billboard: true,
        font_size: height_m,
        scale_invariant: false,
        color: Some(colour((rgb, 1.0))),
        text,
    }
}

/// Shape of a point in a cloud, with its diameter in metres.
#[derive(Clone, Copy)]
pub(crate) enum Dot {
    /// A single point, which has a size on the screen.
    Point,
    /// Six points on a sphere, which has a size in the scene, for viewers that draw no scenes.
    Star(f64),
}

/// A message of coloured points with a number or two each, which every viewer draws without set-up.
pub(crate) struct Cloud {
    message: PointCloud,
    data: Vec<u8>,
}

impl Cloud {
    /// A cloud in `frame` whose points carry numbers of these names.
    pub(crate) fn new(frame: &str, numbers: &[&str]) -> Self {
        let mut message = PointCloud {
            frame_id: frame.to_owned(),
            pose: Some(pose([0.0; 3])),
            ..PointCloud::default()
        };
        let floats = ["x", "y", "z"].map(|name| (name, NumericType::Float32, 4));
        let numbers = numbers.iter().map(|&name| (name, NumericType::Uint32, 4));
        let bytes = ["red", "green", "blue", "alpha"].map(|name| (name, NumericType::Uint8, 1));
        for (name, numeric_type, width) in floats.into_iter().chain(numbers).chain(bytes) {
            message.fields.push(PackedElementField {
                name: name.to_owned(),
                offset: message.point_stride,
                r#type: numeric_type.into(),
            });
            message.point_stride += width;
        }
        Self {
            message,
            data: Vec::new(),
        }
    }

    /// Adds a point, metres; 32 bits hold it to a micrometre at ten metres.
    pub(crate) fn push(&mut self, position_m: [f64; 3], numbers: &[usize], rgb: Rgb) {
        for coordinate in position_m {
            (self.data).extend_from_slice(&(shown(coordinate) as f32).to_le_bytes());
        }
        for &number in numbers {
            (self.data).extend_from_slice(&(number as u32).to_le_bytes());
        }
        self.data.extend_from_slice(&rgb);
        self.data.push(u8::MAX);
    }

    /// Adds a point of this shape.
    pub(crate) fn push_dot(
        &mut self,
        dot: Dot,
        centre_m: [f64; 3],
        numbers: &[usize],
        colour: Rgb,
    ) {
        let (diameter_m, directions) = match dot {
            Dot::Point => return self.push(centre_m, numbers, colour),
            Dot::Star(diameter_m) => (diameter_m, face_directions()),
        };
        for direction in directions {
            let point =
                [0, 1, 2].map(|axis: usize| centre_m[axis] + diameter_m / 2.0 * direction[axis]);
            self.push(point, numbers, colour);
        }
    }

    /// The message with the points since the last one.
    pub(crate) fn message(&mut self, unix_nanos: u64) -> &PointCloud {
        self.message.timestamp = Some(viewer_time(unix_nanos));
        self.message.data = std::mem::take(&mut self.data).into();
        &self.message
    }
}

/// Adds a channel with a cloud for each sample, of the points that `fill` adds.
pub(crate) fn add_cloud<'a>(
    streams: &mut Streams<'a>,
    (topic, frame): (&str, &str),
    numbers: &[&str],
    sampling: Sampling,
    mut fill: impl FnMut(&Instant<'_>, &mut Cloud) + 'a,
) -> Result<(), ChannelError> {
    let channel = streams.output.channel::<PointCloud>(topic, Some(frame))?;
    let mut cloud = Cloud::new(frame, numbers);
    streams.add(sampling, move |at, output| {
        fill(at, &mut cloud);
        output.message(channel, at.k, at.unix_nanos, cloud.message(at.unix_nanos))
    });
    Ok(())
}

/// Writes one cloud of numbered points that holds for the whole file, on a topic of its own.
pub(crate) fn cloud_once(
    (topic, frame, number): (&str, &str, &str),
    points_m: impl IntoIterator<Item = (usize, [f64; 3])>,
    colour: impl Fn(usize) -> Rgb,
    unix_nanos: u64,
    streams: &mut Streams<'_>,
) -> Result<(), ChannelError> {
    let mut cloud = Cloud::new(frame, &[number]);
    for (n, point_m) in points_m {
        cloud.push(point_m, &[n], colour(n));
    }
    streams.once(topic, Some(frame), unix_nanos, cloud.message(unix_nanos))
}

/// Towards the faces of a cube: 6 unit vectors.
fn face_directions() -> impl Iterator<Item = [f64; 3]> {
    (0..3).flat_map(|axis| {
        [-1.0, 1.0].map(|sign| {
            let mut direction = [0.0; 3];
            direction[axis] = sign;
            direction
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_star_is_round_about_its_centre() {
        let mut cloud = Cloud::new("hand", &["finger"]);
        cloud.push_dot(Dot::Star(0.01), [1.0, 2.0, 3.0], &[4], [1, 2, 3]);
        let stride = cloud.message.point_stride as usize;
        let points: Vec<[f64; 3]> = (cloud.data.chunks(stride))
            .map(|point| {
                let float = |n: usize| f32::from_le_bytes([0, 1, 2, 3].map(|k| point[4 * n + k]));
                [0, 1, 2].map(|n| f64::from(float(n)))
            })
            .collect();
        assert_eq!(points.len(), 6);
        for axis in 0..3 {
            let mean = points.iter().map(|point| point[axis]).sum::<f64>() / 6.0;
            assert!((mean - [1.0, 2.0, 3.0][axis]).abs() < 1e-6);
        }
        let off = |point: &[f64; 3]| {
            let from = [point[0] - 1.0, point[1] - 2.0, point[2] - 3.0];
            from.iter().map(|c| c * c).sum::<f64>().sqrt()
        };
        assert!(points.iter().all(|point| (off(point) - 0.005).abs() < 2e-6));
    }
}
