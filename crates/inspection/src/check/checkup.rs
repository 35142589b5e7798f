//! Results of a check of a take.

use std::ops::Range;

use inhand_model::Clock;
use serde::Serialize;

pub use inhand_model::Level;

/// An interval of a take, seconds after its first sample.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Place {
    /// Time of the first sample, seconds.
    pub from_s: f64,
    /// Time of the last sample, seconds.
    pub to_s: f64,
}

/// A number behind a result.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Number {
    /// What it is, with its unit at the end (`longest_s`, `p95_mm`); shares are 0 to 1.
    pub name: &'static str,
    /// The number; NaN where it does not exist.
    pub value: f64,
    /// How many values it rests on.
    pub n: usize,
}

/// Places that a result keeps; numbers count all.
pub const MAX_PLACES: usize = 100;

/// One thing that was looked at.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CheckResult {
    /// What was looked at: a stable word for programs, such as `gaps`.
    pub id: &'static str,
    /// How much it matters.
    pub level: Level,
    /// The marker, body or role; empty for the whole take.
    pub entity: String,
    /// Where, in order of time, at most [`MAX_PLACES`]; empty for the whole take.
    pub places: Vec<Place>,
    /// What was expected.
    pub expected: String,
    /// What was found.
    pub found: String,
    /// What to do about it; empty where there is nothing to do.
    pub advice: String,
    /// The numbers behind it.
    pub numbers: Vec<Number>,
}

/// First words of a result that says nothing either way.
pub(crate) const NO_EVIDENCE: &str = "no evidence";

impl CheckResult {
    /// Whether the data says nothing either way.
    pub(crate) fn is_without_evidence(&self) -> bool {
        self.level == Level::Info && self.found.starts_with(NO_EVIDENCE)
    }

    pub(crate) fn new(id: &'static str, level: Level, entity: impl Into<String>) -> Self {
        Self {
            id,
            level,
            entity: entity.into(),
            places: Vec::new(),
            expected: String::new(),
            found: String::new(),
            advice: String::new(),
            numbers: Vec::new(),
        }
    }

    pub(crate) fn found(mut self, found: impl Into<String>) -> Self {
        self.found = found.into();
        self
    }

    pub(crate) fn expected(mut self, expected: impl Into<String>) -> Self {
        self.expected = expected.into();
        self
    }

    pub(crate) fn advice(mut self, advice: impl Into<String>) -> Self {
        self.advice = advice.into();
        self
    }

    pub(crate) fn number(mut self, name: &'static str, value: f64, n: usize) -> Self {
        self.numbers.push(Number { name, value, n });
        self
    }

    pub(crate) fn at(mut self, clock: &Clock, ranges: &[Range<usize>]) -> Self {
        // An empty range is the sample it starts at.
        let place = |range: &Range<usize>| Place {
            from_s: clock.time_s(range.start),
            to_s: clock.time_s(range.end.saturating_sub(1).max(range.start)),
        };
        self.places = ranges.iter().take(MAX_PLACES).map(place).collect();
        self
    }
}

/// How much of a take can be learned from or judged on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SegmentShare {
    /// Segments without a gap.
    pub usable: usize,
    /// Segments that the take would give if nothing were missing.
    pub possible: usize,
}

impl SegmentShare {
    /// Usable over possible, at most 1; 0 where none is possible.
    pub fn share(self) -> f64 {
        if self.possible == 0 {
            return 0.0;
        }
        // After a gap the grid of segments starts again and can fit in one more.
        (self.usable as f64 / self.possible as f64).min(1.0)
    }
}

/// Everything that was looked at in a take.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkup {
    /// The take's name.
    pub take: String,
    /// Format of its source, in words.
    pub format: String,
    /// Samples.
    pub samples: usize,
    /// Samples per second.
    pub rate_hz: f64,
    /// From the first sample to the end of the last, seconds.
    pub duration_s: f64,
    /// Segments; `None` where hand and fingers are not known.
    pub segments: Option<SegmentShare>,
    /// Results, worst first.
    pub results: Vec<CheckResult>,
}

/// What one failed check counts in [`Checkup::score`].
const FAIL_SCORE: f64 = 100.0;
/// What one warning counts.
const WARN_SCORE: f64 = 10.0;
/// What it counts that no segment is usable.
const SEGMENTS_SCORE: f64 = 50.0;

impl Checkup {
    /// The worst level of all results.
    pub fn level(&self) -> Level {
        let levels = self.results.iter().map(|result| result.level);
        levels.max().unwrap_or(Level::Ok)
    }

    /// How many results have a level.
    pub fn count(&self, level: Level) -> usize {
        self.results.iter().filter(|r| r.level == level).count()
    }

    /// How much there is to look at, 0 for nothing: 100 for each failed check, 10 for each warning,
    /// 50 times the share of segments that cannot be used.
    pub fn score(&self) -> f64 {
        let lost = self.segments.map_or(0.0, |segments| 1.0 - segments.share());
        FAIL_SCORE * self.count(Level::Fail) as f64
            + WARN_SCORE * self.count(Level::Warn) as f64
            + SEGMENTS_SCORE * lost
    }

    /// The first result of an id.
    pub fn result(&self, id: &str) -> Option<&CheckResult> {
        self.results.iter().find(|result| result.id == id)
    }
}
