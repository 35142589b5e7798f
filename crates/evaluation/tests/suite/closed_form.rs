//! Sessions whose evaluation can be written down.

use inhand_model::{Finger, PerFinger, Trajectory, in_contact};

use crate::session::{Session, anywhere, beside_cube, fill, motion, object_ahead};

const NEAR: f64 = 1e-12;

fn near(found: f64, expected: f64) {
    assert!(
        (found - expected).abs() < NEAR,
        "expected {expected}, found {found}"
    );
}

/// Two segments of four samples at 10 Hz in a take of ten; at rest, the pads 1, 2, 3, 4 and 20 mm
/// from the cube.
fn at_rest() -> Session {
    let tips = vec![beside_cube([0.001, 0.002, 0.003, 0.004, 0.020]); 10];
    let object = vec![Some(object_ahead()); 10];
    Session::new(
        vec![motion(10.0, &tips, Some(&object))],
        4,
        &[(0, 1), (0, 5)],
        0,
        anywhere(),
    )
}

/// All recorded segments, every coordinate along y moved by `shift_m` for each finger.
fn moved(session: &Session, shift_m: [f64; 5]) -> Vec<Option<Trajectory>> {
    (0..session.segments.len())
        .map(|segment| {
            let mut values = session.segments.fingertips_m(segment).to_vec();
            for configuration in values.chunks_exact_mut(15) {
                for (finger, shift) in shift_m.iter().enumerate() {
                    configuration[3 * finger + 1] += shift;
                }
            }
            Some(session.trajectory(values))
        })
        .collect()
}

#[test]
fn a_copy_of_the_recording_has_no_error() {
    let session = at_rest();
    let (evaluation, rows) = session.evaluate(&session.copies());
    assert_eq!(
        (evaluation.error.all.n, evaluation.error.all.n_left_out),
        (40, 0)
    );
    assert_eq!(
        (evaluation.error.all.max, evaluation.error.all.rmse),
        (0.0, 0.0)
    );
    assert_eq!(evaluation.error_at_start.n, 10);
    assert_eq!(evaluation.error_at_goal.max, 0.0);
    assert_eq!(evaluation.median_error_by_sample_m, [0.0; 4]);
    assert_eq!(rows.error_m.len(), 8);

    let contact = evaluation.contact.unwrap();
    assert_eq!((contact.n, contact.n_filled, contact.n_left_out), (8, 0, 0));
    assert_eq!(
        (contact.three_or_more, contact.recorded_three_or_more),
        (1.0, 1.0)
    );
    assert_eq!(contact.by_finger, PerFinger::new([1.0, 1.0, 1.0, 1.0, 0.0]));
    assert_eq!(contact.by_finger, contact.recorded_by_finger);
    assert_eq!(
        evaluation.distance_difference.unwrap()[Finger::Ring].max,
        0.0
    );

    // The third nearest pad is 3 mm away.
    let shares: Vec<f64> = contact
        .by_tau
        .iter()
        .map(|share| share.three_or_more)
        .collect();
    assert_eq!(
        shares,
        [0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0]
    );

    assert_eq!(evaluation.velocity.n, 2 * 3 * 15);
    assert_eq!(
        (evaluation.velocity.outside, evaluation.velocity.worst_ratio),
        (0, 0.0)
    );
    assert!(evaluation.plan.is_none());
}

#[test]
fn known_shifts_are_found_again() {
    let session = at_rest();
    let shift_m = [0.001, -0.002, 0.003, 0.0, 0.005];
    let (evaluation, rows) = session.evaluate(&moved(&session, shift_m));
    for (finger, statistics) in evaluation.error.by_finger.iter() {
        let expected = shift_m[finger.index()].abs();
        for found in [
            statistics.min,
            statistics.p50,
            statistics.max,
            statistics.mean,
            statistics.rmse,
        ] {
            near(found, expected);
        }
    }
    // 0, 1, 2, 3 and 5 mm, eight times each.
    let pooled = &evaluation.error.all;
    near(pooled.mean, 0.0022);
    near(pooled.rmse, (39.0_f64 / 5.0).sqrt() * 1e-3);
    near(pooled.p25, 0.001);
    near(pooled.p50, 0.002);
    near(pooled.p75, 0.003);
    near(pooled.whisker_high, 0.005);
    near(evaluation.error_at_goal.p50, 0.002);
    for median in &evaluation.median_error_by_sample_m {
        near(*median, 0.002);
    }

    // Pads now at 2, 0, 6, 4 and 25 mm: three in contact, other ones.
    let contact = evaluation.contact.unwrap();
    assert_eq!(contact.three_or_more, 1.0);
    assert_eq!(contact.by_finger, PerFinger::new([1.0, 1.0, 0.0, 1.0, 0.0]));
    assert_eq!(
        contact.recorded_by_finger,
        PerFinger::new([1.0, 1.0, 1.0, 1.0, 0.0])
    );
    let distance_m = rows.distance_m.unwrap();
    let touching = distance_m[7].map(|d| in_contact(d, 0.005));
    let distance_m = distance_m[0];
    for (found, expected) in distance_m
        .into_array()
        .into_iter()
        .zip([0.002, 0.0, 0.006, 0.004, 0.025])
    {
        near(found, expected);
    }
    assert_eq!(touching, PerFinger::new([true, true, false, true, false]));
    near(
        evaluation.distance_difference.unwrap()[Finger::Little].p95,
        0.005,
    );
}

#[test]
fn offsets_reach_from_marker_to_pad() {
    let mut session = at_rest();
    session.settings.finger_offsets_m[Finger::Little] = 0.015;
    let (evaluation, _) = session.evaluate(&session.copies());
    assert_eq!(evaluation.contact.unwrap().by_finger[Finger::Little], 1.0);
}

#[test]
fn fingers_deep_in_the_object_are_not_in_contact() {
    let session = at_rest();
    // Pads at 1, -5, -6, -4 and 20 mm.
    let shift_m = [0.0, -0.007, -0.009, -0.008, 0.0];
    let (evaluation, rows) = session.evaluate(&moved(&session, shift_m));
    let distance_m = rows.distance_m.unwrap()[3];
    for (found, expected) in
        (distance_m.into_array().into_iter()).zip([0.001, -0.005, -0.006, -0.004, 0.020])
    {
        near(found, expected);
    }
    let touching = distance_m.map(|d| in_contact(d, 0.005));
    assert_eq!(touching, PerFinger::new([true, true, false, true, false]));
    let contact = evaluation.contact.unwrap();
    assert_eq!(contact.by_finger, PerFinger::new([1.0, 1.0, 0.0, 1.0, 0.0]));
    assert_eq!(contact.three_or_more, 1.0);
    // The third nearest to the surface is 5 mm below it.
    for share in &contact.by_tau {
        let expected = f64::from(u8::from(share.tau_m >= 0.005));
        assert_eq!(share.three_or_more, expected, "{}", share.tau_m);
    }
    // As far inside as outside is no difference.
    let difference = evaluation.distance_difference.unwrap();
    near(difference[Finger::Ring].max, 0.0);
    near(difference[Finger::Middle].p50, 0.003);

    // All five in the object, three of them deep.
    let (evaluation, _) =
        session.evaluate(&moved(&session, [-0.010, -0.012, -0.015, -0.014, -0.030]));
    let contact = evaluation.contact.unwrap();
    assert_eq!(contact.three_or_more, 0.0);
    assert_eq!(contact.recorded_three_or_more, 1.0);
}

#[test]
fn contact_at_exactly_tau_is_contact() {
    // 5 mm beside a rotated object, where rounding goes either way.
    for k in 0..50 {
        let turn = nalgebra::Isometry3::new(
            nalgebra::Vector3::new(0.1, 0.01 * f64::from(k), 0.0),
            nalgebra::Vector3::new(0.0, 0.1 * f64::from(k), 0.3),
        );
        let object = inhand_model::Pose::new(turn);
        let tips = PerFinger::from_fn(|finger| {
            object * inhand_model::Position::new(0.01 * finger.index() as f64 - 0.02, 0.03, 0.0)
        });
        let motion = motion(10.0, &[tips; 4], Some(&[Some(object); 4]));
        let session = Session::new(vec![motion], 4, &[(0, 0)], 0, anywhere());
        let (evaluation, _) = session.evaluate(&session.copies());
        assert_eq!(
            evaluation.contact.unwrap().by_finger,
            PerFinger::new([1.0; 5]),
            "{k}"
        );
    }
}

#[test]
fn collisions_are_counted_by_instant_and_trajectory() {
    let session = at_rest();
    let mut planned = session.copies();
    // Ring on the middle finger, 9 mm apart, at two instants of the second trajectory.
    let mut values = planned[1].as_ref().unwrap().values_m().to_vec();
    for t in [1, 2] {
        for axis in 0..3 {
            values[15 * t + 9 + axis] = values[15 * t + 6 + axis] + [0.0, 0.0, 0.009][axis];
        }
    }
    planned[1] = Some(session.trajectory(values));
    let (evaluation, rows) = session.evaluate(&planned);
    let collision = evaluation.collision;
    assert_eq!(
        (collision.n, collision.instants, collision.trajectories),
        (8, 2, 1)
    );
    assert_eq!(collision.recorded_instants, 0);
    assert_eq!(collision.nearest_pair, Some((Finger::Middle, Finger::Ring)));
    near(collision.nearest_m, 0.009);
    // 12 mm along x and 1 mm in depth.
    near(collision.recorded_nearest_m, 1.45e-4_f64.sqrt());
    near(rows.nearest_pair_m[5], 0.009);
}

#[test]
fn reachability_counts_what_leaves_the_hull() {
    let session = at_rest();
    let mut planned = session.copies();
    let mut values = planned[0].as_ref().unwrap().values_m().to_vec();
    // The hulls end at half a metre.
    values[2] = 0.503;
    values[15 + 2] = 0.501;
    planned[0] = Some(session.trajectory(values));
    let (evaluation, rows) = session.evaluate(&planned);
    let reachability = evaluation.reachability;
    assert_eq!(reachability.n, 8);
    assert_eq!(
        reachability.inside,
        PerFinger::new([0.75, 1.0, 1.0, 1.0, 1.0])
    );
    assert_eq!(reachability.recorded_inside, PerFinger::new([1.0; 5]));
    near(reachability.worst_outside_m[Finger::Thumb], 0.003);
    assert_eq!(reachability.worst_outside_m[Finger::Index], 0.0);
    near(reachability.distance[Finger::Thumb].max, 0.003);
    // The index is at x = 88 mm, 27 mm beside the middle.
    near(reachability.distance[Finger::Index].p50, 0.088 - 0.5);
    near(rows.hull_distance_m[1][Finger::Thumb], 0.001);
}

#[test]
fn velocities_are_compared_with_their_own_side() {
    let mut session = at_rest();
    session.velocity_bounds.max_m_s[4] = 0.02;
    session.velocity_bounds.min_m_s[4] = -0.05;
    let step = |dy: f64| {
        let mut planned = session.copies();
        let mut values = planned[0].as_ref().unwrap().values_m().to_vec();
        for t in 2..4 {
            values[15 * t + 4] += dy;
        }
        planned[0] = Some(session.trajectory(values));
        session.evaluate(&planned).0.velocity
    };
    // At 10 Hz a step of 2 mm is 0.02 m/s.
    let exact = step(0.002);
    assert_eq!((exact.n, exact.outside), (90, 0));
    near(exact.worst_ratio, 1.0);
    let above = step(0.003);
    assert_eq!((above.outside, above.trajectories_outside), (1, 1));
    near(above.worst_ratio, 1.5);
    let below = step(-0.004);
    assert_eq!(below.outside, 0);
    near(below.worst_ratio, 0.8);
    session.velocity_bounds.max_m_s[4] = 0.0;
    let planned = moved(&session, [0.0; 5]);
    assert_eq!(session.evaluate(&planned).0.velocity.worst_ratio, 0.0);
}

#[test]
fn filled_samples_count_where_they_matter() {
    let mut session = at_rest();
    fill(&mut session.motions[0].fingertips[Finger::Ring], 2);
    fill(&mut session.motions[0].fingertips[Finger::Ring], 3);
    fill(session.motions[0].object.as_mut().unwrap(), 3);
    fill(session.motions[0].object.as_mut().unwrap(), 8);
    fill(session.motions[0].object.as_mut().unwrap(), 9); // in no segment
    let (evaluation, _) = session.evaluate(&session.copies());
    assert_eq!(evaluation.error.all.n_filled, 2);
    assert_eq!(evaluation.error.by_finger[Finger::Ring].n_filled, 2);
    assert_eq!(evaluation.error.by_finger[Finger::Thumb].n_filled, 0);
    assert_eq!(
        (
            evaluation.error_at_start.n_filled,
            evaluation.error_at_goal.n_filled
        ),
        (0, 0)
    );
    assert_eq!(evaluation.contact.unwrap().n_filled, 3);
    let difference = evaluation.distance_difference.unwrap();
    assert_eq!(difference[Finger::Ring].n_filled, 3);
    assert_eq!(difference[Finger::Thumb].n_filled, 2);
    assert_eq!(evaluation.reachability.distance[Finger::Ring].n_filled, 2);
}
