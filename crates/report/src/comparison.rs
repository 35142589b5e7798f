//! Two evaluations side by side: for a terminal and for a pull request.

use std::fmt::Write as _;

use inhand_model::{ContactChange, Drawn, ErrorChange, Estimate, EvaluationComparison, Finger};

use crate::figure::forest::signed;
use crate::html::intervals::measure_words;
use crate::markdown::{escaped, row};
use crate::number::{decimals, percent, plain, to_mm};

/// A line for each statistic of the error, then contacts, then how intervals were made and settings that differ.
pub(crate) fn text(comparison: &EvaluationComparison) -> String {
    let mut text = String::new();
    let mut last = None;
    for change in &comparison.errors {
        let who = methods(&change.before_method, &change.after_method);
        let head = (who.clone(), change.finger);
        if last.as_ref() != Some(&head) {
            let _ = writeln!(text, "{who}, {}", finger_words(change.finger));
            last = Some(head);
        }
        let _ = writeln!(
            text,
            "  {:<7} {}",
            measure_words(change.measure),
            error_change(change)
        );
    }
    for change in &comparison.contacts {
        let who = methods(&change.before_method, &change.after_method);
        let _ = writeln!(
            text,
            "{who}, three or more contacts\n  share   {}",
            contact_change(change)
        );
    }
    let _ = writeln!(text, "{}", made_words(comparison));
    for difference in &comparison.settings {
        let _ = writeln!(
            text,
            "setting {}: {}",
            difference.key,
            difference.values.join(" -> ")
        );
    }
    text
}

/// The same as Markdown; names from files are text in it.
pub(crate) fn markdown(comparison: &EvaluationComparison) -> String {
    let (before, after) = (&comparison.before, &comparison.after);
    let mut text = format!(
        "## In-hand manipulation: {} ({}) against {} ({})\n\n",
        escaped(&after.session),
        escaped(&after.file),
        escaped(&before.session),
        escaped(&before.file)
    );
    row(
        &mut text,
        &["method", "finger", "statistic", "change"].map(str::to_owned),
    );
    row(&mut text, &["---", "---", "---", "---"].map(str::to_owned));
    for change in &comparison.errors {
        let cells = [
            escaped(&methods(&change.before_method, &change.after_method)),
            finger_words(change.finger).to_owned(),
            measure_words(change.measure).to_owned(),
            error_change(change),
        ];
        row(&mut text, &cells);
    }
    for change in &comparison.contacts {
        let cells = [
            escaped(&methods(&change.before_method, &change.after_method)),
            "all fingers".to_owned(),
            "three or more contacts".to_owned(),
            contact_change(change),
        ];
        row(&mut text, &cells);
    }
    let _ = writeln!(text, "\n{}", made_words(comparison));
    if !comparison.settings.is_empty() {
        text.push('\n');
    }
    for difference in &comparison.settings {
        let values = escaped(&difference.values.join(" -> "));
        let _ = writeln!(text, "* setting {}: {values}", escaped(&difference.key));
    }
    text
}

fn methods(before: &str, after: &str) -> String {
    match before == after {
        true => after.to_owned(),
        false => format!("{before} -> {after}"),
    }
}

fn finger_words(finger: Option<Finger>) -> &'static str {
    finger.map_or("all fingers", Finger::name)
}

/// `1.39 -> 1.31 mm (-5.8 %, 95 % interval -8.1 .. -3.2)`.
fn error_change(change: &ErrorChange) -> String {
    let mm = |metres: f64| decimals(to_mm(metres), 3);
    let values = format!("{} -> {} mm", mm(change.before_m), mm(change.after_m));
    let relative = change.relative_change;
    if !relative.is_finite() {
        // Before was 0, so only the difference itself says anything.
        return match interval(change.absolute.as_ref(), |metres| {
            decimals(to_mm(metres), 3)
        }) {
            Some(ends) => format!("{values} (interval {ends} mm)"),
            None => values,
        };
    }
    let own = signed(100.0 * relative);
    match interval(change.relative.as_ref(), |share| signed(100.0 * share)) {
        Some(ends) => format!("{values} ({own}, interval {ends})"),
        None => format!("{values} ({own})"),
    }
}

/// `99.1 -> 98.7 % (-0.4 points, interval -0.9 .. 0.1)`.
fn contact_change(change: &ContactChange) -> String {
    // Points, which are no percentage of anything.
    let points = |share: f64| signed(100.0 * share).trim_end_matches(" %").to_owned();
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
        Drawn::Together => made + "the same ones for both, which judged the same segments",
        Drawn::Apart => {
            made + "drawn apart: the two did not judge the same segments, so that differences among \
                    segments count as well"
        }
        Drawn::NotAtAll => {
            "no intervals: none were asked for, or no rows.parquet stands beside one of the two"
                .to_owned()
        }
    }
}
