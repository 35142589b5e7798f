//! The object: its solid for viewers that draw scenes, its edges and surface as points for those that do
//! not. Of one whose shape is not known the axes are drawn.

use std::f64::consts::TAU;

use foxglove::messages::{CubePrimitive, CylinderPrimitive, SceneEntity};
use inhand_model::{Frame, Object, Shape};

use super::draw::{Paint, cloud_once, colour, entity, point, pose, scene, size, strip};
use crate::colour::Rgb;
use crate::error::ChannelError;
use crate::streams::Streams;
use crate::topic;

/// Fingers behind the object stay visible.
const OBJECT: Paint = ([0xBB, 0xBB, 0xBB], 0.5);
/// Points of the surface stay behind fingertips.
const SURFACE: Rgb = [0x66, 0x66, 0x66];
/// Points along an edge of a box, or around a quarter of a circle: close enough to look like a line.
const EDGE_POINTS: usize = 32;
/// Distance between points of the surface, metres.
const GRID_M: f64 = 0.01;
/// Most steps of the grid along one direction.
const MOST_STEPS: usize = 40;
/// x, y and z, as in most viewers.
const AXES: [Rgb; 3] = [[0xE0, 0x3C, 0x31], [0x3F, 0xA3, 0x4D], [0x3A, 0x6F, 0xD8]];
/// Length of an axis, metres: about half of what a hand turns.
const AXIS_M: f64 = 0.025;
/// Thickness of an axis, metres.
const AXIS_THICKNESS_M: f64 = 0.001;
/// Points along an axis.
const AXIS_POINTS: usize = 10;

/// The solid of a shape as an entity of this id.
pub(crate) fn solid(
    shape: Shape,
    (frame, id): (&str, &str),
    paint: Paint,
    unix_nanos: u64,
) -> SceneEntity {
    let mut solid = entity(frame, id, unix_nanos);
    let (pose, color) = (Some(pose([0.0; 3])), Some(colour(paint)));
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
    solid
}

/// Draws the object once, at the start, on topics of its own: it moves with its frame.
pub(crate) fn draw(
    shape: Option<Shape>,
    unix_nanos: u64,
    streams: &mut Streams<'_>,
) -> Result<(), ChannelError> {
    let (frame, object) = (Object::NAME, topic::VIEW_OBJECT);
    let edges = (topic::VIEW_OBJECT_EDGES, frame, "edge");
    let Some(shape) = shape else {
        let mut axes = entity(frame, "object", unix_nanos);
        for (axis, colour) in AXES.into_iter().enumerate() {
            let ends = [0.0, 1.0].map(|share| point(along_axis(axis, share)));
            let line = strip(ends.into(), AXIS_THICKNESS_M, (colour, 1.0));
            axes.lines.push(line);
        }
        streams.once(object, Some(frame), unix_nanos, &scene(vec![axes]))?;
        let points = (0..3).flat_map(|axis| {
            let shares = (0..=AXIS_POINTS).map(|n| n as f64 / AXIS_POINTS as f64);
            shares.map(move |share| (axis, along_axis(axis, share)))
        });
        return cloud_once(edges, points, |axis| AXES[axis], unix_nanos, streams);
    };
    let solid = solid(shape, (frame, "object"), OBJECT, unix_nanos);
    streams.once(object, Some(frame), unix_nanos, &scene(vec![solid]))?;
    let points = edge_points_m(shape);
    cloud_once(edges, points, |_| OBJECT.0, unix_nanos, streams)?;
    let surface = (topic::VIEW_OBJECT_SURFACE, frame, "face");
    let points = surface_points_m(shape);
    cloud_once(surface, points, |_| SURFACE, unix_nanos, streams)
}

/// The point at this share of an axis.
fn along_axis(axis: usize, share: f64) -> [f64; 3] {
    let mut point = [0.0; 3];
    point[axis] = AXIS_M * share;
    point
}

/// Points of a grid on every face, metres, each with the number of its face: of a box six, of a cylinder
/// its side, bottom and top.
fn surface_points_m(shape: Shape) -> Vec<(usize, [f64; 3])> {
    match shape {
        Shape::Cuboid { edges_m } => (0..6)
            .flat_map(|face| grid_on_box_face(edges_m, face))
            .collect(),
        Shape::Cylinder {
            diameter_m,
            height_m,
        } => {
            let radius_m = diameter_m / 2.0;
            let rows = steps(height_m);
            let side = (0..=rows).flat_map(|row| {
                let z = height_m * (row as f64 / rows as f64 - 0.5);
                ring(radius_m).map(move |[x, y]| (0, [x, y, z]))
            });
            let rings = steps(radius_m);
            let ends = (0..2).flat_map(|end| {
                let z = height_m * (end as f64 - 0.5);
                (0..rings).flat_map(move |n| {
                    ring(radius_m * n as f64 / rings as f64).map(move |[x, y]| (1 + end, [x, y, z]))
                })
            });
            side.chain(ends).collect()
        }
    }
}

/// Steps of the grid along a length: about [`GRID_M`] each, few enough for any object.
fn steps(length_m: f64) -> usize {
    ((length_m / GRID_M).round() as usize).clamp(1, MOST_STEPS)
}

/// Two faces across each axis, with a grid over the other two.
fn grid_on_box_face(edges_m: [f64; 3], face: usize) -> impl Iterator<Item = (usize, [f64; 3])> {
    let axis = face / 2;
    let (first, second) = ((axis + 1) % 3, (axis + 2) % 3);
    let (across, along) = (steps(edges_m[first]), steps(edges_m[second]));
    (0..=across).flat_map(move |a| {
        (0..=along).map(move |b| {
            let mut point = [0.0; 3];
            point[axis] = edges_m[axis] * [-0.5, 0.5][face % 2];
            point[first] = edges_m[first] * (a as f64 / across as f64 - 0.5);
            point[second] = edges_m[second] * (b as f64 / along as f64 - 0.5);
            (face, point)
        })
    })
}

/// Points around a circle; its centre where it has no radius.
fn ring(radius_m: f64) -> impl Iterator<Item = [f64; 2]> {
    let count = if radius_m > 0.0 {
        steps(TAU * radius_m).max(6)
    } else {
        1
    };
    (0..count).map(move |n| {
        let (sin, cos) = (TAU * n as f64 / count as f64).sin_cos();
        [radius_m * cos, radius_m * sin]
    })
}

/// Points along the edges, metres, each with the number of its edge.
pub(crate) fn edge_points_m(shape: Shape) -> Vec<(usize, [f64; 3])> {
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
    fn surface_points_lie_on_their_faces_a_grid_step_apart() {
        let edges_m = [0.04, 0.05, 0.06];
        let points = surface_points_m(Shape::Cuboid { edges_m });
        assert_eq!(points.len(), 2 * (6 * 7 + 7 * 5 + 5 * 6));
        for (face, point) in points {
            let axis = face / 2;
            let expected = edges_m[axis] * [-0.5, 0.5][face % 2];
            assert!((point[axis] - expected).abs() < 1e-15);
            assert!((0..3).all(|axis| point[axis].abs() <= edges_m[axis] / 2.0 + 1e-15));
        }
        let round = Shape::Cylinder {
            diameter_m: 0.05,
            height_m: 0.08,
        };
        for (face, [x, y, z]) in surface_points_m(round) {
            let radius = x.hypot(y);
            match face {
                0 => assert!((radius - 0.025).abs() < 1e-12 && z.abs() <= 0.04 + 1e-15),
                _ => assert!(radius < 0.025 && (z - [-0.04, 0.04][face - 1]).abs() < 1e-15),
            }
        }
        // A wall is no reason for a million points.
        let wall = Shape::Cuboid {
            edges_m: [100.0, 100.0, 100.0],
        };
        assert_eq!(surface_points_m(wall).len(), 6 * 41 * 41);
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
