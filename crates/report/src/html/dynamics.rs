//! Contact dynamics: makes and breaks, states, phases, slip.

use inhand_model::{
    ContactDynamics, ContactRules, Finger, FingerContactFacts, FingerSet, GaitFacts, PhaseKind,
    Statistics, TakeContacts,
};
use maud::{Markup, html};

use super::{Body, Method, motions, motions_by_finger};
use crate::Report;
use crate::figure::scale::Scale;
use crate::figure::state_graph::{self, STATES};
use crate::figure::{Figure, FigureData, Frame, Key, Panel, Px, axes, finger_class, finger_keys};
use crate::table::{Head, Table, statistic};
use crate::words::{count, counted, plain, short, to_mm};

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

fn fact_columns<R>(table: Table<R>, of: fn(&R) -> &FingerContactFacts) -> Table<R> {
    let median = |s: &Statistics| statistic(s, |s| s.p50);
    table
        .decimals("known", "s", 1, |row| of(row).known_s)
        .percents("in contact", "%", |row| of(row).duty)
        .counts("makes", "", |row| of(row).makes)
        .counts("breaks", "", |row| of(row).breaks)
        .counts("n", "", |row| of(row).duration_s.n)
        .decimals("duration", "s", 2, |row| median(&of(row).duration_s))
        .counts("cut", "", |row| of(row).censored)
        .counts("n", "", |row| of(row).slip_m.n)
        .lengths("slip", |row| median(&of(row).slip_m))
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
    let drawn_s = shown_s(longest_s);
    let cut = if drawn_s < longest_s {
        format!(
            " Of longer takes the first {} s are drawn; all contacts are in evaluation.json and contacts.parquet.",
            plain(drawn_s)
        )
    } else {
        String::new()
    };
    Figure {
        id: "gait-diagram",
        title: "Contacts and phases of the test takes.".to_owned(),
        caption: format!(
            "Coloured where a fingertip touches the object in the recording; blank: no contact; thin grey line: not known. Lowest lane: \
             phases of the contacts. Test takes, n = {}.{cut}",
            takes.len()
        ),
        data: gait_data(takes),
        legend,
        panels: takes.iter().map(gait_panel).collect(),
    }
}

/// Phases, in the order of tables, with their words and the class of their colour.
const PHASES: [(PhaseKind, &str, &str); 4] = [
    (PhaseKind::InGrasp, "in grasp", "phase-grasp"),
    (PhaseKind::FingerGaiting, "finger gaiting", "phase-gaiting"),
    (PhaseKind::Regrasp, "regrasp", "phase-regrasp"),
    (PhaseKind::NoGrasp, "no grasp", "phase-none"),
];

const WIDTH: f64 = 940.0;
const LEFT: f64 = 62.0;
const TOP: f64 = 4.0;
const LANE_HEIGHT: f64 = 15.0;
const BAR_HEIGHT: f64 = 11.0;
const PHASE_HEIGHT: f64 = 9.0;
/// Lanes of five fingers, and of the phases beneath.
const BLOCK_HEIGHT: f64 = LANE_HEIGHT * (Finger::COUNT as f64) + 18.0;
/// From the end of a row's lanes to the next row's: tick labels.
const BLOCK_GAP: f64 = 30.0;
const WANTED_TICKS: usize = 12;
/// Least width of an interval that is there at all: short is not never.
const LEAST: f64 = 0.6;

/// The longest interval in a row of a diagram, seconds.
const ROW_S: f64 = 60.0;
/// Rows of a diagram; what comes later is not drawn.
const ROWS: usize = 4;

/// Time of a take that is drawn, seconds.
fn shown_s(duration_s: f64) -> f64 {
    duration_s.min(ROW_S * ROWS as f64)
}

/// The gait diagram of a take: rows of equal length below each other.
fn gait_panel(take: &TakeContacts) -> Panel {
    let shown_s = shown_s(take.duration_s);
    let rows = ((shown_s / ROW_S).ceil() as usize).clamp(1, ROWS);
    let row_s = shown_s / rows as f64;
    let top = |row: usize| TOP + (BLOCK_HEIGHT + BLOCK_GAP) * row as f64;
    let shapes = html! {
        @for row in 0..rows {
            (gait_rows(take, [row_s * row as f64, row_s * (row + 1) as f64], top(row), row + 1 == rows))
        }
    };
    Panel {
        title: take.take.as_str().into(),
        width: WIDTH,
        height: top(rows - 1) + BLOCK_HEIGHT + axes::BOTTOM_ROOM,
        summary: gait_summary(take),
        shapes,
    }
}

/// One row: a lane for each finger, phases beneath, an axis.
fn gait_rows(take: &TakeContacts, span_s: [f64; 2], top: f64, is_last: bool) -> Markup {
    let frame = Frame::new([LEFT, WIDTH - 8.0], [top, top + BLOCK_HEIGHT]);
    let x = Scale::linear(span_s[0], span_s[1]).over(frame.left, frame.right);
    let name = if is_last { "time in the take (s)" } else { "" };
    let phases_top = top + LANE_HEIGHT * Finger::COUNT as f64 + 3.0;
    html! {
        (axes::bottom(&frame, &x, WANTED_TICKS, name))
        @for finger in Finger::ALL {
            @let y = top + LANE_HEIGHT * finger.index() as f64;
            text.label x=(Px(LEFT - 8.0)) y=(Px(y + 10.5)) text-anchor="end" { (finger.name()) }
            g.(finger_class(finger)) {
                (bars(&x, &take.contacts_s[finger], [y + 1.0, BAR_HEIGHT], &format!("{finger} touches")))
            }
            g.missing {
                (bars(&x, &take.unknown_s[finger], [y + 0.5 * LANE_HEIGHT - 1.0, 1.5], &format!("{finger}: not known")))
            }
        }
        text.label x=(Px(LEFT - 8.0)) y=(Px(phases_top + 9.0)) text-anchor="end" { "phase" }
        @for (kind, name, class) in PHASES {
            g.(class) {
                @for phase in take.phases.iter().filter(|phase| phase.kind == kind) {
                    (bars(&x, &[phase.span_s], [phases_top, PHASE_HEIGHT], name))
                }
            }
        }
    }
}

/// Bars over those parts of intervals that are on the axis.
fn bars(x: &Scale, intervals_s: &[[f64; 2]], [top, height]: [f64; 2], name: &str) -> Markup {
    let [low, high] = x.ends();
    html! {
        @for [start, end] in intervals_s.iter().filter(|[start, end]| *start < high && *end > low) {
            @let (left, right) = (x.at(start.max(low)), x.at(end.min(high)));
            rect.area x=(Px(left)) y=(Px(top)) width=(Px((right - left).max(LEAST))) height=(Px(height)) {
                title { (name) ", " (short(*start)) " to " (short(*end)) " s" }
            }
        }
    }
}

/// Description for readers who do not see it.
fn gait_summary(take: &TakeContacts) -> String {
    let contacts = (take.contacts_s.each_ref()).map(|contacts| contacts.len().to_string());
    format!(
        "{}: contacts of thumb to little finger over {} s: {}; {} phases",
        take.take,
        plain(take.duration_s),
        contacts.as_array().join(", "),
        take.phases.len()
    )
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
    let transitions = changing.iter().flat_map(|take| &take.transitions);
    let transitions = count(transitions.map(|change| change.count).sum());
    Some(Figure {
        id: "contact-states",
        title: "Contact states and transitions.".to_owned(),
        caption: format!(
            "Circle: a set of fingers in contact (filled dots, thumb to little finger), its area and number: share of the time. Arrow: transition \
             from one sample to the next, wider the more often; n = {transitions} transitions.{cut}"
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
