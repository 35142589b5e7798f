//! Plans beside fingertips: the object, and prediction regions.

use std::f64::consts::{PI, SQRT_2, TAU};

use inhand_evaluation::{Corridors, MethodResult, ObjectPoses};
use inhand_model::{
    Calibration, CorridorCoverage, Finger, Hand, MethodEvaluation, Object, ObjectError, PerFinger,
    Pose, SegmentLayout, Segments, Status,
};
use nalgebra::{DMatrix, Isometry3, Matrix3, Quaternion, UnitQuaternion, Vector3};

use crate::session::{Session, anywhere, beside_cube, method, motion, object_ahead};

const SAMPLES: usize = 4;

/// Three segments of four samples, one more lost to gaps; the object is missing at samples 6 and 7.
fn session() -> Session {
    let tips = vec![beside_cube([0.001, 0.002, 0.003, 0.004, 0.020]); 14];
    let object: Vec<_> = (0..14)
        .map(|k| (!(6..=7).contains(&k)).then(object_ahead))
        .collect();
    let take = motion(10.0, &tips, Some(&object));
    Session::new(
        vec![take],
        SAMPLES,
        &[(0, 1), (0, 5), (0, 9)],
        1,
        anywhere(),
    )
}

type Objects = Vec<Option<ObjectPoses>>;

/// The same pose at every instant of three segments.
fn everywhere(pose: Pose<Hand, Object>) -> Objects {
    vec![Some(vec![pose; SAMPLES]); 3]
}

fn with_objects(session: &Session, objects: &Objects) -> MethodEvaluation {
    let copies = session.copies();
    let result = MethodResult {
        objects: Some(objects),
        ..method(&copies)
    };
    session.judge(&result).0
}

fn object_error(session: &Session, objects: &Objects) -> ObjectError {
    with_objects(session, objects)
        .object_error
        .expect("both are known")
}

/// The recorded pose, moved by (3, 4, 0) mm and turned about its own origin.
fn off(turn: Vector3<f64>) -> Pose<Hand, Object> {
    let mut isometry = object_ahead().isometry();
    isometry.translation.vector += Vector3::new(0.003, 0.004, 0.0);
    isometry.rotation = UnitQuaternion::from_scaled_axis(turn) * isometry.rotation;
    Pose::new(isometry)
}

#[test]
fn an_object_that_is_off_is_off_by_its_distance_and_angle() {
    let session = session();
    let axis = Vector3::new(1.0, -2.0, 2.0) / 3.0;
    for (turned, angle) in [
        (0.2, 0.2),
        (-0.2, 0.2),
        (3.5, TAU - 3.5),
        (PI, PI),
        (0.0, 0.0),
    ] {
        let error = object_error(&session, &everywhere(off(axis * turned)));
        for (statistics, expected) in [(error.position, 0.005), (error.angle, angle)] {
            // Two of twelve instants without the object, and a segment lost to gaps.
            assert_eq!((statistics.n, statistics.n_left_out), (10, 2 + 4));
            for found in [
                statistics.min,
                statistics.p50,
                statistics.max,
                statistics.rmse,
            ] {
                assert!((found - expected).abs() < 1e-12, "{found} {expected}");
            }
        }
    }
    // The other quaternion of the same rotation.
    let mut pose = object_ahead().isometry();
    pose.rotation = UnitQuaternion::new_unchecked(Quaternion::from(-pose.rotation.coords));
    assert_eq!(
        object_error(&session, &everywhere(Pose::new(pose)))
            .angle
            .max,
        0.0
    );
}

#[test]
fn planned_objects_that_are_missing_or_no_numbers_are_left_out_and_counted() {
    let session = session();
    let counts = |objects: &Objects| {
        let error = object_error(&session, objects);
        assert_eq!(error.position.n, error.angle.n);
        (error.position.n, error.position.n_left_out)
    };
    let mut objects = everywhere(object_ahead());
    assert_eq!(counts(&objects), (10, 6));
    objects[0].as_mut().unwrap()[2] = Pose::new(Isometry3::translation(f64::NAN, 0.0, 0.0));
    assert_eq!(counts(&objects), (9, 7));
    objects[2] = Some(vec![object_ahead(); SAMPLES + 1]);
    assert_eq!(counts(&objects), (5, 11));
    objects.truncate(1);
    assert_eq!(counts(&objects), (3, 13));
    objects[0] = None;
    assert_eq!(counts(&objects), (0, 16));
    assert!(object_error(&session, &objects).angle.p50.is_nan());

    // A failed plan has no object either.
    let mut copies = session.copies();
    copies[0] = None;
    let objects = everywhere(object_ahead());
    let result = MethodResult {
        objects: Some(&objects),
        ..method(&copies)
    };
    let error = session.judge(&result).0.object_error.unwrap();
    assert_eq!((error.angle.n, error.angle.n_left_out), (6, 10));
}

#[test]
fn objects_are_compared_where_there_are_two() {
    let mut session = session();
    assert!(session.evaluate(&session.copies()).0.object_error.is_none());
    // Poses need no shape.
    session.shape = None;
    let evaluation = with_objects(&session, &everywhere(off(Vector3::zeros())));
    assert!(evaluation.contact.is_none());
    assert_eq!(evaluation.object_error.unwrap().position.n, 10);
    session.motions[0].object = None;
    let evaluation = with_objects(&session, &everywhere(off(Vector3::zeros())));
    assert!(evaluation.object_error.is_none());
}

#[test]
fn filled_poses_are_counted() {
    let mut session = session();
    let object = session.motions[0].object.as_mut().unwrap();
    for k in [2, 9, 13] {
        object.set(k, Some(object_ahead()), Status::Filled);
    }
    // Sample 13 is in no segment.
    assert_eq!(
        object_error(&session, &everywhere(object_ahead()))
            .position
            .n_filled,
        2
    );
}

#[test]
fn segments_that_carry_the_object_are_judged_as_those_that_do_not() {
    let mut session = session();
    let copies = session.copies();
    let (plain, plain_rows) = session.evaluate(&copies);

    let layout = SegmentLayout {
        object: true,
        ..session.segments.layout()
    };
    let fingers = session.segments.columns_m();
    let columns = DMatrix::from_fn(layout.rows(), session.segments.len(), |row, segment| {
        if row < layout.finger_rows() {
            fingers[(row, segment)]
        } else {
            7.0
        }
    });
    let (origins, ends) = (
        session.segments.origins().to_vec(),
        session.segments.ends().to_vec(),
    );
    session.segments = Segments::new(layout, columns, origins, ends, 1).unwrap();
    // Trajectories of either layout have the same fingertips.
    for trajectories in [session.copies(), copies] {
        let (evaluation, rows) = session.evaluate(&trajectories);
        assert_eq!(evaluation, plain);
        assert_eq!(rows.error_m, plain_rows.error_m);
        assert_eq!(rows.hull_distance_m, plain_rows.hull_distance_m);
    }
}

fn coverage(
    session: &Session,
    mahalanobis: &[Option<Vec<PerFinger<f64>>>],
    widths: &[Calibration],
) -> Vec<CorridorCoverage> {
    let copies = session.copies();
    let corridors = Corridors {
        mahalanobis,
        widths,
    };
    let result = MethodResult {
        corridors: Some(corridors),
        ..method(&copies)
    };
    session.judge(&result).0.corridors
}

/// Fractions of the powers of the root of x^5 = x + 1: points spread evenly over four dimensions.
fn even_points(count: usize) -> impl Iterator<Item = [f64; 4]> {
    let root = 1.167_303_978_261_418_7_f64;
    (1..=count).map(move |k| [1, 2, 3, 4].map(|power| (0.5 + k as f64 * root.powi(-power)).fract()))
}

/// Share of a normal distribution in three dimensions within Mahalanobis distance `r`: the chi
/// distribution with three degrees of freedom.
fn share_of_normal(r: f64) -> f64 {
    // erf(r / sqrt 2) by its series.
    let x = r / SQRT_2;
    let (mut term, mut sum) = (x, x);
    for n in 1..100_u32 {
        term *= -x * x / f64::from(n);
        sum += term / f64::from(2 * n + 1);
    }
    2.0 / PI.sqrt() * sum - (2.0 / PI).sqrt() * r * (-r * r / 2.0).exp()
}

#[test]
fn a_corridor_of_the_right_covariance_holds_what_it_states() {
    let samples = 1000;
    let tips = vec![beside_cube([0.001; 5]); samples];
    let session = Session::new(
        vec![motion(10.0, &tips, None)],
        samples,
        &[(0, 0)],
        0,
        anywhere(),
    );
    // Deviations L z in millimetres, z normal, measured by C = L L'.
    let factor = Matrix3::new(2.0, 0.0, 0.0, 1.5, 0.4, 0.0, -0.7, 0.9, 3.0) * 1e-3;
    let inverse = (factor * factor.transpose()).try_inverse().unwrap();
    let mut points = even_points(5 * samples);
    let mut distance = |scale: f64| {
        let [a, b, c, d] = points.next().unwrap();
        let (r, s) = ((-2.0 * a.ln()).sqrt(), (-2.0 * c.ln()).sqrt());
        let z = Vector3::new(
            r * (TAU * b).cos(),
            r * (TAU * b).sin(),
            s * (TAU * d).cos(),
        );
        let deviation = factor * z * scale;
        deviation.dot(&(inverse * deviation)).sqrt()
    };
    // The little finger moves twice as far as its corridor thinks.
    let distances = (0..samples)
        .map(|_| {
            PerFinger::from_fn(|finger| distance(if finger == Finger::Little { 2.0 } else { 1.0 }))
        })
        .collect();
    let widths = [1.538_172_254, 2.795_483_483].map(|mahalanobis| Calibration {
        share: share_of_normal(mahalanobis),
        mahalanobis,
    });
    assert!((widths[0].share - 0.5).abs() < 1e-9 && (widths[1].share - 0.95).abs() < 1e-9);
    let found = coverage(&session, &[Some(distances)], &widths);
    assert_eq!(found.len(), 2);
    for (found, width) in found.iter().zip(widths) {
        assert_eq!(
            (found.share_stated, found.mahalanobis),
            (width.share, width.mahalanobis)
        );
        assert_eq!(
            (found.n, found.n_filled, found.n_left_out),
            (5 * samples, 0, 0)
        );
        for finger in Finger::ALL {
            let expected = if finger == Finger::Little {
                share_of_normal(width.mahalanobis / 2.0)
            } else {
                width.share
            };
            let inside = found.share_inside.by_finger[finger];
            assert!(
                (inside - expected).abs() < 0.02,
                "{finger}: {inside} {expected}"
            );
        }
        let pooled = (4.0 * width.share + share_of_normal(width.mahalanobis / 2.0)) / 5.0;
        assert!(
            (found.share_inside.all - pooled).abs() < 0.01,
            "{}",
            found.share_inside.all
        );
    }
}

#[test]
fn instants_without_corridor_are_left_out_and_counted() {
    let mut session = session();
    let ring = &mut session.motions[0].fingertips[Finger::Ring];
    let place = ring.get(2);
    ring.set(2, place, Status::Filled);
    // Thumb always at 1, ring at 2 but for a corridor of no width and none at all, the others at 0.
    let distances = PerFinger::new([1.0, 0.0, 0.0, 2.0, 0.0]);
    let mut first = vec![distances; SAMPLES];
    first[0][Finger::Ring] = f64::INFINITY;
    first[3][Finger::Ring] = f64::NAN;
    let mahalanobis = [Some(first), None, Some(vec![distances; SAMPLES - 1])];
    let width = |mahalanobis| Calibration {
        share: 0.5,
        mahalanobis,
    };
    let found = coverage(
        &session,
        &mahalanobis,
        &[width(0.999), width(1.0), width(1e300)],
    );
    for coverage in &found {
        // Of 5 fingers, 4 segments, 4 samples.
        assert_eq!(
            (coverage.n, coverage.n_filled, coverage.n_left_out),
            (19, 1, 61)
        );
    }
    let by_finger = |k: usize| found[k].share_inside.by_finger.into_array();
    assert_eq!(by_finger(0), [0.0, 1.0, 1.0, 0.0, 1.0]);
    // On the edge is inside.
    assert_eq!(by_finger(1), [1.0, 1.0, 1.0, 0.0, 1.0]);
    assert_eq!(by_finger(2), [1.0, 1.0, 1.0, 2.0 / 3.0, 1.0]);
    let pooled: Vec<f64> = found
        .iter()
        .map(|coverage| coverage.share_inside.all)
        .collect();
    assert_eq!(pooled, [12.0 / 19.0, 16.0 / 19.0, 18.0 / 19.0]);

    let nothing = coverage(&session, &[], &[width(1.0)]);
    assert_eq!((nothing[0].n, nothing[0].n_left_out), (0, 80));
    assert!(nothing[0].share_inside.all.is_nan());
    assert!(coverage(&session, &mahalanobis, &[]).is_empty());
    assert!(session.evaluate(&session.copies()).0.corridors.is_empty());
}
