//! Makes, breaks and durations of contacts, and the states of contact they add up to.
//!
//! A [`ContactSeries`] says at every sample and of every finger whether it touches the object, or that
//! this is not known. What is not known is never guessed: a missing sample ends a contact without
//! counting as a break, and a contact that goes on after it does not count as a make. Such contacts, and
//! those that are there at the first or last sample, are *censored*: they lasted at least as long as was
//! seen, and their duration is kept apart from those seen from make to break.
//!
//! A sample stands for one period: a contact over n samples lasts n / rate.
//!
//! ```
//! use inhand_contact::events::ContactSeries;
//! use inhand_model::{Finger, PerFinger};
//!
//! // The thumb touches at samples 1 and 2 of 5 and again at the last, the others never, at 100 Hz.
//! let samples = [false, true, true, false, true].map(|thumb| {
//!     PerFinger::from_fn(|finger| Some(finger == Finger::Thumb && thumb))
//! });
//! let series = ContactSeries::new(samples.to_vec(), 100.0)?;
//! let thumb = series.finger(Finger::Thumb);
//! assert_eq!((thumb.makes, thumb.breaks), (2, 1));
//! assert_eq!(thumb.duty(), Some(0.6));
//! assert_eq!(series.durations_s(&thumb).complete, [0.02]);
//! assert_eq!(series.durations_s(&thumb).censored, [0.01]);
//! # Ok::<(), inhand_contact::ContactError>(())
//! ```

use std::collections::BTreeMap;
use std::ops::Range;

use inhand_model::{Finger, FingerSet, PerFinger};

use crate::error::ContactError;

/// Whether each finger touches at each sample, `None` where it is not known.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactSeries {
    samples: Vec<PerFinger<Option<bool>>>,
    rate_hz: f64,
}

/// An unbroken stretch of known samples in which a finger touches.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Contact {
    /// The samples in contact.
    pub samples: Range<usize>,
    /// Whether it was seen to begin: the sample before is known and without contact.
    pub made: bool,
    /// Whether it was seen to end: the sample after is known and without contact.
    pub broken: bool,
}

impl Contact {
    /// Seen from make to break, so that its duration is known.
    pub fn is_complete(&self) -> bool {
        self.made && self.broken
    }
}

/// The contacts of one finger.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FingerContacts {
    /// Samples at which it is known whether the finger touches.
    pub known: usize,
    /// Samples of those at which it does.
    pub touching: usize,
    /// Contacts seen to begin.
    pub makes: usize,
    /// Contacts seen to end.
    pub breaks: usize,
    /// All contacts in order.
    pub contacts: Vec<Contact>,
}

impl FingerContacts {
    /// Share of the known samples in contact, 0 to 1 (the duty factor of gait analysis); `None` if
    /// nothing is known.
    pub fn duty(&self) -> Option<f64> {
        (self.known > 0).then(|| self.touching as f64 / self.known as f64)
    }
}

/// Durations of contacts, seconds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Durations {
    /// Of those seen from make to break.
    pub complete: Vec<f64>,
    /// Of the others, as far as they were seen: lower bounds.
    pub censored: Vec<f64>,
}

/// A stretch in which the same fingers touch; all five are known throughout.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StateRun {
    /// The fingers that touch.
    pub state: FingerSet,
    /// The samples.
    pub samples: Range<usize>,
    /// Whether both ends are changes to other known states, so that the duration is known.
    pub is_complete: bool,
}

/// How often and how long each state of contact was there, and what came after it. All over the samples
/// at which all five fingers are known.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct States {
    /// The stretches in order.
    pub runs: Vec<StateRun>,
    /// Samples in each state that occurs.
    pub samples: BTreeMap<FingerSet, usize>,
    /// How often each state was followed by each other, seen from one sample to the next: (from, to).
    pub transitions: BTreeMap<(FingerSet, FingerSet), usize>,
    /// Samples at which 0, 1, .. 5 fingers touch.
    pub by_fingers: [usize; Finger::COUNT + 1],
}

impl ContactSeries {
    /// Contacts at `rate_hz`.
    ///
    /// # Errors
    ///
    /// [`ContactError::Rate`] for a rate that is not a positive number.
    pub fn new(samples: Vec<PerFinger<Option<bool>>>, rate_hz: f64) -> Result<Self, ContactError> {
        if !(rate_hz > 0.0 && rate_hz.is_finite()) {
            return Err(ContactError::Rate { found_hz: rate_hz });
        }
        Ok(Self { samples, rate_hz })
    }

    /// What is known at each sample.
    pub fn samples(&self) -> &[PerFinger<Option<bool>>] {
        &self.samples
    }

    /// Samples per second.
    pub fn rate_hz(&self) -> f64 {
        self.rate_hz
    }

    /// The fingers in contact at each sample; `None` unless all five are known.
    pub fn states(&self) -> Vec<Option<FingerSet>> {
        let all = |sample: &PerFinger<Option<bool>>| {
            let known = PerFinger::try_from_fn(|finger| sample[finger].ok_or(()));
            known.ok().map(FingerSet::of)
        };
        self.samples.iter().map(all).collect()
    }

    /// The series without changes that last less than `min_duration_s`, in contact or out of it, as a
    /// switch is debounced: a change counts only if the new value then stays for that long; until then
    /// the old one goes on. What is known stays known.
    ///
    /// The first value after missing samples is taken as it is, and so is a last one before missing
    /// samples or the end, since it may have gone on. 0 changes nothing. Distances that hover about the
    /// threshold make and break contacts at every sample without it.
    ///
    /// # Errors
    ///
    /// [`ContactError::Duration`] for a duration that is negative or not finite.
    pub fn debounced(&self, min_duration_s: f64) -> Result<ContactSeries, ContactError> {
        let least = self.samples_in("min_duration_s", min_duration_s)?;
        let mut steady = self.clone();
        for finger in Finger::ALL {
            let runs = runs(self.samples.iter().map(|sample| sample[finger]));
            let mut held = None;
            for (k, (value, range)) in runs.iter().enumerate() {
                let is_last = runs.get(k + 1).is_none_or(|(next, _)| next.is_none());
                if held.is_none() || value.is_none() || is_last || range.len() >= least {
                    held = *value;
                }
                for sample in &mut steady.samples[range.clone()] {
                    sample[finger] = held;
                }
            }
        }
        Ok(steady)
    }

    /// The contacts of a finger.
    pub fn finger(&self, finger: Finger) -> FingerContacts {
        let runs = runs(self.samples.iter().map(|sample| sample[finger]));
        let is_off = |k: Option<usize>| {
            k.and_then(|k| runs.get(k))
                .is_some_and(|(value, _)| *value == Some(false))
        };
        let mut found = FingerContacts::default();
        for (k, (value, samples)) in runs.iter().enumerate() {
            let Some(touches) = value else { continue };
            found.known += samples.len();
            if !touches {
                continue;
            }
            found.touching += samples.len();
            let (made, broken) = (is_off(k.checked_sub(1)), is_off(Some(k + 1)));
            found.makes += usize::from(made);
            found.breaks += usize::from(broken);
            found.contacts.push(Contact {
                samples: samples.clone(),
                made,
                broken,
            });
        }
        found
    }

    /// Durations of the contacts of a finger of this series.
    pub fn durations_s(&self, finger: &FingerContacts) -> Durations {
        let mut durations = Durations::default();
        for contact in &finger.contacts {
            let duration_s = contact.samples.len() as f64 / self.rate_hz;
            if contact.is_complete() {
                durations.complete.push(duration_s);
            } else {
                durations.censored.push(duration_s);
            }
        }
        durations
    }

    /// States of contact with their transitions.
    pub fn state_table(&self) -> States {
        let runs = runs(self.states().into_iter());
        let known = |k: Option<usize>| k.and_then(|k| runs.get(k)).and_then(|(state, _)| *state);
        let mut table = States::default();
        for (k, (state, samples)) in runs.iter().enumerate() {
            let Some(state) = *state else { continue };
            *table.samples.entry(state).or_default() += samples.len();
            table.by_fingers[state.len()] += samples.len();
            let next = known(Some(k + 1));
            if let Some(next) = next {
                *table.transitions.entry((state, next)).or_default() += 1;
            }
            table.runs.push(StateRun {
                state,
                samples: samples.clone(),
                is_complete: next.is_some() && known(k.checked_sub(1)).is_some(),
            });
        }
        table
    }

    /// The least number of samples that last at least this long.
    pub(crate) fn samples_in(
        &self,
        name: &'static str,
        duration_s: f64,
    ) -> Result<usize, ContactError> {
        if !(duration_s >= 0.0 && duration_s.is_finite()) {
            let found_s = duration_s;
            return Err(ContactError::Duration { name, found_s });
        }
        // 0.03 s at 100 Hz are 3 samples, whatever their product rounds to.
        Ok((duration_s * self.rate_hz - 1e-6).ceil().max(0.0) as usize)
    }
}

/// Stretches of equal values with their samples.
pub(crate) fn runs<T: PartialEq>(values: impl Iterator<Item = T>) -> Vec<(T, Range<usize>)> {
    let mut runs: Vec<(T, Range<usize>)> = Vec::new();
    for (k, value) in values.enumerate() {
        match runs.last_mut() {
            Some((last, range)) if *last == value => range.end = k + 1,
            _ => runs.push((value, k..k + 1)),
        }
    }
    runs
}
