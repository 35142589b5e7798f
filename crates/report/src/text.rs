//! The summary that a run prints on a terminal.

use std::fmt::Write as _;

use inhand_model::{Evaluation, MethodEvaluation};

use crate::learned::{choice_sentence, corridor_words};
use crate::number::{NARROW_SPACE, NONE, decimals, percent, plain, to_mm};
use crate::verdict::{Measure, default_method, standing_sentence};
use crate::words::shortened;

const TITLE: &str = "error over all fingers and instants (mm)";
/// Width of a column of numbers: "1000.00" and a space.
const NUMBER_WIDTH: usize = 8;
/// Longest description that is written out, so that a line fits a terminal of 100 columns.
const DESCRIPTION_WIDTH: usize = 36;
/// Width of the column of contact shares: its heading and two spaces.
const CONTACT_WIDTH: usize = 13;

/// Writes the table, a line each on contacts, corridors and the choice, and how the learned methods
/// stand.
pub(crate) fn write(evaluation: &Evaluation) -> String {
    let mut text = String::new();
    for line in table(&evaluation.methods) {
        text.push_str(line.trim_end());
        text.push('\n');
    }
    let standings = evaluation
        .methods
        .iter()
        .filter(|method| !method.baseline)
        .map(|method| standing_sentence(method, evaluation));
    for sentence in contact_line(evaluation)
        .into_iter()
        .chain(corridor_words(evaluation))
        .chain(choice_sentence(evaluation))
        .chain(standings)
    {
        // Narrow spaces are not in every terminal font.
        text.push_str(&sentence.replace(NARROW_SPACE, " "));
        text.push('\n');
    }
    text
}

/// Columns wide enough for their widest cell; the share of three contacts only where judged.
fn table(methods: &[MethodEvaluation]) -> Vec<String> {
    let width = |cell: fn(&MethodEvaluation) -> &str| {
        methods
            .iter()
            .map(|method| cell(method).chars().count())
            .max()
            .unwrap_or(0)
    };
    let names = width(|method| &method.name);
    let label = (2 + names + 2 + width(|method| &method.description).min(DESCRIPTION_WIDTH))
        .max(TITLE.len());
    let descriptions = label - 2 - names - 2;
    let with_contacts = methods.iter().any(|method| share(method).is_some());

    let mut head = format!("{TITLE:<label$}");
    for name in ["p50", "p75", "p95", "max"] {
        let _ = write!(head, "{name:>NUMBER_WIDTH$}");
    }
    if with_contacts {
        let _ = write!(head, "{:>CONTACT_WIDTH$}", "3+ contacts");
    }
    let mut lines = vec![head];
    for method in methods {
        let mut line = format!(
            "  {:<names$}  {:<descriptions$}",
            method.name,
            shortened(&method.description, descriptions)
        );
        for measure in Measure::ALL {
            let value = measure.of(&method.error.all).map_or(f64::NAN, to_mm);
            let _ = write!(line, "{:>NUMBER_WIDTH$}", decimals(value, 2));
        }
        if with_contacts {
            let cell = share(method).map_or_else(|| NONE.to_owned(), |share| percent(share) + " %");
            let _ = write!(line, "{cell:>CONTACT_WIDTH$}");
        }
        lines.push(line);
    }
    lines
}

fn share(method: &MethodEvaluation) -> Option<f64> {
    method
        .contact
        .as_ref()
        .filter(|contact| contact.n > 0)
        .map(|contact| contact.three_or_more)
}

fn contact_line(evaluation: &Evaluation) -> Option<String> {
    let method = default_method(evaluation)?;
    let contact = method.contact.as_ref()?;
    if contact.n == 0 {
        return Some(format!(
            "three or more fingers in contact: not judged, no instant with a tracked object and a trajectory of {}",
            method.name
        ));
    }
    Some(format!(
        "three or more fingers in contact: recorded {} %, {} {} %  (tau {} mm)",
        percent(contact.recorded_three_or_more),
        method.name,
        percent(contact.three_or_more),
        plain(to_mm(contact.tau_m)),
    ))
}
