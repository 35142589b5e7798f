//! Contact dynamics: makes and breaks, states, phases, slip.

use inhand_model::{
    ContactDynamics, ContactRules, Finger, FingerContactFacts, FingerSet, GaitFacts, PhaseKind,
    Statistics, TakeContacts,
};
use maud::{Markup, html};

use super::{Body, Method, motions, motions_by_finger};
use crate::Report;
use crate::figure::gait_diagram::{self, PHASES};
use crate::figure::state_graph::{self, STATES};
use crate::figure::{Figure, FigureData, Key, finger_class, finger_keys};
use crate::table::{Head, Table, statistic};
use crate::words::{counted, plain, to_mm};

/// Takes that have tables and figures of their own; all are in `evaluation.json`.
const TAKES: usize = 3;
/// The section's content; `None` where contacts were not evaluated over time.
pub(super) fn section(report: &Report<'_>, methods: &[Method<'_>]) -> Option<Body> {
    let contacts = report.evaluation.contacts.as_ref()?;
    let all = contacts.takes.len();
    let shown = &contacts.takes[..all.min(TAKES)];
    let mut body = Body::from(rules(&contacts.rules));
    if all > shown.len() {
        body = body.prose(html! {
            p { "The first " (shown.len()) " of " (all) " test takes are shown; all are in " code { "evaluation.json" } "." }
        });
    }
    if !shown.is_empty() {
        let tables = shown
            .iter()
            .map(state_tables)
            .fold(Body::default(), Body::prose);
        body = body
            .prose(take_table(shown))
            .figure(gaits(shown))
            .prose(phase_table(shown))
            .figure(states(shown))
            .folded("Contact states and transitions", tables);
    }
    Some(body.prose(segment_table(contacts, methods)))
}

fn rules(rules: &ContactRules) -> Markup {
    html! {
        p {
            "Contact is within " (plain(to_mm(rules.tau_m))) " mm of the surface; contacts, and lifts, shorter than "
            (plain(rules.min_duration_s)) " s count as no change. " b { "In grasp" } ": " (counted(rules.min_fingers, "finger")) " or more hold and keep their contacts. "
            b { "Finger gaiting" } ": a finger has lifted and sets down again within " (plain(rules.max_lift_s)) " s while "
            (rules.min_fingers) " or more others hold. " b { "Regrasp" } ": fewer hold, between two grasps; " b { "no grasp" } ": the same at the \
             beginning or end of what is known. Phases and steps are events of the takes, too (" code { "by=inhand" } ")."
        }
    }
}

fn fact_columns<R>(
    table: Table<'_, R>,
    of: impl Fn(&R) -> &FingerContactFacts + Copy + 'static,
) -> Table<'_, R> {
    let median = |s: &Statistics| statistic(s, |s| s.p50);
    table
        .decimals("known", "s", 1, move |row| of(row).known_s)
        .percents("in contact", "%", move |row| of(row).duty)
        .counts("makes", "", move |row| of(row).makes)
        .counts("breaks", "", move |row| of(row).breaks)
        .counts("n", "", move |row| of(row).duration_s.n)
        .decimals("duration", "s", 2, move |row| median(&of(row).duration_s))
        .counts("cut", "", move |row| of(row).censored)
        .counts("n", "", move |row| of(row).slip_m.n)
        .lengths("slip", move |row| median(&of(row).slip_m))
}

fn take_table(takes: &[TakeContacts]) -> Markup {
    let groups = takes
        .iter()
        .map(|take| (&*take.take, take.by_finger.iter().collect()));
    let caption = "Contacts of whole test takes as recorded";
    let table = Table::grouped(caption, groups, "finger", |(finger, _)| *finger);
    html! {
        (fact_columns(table, |row: &(Finger, &FingerContactFacts)| row.1))
        p.note {
            "In contact: share of the time over which it is known whether the finger touches. Duration: median of the n contacts seen from make to \
             break; cut: contacts that an end or a gap cuts, which lasted at least as long as was seen and are in no duration, so that the more are cut the shorter durations seem. Slip: median over \
             contacts of the straight distance (the chord) between points of the object's surface, from the first to the last sample of a contact, in the object's frame; it holds sliding, rolling of \
             the fingertip and noise together."
        }
    }
}

/// Total duration of each phase, and steps of fingers.
fn phase_table(takes: &[TakeContacts]) -> Markup {
    // A sum of nothing would be a negative zero.
    let sum_s = |spans: &[[f64; 2]]| spans.iter().map(|&s| length_s(s)).fold(0.0, |a, b| a + b);
    let phases = takes.iter().map(|take| {
        let spans = |kind: Option<PhaseKind>| -> Vec<[f64; 2]> {
            let own = take
                .phases
                .iter()
                .filter(|p| kind.is_none_or(|kind| p.kind == kind));
            own.map(|phase| phase.span_s).collect()
        };
        let known_s = sum_s(&spans(None));
        let row = |(kind, words, class)| {
            let own = spans(Some(kind));
            (
                Head::coloured(class, words),
                own.len(),
                sum_s(&own),
                known_s,
            )
        };
        (&*take.take, PHASES.map(row).into())
    });
    let caption = "Phases of the test takes as recorded";
    let phases = Table::grouped(caption, phases, "phase", |row| row.0.clone())
        .counts("how often", "", |row| row.1)
        .decimals("time", "s", 2, |row| row.2)
        .percents("share", "%", |row| row.2 / row.3);
    let steps = takes.iter().map(|take| {
        let row = |finger| -> (Finger, Vec<&GaitFacts>) {
            let own = take.gaits.iter().filter(|gait| gait.finger == finger);
            (finger, own.collect())
        };
        (&*take.take, Finger::ALL.map(row).into())
    });
    let caption =
        "Steps of fingers: medians of how long they lift and how far over the object they set down";
    let steps = Table::grouped(caption, steps, "finger", |(finger, _)| *finger)
        .counts("steps", "", |(_, own)| own.len())
        .decimals("lift", "s", 2, |(_, own)| {
            median(own.iter().map(|gait| length_s(gait.span_s)))
        })
        .lengths("step", |(_, own)| {
            median(own.iter().map(|gait| gait.step_m))
        });
    html! {
        (phases)
        @if takes.iter().any(|take| !take.gaits.is_empty()) {
            (steps)
        } @else {
            p { "No finger lifts and sets down again while others hold." }
        }
    }
}

fn length_s([start, end]: [f64; 2]) -> f64 {
    end - start
}

/// The median of those that are known; NaN without any.
fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
    values.sort_unstable_by(f64::total_cmp);
    let middle = values.len() / 2;
    match (values.get(middle), values.len() % 2) {
        (Some(value), 1) => *value,
        (Some(value), _) => 0.5 * (values[middle - 1] + value),
        (None, _) => f64::NAN,
    }
}

/// A set of fingers with their colours.
fn fingers(set: FingerSet) -> Head {
    let classes = set.iter().map(|finger| finger_class(finger).to_owned());
    Head::with_swatches(classes.collect(), set.to_string())
}

fn state_tables(take: &TakeContacts) -> Markup {
    let caption = format!(
        "{}: contact states, with the median duration of the n intervals seen from change to change",
        take.take
    );
    let states = take.states.iter().take(STATES);
    let states = Table::new(caption, states, "fingers that hold", |state| {
        fingers(state.fingers)
    })
    .percents("share", "%", |state| state.share)
    .counts("intervals", "", |state| state.runs)
    .counts("n", "", |state| state.duration_s.n)
    .decimals("duration", "s", 2, |state| {
        statistic(&state.duration_s, |s| s.p50)
    });
    let caption = format!("{}: transitions from one sample to the next", take.take);
    let changes = take.transitions.iter().take(STATES);
    let changes = Table::new(caption, changes, "from", |change| fingers(change.from))
        .words("to", |change| change.to.to_string())
        .counts("times", "", |change| change.count);
    let rest = |all: usize, what: &str| {
        let more = all.saturating_sub(STATES);
        html! { @if more > 0 { p.note { (more) " rarer " (what) " are in " code { "evaluation.json" } "." } } }
    };
    html! {
        (states)
        (rest(take.states.len(), "states"))
        @if !changes.is_empty() {
            (changes)
            (rest(take.transitions.len(), "transitions"))
        }
    }
}

/// The recording and each method inside the test segments.
fn segment_table(contacts: &ContactDynamics, methods: &[Method<'_>]) -> Markup {
    let motions = motions(&contacts.recorded, &contacts.methods, methods);
    let caption = "Contacts inside the test segments, recorded and planned";
    let table = motions_by_finger(caption, &motions, |own, finger| &own.by_finger[finger]);
    html! {
        (fact_columns(table, |row| row.1))
        p.note {
            "Each segment is evaluated alone: a contact that goes on beyond it is cut there, so that most are. Compare motions with one another, not with \
             whole takes. Planned fingertips slip over the object as it was recorded. Failed plans are left out: less time is known."
        }
    }
}

/// Contacts of each finger over time, with the phases beneath.
fn gaits(takes: &[TakeContacts]) -> Figure {
    let mut legend = finger_keys(Key::area);
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
        panels: takes.iter().map(gait_diagram::draw).collect(),
    }
}

fn gait_data(takes: &[TakeContacts]) -> FigureData {
    let mut rows: Vec<(&str, &str, &str, [f64; 2])> = Vec::new();
    for take in takes {
        for finger in Finger::ALL {
            let of = |kind, spans: &[[f64; 2]]| -> Vec<_> {
                let row = |&span| (&*take.take, kind, finger.name(), span);
                spans.iter().map(row).collect()
            };
            rows.extend(of("contact", &take.contacts_s[finger]));
            rows.extend(of("unknown", &take.unknown_s[finger]));
        }
        let phases = take.phases.iter();
        rows.extend(phases.map(|p| (&*take.take, "phase", p.kind.name(), p.span_s)));
    }
    FigureData::about(&rows)
        .words("take", |row| row.0)
        .words("kind", |row| row.1)
        .words("what", |row| row.2)
        .numbers("start_s", |row| row.3[0])
        .numbers("end_s", |row| row.3[1])
        .done()
}

/// Contact states and transitions; `None` where nothing changes.
fn states(takes: &[TakeContacts]) -> Option<Figure> {
    let changing: Vec<&TakeContacts> = (takes.iter())
        .filter(|take| !take.transitions.is_empty())
        .collect();
    if changing.is_empty() {
        return None;
    }
    let cut = if changing.iter().any(|take| take.states.len() > STATES) {
        format!(" The {STATES} most frequent states are drawn.")
    } else {
        String::new()
    };
    Some(Figure {
        id: "contact-states",
        title: "Contact states and transitions.".to_owned(),
        caption: format!(
            "A circle is a set of fingers that hold (filled dots, from thumb to little finger), its area and the number at it the share of the \
             time; an arrow is a transition from one sample to the next, thicker the more often.{cut}"
        ),
        data: state_data(&changing),
        legend: finger_keys(Key::area),
        panels: changing
            .iter()
            .map(|take| state_graph::draw(take))
            .collect(),
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
    FigureData::about(&rows)
        .words("take", |row| row.0)
        .words("fingers", |row| &*row.1)
        .words("followed_by", |row| &*row.2)
        .numbers("share_percent", |row| row.3)
        .numbers("times", |row| row.4)
        .done()
}
