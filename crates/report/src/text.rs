//! The summary that a run prints on a terminal.

use inhand_model::{Evaluation, MethodEvaluation};

use crate::table::{Statistic, Table};
use crate::verdict::{choice_sentence, comparison_sentence, contact_sentence, region_sentence};
use crate::words::{NARROW_SPACE, millimetres, percent, shortened};

/// Longest description that is written out, so that a line fits a terminal of 100 columns.
const DESCRIPTION_WIDTH: usize = 36;

const SHOWN: [Statistic; 4] = [
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
    let table = Table::new("", methods, title, move |method| {
        let description = shortened(&method.description, DESCRIPTION_WIDTH);
        format!("  {:<width$}  {description}", method.name)
    })
    .statistics(&SHOWN, "", millimetres, |method| method.error.all);
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
