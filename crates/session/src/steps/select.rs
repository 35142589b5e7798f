//! Selection of intervals of takes by their events.

use std::collections::BTreeSet;

use inhand_model::{Motion, Selection};

use crate::error::{SessionError, invalid};
use crate::settings::Settings;
use crate::take::Take;

/// Notes in each motion which of its samples are used.
pub(crate) fn select(
    motions: &mut [Motion],
    takes: &[Take],
    settings: &Settings,
) -> Result<(), SessionError> {
    let selection = settings.selection()?;
    if selection.is_everything() {
        return Ok(());
    }
    for (motion, take) in motions.iter_mut().zip(takes) {
        let events = take.annotations.given();
        motion.selected = Some(selection.samples(&events, motion.clock, motion.len()));
    }
    Ok(())
}

/// How much of some takes a selection uses.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Used {
    /// What is used, seconds.
    pub used_s: f64,
    /// All there is, seconds.
    pub whole_s: f64,
    /// Events with one of the labels.
    pub events: usize,
}

/// Adds up what a selection uses of takes that come one at a time.
#[derive(Debug)]
pub struct Tally {
    selection: Selection,
    used: Used,
    /// Labels of events, for a message where nothing is left.
    labels: BTreeSet<String>,
}

impl Tally {
    /// An empty tally.
    ///
    /// # Errors
    ///
    /// [`SessionError::Settings`] for labels that cannot be parsed.
    pub fn new(settings: &Settings) -> Result<Self, SessionError> {
        Ok(Self {
            selection: settings.selection()?,
            used: Used::default(),
            labels: BTreeSet::new(),
        })
    }

    /// Adds a take.
    pub fn add(&mut self, take: &Take) {
        let (clock, samples) = (take.recording.clock, take.recording.len());
        let events = take.annotations.given();
        let selected = self.selection.samples(&events, clock, samples);
        let used = &mut self.used;
        used.used_s += clock.time_s(selected.iter().map(ExactSizeIterator::len).sum());
        used.whole_s += clock.time_s(samples);
        used.events += (events.iter())
            .filter(|event| labels(&self.selection).any(|label| event.has(label)))
            .count();
        let labels = events.iter().flat_map(|event| &event.labels);
        let labels = labels.map(|(key, value)| format!("{key}={value}"));
        self.labels.extend(labels);
    }

    /// What is used; `None` where everything is.
    ///
    /// # Errors
    ///
    /// As [`used`].
    pub fn finish(self) -> Result<Option<Used>, SessionError> {
        if self.selection.is_everything() {
            return Ok(None);
        }
        if self.used.used_s > 0.0 || self.used.whole_s == 0.0 {
            return Ok(Some(self.used));
        }
        let asked: Vec<String> = labels(&self.selection).map(ToString::to_string).collect();
        Err(invalid(
            "select (--event, --without)",
            "labels that leave something to use",
            &format!(
                "{} in takes with {}",
                asked.join(", "),
                listed(&self.labels)
            ),
        ))
    }
}

/// How much of the takes the settings select; `None` where they select everything.
///
/// # Errors
///
/// [`SessionError::Settings`] where nothing is left, with the labels that there are.
pub fn used<'a>(
    takes: impl IntoIterator<Item = &'a Take>,
    settings: &Settings,
) -> Result<Option<Used>, SessionError> {
    let mut tally = Tally::new(settings)?;
    for take in takes {
        tally.add(take);
    }
    tally.finish()
}

fn labels(selection: &Selection) -> impl Iterator<Item = &inhand_model::Label> {
    selection.with.iter().chain(&selection.without)
}

/// Labels of events, for messages.
fn listed(labels: &BTreeSet<String>) -> String {
    const SHOWN: usize = 20;
    let shown: Vec<&str> = labels.iter().take(SHOWN).map(String::as_str).collect();
    match labels.len() {
        0 => "no labelled event".to_owned(),
        n if n <= SHOWN => shown.join(", "),
        n => format!("{} and {} more", shown.join(", "), n - SHOWN),
    }
}
