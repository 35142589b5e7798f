//! Events as CSV and back.

use std::collections::BTreeMap;

use inhand_export::events::{parse_seconds, read, write};
use inhand_model::{Annotations, Event};
use proptest::prelude::*;

const START: u64 = 1_700_000_000_000_000_000;

fn written(annotations: &Annotations) -> String {
    let mut csv = Vec::new();
    write(annotations, START, &mut csv).unwrap();
    String::from_utf8(csv).unwrap()
}

#[test]
fn csv_comes_back_to_the_byte() {
    let csv = "start_s,end_s,task,note,by\n\
               63.4,63.6,rotate,,\"a \"\"b\"\"\"\n\
               1,1.000000001,,\" two, words \",é\n\
               -0.25,12,lift,\"line\nbreak\",\n\
               0,0,,,\n";
    let annotations = read(csv.as_bytes(), "a.csv", START).unwrap();
    assert_eq!(
        annotations.events[0].start_unix_nanos,
        START + 63_400_000_000
    );
    assert_eq!(annotations.events[1].end_unix_nanos, START + 1_000_000_001);
    assert_eq!(annotations.events[2].start_unix_nanos, START - 250_000_000);
    assert_eq!(annotations.events[2].labels["note"], "line\nbreak");
    assert_eq!(annotations.events[3].labels, BTreeMap::new());
    assert_eq!(written(&annotations), csv);
}

#[test]
fn a_tab_in_a_label_separates_no_columns() {
    let csv = "start_s,end_s,a\tb\n0,1,slip\n";
    let annotations = read(csv.as_bytes(), "a.csv", START).unwrap();
    assert_eq!(annotations.events[0].labels["a\tb"], "slip");
    assert_eq!(written(&annotations), csv);
}

#[test]
fn other_time_columns_are_read() {
    let event = |start, end| {
        let labels = [("trial_type".to_owned(), "rotate".to_owned())].into();
        Event {
            start_unix_nanos: START + start,
            end_unix_nanos: START + end,
            labels,
        }
    };
    for csv in [
        "onset\tduration\ttrial_type\n1.5\t0.5\trotate\n3\tn/a\trotate\n",
        "trial_type,end_s,start_s\r\nrotate,2,1.5\r\nrotate,,3\r\n",
        "\u{feff}start_time,trial_type,end_time\n\
         2023-11-14T22:13:21.5Z,rotate,2023-11-14T23:13:22+01:00\n\
         1700000003000000000,rotate,\n",
    ] {
        let annotations = read(csv.as_bytes(), "a.csv", START).unwrap();
        assert_eq!(
            annotations.events,
            [
                event(1_500_000_000, 2_000_000_000),
                event(3_000_000_000, 3_000_000_000)
            ]
        );
    }
}

#[test]
fn what_cannot_be_read_is_refused_with_its_place() {
    let cases = [
        (
            "time,task\n1,a\n",
            "a.csv: expected a column start_s, start_time or onset",
        ),
        (
            "start_s,end_s\n1,2\nx,2\n",
            "line 3, column 1 (\"start_s\"): expected a number of seconds, found \"x\"",
        ),
        (
            "start_s,end_s\n1,0.5\n",
            "line 2, column 2 (\"end_s\"): expected an end that is not before the start",
        ),
        ("start_s,end_s\n-1e10,0\n", "after 1970"),
        ("start_s,end_s\n1\n", "line 2: expected 2 cells"),
        ("start_s,end_s,task,task\n", "the heading \"task\" twice"),
        ("start_s,end_s,\n", "a column without a heading"),
        (
            "start_time,end_time\nyesterday,today\n",
            "expected a time such as",
        ),
        ("start_s\n\n", ""),
        (
            "start_s,end_s,label\n0,1,a\n1,2,\"oops\n3,4,b\n5,6,c\n",
            "line 3: column 3: expected a quote that is closed",
        ),
        (
            "start_s,end_s\n170141183460469231731687303715.9,2\n",
            "expected a number of seconds",
        ),
    ];
    for (csv, expected) in cases {
        match read(csv.as_bytes(), "a.csv", START) {
            Err(error) => assert!(error.to_string().contains(expected), "{error}"),
            Ok(annotations) => assert!(expected.is_empty() && annotations.events.is_empty()),
        }
    }
}

#[test]
fn seconds_are_exact() {
    for (text, nanos) in [
        ("0.1", Some(100_000_000)),
        ("+3", Some(3_000_000_000)),
        (".5", Some(500_000_000)),
        ("5.", Some(5_000_000_000)),
        ("1700000000.123456789", Some(1_700_000_000_123_456_789)),
        ("0.0000000005", Some(1)),
        ("-0.0000000004", Some(0)),
        ("1e-3", Some(1_000_000)),
        ("", None),
        (".", None),
        ("-", None),
        ("nan", None),
        ("inf", None),
        ("99999999999999999999999999999999999999999", None),
    ] {
        assert_eq!(parse_seconds(text), nanos, "{text}");
    }
}

proptest! {
    #[test]
    fn events_come_back(
        events in prop::collection::vec(
            (0_u64..10_000_000_000, 0_u64..10_000_000_000,
             prop::collection::btree_map("[a-z ]*[a-z]", "[ -~\n]*[!-~]", 0..3)),
            0..6,
        ),
    ) {
        let event = |(start, length, labels): (u64, u64, BTreeMap<String, String>)| {
            let labels = labels.into_iter()
                .map(|(key, value)| (key.trim().to_owned(), value))
                .filter(|(key, value)| {
                    value != "n/a" && !["start_s", "end_s"].contains(&key.as_str())
                });
            Event {
                start_unix_nanos: START - 5_000_000_000 + start,
                end_unix_nanos: START - 5_000_000_000 + start + length,
                labels: labels.collect(),
            }
        };
        let annotations = Annotations {
            events: events.into_iter().map(event).collect(),
            ..Annotations::default()
        };
        let csv = written(&annotations);
        let back = read(csv.as_bytes(), "a.csv", START).unwrap();
        prop_assert_eq!(&back.events, &annotations.events);
        prop_assert_eq!(written(&back), csv);
    }
}

#[test]
fn labels_that_begin_a_formula_are_no_formula_in_a_spreadsheet_and_come_back() {
    let labels = [("+cmd", "=1+1"), ("angle", "-30"), ("note", "'=x")];
    let event = Event {
        start_unix_nanos: START,
        end_unix_nanos: START,
        labels: labels
            .map(|(key, value)| (key.to_owned(), value.to_owned()))
            .into(),
    };
    let annotations = Annotations {
        events: vec![event],
        ..Annotations::default()
    };
    let csv = written(&annotations);
    assert_eq!(csv, "start_s,end_s,'+cmd,angle,note\n0,0,'=1+1,-30,''=x\n");
    assert_eq!(
        read(csv.as_bytes(), "a.csv", START).unwrap().events,
        annotations.events
    );
}
