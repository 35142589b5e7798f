//! Sets points aside that cannot be corners, so that the hull algorithm sees few.

use super::plane_of;
use super::quickhull::quickhull;
use super::vector::{Vec3, dot};

/// Points looked at together; small enough for their coordinates and distances to stay in cache.
const BLOCK: usize = 256;

/// Half of the directions in which extreme points are sought, not of unit length: axes, edges and
/// corners of a cube, and those halfway between. The other half is opposite.
const DIRECTIONS: [Vec3; 25] = [
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 1.0, 0.0],
    [1.0, -1.0, 0.0],
    [1.0, 0.0, 1.0],
    [1.0, 0.0, -1.0],
    [0.0, 1.0, 1.0],
    [0.0, 1.0, -1.0],
    [1.0, 1.0, 1.0],
    [1.0, 1.0, -1.0],
    [1.0, -1.0, 1.0],
    [1.0, -1.0, -1.0],
    [2.0, 1.0, 1.0],
    [2.0, 1.0, -1.0],
    [2.0, -1.0, 1.0],
    [2.0, -1.0, -1.0],
    [1.0, 2.0, 1.0],
    [1.0, 2.0, -1.0],
    [1.0, -2.0, 1.0],
    [1.0, -2.0, -1.0],
    [1.0, 1.0, 2.0],
    [1.0, 1.0, -2.0],
    [1.0, -1.0, 2.0],
    [1.0, -1.0, -2.0],
];

/// The points that may be corners of the hull, in their order: all but those well inside the hull
/// of the extreme points along a few directions. "Well" is more than rounding can be wrong by, so
/// no corner is lost.
///
/// Cost proportional to the number of points.
pub(super) fn possible_corners(points: &[Vec3], needed_thickness: f64) -> Vec<Vec3> {
    // Not worth it for few points.
    if points.len() < 4 * DIRECTIONS.len() {
        return points.to_vec();
    }
    let (extremes, size) = extremes(points);
    let Ok(triangles) = quickhull(&extremes, needed_thickness) else {
        // The extremes are flat although the points may not be quite: keep them all.
        return points.to_vec();
    };
    let planes: Vec<(Vec3, f64)> = (triangles.iter())
        .filter_map(|triangle| {
            let corners = triangle.map(|corner| extremes[corner as usize]);
            let (normal, conditioning) = plane_of(corners)?;
            let offset = (corners.iter())
                .map(|&corner| dot(normal, corner))
                .fold(f64::INFINITY, f64::min);
            // A unit normal is wrong by its conditioning in roundings, a product with it by as much
            // times the size of the points.
            let margin = 64.0 * f64::EPSILON * conditioning * size;
            Some((normal, offset - margin))
        })
        .collect();

    let mut kept = Vec::new();
    let mut block = [[0.0; BLOCK]; 3];
    let mut highest = [0.0; BLOCK];
    for chunk in points.chunks(BLOCK) {
        for (place, p) in chunk.iter().enumerate() {
            for axis in 0..3 {
                block[axis][place] = p[axis];
            }
        }
        highest.fill(f64::NEG_INFINITY);
        let [xs, ys, zs] = &block;
        for &([nx, ny, nz], offset) in &planes {
            for place in 0..BLOCK {
                let height = nx * xs[place] + ny * ys[place] + nz * zs[place] - offset;
                highest[place] = if height > highest[place] {
                    height
                } else {
                    highest[place]
                };
            }
        }
        let outside = chunk.iter().zip(&highest).filter(|(_, h)| **h >= 0.0);
        kept.extend(outside.map(|(&p, _)| p));
    }
    kept
}

/// The extreme points along all directions without repetition, and the largest norm of a point.
fn extremes(points: &[Vec3]) -> (Vec<Vec3>, f64) {
    let mut found = [[(0_usize, f64::NEG_INFINITY); 2]; DIRECTIONS.len()];
    let mut size = 0.0_f64;
    for (index, &p) in points.iter().enumerate() {
        size = size.max(dot(p, p));
        for (direction, [low, high]) in DIRECTIONS.iter().zip(&mut found) {
            let along = dot(*direction, p);
            if along > high.1 {
                *high = (index, along);
            }
            if -along > low.1 {
                *low = (index, -along);
            }
        }
    }
    let mut indices: Vec<usize> = found.as_flattened().iter().map(|best| best.0).collect();
    indices.sort_unstable();
    indices.dedup();
    let extremes = indices.into_iter().map(|index| points[index]).collect();
    (extremes, size.sqrt())
}
