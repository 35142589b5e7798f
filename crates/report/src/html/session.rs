//! The top of the page, the list of methods, and the steps that led here.

use inhand_model::{Evaluation, Level, MethodEvaluation, Provenance, SessionFinding, TakeFacts};
use maud::{Markup, html};

use super::{Body, Method, method_table, named};
use crate::json::settings_value;
use crate::table::Table;
use crate::text::protocol_columns;
use crate::verdict::{
    Outcome, choice_sentence, comparisons, default_method, definition, headline, protocols,
    sentences, warnings,
};
use crate::words::{NONE, counted, decimals, plain, tied, to_mm};

/// Facts at the top of the page.
pub(super) fn facts(evaluation: &Evaluation) -> Vec<(&'static str, String)> {
    let session = &evaluation.session;
    let dictionary = &evaluation.dictionary;
    let seconds = session.segment_samples as f64 / session.rate_hz;
    let kind = dictionary.kind.name().to_uppercase();
    let segment = format!("{} samples, {} s", session.segment_samples, plain(seconds));
    let mut facts = vec![
        (
            "Object",
            session
                .object
                .clone()
                .unwrap_or_else(|| "none given".to_owned()),
        ),
        ("Training", takes(&session.train)),
        ("Test", takes(&session.test)),
        ("Sample rate", format!("{} Hz", plain(session.rate_hz))),
        ("Segment", segment),
        (
            "Dictionary",
            format!("{kind}, {} primitives", dictionary.rank),
        ),
    ];
    let deviation = dictionary.deviation.as_ref();
    facts.extend(deviation.map(|own| ("Deviation", format!("{} primitives", own.primitives))));
    facts
}

fn takes(takes: &[TakeFacts]) -> String {
    let seconds: f64 = takes.iter().map(|take| take.duration_s).sum();
    let segments: usize = takes.iter().map(|take| take.segments).sum();
    let (takes, segments) = (counted(takes.len(), "take"), counted(segments, "segment"));
    format!("{takes}, {} s, {segments}", decimals(seconds, 0))
}

/// The verdict, coloured by whether the default method is behind.
pub(super) fn verdict(evaluation: &Evaluation, methods: &[Method<'_>]) -> Markup {
    let protocol = headline(evaluation);
    let method = default_method(evaluation, protocol);
    let outcomes: Vec<Outcome> = (method.into_iter())
        .flat_map(|method| comparisons(method, evaluation, protocol))
        .map(|comparison| comparison.outcome)
        .collect();
    let plan = method.and_then(|method| method.plan.as_ref());
    let unsolved = plan.is_some_and(|plan| plan.infeasible + plan.failed > 0);
    let class = if unsolved || outcomes.contains(&Outcome::Higher) {
        "verdict behind"
    } else if outcomes.is_empty() {
        "verdict"
    } else {
        "verdict kept-up"
    };
    let protocols: Vec<_> = protocols(evaluation).collect();
    let caption = "Error of all fingers under both protocols";
    let sentences = sentences(evaluation);
    // Errors and how they compare lead.
    let (lead, rest) = sentences.split_at(sentences.len().min(2));
    html! {
        div class=(class) {
            @for sentence in lead { p.lead { (tied(sentence)) } }
            (inspection(evaluation))
            @if protocols.len() > 1 {
                (protocol_columns(method_table(caption, methods, |m| m), evaluation, "mm", |m| m.name))
            }
            @for sentence in rest { p { (tied(sentence)) } }
            @if protocols.len() > 1 {
                @for protocol in protocols { p.note { (tied(&definition(protocol, evaluation))) } }
            }
            p.note {
                "Differences under 2 %, or whose 95 % interval contains zero, are ties; a maximum has no interval. \
                 Neighbouring instants are not independent of one another, so small differences between methods may not hold on \
                 another session."
            }
        }
    }
}

/// Findings that may affect numbers.
fn inspection(evaluation: &Evaluation) -> Markup {
    let findings: Vec<_> = warnings(evaluation).collect();
    html! {
        @if !findings.is_empty() { (finding_list(findings.into_iter())) }
    }
}

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
            p { "Every step that led here, with all settings that had an effect and the SHA-256 of what went in. The same inputs and settings give the same bytes." }
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
