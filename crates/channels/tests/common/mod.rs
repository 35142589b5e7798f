//! A take made in memory, the same at every call: a hand that sways, an object that turns in it,
//! fingers that follow, gaps, qualities and names as real sources have them.

#![allow(dead_code, reason = "tests, bench and example each use a part")]
#![allow(
    clippy::allow_attributes,
    reason = "what is unused differs from one user to the next"
)]

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use inhand_channels::{
    ContactSample, EvaluatedMethod, EvaluatedSample, GeneratedMethod, GeneratedSegment, TakeFile,
};
use inhand_model::{
    Bandwidths, Body, BodyKind, BodySource, Calibration, Certificate, Clock, ConstraintFamily,
    Demonstrated, DeviationPredictor, Dictionary, DictionaryKind, Finding, Finger, Hand, Hull,
    InputHash, Learning, LengthUnit, Marker, MarkerKind, MethodCandidate, MethodChoice, Motion,
    Object, PerFamily, PerFinger, Plan, PlanChecks, PlanStatus, PointTrack, Pose, PoseTrack,
    Position, PredictorWeights, Protocol, Provenance, Recording, Relaxation, Residual, Restart,
    Roles, RotationOrder, SEGMENT_COORDINATES, SegmentLayout, Shape, SmoothCurve, Source,
    StartTime, Status, StopReason, TrackedBody, Trajectory, UpAxis, Validation, VelocityBounds,
    World, ends_len,
};
use nalgebra::{DMatrix, DVector, Isometry3, Translation3, UnitQuaternion, Vector3};

/// Everything that `TakeFile` borrows.
pub(crate) struct Take {
    pub(crate) recording: Recording,
    pub(crate) roles: Roles,
    pub(crate) motion: Motion,
    pub(crate) trajectories: Vec<(usize, Trajectory, Plan)>,
    pub(crate) provenance: Vec<Provenance>,
}

/// Small reproducible noise, -1 to 1.
fn noise(n: usize) -> f64 {
    let mut x = (n as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((x >> 11) as f64 / (1u64 << 52) as f64) - 1.0
}

fn hand_pose(t_s: f64) -> Isometry3<f64> {
    let sway = (TAU * 0.11 * t_s).sin();
    Isometry3::from_parts(
        Translation3::new(0.3 + 0.05 * sway, 1.1 + 0.02 * sway, -0.2),
        UnitQuaternion::from_euler_angles(0.2 * sway, 0.1, 0.3 * sway),
    )
}

fn object_in_hand(t_s: f64) -> Isometry3<f64> {
    Isometry3::from_parts(
        Translation3::new(0.09, -0.02, 0.005 * (TAU * 0.3 * t_s).sin()),
        UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.4 * (TAU * 0.25 * t_s).sin()),
    )
}

fn tip_in_hand(finger: Finger, t_s: f64) -> Vector3<f64> {
    let n = finger.index() as f64;
    let base = if finger == Finger::Thumb {
        Vector3::new(0.09, -0.045, -0.01)
    } else {
        Vector3::new(0.085 + 0.004 * n, 0.006, -0.03 + 0.018 * (n - 1.0))
    };
    let turn = object_in_hand(t_s).rotation;
    let lift = 0.006 * (TAU * (0.5 * t_s + 0.2 * n)).sin().max(0.0);
    turn * (base - Vector3::new(0.09, -0.02, 0.0)) + Vector3::new(0.09, -0.02 + lift, 0.0)
}

/// Six decimals, as a text source has them.
fn rounded(v: Vector3<f64>) -> Vector3<f64> {
    v.map(|c| (c * 1e6).round() / 1e6)
}

/// Whether marker `n` is out of sight at sample `k`.
fn gap(n: usize, k: usize) -> bool {
    n == 3 && (40..70).contains(&(k % 500)) || n == 4 && k % 700 == 11
}

pub(crate) fn clock(rate_hz: f64) -> Clock {
    Clock::new(1_793_614_320_000_000_000, StartTime::AssumedUtc, rate_hz).unwrap()
}

pub(crate) fn take(samples: usize, rate_hz: f64) -> Take {
    let clock = clock(rate_hz);
    let time = |k: usize| clock.time_s(k);
    let marker_names = [
        "Thumb",
        "Index",
        "Middle",
        "Ring",
        "Little",
        "Hand:Marker1",
        "Hand:Marker2",
        "Hand:Marker3",
        "Object:Marker1",
        "Object:Marker2",
        "Unlabeled 1036",
    ];
    let offset = |n: usize| 0.03 * Vector3::new((n as f64).cos(), (n as f64).sin(), 0.3);
    let place = |n: usize, k: usize| {
        let hand = hand_pose(time(k));
        let at = match n {
            0..5 => hand * nalgebra::Point3::from(tip_in_hand(Finger::ALL[n], time(k))),
            5..8 | 10 => hand * nalgebra::Point3::from(offset(n)),
            _ => hand * object_in_hand(time(k)) * nalgebra::Point3::from(offset(n)),
        };
        let shake = Vector3::from_fn(|axis, _| 1e-4 * noise(k * 64 + n * 4 + axis));
        rounded(at.coords + shake)
    };
    let markers = (marker_names.iter().enumerate())
        .map(|(n, name)| {
            let track = PointTrack::from_measured((0..samples).map(|k| {
                let seen = !gap(n, k) && (n != 10 || k.is_multiple_of(3));
                seen.then(|| Position::from_coords(place(n, k)))
            }));
            let quality = (n == 5).then(|| {
                let quality = |k| {
                    if k % 9 == 4 {
                        f64::NAN
                    } else {
                        1.0 - 1e-3 * noise(k).abs()
                    }
                };
                (0..samples).map(quality).collect()
            });
            Marker {
                name: (*name).to_owned(),
                id: format!("{:032X}", 0xABCD_0000_u64 + n as u64),
                kind: match n {
                    0..5 => MarkerKind::Labelled,
                    10 => MarkerKind::Unlabelled,
                    _ => MarkerKind::RigidBodyMarker,
                },
                track,
                quality,
            }
        })
        .collect();

    let body =
        |name: &str, pose: &dyn Fn(usize) -> Isometry3<f64>, hidden: &dyn Fn(usize) -> bool| {
            let track = PoseTrack::<World, Body>::from_measured(
                (0..samples).map(|k| (!hidden(k)).then(|| Pose::new(pose(k)))),
            );
            let error = |k| {
                if hidden(k) {
                    f64::NAN
                } else {
                    2e-4 + 1e-5 * noise(k)
                }
            };
            TrackedBody {
                name: name.to_owned(),
                id: format!("id of {name}"),
                kind: if name == "Wrist" {
                    BodyKind::Bone
                } else {
                    BodyKind::RigidBody
                },
                track,
                marker_error_m: (name == "Hand").then(|| (0..samples).map(error).collect()),
            }
        };
    let hand_hidden = |k: usize| (200..206).contains(&(k % 1000));
    let bodies = vec![
        body("Hand", &|k| hand_pose(time(k)), &hand_hidden),
        body(
            "Object",
            &|k| hand_pose(time(k)) * object_in_hand(time(k)),
            &|_| false,
        ),
    ];
    let source = Source {
        format: "Motive CSV 1.23".to_owned(),
        length_unit: LengthUnit::Millimetres,
        up_axis: UpAxis::Y,
        rotation: Some(RotationOrder::Euler([2, 1, 0])),
        header: BTreeMap::from([
            ("Take Name".to_owned(), "Take 1 \"quoted\", 上午".to_owned()),
            ("Export Frame Rate".to_owned(), rate_hz.to_string()),
            (String::new(), String::new()),
        ]),
    };
    let mut recording =
        Recording::new("Take 1".to_owned(), clock, source, samples, markers, bodies).unwrap();
    recording.findings = vec![
        Finding::warning("line 7", "no rotation type: took quaternions"),
        Finding::info("", "no zone: took UTC"),
    ];

    let status = |n: usize, k: usize| {
        if gap(n, k) {
            Status::Filled
        } else {
            Status::Measured
        }
    };
    let fingertips = PerFinger::from_fn(|finger| {
        let mut track = PointTrack::<Hand>::with_capacity(samples);
        for k in 0..samples {
            let n = finger.index();
            // The longer gap stays open.
            let open = n == 3 && gap(n, k);
            let tip = Position::from_coords(tip_in_hand(finger, time(k)));
            track.push((!open && !hand_hidden(k)).then_some(tip), status(n, k));
        }
        track
    });
    let mut object = PoseTrack::<Hand, Object>::with_capacity(samples);
    let mut hand = PoseTrack::<World, Hand>::with_capacity(samples);
    for k in 0..samples {
        let seen = !hand_hidden(k);
        object.push(
            seen.then(|| Pose::new(object_in_hand(time(k)))),
            Status::Measured,
        );
        hand.push(seen.then(|| Pose::new(hand_pose(time(k)))), status(3, k));
    }
    let motion = Motion {
        name: "Take 1, processed".to_owned(),
        clock,
        fingertips,
        object: Some(object),
        hand,
        selected: None,
    };

    let layout = SegmentLayout::one_second(rate_hz);
    let trajectories = (4..samples.saturating_sub(layout.samples + 4))
        .step_by(layout.samples)
        .map(|start| {
            let values = (0..layout.samples)
                .flat_map(|t| {
                    Finger::ALL.into_iter().flat_map(move |finger| {
                        let wobble = 1e-3 * (TAU * t as f64 / layout.samples as f64).sin();
                        let tip = tip_in_hand(finger, clock.time_s(start + t));
                        [tip.x, tip.y + wobble, tip.z]
                    })
                })
                .collect();
            let trajectory = Trajectory::new(layout, values).unwrap();
            (start, trajectory.clone(), plan(trajectory))
        })
        .collect();

    Take {
        recording,
        roles: Roles {
            hand: BodySource::RigidBody("Hand".to_owned()),
            object: Some(BodySource::RigidBody("Object".to_owned())),
            fingers: PerFinger::from_fn(|finger| marker_names[finger.index()].to_owned()),
        },
        motion,
        trajectories,
        provenance: provenance(),
    }
}

pub(crate) fn provenance() -> Vec<Provenance> {
    let step = |step: &str, settings: &str| Provenance {
        tool: "inhand 0.1.0".to_owned(),
        step: step.to_owned(),
        settings_json: settings.to_owned(),
        inputs: vec![InputHash {
            name: "Take 1.csv".to_owned(),
            sha256: "ab".repeat(32),
        }],
    };
    // More than nine, so that text order and number order differ.
    (0..11)
        .map(|n| step(&format!("step {n}"), "{\"median\":50}"))
        .collect()
}

fn plan(trajectory: Trajectory) -> Plan {
    Plan {
        status: PlanStatus::Solved,
        trajectory: Some(trajectory),
        activations_m: DVector::from_fn(200, |n, _| 1e-3 * noise(n).abs()),
        objective: 12.5,
        certificate: Certificate {
            stationarity: 1e-9,
            primal: 2e-9,
            dual: 0.0,
            complementarity: 3e-10,
        },
        object: (0..3)
            .map(|t| {
                let turn = Vector3::new(0.1, -0.2, 0.3) * f64::from(t);
                Pose::new(Isometry3::new(
                    Vector3::new(0.01, 0.02, noise(t as usize)),
                    turn,
                ))
            })
            .collect(),
        checks: PlanChecks {
            active: PerFamily::from_fn(|family| 3 * family as usize),
            violation: PerFamily::from_fn(|family| {
                (family != ConstraintFamily::Holding).then(|| -1e-3 * family as usize as f64)
            }),
            rows: 2970,
            rows_taken_up: 7,
            hull_distance_m: Some(-0.0015),
        },
        relaxations: vec![
            Relaxation {
                family: ConstraintFamily::Velocity,
                by: 0.125,
                joint: false,
            },
            Relaxation {
                family: ConstraintFamily::Targets,
                by: 2e-3,
                joint: true,
            },
        ],
        rounds: 2,
        iterations: 19,
    }
}

/// Segments of every method, borrowed from the take.
pub(crate) fn segments(take: &Take) -> Vec<GeneratedSegment<'_>> {
    (take.trajectories.iter())
        .map(|(start_sample, trajectory, plan)| GeneratedSegment {
            start_sample: *start_sample,
            samples: trajectory.layout().samples,
            trajectory: Some(trajectory),
            plan: Some(plan),
        })
        .collect()
}

pub(crate) fn generated<'a>(
    names: &[&'a str],
    segments: &'a [GeneratedSegment<'a>],
) -> Vec<GeneratedMethod<'a>> {
    let plans = segments.iter().any(|segment| segment.plan.is_some());
    let method = |&name| GeneratedMethod {
        name,
        plans,
        segments,
    };
    names.iter().map(method).collect()
}

pub(crate) fn evaluated(names: &[&str], take: &Take) -> Vec<EvaluatedMethod> {
    let judged = |sample: usize| {
        let distance_m = PerFinger::from_fn(|f| 4e-3 + 3e-3 * noise(sample / 20 * 8 + f.index()));
        let in_contact = distance_m.map(|d| d <= 5e-3);
        EvaluatedSample {
            sample,
            error_m: Some(PerFinger::from_fn(|f| {
                1e-3 * noise(sample * 8 + f.index()).abs()
            })),
            contact: Some(ContactSample {
                distance_m,
                in_contact,
                count: in_contact.iter().filter(|(_, touches)| **touches).count(),
            }),
        }
    };
    let samples: Vec<_> = (take.trajectories.iter())
        .flat_map(|(start, trajectory, _)| *start..start + trajectory.layout().samples)
        .map(judged)
        .collect();
    let method = |name: &&str| EvaluatedMethod {
        name: (*name).to_owned(),
        samples: samples.clone(),
    };
    names.iter().map(method).collect()
}

/// A plan that found no motion.
pub(crate) fn infeasible(take: &Take) -> Plan {
    Plan {
        status: PlanStatus::Infeasible,
        trajectory: None,
        object: Vec::new(),
        activations_m: DVector::zeros(0),
        objective: f64::INFINITY,
        ..take.trajectories[0].2.clone()
    }
}

/// The whole take as one file's content.
pub(crate) fn take_file<'a>(
    take: &'a Take,
    generated: &'a [GeneratedMethod<'a>],
    evaluated: &'a [EvaluatedMethod],
) -> TakeFile<'a> {
    TakeFile {
        cleaned: None,
        recording: &take.recording,
        roles: Some(&take.roles),
        motion: Some(&take.motion),
        generated,
        held_out: &[],
        evaluated,
        object_shape: Some(Shape::Cuboid { edges_m: [0.05; 3] }),
        hulls: None,
        annotations: None,
        provenance: &take.provenance,
    }
}

pub(crate) fn dictionary(rank: usize, samples: usize, rate_hz: f64) -> Dictionary {
    dictionary_of(
        rank,
        SegmentLayout {
            samples,
            rate_hz,
            object: false,
        },
    )
}

pub(crate) fn dictionary_of(rank: usize, layout: SegmentLayout) -> Dictionary {
    let (rows, samples) = (layout.rows(), layout.samples);
    let mut primitives = DMatrix::from_fn(rows, rank, |row, column| {
        let t = (row / SEGMENT_COORDINATES) as f64 / samples as f64;
        (TAU * (t * (1 + column % 4) as f64 + 0.1 * (row % 15 + column) as f64)).sin() + 1.001
    });
    for mut column in primitives.column_iter_mut() {
        let norm = column.norm();
        column /= norm;
    }
    let hull = Hull {
        vertices_m: vec![
            [0.0, 0.0, 0.0],
            [0.02, 0.0, 0.0],
            [0.0, 0.02, 0.0],
            [0.0, 0.0, 0.02],
        ],
        triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
        normals: vec![
            [0.0, 0.0, -1.0],
            [0.0, -1.0, 0.0],
            [-1.0, 0.0, 0.0],
            [1.0 / 3f64.sqrt(); 3],
        ],
        offsets_m: vec![0.0, -0.0, 0.0, 0.02 / 3f64.sqrt()],
    };
    Dictionary {
        kind: DictionaryKind::Nmf,
        layout,
        offset_m: DVector::from_fn(rows, |row, _| {
            tip_in_hand(Finger::ALL[row % 15 / 3], 0.0)[row % 3] - 0.02
        }),
        primitives,
        activation_mean_m: DVector::from_fn(rank, |n, _| 1e-3 * (n % 7) as f64),
        activation_covariance_m2: DMatrix::from_fn(rank, rank, |i, j| {
            if i == j {
                1e-4
            } else {
                1e-7 * noise(i.min(j) * 512 + i.max(j))
            }
        }),
        covariance_shrinkage: 0.1,
        learning: Learning {
            segments: 595,
            rms_m: 2.3e-4,
            relative_error: 4e-3,
            iterations: 40,
            stop_reason: StopReason::IterationLimit,
            objective_history_m2: vec![3.0, 1.0, 0.5],
            seed: u64::MAX,
            restarts: (0..3)
                .map(|n| Restart {
                    seed: u64::MAX - n,
                    rms_m: 2.3e-4 + 1e-6 * n as f64,
                    objective_m2: 0.5 + 0.1 * n as f64,
                    matched_cosine: 1.0 - 0.05 * n as f64,
                })
                .collect(),
        },
        demonstrated: Demonstrated {
            hulls: PerFinger::from_fn(|finger| Hull {
                vertices_m: (hull.vertices_m.iter())
                    .map(|v| {
                        let tip = tip_in_hand(finger, 0.0);
                        [v[0] + tip.x, v[1] + tip.y, v[2] + tip.z]
                    })
                    .collect(),
                ..hull.clone()
            }),
            velocity: VelocityBounds {
                min_m_s: [-0.3; SEGMENT_COORDINATES],
                max_m_s: [0.4; SEGMENT_COORDINATES],
            },
        },
        residual: Some(residual_of(layout)),
        residual_held_out: Some(Residual {
            curve: SmoothCurve::Line,
            ..residual_of(layout)
        }),
        choice: Some(MethodChoice {
            protocol: Protocol::HeldOut,
            method: "residual".to_owned(),
            candidates: vec![
                MethodCandidate {
                    name: "residual".to_owned(),
                    mean_error_m: 6e-4,
                },
                MethodCandidate {
                    name: "prior".to_owned(),
                    mean_error_m: f64::INFINITY,
                },
            ],
            gain_m: Some(1e-4),
            gain_standard_error_m: None,
            folds: 5,
            segments: 119,
        }),
    }
}

/// A learned deviation of two primitives a finger (and the object), three demonstrations.
pub(crate) fn residual_of(layout: SegmentLayout) -> Residual {
    residual_with(layout, 2, 3)
}

/// A learned deviation of so many primitives a finger (and the object).
pub(crate) fn residual_with(
    layout: SegmentLayout,
    primitives_each: usize,
    demonstrations: usize,
) -> Residual {
    let blocks = vec![primitives_each; if layout.object { 6 } else { 5 }];
    let (rank, ends) = (primitives_each * blocks.len(), ends_len(layout));
    // Each primitive lives in the rows of its own part.
    let part = |row: usize| {
        if row < layout.finger_rows() {
            row % 15 / 3
        } else {
            5
        }
    };
    let primitives = DMatrix::from_fn(layout.rows(), rank, |row, j| {
        if part(row) == j / primitives_each {
            noise(row * 31 + j)
        } else {
            0.0
        }
    });
    let matrix = |seed: usize, rows: usize, columns: usize| {
        DMatrix::from_fn(rows, columns, |i, j| noise(seed + i * 131 + j * 17))
    };
    Residual {
        layout,
        curve: SmoothCurve::Hermite,
        ends_mean: DVector::from_fn(ends, |i, _| noise(i)),
        ends_covariance: matrix(3, ends, ends),
        primitives,
        expectation: DeviationPredictor::new(
            layout,
            blocks,
            matrix(5, rank, ends),
            matrix(7, ends, demonstrations),
            matrix(11, rank, demonstrations),
        )
        .weighted(
            Bandwidths {
                hand: 2.0,
                finger: 0.5,
            },
            PredictorWeights {
                profile: 0.9,
                hand: 0.3,
                finger: 0.6,
            },
        ),
        covariance_m2: matrix(13, rank, rank),
        unexplained_m2: 2e-9,
        calibration: vec![Calibration {
            share: 0.5,
            mahalanobis: 1.25,
        }],
        validation: Validation {
            folds: 5,
            segments: 119,
            smooth_error_m: 8e-4,
            error_m: 6e-4,
            standard_error_m: 1e-5,
        },
    }
}
