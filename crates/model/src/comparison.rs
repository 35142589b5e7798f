//! Two evaluations side by side.

use crate::finger::Finger;
use crate::intervals::{Bootstrap, Estimate, Measure};
use crate::summary::SettingDifference;

/// One of two evaluations that are compared.
#[derive(Clone, Debug, PartialEq)]
pub struct ComparedSide {
    /// File of the evaluation, as it was given.
    pub file: String,
    /// Session.
    pub session: String,
}

/// How clusters of two evaluations were drawn for intervals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drawn {
    /// Together: both judged the same segments.
    Together,
    /// Apart: they judged different segments.
    Apart,
    /// Not at all: the rows of one of them are not there.
    NotAtAll,
}

/// What two evaluations differ in.
#[derive(Clone, Debug, PartialEq)]
pub struct EvaluationComparison {
    /// What is compared with.
    pub before: ComparedSide,
    /// What is compared.
    pub after: ComparedSide,
    /// How intervals were made.
    pub drawn: Drawn,
    /// Draws and confidence of the intervals.
    pub bootstrap: Bootstrap,
    /// Errors: for each pair of methods all fingers together, then each finger, each in every measure.
    pub errors: Vec<ErrorChange>,
    /// Shares of instants with three or more contacts, for each pair of methods that has an object.
    pub contacts: Vec<ContactChange>,
    /// Settings that differ.
    pub settings: Vec<SettingDifference>,
}

/// A statistic of the error, before and after.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorChange {
    /// Method before.
    pub before_method: String,
    /// Method after.
    pub after_method: String,
    /// The finger; `None` for all of them together.
    pub finger: Option<Finger>,
    /// Which statistic.
    pub measure: Measure,
    /// Before, metres.
    pub before_m: f64,
    /// After, metres.
    pub after_m: f64,
    /// After less before, metres; `None` without rows.
    pub absolute: Option<Estimate>,
    /// That over before, no unit; `None` without rows, or where before is 0.
    pub relative: Option<Estimate>,
}

impl ErrorChange {
    /// After less before, over before; NaN where before is 0.
    pub fn relative_change(&self) -> f64 {
        let change = (self.after_m - self.before_m) / self.before_m.abs();
        if change.is_finite() { change } else { f64::NAN }
    }
}

/// The share of instants with three or more contacts, before and after.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactChange {
    /// Method before.
    pub before_method: String,
    /// Method after.
    pub after_method: String,
    /// Before, 0 to 1.
    pub before: f64,
    /// After.
    pub after: f64,
    /// After less before; `None` without rows.
    pub absolute: Option<Estimate>,
}
