//! The sessions, worst first.

use inhand_model::{SessionSummary, Statistics, Summary};
use maud::{Markup, html};

use super::{Contender, stated};
use crate::figure::box_plot::{self, BoxPlot, Row, shared_end_mm};
use crate::figure::{Figure, FigureColumn};
use crate::html::Body;
use crate::html::errors::BOX_WORDS;
use crate::html::table::{Column, Line, numbers, table, words};
use crate::number::{NARROW_SPACE, NONE, count, millimetres, percent};
use crate::summary::worst_first;

/// Sessions that are drawn; the table has all of them.
const DRAWN: usize = 40;

const COLUMNS: [Column<'static>; 13] = [
    words("session"),
    words("participant"),
    words("object"),
    words("task"),
    numbers("segments", ""),
    numbers("lost", ""),
    numbers("warnings", ""),
    numbers("median", "mm"),
    numbers("75 %", "mm"),
    numbers("95 %", "mm"),
    numbers("max", "mm"),
    numbers("three +", "%"),
    numbers("recorded", "%"),
];

pub(super) fn section(summary: &Summary, contenders: &[Contender<'_>]) -> Body {
    let Some(place) = contenders
        .iter()
        .position(|contender| contender.named.default)
    else {
        return Body::default();
    };
    let ranked = worst_first(summary, place);
    let name = &summary.default_method;
    let mut body = Body::from(html! {
        p {
            "Sessions by the third quartile of the error of " b { (name) } ", worst first: the first is where to look first. A session's own \
             report, with the worst instants of its takes, lies beside its evaluation."
        }
    });
    body.figure(figure(&ranked, name, &contenders[place].named.class, place));
    let lines = (ranked.iter())
        .map(|session| line(session, place))
        .collect();
    body.prose(table(
        &format!("Sessions, error of {name}"),
        &COLUMNS,
        lines,
    ));
    body
}

fn line(session: &SessionSummary, place: usize) -> Line {
    let method = &session.methods[place];
    let s = &method.error.all;
    let length = |metres: f64| {
        if s.n == 0 {
            NONE.to_owned()
        } else {
            millimetres(metres)
        }
    };
    let contacts = method.contacts.filter(|contacts| contacts.n > 0);
    let share = |of: fn(&inhand_model::SharedContacts) -> usize| {
        contacts.map_or_else(|| NONE.to_owned(), |c| percent(of(&c) as f64 / c.n as f64))
    };
    let mut cells = vec![
        stated(session.participant.as_deref()),
        stated(session.object.as_deref()),
        stated(session.task.as_deref()),
    ];
    cells.extend(
        [session.segments, session.left_out, session.warnings].map(|n| count(n, NARROW_SPACE)),
    );
    cells.extend([s.p50, s.p75, s.p95, s.max].map(length));
    cells.push(share(|contacts| contacts.three_or_more));
    cells.push(share(|contacts| contacts.recorded_three_or_more));
    Line {
        head: head(session),
        cells,
        best: Vec::new(),
        stressed: false,
    }
}

/// The name, and the file on hovering: names of sessions may repeat.
fn head(session: &SessionSummary) -> Markup {
    html! { span title=(session.file) { (session.name) } }
}

fn figure(ranked: &[&SessionSummary], name: &str, class: &str, place: usize) -> Option<Figure> {
    let drawn: Vec<&SessionSummary> = (ranked.iter())
        .copied()
        .filter(|session| session.methods[place].error.all.n > 0)
        .take(DRAWN)
        .collect();
    if drawn.is_empty() {
        return None;
    }
    let errors: Vec<&Statistics> = drawn.iter().map(|s| &s.methods[place].error.all).collect();
    let rows = |part: &[&SessionSummary]| {
        let panel = BoxPlot {
            title: &format!("{name}, by session"),
            swatch: None,
            axis_name: "distance to recorded fingertip (mm)",
            end_mm: shared_end_mm(errors.iter().copied()),
            rows: (part.iter())
                .map(|session| Row {
                    label: &session.name,
                    class,
                    stressed: false,
                    statistics: &session.methods[place].error.all,
                })
                .collect(),
        };
        box_plot::draw(&panel)
    };
    // Two columns of boxes are read more easily than one tall one.
    let half = drawn.len().div_ceil(2).max(10);
    let panels = drawn.chunks(half).map(rows).collect();
    let words = if ranked.len() > drawn.len() {
        format!(
            " The {} worst of {} sessions are drawn.",
            drawn.len(),
            ranked.len()
        )
    } else {
        String::new()
    };
    // The box's finger is all of them; which session it is stands before.
    let mut data = box_plot::data(errors.iter().map(|errors| ("all", name, *errors)));
    data.columns.splice(
        0..0,
        [
            FigureColumn::words("session", drawn.iter().map(|s| s.name.as_str())),
            FigureColumn::words("file", drawn.iter().map(|s| s.file.as_str())),
        ],
    );
    Some(Figure {
        id: "error-by-session",
        title: format!("Error of {name} by session, worst first."),
        caption: format!("{BOX_WORDS}{words}"),
        data,
        legend: Vec::new(),
        panels,
    })
}
