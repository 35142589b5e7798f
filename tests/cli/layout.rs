//! Layouts of what the commands write.

use serde_json::{Value, json};

use crate::support::{Bench, stderr};

fn layout(bench: &Bench, files: &[&str]) -> Value {
    let text = bench.ok(&[&["layout"], files].concat());
    serde_json::from_str(&text).expect("a layout is JSON")
}

fn view(layout: &Value) -> &Value {
    &layout["configById"]["3D!hand"]
}

/// What the camera looks at, metres.
fn target(layout: &Value) -> Vec<f64> {
    let target = &view(layout)["cameraState"]["targetOffset"];
    serde_json::from_value(target.clone()).expect("a point")
}

#[test]
fn each_output_has_a_layout_of_its_own() {
    let bench = Bench::csv();
    bench.run("out", &[]);
    bench.ok(&[
        "convert",
        "session/train/cube_train_01.csv",
        "-o",
        "recording.mcap",
    ]);

    let take = layout(&bench, &["out/cube_test_01.mcap"]);
    assert_eq!(view(&take)["followTf"], "hand");
    assert_eq!(
        view(&take)["topics"]["/view/object"]["visible"],
        json!(true)
    );
    let error = &take["configById"]["Plot!error"]["paths"][0]["value"];
    assert_eq!(error, "/evaluation/residual/error.thumb_m");
    // The grid lies under the fingertips.
    let (grid, target) = (&view(&take)["layers"]["grid"], target(&take));
    assert_eq!(grid["frameId"], "hand");
    let height = grid["position"][2].as_f64().expect("a place has a height");
    assert!((0.03..0.15).contains(&(target[2] - height)), "{height}");

    let recording = layout(&bench, &["recording.mcap"]);
    assert!(recording["configById"].get("Plot!error").is_none());
    let path = &recording["configById"]["Plot!x"]["paths"][0]["value"];
    assert_eq!(path, "/recording/fingertips.thumb.position_m.x");

    // Nothing moves a dictionary's hand: the camera looks at where its fingertips are.
    let dictionary = layout(&bench, &["out/dictionary.mcap"]);
    assert_eq!(view(&dictionary)["followTf"], "hand");
    let target = self::target(&dictionary);
    let distance = target.iter().map(|c| c * c).sum::<f64>().sqrt();
    assert!(
        (0.03..0.3).contains(&distance),
        "{target:?} is a hand's breadth away"
    );
    assert_eq!(
        view(&dictionary)["topics"]["/view/dictionary/primitives_scene"]["visible"],
        json!(true)
    );

    // Several files: what any of them has.
    let both = layout(&bench, &["out/dictionary.mcap", "out/cube_test_01.mcap"]);
    for topic in ["/view/dictionary/primitives", "/view/object"] {
        assert!(view(&both)["topics"].get(topic).is_some(), "{topic}");
    }
}

#[test]
fn without_files_it_suits_any_take() {
    let bench = Bench::empty();
    let general = layout(&bench, &[]);
    assert_eq!(general, layout(&bench, &[]));
    let error = &general["configById"]["Plot!error"]["paths"][0]["value"];
    assert_eq!(error, "/evaluation/residual/error.thumb_m");
    let topics = view(&general)["topics"]
        .as_object()
        .expect("topics have settings");
    assert!(topics.contains_key("/view/generated/hold/fingertips"));
}

#[test]
fn an_output_appears_whole_and_not_over_something_else() {
    let bench = Bench::empty();
    bench.ok(&["layout", "-o", "a.json"]);
    assert_eq!(bench.bytes("a.json"), bench.ok(&["layout"]).into_bytes());
    bench.ok(&["layout", "-o", "a.json"]);
    bench.write("a.json", "{}");
    let again = bench.inhand(&["layout", "-o", "a.json"]);
    assert_eq!(again.status.code(), Some(2));
    assert!(stderr(&again).contains("--force"), "{}", stderr(&again));
    bench.ok(&["layout", "-o", "a.json", "--force"]);
}

#[test]
fn files_that_cannot_be_looked_at_are_refused() {
    let bench = Bench::empty();
    bench.write("take.csv", "Format Version,1.23\n");
    let mut empty = std::io::Cursor::new(Vec::new());
    mcap::Writer::new(&mut empty)
        .and_then(|mut writer| writer.finish())
        .expect("an empty file can be written");
    bench.write("empty.mcap", empty.into_inner());
    for (file, expected) in [
        ("take.csv", "not an MCAP file"),
        ("gone.mcap", "gone.mcap"),
        ("empty.mcap", "no channel at all"),
    ] {
        let output = bench.inhand(&["layout", file, "-o", "a.json"]);
        assert_eq!(output.status.code(), Some(1), "{file}: {}", stderr(&output));
        assert!(stderr(&output).contains(expected), "{}", stderr(&output));
        assert!(!bench.path("a.json").exists());
    }
}

#[test]
fn what_others_drew_is_shown_as_it_is() {
    let bench = Bench::empty();
    let mut file = std::io::Cursor::new(Vec::new());
    let mut write = || -> mcap::McapResult<()> {
        let mut writer = mcap::Writer::new(&mut file)?;
        for (topic, schema) in [
            ("/lidar", "foxglove.PointCloud"),
            ("/imu", "sensor_msgs/msg/Imu"),
        ] {
            let schema = writer.add_schema(schema, "", &[])?;
            writer.add_channel(schema, topic, "json", &Default::default())?;
        }
        writer.finish()?;
        Ok(())
    };
    write().expect("a file can be written");
    bench.write("others.mcap", file.into_inner());
    let output = bench.inhand(&["layout", "others.mcap"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(
        stderr(&output).contains("no channel of inhand"),
        "{}",
        stderr(&output)
    );
    let layout: Value = serde_json::from_slice(&output.stdout).expect("a layout is JSON");
    assert_eq!(
        view(&layout)["topics"],
        json!({ "/lidar": { "visible": true } })
    );
}
