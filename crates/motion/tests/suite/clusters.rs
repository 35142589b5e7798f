//! Templates and poses of marker clusters.

use std::borrow::Cow;

use inhand_model::{Finger, Marker, Recording, Roles, Status, TrackedBody};
use inhand_motion::{BodyRole, MotionError, Templates, fit_templates, process, role_body};
use nalgebra::{Isometry3, Rotation3, Vector3};
use proptest::prelude::*;

use crate::{PLAIN, body, cluster, marker, recording, rigid_body, roles};

const NAMES: [&str; 4] = ["a", "b", "c", "d"];

/// A cluster in its own frame already: centroid at the origin, first to second along x, the first
/// three in a plane of constant z, the third on the side of y.
fn own_frame() -> [Vector3<f64>; 4] {
    let points = [
        Vector3::new(0.0, 0.0, 0.0),
        Vector3::new(0.06, 0.0, 0.0),
        Vector3::new(0.01, 0.04, 0.0),
        Vector3::new(0.02, 0.01, 0.03),
    ];
    let centre = points.iter().sum::<Vector3<f64>>() / 4.0;
    points.map(|point| point - centre)
}

fn placed(pose: &Isometry3<f64>, point: Vector3<f64>) -> Vector3<f64> {
    pose.rotation * point + pose.translation.vector
}

/// A take with the cluster `points` at each of the poses, and five fingertips at the origin.
/// `change` may hide or move a marker, by its index and sample.
fn take(
    points: &[Vector3<f64>],
    poses: &[Isometry3<f64>],
    change: impl Fn(usize, usize, Vector3<f64>) -> Option<Vector3<f64>>,
) -> Recording {
    let cluster = points.iter().enumerate().map(|(i, &point)| {
        let track = poses.iter().enumerate();
        let track = track.map(|(k, pose)| change(i, k, placed(pose, point)).map(Into::into));
        marker(NAMES[i], track.collect::<Vec<_>>())
    });
    let tips = Finger::ALL.map(|finger| marker(finger.name(), vec![Some([0.0; 3]); poses.len()]));
    let markers: Vec<Marker> = cluster.chain(tips).collect();
    recording(100.0, markers, vec![])
}

fn hand_cluster(names: &[&str]) -> Roles {
    roles(cluster(names), None)
}

fn fitted_hand(take: &Recording, roles: &Roles, templates: &Templates) -> TrackedBody {
    let body = role_body(take, BodyRole::Hand, &roles.hand, templates);
    body.expect("the templates fit the take").into_owned()
}

fn template(take: &Recording, names: &[&str]) -> Result<Vec<Vector3<f64>>, MotionError> {
    let templates = fit_templates([(take, &hand_cluster(names))])?;
    Ok(templates.get(BodyRole::Hand).unwrap().positions_m.to_vec())
}

fn pose() -> impl Strategy<Value = Isometry3<f64>> {
    (
        prop::array::uniform3(-1.5..1.5),
        prop::array::uniform3(-3.0..3.0),
    )
        .prop_map(|(p, r)| Isometry3::new(Vector3::from(p), Vector3::from(r)))
}

fn poses() -> impl Strategy<Value = Vec<Isometry3<f64>>> {
    prop::collection::vec(pose(), 1..12)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// A rigid cluster gives itself as template, and the poses it was placed at; three of its
    /// markers are as good as four, and lie in a plane.
    #[test]
    fn rigid_motion_is_recovered(poses in poses(), count in 3_usize..5) {
        let own = own_frame();
        let names = &NAMES[..count];
        let points = &own[..count];
        let take = take(points, &poses, |_, _, point| Some(point));
        let roles = hand_cluster(names);
        let templates = fit_templates([(&take, &roles)]).unwrap();
        let template = templates.get(BodyRole::Hand).unwrap();
        prop_assert_eq!(template.frames, poses.len());
        prop_assert!(template.rms_m < 1e-12);
        let centre = points.iter().sum::<Vector3<f64>>() / count as f64;
        for (found, point) in template.positions_m.iter().zip(points) {
            prop_assert!((found - (point - centre)).norm() < 1e-12);
        }

        let body = fitted_hand(&take, &roles, &templates);
        for (k, pose) in poses.iter().enumerate() {
            let found = body.track.get(k).unwrap().isometry();
            prop_assert!((found.translation.vector - placed(pose, centre)).norm() < 1e-12);
            prop_assert!(found.rotation.angle_to(&pose.rotation) < 1e-12);
            prop_assert!(body.marker_error_m.as_ref().unwrap()[k] < 1e-12);
        }
    }

    /// With noise the fit is still a rotation, and no small change of it is better.
    #[test]
    fn noisy_fits_are_proper_and_least_squares(
        pose in pose(), noise in prop::array::uniform12(-2e-3..2e-3), axis in 0_usize..3,
    ) {
        let own = own_frame();
        let templates = fit_templates([(
            &take(&own, &[Isometry3::identity()], |_, _, point| Some(point)),
            &hand_cluster(&NAMES),
        )]).unwrap();
        let moved = |i: usize, point: Vector3<f64>| {
            point + Vector3::new(noise[3 * i], noise[3 * i + 1], noise[3 * i + 2])
        };
        let take = take(&own, &[pose], |i, _, point| Some(moved(i, point)));
        let body = fitted_hand(&take, &hand_cluster(&NAMES), &templates);
        let fit = body.track.get(0).unwrap().isometry();
        let matrix = fit.rotation.to_rotation_matrix();
        prop_assert!((matrix.matrix().determinant() - 1.0).abs() < 1e-12);

        let cost = |fit: &Isometry3<f64>| -> f64 {
            (own.iter().enumerate())
                .map(|(i, &point)| (placed(fit, point) - moved(i, placed(&pose, point))).norm_squared())
                .sum()
        };
        for sign in [-1.0, 1.0] {
            let mut step = Vector3::zeros();
            step[axis] = sign * 1e-4;
            let turned = Isometry3::from_parts(
                fit.translation,
                Rotation3::from_scaled_axis(step) * fit.rotation,
            );
            let shifted = Isometry3::from_parts((fit.translation.vector + step).into(), fit.rotation);
            prop_assert!(cost(&fit) < cost(&turned) && cost(&fit) < cost(&shifted));
        }
    }
}

#[test]
fn a_mirrored_cluster_gets_a_rotation_all_the_same() {
    // Markers swapped by the capture software look like a mirror image; the answer is the best
    // rotation, and the residual says that it is a poor one.
    let own = own_frame();
    let templates = fit_templates([(
        &take(&own, &[Isometry3::identity()], |_, _, point| Some(point)),
        &hand_cluster(&NAMES),
    )])
    .unwrap();
    let mirrored = own.map(|point| Vector3::new(point.x, point.y, -point.z));
    let take = take(&mirrored, &[Isometry3::identity()], |_, _, point| {
        Some(point)
    });
    let body = fitted_hand(&take, &hand_cluster(&NAMES), &templates);
    let rotation = body.track.get(0).unwrap().isometry().rotation;
    assert!((rotation.to_rotation_matrix().matrix().determinant() - 1.0).abs() < 1e-12);
    assert!(body.marker_error_m.as_ref().unwrap()[0] > 1e-3);
}

#[test]
fn the_axes_are_those_of_the_first_three_markers() {
    // With these markers x points along the world's z and the normal along the world's x.
    let points = [[0.0, 0.0, 0.0], [0.0, 0.0, 0.06], [0.0, 0.03, 0.0]].map(Vector3::from);
    let take = take(&points, &[Isometry3::identity()], |_, _, point| Some(point));
    let found = template(&take, &NAMES[..3]).unwrap();
    // (m2 - m1) x (m3 - m1) = z x y = -x in the world; y = normal x (m2 - m1) = -x x z = y.
    let expected = [[-0.02, -0.01, 0.0], [0.04, -0.01, 0.0], [-0.02, 0.02, 0.0]];
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - Vector3::from(expected)).norm() < 1e-15, "{found}");
    }
    let roles = hand_cluster(&NAMES[..3]);
    let templates = fit_templates([(&take, &roles)]).unwrap();
    let motion = process(&take, &roles, &templates, &PLAIN).unwrap();
    let world_from_hand = motion.hand.get(0).unwrap().isometry();
    for (hand, world) in [
        (Vector3::x(), Vector3::z()),
        (Vector3::y(), Vector3::y()),
        (Vector3::z(), -Vector3::x()),
    ] {
        assert!((world_from_hand.rotation * hand - world).norm() < 1e-15);
    }
}

#[test]
fn the_template_is_the_mean_of_what_the_frames_show() {
    // The fourth marker is seen 1 mm to either side of its place, along the normal, in turn: the mean
    // is its place, to second order in the tilt that the odd marker gives each fit.
    let own = own_frame();
    let poses: Vec<_> = (0..10)
        .map(|k| Isometry3::rotation(Vector3::new(0.3, 0.2, 0.1) * f64::from(k)))
        .collect();
    let take = take(&own, &poses, |i, k, point| {
        let side = if k % 2 == 0 { 1e-3 } else { -1e-3 };
        let normal = poses[k].rotation * Vector3::z();
        Some(if i == 3 { point + side * normal } else { point })
    });
    let found = template(&take, &NAMES).unwrap();
    for (found, own) in found.iter().zip(own) {
        assert!((found - own).norm() < 2e-5);
    }
}

#[test]
fn threads_make_no_difference() {
    // More frames than are summed at a time, with noise, so that another order of sums would show.
    let poses: Vec<_> = (0..3000)
        .map(|k| {
            Isometry3::new(
                Vector3::x() * 1e-4 * f64::from(k),
                Vector3::y() * 1e-3 * f64::from(k),
            )
        })
        .collect();
    let take = take(&own_frame(), &poses, |i, k, point| {
        Some(point + Vector3::from_fn(|axis, _| 1e-3 * ((k * 37 + i * 11 + axis * 5) as f64).sin()))
    });
    let roles = hand_cluster(&NAMES);
    let with_threads = |count| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(count)
            .build()
            .unwrap();
        pool.install(|| {
            let templates = fit_templates([(&take, &roles)]).unwrap();
            let body = fitted_hand(&take, &roles, &templates);
            (templates, body.track.values().collect::<Vec<_>>())
        })
    };
    let alone = with_threads(1);
    assert!(alone.0.get(BodyRole::Hand).unwrap().rms_m > 5e-4);
    assert!(alone == with_threads(2) && alone == with_threads(5));
}

#[test]
fn one_hidden_marker_is_no_gap_and_two_are() {
    let own = own_frame();
    let poses = vec![Isometry3::rotation(Vector3::y() * 0.4); 6];
    let take = take(&own, &poses, |i, k, point| {
        let hidden = (k == 2 && i == 1) || (k == 4 && i < 2);
        (!hidden).then_some(point)
    });
    let roles = hand_cluster(&NAMES);
    let templates = fit_templates([(&take, &roles)]).unwrap();
    assert_eq!(templates.get(BodyRole::Hand).unwrap().frames, 4);
    let body = fitted_hand(&take, &roles, &templates);
    assert_eq!(body.name, "hand");
    for k in 0..6 {
        let expected = if k == 4 {
            Status::Missing
        } else {
            Status::Measured
        };
        assert_eq!(body.track.status(k), expected);
        assert_eq!(body.marker_error_m.as_ref().unwrap()[k].is_nan(), k == 4);
    }
    let pose = body.track.get(2).unwrap().isometry();
    assert!(pose.rotation.angle_to(&poses[2].rotation) < 1e-12);
}

#[test]
fn seen_markers_on_a_line_give_no_pose() {
    let points =
        [[0.0, 0.0], [0.03, 0.0], [0.03, 0.05], [0.06, 0.0]].map(|[x, y]| Vector3::new(x, y, 0.0));
    // Sample 1 hides the one marker off the line.
    let take = take(&points, &[Isometry3::identity(); 2], |i, k, point| {
        (k == 0 || i != 2).then_some(point)
    });
    let roles = hand_cluster(&NAMES);
    let templates = fit_templates([(&take, &roles)]).unwrap();
    let body = fitted_hand(&take, &roles, &templates);
    assert_eq!(body.track.statuses(), [Status::Measured, Status::Missing]);
}

#[test]
fn rigid_bodies_need_no_template() {
    let take = take(&own_frame(), &[Isometry3::identity()], |_, _, point| {
        Some(point)
    });
    let roles = roles(rigid_body("Hand"), Some(rigid_body("Object")));
    assert_eq!(
        fit_templates([(&take, &roles)]).unwrap(),
        Templates::default()
    );
    assert_eq!(fit_templates([]).unwrap(), Templates::default());
}

fn assert_refused<T: std::fmt::Debug>(found: Result<T, MotionError>, why: &str) {
    let error = found.expect_err(why);
    assert!(matches!(error, MotionError::Body(_)), "{error:?}");
    assert!(error.to_string().contains(why), "{error}");
}

#[test]
fn clusters_that_make_no_frame_are_refused() {
    let identity = [Isometry3::identity()];
    let whole = take(&own_frame(), &identity, |_, _, point| Some(point));
    for names in [&["a", "b"][..], &["a", "b", "a"], &[]] {
        assert_refused(template(&whole, names), "the hand is a cluster of ");
    }
    assert!(matches!(
        template(&whole, &["a", "b", "z"]),
        Err(MotionError::NotInTake { kind: "marker", .. })
    ));

    let line = [0.0, 0.02, 0.05].map(|x| Vector3::new(x, 2.0 * x, 1e-4));
    let take_of = |points: &[Vector3<f64>]| take(points, &identity, |_, _, point| Some(point));
    let same = [Vector3::new(0.1, 0.2, 0.3); 3];
    let two_the_same = [Vector3::zeros(), Vector3::zeros(), Vector3::x() * 0.05];
    for points in [line, same, two_the_same] {
        let found = template(&take_of(&points), &NAMES[..3]);
        assert_refused(found, "of the hand lie on a line");
    }
    // The first three define the axes, whatever the fourth does.
    let bent = [line[0], line[1], line[2], Vector3::new(0.0, 0.0, 0.08)];
    let found = template(&take_of(&bent), &NAMES);
    assert_refused(
        found,
        r#"the markers "a", "b", "c" of the hand lie on a line"#,
    );

    let never_whole = take(&own_frame(), &[Isometry3::identity(); 4], |i, k, point| {
        (i != k).then_some(point)
    });
    assert_refused(template(&never_whole, &NAMES), "are never all seen at once");
}

#[test]
fn a_body_is_the_same_thing_in_all_takes() {
    let take = take(&own_frame(), &[Isometry3::identity()], |_, _, point| {
        Some(point)
    });
    let (abc, bac, body) = (
        hand_cluster(&["a", "b", "c"]),
        hand_cluster(&["b", "a", "c"]),
        roles(rigid_body("Hand"), None),
    );
    for other in [&bac, &body] {
        let found = fit_templates([(&take, &abc), (&take, other)]);
        assert_refused(found, "its frame needs one definition");
    }
    // An object that training does not track is no difference.
    let with_object = roles(cluster(&["a", "b", "c"]), Some(cluster(&["b", "c", "d"])));
    let templates = fit_templates([(&take, &abc), (&take, &with_object)]).unwrap();
    assert_eq!(templates.get(BodyRole::Object).unwrap().frames, 1);

    let templates = fit_templates([(&take, &abc)]).unwrap();
    let found = process(&take, &bac, &templates, &PLAIN);
    assert_refused(found, r#"but the template is of "a", "b", "c""#);
}

/// Neither fitted nor copied, though the take has markers that could be a cluster.
#[test]
fn a_rigid_body_of_the_recording_is_not_fitted() {
    let poses = [Some(Isometry3::translation(0.1, 0.2, 0.3)), None];
    let markers = NAMES.map(|name| marker(name, vec![Some([0.0; 3]); poses.len()]));
    let bodies = vec![body("Other", poses), body("Glove", poses)];
    let take = recording(100.0, markers.into(), bodies);
    let templates = Templates::default();
    for role in [BodyRole::Hand, BodyRole::Object] {
        let found = role_body(&take, role, &rigid_body("Glove"), &templates).unwrap();
        assert!(matches!(found, Cow::Borrowed(found) if std::ptr::eq(found, &take.bodies[1])));
    }
}
