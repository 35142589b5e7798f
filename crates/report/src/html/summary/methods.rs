//! Errors of the methods over all sessions.

use inhand_model::{Finger, Statistics};
use maud::html;

use super::Contender;
use crate::figure::box_plot::{self, BoxPlot, Row, cut_off, shared_end_mm};
use crate::figure::palette::finger_class;
use crate::figure::{Figure, FigureColumn, FigureData};
use crate::html::errors::{BOX_WORDS, cut_words};
use crate::html::table::{Column, Line, numbers, table, words};
use crate::html::{Body, named};
use crate::number::{NARROW_SPACE, NONE, count, millimetres, percent, to_mm};

const COLUMNS: [Column<'static>; 14] = [
    words("method"),
    numbers("n", ""),
    numbers("filled", ""),
    numbers("left out", ""),
    numbers("mean", "mm"),
    numbers("RMSE", "mm"),
    numbers("5 %", "mm"),
    numbers("25 %", "mm"),
    numbers("median", "mm"),
    numbers("75 %", "mm"),
    numbers("95 %", "mm"),
    numbers("max", "mm"),
    numbers("three contacts", "%"),
    numbers("recorded", "%"),
];

pub(super) fn section(contenders: &[Contender<'_>]) -> Body {
    let mut body = Body::from(html! {
        p {
            "Distance between planned and recorded fingertips at every instant of every test segment of all sessions together: quantiles are \
             those of the instants, not means over sessions, so that long sessions weigh more than short ones."
        }
    });
    body.figure(figure(contenders));
    body.prose(table(
        "Error over all sessions",
        &COLUMNS,
        contenders.iter().map(line).collect(),
    ));
    body
}

fn line(contender: &Contender<'_>) -> Line {
    let (method, s) = (contender.summary, &contender.summary.error);
    let length = |metres: f64| {
        if s.n == 0 {
            NONE.to_owned()
        } else {
            millimetres(metres)
        }
    };
    let share = |of: fn(&inhand_model::SharedContacts) -> usize| {
        let contacts = method.contacts.filter(|contacts| contacts.n > 0);
        contacts.map_or_else(|| NONE.to_owned(), |c| percent(of(&c) as f64 / c.n as f64))
    };
    let mut cells: Vec<String> = [s.n, s.n_filled, s.n_left_out]
        .map(|n| count(n, NARROW_SPACE))
        .into();
    cells.extend([s.mean, s.rmse, s.p5, s.p25, s.p50, s.p75, s.p95, s.max].map(length));
    cells.push(share(|contacts| contacts.three_or_more));
    cells.push(share(|contacts| contacts.recorded_three_or_more));
    Line {
        head: named(&contender.named),
        cells,
        best: Vec::new(),
        stressed: contender.named.default,
    }
}

fn figure(contenders: &[Contender<'_>]) -> Option<Figure> {
    let errors = || contenders.iter().map(|contender| &contender.summary.error);
    if errors().all(|error| error.n == 0) {
        return None;
    }
    let end_mm = shared_end_mm(errors());
    let mut panels = vec![box_plot::draw(&BoxPlot {
        title: "All fingers, by method",
        swatch: None,
        axis_name: AXIS_NAME,
        end_mm,
        rows: (contenders.iter())
            .map(|contender| Row {
                label: contender.named.name,
                class: &contender.named.class,
                stressed: contender.named.default,
                statistics: &contender.summary.error,
            })
            .collect(),
    })];
    let default = contenders.iter().find(|contender| contender.named.default);
    if let Some(contender) = default {
        let by_finger = &contender.summary.error_by_finger;
        panels.push(box_plot::draw(&BoxPlot {
            title: &format!("{}, by finger", contender.named.name),
            swatch: None,
            axis_name: AXIS_NAME,
            end_mm: shared_end_mm(by_finger.as_array()),
            rows: Finger::ALL
                .map(|finger| Row {
                    label: finger.name(),
                    class: finger_class(finger),
                    stressed: false,
                    statistics: &by_finger[finger],
                })
                .into(),
        }));
    }
    Some(Figure {
        id: "error-over-sessions",
        title: "Error over all sessions.".to_owned(),
        caption: format!(
            "{BOX_WORDS} The two axes differ. {}",
            cut_words(cut_off(errors(), end_mm), end_mm)
        ),
        data: data(contenders),
        legend: Vec::new(),
        panels,
    })
}

const AXIS_NAME: &str = "distance to recorded fingertip (mm)";

fn data(contenders: &[Contender<'_>]) -> FigureData {
    let rows: Vec<(&str, &str, &Statistics)> = (contenders.iter())
        .flat_map(|contender| {
            let summary = contender.summary;
            let all = [("all", &summary.error)].into_iter();
            let fingers = Finger::ALL.map(|f| (f.name(), &summary.error_by_finger[f]));
            all.chain(fingers)
                .map(|(finger, error)| (summary.name.as_str(), finger, error))
        })
        .collect();
    let column = |name, of: fn(&Statistics) -> f64| {
        FigureColumn::numbers(name, rows.iter().map(move |(.., s)| to_mm(of(s))))
    };
    FigureData::new([
        FigureColumn::words("method", rows.iter().map(|row| row.0)),
        FigureColumn::words("finger", rows.iter().map(|row| row.1)),
        FigureColumn::counts("n", rows.iter().map(|(.., s)| s.n)),
        column("whisker_low_mm", |s| s.whisker_low),
        column("p25_mm", |s| s.p25),
        column("p50_mm", |s| s.p50),
        column("p75_mm", |s| s.p75),
        column("p95_mm", |s| s.p95),
        column("whisker_high_mm", |s| s.whisker_high),
        column("max_mm", |s| s.max),
    ])
}
