use inhand_model::Evaluation;
use inhand_report::{Report, html, text_summary};

use crate::sample;

/// An evaluation of a version without the held-out protocol.
fn older() -> Evaluation {
    Evaluation {
        held_out: None,
        ..sample::evaluation(true)
    }
}

#[test]
fn the_table_shows_every_method_under_both_protocols_and_the_contacts() {
    let text = text_summary(&sample::evaluation(true));
    let line = |start: &str| {
        text.lines()
            .find(|l| l.starts_with(start))
            .unwrap()
            .to_owned()
    };
    let fields = |start: &str| -> Vec<String> {
        let line = line(start);
        line.split_whitespace().map(str::to_owned).collect()
    };
    assert_eq!(fields("    ")[..], ["held", "out", "published", "3+"]);
    assert_eq!(
        fields("hermite"),
        [
            "hermite", "cubic,", "no", "learning", "0.60", "5.79", "0.40", "3.86", "98.7", "%"
        ]
    );
    assert_eq!(
        line("Three or more"),
        "Three or more fingertips touch the object 99.2 % of the time with residual, > 99.9 % in the \
         recorded motion (contact: within 5 mm)."
    );
    // Numbers end in one column, whatever the names are.
    let ends: Vec<usize> = text.lines().map(|l| l.chars().count()).collect();
    assert!(ends[1..9].iter().all(|&end| end == ends[1]), "{text}");
    assert!(ends[..11].iter().all(|&end| end <= 80), "{ends:?}\n{text}");
    // The report compares the other methods, and under the other protocol.
    assert!(text.contains("\nheld out: residual"), "{text}");
    assert!(text.lines().count() <= 9 + 6, "{text}");
    assert!(!text.contains('\u{202f}') && text.ends_with(".\n"));
}

#[test]
fn an_evaluation_without_held_out_errors_says_so() {
    let evaluation = older();
    let page = html(&Report::new(&evaluation, &[])).unwrap();
    for text in [text_summary(&evaluation), page] {
        assert!(text.contains("was made before the held-out protocol"));
        assert!(!text.contains("eld out"), "{text}");
    }
    let text = text_summary(&evaluation);
    let line = text.lines().find(|l| l.starts_with("hermite")).unwrap();
    assert!(line.ends_with("0.40   3.86    98.7 %"), "{line}");
}

#[test]
fn both_protocols_are_on_the_first_screen_and_defined_once() {
    let page = html(&Report::new(&sample::evaluation(true), &[])).unwrap();
    let first = page.split("<nav").next().unwrap().replace('\u{a0}', " ");
    for words in [
        "Held out, over ",
        "118 test segments, residual (cubic and learned deviation from it) ",
        "Held out: against the unfiltered recording",
        "Published: against the filtered recording",
    ] {
        assert!(first.contains(words), "{words}: {first}");
    }
    for words in [
        "least-squares lines over 80 ms",
        "It is the protocol of arXiv:2308.15153",
    ] {
        assert_eq!(page.matches(words).count(), 1, "{words}");
    }
}

#[test]
fn a_lower_error_or_a_tie_of_the_default_method_is_stated() {
    let expected = "residual ties with the best baseline at the median (0.40 vs 0.40 mm of \
        hermite) and maximum (11.28 vs 11.20 mm of hermite); it has a lower error than every \
        baseline at the third quartile (0.83 vs 0.93 mm of hermite) and 95 % quantile (2.81 \
        vs 3.69 mm of line)";
    let evaluation = older();
    assert!(text_summary(&evaluation).contains(expected));
    let page = html(&Report::new(&evaluation, &[]))
        .unwrap()
        .replace('\u{a0}', " ");
    assert!(page.contains(&expected["residual ".len()..]));
    assert!(page.contains("class=\"verdict kept-up\""));
}

#[test]
fn a_higher_error_is_stated() {
    let expected = "has a higher error than the best baseline at the median \
        (0.79 vs 0.40 mm of hermite), third quartile (1.32 vs 0.93 mm of hermite) and maximum \
        (22.12 vs 11.20 mm of hermite); it has a lower error than every baseline at the 95 % quantile \
        (3.13 vs 3.69 mm of line)";
    let mut evaluation = older();
    evaluation.default_method = "prior".to_owned();
    assert!(text_summary(&evaluation).contains(expected));
    let page = html(&Report::new(&evaluation, &[]))
        .unwrap()
        .replace('\u{a0}', " ");
    assert!(page.contains(expected));
    assert!(page.contains("class=\"verdict behind\""));
    let verdict = page.find("class=\"verdict").unwrap();
    assert!(
        verdict < page.find("<nav").unwrap(),
        "the verdict comes first"
    );
}

#[test]
fn other_outcomes_have_their_words() {
    let mut evaluation = older();
    let best = evaluation.methods[6].error.all;
    let scaled = |factor: f64| {
        let mut error = best;
        for value in [
            &mut error.p50,
            &mut error.p75,
            &mut error.p95,
            &mut error.max,
        ] {
            *value *= factor;
        }
        error
    };
    // Only the cubic is left to compare with.
    evaluation
        .methods
        .retain(|method| method.name == "residual" || method.name == "hermite");
    for (factor, words) in [
        (
            0.5,
            "residual has a lower error than the only baseline at the median (0.20 vs 0.40 mm of hermite)",
        ),
        (
            1.0,
            "residual ties with the only baseline at the median (0.40 vs 0.40 mm of hermite)",
        ),
        (
            2.0,
            "residual has a higher error than the only baseline at the median (0.80 vs 0.40 mm of hermite)",
        ),
    ] {
        evaluation.methods[0].error.all = scaled(factor);
        let text = text_summary(&evaluation);
        assert!(text.contains(words), "{factor}: {text}");
        let page = html(&Report::new(&evaluation, &[])).unwrap();
        assert_eq!(page.contains("verdict behind"), factor > 1.0);
    }
    evaluation.methods.retain(|method| !method.baseline);
    assert!(text_summary(&evaluation).contains("no baseline to compare residual with"));
}

#[test]
fn a_long_description_does_not_widen_the_table() {
    let mut evaluation = older();
    evaluation.methods[0].description = "knows a great deal ".repeat(9);
    let text = text_summary(&evaluation);
    assert!(
        text.lines().take(8).all(|line| line.chars().count() <= 80),
        "{text}"
    );
    assert!(text.contains("knows a great deal knows…"), "{text}");
}
