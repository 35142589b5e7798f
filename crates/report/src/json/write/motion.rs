//! Motion and contacts over time.

use inhand_model::{
    ContactDynamics, FingerContactFacts, FingerMovement, FingerSet, Movement, MovementAnalysis,
    PerFinger, SegmentContacts, TakeContacts,
};

use super::{distribution, mm, scaled_distribution};
use crate::json::wire::motion as wire;
use crate::json::wire::{ByFinger, Number};

pub(super) fn movements(analysis: &MovementAnalysis) -> wire::Movements {
    wire::Movements {
        static_speed_mm_s: mm(analysis.static_speed_m_s),
        demonstrations: analysis.demonstrations,
        demonstrations_available: analysis.demonstrations_available,
        warping_band_samples: analysis.warping_band,
        recorded: movement(&analysis.recorded),
        methods: named(&analysis.methods, movement),
    }
}

fn named<T, U>(methods: &[(String, T)], write: impl Fn(&T) -> U) -> Vec<wire::Named<U>> {
    (methods.iter())
        .map(|(name, of_method)| wire::Named {
            name: name.clone(),
            of_method: write(of_method),
        })
        .collect()
}

fn movement(movement: &Movement) -> wire::Movement {
    wire::Movement {
        nearest_demonstration_mm: movement.nearest_demonstration_m.as_ref().map(distribution),
        by_finger: ByFinger::from_fn(|finger| moved(&movement.by_finger[finger])),
    }
}

fn moved(finger: &FingerMovement) -> wire::Moved {
    wire::Moved {
        length_mm: distribution(&finger.length_m),
        peak_speed_mm_s: distribution(&finger.peak_speed_m_s),
        static_share: scaled_distribution(&finger.static_share, as_it_is),
        sparc: scaled_distribution(&finger.sparc, as_it_is),
        ldlj: scaled_distribution(&finger.ldlj, as_it_is),
    }
}

pub(super) fn contacts(contacts: &ContactDynamics) -> wire::Contacts {
    let rules = contacts.rules;
    wire::Contacts {
        rules: wire::Rules {
            tau_mm: mm(rules.tau_m),
            min_duration_s: Number::finite(rules.min_duration_s),
            max_lift_s: Number::finite(rules.max_lift_s),
            min_fingers: rules.min_fingers,
        },
        takes: contacts.takes.iter().map(take).collect(),
        recorded: segments(&contacts.recorded),
        methods: named(&contacts.methods, segments),
    }
}

fn by_finger(fingers: &PerFinger<FingerContactFacts>) -> ByFinger<wire::FingerContacts> {
    ByFinger::from_fn(|finger| {
        let facts = &fingers[finger];
        wire::FingerContacts {
            known_s: Number::finite(facts.known_s),
            duty: Number::finite(facts.duty),
            makes: facts.makes,
            breaks: facts.breaks,
            duration_s: scaled_distribution(&facts.duration_s, as_it_is),
            censored: facts.censored,
            slip_mm: distribution(&facts.slip_m),
        }
    })
}

fn segments(contacts: &SegmentContacts) -> wire::SegmentContacts {
    wire::SegmentContacts {
        segments: contacts.segments,
        by_finger: by_finger(&contacts.by_finger),
        by_fingers: contacts.by_fingers,
    }
}

fn take(contacts: &TakeContacts) -> wire::TakeContacts {
    let spans = |spans: &PerFinger<Vec<[f64; 2]>>| {
        ByFinger::from_fn(|finger| spans[finger].iter().copied().map(span).collect())
    };
    wire::TakeContacts {
        take: contacts.take.clone(),
        rate_hz: Number::finite(contacts.rate_hz),
        duration_s: Number::finite(contacts.duration_s),
        by_finger: by_finger(&contacts.by_finger),
        contacts_s: spans(&contacts.contacts_s),
        unknown_s: spans(&contacts.unknown_s),
        states: (contacts.states.iter())
            .map(|state| wire::State {
                fingers: names(state.fingers),
                samples: state.samples,
                share: Number::finite(state.share),
                runs: state.runs,
                duration_s: scaled_distribution(&state.duration_s, as_it_is),
            })
            .collect(),
        transitions: (contacts.transitions.iter())
            .map(|transition| wire::Change {
                from: names(transition.from),
                to: names(transition.to),
                count: transition.count,
            })
            .collect(),
        phases: (contacts.phases.iter())
            .map(|phase| wire::Phase {
                kind: phase.kind.clone(),
                span_s: span(phase.span_s),
                holding: names(phase.holding),
            })
            .collect(),
        gaits: (contacts.gaits.iter())
            .map(|gait| wire::Gait {
                finger: gait.finger.name().to_owned(),
                span_s: span(gait.span_s),
                holding: names(gait.holding),
                step_mm: mm(gait.step_m),
            })
            .collect(),
    }
}

fn names(fingers: FingerSet) -> wire::Fingers {
    fingers
        .iter()
        .map(|finger| finger.name().to_owned())
        .collect()
}

fn span(span_s: [f64; 2]) -> wire::Span {
    span_s.map(Number::finite)
}

/// Shares and seconds are written in the unit they have.
fn as_it_is(value: f64) -> f64 {
    value
}
