//! Many sessions as a table and as text.

use std::fmt::Write as _;

use inhand_model::{
    Finger, HandAndFingers, Intervals, Measure, SessionSummary, SharedContacts, Statistics, Summary,
};

use crate::figure::FigureData;
use crate::html::intervals::{error_words, error_words_short, estimate, measure_words};
use crate::table::{Table, escaped, known};
use crate::words::{NARROW_SPACE, decimals, millimetres, percent};

/// Sessions that the text lists, the worst ones.
const LISTED: usize = 5;

/// The distributions of all fingers together and of each, with their names.
pub(crate) fn by_finger(
    error: &HandAndFingers<Statistics>,
) -> impl Iterator<Item = (&'static str, &Statistics)> {
    let fingers = Finger::ALL.map(|finger| (finger.name(), &error.by_finger[finger]));
    std::iter::once(("all", &error.all)).chain(fingers)
}

/// Shares of instants with three or more contacts, planned and recorded; NaN where none was evaluated.
pub(crate) fn three_contacts(contacts: Option<SharedContacts>) -> [f64; 2] {
    let known = contacts.filter(|contacts| contacts.n > 0);
    known.map_or([f64::NAN; 2], |own| {
        [own.three_or_more, own.recorded_three_or_more].map(|n| n as f64 / own.n as f64)
    })
}

/// The sessions as a table: a line for each session, method and finger (`all` for all of them together).
pub fn table(summary: &Summary) -> FigureData {
    let mut rows: Vec<(&SessionSummary, &str, &str, &Statistics)> = Vec::new();
    for session in &summary.sessions {
        for (method, own) in summary.methods.iter().zip(&session.methods) {
            let line = |(finger, error)| (session, method.name.as_str(), finger, error);
            rows.extend(by_finger(&own.error).map(line));
        }
    }
    FigureData::about(&rows)
        .words("session", |row| &*row.0.name)
        .words("file", |row| &*row.0.file)
        .words("participant", |row| {
            row.0.participant.as_deref().unwrap_or_default()
        })
        .words("object", |row| row.0.object.as_deref().unwrap_or_default())
        .words("task", |row| row.0.task.as_deref().unwrap_or_default())
        .words("method", |row| row.1)
        .words("finger", |row| row.2)
        .lengths(
            &["mean", "rmse", "p5", "p25", "p50", "p75", "p95", "max"],
            |row| row.3,
        )
        .done()
}

/// Protocols as headings with their intervals, and the measures that have columns.
fn columns(summary: &Summary) -> Vec<((&'static str, &Intervals), Measure)> {
    let both = (summary.held_out.as_ref()).map(|own| {
        [
            ("held out: ", &own.intervals),
            ("published: ", &summary.intervals),
        ]
    });
    match both {
        Some([held_out, published]) => vec![
            (held_out, Measure::P50),
            (held_out, Measure::P95),
            (published, Measure::P50),
        ],
        None => [Measure::P50, Measure::P75, Measure::P95]
            .map(|measure| (("", &summary.intervals), measure))
            .into(),
    }
}

/// Many sessions in a few lines, for a terminal; with `markdown` for a pull request: methods with intervals over
/// sessions, the worst sessions, outliers.
pub fn text(summary: &Summary, markdown: bool) -> String {
    let safe = |name: &str| {
        if markdown {
            escaped(name)
        } else {
            name.to_owned()
        }
    };
    let title = if markdown { "method" } else { "errors in mm" };
    let mut table = Table::new("", &summary.methods, title, |method| method.name.clone());
    if markdown {
        let own = summary.held_out.as_ref();
        let (name, leading) = own.map_or(("n", &summary.methods), |own| {
            ("n (held out)", &own.methods)
        });
        table = table.numbers(name, "", |method| {
            let own = leading.iter().find(|own| own.name == method.name);
            known(own.map(|own| own.error.all.n.to_string()))
        });
    }
    // A terminal has 80 columns.
    let words = if markdown {
        error_words
    } else {
        error_words_short
    };
    let unit = if markdown { "mm" } else { "" };
    let table =
        columns(summary)
            .into_iter()
            .fold(table, |table, ((protocol, intervals), measure)| {
                let name = format!("{protocol}{}", measure_words(measure));
                table.numbers(&name, unit, |method| {
                    let mut found = intervals.methods.iter();
                    let own = found.find(|own| own.method == method.name);
                    let estimates = own.and_then(|own| own.error.all.as_ref());
                    known(estimates.map(|all| words(estimate(all, measure))))
                })
            });
    let contacts = if markdown {
        "three contacts, recorded -> planned"
    } else {
        "3+: contacts"
    };
    let table = table.numbers(contacts, if markdown { "%" } else { "" }, |method| {
        let [planned, recorded] = three_contacts(method.contacts);
        let recorded = format!("{} -> ", percent(recorded));
        let recorded = if markdown { &recorded } else { "" };
        let sign = if markdown { "" } else { " %" };
        known((planned.is_finite()).then(|| format!("{recorded}{}{sign}", percent(planned))))
    });
    let mut text = match markdown {
        true => format!(
            "## In-hand manipulation: {} sessions\n\n{}",
            summary.sessions.len(),
            table.markdown()
        ),
        false => table.aligned(),
    };
    worst(&mut text, summary, safe);
    for outlier in &summary.outliers {
        let _ = writeln!(
            text,
            "{}outlier: {}, {} {} {} (median of the sessions {}, score {})",
            if markdown { "* " } else { "" },
            safe(&outlier.session.name),
            outlier.what,
            decimals(outlier.value, 2),
            outlier.unit,
            decimals(outlier.median, 2),
            decimals(outlier.score, 1),
        );
    }
    text.replace(NARROW_SPACE, " ")
}

/// The protocol of a summary's errors, where it is not the published one.
pub(crate) fn protocol_words(summary: &Summary) -> &'static str {
    match summary.held_out {
        Some(_) => ", held out",
        None => "",
    }
}

/// Sessions by the third quartile of a method's error, the largest first; those without errors last.
pub(crate) fn worst_first(summary: &Summary, place: usize) -> Vec<&SessionSummary> {
    let key = |session: &SessionSummary| {
        let error = &session.methods[place].headline().all;
        if error.n == 0 {
            f64::NEG_INFINITY
        } else {
            error.p75
        }
    };
    let mut sessions: Vec<&SessionSummary> = summary.sessions.iter().collect();
    // Stable: equal ones stay in the order given.
    sessions.sort_by(|a, b| key(b).total_cmp(&key(a)));
    sessions
}

/// The sessions with the largest third quartile of the default method.
fn worst(text: &mut String, summary: &Summary, safe: impl Fn(&str) -> String) {
    let mut methods = summary.methods.iter();
    let Some(place) = methods.position(|method| method.name == summary.default_method) else {
        return;
    };
    let listed: Vec<String> = (worst_first(summary, place).into_iter())
        .map(|session| (session, &session.methods[place].headline().all))
        .filter(|(_, error)| error.n > 0)
        .take(LISTED)
        .map(|(session, error)| format!("{} {} mm", safe(&session.name), millimetres(error.p75)))
        .collect();
    if !listed.is_empty() {
        let _ = writeln!(
            text,
            "\nworst sessions by the third quartile of {}{}: {}",
            safe(&summary.default_method),
            protocol_words(summary),
            listed.join(", ")
        );
    }
}
