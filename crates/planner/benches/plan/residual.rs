//! The default model: 60 end conditions and 140 activations of a deviation.

use divan::Bencher;
use inhand_model::{EndConditions, Residual};
use inhand_planner::{Backend, Ends, Planner, PlannerSettings, Target};

use crate::plain::{Gaussian, Plain, Rows};
use crate::{SAMPLES, VELOCITY_M_S, plan_in_turn, support};
use nalgebra::{DMatrix, DVector};

/// Primitives of the deviation.
const DEVIATION: usize = 140;

fn problem() -> (Residual, PlannerSettings, Vec<EndConditions>) {
    let residual = support::residual(SAMPLES, DEVIATION, false);
    let settings = support::settings(support::bounds(VELOCITY_M_S));
    let ends = (0..32)
        .map(|case| {
            let wave = |phase: f64, size: f64| {
                std::array::from_fn(|c| size * (1.3 * c as f64 + phase + f64::from(case)).sin())
            };
            EndConditions {
                first_m: wave(0.0, 0.02),
                last_m: wave(1.0, 0.02),
                first_velocity_m_s: wave(2.0, 0.05),
                last_velocity_m_s: wave(3.0, 0.05),
                object: None,
            }
        })
        .collect();
    (residual, settings, ends)
}

#[divan::bench]
fn prepare(bencher: Bencher) {
    let (residual, settings, _) = problem();
    bencher.bench_local(|| Planner::residual(&residual, &settings));
}

#[divan::bench(args = ["soft", "hard", "tight"])]
fn plan(bencher: Bencher, ends: &str) {
    plan_by(bencher, ends, Backend::ActiveSet);
}

#[divan::bench(args = ["soft"], sample_count = 20)]
fn plan_by_clarabel(bencher: Bencher, ends: &str) {
    plan_by(bencher, ends, Backend::Clarabel);
}

fn plan_by(bencher: Bencher, kind: &str, backend: Backend) {
    let (residual, settings, ends) = problem();
    let settings = match kind {
        "hard" => PlannerSettings {
            ends: Ends::Hard,
            ..settings
        },
        // Some bounds are active.
        "tight" => support::settings(support::bounds(0.12)),
        _ => settings,
    };
    let targets: Vec<Target> = ends.iter().map(Target::from).collect();
    let planner = Planner::residual(&residual, &settings)
        .expect("the formula makes a sound residual")
        .with_backend(backend);
    plan_in_turn(bencher, &planner, &targets);
}

#[divan::bench]
fn corridor_of_a_new_pattern(bencher: Bencher) {
    let (residual, settings, _) = problem();
    let target = Target::new().waypoint(0.5, [0.01; 15]);
    bencher
        .with_inputs(|| Planner::residual(&residual, &settings).expect("sound parts"))
        .bench_local_values(|planner| planner.corridor(&target));
}

#[divan::bench(sample_count = 1, sample_size = 1)]
fn plain_clarabel_with_every_row(bencher: Bencher) {
    let (residual, _, ends) = problem();
    let x = (ends[0].to_vector(residual.layout)).expect("segments without an object");
    let gaussian = Gaussian::of_residual(&residual, &x);
    let (rows, wanted) = gaussian.ends(&ends[0]);
    let mut velocities = DMatrix::zeros(30, 60 + DEVIATION);
    for i in 0..30 {
        velocities[(i, 30 + i)] = 1.0;
    }
    let velocities = Rows {
        factors: velocities,
        base: DVector::zeros(30),
    };
    let mut plain = Plain::new(&gaussian);
    plain.soft(&rows, &wanted, 0.1);
    plain.soft(&velocities, &(x.rows(30, 30) * 1e3), 0.1);
    let bound = [VELOCITY_M_S * 1e3];
    plain.between(&gaussian.differences(1), &bound.map(|v| -v), &bound);
    bencher.bench_local(|| plain.solve());
}
