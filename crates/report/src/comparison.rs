//! Two evaluations side by side: for a terminal and for a pull request.

use inhand_model::{
    ContactChange, Drawn, ErrorChange, Estimate, EvaluationComparison, Finger, Measure, Protocol,
    SettingDifference,
};

use crate::html::intervals::{measure_words, millimetres_3};
use crate::table::{Table, escaped};
use crate::words::{percent, plain, signed};

/// A line of the comparison.
struct Change {
    protocol: Protocol,
    method: String,
    finger: &'static str,
    statistic: &'static str,
    change: String,
    /// After less before, as a share; NaN where before is 0.
    size: f64,
    /// Sign of what is beyond noise: 0 where the interval contains zero or nothing changed; `None` without an interval.
    sign: Option<f64>,
}

/// Changes under each protocol, held out first.
fn changes(comparison: &EvaluationComparison) -> Vec<Change> {
    let held_out = comparison.held_out.iter();
    let held_out =
        held_out.flat_map(|own| of_protocol(Protocol::HeldOut, &own.errors, &own.contacts));
    let (errors, contacts) = (&comparison.errors, &comparison.contacts);
    held_out
        .chain(of_protocol(Protocol::Published, errors, contacts))
        .collect()
}

fn of_protocol(
    protocol: Protocol,
    errors: &[ErrorChange],
    contacts: &[ContactChange],
) -> Vec<Change> {
    let methods = |before: &str, after: &str| match before == after {
        true => after.to_owned(),
        false => format!("{before} -> {after}"),
    };
    let errors = errors.iter().map(|change| Change {
        protocol,
        method: methods(&change.before_method, &change.after_method),
        finger: change.finger.map_or(ALL_FINGERS, Finger::name),
        statistic: measure_words(change.measure),
        change: error_change(change),
        size: change.relative_change,
        sign: sign(change.after_m - change.before_m, change.absolute.as_ref()),
    });
    let contacts = contacts.iter().map(|change| Change {
        protocol,
        method: methods(&change.before_method, &change.after_method),
        finger: ALL_FINGERS,
        statistic: CONTACTS,
        change: contact_change(change),
        size: change.after - change.before,
        sign: sign(change.after - change.before, change.absolute.as_ref()),
    });
    errors.chain(contacts).collect()
}

fn sign(change: f64, estimate: Option<&Estimate>) -> Option<f64> {
    match estimate.and_then(|estimate| estimate.interval) {
        Some([low, high]) if low > 0.0 || high < 0.0 => Some(low.signum()),
        Some(_) => Some(0.0),
        None => (change == 0.0).then_some(0.0),
    }
}

const ALL_FINGERS: &str = "all fingers";
const CONTACTS: &str = "three or more contacts";

/// Changes that are listed unless all are asked for: with the verdict they fit on a screen.
const LISTED: usize = 10;

/// Two evaluations side by side, for a terminal: what differs in the reference and in settings, changes beyond noise or
/// `all` of them, the verdict, and how intervals were made.
pub fn text(comparison: &EvaluationComparison, all: bool) -> String {
    let changes = changes(comparison);
    let mut text = settings_words(comparison, false) + &one_sided(comparison);
    // A change without an interval may be beyond noise.
    let mut listed: Vec<&Change> = changes.iter().collect();
    if !all {
        listed.retain(|change| change.sign != Some(0.0));
        listed.sort_by(|a, b| {
            let by_size = b.size.abs().total_cmp(&a.size.abs());
            (b.protocol.cmp(&a.protocol)).then(by_size)
        });
        let noise = match changes.iter().all(|own| own.sign.is_some()) {
            true => "beyond noise (interval without zero)",
            false => "without an interval or beyond noise",
        };
        let (some, n) = (listed.len(), changes.len());
        let first = match comparison.held_out {
            Some(_) => "held out first, then largest first",
            None => "largest first",
        };
        text += &format!("{some} of {n} changes are {noise}, {first}:\n");
    }
    let shown = if all { listed.len() } else { LISTED };
    if !listed.is_empty() {
        let listed = listed.iter().take(shown).copied();
        text.push_str(&table(listed, comparison).aligned());
    }
    if listed.len() > shown {
        text += &format!("and {} more: --all\n", listed.len() - shown);
    }
    text + &verdict(&changes, comparison, false) + &made_words(comparison) + "\n"
}

fn table<'a>(
    changes: impl IntoIterator<Item = &'a Change>,
    comparison: &EvaluationComparison,
) -> Table<&'a Change> {
    let table = Table::new("", changes, "method", |change| change.method.clone());
    let table = match comparison.held_out {
        Some(_) => table.words("protocol", |change| change.protocol.title().to_owned()),
        None => table,
    };
    table
        .words("finger", |change| change.finger.to_owned())
        .words("statistic", |change| change.statistic.to_owned())
        .words("change", |change| change.change.clone())
}

/// Says that only one of the two has held-out errors; nothing where both or none have them.
fn one_sided(comparison: &EvaluationComparison) -> String {
    let (before, after) = (&comparison.before, &comparison.after);
    let older = match (before.held_out, after.held_out) {
        (true, false) => after,
        (false, true) => before,
        _ => return String::new(),
    };
    format!(
        "{} was made before the held-out protocol: only published errors are compared.\n",
        older.file
    )
}

/// Whether the errors over all fingers of the first method are higher or lower, as far as intervals tell, under each
/// protocol.
fn verdict(changes: &[Change], comparison: &EvaluationComparison, markdown: bool) -> String {
    let of = |protocol| {
        let mut first = changes.iter().filter(|own| own.protocol == protocol);
        let method = &first.next()?.method;
        let own = changes.iter().filter(|own| {
            own.protocol == protocol && own.method == *method && own.finger == ALL_FINGERS
        });
        Some(verdict_under(protocol, own.collect(), comparison, markdown))
    };
    let protocols = [Protocol::HeldOut, Protocol::Published].into_iter();
    protocols.filter_map(of).collect()
}

fn verdict_under(
    protocol: Protocol,
    mut own: Vec<&Change>,
    comparison: &EvaluationComparison,
    markdown: bool,
) -> String {
    let stated = [Measure::P50, Measure::P95, Measure::Mean].map(measure_words);
    own.retain(|own| stated.contains(&own.statistic));
    let Some(first) = own.first() else {
        return String::new();
    };
    let any = |of: fn(Option<f64>) -> bool| own.iter().any(|change| of(change.sign));
    let words = match (any(|sign| sign > Some(0.0)), any(|sign| sign < Some(0.0))) {
        _ if any(|sign| sign.is_none()) => "undetermined without intervals",
        (true, true) => "some errors are higher, some lower",
        (true, false) => "errors are higher",
        (false, true) => "errors are lower",
        (false, false) => "no change beyond noise",
    };
    let reference = match comparison.reference.is_empty() {
        true => "",
        false => ", against another reference",
    };
    let (safe, bullet) = style(markdown);
    let protocol = match comparison.held_out {
        Some(_) => format!(", {}", protocol.title()),
        None => String::new(),
    };
    let head = format!(
        "Verdict on {}, {ALL_FINGERS}{protocol}: {words}{reference}\n",
        safe(&first.method)
    );
    let line = |own: &&Change| format!("{bullet}{:<6} {}\n", own.statistic, own.change);
    head + &own.iter().map(line).collect::<String>()
}

/// Names from files as they are, or as text in Markdown, and the start of a line in a list.
fn style(markdown: bool) -> (fn(&str) -> String, &'static str) {
    match markdown {
        true => (escaped, "* "),
        false => (str::to_owned, "  "),
    }
}

const REFERENCE_CHANGED: &str =
    "The reference changed: errors before and after are distances to different motion.\n";

/// What differs in the reference, then other settings.
fn settings_words(comparison: &EvaluationComparison, markdown: bool) -> String {
    let (safe, bullet) = style(markdown);
    let line = |own: &SettingDifference| {
        let line = format!("{}: {}", own.key, own.values.join(" -> "));
        format!("{bullet}{}\n", safe(&line))
    };
    let reference = &comparison.reference;
    let mut others = comparison.settings.clone();
    others.retain(|own| !reference.contains(own));
    let mut text = String::new();
    for (head, settings) in [
        (REFERENCE_CHANGED, reference),
        ("Settings that differ:\n", &others),
    ] {
        if !settings.is_empty() {
            text += head;
            text.extend(settings.iter().map(line));
        }
    }
    text
}

/// Two evaluations side by side, for a pull request; names from files are text in it.
pub fn markdown(comparison: &EvaluationComparison) -> String {
    let (before, after) = (&comparison.before, &comparison.after);
    let changes = changes(comparison);
    format!(
        "## In-hand manipulation: {} ({}) compared with {} ({})\n\n{}{}\n{}\n{}\n{}\n",
        escaped(&after.session),
        escaped(&after.file),
        escaped(&before.session),
        escaped(&before.file),
        settings_words(comparison, true),
        escaped(one_sided(comparison).trim_end()),
        verdict(&changes, comparison, true),
        table(&changes, comparison).markdown(),
        made_words(comparison)
    )
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
