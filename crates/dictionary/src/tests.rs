//! Tests of the inner steps; those of what is public live in `tests/`.

use std::ops::Range;

use inhand_model::{SegmentLayout, SegmentOrigin, StopReason};
use nalgebra::DMatrix;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use serde_json::Value;

use crate::block::{Basis, Block};
use crate::covariance::moments_of;
use crate::data::Columns;
use crate::descent::{Gram, descend, descend_all};
use crate::error::LearnError;
use crate::matrix_view::{View, chunk_width, multiply};
use crate::nmf::iterate;
use crate::product::{cross, dot, gram, squared_residual};
use crate::rounds::{NmfProblem, NmfState, column_squares};
use crate::settings::{NmfSettings, Penalty, Update};

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

/// Columns of two samples: 30 numbers.
struct Plain(Vec<f64>);

const TWO_SAMPLES: SegmentLayout = SegmentLayout {
    samples: 2,
    rate_hz: 100.0,
    object: false,
};

impl Columns for Plain {
    fn layout(&self) -> SegmentLayout {
        TWO_SAMPLES
    }

    fn count(&self) -> usize {
        self.0.len() / 30
    }

    fn origin(&self, segment: usize) -> SegmentOrigin {
        SegmentOrigin {
            take: 0,
            start: segment,
        }
    }

    fn left_out(&self) -> usize {
        0
    }

    fn read(&self, segments: Range<usize>, into_m: &mut [f64]) -> Result<(), LearnError> {
        into_m.copy_from_slice(&self.0[segments.start * 30..segments.end * 30]);
        Ok(())
    }
}

/// Rounds from given factors over shifted data of any number of rows.
fn rounds(
    v: &[f64],
    rows: usize,
    primitives: Vec<f64>,
    activations: Vec<f64>,
    settings: &NmfSettings,
) -> (NmfState, Vec<f64>) {
    let count = v.len() / rows;
    let problem = NmfProblem {
        layout: TWO_SAMPLES,
        count,
        numbers: v.len(),
        offset_m: vec![0.0; 30],
        left_out: None,
        settings: NmfSettings {
            rank: primitives.len() / rows,
            ..settings.clone()
        },
    };
    let mut block = Block::new(v.to_vec(), rows);
    block.activations = activations;
    let mut blocks = [block];
    // One round in, so that the activations stay as given.
    let mut state = NmfState {
        round: 1,
        primitives,
        ..NmfState::default()
    };
    let columns = Plain(if rows == 30 { v.to_vec() } else { Vec::new() });
    let mut problem = problem;
    problem.settings.max_iterations += 1;
    iterate(&problem, &mut state, &mut blocks, &columns).unwrap();
    let [block] = blocks;
    (state, block.activations)
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
            View::columns(&w, rank),
            View::columns(&v, rows),
            &mut product,
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
    let iterations = r["iterations"].as_u64().unwrap() as usize;
    let (state, activations) = rounds(
        &numbers(&r["data"]),
        rows,
        start_w.as_slice().to_vec(),
        numbers(&r["start_activations"]),
        &settings(iterations, Update::Multiplicative),
    );
    assert_eq!(state.stop, Some(StopReason::IterationLimit));
    assert_eq!(state.primitives.len(), rank * rows);
    let w = matrix(&state.primitives, rank).transpose();
    assert!(largest_difference(w.as_slice(), &numbers(&r["primitives"])) < 1e-8);
    assert!(largest_difference(&activations, &numbers(&r["activations"])) < 1e-8);
}

#[test]
fn hals_agrees_with_the_plain_iteration() {
    let (rows, count, rank) = (60, 41, 9);
    let v = random(rows * count, 1);
    let start_w = random(rank * rows, 2);
    let start_h = random(rank * count, 3);
    let (state, activations) = rounds(
        &v,
        rows,
        start_w.clone(),
        start_h.clone(),
        &settings(5, Update::Hals),
    );

    let v = matrix(&v, rows);
    let mut w = matrix(&start_w, rank).transpose();
    let mut h = matrix(&start_h, rank);
    let (g, p) = (w.transpose() * &w, w.transpose() * &v);
    let sweeps = NmfSettings::default().sweeps;
    for _ in 0..sweeps {
        plain::sweep(&g, &p, &mut h);
    }
    for (iteration, found) in state.objective_history_m2.iter().enumerate() {
        if iteration > 0 {
            plain::iterate(&v, &mut w, &mut h, sweeps);
        }
        let expected = plain::objective(&v, &w, &h);
        assert!(
            (found - expected).abs() < 1e-10 * expected,
            "{iteration}: {found} {expected}"
        );
    }
    assert!(largest_difference(&state.primitives, w.transpose().as_slice()) < 1e-10);
    assert!(largest_difference(&activations, h.as_slice()) < 1e-9);
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
    let basis = Basis::new(&w, rank, Penalty::default());
    let fit = block.fit(&basis, Update::Hals, 0);
    assert!(
        (fit.squared_residual_m2 / 1e-18 - 1.0).abs() < 1e-4,
        "{}",
        fit.squared_residual_m2
    );
}

#[test]
fn a_primitive_that_died_is_put_to_use_again() {
    let (rows, count, rank) = (30, 15, 3);
    let mut start = random(rank * rows, 2);
    for numbers in start.chunks_exact_mut(rank) {
        numbers[1] = 0.0;
    }
    // An activation row of zeros keeps the primitive zero through its own half step.
    let mut activations = random(rank * count, 3);
    for h in activations.chunks_exact_mut(rank) {
        h[1] = 0.0;
    }
    let v = random(rows * count, 1);
    let (state, activations) = rounds(&v, rows, start, activations, &settings(10, Update::Hals));
    for (j, square) in column_squares(&state.primitives, rank).iter().enumerate() {
        assert!(*square > 1e-3, "{j}: {square}");
        assert!(activations.iter().skip(j).step_by(rank).any(|h| *h > 0.0));
    }
    for pair in state.objective_history_m2.windows(2) {
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
            let found = moments_of(blocks.len(), rank, |i| Ok(blocks[i].to_vec())).unwrap();
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
        let found = moments_of(1, rank, |_| Ok(vectors.clone())).unwrap();
        assert!(found.covariance.iter().all(|v| v.is_finite()), "{name}");
        assert!(found.covariance.cholesky().is_some(), "{name}");
        assert!(found.shrinkage > 0.0 && found.shrinkage <= 1.0, "{name}");
    }
}
