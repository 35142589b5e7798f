//! The files of a run.

use std::collections::BTreeMap;
use std::path::PathBuf;

use inhand_model::{Hull, MethodRows, MotionRows, PerFinger, PerProtocol, Provenance, Segments};
use inhand_parallel::both;
use inhand_report::Report;

use super::{RunFiles, RunOptions};
use crate::error::SessionError;
use crate::figures::write_figures;
use crate::manifest::PlanMs;
use crate::output;
use crate::settings::Role;
use crate::steps::{Generated, ProtocolRows, TakeResult};
use crate::tables;
use crate::take_file::{self, GeneratedMotion, TakeContents};

/// Writes a recording for each take.
pub(super) fn write_takes(
    results: &[TakeResult<'_>],
    test: &PerProtocol<Segments>,
    (generated, rows): (&PerProtocol<Vec<Generated>>, &[MethodRows]),
    hulls: &PerFinger<Hull>,
    provenance: &Provenance,
    options: &RunOptions,
    files: &RunFiles,
) -> Result<(), SessionError> {
    // Segments count takes among the test takes, results among all takes.
    let mut tests = 0..;
    let indices: Vec<_> = (results.iter())
        .map(|result| (result.role == Role::Test).then(|| tests.next()).flatten())
        .collect();
    inhand_parallel::try_up_to(results.len(), |n| {
        let motion = indices[n].map(|take| GeneratedMotion {
            segments: test.as_ref(),
            take,
            generated: generated.as_ref().map(Vec::as_slice),
            rows,
            hulls,
        });
        let contents = TakeContents {
            take: results[n].take,
            motion: results[n].motion,
            generated: motion,
            made: provenance,
            settings: &options.settings,
        };
        take_file::write(&files.takes[n], &contents, options.view)
    })
    .map(drop)
}

/// Writes the rows, the evaluation, the page and its figures; returns the files of the figures.
pub(super) fn write_reports(
    report: &Report<'_>,
    (rows, with_positions): (PerProtocol<ProtocolRows<'_>>, bool),
    motion: &MotionRows,
    files: &RunFiles,
) -> Result<Vec<PathBuf>, SessionError> {
    let evaluation = report.evaluation;
    let (table, (json, (html, figures))) = both(
        || {
            let session = &evaluation.session.name;
            tables::write_rows(&files.rows, session, rows.published, with_positions)?;
            tables::write_rows(&files.held_out_rows, session, rows.held_out, with_positions)?;
            tables::write_motion_rows(&files.motion, session, motion)
        },
        || {
            both(
                || inhand_report::evaluation_json(evaluation, report.provenance),
                || {
                    both(
                        || inhand_report::html(report),
                        || write_figures(&files.figures, report),
                    )
                },
            )
        },
    );
    table?;
    output::write_text(&files.evaluation, &json?)?;
    output::write_text(&files.report, &html?)?;
    figures
}

/// Times of single plans, each method that plans.
pub(super) fn plan_times(generated: &[Generated]) -> BTreeMap<String, PlanMs> {
    (generated.iter())
        .filter(|g| !g.plan_times.is_empty())
        .map(|g| (g.method.name().to_owned(), PlanMs::new(&g.plan_times)))
        .collect()
}
