//! Annotations of a take: events on its time line, and facts about the whole.

use std::collections::BTreeMap;
use std::ops::Range;

use crate::clock::Clock;

/// Key of a label that is one word alone: `slip` is short for `label=slip`.
const PLAIN_LABEL: &str = "label";

/// Label of events that inhand found in the motion itself, as against those that people gave: `by=inhand`.
pub const FOUND: (&str, &str) = ("by", "inhand");

/// Something that happened from one instant to another, both inclusive.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Event {
    /// First instant, nanoseconds since 1970-01-01 UTC.
    pub start_unix_nanos: u64,
    /// Last instant, nanoseconds since 1970-01-01 UTC; not before the first.
    pub end_unix_nanos: u64,
    /// Labels by key; no value is empty.
    pub labels: BTreeMap<String, String>,
}

impl Event {
    /// Whether the event carries a label.
    ///
    /// ```
    /// use inhand_model::{Event, Label};
    ///
    /// let slip = Event {
    ///     start_unix_nanos: 0,
    ///     end_unix_nanos: 1,
    ///     labels: [("label".to_owned(), "slip".to_owned())].into(),
    /// };
    /// assert!(slip.has(&"slip".parse().unwrap()));
    /// assert!(slip.has(&"label=slip".parse().unwrap()));
    /// assert!(!slip.has(&Label::new("task", "slip")));
    /// ```
    pub fn has(&self, label: &Label) -> bool {
        self.labels.get(&label.key) == Some(&label.value)
    }

    /// Whether inhand found it: it carries the label [`FOUND`].
    pub fn is_found(&self) -> bool {
        let (key, value) = FOUND;
        self.labels.get(key).is_some_and(|by| by == value)
    }
}

/// A label as people write it: `task=rotate`, or a word alone.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Label {
    /// What it says something about.
    pub key: String,
    /// What it says.
    pub value: String,
}

impl Label {
    /// A label from its parts.
    pub fn new(key: impl Into<String>, value: impl Into<String>) -> Self {
        Self {
            key: key.into(),
            value: value.into(),
        }
    }
}

impl std::fmt::Display for Label {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}={}", self.key, self.value)
    }
}

impl std::str::FromStr for Label {
    type Err = LabelError;

    fn from_str(text: &str) -> Result<Self, LabelError> {
        let (key, value) = text.split_once('=').unwrap_or((PLAIN_LABEL, text));
        let (key, value) = (key.trim(), value.trim());
        if key.is_empty() || value.is_empty() {
            return Err(LabelError {
                found: text.to_owned(),
            });
        }
        Ok(Self::new(key, value))
    }
}

/// Why a text is no label.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "\"{found}\" is no label: expected KEY=VALUE, such as task=rotate, or a word, such as slip"
)]
pub struct LabelError {
    /// The text.
    pub found: String,
}

/// Events of a take and facts about it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Annotations {
    /// Events in the order in which people gave them.
    pub events: Vec<Event>,
    /// Keys of labels in the order in which tables show them; a key of an event that is not listed
    /// comes after those, in alphabetical order.
    pub keys: Vec<String>,
    /// Facts about the whole take, such as `subject`, `object`, `task`.
    pub about: BTreeMap<String, String>,
}

impl Annotations {
    /// Whether nothing is said.
    pub fn is_empty(&self) -> bool {
        self.events.is_empty() && self.about.is_empty()
    }

    /// The events that people gave: data is selected by these alone, so that what an earlier run found changes
    /// nothing.
    pub fn given(&self) -> Vec<Event> {
        let given = self.events.iter().filter(|event| !event.is_found());
        given.cloned().collect()
    }

    /// Keys of all labels, in the order in which tables show them.
    pub fn all_keys(&self) -> Vec<&str> {
        let mut keys: Vec<&str> = self.keys.iter().map(String::as_str).collect();
        let used = self.events.iter().flat_map(|event| event.labels.keys());
        let mut others: Vec<&str> = used.map(String::as_str).collect();
        others.sort_unstable();
        others.dedup();
        others.retain(|key| !keys.contains(key));
        keys.extend(others);
        keys
    }
}

/// Which stretches of a take to use: those of events with one of the labels `with` (everywhere,
/// where there is none), less those of events with one of the labels `without`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Selection {
    /// Labels of events to use.
    pub with: Vec<Label>,
    /// Labels of events to leave out.
    pub without: Vec<Label>,
}

impl Selection {
    /// Whether everything is used.
    pub fn is_everything(&self) -> bool {
        self.with.is_empty() && self.without.is_empty()
    }

    /// The stretches of time that are used, `start..end` in nanoseconds since 1970-01-01 UTC, end
    /// exclusive, in order, not touching each other.
    pub fn intervals(&self, events: &[Event]) -> Vec<Range<u64>> {
        let of = |labels: &[Label]| {
            let chosen = events.iter().filter(|e| labels.iter().any(|l| e.has(l)));
            union(chosen.map(|e| e.start_unix_nanos..e.end_unix_nanos.saturating_add(1)))
        };
        let used = if self.with.is_empty() {
            std::iter::once(0..u64::MAX).collect()
        } else {
            of(&self.with)
        };
        less(&used, &of(&self.without))
    }

    /// The samples that are used of a take of `samples` samples.
    pub fn samples(&self, events: &[Event], clock: Clock, samples: usize) -> Vec<Range<usize>> {
        // The first sample not before an instant; times of samples rise with their number.
        let first_from = |unix_nanos: u64| {
            let mut range = 0..samples;
            while !range.is_empty() {
                let middle = range.start + range.len() / 2;
                if clock.unix_nanos(middle) < unix_nanos {
                    range.start = middle + 1;
                } else {
                    range.end = middle;
                }
            }
            range.start
        };
        (self.intervals(events).into_iter())
            .map(|time| first_from(time.start)..first_from(time.end))
            .filter(|range| !range.is_empty())
            .collect()
    }
}

/// The intervals joined where they touch or overlap, in order.
fn union(intervals: impl Iterator<Item = Range<u64>>) -> Vec<Range<u64>> {
    let mut intervals: Vec<_> = intervals.filter(|interval| !interval.is_empty()).collect();
    intervals.sort_unstable_by_key(|interval| (interval.start, interval.end));
    let mut joined: Vec<Range<u64>> = Vec::new();
    for interval in intervals {
        match joined.last_mut() {
            Some(last) if interval.start <= last.end => last.end = last.end.max(interval.end),
            _ => joined.push(interval),
        }
    }
    joined
}

/// What is in `whole` but not in `holes`; both in order and not touching.
fn less(whole: &[Range<u64>], holes: &[Range<u64>]) -> Vec<Range<u64>> {
    let mut rest = Vec::new();
    for part in whole {
        let mut start = part.start;
        for hole in (holes.iter()).filter(|h| h.start < part.end && h.end > part.start) {
            if hole.start > start {
                rest.push(start..hole.start);
            }
            start = start.max(hole.end);
        }
        if start < part.end {
            rest.push(start..part.end);
        }
    }
    rest
}

#[cfg(test)]
#[expect(
    clippy::single_range_in_vec_init,
    reason = "one interval is what these lists hold"
)]
mod tests {
    use super::*;
    use crate::clock::StartTime;

    fn event(start: u64, end: u64, label: &str) -> Event {
        let label: Label = label.parse().unwrap();
        Event {
            start_unix_nanos: start,
            end_unix_nanos: end,
            labels: [(label.key, label.value)].into(),
        }
    }

    fn selection(with: &[&str], without: &[&str]) -> Selection {
        let labels = |texts: &[&str]| texts.iter().map(|text| text.parse().unwrap()).collect();
        Selection {
            with: labels(with),
            without: labels(without),
        }
    }

    #[test]
    fn labels_are_pairs_or_words() {
        assert_eq!("task=a=b".parse(), Ok(Label::new("task", "a=b")));
        assert_eq!(" slip ".parse(), Ok(Label::new("label", "slip")));
        for text in ["", "=", "task=", "=rotate", "  "] {
            assert!(text.parse::<Label>().is_err(), "{text:?}");
        }
    }

    #[test]
    fn intervals_are_unions_less_holes() {
        let events = [
            event(10, 19, "task=rotate"),
            event(15, 29, "task=rotate"),
            event(30, 39, "task=lift"),
            event(22, 24, "slip"),
            event(0, 10, "slip"),
        ];
        let of = |with: &[&str], without: &[&str]| selection(with, without).intervals(&events);
        assert_eq!(of(&[], &[]), [0..u64::MAX]);
        assert_eq!(of(&["task=rotate"], &[]), [10..30]);
        assert_eq!(of(&["task=rotate", "task=lift"], &[]), [10..40]);
        assert_eq!(of(&["task=rotate"], &["slip"]), [11..22, 25..30]);
        assert_eq!(of(&[], &["slip"]), [11..22, 25..u64::MAX]);
        assert_eq!(of(&["task=fly"], &[]), []);
        assert_eq!(of(&["slip"], &["task=rotate", "slip"]), []);
    }

    #[test]
    fn samples_lie_inside_both_ends_included() {
        let clock = Clock::new(1_000, StartTime::Stated, 1e8).unwrap(); // a sample every 10 ns
        let samples = |start, end| {
            let events = [event(start, end, "slip")];
            selection(&["slip"], &[]).samples(&events, clock, 10)
        };
        assert_eq!(samples(1_010, 1_030), [1..4]);
        assert_eq!(samples(1_011, 1_029), [2..3]);
        assert_eq!(samples(0, 1_000), [0..1]);
        assert_eq!(samples(1_085, u64::MAX), [9..10]);
        assert_eq!(samples(1_011, 1_019), []);
        assert_eq!(samples(2_000, 3_000), []);
    }

    #[test]
    fn what_was_found_is_not_given() {
        let annotations = Annotations {
            events: vec![event(0, 1, "by=ann"), event(2, 3, "by=inhand")],
            ..Annotations::default()
        };
        assert_eq!(annotations.given(), [event(0, 1, "by=ann")]);
        assert!(annotations.events[1].is_found());
    }

    #[test]
    fn keys_come_in_the_stated_order_first() {
        let annotations = Annotations {
            events: vec![event(0, 1, "b=1"), event(0, 1, "a=1"), event(0, 1, "z=1")],
            keys: vec!["z".to_owned(), "empty".to_owned()],
            about: BTreeMap::new(),
        };
        assert_eq!(annotations.all_keys(), ["z", "empty", "a", "b"]);
    }
}
