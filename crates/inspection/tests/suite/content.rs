//! Gaps, repeated frames, bodies, names: planted one at a time.

use inhand_inspection::{
    CheckSettings, FlipRepair, Level, MAX_PLACES, SegmentShare, Suspect, SuspectKind, check,
};
use inhand_model::{Finding, Marker, MarkerKind, Recording, Status};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use crate::support::{
    PLATE_M, body, checked, complaints, good_take, hand_pose, hide, marker, number, recording,
    result, roles,
};

#[test]
fn gaps_are_counted_and_those_that_stay_open_are_named() {
    let mut take = good_take();
    // Ten samples are filled, eleven are not.
    hide(&mut take, "ring", 100..110);
    hide(&mut take, "ring", 400..411);
    hide(&mut take, "ring", 800..830);
    hide(&mut take, "thumb", 200..205);
    let checkup = checked(&take);
    let ring = result(&checkup, "gaps", "ring");
    assert_eq!(ring.level, Level::Warn);
    assert!(
        ring.found
            .starts_with("2 gaps longer than 0.10 s (4.00 s, 8.00 s) stay open; 5.1 % missing"),
        "{}",
        ring.found
    );
    assert_eq!(ring.places.len(), 2);
    assert!(
        (ring.places[0].from_s - 4.0).abs() < 1e-12 && (ring.places[0].to_s - 4.10).abs() < 1e-12
    );
    assert_eq!(
        [
            number(ring, "gaps"),
            number(ring, "open"),
            number(ring, "longest_s"),
            number(ring, "missing_share")
        ],
        [3.0, 2.0, 0.30, 0.051]
    );
    let thumb = result(&checkup, "gaps", "thumb");
    assert_eq!((thumb.level, number(thumb, "open")), (Level::Info, 0.0));
    // One-second segments with 4 samples at each end: starts 4, 104, ... 804 of 1000; what the gaps
    // leave are 0..400 (3 segments), 411..800 (3) and 830..1000 (1).
    assert_eq!(
        checkup.segments,
        Some(SegmentShare {
            usable: 7,
            possible: 9
        })
    );
    assert_eq!(result(&checkup, "segments", "").level, Level::Warn);
}

#[test]
fn what_is_never_or_hardly_seen_fails() {
    let mut take = good_take();
    hide(&mut take, "little", 0..1000);
    hide(&mut take, "ring", 0..600);
    let checkup = checked(&take);
    assert_eq!(result(&checkup, "never-seen", "little").level, Level::Fail);
    assert_eq!(result(&checkup, "gaps", "ring").level, Level::Fail);
    assert_eq!(checkup.segments.map(|s| s.usable), Some(0));
    // Worst first.
    let levels: Vec<_> = checkup.results.iter().map(|r| r.level).collect();
    assert!(levels.is_sorted_by(|a, b| a >= b), "{levels:?}");
    assert!(checkup.score() > 300.0);
}

#[test]
fn places_are_bounded_and_counted() {
    let mut take = good_take();
    for k in (0..1000).step_by(4) {
        hide(&mut take, "index", k..k + 1);
    }
    let checkup = checked(&take);
    let index = result(&checkup, "gaps", "index");
    assert_eq!(
        (index.places.len(), number(index, "gaps")),
        (MAX_PLACES, 250.0)
    );
}

#[test]
fn roles_that_cannot_be_told_fail_and_the_rest_is_still_looked_at() {
    let take = good_take();
    let why = "cannot tell what the hand is\n  it has the bodies: A\u{1b}[2J";
    let checkup = check(&take, Err(why), &[], &CheckSettings::default());
    let open = result(&checkup, "roles", "");
    assert_eq!(open.level, Level::Fail);
    assert!(
        open.found
            .starts_with("cannot tell what the hand is; it has the bodies"),
        "{}",
        open.found
    );
    assert_eq!(checkup.segments, None);
    assert_eq!(result(&checkup, "axes", "Hand").level, Level::Ok);
}

#[test]
fn a_take_of_nothing_is_answered() {
    let empty = recording(0, vec![], vec![]);
    let checkup = check(&empty, Err("no hand"), &[], &CheckSettings::default());
    assert_eq!(checkup.level(), Level::Fail);
    let one = good_take().slice(0..1);
    let checkup = checked(&one);
    assert!(result(&checkup, "segments", "").found.contains("too short"));
}

/// Sample `k` shows what sample `from(k)` showed.
fn resampled(take: &Recording, from: impl Fn(usize) -> usize) -> Recording {
    let mut changed = take.clone();
    for k in 0..take.len() {
        for (to, was) in changed.markers.iter_mut().zip(&take.markers) {
            to.track.set(k, was.track.get(from(k)), Status::Measured);
        }
        for (to, was) in changed.bodies.iter_mut().zip(&take.bodies) {
            to.track.set(k, was.track.get(from(k)), Status::Measured);
        }
    }
    changed
}

#[test]
fn half_the_stated_rate_is_found() {
    let checkup = checked(&resampled(&good_take(), |k| k / 2 * 2));
    let rate = result(&checkup, "rate", "");
    assert_eq!(rate.level, Level::Warn);
    assert!((number(rate, "changes_hz") - 50.0).abs() < 0.1, "{rate:?}");
    assert_eq!(complaints(&checkup), ["rate"]);
}

#[test]
fn single_repeated_frames_are_found() {
    let checkup = checked(&resampled(&good_take(), |k| {
        if k == 300 || k == 700 { k - 1 } else { k }
    }));
    let repeated = result(&checkup, "repeated-frames", "");
    assert_eq!(repeated.level, Level::Warn);
    assert!(
        repeated.found.starts_with("2 frames repeat"),
        "{}",
        repeated.found
    );
    assert_eq!(repeated.places.len(), 2);
    assert_eq!(result(&checkup, "rate", "").level, Level::Ok);
}

#[test]
fn a_marker_that_stands_still_to_the_last_digit_is_frozen() {
    let mut take = good_take();
    let index = take.markers.iter_mut().find(|m| m.name == "index").unwrap();
    let held = index.track.get(500);
    for k in 501..530 {
        index.track.set(k, held, Status::Measured);
    }
    let checkup = checked(&take);
    let frozen = result(&checkup, "frozen", "index");
    assert_eq!(frozen.level, Level::Warn);
    assert!(
        (number(frozen, "longest_s") - 0.30).abs() < 1e-12,
        "{frozen:?}"
    );
    // Nine equal samples are below 0.1 s.
    let mut short = good_take();
    let index = short
        .markers
        .iter_mut()
        .find(|m| m.name == "index")
        .unwrap();
    for k in 501..509 {
        index.track.set(k, held, Status::Measured);
    }
    assert!(checked(&short).result("frozen").is_none());
}

/// Labelled markers on the hand's plate, each moved by `change` in the body's frame.
fn plate(take: &mut Recording, change: impl Fn(usize, usize) -> Vector3<f64>) {
    let samples = take.len();
    let seen = PLATE_M.iter().enumerate().map(|(i, &local)| -> Marker {
        let name = format!("Hand:Marker{}", i + 1);
        marker(&name, MarkerKind::Labelled, samples, |k| {
            (hand_pose(k) * nalgebra::Point3::from(Vector3::from(local) + change(i, k))).coords
        })
    });
    take.markers.extend(seen.collect::<Vec<_>>());
}

#[test]
fn rigid_markers_pass_and_soft_drifting_and_moved_ones_do_not() {
    let wobble = |i: usize, k: usize| 1e-4 * ((1.3 + i as f64) * k as f64).sin();
    let verdict = |change: &dyn Fn(usize, usize) -> Vector3<f64>| {
        let mut take = good_take();
        plate(&mut take, change);
        let checkup = checked(&take);
        let found = result(&checkup, "rigidity", "Hand");
        (found.level, found.found.clone())
    };
    let along_x = |x: f64| Vector3::new(x, 0.0, 0.0);
    let (level, found) = verdict(&|i, k| along_x(wobble(i, k)));
    assert_eq!(level, Level::Ok, "{found}");
    let first = |i: usize, x: f64| if i == 0 { along_x(x) } else { Vector3::zeros() };
    let (level, found) = verdict(&|i, k| first(i, 0.008 * (0.9 * k as f64).sin()));
    assert_eq!(level, Level::Warn);
    assert!(found.starts_with("not rigid"), "{found}");
    let (level, found) = verdict(&|i, k| first(i, 0.006 * k as f64 / 1000.0 + wobble(i, k)));
    assert_eq!(level, Level::Warn);
    assert!(found.contains("drifts by"), "{found}");
    let (level, found) = verdict(&|i, k| first(i, if k < 500 { 0.0 } else { 0.006 }));
    assert_eq!(level, Level::Warn);
    assert!(
        found.contains("jumps by") && found.contains("near 5."),
        "{found}"
    );
}

#[test]
fn a_large_marker_error_is_told_with_its_median() {
    let mut take = good_take();
    take.bodies[0].marker_error_m =
        Some((0..1000).map(|k| 1e-3 * (1.0 + f64::from(k % 3))).collect());
    let checkup = checked(&take);
    let error = result(&checkup, "marker-error", "Hand");
    assert_eq!(error.level, Level::Warn);
    assert!(
        (number(error, "median_mm") - 2.0).abs() < 1e-9
            && (number(error, "p95_mm") - 3.0).abs() < 1e-9
    );
    take.bodies[0].marker_error_m = Some(vec![2e-4; 1000]);
    assert_eq!(
        result(&checked(&take), "marker-error", "Hand").level,
        Level::Ok
    );
}

#[test]
fn sign_changes_are_no_jumps_and_flips_are() {
    let mut take = good_take();
    for k in (100..900).step_by(2) {
        let pose = take.bodies[0].track.get(k).unwrap().isometry();
        let other_sign = UnitQuaternion::new_unchecked(-pose.rotation.into_inner());
        let pose = Isometry3::from_parts(pose.translation, other_sign);
        take.bodies[0]
            .track
            .set(k, Some(inhand_model::Pose::new(pose)), Status::Measured);
    }
    let checkup = checked(&take);
    let smooth = result(&checkup, "orientation", "Hand");
    assert_eq!(
        (smooth.level, number(smooth, "sign_changes")),
        (Level::Ok, 800.0)
    );
    assert_eq!(complaints(&checkup), Vec::<&str>::new());

    take.bodies.push(body("Other", 1000, |k| {
        let half_turn =
            UnitQuaternion::from_scaled_axis(Vector3::new(0.0, std::f64::consts::PI, 0.0));
        let flipped = (300..310).contains(&k);
        hand_pose(k)
            * if flipped {
                half_turn
            } else {
                UnitQuaternion::identity()
            }
    }));
    let checkup = checked(&take);
    let jumps = result(&checkup, "orientation", "Other");
    assert_eq!((jumps.level, number(jumps, "jumps")), (Level::Warn, 2.0));

    // A detector that has found the flip says it; it is not said twice.
    let flip = Suspect {
        kind: SuspectKind::Flip {
            body: 1,
            name: "Other".into(),
            turn_rad: std::f64::consts::PI,
            repair: FlipRepair::Remove,
        },
        samples: 300..310,
        score: 12.0,
    };
    let checkup = check(&take, Ok(&roles()), &[flip], &CheckSettings::default());
    assert_eq!(complaints(&checkup), ["flips"]);
    let flips = result(&checkup, "flips", "Other");
    assert_eq!(
        flips.found,
        "1 suspected flip (3.00 s): Other jumps by 180 degrees and does not come back that way"
    );
}

#[test]
fn suspects_are_grouped_by_kind_and_entity() {
    let spike = |name: &str, k: usize| Suspect {
        kind: SuspectKind::Spike {
            marker: 0,
            name: name.into(),
            off_m: 0.01,
        },
        samples: k..k + 2,
        score: k as f64,
    };
    let all = [
        spike("ring", 500),
        spike("thumb", 20),
        spike("ring", 100),
        spike("ring", 700),
    ];
    let checkup = check(&good_take(), Ok(&roles()), &all, &CheckSettings::default());
    let ring = result(&checkup, "spikes", "ring");
    assert_eq!(ring.found, "3 spikes (1.00 s, 5.00 s, 7.00 s)");
    assert_eq!(
        [number(ring, "count"), number(ring, "largest_score")],
        [3.0, 700.0]
    );
    assert_eq!(result(&checkup, "spikes", "thumb").places.len(), 1);
}

#[test]
fn what_the_reader_found_keeps_its_weight() {
    let mut take = good_take();
    take.findings = vec![
        Finding::warning(
            "line 9",
            "frame 7 follows frame 3; in all the frame column jumps 1 times and leaves out 3 frames",
        ),
        Finding::info(
            "Capture Start Time",
            "the file states no start time: the take starts at 1970-01-01",
        ),
        Finding::info("X", "something that nobody has heard of"),
    ];
    let checkup = checked(&take);
    assert_eq!(result(&checkup, "frame-jumps", "").level, Level::Warn);
    assert_eq!(result(&checkup, "start-time", "").level, Level::Info);
    assert_eq!(
        result(&checkup, "source", "").found,
        "X: something that nobody has heard of"
    );
    assert!(!result(&checkup, "rate", "").found.contains("no jumps"));
}

/// The words by which findings are told apart are those that the reader writes.
#[test]
fn findings_of_the_reader_are_known() {
    let csv = "Format Version,1.23,Take Name,t,Capture Frame Rate,100,Export Frame Rate,100,Total Exported Frames,9,\
               Rotation Type,Quaternion,Length Units,Meters,Coordinate Space,Global\n\n,Type,Marker,Marker,Marker\n\
               ,Name,A,A,A\n,ID,1,1,1\n,,Position,Position,Position\nFrame,Time (Seconds),X,Y,Z\n\
               0,0.0,1,2,3\n1,0.01,1,2,3.1\n4,0.9,1,2,\n5,0.05,1,2,3.3\n";
    let take = inhand_capture::read(
        csv.as_bytes(),
        "t.csv",
        &inhand_capture::ReadSettings::default(),
    );
    let checkup = check(
        &take.expect("the take can be read"),
        Err("no hand"),
        &[],
        &CheckSettings::default(),
    );
    for id in [
        "frame-jumps",
        "cut-short",
        "time-column",
        "damaged-samples",
        "start-time",
    ] {
        assert!(checkup.result(id).is_some(), "{id}: {:#?}", checkup.results);
    }
    assert!(checkup.result("source").is_none(), "{:#?}", checkup.results);
    let declared = checkup.result("cut-short").expect("it was there");
    assert!(declared.found.contains("cut or edited after the export"));
    assert_eq!(declared.advice, "use the original, if there is one");
}

#[test]
fn names_that_are_not_unique_matter_where_a_role_has_one() {
    let mut take = good_take();
    let again = |name: &str| {
        marker(name, MarkerKind::Labelled, 1000, |k| {
            hand_pose(k).translation.vector
        })
    };
    take.markers.extend([again("x"), again("x")]);
    assert_eq!(
        result(&checked(&take), "duplicate-names", "").level,
        Level::Info
    );
    take.markers.push(again("index"));
    assert_eq!(
        result(&checked(&take), "duplicate-names", "").level,
        Level::Warn
    );
}
