//! An evaluation as a session of six takes gives it: numbers of the right size and shape from
//! closed forms, so that they are the same everywhere.

#[path = "sample_motion.rs"]
mod motion;

use inhand_model::{
    Bandwidths, BodySource, Collision, ConstraintFamily, ContactShare, CorridorCoverage,
    DeviationFacts, DictionaryFacts, DictionaryKind, Evaluation, FamilyFacts, Finding, Finger,
    FingerGaps, HandAndFingers, HeldOutEvaluation, InputHash, Inspection, LengthUnit, Level,
    MethodCandidate, MethodChoice, MethodEvaluation, ObjectError, PerFinger, PlanFacts,
    PredictorWeights, Protocol, Provenance, Reachability, Roles, RotationOrder, SessionFacts,
    SessionFinding, SmoothCurve, Statistics, StopReason, TakeFacts, TakeQuality, TakeSource,
    TauShare, TrackCounts, TrackQuality, UpAxis, Validation, VelocityBounds, VelocityCheck,
};

const SEGMENTS: usize = 119;
const SAMPLES: usize = 100;

/// Name, description, baseline, median (m), tail, three-contact share.
type Kind = (&'static str, &'static str, bool, f64, f64, f64);

const METHODS: [Kind; 7] = [
    (
        "residual",
        "cubic and learned deviation from it",
        false,
        0.000_403,
        1.2,
        0.992,
    ),
    (
        "prior",
        "start + end, NMF 200",
        false,
        0.000_79,
        0.85,
        0.991,
    ),
    (
        "paper",
        "end only, as published",
        false,
        0.004_2,
        0.62,
        0.784,
    ),
    (
        "hold",
        "the final configuration, held",
        true,
        0.001_8,
        1.2,
        0.93,
    ),
    (
        "line",
        "straight between start and end",
        true,
        0.000_73,
        1.0,
        0.989,
    ),
    (
        "minimum_jerk",
        "minimum jerk between start and end",
        true,
        0.000_74,
        1.0,
        0.988,
    ),
    ("hermite", "cubic, no learning", true, 0.000_40, 1.4, 0.987),
];

/// Type-7 quantiles and 1.5 IQR whiskers of the values.
pub(crate) fn statistics(mut values: Vec<f64>) -> Statistics {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    let quantile = |p: f64| {
        let place = p * (n - 1) as f64;
        let low = place.floor() as usize;
        let high = (low + 1).min(n - 1);
        values[low] + (place - low as f64) * (values[high] - values[low])
    };
    let (p25, p75) = (quantile(0.25), quantile(0.75));
    let reach = 1.5 * (p75 - p25);
    Statistics {
        n,
        n_filled: n / 500,
        n_left_out: 0,
        mean: values.iter().sum::<f64>() / n as f64,
        rmse: (values.iter().map(|v| v * v).sum::<f64>() / n as f64).sqrt(),
        min: values[0],
        p5: quantile(0.05),
        p25,
        p50: quantile(0.5),
        p75,
        p95: quantile(0.95),
        max: values[n - 1],
        whisker_low: *values
            .iter()
            .find(|v| **v >= p25 - reach)
            .expect("the quartiles lie among the values"),
        whisker_high: *values
            .iter()
            .rev()
            .find(|v| **v <= p75 + reach)
            .expect("the quartiles lie among the values"),
    }
}

/// `n` values whose logarithm is logistic: median as given, a long tail to the right.
fn skewed(n: usize, median: f64, tail: f64) -> Statistics {
    let values = (0..n).map(|k| {
        let p = (k as f64 + 0.5) / n as f64;
        median * (tail * 0.55 * (p / (1.0 - p)).ln()).exp().min(28.0)
    });
    statistics(values.collect())
}

fn finger_factor(finger: Finger) -> f64 {
    [0.9, 1.0, 1.05, 1.15, 0.95][finger.index()]
}

fn method(kind: &Kind, object: bool) -> MethodEvaluation {
    let &(name, description, baseline, median, tail, share) = kind;
    let n = SEGMENTS * SAMPLES;
    let shape = |s: usize| {
        let t = s as f64 / (SAMPLES - 1) as f64;
        match name {
            "paper" => 1.4 - 1.3 * t * t,
            "hold" => 2.0 * (1.0 - t),
            _ => 1.6 * (4.0 * t * (1.0 - t)).powf(0.8),
        }
    };
    let at_tau = |tau_m: f64, full: f64| full * (1.0 - (-(tau_m / 0.001_6).powi(2)).exp());
    let contact = object.then(|| ContactShare {
        n,
        n_filled: n / 500,
        n_left_out: 0,
        tau_m: 0.005,
        three_or_more: at_tau(0.005, share),
        recorded_three_or_more: at_tau(0.005, 0.999_97),
        by_finger: PerFinger::from_fn(|f| share * (1.0 - 0.03 * f.index() as f64)),
        recorded_by_finger: PerFinger::from_fn(|f| 1.0 - 0.025 * f.index() as f64),
        by_tau: (1..=20)
            .map(|k| 0.000_5 * f64::from(k))
            .map(|tau_m| TauShare {
                tau_m,
                three_or_more: at_tau(tau_m, share),
                recorded_three_or_more: at_tau(tau_m, 0.999_97),
            })
            .collect(),
    });
    MethodEvaluation {
        name: name.to_owned(),
        description: description.to_owned(),
        baseline,
        error: HandAndFingers {
            all: skewed(5 * n, median, tail),
            by_finger: PerFinger::from_fn(|f| skewed(n, median * finger_factor(f), tail)),
        },
        error_at_start: skewed(5 * SEGMENTS, median * shape(0).max(0.02), tail),
        error_at_goal: skewed(5 * SEGMENTS, median * shape(SAMPLES - 1).max(0.02), tail),
        median_error_by_sample_m: (0..SAMPLES).map(|s| median * shape(s)).collect(),
        reachability: Reachability {
            n,
            inside: PerFinger::from_fn(|f| 0.999_9 - 0.004 * f.index() as f64),
            worst_outside_m: PerFinger::from_fn(|f| 0.000_8 * f.index() as f64),
            distance: PerFinger::from_fn(|f| {
                let values =
                    (0..n).map(|k| 0.000_8 * f.index() as f64 - 0.02 * k as f64 / n as f64);
                statistics(values.collect())
            }),
            recorded_inside: PerFinger::from_fn(|f| 0.998 - 0.003 * f.index() as f64),
        },
        collision: Collision {
            n,
            limit_m: 0.01,
            instants: if baseline { 3 } else { 2 },
            trajectories: 1,
            nearest_m: 0.009_31,
            nearest_pair: Some((Finger::Ring, Finger::Little)),
            recorded_instants: 2,
            recorded_nearest_m: 0.009_58,
        },
        velocity: VelocityCheck {
            n: SEGMENTS * (SAMPLES - 1) * 15,
            outside: if baseline { 12 } else { 0 },
            trajectories_outside: if baseline { 3 } else { 0 },
            worst_ratio: if baseline { 1.134_2 } else { 1.0 },
        },
        contact,
        distance_difference: object.then(|| {
            PerFinger::from_fn(|finger| skewed(n, 0.6 * median * finger_factor(finger), tail))
        }),
        object_error: (object && !baseline && name != "paper").then(|| ObjectError {
            position: skewed(n, 0.8 * median, tail),
            angle: skewed(n, 20.0 * median, tail),
        }),
        corridors: if baseline || name == "paper" {
            Vec::new()
        } else {
            // The second learned method knows less than it claims.
            let less = if name == "prior" { 0.04 } else { 0.0 };
            [(0.5, 1.61, 0.52), (0.95, 3.02, 0.941)]
                .map(
                    |(share_stated, mahalanobis, share_inside)| CorridorCoverage {
                        share_stated,
                        mahalanobis,
                        n: 5 * n,
                        n_filled: n / 100,
                        n_left_out: 0,
                        share_inside: HandAndFingers {
                            all: share_inside - less,
                            by_finger: PerFinger::from_fn(|f| {
                                share_inside - less - 0.005 * (f.index() as f64 - 2.0)
                            }),
                        },
                    },
                )
                .into()
        },
        plan: (!baseline).then_some(PlanFacts {
            solved: SEGMENTS,
            infeasible: 0,
            failed: 0,
            worst_kkt_residual: 3.1e-9,
            velocity_bound_active: 4,
            families: families(name),
            outside_hull: Some(9),
        }),
    }
}

/// Families of constraints that were on, and what they did.
fn families(name: &str) -> Vec<FamilyFacts> {
    let facts = |family, active, worst_violation| FamilyFacts {
        family,
        active,
        worst_violation,
        would_mend: 0,
        largest_relaxation: 0.0,
    };
    let velocity = facts(ConstraintFamily::Velocity, 4, 2.0e-12);
    match name {
        "residual" => vec![
            velocity,
            facts(ConstraintFamily::Acceleration, 0, -0.41),
            facts(ConstraintFamily::Separation, 2, 0.0),
        ],
        _ => vec![
            facts(ConstraintFamily::Activations, SEGMENTS, 0.0),
            velocity,
        ],
    }
}

fn take(name: &str, left_out: usize) -> TakeFacts {
    TakeFacts {
        name: name.to_owned(),
        samples: 12_000,
        duration_s: 120.0,
        segments: SEGMENTS - left_out,
        left_out,
        left_out_by: (left_out > 0)
            .then(|| ("ring".to_owned(), left_out))
            .into_iter()
            .collect(),
        source: Some(source(left_out)),
    }
}

fn source(left_out: usize) -> TakeSource {
    let body = |name: &str| BodySource::RigidBody(name.to_owned());
    let missing = |finger| left_out > 0 && finger == Finger::Ring;
    TakeSource {
        format: "Motive CSV 1.23".to_owned(),
        rate_hz: 100.0,
        length_unit: LengthUnit::Millimetres,
        up_axis: UpAxis::Y,
        rotation: Some(RotationOrder::Quaternion),
        roles: Some(Roles {
            hand: body("RightHand"),
            object: Some(body("cube 5")),
            fingers: PerFinger::from_fn(|finger| format!("RightHand:{finger}")),
        }),
        hand_tracked: Some(if left_out > 0 { 0.998 } else { 1.0 }),
        object_tracked: Some(1.0),
        gaps: PerFinger::from_fn(|finger| match missing(finger) {
            true => FingerGaps {
                missing: 0.021,
                longest_s: 0.31,
            },
            false => FingerGaps::default(),
        }),
    }
}

fn take_quality(place: usize, role: &str) -> TakeQuality {
    let gap = |finger: Finger| match (place, finger) {
        (1, Finger::Ring) => 252,
        (1, Finger::Little) => 31,
        (3, Finger::Thumb) => 8,
        _ => 0,
    };
    TakeQuality {
        take: format!("cube_{place:02}"),
        role: role.to_owned(),
        fingers: PerFinger::from_fn(|f| {
            let filled = gap(f).min(80);
            let counts = |filled| TrackCounts {
                measured: 12_000 - gap(f),
                filled,
                missing: gap(f) - filled,
            };
            TrackQuality {
                recorded: counts(0),
                processed: counts(filled),
                longest_gap_s: match gap(f) {
                    81.. => 0.31,
                    gap => 0.01 * gap.min(6) as f64,
                },
            }
        }),
        hand_tracked: if place == 1 { 0.998 } else { 1.0 },
        object_tracked: Some(1.0),
        findings: match place {
            1 => vec![
                Finding::warning(
                    "ring",
                    "3 gaps longer than 0.10 s (12.31 s, 48.02 s, 77.90 s) stay open",
                ),
                Finding::info("", "start time without a zone, taken as UTC"),
            ],
            _ => vec![],
        },
    }
}

/// The evaluation of a cube session, with contacts unless `object` is false.
pub(crate) fn evaluation(object: bool) -> Evaluation {
    let names: Vec<String> = (0..6).map(|place| format!("cube_{place:02}")).collect();
    Evaluation {
        session: SessionFacts {
            name: "cube".to_owned(),
            rate_hz: 100.0,
            segment_samples: SAMPLES,
            object: object.then(|| "cube:0.05".to_owned()),
            participant: Some("P07".to_owned()),
            task: None,
            train: (0..5)
                .map(|place| take(&names[place], if place == 1 { 5 } else { 0 }))
                .collect(),
            test: vec![take(&names[5], 0)],
        },
        default_method: "residual".to_owned(),
        choice: Some(MethodChoice {
            protocol: Protocol::HeldOut,
            method: "residual".to_owned(),
            candidates: vec![
                MethodCandidate {
                    name: "residual".to_owned(),
                    mean_error_m: 0.000_629,
                },
                MethodCandidate {
                    name: "prior".to_owned(),
                    mean_error_m: 0.001_08,
                },
                MethodCandidate {
                    name: "hermite".to_owned(),
                    mean_error_m: 0.000_727,
                },
            ],
            gain_m: Some(0.000_098),
            gain_standard_error_m: Some(0.000_009),
            folds: 5,
            segments: 590,
        }),
        dictionary: DictionaryFacts {
            kind: DictionaryKind::Nmf,
            rank: 200,
            segments: 590,
            rms_m: 0.000_143,
            relative_error: 0.003_1,
            iterations: 40,
            stop_reason: StopReason::IterationLimit,
            objective_history_m2: (0..=40)
                .map(|iteration| 0.009_05 + 45.0 * (-0.9 * f64::from(iteration).sqrt() * 1.9).exp())
                .collect(),
            velocity_bounds: VelocityBounds {
                min_m_s: std::array::from_fn(|row| -0.21 - 0.01 * row as f64),
                max_m_s: std::array::from_fn(|row| 0.23 + 0.01 * row as f64),
            },
            deviation: Some(DeviationFacts {
                primitives: 140,
                demonstrations: 590,
                weights: PredictorWeights {
                    profile: 0.82,
                    hand: 0.36,
                    finger: 0.54,
                },
                bandwidths: Bandwidths {
                    hand: 2.0,
                    finger: 0.5,
                },
                curve: SmoothCurve::Hermite,
                validation: Validation {
                    folds: 5,
                    segments: 590,
                    smooth_error_m: 0.000_727,
                    error_m: 0.000_629,
                    standard_error_m: 0.000_009,
                },
            }),
        },
        methods: METHODS.iter().map(|kind| method(kind, object)).collect(),
        held_out: Some(held_out(object)),
        filter_moves: Some(HandAndFingers {
            all: skewed(5 * SEGMENTS * SAMPLES, 0.000_29, 0.5),
            by_finger: PerFinger::from_fn(|f| {
                skewed(SEGMENTS * SAMPLES, 0.000_29 * finger_factor(f), 0.5)
            }),
        }),
        quality: (0..6)
            .map(|place| take_quality(place, if place < 5 { "train" } else { "test" }))
            .collect(),
        intervals: None,
        movement: Some(motion::movement()),
        contacts: object.then(motion::contacts),
        inspection: Some(inspection()),
        key: None,
    }
}

/// The same methods with larger errors, on one segment less.
fn held_out(object: bool) -> HeldOutEvaluation {
    let methods = METHODS
        .iter()
        .map(|&(name, description, baseline, median, tail, share)| {
            let kind = (name, description, baseline, 1.5 * median, tail, share);
            method(&kind, object)
        });
    HeldOutEvaluation {
        ends_s: 0.08,
        ends_samples: 8,
        segments: SEGMENTS - 1,
        left_out: 1,
        deviation: None,
        methods: methods.collect(),
        intervals: None,
    }
}

/// Two checks, of which one found something.
fn inspection() -> Inspection {
    Inspection {
        checks: vec!["units".to_owned(), "swaps".to_owned()],
        findings: vec![SessionFinding {
            id: "swaps".to_owned(),
            level: Level::Warn,
            accepted: false,
            takes: vec!["cube_train_02".to_owned()],
            entity: "index and middle".to_owned(),
            places_s: vec![[1.0, 1.5]],
            found: "2 suspected swaps".to_owned(),
            advice: "look at it in a viewer".to_owned(),
        }],
    }
}

/// Three steps with settings and inputs.
pub(crate) fn provenance() -> Vec<Provenance> {
    let hash = |seed: usize| {
        (0..64)
            .map(|k| char::from_digit(((k * 7 + seed * 13) % 16) as u32, 16).unwrap_or('0'))
            .collect()
    };
    let inputs = |count: usize| {
        (0..count)
            .map(|k| InputHash {
                name: format!("cube_{k:02}.csv"),
                sha256: hash(k),
            })
            .collect()
    };
    [("process", 6), ("learn", 5), ("evaluate", 1)]
        .map(|(step, count)| Provenance {
            tool: "inhand 0.1.0".to_owned(),
            step: step.to_owned(),
            settings_json: r#"{"gap_limit_s":0.1,"filter":{"kind":"median","window":50},"rank":200,"tau_m":0.005}"#.to_owned(),
            inputs: inputs(count),
        })
        .into()
}
