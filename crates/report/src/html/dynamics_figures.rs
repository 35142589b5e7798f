//! Gait diagrams and graphs of contact states.

use inhand_model::{Finger, TakeContacts};

use super::dynamics::PHASES;
use crate::figure::gait_diagram::{self, GaitDiagram, PhaseSpan};
use crate::figure::palette::finger_class;
use crate::figure::state_graph::{self, Edge, Node, StateGraph};
use crate::figure::{Figure, FigureColumn, FigureData, Key};
use crate::number::plain;

/// States in a graph: the most frequent ones.
const NODES: usize = 10;

/// When each finger touches, with the phases beneath.
pub(super) fn gaits(takes: &[TakeContacts]) -> Figure {
    let mut legend: Vec<Key> = Finger::ALL
        .map(|finger| Key::area(finger.name(), finger_class(finger)))
        .into();
    legend.extend(PHASES.map(|(_, words, class)| Key::area(words, class)));
    let longest_s = takes.iter().map(|take| take.duration_s).fold(0.0, f64::max);
    let shown_s = gait_diagram::shown_s(longest_s);
    let cut = if shown_s < longest_s {
        format!(
            " Of longer takes the first {} s are drawn; all contacts are in evaluation.json and contacts.parquet.",
            plain(shown_s)
        )
    } else {
        String::new()
    };
    Figure {
        id: "gait-diagram",
        title: "Which finger holds when.".to_owned(),
        caption: format!(
            "Coloured where a finger touches, as recorded; thin grey line: not known. Beneath, the phases that makes.{cut}"
        ),
        data: gait_data(takes),
        legend,
        panels: takes.iter().map(diagram).collect(),
    }
}

fn diagram(take: &TakeContacts) -> crate::figure::Panel {
    let phases = take.phases.iter().map(|phase| {
        let (_, name, class) = (PHASES.into_iter().find(|(kind, ..)| *kind == phase.kind))
            .unwrap_or((phase.kind, "phase", "faded"));
        PhaseSpan {
            name,
            class,
            span_s: phase.span_s,
        }
    });
    gait_diagram::draw(&GaitDiagram {
        take: &take.take,
        duration_s: take.duration_s,
        contacts_s: &take.contacts_s,
        unknown_s: &take.unknown_s,
        phases: phases.collect(),
    })
}

fn gait_data(takes: &[TakeContacts]) -> FigureData {
    let mut rows: Vec<(&str, &str, &str, [f64; 2])> = Vec::new();
    for take in takes {
        for finger in Finger::ALL {
            let of = |kind, spans: &[[f64; 2]]| -> Vec<_> {
                let row = |&span| (take.take.as_str(), kind, finger.name(), span);
                spans.iter().map(row).collect()
            };
            rows.extend(of("contact", &take.contacts_s[finger]));
            rows.extend(of("unknown", &take.unknown_s[finger]));
        }
        let phases = take.phases.iter();
        rows.extend(phases.map(|p| (take.take.as_str(), "phase", p.kind.name(), p.span_s)));
    }
    FigureData::new([
        FigureColumn::words("take", rows.iter().map(|row| row.0)),
        FigureColumn::words("kind", rows.iter().map(|row| row.1)),
        FigureColumn::words("what", rows.iter().map(|row| row.2)),
        FigureColumn::numbers("start_s", rows.iter().map(|row| row.3[0])),
        FigureColumn::numbers("end_s", rows.iter().map(|row| row.3[1])),
    ])
}

/// States of contact and what came after what; `None` where nothing changes.
pub(super) fn states(takes: &[TakeContacts]) -> Option<Figure> {
    let changing: Vec<&TakeContacts> = (takes.iter())
        .filter(|take| !take.transitions.is_empty())
        .collect();
    if changing.is_empty() {
        return None;
    }
    let cut = if changing.iter().any(|take| take.states.len() > NODES) {
        format!(" The {NODES} most frequent states are drawn.")
    } else {
        String::new()
    };
    Some(Figure {
        id: "contact-states",
        title: "States of contact and what came after what.".to_owned(),
        caption: format!(
            "A circle is a set of fingers that hold (filled dots, from thumb to little finger), its area and the number at it the share of the \
             time; an arrow is a change from one sample to the next, thicker the more often.{cut}"
        ),
        data: state_data(&changing),
        legend: Finger::ALL
            .map(|finger| Key::area(finger.name(), finger_class(finger)))
            .into(),
        panels: changing.iter().map(|take| graph(take)).collect(),
    })
}

fn graph(take: &TakeContacts) -> crate::figure::Panel {
    let nodes: Vec<Node> = (take.states.iter().take(NODES))
        .map(|state| Node {
            fingers: state.fingers,
            share: state.share,
        })
        .collect();
    let place = |fingers| nodes.iter().position(|node| node.fingers == fingers);
    let edges = (take.transitions.iter())
        .filter_map(|change| {
            Some(Edge {
                from: place(change.from)?,
                to: place(change.to)?,
                count: change.count,
            })
        })
        .collect();
    state_graph::draw(&StateGraph {
        take: &take.take,
        nodes,
        edges,
    })
}

/// States first, each with its share; then changes, each with its count.
fn state_data(takes: &[&TakeContacts]) -> FigureData {
    let mut rows: Vec<(&str, String, String, f64, f64)> = Vec::new();
    for take in takes {
        let name = take.take.as_str();
        rows.extend(take.states.iter().map(|state| {
            let set = state.fingers.to_string();
            (name, set, String::new(), 100.0 * state.share, f64::NAN)
        }));
        rows.extend(take.transitions.iter().map(|change| {
            let (from, to) = (change.from.to_string(), change.to.to_string());
            (name, from, to, f64::NAN, change.count as f64)
        }));
    }
    FigureData::new([
        FigureColumn::words("take", rows.iter().map(|row| row.0)),
        FigureColumn::words("fingers", rows.iter().map(|row| row.1.clone())),
        FigureColumn::words("followed_by", rows.iter().map(|row| row.2.clone())),
        FigureColumn::numbers("share_percent", rows.iter().map(|row| row.3)),
        FigureColumn::numbers("times", rows.iter().map(|row| row.4)),
    ])
}
