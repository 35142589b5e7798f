//! Two evaluations side by side: for a terminal and for a pull request.

use std::fmt::Write as _;

use inhand_model::{ContactChange, Drawn, ErrorChange, Estimate, EvaluationComparison, Finger};

use crate::html::intervals::{measure_words, millimetres_3};
use crate::table::{Table, escaped};
use crate::words::{percent, plain, signed};

/// A line of the comparison: method, fingers, statistic, change.
type Change = (String, &'static str, &'static str, String);

fn changes(comparison: &EvaluationComparison) -> Vec<Change> {
    let methods = |before: &str, after: &str| match before == after {
        true => after.to_owned(),
        false => format!("{before} -> {after}"),
    };
    let errors = comparison.errors.iter().map(|change| {
        let finger = change.finger.map_or("all fingers", Finger::name);
        let who = methods(&change.before_method, &change.after_method);
        (
            who,
            finger,
            measure_words(change.measure),
            error_change(change),
        )
    });
    let contacts = comparison.contacts.iter().map(|change| {
        let who = methods(&change.before_method, &change.after_method);
        (who, "all fingers", CONTACTS, contact_change(change))
    });
    errors.chain(contacts).collect()
}

const CONTACTS: &str = "three or more contacts";

/// Two evaluations side by side, for a terminal: a line for each statistic of the error, then contacts, then how
/// intervals were made and settings that differ.
pub fn text(comparison: &EvaluationComparison) -> String {
    let mut text = String::new();
    let mut last = String::new();
    for (who, finger, statistic, change) in changes(comparison) {
        let contacts = statistic == CONTACTS;
        let head = format!("{who}, {}\n", if contacts { statistic } else { finger });
        if head != last {
            text.push_str(&head);
            last = head;
        }
        let name = if contacts { "share" } else { statistic };
        let _ = writeln!(text, "  {name:<7} {change}");
    }
    let _ = writeln!(text, "{}", made_words(comparison));
    for difference in &comparison.settings {
        let values = difference.values.join(" -> ");
        let _ = writeln!(text, "setting {}: {values}", difference.key);
    }
    text
}

/// Two evaluations side by side, for a pull request; names from files are text in it.
pub fn markdown(comparison: &EvaluationComparison) -> String {
    let (before, after) = (&comparison.before, &comparison.after);
    let table = Table::new("", changes(comparison), "method", |change| change.0.clone())
        .words("finger", |change| change.1.to_owned())
        .words("statistic", |change| change.2.to_owned())
        .numbers("change", "", |change| change.3.clone());
    let mut text = format!(
        "## In-hand manipulation: {} ({}) compared with {} ({})\n\n{}\n{}\n",
        escaped(&after.session),
        escaped(&after.file),
        escaped(&before.session),
        escaped(&before.file),
        table.markdown(),
        made_words(comparison)
    );
    if !comparison.settings.is_empty() {
        text.push('\n');
    }
    for difference in &comparison.settings {
        let values = escaped(&difference.values.join(" -> "));
        let _ = writeln!(text, "* setting {}: {values}", escaped(&difference.key));
    }
    text
}

/// `1.39 -> 1.31 mm (-5.8 %, interval -8.1 % .. -3.2 %)`.
fn error_change(change: &ErrorChange) -> String {
    let [before, after] = [change.before_m, change.after_m].map(millimetres_3);
    let values = format!("{before} -> {after} mm");
    let relative = change.relative_change;
    if !relative.is_finite() {
        // Before was 0, so only the difference itself says anything.
        return match interval(change.absolute.as_ref(), millimetres_3) {
            Some(ends) => format!("{values} (interval {ends} mm)"),
            None => values,
        };
    }
    let share = |share: f64| signed(100.0 * share, " %");
    match interval(change.relative.as_ref(), share) {
        Some(ends) => format!("{values} ({}, interval {ends})", share(relative)),
        None => format!("{values} ({})", share(relative)),
    }
}

/// `99.1 -> 98.7 % (-0.4 points, interval -0.9 .. 0.1)`.
fn contact_change(change: &ContactChange) -> String {
    let points = |share: f64| signed(100.0 * share, "");
    let values = format!("{} -> {} %", percent(change.before), percent(change.after));
    let own = points(change.after - change.before);
    match interval(change.absolute.as_ref(), points) {
        Some(ends) => format!("{values} ({own} points, interval {ends})"),
        None => format!("{values} ({own} points)"),
    }
}

fn interval(found: Option<&Estimate>, text: impl Fn(f64) -> String) -> Option<String> {
    let [low, high] = found?.interval?;
    Some(format!("{} .. {}", text(low), text(high)))
}

fn made_words(comparison: &EvaluationComparison) -> String {
    let bootstrap = &comparison.bootstrap;
    let made = format!(
        "intervals: {} % of {} draws of segments (seed {}), ",
        plain(100.0 * bootstrap.confidence),
        bootstrap.draws,
        bootstrap.seed
    );
    match comparison.drawn {
        Drawn::Together => {
            made + "the same ones for both, which were evaluated on the same segments"
        }
        Drawn::Apart => {
            made + "drawn apart: the two were not evaluated on the same segments, so that differences among \
                    segments count as well"
        }
        Drawn::NotAtAll => {
            "no intervals: none were asked for, or one of the two has no rows.parquet beside it"
                .to_owned()
        }
    }
}
