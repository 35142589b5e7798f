//! The object: its solid for viewers that draw scenes, its edges as points for those that do not.

use std::f64::consts::TAU;

use foxglove::messages::{CubePrimitive, CylinderPrimitive, PointCloud, SceneUpdate};
use inhand_model::Shape;

use super::cloud::Cloud;
use super::entities::{colour, entity, identity, size};
use crate::colour::Rgb;
use crate::error::ChannelError;
use crate::output::Output;
use crate::topic;

const OBJECT: Rgb = [0xBB, 0xBB, 0xBB];
/// Fingers behind the object stay visible.
const OBJECT_ALPHA: f64 = 0.5;
/// Points along an edge of a box, or around a quarter of a circle.
const EDGE_POINTS: usize = 12;

/// Sends the object once, at the start, on topics of its own: it moves with its frame.
pub(crate) fn write(
    shape: Shape,
    frame: &str,
    unix_nanos: u64,
    output: &mut Output,
) -> Result<(), ChannelError> {
    let mut solid = entity(frame, "object", unix_nanos);
    let (pose, color) = (Some(identity()), Some(colour(OBJECT, OBJECT_ALPHA)));
    match shape {
        Shape::Cuboid { edges_m } => solid.cubes.push(CubePrimitive {
            pose,
            size: Some(size(edges_m)),
            color,
        }),
        Shape::Cylinder {
            diameter_m,
            height_m,
        } => solid.cylinders.push(CylinderPrimitive {
            pose,
            size: Some(size([diameter_m, diameter_m, height_m])),
            bottom_scale: 1.0,
            top_scale: 1.0,
            color,
        }),
    }
    let update = SceneUpdate {
        deletions: Vec::new(),
        entities: vec![solid],
    };
    let channel = output.channel::<SceneUpdate>(topic::VIEW_OBJECT, Some(frame))?;
    output.message(channel, 0, unix_nanos, &update)?;

    let mut cloud = Cloud::new(frame, "edge");
    for (edge, point) in edge_points_m(shape) {
        cloud.push(point, edge, OBJECT);
    }
    let channel = output.channel::<PointCloud>(topic::VIEW_OBJECT_EDGES, Some(frame))?;
    output.message(channel, 0, unix_nanos, cloud.message(unix_nanos))
}

/// Points along the edges, metres, each with the number of its edge.
fn edge_points_m(shape: Shape) -> Vec<(usize, [f64; 3])> {
    match shape {
        Shape::Cuboid { edges_m } => (0..12)
            .flat_map(|edge| {
                (0..=EDGE_POINTS).map(move |n| (edge, box_edge_point(edges_m, edge, n)))
            })
            .collect(),
        Shape::Cylinder {
            diameter_m,
            height_m,
        } => (0..2)
            .flat_map(|rim| {
                let z = height_m * (rim as f64 - 0.5);
                (0..4 * EDGE_POINTS).map(move |n| {
                    let angle = TAU * n as f64 / (4 * EDGE_POINTS) as f64;
                    let (sin, cos) = angle.sin_cos();
                    (rim, [diameter_m / 2.0 * cos, diameter_m / 2.0 * sin, z])
                })
            })
            .collect(),
    }
}

/// Point `n` along one of the twelve edges: four along each axis, at the corners of the other two.
fn box_edge_point(edges_m: [f64; 3], edge: usize, n: usize) -> [f64; 3] {
    let along = edge / 4;
    let (sign_1, sign_2) = ([-0.5, 0.5][edge % 2], [-0.5, 0.5][edge / 2 % 2]);
    let mut point = [0.0; 3];
    point[along] = edges_m[along] * (n as f64 / EDGE_POINTS as f64 - 0.5);
    for (axis, sign) in [((along + 1) % 3, sign_1), ((along + 2) % 3, sign_2)] {
        point[axis] = edges_m[axis] * sign;
    }
    point
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn box_edges_lie_on_two_faces_each() {
        let edges_m = [0.04, 0.05, 0.06];
        let points = edge_points_m(Shape::Cuboid { edges_m });
        for &(_, point) in &points {
            let on_faces = (0..3)
                .filter(|&axis| (point[axis].abs() - edges_m[axis] / 2.0).abs() < 1e-12)
                .count();
            assert!(on_faces >= 2, "{point:?}");
        }
        for edge in 0..12 {
            let ends: Vec<_> = points.iter().filter(|(n, _)| *n == edge).collect();
            assert_eq!(ends.len(), EDGE_POINTS + 1);
        }
        let mut starts: Vec<_> = (points.iter())
            .step_by(EDGE_POINTS + 1)
            .map(|(edge, p)| (edge / 4, p.map(|c| (c * 1e3).round() as i64)))
            .collect();
        starts.sort_unstable();
        starts.dedup();
        assert_eq!(starts.len(), 12);
    }

    #[test]
    fn cylinder_rims_have_its_radius_and_height() {
        let points = edge_points_m(Shape::Cylinder {
            diameter_m: 0.05,
            height_m: 0.08,
        });
        for (_, [x, y, z]) in points {
            assert!((x.hypot(y) - 0.025).abs() < 1e-12 && (z.abs() - 0.04).abs() < 1e-12);
        }
    }
}
