use inhand_report::{Report, html, text_summary};

use crate::sample;

#[test]
fn the_table_shows_every_method_and_the_contacts() {
    let text = text_summary(&sample::evaluation(true));
    let line = |start: &str| {
        text.lines()
            .find(|l| l.starts_with(start))
            .unwrap()
            .to_owned()
    };
    let fields: Vec<String> = line("  hermite")
        .split_whitespace()
        .map(str::to_owned)
        .collect();
    assert_eq!(
        fields,
        [
            "hermite", "cubic,", "no", "learning", "0.40", "0.93", "3.86", "11.20", "98.7", "%"
        ]
    );
    assert_eq!(
        line("Three or more"),
        "Three or more fingertips touch the object 99.2 % of the time with residual, > 99.9 % in the \
         recorded motion (contact: within 5 mm)."
    );
    // Numbers end in one column, whatever the names are.
    let ends: Vec<usize> = text.lines().take(8).map(|l| l.chars().count()).collect();
    assert!(
        ends.iter().all(|&end| end == ends[0] && end <= 100),
        "{ends:?}\n{text}"
    );
    assert!(!text.contains('\u{202f}') && text.ends_with(".\n"));
}

#[test]
fn a_lower_error_or_a_tie_of_the_default_method_is_stated() {
    let expected = "residual ties with the best baseline at the median (0.40 vs 0.40 mm of \
        hermite) and maximum (11.28 vs 11.20 mm of hermite). residual has a lower error than every \
        baseline at the third quartile (0.83 vs 0.93 mm of hermite) and 95 % quantile (2.81 \
        vs 3.69 mm of line).";
    let evaluation = sample::evaluation(true);
    assert!(text_summary(&evaluation).contains(expected));
    let page = html(&Report::new(&evaluation, &[]))
        .unwrap()
        .replace('\u{a0}', " ");
    assert!(page.contains(expected));
    assert!(page.contains("class=\"verdict kept-up\""));
}

#[test]
fn a_higher_error_is_stated_first() {
    let expected = "hermite, which learns nothing, has a lower error than prior at the median \
        (0.40 vs 0.79 mm), third quartile (0.93 vs 1.32 mm) and maximum \
        (11.20 vs 22.12 mm). prior has a lower error than every baseline at the 95 % quantile \
        (3.13 vs 3.69 mm of line).";
    let mut evaluation = sample::evaluation(true);
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
    let mut evaluation = sample::evaluation(true);
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
            "residual has a lower error than every baseline: median (0.20 vs 0.40 mm of hermite)",
        ),
        (
            1.0,
            "residual ties with the best baseline at the median (0.40 vs 0.40 mm of hermite)",
        ),
        (
            2.0,
            "hermite, which learns nothing, has a lower error than residual everywhere: median",
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
    let mut evaluation = sample::evaluation(true);
    evaluation.methods[0].description = "knows a great deal ".repeat(9);
    let text = text_summary(&evaluation);
    assert!(
        text.lines().take(8).all(|line| line.chars().count() <= 100),
        "{text}"
    );
    assert!(
        text.contains("knows a great deal knows a great de…"),
        "{text}"
    );
}
