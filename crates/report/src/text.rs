//! An evaluation as text: in Markdown for pull requests and issues, in columns for a terminal.

use std::fmt::Write;

use inhand_model::{Evaluation, Intervals, Measure, MethodEvaluation, Protocol, Statistics};

use crate::Report;
use crate::html::checks::checks;
use crate::html::intervals::{
    against, error_words, estimate, made_words, measure_words, relative_words,
};
use crate::table::{Table, escaped, known, statistic};
use crate::verdict::{
    choice_sentence, comparison_sentence, contact_sentence, default_method, headline,
    missing_samples, protocols, region_sentence, verdict, warnings, without_held_out,
};
use crate::words::{NARROW_SPACE, count, decimals, millimetres, part_of, percent, shortened};

/// A measure with a column, and its value where no interval is known.
type MeasureColumn = (Measure, fn(&Statistics) -> f64);

const SHOWN: [MeasureColumn; 3] = [
    (Measure::P50, |s| s.p50),
    (Measure::P75, |s| s.p75),
    (Measure::P95, |s| s.p95),
];
/// Methods and takes listed; what is more is counted. Keeps the text within a screen or two.
const METHODS: usize = 24;
const TAKES: usize = 16;

/// A summary in Markdown.
pub(crate) fn markdown(report: &Report<'_>) -> String {
    let evaluation = report.evaluation;
    let worries = checks(report).into_iter().filter(|check| check.worrying);
    let worries = worries.map(|check| format!("* {}: {}\n", check.label, escaped(&check.words)));
    let found = warnings(evaluation).map(|finding| {
        let (level, finding) = (finding.level.name(), escaped(&finding.to_string()));
        format!("* {level}: {finding}\n")
    });
    let found = found.chain(worries).reduce(|list, line| list + &line);
    let mut text = format!(
        "## In-hand manipulation: {}\n\n{}\n\n{}{}\n",
        escaped(&evaluation.session.name),
        escaped(&verdict(evaluation)),
        found.map_or_else(String::new, |list| list + "\n"),
        methods(evaluation)
    );
    let protocol = headline(evaluation);
    if let Some(intervals) = evaluation.intervals(protocol) {
        text.push_str(&differences(evaluation, protocol, intervals));
    }
    quality(&mut text, evaluation);
    text
}

/// The methods, the default one stressed; what is more than fits is counted.
fn method_table<'a>(
    methods: Vec<&'a MethodEvaluation>,
    evaluation: &'a Evaluation,
    columns: impl FnOnce(Table<&'a MethodEvaluation>) -> Table<&'a MethodEvaluation>,
) -> String {
    let more = more(methods.len(), METHODS, "methods");
    let head = |method: &&MethodEvaluation| match method.baseline {
        true => format!("{} (baseline)", method.name),
        false => method.name.clone(),
    };
    let table = Table::new("", methods.into_iter().take(METHODS), "method", head)
        .stressed(|method| method.name == evaluation.default_method);
    columns(table).markdown() + &more
}

fn methods(evaluation: &Evaluation) -> String {
    let methods = evaluation.methods.iter();
    method_table(methods.collect(), evaluation, |table| {
        let mut table = protocols(evaluation).fold(table, |table, protocol| {
            let first = protocol == headline(evaluation);
            let shown = SHOWN.into_iter();
            let shown = shown.filter(|(measure, _)| first || *measure != Measure::P75);
            let table = shown.fold(table, |table, (measure, of)| {
                let name = heading(evaluation, protocol, measure_words(measure));
                table.numbers(&name, "mm", |method| {
                    let own = named(evaluation, protocol, &method.name);
                    known(own.map(|own| error_cell(own, evaluation, protocol, (measure, of))))
                })
            });
            match first {
                false => table,
                true => table.lengths(&heading(evaluation, protocol, "max"), |method| {
                    let own = named(evaluation, protocol, &method.name);
                    own.map_or(f64::NAN, |own| statistic(&own.error.all, |s| s.max))
                }),
            }
        });
        if evaluation.methods.iter().any(|m| m.contact.is_some()) {
            let name = "three contacts, recorded → planned";
            table = table.numbers(name, "%", |method| contact_cell(method));
        }
        let first = headline(evaluation);
        table.numbers(&heading(evaluation, first, "n (left out)"), "", |method| {
            let own = named(evaluation, first, &method.name).unwrap_or(method);
            let error = &own.error.all;
            format!("{} ({})", count(error.n), count(error.n_left_out))
        })
    })
}

/// The heading of a column, with its protocol where there are two.
fn heading(evaluation: &Evaluation, protocol: Protocol, name: &str) -> String {
    match protocols(evaluation).count() {
        1 => name.to_owned(),
        _ => format!("{}: {name}", protocol.title()),
    }
}

/// What was found of a method under a protocol.
fn named<'a>(
    evaluation: &'a Evaluation,
    protocol: Protocol,
    name: &str,
) -> Option<&'a MethodEvaluation> {
    let mut methods = evaluation.methods(protocol).iter();
    methods.find(|method| method.name == name)
}

/// Adds the median and the 95 % quantile of the error of all fingers under each protocol.
pub(crate) fn protocol_columns<R>(
    table: Table<R>,
    evaluation: &Evaluation,
    unit: &str,
    name: impl Fn(&R) -> &str,
) -> Table<R> {
    protocols(evaluation).fold(table, |table, protocol| {
        [SHOWN[0], SHOWN[2]]
            .into_iter()
            .fold(table, |table, (measure, of)| {
                let heading = format!("{}: {}", protocol.title(), measure_words(measure));
                table.numbers(&heading, unit, |row| {
                    let method = named(evaluation, protocol, name(row));
                    known(method.map(|own| millimetres(statistic(&own.error.all, of))))
                })
            })
    })
}

fn error_cell(
    method: &MethodEvaluation,
    evaluation: &Evaluation,
    protocol: Protocol,
    (measure, of): MeasureColumn,
) -> String {
    let intervals = evaluation.intervals(protocol);
    let own = intervals.and_then(|all| all.methods.iter().find(|own| own.method == method.name));
    match own.and_then(|own| own.error.all.as_ref()) {
        Some(estimates) => error_words(estimate(estimates, measure)),
        None => millimetres(statistic(&method.error.all, of)),
    }
}

fn contact_cell(method: &MethodEvaluation) -> String {
    let contact = method.contact.as_ref().filter(|contact| contact.n > 0);
    known(contact.map(|contact| {
        let recorded = percent(contact.recorded_three_or_more);
        format!("{recorded} → {}", percent(contact.three_or_more))
    }))
}

fn differences(evaluation: &Evaluation, protocol: Protocol, intervals: &Intervals) -> String {
    let Some(baseline) = intervals.best_baseline.as_deref() else {
        return String::new();
    };
    let found = |method: &MethodEvaluation, measure: Measure| {
        against(intervals, baseline, measure).find(|own| own.method == method.name)
    };
    let compared: Vec<&MethodEvaluation> = (evaluation.methods(protocol).iter())
        .filter(|method| SHOWN.iter().any(|&(m, _)| found(method, m).is_some()))
        .collect();
    if compared.is_empty() {
        return String::new();
    }
    let table = method_table(compared, evaluation, |table| {
        SHOWN.into_iter().fold(table, |table, (measure, _)| {
            table.numbers(measure_words(measure), "", |method| {
                let relative = found(method, measure).and_then(|own| own.relative.as_ref());
                known(relative.map(relative_words))
            })
        })
    });
    format!(
        "Error relative to {}, the best baseline, on the same segments{}; below zero is better:\n\n{table}\n{}\n\n",
        escaped(baseline),
        match protocol {
            Protocol::HeldOut => ", held out",
            Protocol::Published => "",
        },
        made_words(&intervals.bootstrap)
    )
}

/// A line a take, only those with warnings where there are many.
fn quality(text: &mut String, evaluation: &Evaluation) {
    let takes = &evaluation.quality;
    let odd: Vec<_> = takes.iter().filter(|take| take.warnings() > 0).collect();
    let (missing, samples) = missing_samples(evaluation);
    if samples == 0 {
        return;
    }
    let _ = writeln!(
        text,
        "Data: {} fingertip samples missing as recorded ({} %); {} of {} takes with warnings.",
        part_of(missing, samples),
        percent(missing as f64 / samples as f64),
        odd.len(),
        takes.len(),
    );
    if odd.is_empty() {
        return;
    }
    text.push('\n');
    for take in odd.iter().take(TAKES) {
        let object = take.object_tracked.map_or_else(String::new, |share| {
            format!(", object tracked {} %", percent(share))
        });
        let gaps_s = take.fingers.as_array().iter().map(|t| t.longest_gap_s);
        let _ = writeln!(
            text,
            "* {} ({}): {} warnings, longest gap {} s{object}",
            escaped(&take.take),
            escaped(&take.role),
            take.warnings(),
            decimals(gaps_s.fold(0.0, f64::max), 2),
        );
    }
    text.push_str(&more(odd.len(), TAKES, "takes"));
}

/// Number of those that are not listed.
fn more(all: usize, shown: usize, what: &str) -> String {
    match all.saturating_sub(shown) {
        0 => String::new(),
        more => format!("\nand {more} more {what}.\n"),
    }
}

/// Longest description that is written out, so that a line fits a terminal of 80 columns.
const DESCRIPTION_WIDTH: usize = 25;

/// The end of a run in plain text: per method the median and the 95 % quantile of the error under each protocol and the
/// share of time with three or more fingers in contact; then a line each for the protocols, where a baseline beats the
/// default method, contacts, the coverage of prediction regions, which method was chosen and why. Lines end with a newline;
/// no colour.
pub fn text_summary(evaluation: &Evaluation) -> String {
    let protocol = headline(evaluation);
    let compared = default_method(evaluation, protocol).map(|method| {
        let sentence = comparison_sentence(method, evaluation, protocol);
        heading(evaluation, protocol, &sentence)
    });
    let published = default_method(evaluation, Protocol::Published);
    let sentences = (legend(evaluation).into_iter())
        .chain(compared)
        .chain(published.and_then(contact_sentence))
        .chain(published.and_then(region_sentence))
        .chain(choice_sentence(evaluation));
    let text = sentences.fold(table(evaluation), |text, sentence| text + &sentence + "\n");
    // Narrow spaces are not in every terminal font.
    text.replace(NARROW_SPACE, " ")
}

/// The protocols in a line each.
fn legend(evaluation: &Evaluation) -> Vec<String> {
    if let Some(words) = without_held_out(evaluation) {
        return vec![words.to_owned()];
    }
    let held_out = evaluation.held_out.as_ref().map_or(0, |own| own.segments);
    let published = evaluation.session.test.iter().map(|take| take.segments);
    vec![
        format!(
            "held out: {held_out} segments of unfiltered motion; plans know nothing inside one"
        ),
        format!(
            "published: {} segments of filtered motion, which also gives both ends",
            published.sum::<usize>()
        ),
    ]
}

/// Errors; the share of three contacts only where contacts were evaluated.
fn table(evaluation: &Evaluation) -> String {
    let methods = &evaluation.methods;
    let lengths = methods.iter().map(|method| method.name.chars().count());
    let width = lengths.max().unwrap_or(0);
    let title = "error over all fingers and instants, mm";
    let table = Table::new("", methods, title, |method| {
        let description = shortened(&method.description, DESCRIPTION_WIDTH);
        format!("{:<width$}  {description}", method.name)
    });
    let table = protocol_columns(table, evaluation, "", |method| &method.name);
    if !methods.iter().any(|method| share(method).is_finite()) {
        return table.aligned();
    }
    let shares = |method: &&MethodEvaluation| {
        let sign = if share(method).is_finite() { " %" } else { "" };
        percent(share(method)) + sign
    };
    table.numbers("3+: contacts", "", shares).aligned()
}

/// The share of instants with three or more contacts; NaN where none was evaluated.
fn share(method: &MethodEvaluation) -> f64 {
    let contact = method.contact.as_ref().filter(|contact| contact.n > 0);
    contact.map_or(f64::NAN, |contact| contact.three_or_more)
}
