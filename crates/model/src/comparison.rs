//! Two evaluations side by side.

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

use crate::finger::Finger;
use crate::intervals::{Bootstrap, Estimate, Measure, finger_or_all};
use crate::summary::SettingDifference;
use crate::units::{Millimetres, Unit};

/// One of two evaluations that are compared.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ComparedSide {
    /// File of the evaluation, as it was given.
    pub file: String,
    /// Session.
    pub session: String,
    /// Whether methods were compared under the held-out protocol.
    pub held_out: bool,
}

/// How clusters of two evaluations were drawn for intervals.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Drawn {
    /// Together: both judged the same segments.
    Together,
    /// Apart: they judged different segments.
    Apart,
    /// Not at all: the rows of one of them are not there.
    NotAtAll,
}

/// What two evaluations differ in.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EvaluationComparison {
    /// What is compared with.
    pub before: ComparedSide,
    /// What is compared.
    pub after: ComparedSide,
    /// How intervals were made.
    #[serde(rename = "segments_drawn")]
    pub drawn: Drawn,
    /// Draws and confidence of the intervals.
    #[serde(flatten, serialize_with = "without_cluster")]
    pub bootstrap: Bootstrap,
    /// What differs in the recorded motion that both are judged against: test files, segments and the settings that
    /// make them. Where there is anything, errors before and after are distances to different motion.
    #[serde(rename = "reference_that_differs", serialize_with = "before_and_after")]
    pub reference: Vec<SettingDifference>,
    /// Errors under the published protocol: for each pair of methods all fingers together, then each finger, each in every measure.
    pub errors: Vec<ErrorChange>,
    /// Shares of instants with three or more contacts, for each pair of methods that has an object.
    pub contacts: Vec<ContactChange>,
    /// The same under the held-out protocol; `None` where one of the two has no such errors.
    pub held_out: Option<HeldOutComparison>,
    /// Settings that differ.
    #[serde(rename = "settings_that_differ", serialize_with = "before_and_after")]
    pub settings: Vec<SettingDifference>,
}

/// What two evaluations differ in under the held-out protocol.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HeldOutComparison {
    /// How intervals were made.
    #[serde(rename = "segments_drawn")]
    pub drawn: Drawn,
    /// Errors, in the order of those under the published protocol.
    pub errors: Vec<ErrorChange>,
    /// Shares of instants with three or more contacts.
    pub contacts: Vec<ContactChange>,
}

/// A statistic of the error, before and after.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ErrorChange {
    /// Method before.
    pub before_method: String,
    /// Method after.
    pub after_method: String,
    /// The finger; `None` for all of them together.
    #[serde(serialize_with = "finger_or_all::serialize")]
    pub finger: Option<Finger>,
    /// Which statistic.
    pub measure: Measure,
    /// Before, metres.
    #[serde(rename = "before_mm", with = "Millimetres")]
    pub before_m: f64,
    /// After, metres.
    #[serde(rename = "after_mm", with = "Millimetres")]
    pub after_m: f64,
    /// After less before, over before; NaN where before is 0.
    pub relative_change: f64,
    /// After less before, metres; `None` without rows.
    #[serde(rename = "absolute_mm", with = "Millimetres")]
    pub absolute: Option<Estimate>,
    /// That over before, no unit; `None` without rows, or where before is 0.
    pub relative: Option<Estimate>,
}

impl ErrorChange {
    /// After less before, over before; NaN where before is 0.
    pub fn relative_change(before_m: f64, after_m: f64) -> f64 {
        let change = (after_m - before_m) / before_m.abs();
        if change.is_finite() { change } else { f64::NAN }
    }
}

/// The share of instants with three or more contacts, before and after.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ContactChange {
    /// Method before.
    pub before_method: String,
    /// Method after.
    pub after_method: String,
    /// Before, 0 to 1.
    #[serde(rename = "three_or_more_before")]
    pub before: f64,
    /// After.
    #[serde(rename = "three_or_more_after")]
    pub after: f64,
    /// After less before; `None` without rows.
    pub absolute: Option<Estimate>,
}

fn without_cluster<S: Serializer>(bootstrap: &Bootstrap, serializer: S) -> Result<S::Ok, S::Error> {
    let mut keys = serializer.serialize_map(None)?;
    keys.serialize_entry("draws", &bootstrap.draws)?;
    keys.serialize_entry("seed", &bootstrap.seed)?;
    keys.serialize_entry("confidence", &bootstrap.confidence)?;
    keys.end()
}

fn before_and_after<S: Serializer>(
    settings: &[SettingDifference],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct Keys<'a> {
        key: &'a str,
        before: &'a str,
        after: &'a str,
    }
    serializer.collect_seq(settings.iter().map(|difference| Keys {
        key: &difference.key,
        before: difference.values.first().map_or("", String::as_str),
        after: difference.values.last().map_or("", String::as_str),
    }))
}
