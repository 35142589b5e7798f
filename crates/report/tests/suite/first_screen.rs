use inhand_model::{Evaluation, Finding, Finger, Level, MethodEvaluation, StopReason};
use inhand_report::{Report, html};

use crate::page::text;
use crate::{sample, sample_rows};

const PROTOCOL: &str = r#"{"process":{"filter":"median","window":50}}"#;

fn page(evaluation: &Evaluation) -> String {
    let mut provenance = sample::provenance();
    PROTOCOL.clone_into(&mut provenance[0].settings_json);
    provenance.truncate(1);
    let rows = sample_rows::rows(evaluation, true);
    let report = Report {
        rows: Some(&rows),
        ..Report::new(evaluation, &provenance)
    };
    html(&report).expect("the sample makes a page")
}

/// The page as it opens: without what is folded away, styles and the script.
fn opened(page: &str) -> String {
    let mut shown = String::new();
    let mut depth = 0_usize;
    for part in page[page.find("<body>").expect("a body")..page.find("<script>").expect("a script")]
        .split('<')
    {
        if part.starts_with("details") {
            depth += 1;
        }
        // Titles of shapes show under a pointer alone.
        if depth == 0 && !part.starts_with("title") {
            shown += "<";
            shown += part;
        }
        if part.starts_with("/details") {
            depth -= 1;
        }
    }
    shown
}

#[test]
fn a_page_opens_short() {
    let mut evaluation = sample::evaluation(true);
    evaluation.intervals = Some(sample_rows::intervals(&evaluation));
    let page = page(&evaluation);
    assert!(!page.contains("<details open"), "nothing is open");
    let shown = opened(&page);
    let words = text(&shown.replace('<', " <")).split_whitespace().count();
    assert!(words < 2500, "{words} words");
    assert!(words > 500, "{words} words");
    let count = |tag: &str| shown.matches(tag).count();
    assert!(count("<figure ") <= 9, "{} figures", count("<figure "));
    assert!(count("<table") <= 6, "{} tables", count("<table"));
    // At most one figure and one table a section.
    for section in shown.split("<section ").skip(1) {
        assert!(section.matches("<figure ").count() <= 1, "{section}");
        assert!(section.matches("<table").count() <= 1, "{section}");
    }
    // In the order in which they are read.
    let order = [
        "5 training takes (",
        "class=\"verdict",
        "id=\"figure-error-overview\"",
        "Error of all fingers",
        "Worrying",
        "id=\"quality\"",
    ];
    let places: Vec<_> = order.iter().map(|own| shown.find(own)).collect();
    assert!(places.iter().all(Option::is_some), "{places:?}");
    assert!(places.is_sorted(), "{places:?}");
}

/// The lines of the first screen about what is worrying.
fn worries(evaluation: &Evaluation) -> Vec<String> {
    let page = page(evaluation);
    let part = &page[page.find("class=\"worries\"").expect("its list")..];
    let part = &part[..part.find("Looked at without").expect("the end of it")];
    let lines = part.split("<li").skip(1);
    lines
        .map(|line| text(line).replace('\u{a0}', " "))
        .collect()
}

/// An evaluation without any worry.
fn fine() -> Evaluation {
    let mut evaluation = sample::evaluation(true);
    evaluation.dictionary.stop_reason = StopReason::Converged;
    for take in &mut evaluation.quality {
        take.findings.clear();
    }
    for take in (evaluation.session.train.iter_mut()).chain(&mut evaluation.session.test) {
        take.left_out = 0;
    }
    if let Some(inspection) = &mut evaluation.inspection {
        inspection.findings.clear();
    }
    let movement = evaluation.movement.as_mut().expect("the sample has it");
    for (_, planned) in &mut movement.methods {
        planned.by_finger = movement.recorded.by_finger;
    }
    let held_out = evaluation.held_out.as_mut().expect("the sample has it");
    for (own, published) in held_out.methods.iter_mut().zip(&evaluation.methods) {
        own.error = published.error;
    }
    for method in evaluation.methods.iter_mut().chain(&mut held_out.methods) {
        method.collision.instants = method.collision.recorded_instants;
        method.velocity.outside = 0;
        method.reachability.inside = method.reachability.recorded_inside;
        for region in &mut method.corridors {
            region.share_inside.all = region.share_stated;
        }
        if let Some(contact) = &mut method.contact {
            contact.three_or_more = contact.recorded_three_or_more;
        }
        if method.name == "paper" {
            for finger in Finger::ALL {
                method.error.by_finger[finger].p75 = 0.001;
            }
        }
    }
    evaluation
}

#[test]
fn nothing_worrying_is_said_with_what_was_looked_at() {
    let page = page(&fine());
    assert!(
        page.contains("Nothing worrying was found"),
        "{:?}",
        worries(&fine())
    );
    let part = &page[page.find("Looked at without a worry").unwrap()..];
    let part = &part[..part.find("</p>").unwrap()];
    for label in [
        "Collisions",
        "Peak speed",
        "Learning",
        "Unfiltered recording",
        "Published values",
        "Coverage",
        "Plans",
        "Velocity",
        "Reach",
        "Contacts",
        "Gaps",
        "Reader",
        "Inspection",
    ] {
        assert!(part.contains(&format!("<b>{label}</b>")), "{label}: {part}");
    }
    // A run that does not follow the published protocol was not compared with published values.
    let page = html(&Report::new(&fine(), &[])).unwrap();
    assert!(!page.contains("<b>Published values</b>"));
    assert!(page.contains("cube, 50 mm; 100"));
}

/// The default method under the held-out protocol, which the first screen is about.
fn held_out(evaluation: &mut Evaluation) -> &mut MethodEvaluation {
    &mut evaluation
        .held_out
        .as_mut()
        .expect("the sample has it")
        .methods[0]
}

/// Makes one number of an evaluation bad.
type Spoil = fn(&mut Evaluation);

#[test]
fn each_bad_number_has_a_line() {
    let bad: [(&str, Spoil); 15] = [
        (
            "fingertips of residual nearer than 10 mm at 220 of 11 900 instants (recording: ",
            |e| held_out(e).collision.instants = 220,
        ),
        ("Peak speed: index", |e| {
            let speeds = &mut e.movement.as_mut().unwrap().methods[0].1.by_finger;
            speeds[Finger::Index].peak_speed_m_s.p50 *= 0.4;
        }),
        ("Peak speed: thumb 0.0 mm/s with residual", |e| {
            let speeds = &mut e.movement.as_mut().unwrap().methods[0].1.by_finger;
            speeds[Finger::Thumb].peak_speed_m_s.p50 = 0.0;
        }),
        (
            "Learning: stopped at its limit of 40 iterations, before it converged",
            |e| {
                e.dictionary.stop_reason = StopReason::IterationLimit;
            },
        ),
        (
            "Unfiltered recording: median error 0.81 mm against it, 0.40 mm",
            |e| {
                held_out(e).error.all.p50 *= 2.0;
            },
        ),
        (
            "Unfiltered recording: median error – mm against it",
            |e| held_out(e).error.all.p50 = f64::NAN,
        ),
        (
            "this evaluation was made before the held-out protocol",
            |e| e.held_out = None,
        ),
        (
            "75 % of the errors of paper are below 2.00 mm in the worst finger (published: 1.2 mm)",
            |e| {
                e.methods[2].error.by_finger[Finger::Ring].p75 = 0.002;
            },
        ),
        ("three contacts at 95.0 % (published: 97 %)", |e| {
            e.methods[2].contact.as_mut().unwrap().three_or_more = 0.95;
        }),
        (
            "95 % prediction regions of residual contain 90.0 % of 59 500 recorded fingertip positions",
            |e| {
                for region in &mut held_out(e).corridors {
                    region.share_inside.all = 0.9;
                }
            },
        ),
        (
            "Coverage: 95 % prediction regions of residual contain – %",
            |e| {
                for region in &mut held_out(e).corridors {
                    region.share_inside.all = f64::NAN;
                }
            },
        ),
        ("Plans: 117 of 119 solved, 2 infeasible, 0 failed", |e| {
            let plan = held_out(e).plan.as_mut().unwrap();
            (plan.solved, plan.infeasible) = (117, 2);
        }),
        ("Velocity: 5 of 176 715 steps outside the bounds", |e| {
            held_out(e).velocity.outside = 5;
        }),
        (
            "Reader: 1 warning about 1 of 6 takes, the first cube_02",
            |e| {
                let take = e
                    .quality
                    .iter_mut()
                    .find(|take| take.take == "cube_02")
                    .unwrap();
                take.findings.push(Finding::warning("marker", "odd"));
            },
        ),
        (
            "swaps (cube_train_02, index and middle): 2 suspected swaps",
            |e| {
                e.inspection = sample::evaluation(true).inspection;
                e.inspection.as_mut().unwrap().findings[0].level = Level::Warn;
            },
        ),
    ];
    assert_eq!(worries(&fine()), [""; 0]);
    for (words, spoil) in bad {
        let mut evaluation = fine();
        spoil(&mut evaluation);
        let found = worries(&evaluation);
        assert_eq!(found.len(), 1, "{words}: {found:?}");
        assert!(found[0].contains(words), "{words}: {found:?}");
    }
}
