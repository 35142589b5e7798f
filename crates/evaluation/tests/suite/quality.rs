//! Completeness of takes.

use std::collections::BTreeMap;

use inhand_evaluation::recording_quality;
use inhand_model::{
    Body, BodyKind, BodySource, Clock, Finding, Finger, LengthUnit, Marker, MarkerKind, Motion,
    PerFinger, PointTrack, Pose, PoseTrack, Position, Recording, Roles, Source, StartTime, Track,
    TrackCounts, TrackedBody, UpAxis, World,
};

use crate::session::{beside_cube, fill, motion};

const SAMPLES: usize = 20;

fn marker(name: &str, missing: &[usize]) -> Marker {
    let present = |k: usize| (!missing.contains(&k)).then(|| Position::<World>::new(0.0, 0.0, 1.0));
    Marker {
        name: name.to_owned(),
        id: String::new(),
        kind: MarkerKind::Labelled,
        track: PointTrack::from_measured((0..SAMPLES).map(present)),
        quality: None,
    }
}

fn body(name: &str, missing: &[usize]) -> TrackedBody {
    let present = |k: usize| (!missing.contains(&k)).then(Pose::<World, Body>::identity);
    TrackedBody {
        name: name.to_owned(),
        id: String::new(),
        kind: BodyKind::RigidBody,
        track: PoseTrack::from_measured((0..SAMPLES).map(present)),
        marker_error_m: None,
    }
}

fn recording(markers: Vec<Marker>, bodies: Vec<TrackedBody>) -> Recording {
    let source = Source {
        format: "made for a test".to_owned(),
        length_unit: LengthUnit::Metres,
        up_axis: UpAxis::Z,
        rotation: None,
        header: BTreeMap::new(),
    };
    let clock = Clock::new(0, StartTime::Unknown, 10.0).expect("a positive rate");
    Recording::new("take".to_owned(), clock, source, SAMPLES, markers, bodies).expect("lengths fit")
}

fn tips() -> Vec<Marker> {
    Finger::ALL
        .iter()
        .map(|finger| {
            let missing: &[usize] = match finger {
                Finger::Ring => &[3, 4, 5, 9, 10],
                Finger::Little => &[19],
                _ => &[],
            };
            marker(finger.name(), missing)
        })
        .collect()
}

fn roles(hand: BodySource, object: Option<BodySource>) -> Roles {
    Roles {
        hand,
        object,
        fingers: PerFinger::from_fn(|finger| finger.name().to_owned()),
    }
}

fn processed() -> Motion {
    let mut motion = motion(10.0, &vec![beside_cube([0.0; 5]); SAMPLES], None);
    for k in [9, 10] {
        fill(&mut motion.fingertips[Finger::Ring], k);
    }
    for k in 3..=5 {
        motion.fingertips[Finger::Ring].set(k, None, inhand_model::Status::Missing);
    }
    motion
}

#[test]
fn counts_gaps_and_tracking() {
    let bodies = vec![body("Hand", &[0, 1]), body("Object", &[4])];
    let mut recording = recording(tips(), bodies);
    recording.findings.push(Finding::info("", "odd"));
    let rigid = |name: &str| BodySource::RigidBody(name.to_owned());
    let quality = recording_quality(
        &recording,
        &roles(rigid("Hand"), Some(rigid("Object"))),
        &processed(),
        "test",
    );
    assert_eq!(
        (quality.take.as_str(), quality.role.as_str()),
        ("take", "test")
    );
    let counts = |measured, filled, missing| TrackCounts {
        measured,
        filled,
        missing,
    };
    assert_eq!(quality.fingers[Finger::Thumb].recorded, counts(20, 0, 0));
    assert_eq!(quality.fingers[Finger::Ring].recorded, counts(15, 0, 5));
    assert_eq!(quality.fingers[Finger::Ring].processed, counts(15, 2, 3));
    let expected_s = [0.0, 0.0, 0.0, 0.3, 0.1];
    assert_eq!(
        quality.fingers.map(|track| track.longest_gap_s),
        PerFinger::new(expected_s)
    );
    assert_eq!(
        (quality.hand_tracked, quality.object_tracked),
        (0.9, Some(0.95))
    );
    assert_eq!(quality.findings, [Finding::info("", "odd")]);
}

#[test]
fn a_cluster_is_tracked_where_three_markers_are() {
    let mut markers = tips();
    markers.push(marker("a", &[0, 1, 2]));
    markers.push(marker("b", &[2, 3]));
    markers.push(marker("c", &[2]));
    markers.push(marker("d", &[3, 7]));
    let cluster =
        |names: &[&str]| BodySource::Markers(names.iter().map(|&n| n.to_owned()).collect());
    let never = body("Object", &(0..SAMPLES).collect::<Vec<_>>());
    let recording = recording(markers, vec![never]);
    let object = BodySource::RigidBody("Object".to_owned());
    let judged = |hand| {
        recording_quality(
            &recording,
            &roles(hand, Some(object.clone())),
            &processed(),
            "train",
        )
    };
    // Of four, three are missing at 2, two at 3.
    assert_eq!(judged(cluster(&["a", "b", "c", "d"])).hand_tracked, 0.9);
    // Of three, any missing one is too many: 0 to 3.
    assert_eq!(judged(cluster(&["a", "b", "c"])).hand_tracked, 0.8);
    assert_eq!(judged(cluster(&["a", "b"])).hand_tracked, 0.0);
    assert_eq!(judged(cluster(&["a", "b", "c"])).object_tracked, None);
}

#[test]
fn what_the_take_lacks_is_a_finding() {
    let mut markers = tips();
    markers.retain(|marker| marker.name != "middle");
    let recording = recording(markers, vec![]);
    let hand = BodySource::RigidBody("Hand".to_owned());
    let motion = Motion {
        fingertips: PerFinger::from_fn(|_| Track::missing(SAMPLES)),
        ..processed()
    };
    let quality = recording_quality(&recording, &roles(hand, None), &motion, "test");
    assert_eq!(quality.fingers[Finger::Middle].recorded.missing, SAMPLES);
    assert_eq!(quality.fingers[Finger::Middle].longest_gap_s, 2.0);
    assert_eq!((quality.hand_tracked, quality.object_tracked), (0.0, None));
    let places: Vec<&str> = quality.findings.iter().map(|f| f.place.as_str()).collect();
    assert_eq!(places, ["middle", "Hand"]);
}
