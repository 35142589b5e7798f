//! Phases of in-hand manipulation, found from the contacts.
//!
//! Manipulation within the hand is distinguished by its contacts:
//!
//! * **In-grasp manipulation**: the object moves while the same fingers keep their contacts
//!   (B. Sundaralingam and T. Hermans, *Geometric in-hand regrasp planning: alternating optimization of
//!   finger gaits and in-grasp manipulation*, arXiv 1804.04292).
//! * **Finger gaiting**: a finger lifts and sets down again, mostly elsewhere, while the others hold
//!   (J. Hong, G. Lafferriere, B. Mishra and X. Tan, *Fine manipulation with multifinger hands*, ICRA
//!   1990; L. Han and J. C. Trinkle, *Dextrous manipulation by rolling and finger gaiting*, ICRA 1998).
//! * **Regrasp**: the grasp is given up, fewer fingers than a grasp needs touch, and taken again.
//!
//! What needs a definition in numbers is in [`ContactRules`]; there are no defaults.

use inhand_model::{
    ContactRules, Finger, FingerSet, GaitRow, Object, PhaseKind, PhaseRow, Position,
};

use crate::error::ContactError;
use crate::events::{ContactSeries, runs};

/// Finds the phases of a series of contacts, and the steps of fingers by their lifts. Phases are in order, do not
/// overlap, and together are all samples at which the contacts of all five fingers are known. `pad` gives the
/// positions of the pads in the object's frame by sample and finger, as far as they are known.
///
/// In order: contacts are debounced; samples with fewer than `min_fingers` in contact are
/// regrasp or no grasp; a finger's time without contact is a step ([`GaitRow`]) if it was seen to lift and to set
/// down within `max_lift_s`, and at every sample of it the contacts are known and at least
/// `min_fingers` others hold; samples of steps are gaiting, also where several fingers' steps overlap; all
/// others are in grasp, where a change of the fingers that hold begins a new phase.
///
/// ```
/// use inhand_contact::{ContactSeries, phases};
/// use inhand_model::{ContactRules, Finger, PerFinger, PhaseKind};
///
/// // All fingers hold but the index at samples 4 to 6.
/// let samples: Vec<_> = (0..10)
///     .map(|k| PerFinger::from_fn(|f| Some(f != Finger::Index || !(4..7).contains(&k))))
///     .collect();
/// let series = ContactSeries::new(samples, 100.0)?;
/// let rules = ContactRules { tau_m: 0.005, min_fingers: 3, min_duration_s: 0.0, max_lift_s: 1.0 };
/// let (phases, gaits) = phases(&series, &|_, _| None, &rules)?;
/// let kinds: Vec<_> = phases.iter().map(|p| (p.kind, p.samples.clone())).collect();
/// assert_eq!(kinds, [
///     (PhaseKind::InGrasp, 0..4), (PhaseKind::FingerGaiting, 4..7), (PhaseKind::InGrasp, 7..10),
/// ]);
/// assert_eq!(gaits[0].holding.to_string(), "thumb+middle+ring+little");
/// # Ok::<(), inhand_contact::ContactError>(())
/// ```
///
/// # Errors
///
/// [`ContactError::Duration`] for a duration that is negative or not finite, [`ContactError::MinFingers`] for
/// a grasp of no finger or of more than five.
pub fn phases(
    series: &ContactSeries,
    pad: &dyn Fn(usize, Finger) -> Option<Position<Object>>,
    rules: &ContactRules,
) -> Result<(Vec<PhaseRow>, Vec<GaitRow>), ContactError> {
    let needed = rules.min_fingers;
    if !(1..=Finger::COUNT).contains(&needed) {
        return Err(ContactError::MinFingers { found: needed });
    }
    series.samples_in("max_lift_s", rules.max_lift_s)?;
    let steady = series.debounced(rules.min_duration_s)?;
    let states = steady.states();

    let mut gaits: Vec<GaitRow> = Finger::ALL
        .into_iter()
        .flat_map(|finger| gaits_of(finger, &steady, &states, pad, rules))
        .collect();
    gaits.sort_by_key(|gait| (gait.samples.start, gait.finger));

    let mut is_gait = vec![false; states.len()];
    for gait in &gaits {
        is_gait[gait.samples.clone()].fill(true);
    }
    Ok((labelled(&states, &is_gait, needed), gaits))
}

fn gaits_of(
    finger: Finger,
    series: &ContactSeries,
    states: &[Option<FingerSet>],
    pad: &dyn Fn(usize, Finger) -> Option<Position<Object>>,
    rules: &ContactRules,
) -> Vec<GaitRow> {
    let contacts = series.contacts(finger);
    (contacts.windows(2))
        .filter(|pair| pair[0].broken && pair[1].made)
        .map(|pair| pair[0].samples.end..pair[1].samples.start)
        // Rounding of a duration must not decide.
        .filter(|lift| lift.len() as f64 <= rules.max_lift_s * series.rate_hz() + 1e-6)
        .filter_map(|lift| {
            // One contact after the other may still have missing samples between them.
            let states: Option<Vec<FingerSet>> = states[lift.clone()].iter().copied().collect();
            let states = states?;
            if states.iter().any(|state| state.len() < rules.min_fingers) {
                return None;
            }
            let step_m = pad(lift.start - 1, finger)
                .zip(pad(lift.end, finger))
                .map(|(from, to)| to.distance_m(from))
                .filter(|m| m.is_finite());
            Some(GaitRow {
                finger,
                holding: in_all(&states),
                samples: lift,
                step_m: step_m.unwrap_or(f64::NAN),
            })
        })
        .collect()
}

/// The fingers that are in every state; there is one state at least.
fn in_all(states: &[FingerSet]) -> FingerSet {
    (states.iter().copied())
        .reduce(FingerSet::and)
        .unwrap_or_default()
}

fn labelled(states: &[Option<FingerSet>], is_gait: &[bool], needed: usize) -> Vec<PhaseRow> {
    // In grasp the fingers tell phases apart, elsewhere the kind alone does.
    let key = |(state, &gait): (&Option<FingerSet>, &bool)| {
        state.map(|state| match (state.len() < needed, gait) {
            (true, _) => (PhaseKind::NoGrasp, FingerSet::NONE),
            (false, true) => (PhaseKind::FingerGaiting, FingerSet::NONE),
            (false, false) => (PhaseKind::InGrasp, state),
        })
    };
    let runs = runs(states.iter().zip(is_gait).map(key));
    let is_known = |k: Option<usize>| {
        k.and_then(|k| runs.get(k))
            .is_some_and(|(key, _)| key.is_some())
    };
    (runs.iter().enumerate())
        .filter_map(|(k, (key, samples))| {
            let kind = match (*key)?.0 {
                // A known neighbour of too few fingers is a grasp: others would be the same run.
                PhaseKind::NoGrasp if is_known(k.checked_sub(1)) && is_known(Some(k + 1)) => {
                    PhaseKind::Regrasp
                }
                kind => kind,
            };
            let states: Vec<FingerSet> =
                states[samples.clone()].iter().flatten().copied().collect();
            Some(PhaseRow {
                kind,
                samples: samples.clone(),
                holding: in_all(&states),
            })
        })
        .collect()
}
