//! Notes on sessions: outliers and settings that differ.

use inhand_model::{Outlier, Summary};
use maud::html;

use crate::html::Body;
use crate::html::table::{Column, Line, numbers, table, words};
use crate::number::decimals;

const OUTLIERS: [Column<'static>; 6] = [
    words("session"),
    words("what is far off"),
    numbers("there", ""),
    numbers("median of the sessions", ""),
    numbers("score", ""),
    words("what else is known of the session"),
];

/// Sessions far from the others; `None` where no session is.
pub(super) fn outliers(summary: &Summary) -> Option<Body> {
    if summary.outliers.is_empty() {
        return None;
    }
    let lines = summary
        .outliers
        .iter()
        .map(|outlier| line(summary, outlier));
    Some(Body::from(html! {
        p {
            "Far off is a modified z-score beyond 3.5, " code { "0.6745 (value − median) / MAD" } " with the median absolute deviation \
             from the median over sessions (Iglewicz and Hoaglin 1993); where most sessions agree to the last digit, the mean deviation stands \
             in for it. It says that a session is unlike the others, not that it is wrong."
        }
        (table("Sessions unlike the others", &OUTLIERS, lines.collect()))
    }))
}

fn line(summary: &Summary, outlier: &Outlier) -> Line {
    let session = &summary.sessions[outlier.session.place];
    let shown = |value: f64| format!("{} {}", decimals(value, 2), outlier.unit);
    let mut known = Vec::new();
    let all = session.segments + session.left_out;
    if session.left_out > 0 {
        known.push(format!(
            "{} of {all} segments lost to gaps",
            session.left_out
        ));
    }
    if session.warnings > 0 {
        let takes = if session.warnings == 1 {
            "warning"
        } else {
            "warnings"
        };
        known.push(format!("{} {takes} about its takes", session.warnings));
    }
    if known.is_empty() {
        known.push("no gaps, no warnings".to_owned());
    }
    Line {
        head: html! { span title=(session.file) { (session.name) } },
        cells: vec![
            outlier.what.clone(),
            shown(outlier.value),
            shown(outlier.median),
            decimals(outlier.score, 1),
            known.join("; "),
        ],
        best: Vec::new(),
        stressed: false,
    }
}

/// Settings that are not the same in all sessions; `None` where all are.
pub(super) fn settings(summary: &Summary) -> Option<Body> {
    if summary.differences.is_empty() {
        return None;
    }
    let lines = (summary.differences.iter()).map(|difference| {
        let mut values: Vec<(&str, usize)> = Vec::new();
        for value in &difference.values {
            match values.iter_mut().find(|(known, _)| known == value) {
                Some((_, times)) => *times += 1,
                None => values.push((value, 1)),
            }
        }
        let values = values
            .iter()
            .map(|(value, times)| format!("{value} (in {times})"));
        Line {
            head: html! { code { (difference.key) } },
            cells: vec![values.collect::<Vec<_>>().join("; ")],
            best: Vec::new(),
            stressed: false,
        }
    });
    Some(Body::from(html! {
        p {
            "These sessions were joined although they were not worked on in the same way, as was asked for. Numbers over all of them mix what \
             these settings change."
        }
        (table("Settings that differ among the sessions", &[words("setting"), words("values")], lines.collect()))
    }))
}
