//! Invariants of every simulated take, for any seed.

mod faults;
mod refusals;
mod reproducibility;
mod truth;
mod vendor_side;

use inhand_model::{Position, Shape};

/// Distance from the surface of a solid, metres, negative inside; written here apart from the
/// simulation's own, from the faces' half-spaces.
fn surface_distance_m<F: inhand_model::Frame>(shape: Shape, point: Position<F>) -> f64 {
    let [x, y, z] = point.to_array();
    // Signed distances to the planes (or the mantle) that bound the solid, one per direction that
    // can be left independently of the others.
    let excess = match shape {
        Shape::Cuboid { edges_m } => {
            vec![
                x.abs() - edges_m[0] / 2.0,
                y.abs() - edges_m[1] / 2.0,
                z.abs() - edges_m[2] / 2.0,
            ]
        }
        Shape::Cylinder {
            diameter_m,
            height_m,
        } => vec![
            (x * x + y * y).sqrt() - diameter_m / 2.0,
            z.abs() - height_m / 2.0,
        ],
    };
    let outside: f64 = excess.iter().filter(|&&e| e > 0.0).map(|e| e * e).sum();
    if outside > 0.0 {
        outside.sqrt()
    } else {
        excess.into_iter().fold(f64::NEG_INFINITY, f64::max)
    }
}

/// The objects that every invariant is checked on: the demo's, and the corners of what the hand
/// holds.
fn shapes() -> Vec<Shape> {
    [
        "cube:0.05",
        "cylinder:0.05x0.05",
        "cube:0.035",
        "cube:0.08",
        "box:0.08x0.035x0.03",
        "box:0.035x0.08x0.1",
        "cylinder:0.035x0.03",
        "cylinder:0.08x0.1",
    ]
    .map(|text| text.parse().expect("the shapes above are shapes"))
    .into()
}
