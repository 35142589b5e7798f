//! Against NumPy, SciPy and quadprog; `../reference/make_session.py` made the numbers.

use inhand_contact::hull;
use inhand_evaluation::EvaluationSettings;
use inhand_model::{
    Demonstrated, Finger, Hand, PerFinger, Pose, Position, Shape, Statistics, Status,
    VelocityBounds,
};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use serde_json::Value;

use crate::session::{Session, fill, motion};

/// Both sides round at 1e-16 of some decimetres; quadprog's projection is good to 1e-13 of that.
const NEAR_M: f64 = 1e-12;

fn reference() -> Value {
    serde_json::from_str(include_str!("../reference/session.json")).expect("written by the script")
}

fn list(value: &Value) -> &[Value] {
    value.as_array().expect("a list")
}

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("a number, not {value}"))
}

fn count(value: &Value) -> usize {
    value.as_u64().expect("a count") as usize
}

fn numbers<const N: usize>(value: &Value) -> [f64; N] {
    let numbers: Vec<f64> = list(value).iter().map(number).collect();
    numbers.try_into().expect("as many numbers")
}

fn session(reference: &Value) -> Session {
    let motions = (list(&reference["takes"]).iter())
        .map(|take| {
            let tips: Vec<PerFinger<Position<Hand>>> = (list(&take["tips_m"]).iter())
                .map(|row| {
                    let row = numbers::<15>(row);
                    PerFinger::from_fn(|f| {
                        Position::from([0, 1, 2].map(|axis| row[3 * f.index() + axis]))
                    })
                })
                .collect();
            let statuses: Vec<u64> = list(&take["object_status"])
                .iter()
                .map(|s| s.as_u64().expect("a status"))
                .collect();
            let object: Vec<Option<Pose<Hand, inhand_model::Object>>> = (list(&take["centre_m"])
                .iter())
            .zip(list(&take["quaternion_xyzw"]))
            .zip(&statuses)
            .map(|((centre, quaternion), &status)| {
                let [x, y, z, w] = numbers(quaternion);
                let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
                let translation = Translation3::from(Vector3::from(numbers::<3>(centre)));
                (status != 2).then(|| Pose::new(Isometry3::from_parts(translation, rotation)))
            })
            .collect();
            let mut motion = motion(number(&reference["rate_hz"]), &tips, Some(&object));
            for (k, filled) in list(&take["filled"]).iter().enumerate() {
                for (finger, filled) in Finger::ALL.into_iter().zip(numbers::<5>(filled)) {
                    if filled != 0.0 {
                        fill(&mut motion.fingertips[finger], k);
                    }
                }
                if statuses[k] == 1 {
                    let object = motion.object.as_mut().expect("tracked");
                    object.set(k, object.get(k), Status::Filled);
                }
            }
            motion
        })
        .collect();
    let hulls = list(&reference["training_m"]);
    let demonstrated = Demonstrated {
        hulls: PerFinger::from_fn(|finger| {
            let points: Vec<Position<Hand>> = list(&hulls[finger.index()])
                .iter()
                .map(|p| numbers::<3>(p).into())
                .collect();
            hull(&points).expect("points in space")
        }),
        velocity: VelocityBounds {
            min_m_s: numbers(&reference["velocity_min_m_s"]),
            max_m_s: numbers(&reference["velocity_max_m_s"]),
        },
    };
    let origins: Vec<(usize, usize)> = list(&reference["origins"])
        .iter()
        .map(|o| (count(&o[0]), count(&o[1])))
        .collect();
    let mut session = Session::new(
        motions,
        count(&reference["samples"]),
        &origins,
        count(&reference["left_out"]),
        demonstrated,
    );
    session.shape = Some(Shape::Cuboid {
        edges_m: numbers(&reference["edges_m"]),
    });
    session.settings = EvaluationSettings {
        tau_m: number(&reference["tau_m"]),
        collision_limit_m: number(&reference["collision_limit_m"]),
        finger_offsets_m: PerFinger::new(numbers(&reference["finger_offsets_m"])),
        tau_sweep_m: list(&reference["tau_sweep_m"]).iter().map(number).collect(),
        hull_tolerance_m: number(&reference["hull_tolerance_m"]),
    };
    session
}

fn near(what: &str, found: f64, expected: &Value) {
    let expected = number(expected);
    assert!(
        (found - expected).abs() < NEAR_M,
        "{what}: expected {expected}, found {found}"
    );
}

fn same(what: &str, found: usize, expected: &Value) {
    assert_eq!(found, count(expected), "{what}");
}

fn check_statistics(what: &str, found: &Statistics, expected: &Value) {
    for (field, found) in [
        ("n", found.n),
        ("n_filled", found.n_filled),
        ("n_left_out", found.n_left_out),
    ] {
        same(&format!("{what}.{field}"), found, &expected[field]);
    }
    for (field, found) in [
        ("mean", found.mean),
        ("rmse", found.rmse),
        ("min", found.min),
        ("p5", found.p5),
        ("p25", found.p25),
        ("p50", found.p50),
        ("p75", found.p75),
        ("p95", found.p95),
        ("max", found.max),
        ("whisker_low", found.whisker_low),
        ("whisker_high", found.whisker_high),
    ] {
        near(&format!("{what}.{field}"), found, &expected[field]);
    }
}

fn check_fingers(what: &str, found: &PerFinger<f64>, expected: &Value) {
    for (finger, &found) in found.iter() {
        near(
            &format!("{what} {finger}"),
            found,
            &expected[finger.index()],
        );
    }
}

#[test]
fn an_evaluation_agrees_with_numpy() {
    let reference = reference();
    let session = session(&reference);
    let failed = count(&reference["failed"]);
    let trajectories: Vec<_> = (list(&reference["planned_m"]).iter().enumerate())
        .map(|(segment, values)| {
            (segment != failed)
                .then(|| session.trajectory(list(values).iter().map(number).collect()))
        })
        .collect();
    let (found, rows) = session.evaluate(&trajectories);
    let expected = &reference["expected"];

    let recorded = session.recorded();
    for (name, found) in [
        ("error_m", &rows.error_m),
        ("distance_m", rows.distance_m.as_ref().unwrap()),
        (
            "recorded_distance_m",
            recorded.rows.recorded_distance_m.as_ref().unwrap(),
        ),
        ("hull_distance_m", &rows.hull_distance_m),
        (
            "recorded_hull_distance_m",
            &recorded.rows.recorded_hull_distance_m,
        ),
    ] {
        let expected = list(&reference["expected_rows"][name]);
        assert_eq!(found.len(), expected.len(), "{name}");
        for (k, (found, expected)) in found.iter().zip(expected).enumerate() {
            // The script writes -1 where there is no number.
            let found = found.map(|d| if d.is_nan() { -1.0 } else { d });
            check_fingers(&format!("{name} {k}"), &found, expected);
        }
    }

    check_statistics("error", &found.error.all, &expected["error"]);
    check_statistics(
        "error at start",
        &found.error_at_start,
        &expected["error_at_start"],
    );
    check_statistics(
        "error at goal",
        &found.error_at_goal,
        &expected["error_at_goal"],
    );
    let difference = found.distance_difference.as_ref().unwrap();
    for finger in Finger::ALL {
        let k = finger.index();
        let what = |name: &str| format!("{name} {finger}");
        check_statistics(
            &what("error"),
            &found.error.by_finger[finger],
            &expected["error_by_finger"][k],
        );
        check_statistics(
            &what("hull"),
            &found.reachability.distance[finger],
            &expected["reachability"]["distance"][k],
        );
        check_statistics(
            &what("difference"),
            &difference[finger],
            &expected["distance_difference"][k],
        );
    }
    let medians = list(&expected["median_error_by_sample_m"]);
    assert_eq!(found.median_error_by_sample_m.len(), medians.len());
    for (found, expected) in found.median_error_by_sample_m.iter().zip(medians) {
        near("median by sample", *found, expected);
    }

    let (found_reach, reach) = (&found.reachability, &expected["reachability"]);
    same("reachability", found_reach.n, &reach["n"]);
    check_fingers("inside", &found_reach.inside, &reach["inside"]);
    check_fingers(
        "recorded inside",
        &found_reach.recorded_inside,
        &reach["recorded_inside"],
    );
    check_fingers(
        "worst outside",
        &found_reach.worst_outside_m,
        &reach["worst_outside_m"],
    );

    let (found_near, collision) = (&found.collision, &expected["collision"]);
    same("collision n", found_near.n, &collision["n"]);
    same(
        "collision instants",
        found_near.instants,
        &collision["instants"],
    );
    same(
        "collision trajectories",
        found_near.trajectories,
        &collision["trajectories"],
    );
    same(
        "recorded collisions",
        found_near.recorded_instants,
        &collision["recorded_instants"],
    );
    near("nearest", found_near.nearest_m, &collision["nearest_m"]);
    near(
        "recorded nearest",
        found_near.recorded_nearest_m,
        &collision["recorded_nearest_m"],
    );

    let (found_velocity, velocity) = (&found.velocity, &expected["velocity"]);
    same("velocity n", found_velocity.n, &velocity["n"]);
    same(
        "velocity outside",
        found_velocity.outside,
        &velocity["outside"],
    );
    same(
        "trajectories outside",
        found_velocity.trajectories_outside,
        &velocity["trajectories_outside"],
    );
    near(
        "worst ratio",
        found_velocity.worst_ratio,
        &velocity["worst_ratio"],
    );

    let (found_contact, contact) = (found.contact.as_ref().unwrap(), &expected["contact"]);
    same("contact n", found_contact.n, &contact["n"]);
    same(
        "contact filled",
        found_contact.n_filled,
        &contact["n_filled"],
    );
    same(
        "contact left out",
        found_contact.n_left_out,
        &contact["n_left_out"],
    );
    near(
        "three",
        found_contact.three_or_more,
        &contact["three_or_more"],
    );
    near(
        "recorded three",
        found_contact.recorded_three_or_more,
        &contact["recorded_three_or_more"],
    );
    check_fingers("contact", &found_contact.by_finger, &contact["by_finger"]);
    check_fingers(
        "recorded contact",
        &found_contact.recorded_by_finger,
        &contact["recorded_by_finger"],
    );
    assert_eq!(found_contact.by_tau.len(), 11);
    for (found, expected) in found_contact.by_tau.iter().zip(list(&contact["by_tau"])) {
        near("tau", found.tau_m, &expected["tau_m"]);
        near(
            "three by tau",
            found.three_or_more,
            &expected["three_or_more"],
        );
        near(
            "recorded three by tau",
            found.recorded_three_or_more,
            &expected["recorded_three_or_more"],
        );
    }
}
