//! Errors of the methods over all sessions.

use inhand_model::Finger;
use maud::html;

use super::Contender;
use crate::figure::box_plot::{self, BoxPlot, Row, cut_off, shared_end_mm};
use crate::figure::palette::finger_class;
use crate::figure::{Figure, FigureData};
use crate::html::errors::{BOX_WORDS, cut_words};
use crate::html::table::{Column, Line, numbers, table};
use crate::html::{Body, named, statistics};
use crate::number::{NONE, percent};

/// Contacts beside the columns of every table of errors.
const CONTACTS: [Column<'static>; 2] = [numbers("three contacts", "%"), numbers("recorded", "%")];

pub(super) fn section(contenders: &[Contender<'_>]) -> Body {
    let mut body = Body::from(html! {
        p {
            "Distance between planned and recorded fingertips at every instant of every test segment of all sessions together: quantiles are \
             those of the instants, not means over sessions, so that long sessions weigh more than short ones."
        }
    });
    body.figure(figure(contenders));
    let columns: Vec<Column<'_>> = statistics::COLUMNS.into_iter().chain(CONTACTS).collect();
    body.prose(table(
        "Error over all sessions",
        &columns,
        contenders.iter().map(line).collect(),
    ));
    body
}

fn line(contender: &Contender<'_>) -> Line {
    let method = contender.summary;
    let share = |of: fn(&inhand_model::SharedContacts) -> usize| {
        let contacts = method.contacts.filter(|contacts| contacts.n > 0);
        contacts.map_or_else(|| NONE.to_owned(), |c| percent(of(&c) as f64 / c.n as f64))
    };
    let mut cells = statistics::cells(&method.error.all);
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
    let errors = || {
        contenders
            .iter()
            .map(|contender| &contender.summary.error.all)
    };
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
                statistics: &contender.summary.error.all,
            })
            .collect(),
    })];
    let default = contenders.iter().find(|contender| contender.named.default);
    if let Some(contender) = default {
        let by_finger = &contender.summary.error.by_finger;
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
    box_plot::data(contenders.iter().flat_map(|contender| {
        let summary = contender.summary;
        let name = summary.name.as_str();
        let fingers = Finger::ALL.map(|f| (f.name(), name, &summary.error.by_finger[f]));
        [("all", name, &summary.error.all)]
            .into_iter()
            .chain(fingers)
    }))
}
