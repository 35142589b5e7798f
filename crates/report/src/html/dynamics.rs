//! Contact dynamics: makes and breaks, states, phases, slip.

use inhand_model::{
    ContactDynamics, ContactRules, Finger, FingerContactFacts, FingerSet, GaitFacts, PerFinger,
    PhaseKind, Statistics, TakeContacts,
};
use maud::{Markup, html};

use super::session::name;
use super::table::{Column, Group, Line, grouped, numbers, table, words};
use super::{Body, Method, dynamics_figures};
use crate::figure::palette::{RECORDED_CLASS, finger_class};
use crate::number::{NARROW_SPACE, NONE, count, decimals, millimetres, percent, plain, to_mm};
use crate::report::Report;

/// Takes that have tables and figures of their own; all are in `evaluation.json`.
pub(super) const TAKES: usize = 3;
/// Lines of the tables of states and of changes.
const STATES: usize = 10;

/// Names of phases, in the order of tables, with their words and the class of their colour.
pub(super) const PHASES: [(PhaseKind, &str, &str); 4] = [
    (PhaseKind::InGrasp, "in grasp", "phase-grasp"),
    (PhaseKind::FingerGaiting, "finger gaiting", "phase-gaiting"),
    (PhaseKind::Regrasp, "regrasp", "phase-regrasp"),
    (PhaseKind::NoGrasp, "no grasp", "phase-none"),
];

/// The section's content; `None` where contacts were not judged over time.
pub(super) fn section(report: &Report<'_>, methods: &[Method<'_>]) -> Option<Body> {
    let contacts = report.evaluation.contacts.as_ref()?;
    let mut body = Body::from(rules(&contacts.rules));
    let shown = &contacts.takes[..contacts.takes.len().min(TAKES)];
    if contacts.takes.len() > shown.len() {
        let all = contacts.takes.len();
        body.prose(html! {
            p { "The first " (shown.len()) " of " (all) " test takes are shown; all are in " code { "evaluation.json" } "." }
        });
    }
    if !shown.is_empty() {
        body.prose(take_table(shown));
        body.figure(dynamics_figures::gaits(shown));
        body.prose(phase_table(shown));
        body.figure(dynamics_figures::states(shown));
        let mut tables = Body::default();
        for take in shown {
            tables.prose(state_tables(take));
        }
        body.folded("States of contact and what came after what", tables);
    }
    body.prose(segment_table(contacts, methods));
    Some(body)
}

fn rules(rules: &ContactRules) -> Markup {
    let fingers = if rules.min_fingers == 1 {
        " finger"
    } else {
        " fingers"
    };
    html! {
        p {
            "Contact is within " (plain(to_mm(rules.tau_m))) " mm of the surface; contacts, and lifts, shorter than "
            (plain(rules.min_duration_s)) " s count as no change. " b { "In grasp" } ": " (rules.min_fingers) (fingers) " or more hold and keep their contacts. "
            b { "Finger gaiting" } ": a finger has lifted and sets down again within " (plain(rules.max_lift_s)) " s while "
            (rules.min_fingers) " or more others hold. " b { "Regrasp" } ": fewer hold, between two grasps; " b { "no grasp" } ": the same at the \
             beginning or end of what is known. Phases and steps are events of the takes, too (" code { "by=inhand" } ")."
        }
    }
}

const FACTS: [Column<'static>; 10] = [
    words("finger"),
    numbers("known", "s"),
    numbers("in contact", "%"),
    numbers("makes", ""),
    numbers("breaks", ""),
    numbers("n", ""),
    numbers("duration", "s"),
    numbers("cut", ""),
    numbers("n", ""),
    numbers("slip", "mm"),
];

fn facts(facts: &FingerContactFacts) -> Vec<String> {
    let median = |s: &Statistics, print: fn(f64) -> String| match s.n {
        0 => NONE.to_owned(),
        _ => print(s.p50),
    };
    vec![
        decimals(facts.known_s, 1),
        percent(facts.duty),
        count(facts.makes, NARROW_SPACE),
        count(facts.breaks, NARROW_SPACE),
        count(facts.duration_s.n, NARROW_SPACE),
        median(&facts.duration_s, |s| decimals(s, 2)),
        count(facts.censored, NARROW_SPACE),
        count(facts.slip_m.n, NARROW_SPACE),
        median(&facts.slip_m, millimetres),
    ]
}

fn finger_head(finger: Finger) -> Markup {
    html! { span.swatch.(finger_class(finger)) {} (finger.name()) }
}

fn take_table(takes: &[TakeContacts]) -> Markup {
    let groups: Vec<Group> = (takes.iter())
        .map(|take| Group {
            head: Some(html! { (take.take) }),
            lines: (take.by_finger.iter())
                .map(|(finger, own)| plain_line(finger_head(finger), facts(own)))
                .collect(),
        })
        .collect();
    html! {
        (grouped("Contacts of whole test takes as recorded", &FACTS, &groups))
        p.note {
            "In contact: share of the time over which it is known whether the finger touches. Duration: median of the n contacts seen from make to \
             break; cut: contacts that an end or a gap cuts, which lasted at least as long as was seen and are in no duration, so that the more are cut the shorter durations seem. Slip: median over \
             contacts of the straight distance (the chord) between points of the object's surface, from the first to the last sample of a contact, in the object's frame; it holds sliding, rolling of \
             the fingertip and noise together."
        }
    }
}

fn plain_line(head: Markup, cells: Vec<String>) -> Line {
    Line {
        head,
        cells,
        best: Vec::new(),
        stressed: false,
    }
}

/// How long each phase lasted in all, and how often fingers stepped.
fn phase_table(takes: &[TakeContacts]) -> Markup {
    const COLUMNS: [Column<'static>; 4] = [
        words("phase"),
        numbers("how often", ""),
        numbers("time", "s"),
        numbers("share", "%"),
    ];
    const STEPS: [Column<'static>; 4] = [
        words("finger"),
        numbers("steps", ""),
        numbers("lift", "s"),
        numbers("step", "mm"),
    ];
    let phases = |take: &TakeContacts| {
        // A sum of nothing would be a negative zero.
        let sum_s = |lengths_s: &mut dyn Iterator<Item = f64>| lengths_s.fold(0.0, |a, b| a + b);
        let known_s = sum_s(&mut take.phases.iter().map(|phase| length_s(phase.span_s)));
        PHASES
            .iter()
            .map(|(kind, words, class)| {
                let own = || take.phases.iter().filter(|phase| phase.kind == *kind);
                let own_s = sum_s(&mut own().map(|phase| length_s(phase.span_s)));
                let head = html! { span.swatch.(class) {} (words) };
                let cells = vec![
                    count(own().count(), NARROW_SPACE),
                    decimals(own_s, 2),
                    percent(own_s / known_s),
                ];
                plain_line(head, cells)
            })
            .collect()
    };
    let steps = |take: &TakeContacts| {
        Finger::ALL
            .into_iter()
            .map(|finger| {
                let own: Vec<&GaitFacts> = (take.gaits.iter())
                    .filter(|gait| gait.finger == finger)
                    .collect();
                let lift_s = median(own.iter().map(|gait| length_s(gait.span_s)));
                let step_m = median(own.iter().map(|gait| gait.step_m));
                let cells = vec![
                    count(own.len(), NARROW_SPACE),
                    decimals(lift_s, 2),
                    millimetres(step_m),
                ];
                plain_line(finger_head(finger), cells)
            })
            .collect()
    };
    let by_take = |lines: &dyn Fn(&TakeContacts) -> Vec<Line>| -> Vec<Group> {
        (takes.iter())
            .map(|take| Group {
                head: Some(html! { (take.take) }),
                lines: lines(take),
            })
            .collect()
    };
    let stepped = takes.iter().any(|take| !take.gaits.is_empty());
    html! {
        (grouped("Phases of the test takes as recorded", &COLUMNS, &by_take(&phases)))
        @if stepped {
            (grouped("Steps of fingers: medians of how long they lift and how far over the object they set down", &STEPS, &by_take(&steps)))
        } @else {
            p { "No finger lifts and sets down again while others hold." }
        }
    }
}

pub(super) fn length_s([start, end]: [f64; 2]) -> f64 {
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
fn fingers(set: FingerSet) -> Markup {
    html! {
        @for finger in set.iter() { span.swatch.(finger_class(finger)) {} }
        (set)
    }
}

fn state_tables(take: &TakeContacts) -> Markup {
    const COLUMNS: [Column<'static>; 5] = [
        words("fingers that hold"),
        numbers("share", "%"),
        numbers("stretches", ""),
        numbers("n", ""),
        numbers("duration", "s"),
    ];
    let states = take.states.iter().take(STATES).map(|state| {
        let duration = match state.duration_s.n {
            0 => NONE.to_owned(),
            _ => decimals(state.duration_s.p50, 2),
        };
        let cells = vec![
            percent(state.share),
            count(state.runs, NARROW_SPACE),
            count(state.duration_s.n, NARROW_SPACE),
            duration,
        ];
        plain_line(fingers(state.fingers), cells)
    });
    let changes = take.transitions.iter().take(STATES).map(|change| {
        let cells = vec![change.to.to_string(), count(change.count, NARROW_SPACE)];
        plain_line(fingers(change.from), cells)
    });
    let rest = |all: usize, what: &str| {
        let more = all.saturating_sub(STATES);
        html! { @if more > 0 { p.note { (more) " rarer " (what) " are in " code { "evaluation.json" } "." } } }
    };
    html! {
        (table(&format!("{}: states of contact, with the median duration of the n stretches seen from change to change", take.take), &COLUMNS, states.collect()))
        (rest(take.states.len(), "states"))
        @if !take.transitions.is_empty() {
            (table(&format!("{}: changes from one sample to the next", take.take), &[words("from"), words("to"), numbers("times", "")], changes.collect()))
            (rest(take.transitions.len(), "changes"))
        }
    }
}

/// The recording and each method inside the test segments.
fn segment_table(contacts: &ContactDynamics, methods: &[Method<'_>]) -> Markup {
    let mut columns = FACTS;
    columns[0] = words("motion");
    let planned: Vec<(&Method<'_>, &PerFinger<FingerContactFacts>)> = (methods.iter())
        .filter_map(|method| {
            let own = &method.evaluation.name;
            let (_, found) = contacts.methods.iter().find(|(name, _)| name == own)?;
            Some((method, &found.by_finger))
        })
        .collect();
    let groups = Finger::ALL.map(|finger| {
        let recorded = plain_line(
            html! { span.swatch.(RECORDED_CLASS) {} "recorded" },
            facts(&contacts.recorded.by_finger[finger]),
        );
        let planned = planned.iter().map(|(method, found)| Line {
            stressed: method.default,
            ..plain_line(name(method), facts(&found[finger]))
        });
        Group {
            head: Some(finger_head(finger)),
            lines: std::iter::once(recorded).chain(planned).collect(),
        }
    });
    html! {
        (grouped("Contacts inside the test segments, recorded and planned", &columns, &groups))
        p.note {
            "Each segment stands alone: a contact that goes on beyond it is cut there, so that most are. Compare motions with one another, not with \
             whole takes. Planned fingertips slip over the object as it was recorded. Failed plans are left out: less time is known."
        }
    }
}
