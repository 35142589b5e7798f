//! The top of the page, and the list of methods.

use inhand_model::{Evaluation, MethodEvaluation, TakeFacts};
use maud::{Markup, html};

use super::table::{Line, table, words};
use super::{Method, choice};
use crate::learned::corridor_words;
use crate::number::{NARROW_SPACE, NONE, count, decimals, plain};
use crate::verdict::{
    Outcome, comparisons, constraint_sentence, contact_sentence, default_method, error_sentence,
    standing_sentence,
};
use crate::words::tied;

/// Name, facts and verdict.
pub(super) fn header(evaluation: &Evaluation) -> Markup {
    let session = &evaluation.session;
    let dictionary = &evaluation.dictionary;
    let seconds = session.segment_samples as f64 / session.rate_hz;
    html! {
        header {
            p.kind { "In-hand manipulation report" }
            h1 { (session.name) }
            dl.facts {
                (fact("Object", session.object.as_deref().unwrap_or("none given")))
                (fact("Training", &takes(&session.train)))
                (fact("Test", &takes(&session.test)))
                (fact("Sample rate", &format!("{} Hz", plain(session.rate_hz))))
                (fact("Segment", &format!("{} samples, {} s", session.segment_samples, plain(seconds))))
                (fact("Dictionary", &format!(
                    "{}, {} primitives", dictionary.kind.name().to_uppercase(), dictionary.rank
                )))
                @if let Some(deviation) = &dictionary.deviation {
                    (fact("Deviation", &format!("{} primitives", deviation.primitives)))
                }
            }
            (verdict(evaluation))
        }
    }
}

fn fact(name: &str, value: &str) -> Markup {
    html! { div { dt { (name) } dd { (value) } } }
}

fn takes(takes: &[TakeFacts]) -> String {
    let seconds: f64 = takes.iter().map(|take| take.duration_s).sum();
    let segments: usize = takes.iter().map(|take| take.segments).sum();
    format!(
        "{} {}, {} s, {} {}",
        takes.len(),
        if takes.len() == 1 { "take" } else { "takes" },
        decimals(seconds, 0),
        count(segments, NARROW_SPACE),
        if segments == 1 { "segment" } else { "segments" },
    )
}

fn verdict(evaluation: &Evaluation) -> Markup {
    let method = default_method(evaluation);
    let outcomes: Vec<Outcome> = method
        .map(|method| comparisons(method, evaluation))
        .into_iter()
        .flatten()
        .map(|comparison| comparison.outcome)
        .collect();
    let unsolved = method
        .and_then(|method| method.plan.as_ref())
        .is_some_and(|plan| plan.infeasible + plan.failed > 0);
    let class = if unsolved || outcomes.contains(&Outcome::Behind) {
        "verdict behind"
    } else if outcomes.is_empty() {
        "verdict"
    } else {
        "verdict kept-up"
    };
    html! {
        div class=(class) {
            p.lead { (tied(&error_sentence(evaluation))) }
            @if let Some(method) = method {
                p.lead { (tied(&standing_sentence(method, evaluation))) }
            }
            @if let Some(sentence) = contact_sentence(evaluation) { p { (tied(&sentence)) } }
            @if let Some(words) = corridor_words(evaluation) { p { (tied(&format!("{words}."))) } }
            @if let Some(sentence) = constraint_sentence(evaluation) { p { (tied(&sentence)) } }
            p.note {
                "Up to 2 % apart counts as level, and so does a difference whose interval holds zero; a maximum has no interval. \
                 Neighbouring instants are not independent of one another, so small differences between methods may not hold on \
                 another session."
            }
        }
    }
}

/// What each method knows.
pub(super) fn methods(evaluation: &Evaluation, methods: &[Method<'_>]) -> Markup {
    let lines = methods
        .iter()
        .map(|method| Line {
            head: name(method),
            cells: vec![
                method.evaluation.description.clone(),
                if method.evaluation.baseline {
                    "no, a baseline"
                } else {
                    "yes"
                }
                .to_owned(),
                standing(method.evaluation, evaluation),
            ],
            best: Vec::new(),
            stressed: method.default,
        })
        .collect();
    html! {
        p {
            "Every method plans the same test segments. A baseline has learned nothing from the training takes; \
             a learned method is worth its trouble only where it does better than all baselines."
        }
        (table(
            "Methods, and how each learned one stands against the baseline that is best at the median, third quartile, 95 % quantile and maximum of its error",
            &[words("method"), words("what it does"), words("learned"), words("against the best one there")],
            lines,
        ))
        (choice::part(evaluation, methods))
    }
}

/// A method's name with the colour it has in the figures.
pub(super) fn name(method: &Method<'_>) -> Markup {
    super::named(&method.named())
}

fn standing(method: &MethodEvaluation, evaluation: &Evaluation) -> String {
    if method.baseline {
        return String::new();
    }
    let marks: Vec<&str> = comparisons(method, evaluation)
        .iter()
        .map(|c| match c.outcome {
            Outcome::Ahead => "better",
            Outcome::Level => "level",
            Outcome::Behind => "worse",
        })
        .collect();
    if marks.is_empty() {
        NONE.to_owned()
    } else {
        marks.join(" · ")
    }
}
