//! Confidence intervals of an evaluation.

use inhand_evaluation::{Contestant, session_intervals};
use inhand_model::{Bootstrap, Cluster, EvaluationRows, Intervals, MethodEvaluation};

use crate::error::SessionError;
use crate::settings::Settings;

/// Seed of every bootstrap: two evaluations draw the same clusters, so that they can be compared.
pub(crate) const SEED: u64 = 1;

/// Bootstrap intervals over segments, the first method being the one to look at first; `None` where no draws are
/// asked for.
///
/// # Errors
///
/// [`SessionError::At`].
pub fn intervals(
    methods: &[MethodEvaluation],
    rows: &EvaluationRows,
    settings: &Settings,
) -> Result<Option<Intervals>, SessionError> {
    let evaluate = &settings.evaluate;
    if evaluate.draws == 0 {
        return Ok(None);
    }
    let bootstrap = Bootstrap {
        cluster: Cluster::Segment,
        draws: evaluate.draws,
        seed: SEED,
        confidence: evaluate.confidence,
    };
    let contestants: Vec<_> = methods.iter().map(Contestant::new).collect();
    let found = session_intervals(
        rows,
        &contestants,
        methods.first().map_or("", |method| &method.name),
        evaluate.tau_mm / 1e3,
        bootstrap,
    )?;
    Ok(Some(found))
}
