//! Chains of segments: continuous, through every knot, and the answer "no".

use inhand_model::{
    ConstraintFamily, Dictionary, DictionaryKind, Finger, PerFinger, Plan, PlanStatus, Trajectory,
};
use inhand_planner::{
    AccelerationBounds, Chain, Ends, Knot, Method, Planner, PlannerSettings, Tips, plan_chain,
};
use proptest::prelude::*;

use crate::support::{bounds, free, residual, settings};

/// Samples a segment; at 20 Hz, so that one lasts 0.95 s.
const SAMPLES: usize = 20;
const RATE_HZ: f64 = 20.0;
/// Intervals a segment: joints lie at multiples.
const STEPS: usize = SAMPLES - 1;

fn loose() -> PlannerSettings {
    settings(bounds(100.0))
}

/// A smooth curve with a deviation, principal components, and an NMF dictionary, none of which is
/// short of freedom.
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

/// Where a finger is on a smooth way, metres.
fn way(sample: usize, finger: Finger) -> [f64; 3] {
    let (t, f) = (sample as f64 / RATE_HZ, finger.index() as f64);
    [0.0, 1.0, 2.0].map(|axis| 0.05 + 0.01 * (1.7 * t + 1.1 * f + 2.0 * axis).sin())
}

fn tips(given: impl Fn(Finger) -> Option<[f64; 3]>) -> Tips {
    Tips(PerFinger::from_fn(given))
}

/// A knot on the way, for all fingers.
fn knot(sample: usize) -> Knot {
    Knot {
        time_s: sample as f64 / RATE_HZ,
        tips: tips(|finger| Some(way(sample, finger))),
        velocity: Tips::default(),
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).abs()).fold(0.0, f64::max)
}

fn step(trajectory: &Trajectory, from: usize, finger: Finger) -> [f64; 3] {
    let [a, b] = [from, from + 1].map(|t| trajectory.position(t, finger).to_array());
    [0, 1, 2].map(|axis| (b[axis] - a[axis]) * RATE_HZ)
}

/// Every plan is proven, segments meet, and the whole passes all knots. `same` says of which joints
/// the velocities have to be one and the same.
fn assert_chain(chain: &Chain, knots: &[Knot], same: impl Fn(usize) -> bool) {
    let solved = |plan: &Plan| plan.status == PlanStatus::Solved;
    assert!(chain.plans.iter().all(solved));
    let last = (knots.last().expect("there are knots").time_s * RATE_HZ).round() as usize;
    assert_eq!(chain.plans.len(), last.div_ceil(STEPS));
    let whole = chain.trajectory.as_ref().expect("a solved plan has one");
    assert_eq!(whole.layout().samples, last + 1);
    let segments: Vec<_> = (chain.plans.iter())
        .map(|plan| {
            assert!(plan.certificate.worst() <= 1e-6, "{:?}", plan.certificate);
            plan.trajectory.as_ref().expect("a solved plan has one")
        })
        .collect();
    for (i, start_s) in chain.starts_s.iter().enumerate() {
        assert!((start_s - (i * STEPS) as f64 / RATE_HZ).abs() < 1e-12);
    }
    for finger in Finger::ALL {
        for (i, pair) in segments.windows(2).enumerate() {
            let [a, b] = [(pair[0], STEPS), (pair[1], 0)]
                .map(|(segment, t)| segment.position(t, finger).to_array());
            assert!(distance(a, b) < 1e-12, "joint {i}: {}", distance(a, b));
            let [a, b] = [step(pair[0], STEPS - 1, finger), step(pair[1], 0, finger)];
            if same(i) {
                assert!(distance(a, b) < 1e-9, "joint {i}: {}", distance(a, b));
            }
        }
        for knot in knots {
            let sample = (knot.time_s * RATE_HZ).round() as usize;
            let found = whole.position(sample, finger).to_array();
            if let Some(wanted) = knot.tips.0[finger] {
                let away = distance(found, wanted);
                assert!(away < 1e-12, "{finger} at {sample}: {away}");
            }
            if let (Some(wanted), true) = (knot.velocity.0[finger], sample > 0 && sample < last) {
                let away = distance(step(whole, sample, finger), wanted);
                assert!(away < 1e-9, "{finger} at {sample}: {away}");
            }
        }
        for t in 0..=last {
            let i = (t / STEPS).min(segments.len() - 1);
            let own = segments[i].position(t - i * STEPS, finger).to_array();
            assert!(distance(own, whole.position(t, finger).to_array()) < 1e-12);
        }
    }
}

#[test]
fn one_segment_two_and_three_point_four() {
    for planner in planners(&loose()) {
        for samples in [
            vec![0, 19],
            vec![0, 10, 19],
            // A joint without a knot, and with one.
            vec![0, 30, 38],
            vec![0, 19, 38],
            // Knots at joints, in between, and a last one before its segment's end.
            vec![0, 7, 19, 26, 45, 57, 65],
            vec![0, 65],
        ] {
            let knots: Vec<_> = samples.iter().map(|&sample| knot(sample)).collect();
            let chain = plan_chain(&planner, &knots).unwrap();
            assert_chain(&chain, &knots, |_| true);
        }
    }
}

#[test]
fn knots_beside_joints_decide_the_velocity_there() {
    for planner in planners(&loose()) {
        for (samples, same) in [
            (vec![0, 18, 30], true),
            (vec![0, 20, 30], true),
            (vec![0, 18, 19, 30], true),
            (vec![0, 19, 20, 30], true),
            (vec![0, 18, 20, 30], true),
            // Three in a row need not lie on a line.
            (vec![0, 18, 19, 20, 30], false),
            (vec![0, 17, 21, 30], true),
        ] {
            let knots: Vec<_> = samples.iter().map(|&sample| knot(sample)).collect();
            let chain = plan_chain(&planner, &knots).unwrap();
            assert_chain(&chain, &knots, |_| same);
        }
    }
}

#[test]
fn velocities_given_at_knots_are_those_of_the_motion() {
    for planner in planners(&loose()) {
        // At a joint (19), beside one (37), elsewhere, and at a last knot before its segment's end.
        for samples in [
            [0, 8, 19, 50],
            [0, 18, 30, 50],
            [0, 20, 37, 38],
            [0, 5, 37, 50],
        ] {
            let mut knots = samples.map(knot);
            for (i, knot) in knots.iter_mut().enumerate().skip(1) {
                knot.velocity = tips(|finger| {
                    (finger != Finger::Ring).then_some([0.01, -0.005 * i as f64, 0.0])
                });
            }
            // A sample before the next knot, positions say it all.
            if samples[2] + 1 == samples[3] {
                knots[2].velocity = Tips::default();
                knots[3].velocity = Tips::default();
            }
            let chain = plan_chain(&planner, &knots).unwrap();
            assert_chain(&chain, &knots, |_| true);
        }
    }
}

#[test]
fn a_chain_of_one_segment_is_its_plan() {
    for planner in planners(&PlannerSettings {
        ends: Ends::Hard,
        ..loose()
    }) {
        let mut knots = [knot(0), knot(9), knot(19)];
        knots[0].velocity = tips(|_| Some([0.02; 3]));
        knots[2].velocity = tips(|_| Some([-0.01; 3]));
        let target = inhand_planner::Target::new()
            .first(knots[0].tips)
            .first_velocity(knots[0].velocity)
            .waypoint(0.45, knots[1].tips)
            .last(knots[2].tips)
            .last_velocity(knots[2].velocity);
        let chain = plan_chain(&planner, &knots).unwrap();
        assert_eq!(chain.plans, [planner.plan(&target).unwrap()]);
    }
}

#[test]
fn fingers_that_no_knot_gives_go_on_from_segment_to_segment() {
    for planner in planners(&loose()) {
        let given = |sample: usize, fingers: &[Finger]| Knot {
            tips: tips(|finger| fingers.contains(&finger).then(|| way(sample, finger))),
            ..knot(sample)
        };
        // The thumb always, the index from the second segment on, the middle at first, the others
        // never.
        let knots = [
            given(0, &[Finger::Thumb, Finger::Middle]),
            given(10, &[Finger::Thumb, Finger::Middle]),
            given(24, &[Finger::Thumb, Finger::Index]),
            given(40, &[Finger::Thumb, Finger::Index]),
            given(60, &[Finger::Thumb]),
        ];
        let chain = plan_chain(&planner, &knots).unwrap();
        assert_chain(&chain, &knots, |_| true);
        // None runs away.
        let whole = chain.trajectory.unwrap();
        for value in whole.values_m() {
            assert!(value.abs() < 0.5, "{value}");
        }
    }
}

#[test]
fn soft_planners_make_chains_that_are_exact() {
    let planner = planner(0, &loose());
    assert!(!planner.is_exact());
    let knots = [knot(0), knot(12), knot(30)];
    let exact = planner.clone().exact().unwrap();
    assert!(exact.is_exact());
    assert_eq!(
        plan_chain(&planner, &knots).unwrap(),
        plan_chain(&exact, &knots).unwrap()
    );
}

#[test]
fn bounds_hold_across_joints() {
    let reach = AccelerationBounds {
        min_m_s2: [-0.045; 15],
        max_m_s2: [0.045; 15],
    };
    let mut tight = settings(bounds(0.0185));
    tight.constraints.acceleration = Some(reach);
    for planner in planners(&tight) {
        let knots = [knot(0), knot(10), knot(25), knot(50)];
        let chain = plan_chain(&planner, &knots).unwrap();
        assert_chain(&chain, &knots, |_| true);
        let (velocity, acceleration) = (ConstraintFamily::Velocity, ConstraintFamily::Acceleration);
        let active = |family| -> usize {
            (chain.plans.iter())
                .map(|plan| plan.checks.active[family])
                .sum()
        };
        assert!(active(velocity) + active(acceleration) > 0);
        let whole = chain.trajectory.unwrap();
        for finger in Finger::ALL {
            let steps: Vec<_> = (0..50).map(|t| step(&whole, t, finger)).collect();
            for (t, pair) in steps.windows(2).enumerate() {
                for (now, next) in pair[0].into_iter().zip(pair[1]) {
                    assert!(now.abs() <= 0.0185 * (1.0 + 1e-6), "{t}: {now}");
                    let change = (next - now).abs() * RATE_HZ;
                    assert!(change <= 0.045 * (1.0 + 1e-6), "{t}: {change}");
                }
            }
        }
    }
}

#[test]
fn what_cannot_be_planned_ends_the_chain_and_says_why() {
    for planner in planners(&settings(bounds(0.1))) {
        // From sample 40 to 45 by half a metre a second.
        let mut knots = [0, 10, 19, 30, 40, 45, 60].map(knot);
        knots[4].velocity = tips(|_| Some([0.0; 3]));
        knots[5].tips.0[Finger::Index].as_mut().unwrap()[1] += 0.125;
        let chain = plan_chain(&planner, &knots).unwrap();
        assert_eq!(chain.trajectory, None);
        assert_eq!(chain.starts_s.len(), 3);
        let [first, second, failed] = &chain.plans[..] else {
            panic!("three segments, not {}", chain.plans.len());
        };
        assert_eq!([first.status, second.status], [PlanStatus::Solved; 2]);
        assert_eq!(failed.status, PlanStatus::Infeasible);
        assert!(!failed.relaxations.is_empty());
        // Dictionaries that can do any motion could do it faster.
        if planner.method().is_some() {
            let velocity = (failed.relaxations.iter())
                .find(|relaxation| relaxation.family == ConstraintFamily::Velocity)
                .map(|relaxation| relaxation.by);
            assert!(
                velocity.is_some_and(|by| by > 0.3 && by < 0.6),
                "{velocity:?}"
            );
        }
    }
}

#[test]
fn knots_that_make_no_chain_are_refused() {
    let planner = planner(0, &loose());
    let at = |time_s: f64| Knot { time_s, ..knot(0) };
    let mut nan = [knot(0), knot(19), knot(30)];
    nan[1].tips.0[Finger::Ring] = Some([0.0, f64::NAN, 0.0]);
    let mut far = [knot(0), knot(19), knot(30)];
    far[2].tips.0[Finger::Ring] = Some([50.0, 0.0, 0.0]);
    let mut fast = [knot(0), knot(19), knot(30)];
    fast[1].velocity.0[Finger::Thumb] = Some([0.0, 0.0, 4000.0]);
    let mut other = [knot(0), knot(18), knot(19)];
    other[1].velocity.0[Finger::Thumb] = Some([0.5, 0.0, 0.0]);
    // So far within a sample that the way there and back leads out of what is allowed.
    let mut jump = [knot(0), knot(37), knot(38), knot(60)];
    jump[2].tips = tips(|_| Some([9.0, 0.0, 0.0]));
    for (knots, expected) in [
        (vec![], "knot 0 at 0 s: expected at least two knots"),
        (vec![at(0.0)], "knot 1 at 0 s: expected at least two knots"),
        (
            vec![at(0.1), at(1.0)],
            "knot 0 at 0.1 s: expected the first at 0 s",
        ),
        (
            vec![at(0.0), at(1.0), at(1.0)],
            "knot 2 at 1 s: expected a time later than 1 s by a sample (0.05 s)",
        ),
        (
            vec![at(0.0), at(1.0), at(0.5)],
            "knot 2 at 0.5 s: expected a time later than 1 s",
        ),
        (
            vec![at(0.0), at(1.0), at(1.01)],
            "knot 2 at 1.01 s: expected a time later than 1 s",
        ),
        (
            vec![at(0.0), at(f64::NAN)],
            "knot 1 at NaN s: expected a time from 0 to 3600 s",
        ),
        (
            vec![at(0.0), at(f64::INFINITY)],
            "knot 1 at inf s: expected a time from 0 to 3600 s",
        ),
        (vec![at(0.0), at(-1.0)], "knot 1 at -1 s"),
        (vec![at(0.0), at(1e300)], "expected a time from 0 to 3600 s"),
        (
            nan.to_vec(),
            "knot 1 at 0.95 s: target: position of ring, axis 1, is NaN: \
             expected a number of at most 10 in size",
        ),
        (
            far.to_vec(),
            "knot 2 at 1.5 s: target: position of ring, axis 0, is 50",
        ),
        (
            fast.to_vec(),
            "knot 1 at 0.95 s: target: velocity of thumb, axis 2, is 4000: \
             expected a number of at most 100",
        ),
        (
            other.to_vec(),
            "knot 1 at 0.9 s: expected the velocity of thumb that leads to the next knot",
        ),
        (
            jump.to_vec(),
            "segment 0 of the chain, from 0 s on: target: last configuration of thumb, axis 0, is -62",
        ),
    ] {
        let error = plan_chain(&planner, &knots).unwrap_err();
        assert!(error.to_string().contains(expected), "{error}");
    }
    // Fingers that no knot gives leave nothing to plan.
    let nobody = [0.0, 1.0].map(|time_s| Knot {
        time_s,
        tips: Tips::default(),
        velocity: Tips::default(),
    });
    let error = plan_chain(&planner, &nobody).unwrap_err();
    assert!(error.to_string().starts_with("segment 0"), "{error}");
    let short = free(2, RATE_HZ, |_| 0.05);
    let planner = Planner::new(&short, Method::Prior, &loose()).unwrap();
    let error = plan_chain(&planner, &[knot(0), knot(1)]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "segments of 2 samples make no chain: expected at least 3"
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn any_knots_are_passed(
        gaps in prop::collection::vec(1_usize..30, 1..6),
        given in prop::collection::vec(0_u8..32, 6),
    ) {
        let planner = planner(0, &loose());
        let mut sample = 0;
        let mut knots = vec![knot(0)];
        for (gap, fingers) in gaps.into_iter().zip(given) {
            sample += gap;
            knots.push(Knot {
                tips: tips(|f| (fingers >> f.index() & 1 == 1).then(|| way(sample, f))),
                ..knot(sample)
            });
        }
        let chain = plan_chain(&planner, &knots).unwrap();
        // Velocities are one and the same but where three knots in a row say otherwise.
        assert_chain(&chain, &knots, |_| false);
    }
}
