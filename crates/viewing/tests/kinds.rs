//! Content of layouts for each kind of output.

use inhand_channels::finger_hex;
use inhand_model::Finger;
use inhand_viewing::{LayoutError, layout};
use serde_json::{Value, json};

use crate::settings::check;
use crate::{TAKE, content};

/// The layout of these topics, found to be sound.
fn of(topics: &[(&str, Option<&str>)]) -> Value {
    let layout = layout(&content(topics)).expect("the topics can be shown");
    check(&layout);
    layout
}

/// Topics that are drawn from the start.
fn drawn(layout: &Value) -> Vec<&str> {
    (layout["configById"]["3D!hand"]["topics"].as_object())
        .expect("topics have settings")
        .iter()
        .filter(|(_, settings)| settings["visible"] == json!(true))
        .map(|(topic, _)| topic.as_str())
        .collect()
}

/// Panels and, of plots and lists, what each is of.
fn panels(layout: &Value) -> Vec<(&str, String)> {
    (layout["configById"].as_object())
        .expect("panels have settings")
        .iter()
        .map(|(id, settings)| {
            let first = [
                &settings["paths"][0]["value"],
                &settings["topicToRender"],
                &settings["topicPath"],
                &settings["followTf"],
            ];
            let first = first.into_iter().find_map(Value::as_str);
            (id.as_str(), first.unwrap_or("-").to_owned())
        })
        .collect()
}

fn is(found: &[(&str, String)], expected: &[(&str, &str)]) {
    let found: Vec<_> = found.iter().map(|(id, of)| (*id, of.as_str())).collect();
    assert_eq!(found, expected);
}

#[test]
fn a_take_with_everything() {
    let layout = of(&TAKE);
    assert_eq!(
        drawn(&layout),
        [
            "/view/fingertips_scene",
            "/view/generated/residual/fingertips_scene",
            "/view/object"
        ],
        "nothing is drawn twice"
    );
    is(
        &panels(&layout),
        &[
            ("3D!hand", "object"),
            ("Plot!contacts", "/evaluation/residual/contact.count"),
            (
                "Plot!distance",
                "/evaluation/residual/contact.thumb_distance_m",
            ),
            ("Plot!error", "/evaluation/residual/error.thumb_m"),
            ("RawMessages!event", "/annotations"),
            ("RosOut!findings", "/recording/findings"),
            ("StateTransitions!events", "/annotations.metadata[0].value"),
        ],
    );
    // Other methods are there to be switched on.
    let topics = &layout["configById"]["3D!hand"]["topics"];
    assert_eq!(
        topics["/view/generated/line/fingertips"]["visible"],
        json!(false)
    );
    let paths = &layout["configById"]["Plot!error"]["paths"];
    for (n, finger) in Finger::ALL.into_iter().enumerate() {
        assert_eq!(paths[n]["color"], finger_hex(finger));
        assert_eq!(paths[n]["label"], finger.name());
    }
}

#[test]
fn distances_of_the_take_go_before_those_of_a_method() {
    let mut topics = TAKE.to_vec();
    topics.push(("/evaluation/recorded/contact", Some("hand")));
    let layout = of(&topics);
    let panels = &layout["configById"];
    let distance = "/evaluation/recorded/contact.thumb_distance_m";
    assert_eq!(panels["Plot!distance"]["paths"][0]["value"], distance);
    let counts: Vec<_> = (panels["Plot!contacts"]["paths"].as_array())
        .expect("there are lines")
        .iter()
        .map(|path| &path["value"])
        .collect();
    let expected = [
        "/evaluation/recorded/contact.count",
        "/evaluation/residual/contact.count",
    ];
    assert_eq!(counts, expected);
}

#[test]
fn a_recording_alone() {
    let layout = of(&[
        ("/recording/markers", Some("world")),
        ("/recording/fingertips", Some("world")),
        ("/view/markers", Some("world")),
        ("/view/fingertips", Some("world")),
        ("/view/fingertips_scene", Some("world")),
    ]);
    assert_eq!(drawn(&layout), ["/view/fingertips_scene"]);
    is(
        &panels(&layout),
        &[
            ("3D!hand", "upright"),
            ("Plot!x", "/recording/fingertips.thumb.position_m.x"),
            ("Plot!y", "/recording/fingertips.thumb.position_m.y"),
            ("Plot!z", "/recording/fingertips.thumb.position_m.z"),
        ],
    );
}

#[test]
fn markers_without_roles() {
    let layout = of(&[
        ("/recording/markers", Some("world")),
        ("/view/markers", Some("world")),
    ]);
    assert_eq!(drawn(&layout), ["/view/markers"]);
    assert_eq!(
        layout["layout"], "3D!hand",
        "the view of the markers has the window"
    );
}

#[test]
fn a_take_that_was_only_processed() {
    let layout = of(&[
        ("/recording/fingertips", Some("world")),
        ("/processed/fingertips", Some("hand")),
        ("/view/fingertips", Some("hand")),
    ]);
    assert_eq!(
        drawn(&layout),
        ["/view/fingertips"],
        "points where there are no spheres"
    );
    assert_eq!(layout["configById"]["3D!hand"]["followTf"], "hand");
    let path = &layout["configById"]["Plot!x"]["paths"][0]["value"];
    assert_eq!(path, "/processed/fingertips.thumb.position_m.x");
}

#[test]
fn a_plan_alone() {
    let layout = of(&[
        ("/generated/residual/fingertips", Some("hand")),
        ("/generated/residual/plan", Some("hand")),
        ("/view/generated/residual/fingertips", Some("hand")),
        ("/view/generated/residual/fingertips_scene", Some("hand")),
    ]);
    assert_eq!(
        drawn(&layout),
        ["/view/generated/residual/fingertips_scene"]
    );
    let path = &layout["configById"]["Plot!x"]["paths"][0]["value"];
    assert_eq!(path, "/generated/residual/fingertips.thumb.position_m.x");
}

#[test]
fn a_dictionary() {
    let older = [
        ("/dictionary/model", Some("hand")),
        ("/dictionary/primitives", Some("hand")),
        ("/view/dictionary/hulls", Some("hand")),
        ("/view/dictionary/primitives", Some("hand")),
    ];
    let layout = of(&older);
    assert_eq!(
        drawn(&layout),
        ["/view/dictionary/hulls", "/view/dictionary/primitives"]
    );
    let path = &layout["configById"]["Plot!x"]["paths"][0]["value"];
    assert_eq!(path, "/dictionary/primitives.thumb.position_m.x");

    let newer = [
        ("/dictionary/profile", None),
        ("/view/dictionary/paths", Some("hand")),
    ];
    let layout = of(&[&older[..], &newer].concat());
    assert_eq!(
        drawn(&layout),
        ["/view/dictionary/paths", "/view/dictionary/primitives"]
    );
    is(
        &panels(&layout),
        &[
            ("3D!hand", "hand"),
            ("Plot!primitive", "/dictionary/profile.primitive"),
            ("Plot!profile", "/dictionary/profile.thumb_m"),
        ],
    );
}

#[test]
fn an_overlay_shows_every_take_and_how_far_they_are_apart() {
    let mut topics = vec![
        ("/processed/fingertips", Some("hand")),
        ("/view/fingertips_scene", Some("hand")),
        ("/view/object", Some("object")),
    ];
    for of_b in [
        "/overlay/b/fingertips",
        "/overlay/b/distance",
        "/view/overlay/b/fingertips",
    ] {
        topics.push((of_b, Some("hand")));
    }
    topics.push(("/view/overlay/c-1/fingertips_scene", Some("hand")));
    let layout = of(&topics);
    assert_eq!(
        drawn(&layout),
        [
            "/view/fingertips_scene",
            "/view/object",
            "/view/overlay/b/fingertips",
            "/view/overlay/c-1/fingertips_scene",
        ]
    );
    is(
        &panels(&layout),
        &[
            ("3D!hand", "object"),
            ("Plot!overlay-b", "/overlay/b/distance.thumb_m"),
        ],
    );
}

#[test]
fn nothing_to_show_is_said() {
    for (topics, expected) in [
        (&[][..], "no channel at all"),
        (&[("/imu", None)][..], "only /imu"),
        (
            &[("/recording/unknown", None)][..],
            "only /recording/unknown",
        ),
    ] {
        let error = layout(&content(topics)).expect_err("there is nothing");
        assert!(matches!(error, LayoutError::NothingToShow { .. }));
        assert!(error.to_string().contains(expected), "{error}");
    }
    let many: Vec<_> = ["/a", "/b", "/c", "/d", "/e", "/f", "/g"]
        .map(|t| (t, None))
        .into();
    let error = layout(&content(&many)).expect_err("there is nothing");
    assert!(error.to_string().contains("/e and 2 more"), "{error}");
}
