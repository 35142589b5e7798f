//! An evaluation as text: in Markdown for pull requests and issues, in columns for a terminal.

use std::fmt::Write;

use inhand_model::{Evaluation, Intervals, Measure, MethodEvaluation, Statistics};

use crate::html::intervals::{
    against, error_words, estimate, made_words, measure_words, relative_words,
};
use crate::table::{Statistic, Table, escaped, known, statistic};
use crate::verdict::{
    choice_sentence, comparison_sentence, contact_sentence, region_sentence, sentences, warnings,
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
pub(crate) fn markdown(evaluation: &Evaluation) -> String {
    let verdict = sentences(evaluation).join(" ");
    let found = warnings(evaluation).map(|finding| {
        let (level, finding) = (finding.level.name(), escaped(&finding.to_string()));
        format!("* {level}: {finding}\n")
    });
    let found = found.reduce(|list, line| list + &line);
    let mut text = format!(
        "## In-hand manipulation: {}\n\n{}\n\n{}{}\n",
        escaped(&evaluation.session.name),
        escaped(&verdict),
        found.map_or_else(String::new, |list| list + "\n"),
        methods(evaluation)
    );
    if let Some(intervals) = &evaluation.intervals {
        text.push_str(&differences(evaluation, intervals));
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
        let mut table = SHOWN.into_iter().fold(table, |table, (measure, of)| {
            table.numbers(measure_words(measure), "mm", |method| {
                error_cell(method, evaluation, measure, of)
            })
        });
        table = table.lengths("max", |method| statistic(&method.error.all, |s| s.max));
        if evaluation.methods.iter().any(|m| m.contact.is_some()) {
            let name = "three contacts, recorded → planned";
            table = table.numbers(name, "%", |method| contact_cell(method));
        }
        table.numbers("n (left out)", "", |method| {
            let error = &method.error.all;
            format!("{} ({})", count(error.n), count(error.n_left_out))
        })
    })
}

fn error_cell(
    method: &MethodEvaluation,
    evaluation: &Evaluation,
    measure: Measure,
    of: fn(&Statistics) -> f64,
) -> String {
    let intervals = evaluation.intervals.as_ref();
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

fn differences(evaluation: &Evaluation, intervals: &Intervals) -> String {
    let Some(baseline) = intervals.best_baseline.as_deref() else {
        return String::new();
    };
    let found = |method: &MethodEvaluation, measure: Measure| {
        against(intervals, baseline, measure).find(|own| own.method == method.name)
    };
    let compared: Vec<&MethodEvaluation> = (evaluation.methods.iter())
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
        "Error relative to {}, the best baseline, on the same segments; below zero is better:\n\n{table}\n{}\n\n",
        escaped(baseline),
        made_words(&intervals.bootstrap)
    )
}

/// A line a take, only those with warnings where there are many.
fn quality(text: &mut String, evaluation: &Evaluation) {
    let takes = &evaluation.quality;
    let odd: Vec<_> = takes.iter().filter(|take| take.warnings() > 0).collect();
    let tracks = takes.iter().flat_map(|take| take.fingers.as_array());
    let (missing, samples) = tracks.fold((0, 0), |(missing, samples), track| {
        let own = &track.recorded;
        let all = own.measured + own.filled + own.missing;
        (missing + own.missing, samples + all)
    });
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

/// Longest description that is written out, so that a line fits a terminal of 100 columns.
const DESCRIPTION_WIDTH: usize = 36;

const TERMINAL: [Statistic; 4] = [
    ("p50", |s| s.p50),
    ("p75", |s| s.p75),
    ("p95", |s| s.p95),
    ("max", |s| s.max),
];

/// The end of a run in plain text: per method the median, third quartile, 95 % quantile and
/// largest error in millimetres, the share of time with three or more fingers in contact, the coverage of
/// prediction regions, which method was chosen and why, and for each learned method where a baseline
/// beats it. Lines end with a newline; no colour.
pub fn text_summary(evaluation: &Evaluation) -> String {
    let learned = evaluation.methods.iter().filter(|method| !method.baseline);
    let sentences = (contact_sentence(evaluation).into_iter())
        .chain(region_sentence(evaluation))
        .chain(choice_sentence(evaluation))
        .chain(learned.map(|method| comparison_sentence(method, evaluation)));
    let text = sentences.fold(table(&evaluation.methods), |text, sentence| {
        text + &sentence + "\n"
    });
    // Narrow spaces are not in every terminal font.
    text.replace(NARROW_SPACE, " ")
}

/// Errors; the share of three contacts only where contacts were evaluated.
fn table(methods: &[MethodEvaluation]) -> String {
    let lengths = methods.iter().map(|method| method.name.chars().count());
    let width = lengths.max().unwrap_or(0);
    let title = "error over all fingers and instants (mm)";
    let table = Table::new("", methods, title, |method| {
        let description = shortened(&method.description, DESCRIPTION_WIDTH);
        format!("  {:<width$}  {description}", method.name)
    })
    .statistics(&TERMINAL, "", millimetres, |method| method.error.all);
    if !methods.iter().any(|method| share(method).is_finite()) {
        return table.aligned();
    }
    let shares = |method: &&MethodEvaluation| {
        let sign = if share(method).is_finite() { " %" } else { "" };
        percent(share(method)) + sign
    };
    table.numbers("3+ contacts", "", shares).aligned()
}

/// The share of instants with three or more contacts; NaN where none was evaluated.
fn share(method: &MethodEvaluation) -> f64 {
    let contact = method.contact.as_ref().filter(|contact| contact.n > 0);
    contact.map_or(f64::NAN, |contact| contact.three_or_more)
}
