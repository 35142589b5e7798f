//! Tests of the inner steps; those of what is public live in `tests/`.

use inhand_model::StopReason;
use nalgebra::DMatrix;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use serde_json::Value;

use crate::block::{Basis, Block, Sums, cross_sum};
use crate::covariance::moments;
use crate::descent::{Gram, descend, descend_all};
use crate::factorise::{factorise, normalise};
use crate::product::{View, chunk_width, cross, dot, gram, multiply, squared_residual};
use crate::settings::{NmfSettings, Update};

#[path = "../tests/plain.rs"]
mod plain;

fn reference(part: &str) -> Value {
    let text = include_str!("../tests/reference/reference.json");
    serde_json::from_str::<Value>(text).unwrap()[part].clone()
}

fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(values) => values.iter().flat_map(numbers).collect(),
        other => vec![other.as_f64().unwrap()],
    }
}

/// Uniform numbers in [0, 1).
fn random(count: usize, seed: u64) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    (0..count)
        .map(|_| f64::from(random.next_u32()) / 4_294_967_296.0)
        .collect()
}

fn matrix(data: &[f64], rows: usize) -> DMatrix<f64> {
    DMatrix::from_column_slice(rows, data.len() / rows, data)
}

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max)
}

fn settings(max_iterations: usize, update: Update) -> NmfSettings {
    NmfSettings {
        max_iterations,
        relative_change: 0.0,
        update,
        ..NmfSettings::default()
    }
}

#[test]
fn products_agree_with_nalgebra() {
    // Sizes around chunk and panel borders, and far from them.
    for (rank, rows, count) in [(1, 1, 1), (3, 7, 5), (65, 130, 201), (70, 3, 700)] {
        let (w, h) = (random(rank * rows, 1), random(rank * count, 2));
        let v = random(rows * count, 3);
        let (w_m, h_m, v_m) = (matrix(&w, rank), matrix(&h, rank), matrix(&v, rows));
        let tolerance = 1e-13 * (rows + count) as f64;
        let expected = &h_m * h_m.transpose();
        assert!(largest_difference(&gram(&h, rank), expected.as_slice()) < tolerance);
        let expected = &h_m * v_m.transpose();
        assert!(largest_difference(&cross(&h, rank, &v, rows), expected.as_slice()) < tolerance);
        let mut product = vec![f64::NAN; rank * count];
        multiply(
            1.0,
            View::columns(&w, rank),
            View::columns(&v, rows),
            0.0,
            &mut product,
            rank,
        );
        assert!(largest_difference(&product, (&w_m * &v_m).as_slice()) < tolerance);
        let expected = (&v_m - w_m.transpose() * &h_m).norm_squared();
        let found = squared_residual(&v, rows, &w, &h, rank);
        assert!(
            (found - expected).abs() < 1e-12 * expected,
            "{found} {expected}"
        );
        assert!((dot(&v, &v) - v_m.norm_squared()).abs() < 1e-12 * v_m.norm_squared());
    }
}

#[test]
fn chunks_cover_everything_and_depend_on_the_count_alone() {
    for count in [0, 1, 3, 95, 96, 97, 595, 1500, 2048] {
        let width = chunk_width(count);
        assert!(width >= 1 && width <= count.max(1));
        assert!(width * count.div_ceil(width) >= count);
    }
}

#[test]
fn descent_agrees_with_the_plain_sweep() {
    // Ranks around the blocks of coordinates, counts around the lanes.
    for rank in [1, 2, 7, 8, 9, 16, 31] {
        for count in [1, 3, 4, 8, 13] {
            let basis = random(rank * 40, rank as u64);
            let symmetric = gram(&basis, rank);
            // Some of the linear terms are negative, so that bounds become active.
            let linear: Vec<f64> = random(rank * count, 5)
                .iter()
                .map(|p| 20.0 * p - 6.0)
                .collect();
            let mut fast = random(rank * count, 6);
            let mut slow = matrix(&fast, rank);
            descend(
                &Gram::new(&symmetric, rank, 0.0),
                &linear,
                0.0,
                &mut fast,
                4,
            );
            for _ in 0..4 {
                plain::sweep(&matrix(&symmetric, rank), &matrix(&linear, rank), &mut slow);
            }
            let difference = largest_difference(&fast, slow.as_slice());
            assert!(
                difference < 1e-11,
                "rank {rank}, {count} columns: {difference}"
            );
            assert!(rank < 7 || fast.contains(&0.0), "no bound was active");
        }
    }
}

#[test]
fn a_column_does_not_depend_on_its_neighbours() {
    let (rank, count) = (19, 37);
    let gram = Gram::new(&gram(&random(rank * 40, 1), rank), rank, 0.0);
    let linear = random(rank * count, 2);
    let start = random(rank * count, 3);
    let mut together = start.clone();
    descend_all(&gram, &linear, 0.0, &mut together, 3);
    for column in 0..count {
        let range = column * rank..(column + 1) * rank;
        let mut alone = start[range.clone()].to_vec();
        descend(&gram, &linear[range.clone()], 0.0, &mut alone, 3);
        assert_eq!(alone, together[range], "column {column}");
    }
}

#[test]
fn coordinates_without_curvature_stay() {
    let mut x = vec![0.25, 0.5];
    // The first primitive is zero: nothing is known of its activation.
    descend(
        &Gram::new(&[0.0, 0.0, 0.0, 2.0], 2, 0.0),
        &[0.0, 3.0],
        0.0,
        &mut x,
        1,
    );
    assert_eq!(x, [0.25, 1.5]);
}

#[test]
fn multiplicative_updates_agree_with_scikit_learn() {
    let r = reference("multiplicative");
    let (rows, rank) = (20, 4);
    let start_w = matrix(&numbers(&r["start_primitives"]), rows).transpose();
    let mut block = Block::new(numbers(&r["data"]), rows);
    block.activations = numbers(&r["start_activations"]);
    let mut blocks = [block];
    let mut basis = Basis::new(start_w.as_slice().to_vec(), rank);
    let iterations = r["iterations"].as_u64().unwrap() as usize;
    let course = factorise(
        &mut blocks,
        &mut basis,
        &settings(iterations, Update::Multiplicative),
    );
    assert_eq!(course.stop_reason, StopReason::IterationLimit);
    let w = matrix(&basis.rows_of, rank).transpose();
    assert!(largest_difference(w.as_slice(), &numbers(&r["primitives"])) < 1e-8);
    assert!(largest_difference(&blocks[0].activations, &numbers(&r["activations"])) < 1e-8);
}

#[test]
fn hals_agrees_with_the_plain_iteration() {
    let (rows, count, rank) = (60, 41, 9);
    let v = random(rows * count, 1);
    let start_w = random(rank * rows, 2);
    let start_h = random(rank * count, 3);
    let mut block = Block::new(v.clone(), rows);
    block.activations = start_h.clone();
    let mut blocks = [block];
    let mut basis = Basis::new(start_w.clone(), rank);
    let course = factorise(&mut blocks, &mut basis, &settings(5, Update::Hals));

    let v = matrix(&v, rows);
    let mut w = matrix(&start_w, rank).transpose();
    let mut h = matrix(&start_h, rank);
    let (g, p) = (w.transpose() * &w, w.transpose() * &v);
    for _ in 0..3 {
        plain::sweep(&g, &p, &mut h);
    }
    for (iteration, found) in course.objective_history.iter().enumerate() {
        if iteration > 0 {
            plain::iterate(&v, &mut w, &mut h, 3);
        }
        let expected = plain::objective(&v, &w, &h);
        assert!(
            (found - expected).abs() < 1e-10 * expected,
            "{iteration}: {found} {expected}"
        );
    }
    assert!(largest_difference(&basis.rows_of, w.transpose().as_slice()) < 1e-10);
    assert!(largest_difference(&blocks[0].activations, h.as_slice()) < 1e-9);
}

#[test]
fn sums_of_blocks_are_those_of_the_whole() {
    let (rows, rank) = (12, 5);
    let v = random(rows * 90, 1);
    let basis = Basis::new(random(rank * rows, 2), rank);
    let fit = |widths: &[usize]| {
        let (mut rest, mut first) = (v.as_slice(), 0);
        let mut blocks = Vec::new();
        for width in widths {
            let (data, later) = rest.split_at(width * rows);
            rest = later;
            let mut block = Block::new(data.to_vec(), rows);
            block.start_activations(&basis, 0, first);
            first += width;
            blocks.push(block);
        }
        let sums = Sums::of(&mut blocks, &basis, Update::Hals, 2);
        (sums, cross_sum(&blocks, rank))
    };
    let (whole, whole_cross) = fit(&[90]);
    let (parts, parts_cross) = fit(&[40, 1, 49]);
    assert_eq!(parts.count, 90);
    assert!(largest_difference(&whole.activation_gram, &parts.activation_gram) < 1e-11);
    assert!(largest_difference(&whole_cross, &parts_cross) < 1e-11);
    assert!((whole.squared_residual / parts.squared_residual - 1.0).abs() < 1e-11);
}

#[test]
fn near_an_exact_fit_the_residual_comes_from_differences() {
    // V = W H but for one number: the expanded form would return rounding.
    let (rows, count, rank) = (30, 25, 4);
    let (w, h) = (random(rank * rows, 1), random(rank * count, 2));
    let mut v = (matrix(&w, rank).transpose() * matrix(&h, rank))
        .as_slice()
        .to_vec();
    v[7] += 1e-9;
    let mut block = Block::new(v, rows);
    block.activations = h;
    let basis = Basis::new(w, rank);
    let fit = block.fit(&basis, Update::Hals, 0);
    assert!(
        (fit.squared_residual / 1e-18 - 1.0).abs() < 1e-4,
        "{}",
        fit.squared_residual
    );
}

#[test]
fn a_primitive_that_died_is_put_to_use_again() {
    let (rows, count, rank) = (20, 15, 3);
    let mut block = Block::new(random(rows * count, 1), rows);
    let mut start = random(rank * rows, 2);
    for numbers in start.chunks_exact_mut(rank) {
        numbers[1] = 0.0;
    }
    let mut basis = Basis::new(start, rank);
    block.start_activations(&basis, 0, 0);
    // An activation row of zeros keeps the primitive zero through its own half step.
    for h in block.activations.chunks_exact_mut(rank) {
        h[1] = 0.0;
    }
    let mut blocks = [block];
    let course = factorise(&mut blocks, &mut basis, &settings(10, Update::Hals));
    normalise(&mut blocks, &mut basis);
    for j in 0..rank {
        assert!((basis.gram[j * rank + j] - 1.0).abs() < 1e-12);
        assert!(
            blocks[0]
                .activations
                .iter()
                .skip(j)
                .step_by(rank)
                .any(|h| *h > 0.0)
        );
    }
    for pair in course.objective_history.windows(2) {
        assert!(pair[1] <= pair[0] * (1.0 + 1e-9));
    }
}

#[test]
fn moments_agree_with_scikit_learn() {
    for case in reference("ledoit_wolf").as_array().unwrap() {
        let mean = numbers(&case["mean"]);
        let rank = mean.len();
        let vectors = numbers(&case["vectors"]);
        // The same in one block and in two.
        let (first, second) = vectors.split_at(2 * rank);
        for blocks in [vec![vectors.as_slice()], vec![first, second]] {
            let found = moments(&blocks, rank);
            let weight = case["weight"].as_f64().unwrap();
            assert!(
                (found.shrinkage - weight).abs() < 1e-12,
                "{} {weight}",
                found.shrinkage
            );
            assert!(largest_difference(found.mean.as_slice(), &mean) < 1e-13);
            let covariance = numbers(&case["covariance"]);
            assert!(largest_difference(found.covariance.as_slice(), &covariance) < 1e-12);
        }
    }
}

#[test]
fn covariance_of_anything_can_be_inverted() {
    let never_used: Vec<f64> = random(200, 1)
        .chunks(4)
        .flat_map(|v| [v[0], 0.0, v[1], v[2]])
        .collect();
    let cases: [(&str, Vec<f64>, usize); 4] = [
        ("one vector", vec![0.3, 0.0, 0.1], 3),
        ("equal vectors", [0.3, 0.2].repeat(5), 2),
        ("all zero", vec![0.0; 6], 2),
        ("a coordinate that is always zero", never_used, 4),
    ];
    for (name, vectors, rank) in cases {
        let found = moments(&[&vectors], rank);
        assert!(found.covariance.iter().all(|v| v.is_finite()), "{name}");
        assert!(found.covariance.cholesky().is_some(), "{name}");
        assert!(found.shrinkage > 0.0 && found.shrinkage <= 1.0, "{name}");
    }
}
