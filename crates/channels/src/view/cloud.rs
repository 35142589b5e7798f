//! Coloured points with a number each: what every viewer draws without set-up.

use foxglove::messages::packed_element_field::NumericType;
use foxglove::messages::{PackedElementField, PointCloud};

use crate::colour::Rgb;
use crate::wire::viewer_time;

/// x, y, z as 32-bit floats, a 32-bit number, red, green, blue, alpha as bytes.
const POINT_BYTES: u32 = 20;

/// A point cloud message that is filled anew for every instant.
#[derive(Clone, Debug)]
pub(crate) struct Cloud {
    message: PointCloud,
    data: Vec<u8>,
}

impl Cloud {
    /// A cloud in `frame` whose points carry a number called `number_name`.
    pub(crate) fn new(frame: &str, number_name: &str) -> Self {
        let field = |name: &str, offset, numeric_type: NumericType| PackedElementField {
            name: name.to_owned(),
            offset,
            r#type: numeric_type.into(),
        };
        let fields = vec![
            field("x", 0, NumericType::Float32),
            field("y", 4, NumericType::Float32),
            field("z", 8, NumericType::Float32),
            field(number_name, 12, NumericType::Uint32),
            field("red", 16, NumericType::Uint8),
            field("green", 17, NumericType::Uint8),
            field("blue", 18, NumericType::Uint8),
            field("alpha", 19, NumericType::Uint8),
        ];
        Self {
            message: PointCloud {
                frame_id: frame.to_owned(),
                pose: Some(super::entities::identity()),
                point_stride: POINT_BYTES,
                fields,
                ..PointCloud::default()
            },
            data: Vec::new(),
        }
    }

    pub(crate) fn clear(&mut self) {
        self.data.clear();
    }

    /// Adds a point, metres. Views are for the eye: 32 bits hold it to a micrometre at ten metres.
    pub(crate) fn push(&mut self, position_m: [f64; 3], number: usize, [red, green, blue]: Rgb) {
        for coordinate in position_m {
            (self.data).extend_from_slice(&(coordinate as f32).to_le_bytes());
        }
        (self.data).extend_from_slice(&(number as u32).to_le_bytes());
        self.data.extend_from_slice(&[red, green, blue, u8::MAX]);
    }

    /// Adds a ball: points on a sphere, which have a size in the scene where a single point has one on the
    /// screen.
    pub(crate) fn push_ball(
        &mut self,
        centre_m: [f64; 3],
        diameter_m: f64,
        number: usize,
        colour: Rgb,
    ) {
        for direction in ball_directions() {
            let point = on_sphere(centre_m, diameter_m, direction);
            self.push(point, number, colour);
        }
    }

    /// Adds what is left of a ball where there is less room: six of its points.
    pub(crate) fn push_star(
        &mut self,
        centre_m: [f64; 3],
        diameter_m: f64,
        number: usize,
        colour: Rgb,
    ) {
        for direction in face_directions() {
            let point = on_sphere(centre_m, diameter_m, direction);
            self.push(point, number, colour);
        }
    }

    pub(crate) fn message(&mut self, unix_nanos: u64) -> &PointCloud {
        self.message.timestamp = Some(viewer_time(unix_nanos));
        self.message.data = self.data.clone().into();
        &self.message
    }
}

fn on_sphere(centre_m: [f64; 3], diameter_m: f64, direction: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|axis: usize| centre_m[axis] + diameter_m / 2.0 * direction[axis])
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

/// Towards the faces and the corners of a cube: 14 unit vectors.
fn ball_directions() -> impl Iterator<Item = [f64; 3]> {
    let corner_axis = 1.0 / 3.0_f64.sqrt();
    let corners = (0..8).map(move |corner| {
        [0, 1, 2].map(|axis| {
            if corner >> axis & 1 == 0 {
                -corner_axis
            } else {
                corner_axis
            }
        })
    });
    face_directions().chain(corners)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ball_is_round_about_its_centre() {
        let directions: Vec<_> = ball_directions().collect();
        assert_eq!(directions.len(), 14);
        let mut sum = [0.0; 3];
        for direction in &directions {
            assert!((direction.iter().map(|c| c * c).sum::<f64>() - 1.0).abs() < 1e-15);
            for axis in 0..3 {
                sum[axis] += direction[axis];
            }
        }
        assert!(sum.iter().all(|c| c.abs() < 1e-15));

        let mut cloud = Cloud::new("hand", "finger");
        cloud.push_ball([1.0, 2.0, 3.0], 0.01, 4, [1, 2, 3]);
        assert_eq!(cloud.data.len(), 14 * POINT_BYTES as usize);
    }
}
