//! Comparison of generated with recorded motion, both protocols at once.

use inhand_model::{
    Dictionary, Evaluation, EvaluationRows, Intervals, MethodEvaluation, MotionRows, PerProtocol,
    Protocol,
};
use inhand_parallel::both;

use super::Cut;
use super::times::Times;
use crate::error::SessionError;
use crate::settings::Settings;
use crate::steps::{self, Generated, MotionAnalysis};

/// Generated motion compared with the recorded one.
pub(super) struct Judged {
    pub(super) evaluation: Evaluation,
    pub(super) rows: PerProtocol<EvaluationRows>,
    pub(super) motion: MotionRows,
}

/// Judges every method under both protocols. `name` is the session's.
pub(super) fn judge(
    name: &str,
    cut: &Cut<'_>,
    dictionary: &Dictionary,
    generated: &PerProtocol<Vec<Generated>>,
    settings: &Settings,
    times: &Times,
) -> Result<Judged, SessionError> {
    let (test, motions) = (&cut.test.held_out, &cut.test_motions.held_out);
    let (published, held_out) = both(
        || published(cut, dictionary, &generated.published, settings, times),
        || {
            let generated = &generated.held_out;
            let work = || steps::held_out(test, motions, dictionary, generated, true, settings);
            times.time("held_out", work)
        },
    );
    let (published, held_out) = (published?, held_out?);
    let segments = (Some(&cut.train), &cut.test.published);
    let methods = published.methods;
    let mut evaluation =
        steps::assemble(name, &cut.results, segments, dictionary, methods, settings)?;
    evaluation.movement = Some(published.motion.movement);
    evaluation.contacts = published.motion.contacts;
    evaluation.intervals = published.intervals;
    evaluation.held_out = Some(held_out.evaluation);
    evaluation.filter_moves = steps::filter_moves(&cut.test.published, motions, settings);
    Ok(Judged {
        evaluation,
        rows: PerProtocol {
            published: published.rows,
            held_out: held_out.rows,
        },
        motion: published.motion.rows,
    })
}

/// What the published protocol finds.
struct Published {
    methods: Vec<MethodEvaluation>,
    rows: EvaluationRows,
    motion: MotionAnalysis,
    intervals: Option<Intervals>,
}

fn published(
    cut: &Cut<'_>,
    dictionary: &Dictionary,
    generated: &[Generated],
    settings: &Settings,
    times: &Times,
) -> Result<Published, SessionError> {
    let of = Protocol::Published;
    let (test, motions) = (&cut.test[of], &cut.test_motions[of]);
    let comparison = times.time("contacts", || {
        steps::measure_recorded(test, motions, dictionary, settings)
    })?;
    let evaluated = times.time("evaluate", || {
        inhand_parallel::map(generated, |g| steps::evaluate(&comparison, g))
    });
    let (methods, rows): (Vec<_>, Vec<_>) = evaluated.into_iter().unzip();
    let rows = steps::evaluation_rows(&comparison, rows);
    let (motion, intervals) = both(
        || {
            let (rows, train) = (&rows.methods, Some(&cut.train));
            let work = || steps::motion_analysis(&comparison, generated, rows, train, settings);
            times.time("motion", work)
        },
        || times.time("intervals", || steps::intervals(&methods, &rows, settings)),
    );
    let (motion, intervals) = (motion?, intervals?);
    Ok(Published {
        methods,
        rows,
        motion,
        intervals,
    })
}
