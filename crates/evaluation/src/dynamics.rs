//! Contact dynamics of whole takes and of segments.

use std::collections::BTreeMap;
use std::ops::Range;

use inhand_contact::{ContactError, ContactSeries, phases, slip_m};
use inhand_model::{
    ContactDynamics, ContactRow, ContactRows, ContactRules, Finger, FingerContactFacts, FingerSet,
    GaitFacts, Motion, Object, PerFinger, PhaseFacts, Position, SegmentContacts, Shape, StateFacts,
    StateRow, Status, TakeContacts, Trajectory, Transition, in_contact, runs,
};
use inhand_statistics::quantiles::statistics;

use crate::contacts::contact_at;
use crate::input::{EvaluationSettings, TestData};
use crate::instants::fingertips;
use crate::method::usable;
use crate::movement::JudgedMethod;
use crate::recorded::Recorded;

/// Rows behind [`contact_dynamics`].
#[derive(Clone, Debug)]
pub struct DynamicsRows {
    /// Each whole take; `None` for one without an object.
    pub takes: Vec<Option<ContactRows>>,
    /// Each segment: of the recording, then of each method.
    pub segments: Vec<Vec<ContactRows>>,
}

/// Analyses contacts over time: over the test takes as recorded, and inside the test segments, of the recording
/// and of each method alike. `None` where no take has an object, or its shape is not known.
///
/// Of a take only what is selected counts. Segments are judged each on its own: a contact that goes on beyond
/// its segment is cut there. Slip of planned fingertips is measured on the object as recorded.
///
/// # Errors
///
/// [`ContactError`] for rules that make no sense.
pub fn contact_dynamics<'a>(
    data: &TestData<'a>,
    recorded: &Recorded,
    methods: &[JudgedMethod<'a>],
    settings: &EvaluationSettings,
    rules: &ContactRules,
) -> Result<Option<(ContactDynamics, DynamicsRows)>, ContactError> {
    let (Some(shape), Some(distance_m)) = (&data.shape, &recorded.rows.recorded_distance_m) else {
        return Ok(None);
    };
    let takes = inhand_parallel::try_map(data.motions, |motion| {
        contact_rows(&motion.selected_only(), shape, settings, rules)
    })?;

    let layout = data.segments.layout();
    let judge = |distance_m: &[PerFinger<f64>],
                 values_m: &(dyn Fn(usize) -> Option<&'a [f64]> + Sync)| {
        let segment_rows = |segment: usize| {
            let first = segment * layout.samples;
            let positions: Vec<_> = values_m(segment).into_iter().flat_map(fingertips).collect();
            let stretch = Stretch {
                touches: (first..first + layout.samples)
                    .map(|k| distance_m[k].map(|distance_m| touches(distance_m, rules.tau_m)))
                    .collect(),
                pad: &|t, finger| {
                    let object_from_hand = *recorded.object_from_hand.get(first + t)?;
                    Some(object_from_hand? * positions.get(t)?[finger])
                },
                filled: &|t, finger| recorded.any_filled(first + t)[finger],
            };
            stretch.rows(shape, layout.rate_hz, rules, false)
        };
        inhand_parallel::try_up_to(data.segments.len(), segment_rows)
    };
    let mut segments = vec![judge(distance_m, &|segment| {
        Some(data.segments.fingertips_m(segment))
    })?];
    for method in methods {
        // A method is judged at the same instants as the recording, so it has distances where that has.
        let Some(distance_m) = &method.rows.distance_m else {
            return Ok(None);
        };
        segments.push(judge(distance_m, &|segment| {
            usable(method.trajectories, segment, layout).map(Trajectory::values_m)
        })?);
    }

    let named = data.motions.iter().zip(&takes);
    let dynamics = ContactDynamics {
        rules: *rules,
        takes: named
            .filter_map(|(motion, rows)| {
                let rate_hz = motion.clock.rate_hz();
                Some(take_contacts(&motion.name, rate_hz, rows.as_ref()?))
            })
            .collect(),
        recorded: segment_contacts(&segments[0], layout.rate_hz),
        methods: (methods.iter().zip(&segments[1..]))
            .map(|(method, rows)| {
                let contacts = segment_contacts(rows, layout.rate_hz);
                (method.rows.name.clone(), contacts)
            })
            .collect(),
    };
    Ok(Some((dynamics, DynamicsRows { takes, segments })))
}

/// Contacts, states, phases and steps of fingers over a whole motion. `None` for one without an
/// object.
///
/// # Errors
///
/// [`ContactError`] for rules that make no sense.
pub fn contact_rows(
    motion: &Motion,
    shape: &Shape,
    settings: &EvaluationSettings,
    rules: &ContactRules,
) -> Result<Option<ContactRows>, ContactError> {
    let Some(object) = &motion.object else {
        return Ok(None);
    };
    let contact = contact_at(motion, shape, settings);
    let touching = |k| contact(k).map(|distance_m| distance_m.map(|d| touches(d, rules.tau_m)));
    let stretch = Stretch {
        touches: (0..motion.len())
            .map(|k| touching(k).unwrap_or_default())
            .collect(),
        pad: &|k, finger| Some(object.get(k)?.inverse() * motion.fingertips[finger].get(k)?),
        filled: &|k, finger| {
            let statuses = [object.status(k), motion.fingertips[finger].status(k)];
            statuses.contains(&Status::Filled)
        },
    };
    let rows = stretch.rows(shape, motion.clock.rate_hz(), rules, true);
    rows.map(Some)
}

/// Fingertips and object over an interval of time, sample by sample.
struct Stretch<'a> {
    touches: Vec<PerFinger<Option<bool>>>,
    /// Position of a pad in the object's frame.
    pad: &'a dyn Fn(usize, Finger) -> Option<Position<Object>>,
    /// Whether the fingertip or the object was filled.
    filled: &'a dyn Fn(usize, Finger) -> bool,
}

impl Stretch<'_> {
    fn rows(
        self,
        shape: &Shape,
        rate_hz: f64,
        rules: &ContactRules,
        with_phases: bool,
    ) -> Result<ContactRows, ContactError> {
        let samples = self.touches.len();
        let series = ContactSeries::new(self.touches, rate_hz)?;
        let (phases, gaits) = if with_phases {
            phases(&series, self.pad, rules)?
        } else {
            Default::default()
        };
        let steady = series.debounced(rules.min_duration_s)?;
        let contacts = PerFinger::from_fn(|finger| {
            let slip_m = |samples: &Range<usize>| {
                let pads: Vec<_> = samples.clone().map(|k| (self.pad)(k, finger)).collect();
                slip_m(shape, &pads)
            };
            (steady.contacts(finger).into_iter())
                .map(|contact| ContactRow {
                    made: contact.made,
                    broken: contact.broken,
                    filled: contact.samples.clone().any(|k| (self.filled)(k, finger)),
                    slip_m: slip_m(&contact.samples).unwrap_or(f64::NAN),
                    samples: contact.samples,
                })
                .collect()
        });
        Ok(ContactRows {
            samples,
            unknown: PerFinger::from_fn(|finger| {
                runs(0..samples, |k| steady.samples()[k][finger].is_none())
            }),
            contacts,
            states: steady.state_runs(),
            phases,
            gaits,
        })
    }
}

/// Whether a pad at a distance touches; not known where the distance is not.
fn touches(distance_m: f64, tau_m: f64) -> Option<bool> {
    (!distance_m.is_nan()).then(|| in_contact(distance_m, tau_m))
}

/// Facts of the contacts of a take.
fn take_contacts(take: &str, rate_hz: f64, rows: &ContactRows) -> TakeContacts {
    let span_s =
        |samples: &Range<usize>| [samples.start, samples.end].map(|sample| sample as f64 / rate_hz);
    TakeContacts {
        take: take.to_owned(),
        rate_hz,
        duration_s: rows.samples as f64 / rate_hz,
        by_finger: fingers(std::slice::from_ref(rows), rate_hz),
        contacts_s: (rows.contacts.each_ref())
            .map(|contacts| contacts.iter().map(|row| span_s(&row.samples)).collect()),
        unknown_s: (rows.unknown.each_ref())
            .map(|stretches| stretches.iter().map(span_s).collect()),
        states: states(&rows.states, rate_hz),
        transitions: transitions(&rows.states),
        phases: (rows.phases.iter())
            .map(|phase| PhaseFacts {
                kind: phase.kind,
                span_s: span_s(&phase.samples),
                holding: phase.holding,
            })
            .collect(),
        gaits: (rows.gaits.iter())
            .map(|gait| GaitFacts {
                finger: gait.finger,
                span_s: span_s(&gait.samples),
                holding: gait.holding,
                step_m: gait.step_m,
            })
            .collect(),
    }
}

/// Facts of the contacts inside all segments.
fn segment_contacts(segments: &[ContactRows], rate_hz: f64) -> SegmentContacts {
    let is_known = |rows: &&ContactRows| Finger::ALL.iter().any(|&finger| rows.known(finger) > 0);
    let mut by_fingers = [0; Finger::COUNT + 1];
    for state in segments.iter().flat_map(|rows| &rows.states) {
        by_fingers[state.fingers.len()] += state.samples.len();
    }
    SegmentContacts {
        segments: segments.iter().filter(is_known).count(),
        by_finger: fingers(segments, rate_hz),
        by_fingers,
    }
}

/// Facts of each finger over intervals of time.
fn fingers(stretches: &[ContactRows], rate_hz: f64) -> PerFinger<FingerContactFacts> {
    PerFinger::from_fn(|finger| {
        let contacts = || stretches.iter().flat_map(|rows| &rows.contacts[finger]);
        let known: usize = stretches.iter().map(|rows| rows.known(finger)).sum();
        let touching: usize = contacts().map(|row| row.samples.len()).sum();
        let is_complete = |row: &&ContactRow| row.made && row.broken;
        let whole = || contacts().filter(is_complete);
        let slipped = || contacts().filter(|row| row.slip_m.is_finite());
        let filled =
            |rows: &mut dyn Iterator<Item = &ContactRow>| rows.filter(|r| r.filled).count();
        FingerContactFacts {
            known_s: known as f64 / rate_hz,
            duty: touching as f64 / known as f64,
            makes: contacts().filter(|row| row.made).count(),
            breaks: contacts().filter(|row| row.broken).count(),
            duration_s: statistics(
                whole()
                    .map(|row| row.samples.len() as f64 / rate_hz)
                    .collect(),
                filled(&mut whole()),
                0,
            ),
            censored: contacts().filter(|row| !is_complete(row)).count(),
            slip_m: statistics(
                slipped().map(|row| row.slip_m).collect(),
                filled(&mut slipped()),
                contacts().count() - slipped().count(),
            ),
        }
    })
}

/// Contact states, most frequent first.
fn states(runs: &[StateRow], rate_hz: f64) -> Vec<StateFacts> {
    let all: usize = runs.iter().map(|run| run.samples.len()).sum();
    let mut by_state: BTreeMap<FingerSet, Vec<&StateRow>> = BTreeMap::new();
    for run in runs {
        by_state.entry(run.fingers).or_default().push(run);
    }
    let mut states: Vec<StateFacts> = (by_state.into_iter())
        .map(|(fingers, runs)| {
            let samples = runs.iter().map(|run| run.samples.len()).sum();
            let whole = runs.iter().filter(|run| run.complete);
            let durations_s = whole.map(|run| run.samples.len() as f64 / rate_hz);
            StateFacts {
                fingers,
                samples,
                share: samples as f64 / all as f64,
                runs: runs.len(),
                duration_s: statistics(durations_s.collect(), 0, 0),
            }
        })
        .collect();
    states.sort_by_key(|state| (std::cmp::Reverse(state.samples), state.fingers));
    states
}

/// Transitions from one sample to the next, most frequent first.
fn transitions(runs: &[StateRow]) -> Vec<Transition> {
    let mut counts: BTreeMap<(FingerSet, FingerSet), usize> = BTreeMap::new();
    for pair in runs.windows(2) {
        // Samples at which not all is known may lie between.
        if pair[0].samples.end == pair[1].samples.start {
            *counts
                .entry((pair[0].fingers, pair[1].fingers))
                .or_default() += 1;
        }
    }
    let mut transitions: Vec<Transition> = (counts.into_iter())
        .map(|((from, to), count)| Transition { from, to, count })
        .collect();
    transitions.sort_by_key(|t| (std::cmp::Reverse(t.count), t.from, t.to));
    transitions
}
