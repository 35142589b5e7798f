//! Comparison of methods on left-out training takes, and the method chosen.

use inhand_model::{Evaluation, MethodCandidate};
use maud::{Markup, html};

use super::Method;
use super::session::name;
use super::table::{Line, numbers, table, words};
use crate::learned::choice_sentence;
use crate::number::{NARROW_SPACE, count, decimals, to_mm};
use crate::words::tied;

/// The comparison, where one was asked for.
pub(super) fn part(evaluation: &Evaluation, methods: &[Method<'_>]) -> Markup {
    let (Some(choice), Some(sentence)) = (&evaluation.choice, choice_sentence(evaluation)) else {
        return html! {};
    };
    let mut candidates: Vec<&MethodCandidate> = choice.candidates.iter().collect();
    candidates.sort_by(|a, b| a.mean_error_m.total_cmp(&b.mean_error_m));
    let lines = candidates
        .iter()
        .map(|candidate| {
            let known = methods.iter().find(|m| m.evaluation.name == candidate.name);
            let error = if candidate.mean_error_m.is_finite() {
                decimals(to_mm(candidate.mean_error_m), 3)
            } else {
                "a plan failed".to_owned()
            };
            Line {
                head: known.map_or_else(|| html! { (candidate.name) }, name),
                cells: vec![error, count(choice.segments, NARROW_SPACE)],
                best: Vec::new(),
                stressed: candidate.name == choice.method,
            }
        })
        .collect();
    html! {
        h3 { "Which method was chosen" }
        p { (tied(&sentence)) }
        @if !choice.candidates.is_empty() {
            (table(
                "Methods on training takes that were left out of learning, best first",
                &[words("method"), numbers("mean error", "mm"), numbers("n", "segments")],
                lines,
            ))
        }
        p.note {
            "Over all segments, fingers and instants. " (groups_words(choice.folds)) " left out in turn, and everything is learned from the \
             rest; no test take has a say. A learned method is chosen where it is better than the best that learns nothing by more than \
             the standard error of the difference over segments."
        }
    }
}

fn groups_words(folds: usize) -> String {
    match folds {
        1 => "1 group of training takes is".to_owned(),
        n => format!("{n} groups of training takes are"),
    }
}
