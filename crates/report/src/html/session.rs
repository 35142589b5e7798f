//! The list of methods, and the steps that led here.

use inhand_model::{Evaluation, Level, MethodEvaluation, Provenance, SessionFinding};
use maud::{Markup, html};

use super::{Body, Method, method_table, named};
use crate::json::settings_value;
use crate::table::Table;
use crate::verdict::{Outcome, choice_sentence, comparisons, headline};
use crate::words::{NONE, counted, decimals, tied, to_mm};

/// Findings of an inspection with their levels.
pub(super) fn finding_list<'a>(findings: impl Iterator<Item = &'a SessionFinding>) -> Markup {
    html! {
        ul.findings {
            @for finding in findings {
                li {
                    span.badge.warning[finding.level > Level::Info] { (finding.level.name()) }
                    " " (finding)
                }
            }
        }
    }
}

/// Methods: description, comparison with the baselines, choice.
pub(super) fn methods(evaluation: &Evaluation, methods: &[Method<'_>]) -> Body {
    let caption = format!(
        "Methods, and how the error of each learned one ({}) compares with that of the best baseline at the median, third \
         quartile, 95 % quantile and maximum",
        headline(evaluation).title()
    );
    let table = method_table(caption, methods, |method| method)
        .words("what it does", |m| m.evaluation.description.clone())
        .words("learned", |m| match m.evaluation.baseline {
            true => "no, a baseline".to_owned(),
            false => "yes".to_owned(),
        })
        .words("error", |m| outcomes(m.evaluation, evaluation));
    Body::from(html! {
        p {
            "Every method plans the same test segments. A baseline has learned nothing from the training takes; \
             a learned method is useful only if it beats every baseline."
        }
    })
    .prose(table)
    .append(choice(evaluation, methods))
}

fn outcomes(method: &MethodEvaluation, evaluation: &Evaluation) -> String {
    let protocol = headline(evaluation);
    let mut methods = evaluation.methods(protocol).iter();
    let Some(method) = methods.find(|own| own.name == method.name && !own.baseline) else {
        return String::new();
    };
    let marks: Vec<&str> = (comparisons(method, evaluation, protocol).iter())
        .map(|comparison| match comparison.outcome {
            Outcome::Lower => "lower",
            Outcome::Tie => "tie",
            Outcome::Higher => "higher",
        })
        .collect();
    match marks.is_empty() {
        true => NONE.to_owned(),
        false => marks.join(" · "),
    }
}

/// The comparison on left-out training takes, where one was asked for.
fn choice(evaluation: &Evaluation, methods: &[Method<'_>]) -> Option<Body> {
    let (choice, sentence) = (evaluation.choice.as_ref()?, choice_sentence(evaluation)?);
    let mut candidates = choice.candidates.clone();
    candidates.sort_by(|a, b| a.mean_error_m.total_cmp(&b.mean_error_m));
    let caption = "Methods on training takes that were left out of learning, lowest error first";
    let table = Table::new(caption, candidates, "method", |candidate| {
        let known = named(methods, &candidate.name);
        known.map_or_else(|| (&*candidate.name).into(), Method::head)
    })
    .stressed(|candidate| candidate.name == choice.method)
    .numbers("mean error", "mm", |c| match c.mean_error_m.is_finite() {
        true => decimals(to_mm(c.mean_error_m), 3),
        false => "a plan failed".to_owned(),
    })
    .counts("n", "segments", |_| choice.segments);
    let are = if choice.folds == 1 { "is" } else { "are" };
    let groups = counted(choice.folds, "group");
    Some(Body::from(html! {
        h3 { "Which method was chosen" }
        p { (tied(&sentence)) }
        @if !table.is_empty() { (table) }
        p.note {
            "Over all segments, fingers and instants. " (groups) " of training takes " (are) " left out in turn, and everything is learned from the \
             rest; test takes are not used. A learned method is chosen where it is better than the best baseline by more than \
             the standard error of the difference over segments."
        }
    }))
}

/// The section's content.
pub(super) fn provenance(provenance: &[Provenance]) -> Markup {
    html! {
        @if provenance.is_empty() {
            p { "No provenance was recorded." }
        } @else {
            p { "Each step with its settings and the SHA-256 of what went in. The same inputs and settings give the same bytes." }
        }
        @for step in provenance {
            details {
                summary {
                    b { (step.step) }
                    " " (step.tool) ", " (counted(step.inputs.len(), "input"))
                }
                h4 { "Settings" }
                pre { (pretty(&step.settings_json)) }
                @if !step.inputs.is_empty() {
                    h4 { "Inputs" }
                    dl.hashes {
                        @for input in &step.inputs {
                            dt { (input.name) }
                            dd { code { (input.sha256) } }
                        }
                    }
                }
            }
        }
    }
}

/// JSON on several lines; other text as it is.
fn pretty(settings_json: &str) -> String {
    match settings_value(settings_json) {
        serde_json::Value::String(text) => text,
        // Writing a value that has just been read cannot fail; the text itself is a safe answer.
        value => serde_json::to_string_pretty(&value).unwrap_or_else(|_| settings_json.to_owned()),
    }
}
