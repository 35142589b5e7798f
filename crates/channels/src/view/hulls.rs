//! Training hulls of fingertips: filled in dictionaries, outlined in takes.

use std::collections::BTreeSet;

use foxglove::messages::{LinePrimitive, Point3, TriangleListPrimitive, line_primitive};
use inhand_model::{Frame, Hand, Hull, PerFinger};

use super::draw::{colour, entity, point, pose, scene};
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
}
