//! Missing data: left out and counted, never guessed, never a panic.

use inhand_evaluation::{EvaluationSettings, MethodResult, evaluate_method, motion_contacts};
use inhand_model::{
    Certificate, ConstraintFamily, Finger, PerFamily, Plan, PlanChecks, PlanStatus, SegmentLayout,
    Shape, Status, Track, Trajectory,
};
use nalgebra::DVector;

use crate::session::{Session, anywhere, beside_cube, motion, object_ahead};

/// Three segments of four samples, two more lost to gaps; the object is missing at samples 3 to 5.
fn session() -> Session {
    let tips = vec![beside_cube([0.001, 0.002, 0.003, 0.004, 0.020]); 14];
    let object: Vec<_> = (0..14)
        .map(|k| (!(3..=5).contains(&k)).then(object_ahead))
        .collect();
    let take = motion(10.0, &tips, Some(&object));
    Session::new(vec![take], 4, &[(0, 1), (0, 5), (0, 9)], 2, anywhere())
}

#[test]
fn missing_objects_leave_contacts_out() {
    let session = session();
    let (evaluation, rows) = session.evaluate(&session.copies());
    assert_eq!(
        (evaluation.error.all.n, evaluation.error.all.n_left_out),
        (60, 40)
    );
    let contact = evaluation.contact.unwrap();
    // Samples 3, 4 and 5 are in segments, and two segments are gone.
    assert_eq!((contact.n, contact.n_left_out), (9, 3 + 8));
    assert_eq!(contact.three_or_more, 1.0);
    let difference = evaluation.distance_difference.unwrap();
    assert_eq!(
        (
            difference[Finger::Thumb].n,
            difference[Finger::Thumb].n_left_out
        ),
        (9, 11)
    );
    // Sample 3 of the take is the third of the first segment.
    assert!(rows.distance_m.unwrap()[2][Finger::Thumb].is_nan());
}

#[test]
fn failed_plans_are_left_out_and_counted() {
    let session = session();
    let mut planned = session.copies();
    planned[1] = None;
    let (evaluation, rows) = session.evaluate(&planned);
    assert_eq!(
        (evaluation.error.all.n, evaluation.error.all.n_left_out),
        (40, 60)
    );
    assert_eq!(
        (
            evaluation.error_at_start.n,
            evaluation.error_at_start.n_left_out
        ),
        (10, 15)
    );
    assert_eq!((evaluation.reachability.n, evaluation.collision.n), (8, 8));
    assert_eq!(evaluation.velocity.n, 2 * 3 * 15);
    let contact = evaluation.contact.unwrap();
    assert_eq!((contact.n, contact.n_left_out), (6, 14));
    assert_eq!(rows.error_m.len(), 12);
    assert!(rows.error_m[4][Finger::Thumb].is_nan());
    assert!(rows.hull_distance_m[7][Finger::Little].is_nan());
    assert!(rows.nearest_pair_m[5].is_nan());
}

#[test]
fn a_method_that_failed_throughout_has_no_numbers() {
    let session = session();
    let (evaluation, _) = session.evaluate(&[None, None, None]);
    assert_eq!(
        (evaluation.error.all.n, evaluation.error.all.n_left_out),
        (0, 100)
    );
    assert!(evaluation.error.all.p50.is_nan());
    assert!(
        evaluation
            .median_error_by_sample_m
            .iter()
            .all(|median| median.is_nan())
    );
    assert_eq!(evaluation.reachability.n, 0);
    assert!(evaluation.reachability.inside[Finger::Thumb].is_nan());
    assert_eq!(
        (evaluation.collision.n, evaluation.collision.nearest_pair),
        (0, None)
    );
    assert!(
        evaluation.collision.nearest_m.is_nan() && evaluation.collision.recorded_nearest_m.is_nan()
    );
    assert_eq!(evaluation.velocity.n, 0);
    let contact = evaluation.contact.unwrap();
    assert_eq!((contact.n, contact.n_left_out), (0, 20));
    assert!(contact.three_or_more.is_nan() && contact.recorded_three_or_more.is_nan());
}

#[test]
fn trajectories_that_do_not_fit_count_as_failed() {
    let session = session();
    let layout = SegmentLayout {
        samples: 5,
        rate_hz: 10.0,
        object: false,
    };
    let longer = Trajectory::new(layout, vec![0.0; layout.rows()]).unwrap();
    let copies = session.copies();
    let (evaluation, rows) = session.evaluate(&[copies[0].clone(), Some(longer)]);
    assert_eq!(
        (evaluation.error.all.n, evaluation.error.all.n_left_out),
        (20, 80)
    );
    assert_eq!(rows.error_m.len(), 12);
}

#[test]
fn without_a_shape_or_an_object_there_are_no_contacts() {
    let mut session = session();
    session.shape = None;
    let (evaluation, rows) = session.evaluate(&session.copies());
    assert!(evaluation.contact.is_none() && evaluation.distance_difference.is_none());
    assert!(rows.distance_m.is_none());

    let mut session = self::session();
    session.motions[0].object = None;
    assert!(session.recorded().rows.recorded_distance_m.is_none());
    let (evaluation, rows) = session.evaluate(&session.copies());
    assert!(evaluation.contact.is_none() && rows.distance_m.is_none());
    assert_eq!(evaluation.error.all.n, 60);
}

#[test]
fn motions_that_are_not_there_leave_contacts_out() {
    let mut session = session();
    let other = session.motions[0].clone();
    let origins = [(0, 1), (1, 5)];
    session = Session::new(vec![other.clone(), other], 4, &origins, 0, anywhere());
    session.motions.pop();
    let (evaluation, _) = session.evaluate(&session.copies());
    assert_eq!(evaluation.error.all.n, 40);
    let contact = evaluation.contact.unwrap();
    assert_eq!((contact.n, contact.n_left_out), (2, 6));
}

#[test]
fn a_session_without_segments_is_judged_too() {
    let tips = vec![beside_cube([0.0; 5]); 3];
    let session = Session::new(vec![motion(10.0, &tips, None)], 4, &[], 1, anywhere());
    let (evaluation, rows) = session.evaluate(&[]);
    assert_eq!(
        (evaluation.error.all.n, evaluation.error.all.n_left_out),
        (0, 20)
    );
    assert!(rows.error_m.is_empty());
}

#[test]
fn plans_are_counted_by_how_they_ended() {
    let session = session();
    let planned = session.copies();
    let plan = |status, worst: f64, velocity| Plan {
        status,
        trajectory: (status == PlanStatus::Solved).then(|| planned[0].clone().unwrap()),
        activations_m: DVector::zeros(0),
        objective: 0.0,
        certificate: Certificate {
            stationarity: worst,
            primal: 0.0,
            dual: 0.0,
            complementarity: 0.0,
        },
        object: Vec::new(),
        checks: PlanChecks {
            active: PerFamily::from_fn(|family| match family {
                ConstraintFamily::Velocity => velocity,
                _ => 0,
            }),
            ..PlanChecks::default()
        },
        relaxations: Vec::new(),
        rounds: 1,
        iterations: 9,
    };
    let plans = [
        plan(PlanStatus::Solved, 1e-9, 0),
        plan(PlanStatus::Solved, 3e-8, 2),
        plan(PlanStatus::Infeasible, 0.5, 7),
        plan(PlanStatus::Failed, 0.9, 0),
    ];
    let facts = |plans: &[Plan]| {
        let method = MethodResult {
            name: "prior",
            description: "",
            baseline: false,
            trajectories: &planned,
            objects: None,
            corridors: None,
            plans: Some(plans),
        };
        session.with_data(|data| {
            evaluate_method(&data, &session.recorded(), &method, &session.settings)
                .0
                .plan
                .unwrap()
        })
    };
    let counted = facts(&plans);
    assert_eq!(
        (counted.solved, counted.infeasible, counted.failed),
        (2, 1, 1)
    );
    assert_eq!(
        (counted.worst_kkt_residual, counted.velocity_bound_active),
        (3e-8, 1)
    );
    let unknown = facts(&[
        plan(PlanStatus::Solved, 1e-9, 0),
        plan(PlanStatus::Solved, f64::NAN, 0),
    ]);
    assert!(unknown.worst_kkt_residual.is_nan() || unknown.worst_kkt_residual > 0.0);
    assert_eq!(facts(&[]).solved, 0);
}

#[test]
fn a_whole_take_has_contacts_where_object_and_a_fingertip_are() {
    let mut session = session();
    let shape: Shape = "cube:0.05".parse().unwrap();
    session.motions[0].fingertips[Finger::Index] = Track::missing(14);
    for finger in Finger::ALL {
        session.motions[0].fingertips[finger].set(9, None, Status::Missing);
    }
    let contacts = motion_contacts(
        &session.motions[0],
        0..session.motions[0].len(),
        &shape,
        &EvaluationSettings::paper(),
    );
    assert_eq!(contacts.len(), 14);
    for (k, contact) in contacts.into_iter().enumerate() {
        let Some(distance_m) = contact else {
            assert!((3..=5).contains(&k) || k == 9, "sample {k}");
            continue;
        };
        let expected_m = [0.001, f64::NAN, 0.003, 0.004, 0.020];
        for (finger, expected_m) in Finger::ALL.into_iter().zip(expected_m) {
            let found_m = distance_m[finger];
            let equal = (found_m - expected_m).abs() < 1e-12;
            assert!(equal || (found_m.is_nan() && expected_m.is_nan()));
        }
    }
    // Without an object nothing is known.
    session.motions[0].object = None;
    let settings = EvaluationSettings::paper();
    assert!(motion_contacts(&session.motions[0], 0..1, &shape, &settings).is_empty());
}
