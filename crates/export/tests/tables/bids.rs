//! Files of a BIDS dataset.

use std::collections::BTreeMap;

use inhand_export::bids::{BidsNames, files};
use inhand_model::{Annotations, Event};

use crate::common::{START, recording};

fn names() -> BidsNames {
    BidsNames {
        subject: "01".to_owned(),
        session: Some("a".to_owned()),
        task: "rotate".to_owned(),
        tracking_system: "OptiTrack".to_owned(),
        run: Some(2),
    }
}

fn written(annotations: &Annotations, samples: usize) -> BTreeMap<String, String> {
    let take = recording(samples, 100.0);
    let files = files(&take, annotations, &names()).unwrap();
    (files.iter())
        .map(|file| {
            let mut content = Vec::new();
            file.write(&mut content).unwrap();
            let path = file.path.to_str().unwrap().to_owned();
            (path, String::from_utf8(content).unwrap())
        })
        .collect()
}

#[test]
fn a_take_as_motion_bids() {
    let event = |start, end| Event {
        start_unix_nanos: START + start,
        end_unix_nanos: START + end,
        labels: [("task".to_owned(), "ro\ttate".to_owned())].into(),
    };
    let annotations = Annotations {
        events: vec![
            event(2_000_000_000, 2_500_000_000),
            event(1_000_000_000, 1_000_000_000),
        ],
        keys: vec!["task".to_owned(), "note".to_owned()],
        about: BTreeMap::new(),
    };
    let files = written(&annotations, 10);
    let folder = "sub-01/ses-a/motion/sub-01_ses-a_task-rotate";
    let tracked = format!("{folder}_tracksys-OptiTrack_run-02");
    let paths: Vec<&str> = files.keys().map(String::as_str).collect();
    assert_eq!(
        paths,
        [
            "dataset_description.json".to_owned(),
            format!("{folder}_run-02_events.tsv"),
            format!("{tracked}_channels.json"),
            format!("{tracked}_channels.tsv"),
            format!("{tracked}_motion.json"),
            format!("{tracked}_motion.tsv"),
        ]
    );
    // Every channel has a column; the motion has no heading, as BIDS wants it.
    let channels = &files[&format!("{tracked}_channels.tsv")];
    let lines: Vec<&str> = channels.lines().collect();
    assert_eq!(
        lines[0],
        "name\tcomponent\ttype\ttracked_point\tunits\treference_frame"
    );
    assert_eq!(
        lines[1],
        "Hand, \"left\"_x\tx\tPOS\tHand, \"left\"\tm\tworld"
    );
    assert_eq!(
        lines[4],
        "Hand, \"left\"_quat_x\tquat_x\tORNT\tHand, \"left\"\tn/a\tworld"
    );
    let motion = &files[&format!("{tracked}_motion.tsv")];
    assert_eq!(motion.lines().count(), 10);
    for line in motion.lines() {
        assert_eq!(line.split('\t').count(), lines.len() - 1);
    }
    // Sample 3 of the first marker is missing, sample 4 is filled.
    let thumb = lines
        .iter()
        .position(|line| line.starts_with("Thumb_x\t"))
        .unwrap()
        - 1;
    let cell = |k: usize, column: usize| {
        motion
            .lines()
            .nth(k)
            .unwrap()
            .split('\t')
            .nth(column)
            .unwrap()
            .to_owned()
    };
    assert_eq!([cell(3, thumb), cell(3, thumb + 3)], ["n/a", "0"]);
    assert_eq!(cell(4, thumb + 3), "1");
    assert_ne!(cell(4, thumb), "n/a");

    let facts: serde_json::Value =
        serde_json::from_str(&files[&format!("{tracked}_motion.json")]).unwrap();
    let counts = [
        "POSChannelCount",
        "ORNTChannelCount",
        "MISCChannelCount",
        "MotionChannelCount",
    ];
    assert_eq!(
        counts.map(|key| facts[key].as_u64().unwrap()),
        [15, 8, 3, 26]
    );
    assert_eq!(lines.len() - 1, 26);
    assert_eq!(facts["SamplingFrequency"], 100.0);

    assert_eq!(
        files[&format!("{folder}_run-02_events.tsv")],
        "onset\tduration\ttask\tnote\n1\t0\tro tate\tn/a\n2\t0.5\tro tate\tn/a\n"
    );
}

#[test]
fn names_that_bids_does_not_take_are_refused() {
    let take = recording(1, 100.0);
    for (subject, task) in [("", "a"), ("s_1", "a"), ("1", "ro-tate"), ("1", "../x")] {
        let names = BidsNames {
            subject: subject.to_owned(),
            task: task.to_owned(),
            ..names()
        };
        let error = files(&take, &Annotations::default(), &names).unwrap_err();
        assert!(
            error.to_string().contains("letters and digits alone"),
            "{error}"
        );
    }
}
