//! Input of a report.

use inhand_model::{Evaluation, EvaluationRows, Illustrations, Provenance};

/// Everything that a report is made from. Without rows or illustrations it has fewer figures.
#[derive(Clone, Copy, Debug)]
pub struct Report<'a> {
    /// The numbers.
    pub evaluation: &'a Evaluation,
    /// The single values behind them.
    pub rows: Option<&'a EvaluationRows>,
    /// Illustrations of takes and training.
    pub illustrations: Option<&'a Illustrations>,
    /// Times of plans, where they are known: they differ from run to run, so not for a page that has to be the same each time.
    pub plan_times: &'a [PlanTimes],
    /// The steps that led here.
    pub provenance: &'a [Provenance],
}

/// Times of single plans of a method.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanTimes {
    /// Method.
    pub method: String,
    /// Plans.
    pub n: usize,
    /// Median, milliseconds.
    pub p50_ms: f64,
    /// 95 % quantile, milliseconds.
    pub p95_ms: f64,
    /// Longest, milliseconds.
    pub max_ms: f64,
}

impl<'a> Report<'a> {
    /// A report of an evaluation alone.
    pub fn new(evaluation: &'a Evaluation, provenance: &'a [Provenance]) -> Self {
        Self {
            evaluation,
            rows: None,
            illustrations: None,
            plan_times: &[],
            provenance,
        }
    }
}
