//! Motion and contacts over time of the sample: one test take of 40 s in which the index walks.

use inhand_model::{
    ContactDynamics, ContactRules, Finger, FingerContactFacts, FingerMovement, FingerSet,
    GaitFacts, Movement, MovementAnalysis, PerFinger, PhaseFacts, PhaseKind, SegmentContacts,
    StateFacts, Statistics, TakeContacts, Transition,
};

use super::{METHODS, SEGMENTS, finger_factor, statistics};

/// Values about a middle, spread evenly.
fn about(n: usize, middle: f64, spread: f64) -> Statistics {
    let share = |k: usize| (k as f64 + 0.5) / n as f64 - 0.5;
    statistics((0..n).map(|k| middle + spread * share(k)).collect())
}

fn nothing() -> Statistics {
    let nan = f64::NAN;
    Statistics {
        mean: nan,
        rmse: nan,
        min: nan,
        p5: nan,
        p25: nan,
        p50: nan,
        p75: nan,
        p95: nan,
        max: nan,
        whisker_low: nan,
        whisker_high: nan,
        ..Statistics::default()
    }
}

fn one(smoothness: f64) -> Movement {
    Movement {
        by_finger: PerFinger::from_fn(|finger| {
            let factor = finger_factor(finger);
            FingerMovement {
                length_m: about(SEGMENTS, 0.021 * factor, 0.03 * factor),
                peak_speed_m_s: about(SEGMENTS, 0.062 * factor, 0.08 * factor),
                static_share: about(SEGMENTS, 0.22, 0.3),
                sparc: about(SEGMENTS, smoothness - 1.6, 0.5),
                ldlj: about(SEGMENTS, 4.0 * smoothness - 7.0, 3.0),
            }
        }),
        nearest_demonstration_m: Some(about(SEGMENTS, 0.0061, 0.006)),
    }
}

pub(super) fn movement() -> MovementAnalysis {
    MovementAnalysis {
        recorded: one(-0.4),
        methods: (METHODS.iter().enumerate())
            .map(|(place, kind)| {
                let mut movement = one(-0.05 * place as f64);
                if kind.0 == "hold" {
                    for finger in Finger::ALL {
                        movement.by_finger[finger].sparc = nothing();
                        movement.by_finger[finger].ldlj = nothing();
                    }
                }
                (kind.0.to_owned(), movement)
            })
            .collect(),
        static_speed_m_s: 0.005,
        demonstrations: 590,
        demonstrations_available: 590,
        warping_band: Some(10),
    }
}

fn facts(finger: Finger, known_s: f64, makes: usize) -> FingerContactFacts {
    FingerContactFacts {
        known_s,
        duty: 1.0 - 0.06 * finger.index() as f64,
        makes,
        breaks: makes,
        duration_s: if makes > 1 {
            about(makes - 1, 1.8, 2.0)
        } else {
            nothing()
        },
        censored: 2,
        slip_m: about(makes + 1, 0.0017, 0.002),
    }
}

fn segments() -> SegmentContacts {
    SegmentContacts {
        segments: SEGMENTS,
        by_finger: PerFinger::from_fn(|finger| facts(finger, 119.0, 3 * finger.index())),
        by_fingers: [0, 0, 12, 400, 3488, 8000],
    }
}

/// Every 4 s the index lifts for 0.4 s, the little finger for longer than a gait.
fn take() -> TakeContacts {
    const LENGTH_S: f64 = 40.0;
    let all = FingerSet::of(PerFinger::new([true; 5]));
    let without = |gone: Finger| FingerSet::of(PerFinger::from_fn(|finger| finger != gone));
    let lifts: Vec<[f64; 2]> = (1..10)
        .map(|k| [4.0 * f64::from(k), 4.0 * f64::from(k) + 0.4])
        .collect();
    let touching = |lifts: &[[f64; 2]]| {
        let starts = std::iter::once(0.0).chain(lifts.iter().map(|lift| lift[1]));
        let ends = lifts.iter().map(|lift| lift[0]).chain([LENGTH_S]);
        starts
            .zip(ends)
            .map(|(start, end)| [start, end])
            .collect::<Vec<_>>()
    };
    let mut contacts_s = PerFinger::from_fn(|_| vec![[0.0, LENGTH_S]]);
    contacts_s[Finger::Index] = touching(&lifts);
    contacts_s[Finger::Little] = touching(&[[25.0, 27.5]]);
    let mut unknown_s = PerFinger::from_fn(|_| Vec::new());
    unknown_s[Finger::Ring] = vec![[13.0, 13.5]];
    let mut phases = Vec::new();
    let mut start_s = 0.0;
    for lift in &lifts {
        phases.push(PhaseFacts {
            kind: PhaseKind::InGrasp,
            span_s: [start_s, lift[0]],
            holding: all,
        });
        phases.push(PhaseFacts {
            kind: PhaseKind::FingerGaiting,
            span_s: *lift,
            holding: without(Finger::Index),
        });
        start_s = lift[1];
    }
    phases.push(PhaseFacts {
        kind: PhaseKind::NoGrasp,
        span_s: [start_s, LENGTH_S],
        holding: FingerSet::NONE,
    });
    let state = |fingers, samples: usize, runs: usize| StateFacts {
        fingers,
        samples,
        share: samples as f64 / 3950.0,
        runs,
        duration_s: if runs > 2 {
            about(runs - 2, 3.0, 2.0)
        } else {
            nothing()
        },
    };
    let change = |from, to, count| Transition { from, to, count };
    TakeContacts {
        take: "cube_05".to_owned(),
        rate_hz: 100.0,
        duration_s: LENGTH_S,
        by_finger: PerFinger::from_fn(|finger| facts(finger, LENGTH_S, 2 * finger.index())),
        contacts_s,
        unknown_s,
        states: vec![
            state(all, 3340, 12),
            state(without(Finger::Index), 360, 9),
            state(without(Finger::Little), 250, 1),
        ],
        transitions: vec![
            change(all, without(Finger::Index), 9),
            change(without(Finger::Index), all, 9),
            change(all, without(Finger::Little), 1),
            change(without(Finger::Little), all, 1),
        ],
        phases,
        gaits: (lifts.iter().enumerate())
            .map(|(k, &span_s)| GaitFacts {
                finger: Finger::Index,
                span_s,
                holding: without(Finger::Index),
                step_m: if k == 3 {
                    f64::NAN
                } else {
                    0.006 + 0.001 * k as f64
                },
            })
            .collect(),
    }
}

pub(super) fn contacts() -> ContactDynamics {
    ContactDynamics {
        rules: ContactRules {
            tau_m: 0.005,
            min_duration_s: 0.05,
            max_lift_s: 1.0,
            min_fingers: 3,
        },
        takes: vec![take()],
        recorded: segments(),
        methods: (METHODS.iter())
            .map(|kind| (kind.0.to_owned(), segments()))
            .collect(),
    }
}
