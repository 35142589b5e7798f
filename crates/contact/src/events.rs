//! Makes and breaks of contacts, and the states of contact they add up to.
//!
//! A [`ContactSeries`] says at every sample and of every finger whether it touches the object, or that
//! this is not known. What is not known is never guessed: a missing sample ends a contact without
//! counting as a break, and a contact that goes on after it does not count as a make. Such contacts, and
//! those that are there at the first or last sample, are *censored*: they lasted at least as long as was
//! seen.
//!
//! ```
//! use inhand_contact::ContactSeries;
//! use inhand_model::{Finger, PerFinger};
//!
//! // The thumb touches at samples 1 and 2 of 5 and again at the last, the others never, at 100 Hz.
//! let samples = [false, true, true, false, true].map(|thumb| {
//!     PerFinger::from_fn(|finger| Some(finger == Finger::Thumb && thumb))
//! });
//! let series = ContactSeries::new(samples.to_vec(), 100.0)?;
//! let [first, last] = &series.contacts(Finger::Thumb)[..] else { panic!("two contacts") };
//! assert_eq!((first.samples.clone(), first.made, first.broken), (1..3, true, true));
//! assert_eq!((last.samples.clone(), last.made, last.broken), (4..5, true, false));
//! # Ok::<(), inhand_contact::ContactError>(())
//! ```

use std::ops::Range;

use inhand_model::{Finger, FingerSet, PerFinger, StateRow};

use crate::error::ContactError;

/// Whether each finger touches at each sample, `None` where it is not known.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactSeries {
    samples: Vec<PerFinger<Option<bool>>>,
    rate_hz: f64,
}

/// An unbroken range of known samples in which a finger touches.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Contact {
    /// The samples in contact.
    pub samples: Range<usize>,
    /// Whether it was seen to begin: the sample before is known and without contact.
    pub made: bool,
    /// Whether it was seen to end: the sample after is known and without contact.
    pub broken: bool,
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

    /// The contacts of a finger, in order.
    pub fn contacts(&self, finger: Finger) -> Vec<Contact> {
        let runs = runs(self.samples.iter().map(|sample| sample[finger]));
        let is_off = |k: Option<usize>| {
            k.and_then(|k| runs.get(k))
                .is_some_and(|(value, _)| *value == Some(false))
        };
        (runs.iter().enumerate())
            .filter(|(_, (value, _))| *value == Some(true))
            .map(|(k, (_, samples))| Contact {
                samples: samples.clone(),
                made: is_off(k.checked_sub(1)),
                broken: is_off(Some(k + 1)),
            })
            .collect()
    }

    /// The ranges in which the same fingers touch, in order; all five are known throughout.
    pub fn state_runs(&self) -> Vec<StateRow> {
        let runs = runs(self.states().into_iter());
        let is_known = |k: Option<usize>| k.and_then(|k| runs.get(k)?.0).is_some();
        (runs.iter().enumerate())
            .filter_map(|(k, (state, samples))| {
                Some(StateRow {
                    fingers: (*state)?,
                    samples: samples.clone(),
                    complete: is_known(k.checked_sub(1)) && is_known(Some(k + 1)),
                })
            })
            .collect()
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
