use inhand_model::{Evaluation, MethodCandidate, PredictorWeights};
use inhand_report::{Report, html, text_summary};

use crate::page::{rows, text};
use crate::sample;

/// The text of the page, with ordinary spaces.
fn words(evaluation: &Evaluation) -> String {
    let page = html(&Report::new(evaluation, &[])).expect("the sample makes a page");
    text(&page).replace('\u{a0}', " ")
}

#[test]
fn infeasible_plans_say_which_constraint_would_have_to_be_relaxed() {
    let mut evaluation = sample::evaluation(true);
    let all_solved = words(&evaluation);
    assert!(all_solved.contains("No plan was infeasible"));
    assert!(!all_solved.contains("would mend"));

    let plan = evaluation.methods[1].plan.as_mut().unwrap();
    (plan.solved, plan.infeasible) = (116, 3);
    plan.families[0].active = 116;
    let velocity = &mut plan.families[1];
    (velocity.would_mend, velocity.largest_relaxation) = (2, 0.012_5);
    let rows = rows(&html(&Report::new(&evaluation, &[])).unwrap());
    for expected in [
        "velocity|4 of 116|2.0e-9 mm/s|2 of 3|12.50 mm/s",
        // Neither did this family mend anything, nor had this method anything to mend.
        "activations not negative|116 of 116|satisfied exactly|0 of 3|–",
        "distance between fingertips|2 of 119|satisfied exactly|–|–",
    ] {
        assert!(
            rows.iter()
                .any(|row| row.join("|").trim_end_matches('|') == expected),
            "{expected}"
        );
    }
}

#[test]
fn what_nobody_planned_has_no_section() {
    let mut evaluation = sample::evaluation(true);
    let held_out = evaluation.held_out.as_mut().unwrap();
    for method in evaluation.methods.iter_mut().chain(&mut held_out.methods) {
        method.corridors.clear();
        method.object_error = None;
        if let Some(plan) = &mut method.plan {
            plan.families.clear();
            plan.outside_hull = None;
        }
    }
    evaluation.dictionary.deviation = None;
    evaluation.choice = None;
    let page = html(&Report::new(&evaluation, &[])).unwrap();
    for gone in [
        "corridor",
        "rediction region",
        "Object pose",
        "family of constraints",
        "outside the hull",
        "Deviation",
        "auto chose",
        "Which method was chosen",
    ] {
        assert!(!page.contains(gone), "{gone}");
    }
    let text = text_summary(&evaluation);
    assert!(!text.contains("prediction region") && !text.contains("auto"));
}

#[test]
fn the_widest_prediction_regions_of_the_default_method_are_stated() {
    let mut evaluation = sample::evaluation(true);
    let line = "95 % prediction regions of residual contain 94.1 % of 59 500 recorded fingertip positions.\n";
    assert!(text_summary(&evaluation).contains(line));
    assert!(words(&evaluation).contains(line.trim_end_matches(".\n")));
    // None evaluated: dashes in the table, no figure, no sentence.
    for method in &mut evaluation.methods {
        for corridor in &mut method.corridors {
            corridor.n = 0;
        }
    }
    assert!(!text_summary(&evaluation).contains("prediction region"));
    let page = html(&Report::new(&evaluation, &[])).unwrap();
    assert!(!page.contains("recorded positions inside (%)"));
    assert!(rows(&page).iter().any(|row| {
        row.join("|")
            .starts_with("residual|1.61|–|–|–|–|–|–|0|119|0")
    }));
}

/// Each finger's dot stands where its number says, left or right of what was stated.
#[test]
fn dots_lie_where_their_numbers_say() {
    let page = html(&Report::new(&sample::evaluation(true), &[])).unwrap();
    let figure = &page[page.find("95 % prediction regions</p>").unwrap()..];
    let figure = &figure[..figure.find("</svg>").unwrap()];
    let numbers = |start: &str| -> Vec<f64> {
        figure
            .split(start)
            .skip(1)
            .map(|part| part.split('"').next().unwrap().parse().unwrap())
            .collect()
    };
    let stated = numbers("class=\"mark\" x1=\"")[0];
    let dots = numbers("class=\"point\" cx=\"");
    assert_eq!(dots.len(), 10);
    // Of residual the thumb alone has more than 95 %, of prior no finger has.
    let right: Vec<bool> = dots.iter().map(|&x| x > stated).collect();
    assert_eq!(right.iter().filter(|&&right| right).count(), 1);
    assert!(right[0]);
    // Half a percent from finger to finger, four percent from method to method.
    let step = dots[0] - dots[1];
    assert!((dots[0] - dots[5] - 8.0 * step).abs() < 0.1);
}

#[test]
fn the_deviation_states_its_validation() {
    let mut evaluation = sample::evaluation(true);
    assert!(words(&evaluation).contains(
        "On 590 left-out segments of 5 groups of takes the cubic baseline has an error of 0.727 mm, with the \
         deviation 0.629 mm (difference −0.098 ± 0.009 mm, the standard error over segments)."
    ));
    evaluation.session.train.truncate(1);
    assert!(
        words(&evaluation)
            .contains("590 left-out segments of 5 intervals of the one training take")
    );

    let deviation = evaluation.dictionary.deviation.as_mut().unwrap();
    deviation.weights = PredictorWeights::default();
    deviation.validation.error_m = deviation.validation.smooth_error_m;
    deviation.validation.standard_error_m = 0.0;
    let told = words(&evaluation);
    assert!(told.contains(
        "All weights are zero, so plans are the cubic baseline within the velocity bounds: on 590"
    ));
    assert!(told.contains("no learned deviation was better by more than the standard error"));

    let deviation = evaluation.dictionary.deviation.as_mut().unwrap();
    (deviation.validation.folds, deviation.validation.segments) = (0, 0);
    assert!(words(&evaluation).contains(
        "too little training data to leave any out and validate the deviation, so all weights are \
         zero and plans are the cubic baseline within the velocity bounds."
    ));
}

#[test]
fn the_choice_has_its_reason() {
    let start = |name: &str, mm: &str| {
        format!(
            "auto chose {name}: on 590 training segments left out of learning, under the held-out protocol, its mean error is {mm} mm"
        )
    };
    let check = |evaluation: &Evaluation, expected: &str| {
        let text = text_summary(evaluation);
        assert!(text.contains(&format!("{expected}.\n")), "{text}");
        assert!(words(evaluation).contains(expected));
    };
    let mut evaluation = sample::evaluation(true);
    let learned = start("residual", "0.629");
    check(
        &evaluation,
        &format!(
            "{learned}, against 0.727 mm of hermite, the best baseline; the gain of \
             0.098 ± 0.009 mm is above its standard error"
        ),
    );
    // A gain within its standard error, none at all, and a learned method that failed.
    let plain = start("hermite", "0.727");
    for (residual_m, gain_m, rest) in [
        (
            0.000_72,
            0.000_007,
            ", against 0.720 mm of residual, the best learned method, whose gain of 0.007 ± 0.009 mm \
             is not above its standard error",
        ),
        (
            0.000_9,
            -0.000_173,
            ", against 0.900 mm of residual, the best learned method",
        ),
        (
            f64::INFINITY,
            f64::NEG_INFINITY,
            "; residual, the best learned method, fails for some segments",
        ),
    ] {
        let choice = evaluation.choice.as_mut().unwrap();
        choice.method = "hermite".to_owned();
        choice.candidates = [("residual", residual_m), ("hermite", 0.000_727)]
            .map(|(name, mean_error_m)| MethodCandidate {
                name: name.to_owned(),
                mean_error_m,
            })
            .into();
        choice.gain_m = Some(gain_m);
        check(&evaluation, &format!("{plain}{rest}"));
    }
    assert!(
        rows(&html(&Report::new(&evaluation, &[])).unwrap())
            .iter()
            .any(|row| row.join("|").starts_with("residual|a plan failed|590"))
    );
    // Candidates of one kind, and one alone.
    let choice = evaluation.choice.as_mut().unwrap();
    choice.method = "residual".to_owned();
    choice.candidates[0].mean_error_m = 0.000_629;
    choice.candidates[1] = MethodCandidate {
        name: "prior".to_owned(),
        mean_error_m: 0.001_08,
    };
    (choice.gain_m, choice.gain_standard_error_m) = (None, None);
    check(&evaluation, &format!("{learned}, the least of 2 methods"));
    evaluation.choice.as_mut().unwrap().candidates.pop();
    check(
        &evaluation,
        &format!("{learned}, and nothing else was compared"),
    );
}
