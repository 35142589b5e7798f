//! Views added to files that are there already.

use std::collections::BTreeMap;

use inhand_channels::Views;
use inhand_container::{Depth, Record, walk};

use crate::bags::{as_mocap4r2, recorded};
use crate::support::{Bench, SMALL, stderr};

/// Log time, publish time, sequence and data.
pub(crate) type Message = (u64, u64, u32, Vec<u8>);

/// Messages by topic, in the order of the file.
pub(crate) fn messages(bench: &Bench, name: &str) -> BTreeMap<String, Vec<Message>> {
    let mut topics: BTreeMap<u16, String> = BTreeMap::new();
    let mut found: BTreeMap<String, Vec<Message>> = BTreeMap::new();
    let visit = |record: Record<'_>| -> Result<(), inhand_container::ContainerError> {
        match record {
            Record::Channel(channel) => {
                found.entry(channel.topic.clone()).or_default();
                topics.insert(channel.id, channel.topic);
            }
            Record::Message { header, data } => {
                let message = (
                    header.log_time,
                    header.publish_time,
                    header.sequence,
                    data.to_vec(),
                );
                let topic = &topics[&header.channel_id];
                found.entry(topic.clone()).or_default().push(message);
            }
            _ => {}
        }
        Ok(())
    };
    walk(name, &bench.bytes(name), Depth::Everything, visit).expect("the file is sound");
    found
}

/// The file with its views, without them, and without them but with views added.
fn same_views(bench: &Bench, with: &str, without: &str) -> BTreeMap<String, Vec<Message>> {
    let dictionary = ["--dictionary", "with/dictionary.mcap"];
    let dictionary = &dictionary[..if bench.path(dictionary[1]).exists() {
        2
    } else {
        0
    }];
    let view = ["view", without, "-o", "viewed.mcap", "--force"];
    bench.ok(&[&view[..], dictionary].concat());
    let [with, without, viewed] = [with, without, "viewed.mcap"].map(|name| messages(bench, name));
    assert!(with.len() > without.len() + 1, "{:?}", with.keys());
    for (topic, messages) in &with {
        assert!(viewed.get(topic) == Some(messages), "{topic} is another");
    }
    assert!(with.keys().eq(viewed.keys()), "{:?}", viewed.keys());
    let metadata = |name: &str| {
        inhand_channels::read_metadata(&bench.bytes(name), name).expect("the file is sound")
    };
    let steps = metadata("viewed.mcap").provenance("").expect("ours");
    assert_eq!(steps.last().map(|step| &*step.step), Some("view"));
    with
}

#[test]
fn what_steps_leave_out_is_added_later_as_they_would_have_written_it() {
    let bench = Bench::csv();
    let take = "session/test/cube_test_01.csv";
    let both = |step: &[&str], with: &'static str, without: &'static str| {
        bench.ok(&[step, &["-o", with]].concat());
        bench.ok(&[step, &["-o", without, "--views=none"]].concat());
        same_views(&bench, with, without)
    };
    both(&["convert", take], "a.mcap", "a0.mcap");
    let clean = ["clean", take, "--repair", "--fill", "cubic"];
    both(
        &[&clean[..], &["--resample", "60"]].concat(),
        "b.mcap",
        "b0.mcap",
    );
    let views = both(
        &["process", "b.mcap", "--object", "cube:0.05"],
        "c.mcap",
        "c0.mcap",
    );
    assert!(views["/view/object"].len() == 1 && views["/tf"].len() > 300);
}

#[test]
fn the_output_of_a_run_gets_its_methods_and_contacts_back() {
    let bench = Bench::csv();
    bench.run("with", &[]);
    bench.run("without", &["--views=none"]);
    let [with, without] = ["with", "without"].map(|folder| format!("{folder}/cube_test_01.mcap"));
    let views = same_views(&bench, &with, &without);
    let scenes = |topic: &&String| topic.starts_with("/view/generated/");
    assert!(views.keys().filter(scenes).count() >= 2);

    // Views that are there are replaced, and the rest stays as it was.
    let dictionary = ["--dictionary", "with/dictionary.mcap"];
    bench.ok(&[
        &["view", "viewed.mcap", "-o", "again.mcap"][..],
        &dictionary,
    ]
    .concat());
    assert!(messages(&bench, "again.mcap") == messages(&bench, "viewed.mcap"));

    // Later steps read the file as before.
    let settings = ["--dictionary", "with/dictionary.mcap", "-o"];
    for (take, name) in [(&*with, "x.json"), ("viewed.mcap", "y.json")] {
        bench.ok(&[&["evaluate", take][..], &settings, &[name]].concat());
    }
    assert_eq!(
        bench.json("x.json")["methods"],
        bench.json("y.json")["methods"]
    );
}

#[test]
fn plans_that_found_no_motion_are_listed_again() {
    let bench = Bench::csv();
    let slow = [
        "--methods",
        "prior",
        "--ends",
        "hard",
        "--velocity-m-s",
        "0.02",
    ];
    for (folder, view) in [("with", None), ("without", Some("--views=none"))] {
        let run = [&["run", "session", "-o", folder][..], &SMALL, &slow].concat();
        let output = bench.inhand(&run.into_iter().chain(view).collect::<Vec<_>>());
        assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
    }
    let [with, without] = ["with", "without"].map(|folder| format!("{folder}/cube_test_01.mcap"));
    let views = same_views(&bench, &with, &without);
    assert!(!views["/view/log"].is_empty());
    assert_eq!(views["/view/hulls"].len(), 1);
}

#[test]
fn a_dictionary_gets_back_what_was_filtered_out() {
    let bench = Bench::csv();
    bench.run("run", &[]);
    bench.ok(&[
        "filter",
        "run/dictionary.mcap",
        "-n",
        "/view/.*",
        "-n",
        "/tf_static",
        "-o",
        "bare.mcap",
    ]);
    let output = bench.inhand(&["view", "run/dictionary.mcap", "bare.mcap", "-o", "folder"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let said = stderr(&output);
    assert!(said.contains("which dictionaries always have"), "{said}");
    let whole = messages(&bench, "run/dictionary.mcap");
    for name in ["folder/dictionary.mcap", "folder/bare.mcap"] {
        assert!(messages(&bench, name) == whole, "{name}");
        // What is learned is read as before.
        bench.ok(&["info", name]);
        inhand_channels::read_dictionary(&bench.bytes(name), name).expect("a dictionary");
    }
}

#[test]
fn a_recording_of_others_is_drawn_beside_what_it_has() {
    let bench = Bench::csv();
    let take = recorded(&bench);
    let text = |word: &str| [word.as_bytes(), &[0]].concat();
    let mut bag = as_mocap4r2(&take);
    // With the profile ros2, behind magic bytes, prefix and length, views would be messages of ROS 2.
    bag[21..25].copy_from_slice(b"none");
    let elsewhere: Vec<u8> = {
        let (from, to) = (text("world"), text("mocap"));
        let mut bytes = bag.clone();
        for at in 0..bytes.len() - from.len() {
            if bytes[at..].starts_with(&from) {
                bytes[at..at + to.len()].copy_from_slice(&to);
            }
        }
        bytes
    };
    for (name, bytes, frames) in [("a.mcap", bag, None), ("b.mcap", elsewhere, Some(1))] {
        bench.write(name, bytes);
        let output = bench.inhand(&["view", name, "-o", "viewed.mcap", "--force"]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let (before, after) = (messages(&bench, name), messages(&bench, "viewed.mcap"));
        for (topic, messages) in &before {
            assert!(after[topic] == *messages, "{topic} is another");
        }
        for topic in ["/view/tf", "/view/tf_static", "/view/fingertips"] {
            assert!(after.contains_key(topic), "{topic}: {:?}", after.keys());
        }
        assert_eq!(after.get("/view/frames").map(Vec::len), frames, "{name}");
        assert!(!after.contains_key("/tf"));

        // Views are no recording: what is read of the file is what was read before.
        bench.ok(&["convert", name, "-o", "x.mcap", "--force"]);
        bench.ok(&["convert", "viewed.mcap", "-o", "y.mcap", "--force"]);
        let markers = |name: &str| messages(&bench, name).remove("/recording/markers");
        assert!(markers("x.mcap").is_some() && markers("x.mcap") == markers("y.mcap"));
        bench.ok(&["view", "viewed.mcap", "-o", "again.mcap", "--force"]);
        assert!(messages(&bench, "again.mcap") == after);
    }
}

#[test]
fn what_cannot_have_views_is_refused_with_a_way_out() {
    let bench = Bench::csv();
    let take = "session/test/cube_test_01.csv";
    bench.ok(&["convert", take, "-o", "a.mcap"]);
    let nothing = ["filter", "a.mcap", "-y", "/none", "--no-metadata"];
    bench.inhand(&[&nothing[..], &["-o", "empty.mcap"]].concat());
    bench.write("half.mcap", &bench.bytes("a.mcap")[..50_000]);
    for (args, code, expected) in [
        (vec!["view", take, "-o", "v.mcap"], 1, "inhand convert"),
        (vec!["view", "empty.mcap", "-o", "v.mcap"], 1, "no take"),
        (vec!["view", "half.mcap", "-o", "v.mcap"], 1, "cut off"),
        (vec!["view", "a.mcap", "-o", "a.mcap"], 2, "also an input"),
        (vec!["view", "a.mcap", "a.mcap", "-o", "f"], 2, "two inputs"),
        (
            vec!["view", "a.mcap", "-o", "v.mcap", "--object", "cheese"],
            2,
            "cube:0.05",
        ),
    ] {
        let output = bench.inhand(&args);
        assert_eq!(output.status.code(), Some(code), "{}", stderr(&output));
        assert!(stderr(&output).contains(expected), "{}", stderr(&output));
        assert!(!bench.path("v.mcap").exists());
    }
}

#[test]
fn a_take_without_samples_gets_what_there_is() {
    let bench = Bench::csv();
    bench.ok(&["convert", "session/test/cube_test_01.csv", "-o", "a.mcap"]);
    let take = inhand_channels::read_take(&bench.bytes("a.mcap"), "a").expect("a take");
    let (recording, roles) = (take.recording.slice(0..0), take.roles.as_ref());
    for (name, views) in [("with.mcap", Views::Default), ("without.mcap", Views::None)] {
        let mut bytes = Vec::new();
        let file = inhand_channels::TakeFile {
            roles,
            ..inhand_channels::TakeFile::new(&recording)
        };
        inhand_channels::write_take(&mut bytes, &file, views).expect("it is written");
        bench.write(name, bytes);
    }
    let views = same_views(&bench, "with.mcap", "without.mcap");
    assert_eq!(views["/tf_static"].len(), 1);
}
