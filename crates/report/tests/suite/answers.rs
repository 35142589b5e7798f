use inhand_model::{DictionaryKind, PerFinger, Statistics, StopReason};
use inhand_report::{Report, ReportError, evaluation_json, html, text_summary};
use serde_json::Value;

use crate::sample;

#[test]
fn a_default_method_that_is_not_there_is_refused() {
    let mut evaluation = sample::evaluation(true);
    evaluation.default_method = "magic".to_owned();
    for refused in [
        evaluation_json(&evaluation, &[]).unwrap_err(),
        html(&Report::new(&evaluation, &[])).unwrap_err(),
    ] {
        assert!(
            matches!(&refused, ReportError::UnknownDefaultMethod { name, .. } if name == "magic")
        );
        let words = refused.to_string();
        assert!(
            words.contains("cube") && words.contains("residual, prior, paper, hold"),
            "{words}"
        );
    }
    evaluation.methods.clear();
    let words = html(&Report::new(&evaluation, &[]))
        .unwrap_err()
        .to_string();
    assert!(words.contains("evaluated were: none"), "{words}");
    assert!(text_summary(&evaluation).contains("error over all fingers"));
}

#[test]
fn two_methods_of_one_name_are_refused() {
    let mut evaluation = sample::evaluation(true);
    evaluation.methods[5].name = "line".to_owned();
    let refused = evaluation_json(&evaluation, &[]).unwrap_err();
    assert!(
        matches!(refused, ReportError::DuplicateMethod { times: 2, .. }),
        "{refused}"
    );
}

#[test]
fn without_an_object_contacts_are_said_to_be_missing() {
    let evaluation = sample::evaluation(false);
    let page = html(&Report::new(&evaluation, &[])).unwrap();
    assert!(page.contains("Contacts were not evaluated"));
    assert!(!page.contains("contact threshold tau"));
    let document: Value =
        serde_json::from_str(&evaluation_json(&evaluation, &[]).unwrap()).unwrap();
    assert_eq!(document["methods"][0]["contact"], Value::Null);
    assert_eq!(
        document["methods"][0]["distance_difference_mm"],
        Value::Null
    );
    assert!(!text_summary(&evaluation).contains("contact"));
}

#[test]
fn an_object_that_was_never_tracked_gives_no_share() {
    let mut evaluation = sample::evaluation(true);
    for method in &mut evaluation.methods {
        let contact = method.contact.as_mut().unwrap();
        (contact.n, contact.three_or_more) = (0, f64::NAN);
    }
    let page = html(&Report::new(&evaluation, &[])).unwrap();
    assert!(page.contains("Contacts could not be evaluated"));
    assert!(!page.contains("contact threshold tau"));
    let document: Value =
        serde_json::from_str(&evaluation_json(&evaluation, &[]).unwrap()).unwrap();
    assert_eq!(
        document["methods"][0]["contact"]["three_or_more"],
        Value::Null
    );
    let text = text_summary(&evaluation);
    assert!(text.contains("Contacts could not be evaluated"), "{text}");
    assert!(text.contains("no instant with a tracked object"), "{text}");
}

/// Failed plans leave a method without a single instant: nothing becomes zero.
#[test]
fn a_method_without_a_trajectory_has_dashes_not_zeros() {
    let mut evaluation = sample::evaluation(true);
    evaluation.held_out = None;
    let method = &mut evaluation.methods[0];
    method.error.all = Statistics {
        n_left_out: 59_500,
        ..Statistics::default()
    };
    method.error.by_finger = PerFinger::new([method.error.all; 5]);
    method.error_at_start = method.error.all;
    method.error_at_goal = method.error.all;
    method.distance_difference = Some(method.error.by_finger);
    method.median_error_by_sample_m.fill(f64::NAN);
    method.reachability.n = 0;
    method.reachability.inside = PerFinger::new([f64::NAN; 5]);
    (
        method.collision.n,
        method.collision.nearest_m,
        method.collision.nearest_pair,
    ) = (0, f64::NAN, None);
    (method.velocity.n, method.velocity.worst_ratio) = (0, f64::NAN);
    method.contact.as_mut().unwrap().n = 0;
    let plan = method.plan.as_mut().unwrap();
    (
        plan.solved,
        plan.infeasible,
        plan.failed,
        plan.worst_kkt_residual,
    ) = (0, 117, 2, f64::NAN);

    let page = html(&Report::new(&evaluation, &[])).unwrap();
    assert!(page.contains("residual could not be evaluated"));
    assert!(page.contains("nothing to evaluate"));
    assert!(page.contains("0 of 119 solved, 117 infeasible, 2 failed"));
    assert!(!page.contains("NaN"));
    let document: Value =
        serde_json::from_str(&evaluation_json(&evaluation, &[]).unwrap()).unwrap();
    let method = &document["methods"][0];
    for path in [
        "/error_mm/all/p50",
        "/error_mm/all/max",
        "/velocity/worst_ratio",
        "/plan/worst_kkt_residual",
        "/collision/nearest_mm",
        "/reachability/inside/all",
    ] {
        assert_eq!(method.pointer(path), Some(&Value::Null), "{path}");
    }
    assert_eq!(method["error_mm"]["all"]["n_left_out"], 59_500);
    let text = text_summary(&evaluation);
    assert!(text.lines().nth(2).unwrap().contains('–'), "{text}");
    assert!(
        text.contains("residual cannot be compared with a baseline"),
        "{text}"
    );
}

#[test]
fn numbers_that_are_none_never_reach_the_page() {
    let mut evaluation = sample::evaluation(true);
    let nan = Statistics {
        n: 7,
        mean: f64::NAN,
        p50: f64::NAN,
        max: f64::INFINITY,
        ..Statistics::default()
    };
    for method in &mut evaluation.methods {
        method.error.all = nan;
        method.error.by_finger = PerFinger::new([nan; 5]);
        method.reachability.worst_outside_m = PerFinger::new([f64::NAN; 5]);
        method.collision.limit_m = f64::NAN;
        for share in &mut method.contact.as_mut().unwrap().by_tau {
            share.three_or_more = f64::NAN;
        }
    }
    for method in &mut evaluation.methods {
        if let Some(object) = &mut method.object_error {
            (object.position, object.angle) = (nan, nan);
        }
        for corridor in &mut method.corridors {
            (corridor.share_inside.all, corridor.mahalanobis) = (f64::NAN, f64::INFINITY);
            corridor.share_inside.by_finger = PerFinger::new([f64::NAN; 5]);
        }
        for facts in method.plan.iter_mut().flat_map(|plan| &mut plan.families) {
            (facts.worst_violation, facts.largest_relaxation) = (f64::NAN, f64::INFINITY);
        }
        if let Some(plan) = &mut method.plan {
            (plan.infeasible, plan.families[0].would_mend) = (2, 2);
        }
    }
    let deviation = evaluation.dictionary.deviation.as_mut().unwrap();
    (deviation.weights.hand, deviation.bandwidths.finger) = (f64::NAN, f64::INFINITY);
    deviation.validation.error_m = f64::NAN;
    let choice = evaluation.choice.as_mut().unwrap();
    (choice.gain_m, choice.gain_standard_error_m) = (Some(f64::NAN), Some(f64::INFINITY));
    choice.candidates[0].mean_error_m = f64::NAN;
    evaluation.session.rate_hz = f64::NAN;
    evaluation.dictionary.objective_history_m2 = vec![f64::NAN, -1.0, 0.0, f64::INFINITY];
    let page = html(&Report::new(&evaluation, &sample::provenance())).unwrap();
    for word in ["NaN", "inf<", "inf ", "inf\""] {
        assert!(!page.contains(word), "{word}");
    }
    let text = evaluation_json(&evaluation, &[]).unwrap();
    assert!(!text.contains("NaN") && !text.contains("inf,"));
    let text = text_summary(&evaluation);
    assert!(!text.contains("NaN") && !text.contains("inf "), "{text}");
}

#[test]
fn one_take_no_quality_no_provenance_no_history() {
    let mut evaluation = sample::evaluation(false);
    evaluation.session.train.truncate(1);
    evaluation.session.test.clear();
    evaluation.quality.clear();
    evaluation.methods.truncate(1);
    evaluation.dictionary.kind = DictionaryKind::Pca;
    evaluation.dictionary.stop_reason = StopReason::ClosedForm;
    evaluation.dictionary.objective_history_m2.clear();
    let page = html(&Report::new(&evaluation, &[])).unwrap();
    for words in [
        "1 training take (2.0 min, 119 segments) and 0 test takes (0.0 min, 0 segments)",
        "The gaps of the takes are not known",
        "No provenance was recorded",
        "does not iterate",
        "no baseline to compare residual with",
    ] {
        assert!(page.contains(words), "{words}");
    }
    assert!(!page.contains("Objective while learning"));
}

#[test]
fn takes_without_gaps_and_many_findings() {
    let mut evaluation = sample::evaluation(true);
    let (clean, findings) = (
        evaluation.quality[0].clone(),
        evaluation.quality[1].findings.clone(),
    );
    for quality in &mut evaluation.quality {
        quality.fingers = clean.fingers;
        quality.findings.clear();
    }
    let page = html(&Report::new(&evaluation, &[])).unwrap();
    assert!(page.contains("No fingertip is missing at any sample"));
    assert!(page.contains("The reader of the takes found nothing."));
    evaluation.quality[2].findings = (0..10).flat_map(|_| findings.clone()).collect();
    assert!(
        html(&Report::new(&evaluation, &[]))
            .unwrap()
            .contains("14 more")
    );
}

#[test]
fn settings_of_another_tool_stay_as_they_are() {
    let mut provenance = sample::provenance();
    provenance[0].settings_json = "--window 50 (not JSON)".to_owned();
    let evaluation = sample::evaluation(true);
    assert!(
        html(&Report::new(&evaluation, &provenance))
            .unwrap()
            .contains("--window 50 (not JSON)")
    );
    let text = evaluation_json(&evaluation, &provenance).unwrap();
    let (_, read) = inhand_report::read_evaluation_json(&text).unwrap();
    assert_eq!(read[0].settings_json, provenance[0].settings_json);
}
