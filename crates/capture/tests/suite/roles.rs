//! Roles by name.

use inhand_capture::roles::{self, BodyChoice, RoleError, RoleSettings};
use inhand_model::{BodySource, Finger, PerFinger, Recording, Roles};

use super::text::{Motive, body, marker, marker_of};

const FINGERS: [&str; 5] = ["Thumb", "Index", "Middle", "Ring", "Little"];

/// A take with one sample of these bodies and markers.
fn take(bodies: &[&str], markers: &[&str]) -> Recording {
    let mut columns = Vec::new();
    let mut row = "0,0".to_owned();
    for name in bodies {
        columns.extend(body(name));
        row.push_str(",0,0,0,1,0,0,0");
    }
    for (m, name) in markers.iter().enumerate() {
        columns.extend(marker_of("Marker", name, &format!("M{m}")));
        row.push_str(",1,2,3");
    }
    Motive::new(columns, &[&row])
        .read()
        .expect("the take reads")
}

fn resolve(bodies: &[&str], markers: &[&str]) -> Result<Roles, RoleError> {
    roles::resolve(&take(bodies, markers), &RoleSettings::default())
}

fn with<'a>(fingers: [&'a str; 5], more: &[&'a str]) -> Vec<&'a str> {
    fingers.iter().chain(more).copied().collect()
}

fn body_source(name: &str) -> BodySource {
    BodySource::RigidBody(name.to_owned())
}

fn cluster(names: &[&str]) -> BodySource {
    BodySource::Markers(names.iter().map(|&name| name.to_owned()).collect())
}

#[test]
fn common_names_need_no_settings() {
    let roles = resolve(&["Hand", "Object"], &FINGERS).unwrap();
    assert_eq!(roles.hand, body_source("Hand"));
    assert_eq!(roles.object, Some(body_source("Object")));
    assert_eq!(roles.fingers, PerFinger::new(FINGERS.map(str::to_owned)));

    let names = [
        "RightHand:ThumbTip",
        "index_finger",
        "MIDDLE",
        "ring tip",
        "Pinky",
    ];
    let roles = resolve(&["RightHand", "cube5", "Table"], &names).unwrap();
    assert_eq!(roles.hand, body_source("RightHand"));
    assert_eq!(roles.object, Some(body_source("cube5")));
    assert_eq!(roles.fingers, PerFinger::new(names.map(str::to_owned)));
}

#[test]
fn joints_are_no_fingertips_and_clusters_make_a_hand() {
    let names = [
        "hand_top",
        "hand_left",
        "hand_right",
        "thumb_tip",
        "thumb_middle",
        "little_tip",
        "little_middle",
        "ring_tip",
        "ring_middle",
        "middle_middle",
        "middle_tip",
        "index_tip",
        "index_middle",
        "right_elbow",
        "back_top",
        "back_left",
        "back_right",
        "pillow_top",
        "pillow_left",
        "pillow_right",
    ];
    let recording = take(&[], &names);
    let roles = roles::resolve(&recording, &RoleSettings::default()).unwrap();
    assert_eq!(
        roles.hand,
        cluster(&["hand_top", "hand_left", "hand_right"])
    );
    assert_eq!(roles.object, None);
    for (finger, name) in roles.fingers.iter() {
        assert_eq!(*name, format!("{finger}_tip"));
    }
    for choice in ["pillow", "Pillow", "pillow_top, pillow_left,pillow_right"] {
        let settings = RoleSettings {
            object: Some(choice.parse().unwrap()),
            ..RoleSettings::default()
        };
        let roles = roles::resolve(&recording, &settings).unwrap();
        assert_eq!(
            roles.object,
            Some(cluster(&["pillow_top", "pillow_left", "pillow_right"])),
            "{choice}"
        );
    }
}

#[test]
fn markers_of_bodies() {
    // The labelled markers of a body that was not exported.
    let names = with(
        FINGERS,
        &[
            "Hand:Marker1",
            "Hand:Marker2",
            "Hand:Marker3",
            "Hand:Thumb base",
        ],
    );
    assert_eq!(
        resolve(&[], &names).unwrap().hand,
        cluster(&["Hand:Marker1", "Hand:Marker2", "Hand:Marker3"])
    );
    // A body counts more than its markers.
    assert_eq!(
        resolve(&["Hand"], &names).unwrap().hand,
        body_source("Hand")
    );
    // A cluster plainly called object.
    let names = with(FINGERS, &["cube_1", "cube_2", "cube_3", "cube_4"]);
    assert_eq!(
        resolve(&["Hand"], &names).unwrap().object,
        Some(cluster(&["cube_1", "cube_2", "cube_3", "cube_4"]))
    );
    // A fitted marker of the same name does not compete with the one the cameras saw.
    let columns = [
        body("Hand"),
        marker_of("Rigid Body Marker", "Thumb", "B0"),
        FINGERS.iter().flat_map(|name| marker(name)).collect(),
    ]
    .concat();
    let row = ["0,0,0,0,0,1,0,0,0".to_owned(), ",1,2,3".repeat(6)].concat();
    let recording = Motive::new(columns, &[&row]).read().unwrap();
    assert!(roles::resolve(&recording, &RoleSettings::default()).is_ok());
}

#[test]
fn a_finger_without_marker_lists_what_there_is() {
    let error = resolve(
        &["Hand"],
        &[
            "Thumb",
            "Index",
            "Unlabeled 1036",
            "Middle",
            "Ring",
            "Marker 005",
        ],
    )
    .unwrap_err();
    assert_eq!(
        error.to_string(),
        "cannot tell which marker is the little finger in take \"take\"\n  it has the bodies: Hand\n  \
         and the markers: Thumb, Index, Middle, Ring, Marker 005, Unlabeled 1036\n  say it with   `fingers` \
         little=\"MARKER\"   or in inhand.toml under [fingers]"
    );
    let error = resolve(&["Hand"], &["Ring"]).unwrap_err().to_string();
    assert!(
        error.starts_with("cannot tell which marker is the thumb, the index finger, the middle"),
        "{error}"
    );
}

#[test]
fn lists_are_whole_but_for_unlabelled_markers() {
    let bodies: Vec<String> = (0..50).map(|n| format!("Body{n}")).collect();
    let mut markers: Vec<String> = (0..50).map(|n| format!("Unlabeled {n}")).collect();
    markers.extend((0..50).map(|n| format!("Marker{n}")));
    let bodies: Vec<&str> = bodies.iter().map(String::as_str).collect();
    let markers: Vec<&str> = markers.iter().map(String::as_str).collect();
    let error = resolve(&bodies, &markers).unwrap_err().to_string();
    for name in [
        "Body49\n",
        "Marker49, Unlabeled 0,",
        "Unlabeled 39 and 10 more",
    ] {
        assert!(error.contains(name), "{name}: {error}");
    }
}

#[test]
fn what_the_user_names_is_looked_up_before_what_is_open() {
    let recording = take(&["Hand"], &["Thumb"]);
    for (role, hand, object) in [("hand", Some("nope"), None), ("object", None, Some("nope"))] {
        let settings = RoleSettings {
            hand: hand.map(|name| name.parse().unwrap()),
            object: object.map(|name| name.parse().unwrap()),
            ..RoleSettings::default()
        };
        let error = roles::resolve(&recording, &settings).unwrap_err();
        let expected = format!("no rigid body \"nope\", which is set for the {role}");
        assert!(error.to_string().contains(&expected), "{error}");
    }
}

#[test]
fn two_that_claim_one_role_are_never_guessed_between() {
    let error = resolve(&["Hand"], &with(FINGERS, &["Pinky"])).unwrap_err();
    assert_eq!(
        error.to_string(),
        "cannot tell which marker is the little finger: take \"take\" has \"Little\" (ID M4), \
         \"Pinky\" (ID M5)\n  say it with   `fingers` little=\"MARKER\"   or in inhand.toml under \
         [fingers]; markers of the same name have to be renamed in the capture software"
    );
    let doubled = resolve(&["Hand"], &with(FINGERS, &["Ring"])).unwrap_err();
    let doubled = doubled.to_string();
    assert!(
        doubled.contains("which marker is the ring finger: take"),
        "{doubled}"
    );

    let hands = resolve(&["LeftHand", "RightHand"], &FINGERS)
        .unwrap_err()
        .to_string();
    assert!(
        hands.contains("which is the hand") && hands.contains("\"RightHand\""),
        "{hands}"
    );
    assert!(hands.contains("`roles.hand`"), "{hands}");
    let objects = resolve(&["Hand", "Cube", "Cylinder"], &FINGERS)
        .unwrap_err()
        .to_string();
    assert!(objects.contains("which is the object"), "{objects}");
    let clusters = [
        "left_hand_1",
        "left_hand_2",
        "left_hand_3",
        "right_hand_1",
        "right_hand_2",
        "right_hand_3",
    ];
    let clusters = resolve(&[], &with(FINGERS, &clusters))
        .unwrap_err()
        .to_string();
    assert!(
        clusters.contains("the markers left_hand (left_hand_1, "),
        "{clusters}"
    );
}

#[test]
fn no_hand_lists_what_there_is() {
    let error = resolve(&["Wrist"], &FINGERS).unwrap_err().to_string();
    assert!(error.contains("bodies: Wrist"), "{error}");
    assert!(error.contains("markers: Thumb, Index"), "{error}");
    // Two markers are no cluster, and fingers never are.
    for names in [
        with(FINGERS, &["hand_1", "hand_2"]),
        FINGERS.map(|_| "").to_vec(),
    ] {
        let names: Vec<String> = if names[0].is_empty() {
            FINGERS.iter().map(|name| format!("Hand:{name}")).collect()
        } else {
            names.into_iter().map(str::to_owned).collect()
        };
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let error = resolve(&[], &names).unwrap_err().to_string();
        assert!(
            error.starts_with("cannot tell what the hand is"),
            "{names:?}: {error}"
        );
    }
}

#[test]
fn settings_decide() {
    let recording = take(
        &["A", "B", "cube"],
        &[
            "Thumb",
            "Index",
            "Middle",
            "Ring",
            "Marker 005",
            "Pinky",
            "x",
            "y",
            "z",
        ],
    );
    let mut settings = RoleSettings {
        hand: Some("a".parse().unwrap()),
        object: Some("B".parse().unwrap()),
        ..RoleSettings::default()
    };
    settings.fingers[Finger::Little] = Some("marker 005".to_owned());
    let roles = roles::resolve(&recording, &settings).unwrap();
    assert_eq!(roles.hand, body_source("A"));
    assert_eq!(roles.object, Some(body_source("B")));
    assert_eq!(roles.fingers[Finger::Little], "Marker 005");

    settings.object = None;
    assert_eq!(
        roles::resolve(&recording, &settings).unwrap().object,
        Some(body_source("cube"))
    );
    settings.no_object = true;
    assert_eq!(roles::resolve(&recording, &settings).unwrap().object, None);
    settings.object = Some("B".parse().unwrap());
    let error = roles::resolve(&recording, &settings)
        .unwrap_err()
        .to_string();
    assert!(
        error.starts_with("an object is set and at the same time"),
        "{error}"
    );
    settings.no_object = false;

    settings.object = Some("A".parse().unwrap());
    let error = roles::resolve(&recording, &settings)
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("\"A\" is set as part of both hand and object"),
        "{error}"
    );
    settings.object = Some("bottle".parse().unwrap());
    let error = roles::resolve(&recording, &settings)
        .unwrap_err()
        .to_string();
    assert!(error.contains("no rigid body \"bottle\"") && error.contains("bodies: A, B, cube"));
    settings.object = Some("x,y,nothing".parse().unwrap());
    let error = roles::resolve(&recording, &settings)
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("no marker \"nothing\", which is set for the object"),
        "{error}"
    );
    settings.object = Some(BodyChoice::Markers(vec![
        "x".to_owned(),
        "X".to_owned(),
        "y".to_owned(),
    ]));
    let error = roles::resolve(&recording, &settings)
        .unwrap_err()
        .to_string();
    assert!(
        error.starts_with("the object is set to 2 different markers"),
        "{error}"
    );
    settings.object = None;

    settings.fingers[Finger::Ring] = Some("Middle".to_owned());
    // Middle is no longer free for the middle finger.
    let error = roles::resolve(&recording, &settings)
        .unwrap_err()
        .to_string();
    assert!(
        error.starts_with("cannot tell which marker is the middle finger in take"),
        "{error}"
    );
    settings.fingers[Finger::Middle] = Some("Middle".to_owned());
    let error = roles::resolve(&recording, &settings)
        .unwrap_err()
        .to_string();
    assert!(error.contains("\"Middle\" is set for both"), "{error}");
    settings.fingers[Finger::Ring] = Some("gone".to_owned());
    let error = roles::resolve(&recording, &settings)
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("no marker \"gone\", which is set for the ring"),
        "{error}"
    );
}

#[test]
fn choices_as_text() {
    assert_eq!("Hand".parse(), Ok(BodyChoice::Named("Hand".to_owned())));
    assert_eq!(
        "a, b,c".parse(),
        Ok(BodyChoice::Markers(
            ["a", "b", "c"].map(str::to_owned).to_vec()
        ))
    );
    for text in ["", "a,b", "a,a,a", ",", "a,"] {
        assert!(text.parse::<BodyChoice>().is_err(), "{text}");
    }
}

#[test]
fn extensions() {
    for (name, expected) in [
        ("a.csv", true),
        ("b/Take 2023.01.CSV", true),
        ("a.tsv", true),
        ("a.trc", true),
        ("a.mcap", false),
        ("csv", false),
        ("", false),
    ] {
        assert_eq!(
            inhand_capture::looks_like_capture_file(name),
            expected,
            "{name}"
        );
    }
}
