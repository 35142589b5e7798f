//! The summary that a run prints on a terminal.

use std::fmt::Write as _;

use inhand_model::{Evaluation, MethodEvaluation};

use crate::number::{decimals, percent, plain, to_mm};
use crate::verdict::{Measure, default_method, standing_sentence};

const TITLE: &str = "error over all fingers and instants (mm)";
/// Width of a column of numbers: "1000.00" and two spaces.
const NUMBER_WIDTH: usize = 9;

/// Writes the table, the contact line and how the learned methods stand.
pub(crate) fn write(evaluation: &Evaluation) -> String {
    let mut text = String::new();
    table(&mut text, &evaluation.methods);
    if let Some(line) = contact_line(evaluation) {
        let _ = writeln!(text, "{line}");
    }
    for method in evaluation.methods.iter().filter(|method| !method.baseline) {
        let _ = writeln!(
            text,
            "{}",
            terminal(&standing_sentence(method, &evaluation.methods))
        );
    }
    text
}

/// Narrow spaces are not in every terminal font.
fn terminal(sentence: &str) -> String {
    sentence.replace(crate::number::NARROW_SPACE, " ")
}

fn table(text: &mut String, methods: &[MethodEvaluation]) {
    let width = |cell: fn(&MethodEvaluation) -> &str| {
        methods
            .iter()
            .map(|method| cell(method).chars().count())
            .max()
            .unwrap_or(0)
    };
    let (names, descriptions) = (width(|m| &m.name), width(|m| &m.description));
    let label = (2 + names + 2 + descriptions).max(TITLE.len());
    let descriptions = label - 2 - names - 2;
    let _ = write!(text, "{TITLE:<label$}");
    for head in ["p50", "p75", "p95", "max"] {
        let _ = write!(text, "{head:>NUMBER_WIDTH$}");
    }
    text.push('\n');
    for method in methods {
        let _ = write!(
            text,
            "  {:<names$}  {:<descriptions$}",
            method.name, method.description
        );
        for measure in Measure::ALL {
            let value = measure.of(&method.error).map_or(f64::NAN, to_mm);
            let _ = write!(text, "{:>NUMBER_WIDTH$}", decimals(value, 2));
        }
        text.push('\n');
    }
}

/// One line: recorded first, then every method, so that no method is shown alone.
fn contact_line(evaluation: &Evaluation) -> Option<String> {
    let contact = default_method(evaluation)?.contact.as_ref()?;
    if contact.n == 0 {
        return Some("three or more fingers in contact: not judged, no tracked object".to_owned());
    }
    let mut line = format!(
        "three or more fingers in contact: recorded {} %",
        percent(contact.recorded_three_or_more)
    );
    for method in &evaluation.methods {
        if let Some(own) = method.contact.as_ref().filter(|own| own.n > 0) {
            let _ = write!(line, ", {} {} %", method.name, percent(own.three_or_more));
        }
    }
    let _ = write!(line, "  (tau {} mm)", plain(to_mm(contact.tau_m)));
    Some(line)
}
