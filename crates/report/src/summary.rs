//! Many sessions as a table and as text.

use std::fmt::Write as _;

use inhand_model::{Finger, SessionSummary, Statistics, Summary};

use crate::figure::{FigureColumn, FigureData};
use crate::html::intervals::error_words;
use crate::markdown::{escaped, row};
use crate::number::{NARROW_SPACE, NONE, decimals, millimetres, percent, to_mm};

/// Sessions that the text lists, the worst ones.
const LISTED: usize = 5;

/// A line for each session, method and finger.
pub(crate) fn table(summary: &Summary) -> FigureData {
    let mut rows: Vec<(&SessionSummary, &str, &str, &Statistics)> = Vec::new();
    for session in &summary.sessions {
        for (method, own) in summary.methods.iter().zip(&session.methods) {
            rows.push((session, &method.name, "all", &own.error.all));
            let fingers = Finger::ALL.map(|f| {
                (
                    session,
                    method.name.as_str(),
                    f.name(),
                    &own.error.by_finger[f],
                )
            });
            rows.extend(fingers);
        }
    }
    let words = |name, of: fn(&SessionSummary) -> Option<&str>| {
        FigureColumn::words(
            name,
            rows.iter().map(move |row| of(row.0).unwrap_or_default()),
        )
    };
    let length = |name, of: fn(&Statistics) -> f64| {
        FigureColumn::numbers(
            name,
            (rows.iter()).map(move |row| {
                if row.3.n == 0 {
                    f64::NAN
                } else {
                    to_mm(of(row.3))
                }
            }),
        )
    };
    let counts = |name, of: fn(&Statistics) -> usize| {
        FigureColumn::counts(name, rows.iter().map(move |row| of(row.3)))
    };
    FigureData::new([
        words("session", |session| Some(&session.name)),
        words("file", |session| Some(&session.file)),
        words("participant", |session| session.participant.as_deref()),
        words("object", |session| session.object.as_deref()),
        words("task", |session| session.task.as_deref()),
        FigureColumn::words("method", rows.iter().map(|row| row.1)),
        FigureColumn::words("finger", rows.iter().map(|row| row.2)),
        counts("n", |s| s.n),
        counts("n_filled", |s| s.n_filled),
        counts("n_left_out", |s| s.n_left_out),
        length("mean_mm", |s| s.mean),
        length("rmse_mm", |s| s.rmse),
        length("p5_mm", |s| s.p5),
        length("p25_mm", |s| s.p25),
        length("p50_mm", |s| s.p50),
        length("p75_mm", |s| s.p75),
        length("p95_mm", |s| s.p95),
        length("max_mm", |s| s.max),
    ])
}

/// Methods with intervals over sessions, the worst sessions, outliers.
pub(crate) fn text(summary: &Summary, markdown: bool) -> String {
    let safe = |name: &str| {
        if markdown {
            escaped(name)
        } else {
            name.to_owned()
        }
    };
    let mut text = String::new();
    if markdown {
        let _ = writeln!(
            text,
            "## In-hand manipulation: {} sessions\n",
            summary.sessions.len()
        );
    }
    let mut lines = vec![
        [
            "method",
            "n",
            "median (mm)",
            "75 % (mm)",
            "95 % (mm)",
            "three contacts, recorded -> planned (%)",
        ]
        .map(str::to_owned)
        .to_vec(),
    ];
    for method in &summary.methods {
        let found = summary
            .intervals
            .methods
            .iter()
            .find(|own| own.method == method.name);
        let mut cells = vec![safe(&method.name), method.error.all.n.to_string()];
        match found.and_then(|own| own.error.all.as_ref()) {
            Some([_, _, p50, p75, p95]) => cells.extend([p50, p75, p95].map(error_words)),
            None => cells.extend(std::iter::repeat_n(NONE.to_owned(), 3)),
        }
        cells.push(match method.contacts.filter(|contacts| contacts.n > 0) {
            Some(c) => {
                let share = |part: usize| percent(part as f64 / c.n as f64);
                format!(
                    "{} -> {}",
                    share(c.recorded_three_or_more),
                    share(c.three_or_more)
                )
            }
            None => NONE.to_owned(),
        });
        lines.push(cells);
    }
    if markdown {
        lines.insert(
            1,
            ["---", "---:", "---:", "---:", "---:", "---:"]
                .map(str::to_owned)
                .to_vec(),
        );
        lines.iter().for_each(|cells| row(&mut text, cells));
    } else {
        text.push_str(&aligned(&lines));
    }
    worst(&mut text, summary, safe);
    for outlier in &summary.outliers {
        let _ = writeln!(
            text,
            "{}unlike the others: {}, {} {} {} (median of the sessions {}, score {})",
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

/// Sessions by the third quartile of a method's error, the largest first; those without errors last.
pub(crate) fn worst_first(summary: &Summary, place: usize) -> Vec<&SessionSummary> {
    let key = |session: &SessionSummary| {
        let error = &session.methods[place].error.all;
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

/// The sessions with the largest third quartile of the method to look at first.
fn worst(text: &mut String, summary: &Summary, safe: impl Fn(&str) -> String) {
    let default = |method: &inhand_model::MethodSummary| method.name == summary.default_method;
    let Some(place) = summary.methods.iter().position(default) else {
        return;
    };
    let judged = worst_first(summary, place)
        .into_iter()
        .filter(|s| s.methods[place].error.all.n > 0);
    let listed: Vec<String> = judged
        .take(LISTED)
        .map(|s| {
            format!(
                "{} {} mm",
                safe(&s.name),
                millimetres(s.methods[place].error.all.p75)
            )
        })
        .collect();
    if !listed.is_empty() {
        let _ = writeln!(
            text,
            "\nworst sessions by the third quartile of {}: {}",
            safe(&summary.default_method),
            listed.join(", ")
        );
    }
}

/// Cells in columns as wide as their widest, words to the left and numbers to the right.
fn aligned(lines: &[Vec<String>]) -> String {
    let columns = lines.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| {
        let cells = lines.iter().filter_map(|line| line.get(column));
        cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let mut text = String::new();
    for line in lines {
        let cells: Vec<String> = (line.iter().zip(&widths).enumerate())
            .map(|(column, (cell, &width))| match column {
                0 => format!("{cell:<width$}"),
                _ => format!("{cell:>width$}"),
            })
            .collect();
        let _ = writeln!(text, "{}", cells.join("  ").trim_end());
    }
    text
}
