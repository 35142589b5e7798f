//! Intervals go through `evaluation.json` and back.

use inhand_model::{
    Bootstrap, Cluster, Estimate, Finger, HandAndFingers, Intervals, Measure, MethodIntervals,
    PairedDifference, PerFinger,
};
use inhand_report::{ReportError, evaluation_json, read_evaluation_json};

use crate::sample;

/// Powers of two in metres are exact in millimetres and back.
fn estimate(value: f64) -> Estimate {
    Estimate {
        value,
        n: 500,
        clusters: 119,
        standard_error: Some(value / 8.0),
        interval: Some([value / 2.0, value * 2.0]),
    }
}

fn intervals() -> Intervals {
    let lone = Estimate {
        clusters: 1,
        standard_error: None,
        interval: None,
        ..estimate(0.25)
    };
    let errors = Some([1.0, 2.0, 4.0, 8.0, 16.0].map(|k| estimate(k / 1024.0)));
    let difference = |finger, relative| PairedDifference {
        method: "prior".to_owned(),
        other: "hermite".to_owned(),
        finger,
        measure: Measure::P75,
        absolute: estimate(-0.125),
        relative,
        share_better: 0.75,
    };
    Intervals {
        bootstrap: Bootstrap {
            cluster: Cluster::Segment,
            draws: 2000,
            seed: 1,
            confidence: 0.95,
        },
        methods: vec![MethodIntervals {
            method: "prior".to_owned(),
            error: HandAndFingers {
                all: errors,
                by_finger: PerFinger::from_fn(|f| errors.filter(|_| f != Finger::Ring)),
            },
            three_or_more: Some(lone),
            three_or_more_less_recorded: None,
        }],
        best_baseline: Some("hermite".to_owned()),
        differences: vec![
            difference(None, Some(estimate(-0.5))),
            difference(Some(Finger::Little), None),
        ],
    }
}

#[test]
fn what_was_written_is_read_back_and_fits_the_schema() {
    let mut evaluation = sample::evaluation(true);
    evaluation.intervals = Some(intervals());
    let text = evaluation_json(&evaluation, &[]).unwrap();
    let errors = crate::schema::errors(&text);
    assert!(errors.is_empty(), "{errors:?}");
    let (read, _) = read_evaluation_json(&text).unwrap();
    assert_eq!(read.intervals, Some(intervals()));
    assert!(text.contains("\"absolute_mm\": {\n          \"value\": -125.0"));
}

#[test]
fn words_that_stand_for_nothing_are_refused() {
    let mut evaluation = sample::evaluation(true);
    evaluation.intervals = Some(intervals());
    let text = evaluation_json(&evaluation, &[]).unwrap();
    for (word, other) in [
        ("\"measure\": \"p75\"", "\"measure\": \"p76\""),
        ("\"finger\": \"little\"", "\"finger\": \"sixth\""),
        ("\"cluster\": \"segment\"", "\"cluster\": \"take\""),
    ] {
        assert!(text.contains(word), "{word}");
        let refused = read_evaluation_json(&text.replace(word, other)).unwrap_err();
        assert!(
            matches!(&refused, ReportError::NotAnEvaluation { source }
                if source.to_string().contains(&other[other.len() - 4..other.len() - 1])),
            "{refused:?}"
        );
    }
}
