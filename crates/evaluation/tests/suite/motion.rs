//! Measures of motion, and contacts over time, where they can be worked out by hand.

use inhand_evaluation::{DynamicsRows, JudgedMethod, MovementSettings, contact_dynamics, movement};
use inhand_model::{
    ContactDynamics, ContactRules, Finger, FingerSet, MethodRows, MovementAnalysis, MovementRows,
    PerFinger, Segments, Trajectory,
};

use crate::session::{Session, anywhere, beside_cube, fill, motion, object_ahead};

const RATE_HZ: f64 = 100.0;

const RULES: ContactRules = ContactRules {
    tau_m: 0.005,
    min_duration_s: 0.03,
    max_lift_s: 0.2,
    min_fingers: 3,
};

fn moved(
    session: &Session,
    name: &str,
    planned: &[Option<Trajectory>],
    demonstrations: Option<&Segments>,
) -> (MovementAnalysis, Vec<MovementRows>) {
    let rows = MethodRows {
        name: name.to_owned(),
        ..session.evaluate(planned).1
    };
    let method = judged(planned, &rows);
    session.with_data(|data| {
        let settings = MovementSettings::USUAL;
        movement(
            &data,
            &session.recorded(),
            &[method],
            demonstrations,
            &settings,
        )
    })
}

fn judged<'a>(trajectories: &'a [Option<Trajectory>], rows: &'a MethodRows) -> JudgedMethod<'a> {
    JudgedMethod { trajectories, rows }
}

/// Contacts of the session's takes, and of plans.
fn touched(session: &Session, planned: &[Option<Trajectory>]) -> (ContactDynamics, DynamicsRows) {
    let rows = session.evaluate(planned).1;
    let found = session.with_data(|data| {
        let method = judged(planned, &rows);
        contact_dynamics(
            &data,
            &session.recorded(),
            &[method],
            &session.settings,
            &RULES,
        )
    });
    let found = found.expect("the rules make sense");
    found.expect("there is an object")
}

/// Two segments of 20 samples: fingertips beside a cube go 1 mm a sample along y (the index stands still), and
/// back in the second one.
fn back_and_forth() -> Session {
    let tips: Vec<_> = (0..40)
        .map(|k| {
            let y = 0.001 * f64::from(if k < 20 { k } else { 39 - k });
            beside_cube([y, 0.0, y, y, y])
        })
        .collect();
    let mut motion = motion(RATE_HZ, &tips, Some(&[Some(object_ahead()); 40]));
    fill(&mut motion.fingertips[Finger::Ring], 25);
    Session::new(vec![motion], 20, &[(0, 0), (0, 20)], 1, anywhere())
}

#[test]
fn lengths_speeds_and_stillness() {
    let session = back_and_forth();
    let (found, rows) = moved(&session, "copy", &session.copies(), None);
    let thumb = found.recorded.by_finger[Finger::Thumb];
    assert_eq!((thumb.length_m.n, thumb.length_m.n_left_out), (2, 1));
    assert!((thumb.length_m.mean - 0.019).abs() < 1e-12);
    assert!((thumb.peak_speed_m_s.max - 0.1).abs() < 1e-12);
    assert_eq!(thumb.static_share.max, 0.0);
    // It does not move: no smoothness, but a length of 0.
    let index = found.recorded.by_finger[Finger::Index];
    assert_eq!((index.sparc.n, index.sparc.n_left_out), (0, 3));
    assert!(index.sparc.mean.is_nan() && index.ldlj.mean.is_nan());
    assert_eq!((index.length_m.n, index.length_m.max), (2, 0.0));
    assert_eq!(index.static_share.min, 1.0);
    assert_eq!(found.recorded.by_finger[Finger::Ring].length_m.n_filled, 1);
    assert_eq!(found.static_speed_m_s, 0.005);

    // What is planned as it was recorded is measured alike.
    assert_eq!(rows.len(), 2);
    assert_eq!(
        format!("{:?}", rows[0].segments),
        format!("{:?}", rows[1].segments)
    );
    assert_eq!(found.methods[0].0, "copy");
}

#[test]
fn without_demonstrations_nothing_is_near() {
    let session = back_and_forth();
    let (found, _) = moved(&session, "copy", &session.copies(), None);
    assert_eq!(found.recorded.nearest_demonstration_m, None);
    assert_eq!(
        (found.demonstrations, found.demonstrations_available),
        (0, 0)
    );
}

#[test]
fn the_nearest_demonstration_is_as_far_as_it_is_aside() {
    let session = back_and_forth();
    // Demonstrations of the same motion 3 and 2 mm aside (along x), the way back among them twice.
    let tips: Vec<_> = (0..80)
        .map(|k| {
            let y = 0.001 * f64::from(if k % 40 < 20 { k % 40 } else { 39 - k % 40 });
            let aside = if k < 40 { 0.003 } else { 0.002 };
            beside_cube([y, 0.0, y, y, y]).map(|tip| {
                let [x, y, z] = tip.to_array();
                [x + aside, y, z].into()
            })
        })
        .collect();
    let take = motion(RATE_HZ, &tips, None);
    let origins = [(0, 0), (0, 20), (0, 40), (0, 60)];
    let demonstrated = Session::new(vec![take], 20, &origins, 0, anywhere());
    let mut planned = session.copies();
    planned[1] = None;
    let (found, rows) = moved(&session, "half", &planned, Some(&demonstrated.segments));
    assert_eq!(
        (found.demonstrations, found.demonstrations_available),
        (4, 4)
    );
    assert_eq!(found.warping_band, Some(2));
    // Five fingertips, each 2 mm aside: the distance of configurations is that times the root of 5.
    let expected_m = 0.002 * 5.0_f64.sqrt();
    let recorded = found.recorded.nearest_demonstration_m.unwrap();
    assert_eq!(
        (recorded.n, recorded.n_filled, recorded.n_left_out),
        (2, 1, 1)
    );
    assert!((recorded.max - expected_m).abs() < 1e-12);
    let half = found.methods[0].1.nearest_demonstration_m.unwrap();
    assert_eq!((half.n, half.n_left_out), (1, 2));
    let nearest =
        |motion: usize, segment: usize| rows[motion].segments[segment].nearest_demonstration;
    assert_eq!([nearest(0, 0), nearest(0, 1)], [Some(2), Some(3)]);
    assert_eq!([nearest(1, 0), nearest(1, 1)], [Some(2), None]);
    assert!(
        rows[1].segments[1].by_finger[Finger::Thumb]
            .length_m
            .is_nan()
    );
    let length = found.methods[0].1.by_finger[Finger::Thumb].length_m;
    assert_eq!((length.n, length.n_left_out), (1, 2));
}

/// 60 samples: all but the little finger touch; the index lifts for samples 20 to 30 and sets down 6 mm further;
/// a flicker of one sample of the thumb counts for nothing; the middle is missing at 40 and 41; the ring leaves at
/// 50 for good.
fn one_gait() -> Session {
    let tips: Vec<_> = (0..60)
        .map(|k| {
            let index = if (20..30).contains(&k) { 0.02 } else { 0.0 };
            let thumb = if k == 10 { 0.02 } else { 0.001 };
            let ring = if k < 50 { 0.0 } else { 0.02 };
            let mut tips = beside_cube([thumb, index, 0.0, ring, 0.03]);
            if k >= 30 {
                let [x, y, z] = tips[Finger::Index].to_array();
                tips[Finger::Index] = [x, y, z + 0.006].into();
            }
            tips
        })
        .collect();
    let mut take = motion(RATE_HZ, &tips, Some(&[Some(object_ahead()); 60]));
    for k in [40, 41] {
        take.fingertips[Finger::Middle].set(k, None, inhand_model::Status::Missing);
    }
    fill(&mut take.fingertips[Finger::Index], 33);
    Session::new(vec![take], 20, &[(0, 0), (0, 20)], 0, anywhere())
}

#[test]
fn contacts_states_and_phases_of_a_take() {
    let session = one_gait();
    let (found, rows) = touched(&session, &session.copies());
    let take = &found.takes[0];
    assert_eq!((take.rate_hz, take.duration_s), (100.0, 0.6));
    let [thumb, index, middle, ring, little] = take.by_finger.as_array();
    assert_eq!(
        (thumb.duty, thumb.makes, thumb.breaks, thumb.censored),
        (1.0, 0, 0, 1)
    );
    assert_eq!((index.makes, index.breaks, index.censored), (1, 1, 2));
    assert!((index.duty - 50.0 / 60.0).abs() < 1e-12);
    assert_eq!(
        (index.duration_s.n, index.slip_m.n, index.slip_m.n_filled),
        (0, 2, 1)
    );
    assert!(index.slip_m.max < 1e-12);
    assert!((middle.known_s - 0.58).abs() < 1e-12);
    assert_eq!(
        (middle.makes, middle.breaks, middle.censored, middle.duty),
        (0, 0, 2, 1.0)
    );
    assert_eq!((ring.makes, ring.breaks, ring.censored), (0, 1, 1));
    assert_eq!((little.duty, little.censored, little.slip_m.n), (0.0, 0, 0));
    let near = |found: &[[f64; 2]], expected: &[[f64; 2]]| {
        found.len() == expected.len()
            && (found.iter().flatten().zip(expected.iter().flatten()))
                .all(|(a, b)| (a - b).abs() < 1e-12)
    };
    assert!(near(
        &take.contacts_s[Finger::Index],
        &[[0.0, 0.2], [0.3, 0.6]]
    ));
    assert!(near(&take.unknown_s[Finger::Middle], &[[0.4, 0.42]]));

    let set = |text: &str| {
        FingerSet::of(PerFinger::from_fn(|finger| {
            text.split('+').any(|name| name == finger.name())
        }))
    };
    let (four, three) = (set("thumb+index+middle+ring"), set("thumb+middle+ring"));
    let states: Vec<_> = take
        .states
        .iter()
        .map(|s| (s.fingers, s.samples, s.runs))
        .collect();
    assert_eq!(
        states,
        [
            (four, 38, 3),
            (set("thumb+index+middle"), 10, 1),
            (three, 10, 1)
        ]
    );
    assert!((take.states[0].share - 38.0 / 58.0).abs() < 1e-12);
    assert_eq!(take.states[2].duration_s.n, 1);
    assert!((take.states[2].duration_s.mean - 0.1).abs() < 1e-12);
    // From before the gap to after it nothing was seen to change.
    let transitions: Vec<_> = take
        .transitions
        .iter()
        .map(|t| (t.from, t.to, t.count))
        .collect();
    assert_eq!(transitions.len(), 3);
    assert!(transitions.contains(&(four, three, 1)) && transitions.contains(&(three, four, 1)));

    let kinds: Vec<_> = take.phases.iter().map(|phase| phase.kind.name()).collect();
    assert_eq!(
        kinds,
        [
            "in_grasp",
            "finger_gaiting",
            "in_grasp",
            "in_grasp",
            "in_grasp"
        ]
    );
    assert_eq!(take.phases[1].holding, three);
    let [gait] = take.gaits.as_slice() else {
        panic!("one gait, not {:?}", take.gaits);
    };
    assert_eq!((gait.finger, gait.holding), (Finger::Index, three));
    assert!(near(&[gait.span_s], &[[0.2, 0.3]]));
    assert!((gait.step_m - 0.006).abs() < 1e-12);
    assert_eq!(rows.takes[0].as_ref().unwrap().gaits[0].samples, 20..30);
}

#[test]
fn segments_stand_alone_and_failed_plans_are_left_out() {
    let session = one_gait();
    let mut planned = session.copies();
    planned[0] = None;
    let (found, rows) = touched(&session, &planned);
    let recorded = &found.recorded;
    assert_eq!(recorded.segments, 2);
    // Of the lift only the end is inside the second segment: its beginning is the segment's.
    let index = &recorded.by_finger[Finger::Index];
    assert_eq!((index.makes, index.breaks, index.censored), (1, 0, 2));
    assert!((index.known_s - 0.4).abs() < 1e-12);
    assert_eq!(recorded.by_fingers, [0, 0, 0, 10, 30, 0]);
    let (name, method) = &found.methods[0];
    assert_eq!((name.as_str(), method.segments), ("test", 1));
    assert_eq!(method.by_fingers, [0, 0, 0, 10, 10, 0]);
    assert!((method.by_finger[Finger::Index].duty - 0.5).abs() < 1e-12);
    assert_eq!(rows.segments[1][0].known(Finger::Thumb), 0);
    assert_eq!(rows.segments[0][1], rows.segments[1][1]);
}

#[test]
fn without_an_object_there_are_no_contacts_and_bad_rules_are_named() {
    let mut session = one_gait();
    let planned = session.copies();
    let rows = session.evaluate(&planned).1;
    let with = |session: &Session, rules: &ContactRules| {
        session.with_data(|data| {
            let method = judged(&planned, &rows);
            contact_dynamics(
                &data,
                &session.recorded(),
                &[method],
                &session.settings,
                rules,
            )
        })
    };
    let none = ContactRules {
        min_fingers: 6,
        ..RULES
    };
    let error = with(&session, &none).unwrap_err().to_string();
    assert!(
        error.contains("6 fingers") && error.contains("1 to 5"),
        "{error}"
    );
    let negative = ContactRules {
        min_duration_s: -1.0,
        ..RULES
    };
    let error = with(&session, &negative).unwrap_err().to_string();
    assert!(error.contains("min_duration_s is -1"), "{error}");
    session.shape = None;
    assert!(with(&session, &RULES).unwrap().is_none());
}

#[test]
fn what_is_not_selected_does_not_count() {
    let mut session = one_gait();
    session.motions[0].selected = Some(std::iter::once(0..25).collect());
    let (found, _) = touched(&session, &session.copies());
    let index = &found.takes[0].by_finger[Finger::Index];
    assert_eq!((index.makes, index.breaks), (0, 1));
    assert!((index.known_s - 0.25).abs() < 1e-12);
    assert!(found.takes[0].gaits.is_empty());
}
