//! What a report is made from.

use inhand_model::{Evaluation, EvaluationRows, Illustrations, Provenance};

/// Everything that a report is made from. Without rows or illustrations it has fewer figures.
#[derive(Clone, Copy, Debug)]
pub struct Report<'a> {
    /// The numbers.
    pub evaluation: &'a Evaluation,
    /// The single values behind them.
    pub rows: Option<&'a EvaluationRows>,
    /// What figures show beside the numbers.
    pub illustrations: Option<&'a Illustrations>,
    /// The steps that led here.
    pub provenance: &'a [Provenance],
}

impl<'a> Report<'a> {
    /// A report of an evaluation alone.
    pub fn new(evaluation: &'a Evaluation, provenance: &'a [Provenance]) -> Self {
        Self {
            evaluation,
            rows: None,
            illustrations: None,
            provenance,
        }
    }

    /// With the rows that the evaluation was made from.
    #[must_use]
    pub fn with_rows(self, rows: &'a EvaluationRows) -> Self {
        Self {
            rows: Some(rows),
            ..self
        }
    }

    /// With illustrations.
    #[must_use]
    pub fn with_illustrations(self, illustrations: &'a Illustrations) -> Self {
        Self {
            illustrations: Some(illustrations),
            ..self
        }
    }
}
