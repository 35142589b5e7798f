use std::sync::LazyLock;

use inhand_model::{Evaluation, Protocol};
use inhand_report::{ReportError, evaluation_json, read_evaluation_json};
use jsonschema::Validator;
use proptest::prelude::*;
use serde_json::Value;

use crate::sample;

const SCHEMA: &str = include_str!("../../../../schemas/evaluation.schema.json");

static VALIDATOR: LazyLock<Validator> = LazyLock::new(|| {
    let schema = serde_json::from_str(SCHEMA).expect("the schema is JSON");
    jsonschema::validator_for(&schema).expect("the schema is a schema")
});

/// Errors of a document by the schema.
pub(crate) fn errors(text: &str) -> Vec<String> {
    let document = serde_json::from_str(text).expect("the document is JSON");
    VALIDATOR
        .iter_errors(&document)
        .map(|e| e.to_string())
        .collect()
}

fn document(object: bool) -> Value {
    let text = evaluation_json(&sample::evaluation(object), &sample::provenance())
        .expect("the sample makes a document");
    serde_json::from_str(&text).expect("the document is JSON")
}

#[test]
fn the_schema_is_one_and_accepts_what_is_written() {
    jsonschema::meta::validate(&serde_json::from_str(SCHEMA).unwrap()).unwrap();
    for object in [true, false] {
        let errors: Vec<String> = VALIDATOR
            .iter_errors(&document(object))
            .map(|e| e.to_string())
            .collect();
        assert!(errors.is_empty(), "{errors:?}");
    }
}

/// Every key that outside scripts rely on, as JSON pointers into the document.
fn promised() -> Vec<String> {
    let fingers = ["thumb", "index", "middle", "ring", "little"];
    let statistics = ["n", "mean", "rmse", "p5", "p25", "p50", "p75", "p95", "max"];
    let mut paths: Vec<String> = [
        "/schema_version",
        "/session",
        "/default_method",
        "/dictionary/kind",
        "/dictionary/rank",
        "/dictionary/segments",
        "/dictionary/rms_mm",
        "/dictionary/relative_error",
        "/dictionary/iterations",
        "/dictionary/stop_reason",
        "/methods/0/name",
        "/methods/0/reachability",
        "/methods/0/collision",
        "/methods/0/contact/tau_mm",
        "/methods/0/contact/three_or_more",
        "/methods/0/contact/recorded_three_or_more",
        "/methods/0/contact/by_finger",
        "/methods/0/object_error_mm/n_left_out",
        "/methods/0/object_error_mm/p50",
        "/methods/0/object_angle_deg/p95",
        "/methods/0/corridors/1/share_stated",
        "/methods/0/corridors/1/mahalanobis",
        "/methods/0/corridors/1/n",
        "/methods/0/corridors/1/inside/all",
        "/methods/0/corridors/1/inside/ring",
        "/methods/0/plan/solved",
        "/methods/0/plan/infeasible",
        "/methods/0/plan/worst_kkt_residual",
        "/quality",
        "/held_out/ends_s",
        "/held_out/methods/0/error_mm/all/p50",
        "/filter_moves_mm/all/p95",
        "/movement/recorded/by_finger/ring/sparc/p50",
        "/movement/recorded/nearest_demonstration_mm/p75",
        "/movement/methods/0/by_finger/thumb/ldlj/p50",
        "/contacts/rules/min_duration_s",
        "/contacts/takes/0/by_finger/index/duty",
        "/contacts/takes/0/states/0/fingers",
        "/contacts/takes/0/transitions/0/count",
        "/contacts/takes/0/phases/0/kind",
        "/contacts/takes/0/gaits/0/step_mm",
        "/contacts/methods/0/by_finger/thumb/slip_mm/p50",
        "/provenance",
    ]
    .map(str::to_owned)
    .into();
    for statistic in statistics {
        paths.push(format!("/methods/0/error_mm/all/{statistic}"));
        for finger in fingers {
            paths.push(format!("/methods/0/error_mm/{finger}/{statistic}"));
            paths.push(format!(
                "/methods/0/distance_difference_mm/{finger}/{statistic}"
            ));
        }
    }
    paths.extend(fingers.map(|finger| format!("/methods/0/contact/by_finger/{finger}")));
    paths
}

#[test]
fn a_promised_key_cannot_go_missing() {
    let (validator, whole) = (&*VALIDATOR, document(true));
    for path in promised() {
        assert!(whole.pointer(&path).is_some(), "{path} is not written");
        let mut cut = whole.clone();
        let (parent, key) = path.rsplit_once('/').unwrap();
        cut.pointer_mut(parent)
            .unwrap()
            .as_object_mut()
            .unwrap()
            .remove(key);
        assert!(!validator.is_valid(&cut), "the schema does not miss {path}");
        let read = read_evaluation_json(&cut.to_string());
        // Null and absent are one to a reader of optional parts, which have defaults.
        assert!(
            read.is_err() || path.ends_with("/contact"),
            "reading does not miss {path}"
        );
    }
}

#[test]
fn an_evaluation_from_before_the_held_out_protocol_is_read() {
    let mut older = document(true);
    for key in ["held_out", "filter_moves_mm"] {
        older.as_object_mut().unwrap().remove(key);
    }
    let curve = older.pointer_mut("/dictionary/deviation").unwrap();
    curve.as_object_mut().unwrap().remove("curve");
    let (read, _) = read_evaluation_json(&older.to_string()).unwrap();
    assert_eq!((read.held_out.as_ref(), read.filter_moves), (None, None));
    assert!(read.methods(Protocol::HeldOut).is_empty());
    assert_eq!(read.methods(Protocol::Published).len(), 7);
}

#[test]
fn an_evaluation_from_before_the_inspection_is_read() {
    let mut older = document(true);
    older.as_object_mut().unwrap().remove("inspection");
    let (read, _) = read_evaluation_json(&older.to_string()).unwrap();
    assert_eq!(read.inspection, None);
    let page = inhand_report::html(&inhand_report::Report::new(&read, &[])).unwrap();
    assert!(page.contains("were not inspected"));
    let now = sample::evaluation(true);
    let page = inhand_report::html(&inhand_report::Report::new(&now, &[])).unwrap();
    assert!(page.contains("Nothing odd was found in 1 of 2 checks. They are: units."));
    assert!(page.contains("swaps (cube_train_02, index and middle): 2 suspected swaps"));
}

/// Every key of every object that is written, as JSON pointers.
fn keys(value: &Value, path: &str, found: &mut Vec<String>) {
    match value {
        Value::Object(map) => {
            for (key, inner) in map {
                let path = format!("{path}/{key}");
                keys(inner, &path, found);
                found.push(path);
            }
        }
        // One element stands for all.
        Value::Array(list) => {
            if let Some(inner) = list.first() {
                keys(inner, &format!("{path}/0"), found);
            }
        }
        _ => {}
    }
}

#[test]
fn the_schema_requires_every_key_that_is_written() {
    let (validator, whole) = (&*VALIDATOR, document(true));
    let mut found = Vec::new();
    keys(&whole, "", &mut found);
    found.retain(|path| !path.contains("/settings/"));
    assert!(found.len() > 150, "{}", found.len());
    for path in found {
        let mut cut = whole.clone();
        let (parent, key) = path.rsplit_once('/').unwrap();
        cut.pointer_mut(parent)
            .unwrap()
            .as_object_mut()
            .unwrap()
            .remove(key);
        assert!(!validator.is_valid(&cut), "the schema does not miss {path}");
    }
}

#[test]
fn lengths_are_millimetres() {
    let (evaluation, document) = (sample::evaluation(true), document(true));
    let number = |path: &str| document.pointer(path).unwrap().as_f64().unwrap();
    let prior = &evaluation.methods[0];
    for (path, metres) in [
        ("/methods/0/error_mm/all/p50", prior.error.all.p50),
        (
            "/methods/0/error_mm/ring/p95",
            prior.error.by_finger.as_array()[3].p95,
        ),
        ("/methods/0/error_at_goal_mm/max", prior.error_at_goal.max),
        ("/methods/0/contact/tau_mm", 0.005),
        ("/methods/0/collision/limit_mm", 0.01),
        (
            "/methods/0/median_error_by_sample_mm/50",
            prior.median_error_by_sample_m[50],
        ),
        ("/dictionary/rms_mm", evaluation.dictionary.rms_m),
        (
            "/dictionary/velocity_bounds_mm_s/index/max/1",
            evaluation.dictionary.velocity_bounds.max_m_s[4],
        ),
    ] {
        assert!(
            (number(path) - 1e3 * metres).abs() <= 1e-12 * number(path).abs(),
            "{path}"
        );
    }
    assert!(
        (number("/dictionary/objective_history_mm2/40")
            / 1e6
            / evaluation.dictionary.objective_history_m2[40]
            - 1.0)
            .abs()
            < 1e-12
    );
    assert_eq!(document["schema_version"], 1);
    assert_eq!(document["methods"][5]["plan"], Value::Null);
    assert_eq!(document["quality"]["warnings"], 1);
    assert_eq!(
        document["provenance"][0]["settings"]["filter"]["window"],
        50
    );
}

#[test]
fn keys_stand_in_the_documented_order_and_bytes_repeat() {
    let write = || evaluation_json(&sample::evaluation(true), &sample::provenance()).unwrap();
    let text = write();
    assert_eq!(text, write());
    assert!(text.ends_with("}\n"));
    let top = [
        "schema_version",
        "session",
        "default_method",
        "dictionary",
        "methods",
        "quality",
        "provenance",
    ];
    let places: Vec<usize> = top
        .iter()
        .map(|key| text.find(&format!("\n  \"{key}\"")).unwrap())
        .collect();
    assert!(places.is_sorted(), "{places:?}");
}

#[test]
fn what_was_written_is_read_back() {
    for object in [true, false] {
        let (evaluation, provenance) = (sample::evaluation(object), sample::provenance());
        let text = evaluation_json(&evaluation, &provenance).unwrap();
        let (read, steps) = read_evaluation_json(&text).unwrap();
        assert_eq!(read.session, evaluation.session);
        assert_eq!(read.quality, evaluation.quality);
        assert_eq!(read.methods.len(), evaluation.methods.len());
        assert_eq!(steps.len(), provenance.len());
        assert_near(
            &format!("{:?}", read.movement),
            &format!("{:?}", evaluation.movement),
        );
        assert_near(
            &format!("{:?}", read.contacts),
            &format!("{:?}", evaluation.contacts),
        );
        assert_eq!(steps[1].inputs, provenance[1].inputs);
        // Numbers may differ in the last digit, so pages are compared: they print fewer.
        let page = |e: &_, p: &_| inhand_report::html(&inhand_report::Report::new(e, p)).unwrap();
        assert_eq!(page(&read, &steps), page(&evaluation, &provenance));
    }
}

/// The same words, and numbers within the rounding of two changes of unit.
fn assert_near(found: &str, expected: &str) {
    let parts = |text: &str| -> Vec<String> {
        let is_edge = |c: char| !(c.is_alphanumeric() || c == '.' || c == '-');
        text.split(is_edge).map(str::to_owned).collect()
    };
    let (found, expected) = (parts(found), parts(expected));
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(&expected) {
        match (found.parse::<f64>(), expected.parse::<f64>()) {
            (Ok(a), Ok(b)) if a.is_finite() => assert!((a - b).abs() <= 1e-15 * b.abs().max(1.0)),
            _ => assert_eq!(found, expected),
        }
    }
}

/// Error of the JSON reader for a document.
fn source(text: &str) -> String {
    match read_evaluation_json(text).expect_err("the text is not an evaluation") {
        ReportError::NotAnEvaluation { source } => source.to_string(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_phase_that_stands_for_nothing_is_refused() {
    let text = evaluation_json(&sample::evaluation(true), &[]).unwrap();
    let other = text.replace("\"finger_gaiting\"", "\"walking\"");
    let refused = source(&other);
    assert!(
        refused.contains("walking") && refused.contains("regrasp"),
        "{refused}"
    );
}

#[test]
fn another_version_a_cut_file_and_other_json_are_refused() {
    let text = evaluation_json(&sample::evaluation(true), &[]).unwrap();
    let other = text.replacen("\"schema_version\": 1", "\"schema_version\": 2", 1);
    let refused = read_evaluation_json(&other).unwrap_err();
    assert!(
        matches!(
            refused,
            ReportError::Version {
                found: 2,
                expected: 1
            }
        ),
        "{refused:?}"
    );

    let refused = read_evaluation_json(&text[..text.len() / 2]).unwrap_err();
    assert!(refused.to_string().contains("line "), "{refused}");
    assert!(matches!(refused, ReportError::NotAnEvaluation { .. }));
    for text in [
        "",
        "{}",
        "[]",
        "{\"schema_version\": 1}",
        "{\"schema_version\": \"1\"}",
    ] {
        let refused = read_evaluation_json(text).unwrap_err();
        assert!(
            matches!(refused, ReportError::NotAnEvaluation { .. }),
            "{text}"
        );
    }
    let odd = text.replacen("\"iteration_limit\"", "\"boredom\"", 1);
    let refused = source(&odd);
    assert!(
        refused.contains("boredom") && refused.contains("iteration_limit"),
        "{refused}"
    );
}

#[test]
fn planned_objects_and_corridors_are_written_and_read_back() {
    let (evaluation, document) = (sample::evaluation(true), document(true));
    let number = |path: &str| document.pointer(path).unwrap().as_f64().unwrap();
    let near = |found: f64, expected: f64| assert!((found / expected - 1.0).abs() < 1e-14);
    let planned = evaluation.methods[0].object_error.unwrap();
    near(
        number("/methods/0/object_error_mm/p50"),
        1e3 * planned.position.p50,
    );
    near(
        number("/methods/0/object_angle_deg/p95"),
        planned.angle.p95.to_degrees(),
    );
    assert_eq!(number("/methods/0/corridors/1/share_stated"), 0.95);
    assert_eq!(document["methods"][5]["object_error_mm"], Value::Null);
    assert_eq!(document["methods"][5]["object_angle_deg"], Value::Null);
    assert_eq!(document["methods"][5]["corridors"], Value::Array(vec![]));

    let (read, _) = read_evaluation_json(&document.to_string()).unwrap();
    for (read, written) in read.methods.iter().zip(&evaluation.methods) {
        assert_eq!(read.corridors, written.corridors);
        assert_eq!(read.object_error.is_some(), written.object_error.is_some());
        if let Some((read, written)) = read.object_error.zip(written.object_error) {
            assert_eq!(read.angle.n_left_out, written.angle.n_left_out);
            near(read.position.rmse, written.position.rmse);
            near(read.angle.whisker_high, written.angle.whisker_high);
        }
    }

    // A corridor over nothing has no share, and comes back as it was.
    let mut evaluation = evaluation;
    let corridor = &mut evaluation.methods[0].corridors[0];
    (corridor.n, corridor.share_inside.all) = (0, f64::NAN);
    let text = evaluation_json(&evaluation, &[]).unwrap();
    let document: Value = serde_json::from_str(&text).unwrap();
    assert!(VALIDATOR.is_valid(&document));
    assert_eq!(
        document["methods"][0]["corridors"][0]["inside"]["all"],
        Value::Null
    );
    let (read, _) = read_evaluation_json(&text).unwrap();
    assert!(read.methods[0].corridors[0].share_inside.all.is_nan());
}

#[test]
fn a_document_from_before_objects_and_corridors_is_read() {
    let mut old = document(true);
    for method in old["methods"].as_array_mut().unwrap() {
        let keys = method.as_object_mut().unwrap();
        for key in ["object_error_mm", "object_angle_deg", "corridors"] {
            keys.remove(key);
        }
    }
    let (read, _) = read_evaluation_json(&old.to_string()).unwrap();
    let first = &read.methods[0];
    assert!(first.object_error.is_none() && first.corridors.is_empty());
}

static SAMPLE: LazyLock<Evaluation> = LazyLock::new(|| sample::evaluation(false));

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Whatever a number is, the document stays valid, and what is not finite is null.
    #[test]
    fn any_number_makes_a_valid_document(value in any::<f64>(), n in 0usize..3) {
        let mut evaluation = SAMPLE.clone();
        let error = &mut evaluation.methods[0].error.all;
        (error.n, error.p50, error.max) = (n, value, -value);
        evaluation.methods[0].velocity.worst_ratio = value;
        let text = evaluation_json(&evaluation, &[]).unwrap();
        let document: Value = serde_json::from_str(&text).unwrap();
        prop_assert!(VALIDATOR.is_valid(&document));
        let written = &document["methods"][0]["error_mm"]["all"]["p50"];
        prop_assert_eq!(written.is_null(), n == 0 || !(1e3 * value).is_finite());
        prop_assert!(inhand_report::html(&inhand_report::Report::new(&evaluation, &[])).is_ok());
    }
}
