//! The time line of a trial: where a take begins on it, and the events that its file states.

use std::collections::BTreeMap;

use inhand_model::{Annotations, Clock, Event, Finding, StartTime};

use crate::error::CaptureError;

/// Longest time from the start of a trial to a file's first frame, seconds: no capture lasts a year.
const MAX_OFFSET_S: f64 = 3.2e7;

/// An event as a file states it.
#[derive(Clone, Debug)]
pub(crate) struct TrialEvent {
    /// Seconds since the trial began.
    pub(crate) time_s: f64,
    /// Labels by key; no value is empty.
    pub(crate) labels: BTreeMap<String, String>,
}

/// The first frame of a file.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FirstFrame {
    pub(crate) number: Option<i64>,
    /// Seconds since the trial began, where the file states them.
    pub(crate) time_s: Option<f64>,
    /// Number of a trial's first frame in this format; a file that starts with frame 0 counts from 0.
    pub(crate) counts_from: i64,
}

/// What a take has of its trial.
pub(crate) struct TrialPart {
    /// The clock of the take; that of the trial starts when the trial does.
    pub(crate) clock: Clock,
    pub(crate) annotations: Annotations,
    pub(crate) findings: Vec<Finding>,
}

impl FirstFrame {
    /// Seconds from the start of the trial, and whether the number says so, which is exact where times are rounded. A
    /// time column decides where numbers count from, and counts where it agrees with neither, unless it starts at 0 in
    /// each file.
    fn offset_s(self, rate_hz: f64) -> (f64, bool) {
        let time_s = self.time_s.filter(|time_s| time_s.is_finite());
        let Some(number) = self.number else {
            return (time_s.unwrap_or(0.0), false);
        };
        let first = if number == 0 { 0 } else { self.counts_from };
        let counted = [first, 0, 1].map(|first: i64| (number as f64 - first as f64) / rate_hz);
        let Some(time_s) = time_s else {
            return (counted[0], true);
        };
        let agrees = |offset_s: &f64| (time_s - offset_s).abs() * rate_hz <= 0.5;
        match counted.into_iter().find(agrees) {
            Some(offset_s) => (offset_s, true),
            None if time_s.abs() * rate_hz <= 0.5 => (counted[0], true),
            None => (time_s, false),
        }
    }

    /// The part of a trial that begins with this frame. A trial whose start is unknown leaves it at 0 s.
    pub(crate) fn part(
        self,
        trial: Clock,
        events: &[TrialEvent],
        file: &str,
    ) -> Result<TrialPart, CaptureError> {
        let rate_hz = trial.rate_hz();
        let mut findings = Vec::new();
        let (mut offset_s, by_number) = self.offset_s(rate_hz);
        if offset_s.abs() > MAX_OFFSET_S {
            let message = format!(
                "the first frame is {offset_s:e} s from the start of its trial: taken as the start"
            );
            findings.push(Finding::warning("", message));
            offset_s = 0.0;
        }
        let is_known = trial.start_time() != StartTime::Unknown;
        let on_time_line = |time_s: f64| match is_known {
            true => (trial.start_unix_nanos()).saturating_add_signed((time_s * 1e9).round() as i64),
            false => ((time_s - offset_s) * 1e9).round().max(0.0) as u64,
        };
        let clock = Clock::new(on_time_line(offset_s), trial.start_time(), rate_hz)
            .map_err(|error| CaptureError::in_file(file, error))?;
        // Whether numbers and times count from 0 or 1 means nothing where no start is known.
        let is_one_apart =
            matches!(self.number, Some(0 | 1)) && (offset_s * rate_hz).abs() < 1.5 && !is_known;
        if offset_s != 0.0 && !is_one_apart {
            let first = match self.number.filter(|_| by_number) {
                Some(number) => format!("the first frame is number {number} of its trial"),
                None => format!("the first frame is at {offset_s:.3} s of its trial"),
            };
            let message = match is_known {
                true => format!("{first}: the take starts {offset_s:.3} s after its trial"),
                false => format!("{first}: it is at 0 s here"),
            };
            findings.push(Finding::info("", message));
        }
        let mut annotations = Annotations::default();
        for event in events {
            let time_s = event.time_s;
            if (time_s - offset_s) * rate_hz < -0.5 {
                let names: Vec<&str> = event.labels.values().map(String::as_str).collect();
                let message = format!(
                    "the event {} at {time_s:.3} s is before the first frame, which is at {offset_s:.3} s \
                     of the trial: left out",
                    names.join(", ")
                );
                findings.push(Finding::info("events", message));
                continue;
            }
            let unix_nanos = on_time_line(time_s.max(offset_s));
            annotations.events.push(Event {
                start_unix_nanos: unix_nanos,
                end_unix_nanos: unix_nanos,
                labels: event.labels.clone(),
            });
        }
        Ok(TrialPart {
            clock,
            annotations,
            findings,
        })
    }
}

/// Labels by key, without blank ones.
pub(crate) fn labels<'a>(
    pairs: impl IntoIterator<Item = (&'a str, &'a str)>,
) -> BTreeMap<String, String> {
    let stated = pairs.into_iter().map(|(key, value)| (key, value.trim()));
    let stated = stated.filter(|(_, value)| !value.is_empty());
    stated
        .map(|(key, value)| (key.to_owned(), value.to_owned()))
        .collect()
}
