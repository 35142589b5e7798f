//! Hulls and distances against closed forms, independent references, properties, and bad input.

mod bad_input;
mod closed_form;
mod events;
mod phases;
mod properties;
mod reference;
mod slip;
mod surface;

use inhand_model::{Hand, Hull, Position};

fn positions(points: &[[f64; 3]]) -> Vec<Position<Hand>> {
    points.iter().map(|&p| p.into()).collect()
}

/// Points spread evenly over a sphere around the origin (Fibonacci lattice).
fn fibonacci_sphere(count: u32, radius: f64) -> Vec<[f64; 3]> {
    (0..count)
        .map(|k| {
            let z = 1.0 - (2.0 * f64::from(k) + 1.0) / f64::from(count);
            let angle = f64::from(k) * std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
            let r = (1.0 - z * z).sqrt();
            [
                radius * r * angle.cos(),
                radius * r * angle.sin(),
                radius * z,
            ]
        })
        .collect()
}

fn corners_of_triangle(hull: &Hull, triangle: [u32; 3]) -> [nalgebra::Vector3<f64>; 3] {
    triangle.map(|corner| hull.vertices_m[corner as usize].into())
}

/// Volume enclosed by the triangles, m³: positive when they run counter-clockwise seen from outside.
fn volume_m3(hull: &Hull) -> f64 {
    (hull.triangles.iter())
        .map(|&triangle| {
            let [a, b, c] = corners_of_triangle(hull, triangle);
            a.dot(&b.cross(&c)) / 6.0
        })
        .sum()
}

fn area_m2(hull: &Hull) -> f64 {
    (hull.triangles.iter())
        .map(|&triangle| {
            let [a, b, c] = corners_of_triangle(hull, triangle);
            (b - a).cross(&(c - a)).norm() / 2.0
        })
        .sum()
}

/// Every edge of the surface belongs to two triangles, which run along it in opposite directions.
fn is_closed(hull: &Hull) -> bool {
    let mut edges: Vec<(u32, u32)> = (hull.triangles.iter())
        .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)])
        .collect();
    let mut opposite: Vec<(u32, u32)> = edges.iter().map(|&(a, b)| (b, a)).collect();
    edges.sort_unstable();
    opposite.sort_unstable();
    let count = edges.len();
    edges.dedup();
    edges.len() == count
        && edges == opposite
        && 2 * hull.vertices_m.len() == hull.triangles.len() + 4
}
