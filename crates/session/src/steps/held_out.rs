//! Evaluation under the held-out protocol.

use inhand_model::{
    DeviationFacts, Dictionary, EvaluationRows, HandAndFingers, HeldOutEvaluation, Motion,
    Segments, Statistics,
};

use super::{Generated, cut_settings, evaluate, intervals, measure_recorded};
use crate::error::{Located as _, SessionError};
use crate::settings::{FilterKind, Role, Settings};

/// Methods compared under the held-out protocol, with the rows behind that.
#[derive(Debug)]
pub struct HeldOutResult {
    /// The numbers.
    pub evaluation: HeldOutEvaluation,
    /// Every judged instant.
    pub rows: EvaluationRows,
}

/// Rows of a protocol, and the motion that they compare.
#[derive(Clone, Copy, Debug)]
pub struct ProtocolRows<'a> {
    /// Every judged instant.
    pub rows: &'a EvaluationRows,
    /// The recorded motion.
    pub segments: &'a Segments,
    /// The motion of each method.
    pub generated: &'a [Generated],
}

/// Compares motion that was generated for held-out segments with motion before the filter. Without `tables` the rows are
/// those that [`intervals`] needs.
///
/// # Errors
///
/// As [`measure_recorded`] and [`intervals`].
pub fn held_out(
    test: &Segments,
    motions: &[&Motion],
    dictionary: &Dictionary,
    generated: &[Generated],
    tables: bool,
    settings: &Settings,
) -> Result<HeldOutResult, SessionError> {
    let comparison = measure_recorded(test, motions, dictionary, settings)?;
    let judged = inhand_parallel::map(generated, |generated| {
        let (method, rows) = evaluate(&comparison, generated);
        (method, if tables { rows } else { rows.compared() })
    });
    let (methods, rows): (Vec<_>, Vec<_>) = judged.into_iter().unzip();
    let rows = comparison.into_rows(rows);
    let layout = test.layout();
    let rule = cut_settings(layout, (Role::Test, test.protocol()), settings).ends;
    let intervals = match test.is_empty() {
        true => None,
        false => intervals(&methods, &rows, settings)?,
    };
    let evaluation = HeldOutEvaluation {
        ends_s: settings.segments.ends_s,
        ends_samples: rule
            .samples(layout.rate_hz)
            .during("processing test takes")?,
        segments: test.len(),
        left_out: test.left_out,
        deviation: dictionary
            .residual_held_out
            .as_ref()
            .map(DeviationFacts::new),
        methods,
        intervals,
    };
    Ok(HeldOutResult { evaluation, rows })
}

/// Distance that the filter moves fingertips of published test segments from motion before it; `None` without a filter.
pub fn filter_moves(
    test: &Segments,
    before: &[&Motion],
    settings: &Settings,
) -> Option<HandAndFingers<Statistics>> {
    let filters = settings.process.filter != FilterKind::None;
    filters.then(|| inhand_evaluation::filter_moves(test, before))
}
