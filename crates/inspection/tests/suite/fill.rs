//! Closed forms of filling, and of pads.

use inhand_inspection::{FillMethod, FillSettings, fill, to_pads};
use inhand_model::{
    BodyKind, BodySource, ChangeKind, Clock, Finger, LengthUnit, Marker, MarkerKind, PerFinger,
    Pose, Position, Recording, Roles, Source, StartTime, Status, Track, TrackedBody, UpAxis, World,
};
use nalgebra::{Isometry3, Vector3};
use proptest::prelude::*;

use crate::common::{label, roles};

const RATE_HZ: f64 = 100.0;

fn recording(samples: usize, markers: Vec<Marker>, bodies: Vec<TrackedBody>) -> Recording {
    let source = Source {
        format: "test".into(),
        length_unit: LengthUnit::Metres,
        up_axis: UpAxis::Y,
        rotation: None,
        header: Default::default(),
    };
    let clock = Clock::new(0, StartTime::Unknown, RATE_HZ).expect("the rate is positive");
    Recording::new("test".into(), clock, source, samples, markers, bodies).expect("lengths agree")
}

fn marker(name: &str, kind: MarkerKind, samples: usize, at: impl Fn(f64) -> [f64; 3]) -> Marker {
    Marker {
        name: name.into(),
        id: String::new(),
        kind,
        track: Track::from_measured((0..samples).map(|k| Some(at(k as f64 / RATE_HZ).into()))),
        quality: None,
    }
}

fn hand_at(s: f64) -> Isometry3<f64> {
    Isometry3::new(
        Vector3::new(0.3 * s, 0.1, 0.2),
        Vector3::new(0.2, 1.3 * s, -0.4 * s),
    )
}

fn hand(samples: usize) -> TrackedBody {
    let pose = |k: usize| Some(Pose::new(hand_at(k as f64 / RATE_HZ)));
    TrackedBody {
        name: "Hand".into(),
        id: String::new(),
        kind: BodyKind::RigidBody,
        track: Track::from_measured((0..samples).map(pose)),
        marker_error_m: None,
    }
}

/// Five fingertips that move in the hand as `in_hand` says, with a hand that moves and turns.
fn take(samples: usize, in_hand: impl Fn(Finger, f64) -> [f64; 3]) -> Recording {
    let tips = Finger::ALL.map(|finger| {
        marker(&label(finger), MarkerKind::Labelled, samples, |s| {
            (hand_at(s) * nalgebra::Point3::from(in_hand(finger, s))).into()
        })
    });
    recording(samples, tips.into(), vec![hand(samples)])
}

fn hide(
    recording: &mut Recording,
    name: &str,
    gap: std::ops::Range<usize>,
) -> Vec<Position<World>> {
    let marker = recording
        .markers
        .iter_mut()
        .find(|m| m.name == name)
        .expect("it is there");
    let was = gap.clone().filter_map(|k| marker.track.get(k)).collect();
    gap.for_each(|k| marker.track.set(k, None, Status::Missing));
    was
}

fn most_off(recording: &Recording, name: &str, start: usize, truth: &[Position<World>]) -> f64 {
    let track = &recording.marker(name).expect("it is there").track;
    (truth.iter().enumerate())
        .map(|(i, there)| {
            assert_eq!(track.status(start + i), Status::Filled);
            track
                .get(start + i)
                .map_or(f64::INFINITY, |at| at.distance_m(*there))
        })
        .fold(0.0, f64::max)
}

fn settings(method: FillMethod) -> FillSettings {
    FillSettings {
        method,
        limit_s: 0.1,
    }
}

#[test]
fn steady_motion_in_the_hand_is_filled_exactly() {
    // A line in the hand is no line in the world, for the hand turns.
    for method in [
        FillMethod::Linear,
        FillMethod::Cubic,
        FillMethod::Neighbours,
    ] {
        let mut take = take(200, |finger, s| {
            [0.02 * finger.index() as f64, 0.1 + 0.05 * s, 0.01 * s]
        });
        let truth = hide(&mut take, "Ring", 90..100);
        let changes = fill(&mut take, &roles(false), &settings(method)).expect("it fills");
        assert!(most_off(&take, "Ring", 90, &truth) < 1e-9, "{method:?}");
        assert_eq!(changes.len(), 1);
        assert_eq!(
            (
                changes[0].kind,
                changes[0].entity.as_str(),
                changes[0].samples.clone()
            ),
            (ChangeKind::Filled, "Ring", 90..100)
        );
    }
}

#[test]
fn a_cubic_bends_with_the_motion_on_both_sides() {
    // An arc of 30 mm radius at 1.5 turns a second: 54 degrees are hidden in 0.1 s.
    let arc = |_: Finger, s: f64| {
        let angle = std::f64::consts::TAU * 1.5 * s;
        [0.03 * angle.cos(), 0.1 + 0.03 * angle.sin(), 0.0]
    };
    let off = |method| {
        let mut take = take(200, arc);
        let truth = hide(&mut take, "Index", 100..110);
        fill(&mut take, &roles(false), &settings(method)).expect("it fills");
        most_off(&take, "Index", 100, &truth)
    };
    // The chord of that arc is 30 mm * (1 - cos(29.7 degrees)) = 3.9 mm off.
    let (linear, cubic) = (off(FillMethod::Linear), off(FillMethod::Cubic));
    assert!((linear - 0.0039).abs() < 2e-4, "{linear}");
    assert!(cubic < 0.25 * linear, "{cubic}");
}

#[test]
fn neighbours_know_motion_that_a_line_does_not() {
    // All fingers follow one signal, fast enough to come and go within the gap.
    let way = |finger: Finger, s: f64| {
        let beat = 0.006 * (std::f64::consts::TAU * 4.0 * s).sin() + 0.003 * (31.0 * s).cos();
        let share = 1.0 + 0.3 * finger.index() as f64;
        [0.02 * finger.index() as f64, 0.1 + share * beat, 0.5 * beat]
    };
    let off = |method| {
        let mut take = take(300, way);
        let truth = hide(&mut take, "Middle", 147..157);
        fill(&mut take, &roles(false), &settings(method)).expect("it fills");
        most_off(&take, "Middle", 147, &truth)
    };
    assert!(off(FillMethod::Neighbours) < 2e-4);
    assert!(off(FillMethod::Linear) > 3e-3);
}

#[test]
fn a_cluster_places_its_markers() {
    let place = [0.03, -0.01, 0.02];
    let mut markers: Vec<Marker> = take(120, |f, _| [0.02 * f.index() as f64, 0.1, 0.0]).markers;
    let on_hand = |at: [f64; 3]| move |s: f64| (hand_at(s) * nalgebra::Point3::from(at)).into();
    markers.push(marker(
        "Hand:Marker1",
        MarkerKind::RigidBodyMarker,
        120,
        on_hand(place),
    ));
    for (name, at) in [
        ("a", [0.0, 0.0, 0.0]),
        ("b", [0.04, 0.0, 0.0]),
        ("c", [0.0, 0.05, 0.0]),
        ("d", [0.01, 0.01, 0.03]),
    ] {
        markers.push(marker(name, MarkerKind::Labelled, 120, on_hand(at)));
    }
    let mut take = recording(120, markers, vec![hand(120)]);
    let of_body = hide(&mut take, "Hand:Marker1", 50..60);
    let of_cluster = hide(&mut take, "b", 70..80);
    let tip = hide(&mut take, "Thumb", 20..25);
    let roles = Roles {
        object: Some(BodySource::Markers(
            ["a", "b", "c", "d"].map(String::from).into(),
        )),
        ..roles(false)
    };
    let changes = fill(&mut take, &roles, &settings(FillMethod::Cluster)).expect("it fills");
    assert!(most_off(&take, "Hand:Marker1", 50, &of_body) < 1e-9);
    assert!(most_off(&take, "b", 70, &of_cluster) < 1e-9);
    // A fingertip belongs to no cluster.
    assert_eq!((changes.len(), tip.len()), (2, 5));
    assert_eq!(
        take.marker("Thumb").expect("it is there").track.status(22),
        Status::Missing
    );
}

#[test]
fn gaps_beyond_the_limit_and_at_the_ends_stay() {
    let mut take = take(100, |f, _| [0.02 * f.index() as f64, 0.1, 0.0]);
    hide(&mut take, "Index", 0..5);
    hide(&mut take, "Index", 30..41);
    hide(&mut take, "Index", 50..60);
    hide(&mut take, "Index", 97..100);
    let changes = fill(&mut take, &roles(false), &settings(FillMethod::Cubic)).expect("it fills");
    assert_eq!(changes.len(), 1);
    assert_eq!(changes[0].samples, 50..60);
    let track = &take.marker("Index").expect("it is there").track;
    assert_eq!(track.gaps(), [0..5, 30..41, 97..100]);
}

#[test]
fn pads_are_where_they_are_said_to_be() {
    let place = [0.02, 0.09, 0.01];
    let still = || take(50, move |_, _| place);
    let of = |recording: &Recording, k: usize| {
        let at = recording
            .marker("Index")
            .and_then(|m| m.track.get(k))
            .expect("it is there");
        hand_at(k as f64 / RATE_HZ).inverse() * at.point()
    };
    let moved = |offset| {
        let mut take = still();
        let offsets = PerFinger::from_fn(|f| (f == Finger::Index).then_some(offset));
        let changes = to_pads(&mut take, &roles(false), &offsets).expect("it moves");
        assert_eq!((changes.len(), changes[0].kind), (1, ChangeKind::Moved));
        of(&take, 37)
    };
    let pad = moved([0.001, -0.002, 0.008]);
    assert!((pad.coords - Vector3::new(0.021, 0.088, 0.018)).norm() < 1e-12);
}

#[test]
fn fingertips_and_other_names_are_no_part_of_a_cluster() {
    let on_hand = |at: [f64; 3]| move |s: f64| (hand_at(s) * nalgebra::Point3::from(at)).into();
    let mut given = take(120, |f, s| [0.02 * f.index() as f64, 0.1 + 0.05 * s, 0.0]);
    given.markers[0].name = "Hand_Thumb".into();
    given.markers[1].name = "Hand:Index".into();
    given.markers.push(marker(
        "Hand_1",
        MarkerKind::Labelled,
        120,
        on_hand([0.01, 0.0, 0.02]),
    ));
    given
        .markers
        .push(marker("Hand_watch", MarkerKind::Labelled, 120, |s| {
            [s, 0.0, 0.0]
        }));
    let named = Roles {
        fingers: PerFinger::from_fn(|f| match f {
            Finger::Thumb => "Hand_Thumb".to_owned(),
            Finger::Index => "Hand:Index".to_owned(),
            other => label(other),
        }),
        ..roles(false)
    };
    for name in ["Hand_Thumb", "Hand:Index", "Hand_1", "Hand_watch"] {
        hide(&mut given, name, 50..55);
    }
    let changes = fill(&mut given, &named, &settings(FillMethod::Cluster)).expect("it fills");
    let filled: Vec<&str> = changes.iter().map(|c| c.entity.as_str()).collect();
    assert_eq!(filled, ["Hand_1"]);
}

#[test]
fn a_cluster_with_too_few_others_is_refused() {
    let on_hand = |at: [f64; 3]| move |s: f64| (hand_at(s) * nalgebra::Point3::from(at)).into();
    let mut given = take(120, |f, _| [0.02 * f.index() as f64, 0.1, 0.0]);
    for (name, at) in [
        ("a", [0.0, 0.0, 0.0]),
        ("b", [0.04, 0.0, 0.0]),
        ("c", [0.0, 0.05, 0.0]),
    ] {
        given
            .markers
            .push(marker(name, MarkerKind::Labelled, 120, on_hand(at)));
    }
    // The thumb is named as well, and does not count.
    let roles = Roles {
        object: Some(BodySource::Markers(
            ["a", "b", "c", "Thumb"].map(String::from).into(),
        )),
        ..roles(false)
    };
    let cluster = settings(FillMethod::Cluster);
    let nothing = fill(&mut given, &roles, &cluster).expect("there is no gap");
    assert!(nothing.is_empty());
    hide(&mut given, "b", 70..80);
    let error = fill(&mut given, &roles, &cluster).expect_err("two others are left");
    let expected = "take \"test\": marker \"b\" of the cluster \"a, b, c, Thumb\" has 2 others";
    assert!(error.to_string().starts_with(expected), "{error}");
}

/// A take whose hand is recorded in a wrong pose, a quarter turn away, over the samples.
fn with_flipped_hand(mut given: Recording, wrong: std::ops::Range<usize>) -> Recording {
    let quarter = Isometry3::rotation(Vector3::x() * std::f64::consts::FRAC_PI_2);
    for k in wrong {
        let pose = (given.bodies[0].track.get(k)).map(|p| Pose::new(p.isometry() * quarter));
        given.bodies[0].track.set(k, pose, Status::Measured);
    }
    given
}

#[test]
fn steps_that_do_not_undo_flips_take_the_hand_as_recorded() {
    let offset_m = [0.001, -0.002, 0.008];
    let mut given = with_flipped_hand(take(200, |_, _| [0.02, 0.09, 0.01]), 80..120);
    assert_eq!(inhand_inspection::detect::flips(&given).len(), 1);
    let before = given.clone();
    let offsets = PerFinger::from_fn(|_| Some(offset_m));
    to_pads(&mut given, &roles(false), &offsets).expect("it moves");
    for k in [50, 100] {
        let at = |r: &Recording| r.markers[0].track.get(k).expect("it is there").coords_m();
        let turned = given.bodies[0].track.value(k).isometry().rotation * Vector3::from(offset_m);
        assert!((at(&given) - at(&before) - turned).norm() < 1e-12, "{k}");
    }
    // A gap across the jump is filled in the world: the jump must not throw the fingertip about.
    for method in [FillMethod::Linear, FillMethod::Cubic] {
        let mut given = with_flipped_hand(take(200, |_, _| [0.02, 0.09, 0.01]), 80..120);
        let truth = hide(&mut given, "Ring", 78..83);
        fill(&mut given, &roles(false), &settings(method)).expect("it fills");
        assert!(most_off(&given, "Ring", 78, &truth) < 1e-3, "{method:?}");
    }
}

#[test]
fn pads_without_a_pose_of_the_hand_are_told() {
    let mut given = take(100, |_, _| [0.02, 0.09, 0.01]);
    (40..70).for_each(|k| given.bodies[0].track.set(k, None, Status::Missing));
    hide(&mut given, "Index", 50..55);
    let offsets = PerFinger::from_fn(|f| (f == Finger::Index).then_some([0.0, 0.0, 0.008]));
    let changes = to_pads(&mut given, &roles(false), &offsets).expect("it moves");
    let told: Vec<_> = (changes.iter())
        .map(|c| (c.kind, c.entity.as_str(), c.samples.clone()))
        .collect();
    // What was missing before is not lost here.
    assert_eq!(
        told,
        [
            (ChangeKind::Moved, "Index", 0..100),
            (ChangeKind::Removed, "Index", 40..50),
            (ChangeKind::Removed, "Index", 55..70),
        ]
    );
    assert!(
        changes[1].message.contains("pose of the hand"),
        "{}",
        changes[1].message
    );
    let gaps = given.marker("Index").expect("it is there").track.gaps();
    assert_eq!((gaps.len(), &gaps[0]), (1, &(40..70)));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Whatever is missing, measured samples stay bit by bit, and what is filled is marked and finite.
    #[test]
    fn measured_samples_stay(
        holes in prop::collection::vec((0_usize..5, 0_usize..120, 1_usize..30), 0..12),
        hand_holes in prop::collection::vec((0_usize..120, 1_usize..20), 0..3),
        method in prop::sample::select(vec![
            FillMethod::Linear, FillMethod::Cubic, FillMethod::Cluster, FillMethod::Neighbours,
        ]),
    ) {
        let mut take = take(120, |f, s| [0.02 * f.index() as f64, 0.1 + 0.02 * (9.0 * s).sin(), 0.0]);
        for (finger, start, len) in holes {
            hide(&mut take, &label(Finger::ALL[finger]), start..(start + len).min(120));
        }
        for (start, len) in hand_holes {
            (start..(start + len).min(120))
                .for_each(|k| take.bodies[0].track.set(k, None, Status::Missing));
        }
        let raw = take.clone();
        let changes = fill(&mut take, &roles(false), &settings(method)).expect("it fills");
        for (before, after) in raw.markers.iter().zip(&take.markers) {
            for k in 0..120 {
                let told = changes.iter().any(|c| c.entity == before.name && c.samples.contains(&k));
                match (before.track.status(k), after.track.status(k)) {
                    (Status::Missing, Status::Filled) => prop_assert!(told),
                    (a, b) => {
                        prop_assert_eq!(a, b);
                        prop_assert!(!told);
                        prop_assert_eq!(before.track.get(k), after.track.get(k));
                    }
                }
            }
        }
    }
}
