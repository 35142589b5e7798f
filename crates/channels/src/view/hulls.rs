//! Training hulls of fingertips: filled in dictionaries, outlined in takes.

use std::collections::BTreeSet;

use foxglove::messages::{LinePrimitive, Point3, TriangleListPrimitive, line_primitive};
use inhand_model::{Finger, Frame, Hand, Hull, PerFinger};

use super::draw::{cloud_once, colour, entity, point, pose, scene};
use crate::colour::FINGER_COLOURS;
use crate::error::ChannelError;
use crate::streams::Streams;
use crate::topic;

/// Hulls enclose each other and the fingertips.
const FILLED_ALPHA: f64 = 0.2;
/// Outlines are around moving fingertips and must not hide them.
const OUTLINE_ALPHA: f64 = 0.25;
/// Thickness of an outline, metres.
const OUTLINE_M: f64 = 0.0003;
/// Distance between points of an edge, metres.
const EDGE_STEP_M: f64 = 0.0015;
/// Part of its finger's colour that a point of an edge has: fingertips and paths are brighter.
const EDGE_SHARE: f64 = 0.5;

/// Draws filled hulls once, on a topic of their own.
pub(crate) fn draw_filled(
    hulls: &PerFinger<Hull>,
    unix_nanos: u64,
    streams: &mut Streams<'_>,
) -> Result<(), ChannelError> {
    let mut filled = entity(Hand::NAME, "hulls", unix_nanos);
    let triangles = hulls.iter().map(|(finger, hull)| TriangleListPrimitive {
        pose: Some(pose([0.0; 3])),
        points: points(hull),
        color: Some(colour((FINGER_COLOURS[finger], FILLED_ALPHA))),
        indices: hull.triangles.concat(),
        ..TriangleListPrimitive::default()
    });
    filled.triangles = triangles.collect();
    let scene = scene(vec![filled]);
    streams.once(topic::VIEW_HULLS, Some(Hand::NAME), unix_nanos, &scene)
}

/// Draws outlines of hulls once, on a topic of their own: one entity for each finger.
pub(crate) fn draw_outlines(
    hulls: &PerFinger<Hull>,
    unix_nanos: u64,
    streams: &mut Streams<'_>,
) -> Result<(), ChannelError> {
    let outlines = hulls.iter().map(|(finger, hull)| {
        let mut outlined = entity(Hand::NAME, finger.name(), unix_nanos);
        outlined.lines.push(LinePrimitive {
            r#type: line_primitive::Type::LineList.into(),
            pose: Some(pose([0.0; 3])),
            thickness: OUTLINE_M,
            points: points(hull),
            color: Some(colour((FINGER_COLOURS[finger], OUTLINE_ALPHA))),
            indices: edges(hull).into_iter().flatten().collect(),
            ..LinePrimitive::default()
        });
        outlined
    });
    let scene = scene(outlines.collect());
    streams.once(topic::VIEW_TAKE_HULLS, Some(Hand::NAME), unix_nanos, &scene)
}

/// Draws the edges of hulls once as points, for viewers that draw no scenes.
pub(crate) fn draw_points(
    hulls: &PerFinger<Hull>,
    unix_nanos: u64,
    streams: &mut Streams<'_>,
) -> Result<(), ChannelError> {
    let points = (hulls.iter()).flat_map(|(finger, hull)| {
        let points = edges(hull)
            .into_iter()
            .flat_map(|edge| edge_points_m(hull, edge));
        points.map(move |point_m| (finger.index(), point_m))
    });
    let dimmed = |n: usize| {
        let rgb = FINGER_COLOURS[Finger::ALL[n]];
        rgb.map(|channel| (f64::from(channel) * EDGE_SHARE) as u8)
    };
    let place = (topic::VIEW_HULL_POINTS, Hand::NAME, "finger");
    cloud_once(place, points, dimmed, unix_nanos, streams)
}

/// Points along an edge, metres.
fn edge_points_m(hull: &Hull, edge: [u32; 2]) -> impl Iterator<Item = [f64; 3]> {
    let [from, to] = edge.map(|corner| hull.vertices_m[corner as usize]);
    let length_m = [0, 1, 2]
        .map(|axis| (to[axis] - from[axis]).powi(2))
        .iter()
        .sum::<f64>()
        .sqrt();
    let steps = (length_m / EDGE_STEP_M).ceil().max(1.0);
    (0..=steps as usize)
        .map(move |n| [0, 1, 2].map(|axis| from[axis] + (to[axis] - from[axis]) * n as f64 / steps))
}

fn points(hull: &Hull) -> Vec<Point3> {
    hull.vertices_m.iter().copied().map(point).collect()
}

/// The edges of a hull's triangles, each once, by its corners in rising order.
fn edges(hull: &Hull) -> BTreeSet<[u32; 2]> {
    (hull.triangles.iter())
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Euler's formula for a closed surface of triangles: V - E + F = 2, and each edge is of two of them.
    #[test]
    fn a_tetrahedron_has_six_edges() {
        let hull = Hull {
            vertices_m: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]],
            normals: Vec::new(),
            offsets_m: Vec::new(),
        };
        let expected = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];
        assert_eq!(edges(&hull), BTreeSet::from(expected));
    }

    #[test]
    fn points_of_an_edge_reach_from_corner_to_corner_in_small_steps() {
        let hull = Hull {
            vertices_m: vec![[0.0; 3], [0.003, 0.004, 0.0]],
            triangles: Vec::new(),
            normals: Vec::new(),
            offsets_m: Vec::new(),
        };
        let points: Vec<_> = edge_points_m(&hull, [0, 1]).collect();
        assert_eq!(
            (points[0], points.last()),
            ([0.0; 3], Some(&hull.vertices_m[1]))
        );
        for pair in points.windows(2) {
            let step_m = (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]);
            assert!(step_m > 0.0 && step_m <= EDGE_STEP_M + 1e-12, "{step_m}");
        }
    }
}
