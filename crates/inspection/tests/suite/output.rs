//! Text, Markdown and JSON.

use inhand_inspection::{CheckSettings, Checked, check, ranked, to_json, to_markdown, to_text};
use serde_json::Value;

use crate::support::{checked, good_take, hide};

fn takes() -> Vec<Checked> {
    let good = Checked {
        file: "good.csv".into(),
        role: None,
        range_s: None,
        outcome: Ok(checked(&good_take())),
    };
    let mut gaps = good_take();
    hide(&mut gaps, "ring", 400..411);
    let warned = Checked {
        file: "gaps.csv".into(),
        role: Some("train"),
        range_s: Some([0.0, 4.0]),
        outcome: Ok(checked(&gaps)),
    };
    hide(&mut gaps, "little", 0..1000);
    let failed = Checked {
        file: "a|b @me.csv".into(),
        role: None,
        range_s: None,
        outcome: Ok(checked(&gaps)),
    };
    let unreadable = Checked {
        file: "broken.csv".into(),
        role: None,
        range_s: None,
        outcome: Err("line 3: expected a number\nfound <x>".into()),
    };
    vec![good, warned, failed, unreadable]
}

#[test]
fn the_worst_come_first() {
    let order: Vec<_> = ranked(takes()).into_iter().map(|take| take.file).collect();
    assert_eq!(order, ["broken.csv", "a|b @me.csv", "gaps.csv", "good.csv"]);
}

#[test]
fn a_take_in_text() {
    let takes = takes();
    let text = to_text(&takes[1..2]);
    let lines: Vec<_> = text.lines().collect();
    assert_eq!(
        lines[0],
        "warn  ring: 1 gap longer than 0.10 s (4.00 s) stays open; 1.1 % missing in all, longest 0.11 s"
    );
    assert!(lines[1].starts_with("      -> "), "{text}");
    assert!(
        lines[2].starts_with("ok    rate 100.00 Hz, no jumps, 1000 samples (10.00 s)"),
        "{text}"
    );
    assert_eq!(*lines.last().unwrap(), "usable segments: 8 of 9  (warn)");
}

#[test]
fn several_takes_in_text() {
    let text = to_text(&ranked(takes()));
    assert!(
        text.starts_with("4 takes: 1 cannot be read, 1 fails, 1 with warnings, 1 OK\n"),
        "{text}"
    );
    assert!(
        text.contains("fail  little: never seen in the whole take"),
        "{text}"
    );
    assert!(text.contains("  gaps.csv (0 s to 4 s)\n"), "{text}");
    assert!(text.ends_with("OK: good.csv\n"), "{text}");
}

#[test]
fn markdown_is_tables_that_names_cannot_break() {
    let markdown = to_markdown(&ranked(takes()));
    assert!(
        markdown.contains("| a\\|b &#64;me.csv | fail |"),
        "{markdown}"
    );
    assert!(
        markdown.contains("Cannot be read: line 3: expected a number found &lt;x&gt;"),
        "{markdown}"
    );
    for line in markdown.lines().filter(|line| line.starts_with('|')) {
        let cells = line.replace("\\|", "").matches('|').count();
        assert_eq!(cells, 7, "{line}");
    }
}

#[test]
fn control_characters_stay_out_of_text() {
    let mut take = good_take();
    take.markers[0].name = "a\u{1b}[2J\u{7}".into();
    take.bodies[0].name = "Hand\u{1b}[2J".into();
    let outcome = check(
        &take,
        Err("no\u{1b}[2J hand"),
        &[],
        &CheckSettings::default(),
    );
    let takes = [Checked {
        file: "x\u{1b}.csv".into(),
        role: None,
        range_s: None,
        outcome: Ok(outcome),
    }];
    for text in [to_text(&takes), to_markdown(&takes)] {
        assert!(
            !text.chars().any(|c| c.is_control() && c != '\n'),
            "{text:?}"
        );
    }
}

#[test]
fn json_keeps_its_contract() {
    let schema = include_str!("../../../../schemas/check.schema.json");
    let schema: Value = serde_json::from_str(schema).unwrap();
    jsonschema::meta::validate(&schema).unwrap();
    let validator = jsonschema::validator_for(&schema).unwrap();
    for takes in [vec![], takes(), ranked(takes())] {
        let document: Value = serde_json::from_str(&to_json(&takes)).unwrap();
        let errors: Vec<_> = validator
            .iter_errors(&document)
            .map(|e| e.to_string())
            .collect();
        assert!(errors.is_empty(), "{errors:#?}");
    }
    let mut document: Value = serde_json::from_str(&to_json(&takes())).unwrap();
    let part = &document["takes"][1];
    assert_eq!(
        [&part["file"], &part["role"]],
        [&Value::from("gaps.csv"), &Value::from("train")]
    );
    assert_eq!([&part["from_s"], &part["to_s"]], [0.0, 4.0]);
    // A key that goes missing is noticed.
    document["takes"][0]["checkup"]["results"][0]
        .as_object_mut()
        .unwrap()
        .remove("id");
    assert!(!validator.is_valid(&document));
}
