//! Hull and distances at the size of a session: five training takes of 120 s at 100 Hz, and the
//! instants of 119 test segments.

use divan::{Bencher, black_box};
use inhand_contact::{HullProbe, hull, hull_distance_m, inside, surface_distance_m};
use inhand_model::{Hand, Position, Shape};

fn main() {
    divan::main();
}

/// A smooth wandering path, about 0.1 mm a sample, within some 5 cm.
fn path(samples: usize) -> Vec<Position<Hand>> {
    (0..samples)
        .map(|k| {
            let t = k as f64 * 0.01;
            let wave = |a: f64, b: f64, c: f64| {
                (0.37 * a * t).sin() * 0.012
                    + (0.61 * b * t).sin() * 0.008
                    + (1.3 * c * t).cos() * 0.003
            };
            Position::new(
                wave(1.0, 1.7, 0.9),
                wave(1.31, 0.87, 1.1),
                wave(0.73, 1.19, 1.3),
            )
        })
        .collect()
}

/// The same in steps of half a millimetre. Filtered motion of a real hand rests often, so that its
/// hull has some hundreds of triangles like this one; that of the smooth path has thousands.
fn coarse_path(samples: usize) -> Vec<Position<Hand>> {
    (path(samples).into_iter())
        .map(|p| Position::from_coords(p.coords_m().map(|c| (c * 2e3).round() / 2e3)))
        .collect()
}

#[divan::bench]
fn hull_of_60_000(bencher: Bencher<'_, '_>) {
    let points = coarse_path(60_000);
    bencher.bench(|| hull(black_box(&points)).expect("a path in space has a hull"));
}

#[divan::bench]
fn hull_of_60_000_with_many_corners(bencher: Bencher<'_, '_>) {
    let points = path(60_000);
    bencher.bench(|| hull(black_box(&points)).expect("a path in space has a hull"));
}

#[divan::bench]
fn hull_distance_11_900(bencher: Bencher<'_, '_>) {
    let hull = hull(&coarse_path(60_000)).expect("a path in space has a hull");
    let points = path(11_900);
    bencher.bench(|| {
        points
            .iter()
            .map(|p| hull_distance_m(&hull, p.to_array()))
            .sum::<f64>()
    });
}

#[divan::bench]
fn hull_probe_11_900(bencher: Bencher<'_, '_>) {
    let hull = hull(&coarse_path(60_000)).expect("a path in space has a hull");
    let points = path(11_900);
    bencher.bench(|| {
        let mut probe = HullProbe::new(&hull);
        points
            .iter()
            .map(|p| probe.distance_m(p.to_array()))
            .sum::<f64>()
    });
}

#[divan::bench]
fn inside_11_900(bencher: Bencher<'_, '_>) {
    let hull = hull(&coarse_path(60_000)).expect("a path in space has a hull");
    let points = path(11_900);
    bencher.bench(|| {
        points
            .iter()
            .filter(|p| inside(&hull, p.to_array(), 0.0))
            .count()
    });
}

#[divan::bench]
fn cylinder_distance_11_900(bencher: Bencher<'_, '_>) {
    let shape = Shape::Cylinder {
        diameter_m: 0.02,
        height_m: 0.02,
    };
    let points = path(11_900);
    bencher.bench(|| {
        (points.iter())
            .map(|p| surface_distance_m(&shape, Position::from(p.to_array())))
            .sum::<f64>()
    });
}
