//! Replanning from a state that is not the planned one, and velocities on the way.

use inhand_model::{
    ConstraintFamily, Dictionary, DictionaryKind, Finger, PerFinger, Plan, PlanStatus, Trajectory,
};
use inhand_planner::{
    AccelerationBounds, Backend, Ends, Knot, Method, Planner, PlannerSettings, Target, Tips, replan,
};
use nalgebra::DVector;

use crate::plain::{Gaussian, Rows};
use crate::support::{bounds, free, residual, settings};

const SAMPLES: usize = 20;
const RATE_HZ: f64 = 20.0;

fn planners(settings: &PlannerSettings) -> [Planner; 3] {
    [0, 1, 2].map(|kind| planner(kind, settings))
}

fn planner(kind: usize, settings: &PlannerSettings) -> Planner {
    let components = || free(SAMPLES, RATE_HZ, |_| 0.05);
    match kind {
        0 => Planner::residual(&residual(SAMPLES, 120, false), settings).expect("sound parts"),
        1 => Planner::new(&components(), Method::Prior, settings).expect("sound parts"),
        _ => {
            let positive = Dictionary {
                kind: DictionaryKind::Nmf,
                ..components()
            };
            Planner::new(&positive, Method::Prior, settings).expect("sound parts")
        }
    }
}

fn soft(bound_m_s: f64) -> PlannerSettings {
    settings(bounds(bound_m_s))
}

fn hard(bound_m_s: f64) -> PlannerSettings {
    PlannerSettings {
        ends: Ends::Hard,
        ..soft(bound_m_s)
    }
}

fn there(size: f64, phase: f64) -> [f64; 15] {
    std::array::from_fn(|c| 0.05 + size * (1.3 * c as f64 + phase).sin())
}

/// From here to there with velocities and points on the way.
fn target() -> Target {
    Target::new()
        .first(there(0.01, 0.0))
        .last(there(0.01, 2.0))
        .first_velocity([0.01; 15])
        .last_velocity([0.0; 15])
        .waypoint(0.3, there(0.009, 0.7))
        .waypoint(0.7, there(0.01, 1.4))
        .velocity_at(0.15, there(0.002, 0.0).map(|v| v - 0.05))
}

/// A state on a trajectory.
fn state(trajectory: &Trajectory, sample: usize) -> Knot {
    let tips = |value: &dyn Fn(Finger) -> [f64; 3]| Tips(PerFinger::from_fn(|f| Some(value(f))));
    let at = |t: usize, finger| trajectory.position(t, finger).to_array();
    Knot {
        time_s: sample as f64 / RATE_HZ,
        tips: tips(&|finger| at(sample, finger)),
        velocity: tips(&|finger| {
            let (a, b) = (at(sample, finger), at(sample + 1, finger));
            [0, 1, 2].map(|axis| (b[axis] - a[axis]) * RATE_HZ)
        }),
    }
}

fn motion(plan: &Plan) -> &Trajectory {
    assert_eq!(plan.status, PlanStatus::Solved, "{:?}", plan.certificate);
    plan.trajectory.as_ref().expect("a solved plan has one")
}

/// Largest distance of two motions from a sample on, per coordinate.
fn apart(a: &Trajectory, b: &Trajectory, from: usize) -> f64 {
    (a.values_m().iter().zip(b.values_m()))
        .skip(15 * from)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max)
}

/// Fastest coordinate from a sample on, m/s.
fn fastest(trajectory: &Trajectory, from: usize) -> f64 {
    let values = &trajectory.values_m()[15 * from..];
    (values.iter().zip(&values[15..]))
        .map(|(a, b)| (b - a).abs() * RATE_HZ)
        .fold(0.0, f64::max)
}

#[test]
fn a_state_on_the_plan_changes_nothing() {
    for (made, tolerance_m, slower) in [
        (hard as fn(f64) -> PlannerSettings, 1e-10, None),
        (hard, 1e-10, Some(0.98)),
        // Drawn once more to soft targets, by part of what they are missed by.
        (soft, PlannerSettings::SIGMA_M, None),
        (soft, PlannerSettings::SIGMA_M, Some(0.98)),
    ] {
        for kind in 0..3 {
            let mut made_planner = planner(kind, &made(100.0));
            let mut plan = made_planner.plan(&target()).unwrap();
            if let Some(slower) = slower {
                // So that bounds are active.
                let bound = slower * fastest(motion(&plan), 0);
                made_planner = planner(kind, &made(bound));
                plan = made_planner.plan(&target()).unwrap();
                assert!(plan.checks.active[ConstraintFamily::Velocity] > 0);
            }
            for sample in [0, 1, 5, 6, 7, 13, 14, 18] {
                let state = state(motion(&plan), sample);
                let again = replan(&made_planner, &plan, &target(), &state).unwrap();
                let away = apart(motion(&plan), motion(&again), sample);
                assert!(away < tolerance_m, "from {sample}: {away}");
            }
        }
    }
}

#[test]
fn a_jump_is_started_from_and_the_goal_is_reached() {
    for (settings, start_m, goal_m) in [(hard(0.3), 1e-12, 1e-12), (soft(0.3), 1e-8, 1e-4)] {
        for planner in planners(&settings) {
            let plan = planner.plan(&target()).unwrap();
            for sample in [1, 7, 12] {
                let mut state = state(motion(&plan), sample);
                state.tips.0[Finger::Index].as_mut().unwrap()[1] += 0.005;
                let again = replan(&planner, &plan, &target(), &state).unwrap();
                let moved = motion(&again);
                for finger in Finger::ALL {
                    let found = moved.position(sample, finger).to_array();
                    let wanted = state.tips.0[finger].unwrap();
                    let goal = moved.position(SAMPLES - 1, finger).to_array();
                    for axis in 0..3 {
                        let away = (found[axis] - wanted[axis]).abs();
                        assert!(away < start_m, "{finger} {axis} at {sample}: {away}");
                        let wanted = there(0.01, 2.0)[3 * finger.index() + axis];
                        assert!((goal[axis] - wanted).abs() < goal_m);
                    }
                }
                // The jump happened before; afterwards bounds hold.
                assert!(again.certificate.worst() <= 1e-6);
                assert!(fastest(moved, sample) <= 0.3 * (1.0 + 1e-6));
                // What lies ahead is not thrown about: nowhere farther off than three times the
                // jump, and on the waypoint that is still to come.
                let away = apart(motion(&plan), moved, sample);
                assert!(away < 0.015, "from {sample}: {away}");
                for (c, wanted) in there(0.01, 1.4).iter().enumerate() {
                    assert!((moved.configuration_m(14)[c] - wanted).abs() < goal_m);
                }
            }
        }
    }
}

/// Rows of several parts as one, with what is wanted of them (m, m/s).
fn stacked(parts: &[(Rows, &[f64])]) -> (Rows, DVector<f64>) {
    let factors: Vec<_> = (parts.iter())
        .flat_map(|(rows, _)| rows.factors.row_iter().map(nalgebra::Matrix::into_owned))
        .collect();
    let base: Vec<f64> = (parts.iter())
        .flat_map(|(rows, _)| rows.base.iter().copied())
        .collect();
    let wanted = (parts.iter()).flat_map(|(_, values)| values.iter().map(|v| v * 1e3));
    let wanted = DVector::from_iterator(base.len(), wanted);
    let rows = Rows {
        factors: nalgebra::DMatrix::from_rows(&factors),
        base: DVector::from_vec(base),
    };
    (rows, wanted)
}

#[test]
fn it_departs_from_the_plan_by_what_is_most_likely() {
    let dictionary = free(SAMPLES, RATE_HZ, |c| 0.04 + 0.001 * c as f64);
    let planner = Planner::new(&dictionary, Method::Prior, &soft(100.0)).unwrap();
    let plan = planner.plan(&target()).unwrap();
    let sample = 9;
    let mut state = state(motion(&plan), sample);
    state.tips.0[Finger::Thumb].as_mut().unwrap()[0] += 0.004;
    state.velocity.0[Finger::Little].as_mut().unwrap()[2] -= 0.01;
    // Elsewhere than planned.
    let goal = there(0.01, 2.2);
    let elsewhere = target().last(goal);
    let again = replan(&planner, &plan, &elsewhere, &state).unwrap();

    // The Gaussian about the plan, given what lies ahead.
    let mut all = Gaussian::of_dictionary(&dictionary);
    all.mean = &plan.activations_m * 1e3;
    let configuration = |t: usize| all.coordinates(&Vec::from_iter(15 * t..15 * (t + 1)));
    let steps = all.differences(1);
    let step = |t: usize| Rows {
        factors: steps.factors.rows(15 * t, 15).into_owned(),
        base: steps.base.rows(15 * t, 15).into_owned(),
    };
    let numbers =
        |tips: &Tips| -> Vec<f64> { (tips.0.iter()).flat_map(|(_, tip)| tip.unwrap()).collect() };
    let (position, velocity) = (numbers(&state.tips), numbers(&state.velocity));
    let via = there(0.01, 1.4);
    let given = |all: &Gaussian, parts: &[(Rows, &[f64])], sigma| {
        let (rows, wanted) = stacked(parts);
        all.given(&rows, &wanted, sigma)
    };
    let expected = given(
        &all,
        &[
            (configuration(14), &via[..]),
            (configuration(19), &goal[..]),
        ],
        0.1,
    );
    let expected = given(&expected, &[(step(18), &[0.0; 15])], 0.1);
    let now = [
        (configuration(sample), &position[..]),
        (step(sample), &velocity[..]),
    ];
    let expected = given(&expected, &now, 1e-3).motion();
    for (row, value) in motion(&again).values_m().iter().enumerate() {
        let away = (value - expected[row] * 1e-3).abs();
        assert!(away < 1e-9, "row {row}: {away}");
    }
}

#[test]
fn replanning_again_and_again_ends_in_the_goal() {
    for settings in [hard(0.4), soft(0.4)] {
        for planner in planners(&settings) {
            let mut plan = planner.plan(&target()).unwrap();
            for sample in (2..SAMPLES - 2).step_by(2) {
                let mut state = state(motion(&plan), sample);
                // Pushed by up to a millimetre, each time otherwise; nothing at the last.
                for (finger, tip) in Finger::ALL.map(|f| (f, state.tips.0[f])) {
                    let size = 1e-3 * (SAMPLES - 4 - sample) as f64 / SAMPLES as f64;
                    let push = |axis: usize| {
                        size * ((sample * 7 + finger.index() * 3 + axis) as f64).sin()
                    };
                    let tip = tip.unwrap();
                    state.tips.0[finger] = Some([0, 1, 2].map(|axis| tip[axis] + push(axis)));
                }
                plan = replan(&planner, &plan, &target(), &state).unwrap();
                assert!(fastest(motion(&plan), sample) <= 0.4 * (1.0 + 1e-6));
            }
            let last = motion(&plan).configuration_m(SAMPLES - 1);
            for (found, wanted) in last.iter().zip(there(0.01, 2.0)) {
                assert!((found - wanted).abs() < 1e-4, "{found} {wanted}");
            }
        }
    }
}

#[test]
fn fingers_left_out_of_the_state_follow() {
    for planner in planners(&hard(100.0)) {
        let plan = planner.plan(&target()).unwrap();
        let mut state = state(motion(&plan), 8);
        for finger in [Finger::Ring, Finger::Little] {
            state.tips.0[finger] = None;
            state.velocity.0[finger] = None;
        }
        // With nothing else changed, they go on as planned.
        let again = replan(&planner, &plan, &target(), &state).unwrap();
        assert!(apart(motion(&plan), motion(&again), 8) < 1e-10);
    }
}

#[test]
fn a_state_too_near_the_goal_in_time_has_to_give_way_or_says_so() {
    // 20 mm to go in three steps of 5 mm.
    for (settings, status) in [
        (hard(0.1), PlanStatus::Infeasible),
        (soft(0.1), PlanStatus::Solved),
    ] {
        for planner in &planners(&settings)[1..] {
            let target = Target::new().first([0.05; 15]).last([0.05; 15]);
            let plan = planner.plan(&target).unwrap();
            let mut state = state(motion(&plan), 16);
            state.velocity = Tips::default();
            state.tips.0[Finger::Middle].as_mut().unwrap()[0] += 0.02;
            for backend in [Backend::ActiveSet, Backend::Clarabel] {
                let planner = planner.clone().with_backend(backend);
                let again = replan(&planner, &plan, &target, &state).unwrap();
                assert_eq!(again.status, status);
                let by = (again.relaxations.iter())
                    .find(|r| r.family == ConstraintFamily::Velocity)
                    .map(|r| r.by);
                if status == PlanStatus::Infeasible {
                    assert!((by.unwrap() - (0.02 / 0.15 - 0.1)).abs() < 1e-6, "{by:?}");
                }
            }
        }
    }
}

#[test]
fn states_and_plans_that_do_not_fit_are_refused() {
    let [planner, other] = [0, 1].map(|kind| planner(kind, &hard(0.3)));
    let plan = planner.plan(&target()).unwrap();
    let on = state(motion(&plan), 4);
    for time_s in [-0.1, 0.95, 2.0, f64::NAN, f64::INFINITY] {
        let error = replan(&planner, &plan, &target(), &Knot { time_s, ..on }).unwrap_err();
        let expected = format!("planning anew at {time_s} s: expected a time from 0 to 0.9");
        assert!(error.to_string().starts_with(&expected), "{error}");
    }
    let error = replan(&other, &plan, &target(), &on).unwrap_err();
    let expected = "number of activations of the plan to go on from is 180, expected 300";
    assert_eq!(error.to_string(), expected);
    let failed = planner.plan(&target().last([0.5; 15])).unwrap();
    assert_eq!(failed.status, PlanStatus::Infeasible);
    let error = replan(&planner, &failed, &target(), &on).unwrap_err();
    assert!(error.to_string().ends_with("is 0, expected 180"), "{error}");
    let mut nan = on;
    nan.tips.0[Finger::Ring] = Some([0.0, 0.0, f64::NAN]);
    let error = replan(&planner, &plan, &target(), &nan).unwrap_err();
    assert!(
        error.to_string().contains("ring, axis 2, is NaN"),
        "{error}"
    );
}

#[test]
fn constraints_before_they_begin_to_hold_are_not_counted() {
    let acceleration = AccelerationBounds {
        min_m_s2: [-1.0; 15],
        max_m_s2: [1.0; 15],
    };
    let mut settings = hard(0.1);
    settings.constraints.acceleration = Some(acceleration);
    // 30 mm within a sample, at 0.25 s.
    let jump = Target::new()
        .first([0.05; 15])
        .waypoint(0.25, [0.05; 15])
        .waypoint(0.3, [0.08; 15])
        .last([0.08; 15]);
    for planner in &planners(&settings)[1..] {
        for backend in [Backend::ActiveSet, Backend::Clarabel] {
            let planner = planner.clone().with_backend(backend);
            assert_eq!(planner.plan(&jump).unwrap().status, PlanStatus::Infeasible);
            let from = |time_s| jump.clone().constrained_from(time_s);
            let before = planner.plan(&from(0.25)).unwrap();
            assert_eq!(before.status, PlanStatus::Infeasible);
            let after = planner.plan(&from(0.3)).unwrap();
            assert!(after.certificate.worst() <= 1e-6, "{:?}", after.certificate);
            let trajectory = motion(&after);
            assert!(fastest(trajectory, 0) > 0.5);
            assert!(fastest(trajectory, 6) <= 0.1 * (1.0 + 1e-6));
            for family in [ConstraintFamily::Velocity, ConstraintFamily::Acceleration] {
                let by = after.checks.violation[family].unwrap();
                assert!(by <= 1e-6, "{family:?} by {by}");
            }
        }
    }
}

#[test]
fn velocities_on_the_way_are_steps_of_the_motion() {
    for planner in planners(&hard(100.0)) {
        let mut some = PerFinger::from_fn(|_| None);
        some[Finger::Index] = Some([0.02, -0.01, 0.03]);
        let ends = Target::new().first(there(0.01, 0.0)).last(there(0.01, 1.0));
        // 0.26 s is nearest to sample 5; from the last sample on there is no step but the one to it.
        for (time_s, sample) in [(0.26, 5), (0.0, 0), (0.9, 18), (0.95, 18)] {
            let plan = planner
                .plan(&ends.clone().velocity_at(time_s, some))
                .unwrap();
            let found = state(motion(&plan), sample).velocity.0[Finger::Index].unwrap();
            for (found, wanted) in found.iter().zip([0.02, -0.01, 0.03]) {
                assert!((found - wanted).abs() < 1e-9, "{found} {wanted}");
            }
        }
        // The same twice is nothing new; another one is a contradiction.
        let once = ends.clone().velocity_at(0.26, some);
        let twice = once.clone().velocity_at(0.24, some);
        assert_eq!(planner.plan(&once), planner.plan(&twice));
        some[Finger::Index] = Some([0.02, 0.01, 0.03]);
        let error = planner.plan(&once.velocity_at(0.24, some)).unwrap_err();
        assert_eq!(
            error.to_string(),
            "target: index is wanted to move at [0.02, -0.01, 0.03] and at [0.02, 0.01, 0.03] m/s \
             from the same sample 5 (0.25 s) on: expected one velocity"
        );
        some[Finger::Index] = Some([0.02, f64::NAN, 0.03]);
        let error = planner.plan(&ends.velocity_at(0.24, some)).unwrap_err();
        assert!(
            error
                .to_string()
                .contains("velocity on the way of index, axis 1, is NaN")
        );
    }
}

#[test]
fn end_conditions_follow_from_what_is_given_of_the_way() {
    let residual = residual(25, 12, false);
    let layout = residual.layout;
    // Velocities at the ends are open; first and last step and a point on the way tell of them.
    let (first, last) = (there(0.02, 0.0), there(0.02, 1.0));
    let (slow, fast, via) = ([0.01; 15], [0.05; 15], there(0.02, 0.4));
    let target = Target::new()
        .first(first)
        .last(last)
        .velocity_at(0.0, slow)
        .velocity_at(0.92, fast)
        .waypoint(0.48, via);
    // The smooth curve's Gaussian, with the deviation (of its own spread, and expected at first
    // nowhere, then where the first conclusion has it) as noise.
    let conclusion = |expected: &DVector<f64>| {
        let mut all = Gaussian::of_residual(&residual, &residual.ends_mean);
        all.mean.rows_mut(60, 12).copy_from(&(expected * 1e3));
        let configuration = |t: usize| all.coordinates(&Vec::from_iter(15 * t..15 * (t + 1)));
        let steps = all.differences(1);
        let step = |t: usize| Rows {
            factors: steps.factors.rows(15 * t, 15).into_owned(),
            base: steps.base.rows(15 * t, 15).into_owned(),
        };
        let (rows, wanted) = stacked(&[
            (configuration(0), &first[..]),
            (configuration(24), &last[..]),
        ]);
        let given = all.given(&rows, &wanted, 0.0);
        let (rows, wanted) = stacked(&[
            (configuration(12), &via[..]),
            (step(0), &slow[..]),
            (step(23), &fast[..]),
        ]);
        given.given(&rows, &wanted, 0.1).mean.rows(0, 60) * 1e-3
    };
    let straight = conclusion(&DVector::zeros(12));
    let likely = conclusion(&residual.expected_m(&straight));
    let mut all = Gaussian::of_residual(&residual, &likely);
    assert_eq!(all.layout, layout);
    let configuration = |t: usize| all.coordinates(&Vec::from_iter(15 * t..15 * (t + 1)));
    let steps = all.differences(1);
    let step = |t: usize| Rows {
        factors: steps.factors.rows(15 * t, 15).into_owned(),
        base: steps.base.rows(15 * t, 15).into_owned(),
    };
    let (places, wanted_places) = stacked(&[
        (configuration(0), &first[..]),
        (configuration(12), &via[..]),
        (configuration(24), &last[..]),
    ]);
    let (speeds, wanted_speeds) = stacked(&[(step(0), &slow[..]), (step(23), &fast[..])]);
    all = all.given(&places, &wanted_places, 0.1);
    let expected = all.given(&speeds, &wanted_speeds, 0.1).motion();
    let planner = Planner::residual(&residual, &soft(100.0)).unwrap();
    let plan = planner.plan(&target).unwrap();
    for (row, value) in motion(&plan).values_m().iter().enumerate() {
        let away = (value - expected[row] * 1e-3).abs();
        assert!(away < 1e-8, "row {row}: {away}");
    }
}
