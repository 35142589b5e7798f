//! Participant x object x task x finger.

use inhand_model::{Finger, GroupSummary, Statistics, Summary};
use maud::html;

use super::stated;
use crate::html::Body;
use crate::html::table::{Column, Line, numbers, table, words};
use crate::number::{NARROW_SPACE, NONE, count, millimetres};

pub(super) fn section(summary: &Summary) -> Body {
    let mut body = Body::from(html! {
        p {
            "Sessions of the same participant, object and task together. Each cell: median (third quartile) of the error at all of their instants, \
             mm. What a session does not state stands as –; participant and task in its inhand.toml, or --participant and \
             --task, state it."
        }
    });
    let methods = summary
        .groups
        .iter()
        .fold(Vec::new(), |mut names: Vec<&str>, group| {
            if !names.contains(&group.method.as_str()) {
                names.push(&group.method);
            }
            names
        });
    for method in methods {
        let of_method = summary.groups.iter().filter(|group| group.method == method);
        let lines = of_method.map(line).collect();
        body.prose(table(
            &format!("Error of {method} by group"),
            &columns(),
            lines,
        ));
    }
    body
}

fn columns() -> Vec<Column<'static>> {
    let mut columns = vec![
        words("participant"),
        words("object"),
        words("task"),
        numbers("sessions", ""),
        numbers("n", ""),
        numbers("all fingers", "mm"),
    ];
    columns.extend(Finger::ALL.map(|finger| numbers(finger.name(), "mm")));
    columns
}

fn line(group: &GroupSummary) -> Line {
    let middle = |s: &Statistics| match s.n {
        0 => NONE.to_owned(),
        _ => format!("{} ({})", millimetres(s.p50), millimetres(s.p75)),
    };
    let mut cells = vec![
        stated(group.object.as_deref()),
        stated(group.task.as_deref()),
        count(group.sessions, NARROW_SPACE),
        count(group.error.all.n, NARROW_SPACE),
        middle(&group.error.all),
    ];
    cells.extend(group.error.by_finger.as_array().iter().map(middle));
    Line {
        head: html! { (stated(group.participant.as_deref())) },
        cells,
        best: Vec::new(),
        stressed: false,
    }
}
