//! Motion and contacts over time.

use inhand_model::{
    ContactDynamics, ContactRules, Finger, FingerContactFacts, FingerMovement, FingerSet,
    GaitFacts, Movement, MovementAnalysis, PerFinger, PhaseFacts, SegmentContacts, StateFacts,
    TakeContacts, Transition,
};

use super::{metres, number, per_finger, scaled_statistics, statistics, word};
use crate::error::ReportError;
use crate::json::wire::ByFinger;
use crate::json::wire::motion as wire;

/// What phases are called.
const KINDS: [&str; 4] = ["in_grasp", "finger_gaiting", "regrasp", "no_grasp"];

pub(super) fn movements(movements: wire::Movements) -> MovementAnalysis {
    MovementAnalysis {
        recorded: movement(movements.recorded),
        methods: named(movements.methods, movement),
        static_speed_m_s: metres(movements.static_speed_mm_s),
        demonstrations: movements.demonstrations,
        demonstrations_available: movements.demonstrations_available,
        warping_band: movements.warping_band_samples,
    }
}

fn named<T, U>(methods: Vec<wire::Named<T>>, read: impl Fn(T) -> U) -> Vec<(String, U)> {
    (methods.into_iter())
        .map(|method| (method.name, read(method.of_method)))
        .collect()
}

fn movement(movement: wire::Movement) -> Movement {
    Movement {
        by_finger: per_finger(movement.by_finger, |finger| moved(&finger)),
        nearest_demonstration_m: movement.nearest_demonstration_mm.map(statistics),
    }
}

fn moved(finger: &wire::Moved) -> FingerMovement {
    FingerMovement {
        length_m: statistics(finger.length_mm),
        peak_speed_m_s: statistics(finger.peak_speed_mm_s),
        static_share: scaled_statistics(finger.static_share, number),
        sparc: scaled_statistics(finger.sparc, number),
        ldlj: scaled_statistics(finger.ldlj, number),
    }
}

pub(super) fn contacts(contacts: wire::Contacts) -> Result<ContactDynamics, ReportError> {
    let rules = contacts.rules;
    Ok(ContactDynamics {
        rules: ContactRules {
            tau_m: metres(rules.tau_mm),
            min_duration_s: number(rules.min_duration_s),
            max_lift_s: number(rules.max_lift_s),
            min_fingers: rules.min_fingers,
        },
        takes: contacts
            .takes
            .into_iter()
            .map(take)
            .collect::<Result<_, _>>()?,
        recorded: segments(contacts.recorded),
        methods: named(contacts.methods, segments),
    })
}

fn by_finger(fingers: ByFinger<wire::FingerContacts>) -> PerFinger<FingerContactFacts> {
    per_finger(fingers, |facts| FingerContactFacts {
        known_s: number(facts.known_s),
        duty: number(facts.duty),
        makes: facts.makes,
        breaks: facts.breaks,
        duration_s: scaled_statistics(facts.duration_s, number),
        censored: facts.censored,
        slip_m: statistics(facts.slip_mm),
    })
}

fn segments(contacts: wire::SegmentContacts) -> SegmentContacts {
    SegmentContacts {
        segments: contacts.segments,
        by_finger: by_finger(contacts.by_finger),
        by_fingers: contacts.by_fingers,
    }
}

fn take(contacts: wire::TakeContacts) -> Result<TakeContacts, ReportError> {
    let spans = |fingers| {
        per_finger(fingers, |spans: Vec<wire::Span>| {
            spans.into_iter().map(span).collect()
        })
    };
    let states = (contacts.states.into_iter()).map(|state| {
        Ok(StateFacts {
            fingers: fingers("contacts.takes.states.fingers", &state.fingers)?,
            samples: state.samples,
            share: number(state.share),
            runs: state.runs,
            duration_s: scaled_statistics(state.duration_s, number),
        })
    });
    let transitions = (contacts.transitions.iter()).map(|change| {
        Ok(Transition {
            from: fingers("contacts.takes.transitions.from", &change.from)?,
            to: fingers("contacts.takes.transitions.to", &change.to)?,
            count: change.count,
        })
    });
    let phases = (contacts.phases.into_iter()).map(|phase| {
        let kind = word(
            "contacts.takes.phases.kind",
            &phase.kind,
            "in_grasp, finger_gaiting, regrasp or no_grasp",
            &KINDS,
            |kind| kind,
        )?;
        Ok(PhaseFacts {
            kind: kind.to_owned(),
            span_s: span(phase.span_s),
            holding: fingers("contacts.takes.phases.holding", &phase.holding)?,
        })
    });
    let gaits = (contacts.gaits.into_iter()).map(|gait| {
        Ok(GaitFacts {
            finger: finger("contacts.takes.gaits.finger", &gait.finger)?,
            span_s: span(gait.span_s),
            holding: fingers("contacts.takes.gaits.holding", &gait.holding)?,
            step_m: metres(gait.step_mm),
        })
    });
    Ok(TakeContacts {
        take: contacts.take,
        rate_hz: number(contacts.rate_hz),
        duration_s: number(contacts.duration_s),
        by_finger: by_finger(contacts.by_finger),
        contacts_s: spans(contacts.contacts_s),
        unknown_s: spans(contacts.unknown_s),
        states: states.collect::<Result<_, ReportError>>()?,
        transitions: transitions.collect::<Result<_, ReportError>>()?,
        phases: phases.collect::<Result<_, ReportError>>()?,
        gaits: gaits.collect::<Result<_, ReportError>>()?,
    })
}

fn fingers(key: &'static str, names: &[String]) -> Result<FingerSet, ReportError> {
    names.iter().try_fold(
        FingerSet::NONE,
        |set, name| Ok(set.with(finger(key, name)?)),
    )
}

fn finger(key: &'static str, name: &str) -> Result<Finger, ReportError> {
    let expected = "thumb, index, middle, ring or little";
    word(key, name, expected, &Finger::ALL, Finger::name)
}

fn span(span_s: wire::Span) -> [f64; 2] {
    span_s.map(number)
}
