//! The files of a run.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use inhand_inspection::Smoothing;
use inhand_model::{Dictionary, PerProtocol, Protocol, Provenance};
use inhand_parallel::both;
use inhand_report::Report;

use super::judge::Judged;
use super::times::Times;
use super::{Cut, RunFiles, RunOptions};
use crate::error::SessionError;
use crate::figures::write_figures;
use crate::manifest::PlanMs;
use crate::output;
use crate::settings::Role;
use crate::steps::{self, Generated, Illustrated, ProtocolRows};
use crate::tables;
use crate::take_file::{self, GeneratedMotion, MotionSource, TakeContents};

/// What a run found.
pub(super) struct Results<'a> {
    pub(super) cut: &'a Cut<'a>,
    pub(super) dictionary: &'a Dictionary,
    pub(super) generated: &'a PerProtocol<Vec<Generated>>,
    pub(super) judged: &'a Judged,
    pub(super) smoothing: Smoothing,
    pub(super) provenance: &'a Provenance,
}

/// Writes a recording for each take that is to be written, but what an earlier run left.
pub(super) fn write_takes(
    run: &Results<'_>,
    options: &RunOptions,
    files: &RunFiles,
) -> Result<(), SessionError> {
    // Segments count takes among the test takes, results among all takes.
    let mut tests = 0..;
    let takes = (run.cut.results.iter())
        .map(|result| {
            (
                result,
                (result.role == Role::Test).then(|| tests.next()).flatten(),
            )
        })
        .filter(|(_, test)| options.scope.train_takes || test.is_some());
    let takes: Vec<_> = takes.zip(&files.takes).collect();
    let compared = run.judged.evaluation.compared();
    let written = (!options.scope.all_methods).then_some(&compared);
    inhand_parallel::try_map(&takes, |((result, test_take), path)| {
        if files.is_kept(path) {
            return Ok(());
        }
        let motion = test_take.map(|take| GeneratedMotion {
            segments: run.cut.test.as_ref(),
            take,
            generated: run.generated.as_ref().map(Vec::as_slice),
            rows: &run.judged.rows.published.methods,
            written,
        });
        let contents = TakeContents {
            take: result.take,
            motion: result.motion,
            hulls: motion.map(|_| &run.dictionary.demonstrated.hulls),
            generated: motion.map(MotionSource::Memory),
            made: run.provenance,
            settings: &options.settings,
        };
        take_file::write(path, &contents, options.scope.views).map(drop)
    })
    .map(drop)
}

/// Writes the rows, the evaluation, the page and its figures; returns the files of the figures.
pub(super) fn write_reports(
    run: &Results<'_>,
    options: &RunOptions,
    files: &RunFiles,
    times: &Times,
) -> Result<Vec<PathBuf>, SessionError> {
    let (cut, evaluation) = (run.cut, &run.judged.evaluation);
    let rows = run.judged.rows.as_ref();
    let illustrated = Illustrated {
        takes: &cut.results,
        train: &cut.train,
        test: &cut.test.published,
        test_motions: &cut.test_motions.published,
        dictionary: run.dictionary,
        generated: &run.generated.published,
        rows: rows.published,
        settings: &options.settings,
    };
    let illustrate = || steps::illustrate(&illustrated, run.smoothing.clone());
    let illustrations = times.time("illustrate", illustrate)?;
    let report = Report {
        rows: Some(rows.published),
        illustrations: Some(&illustrations),
        ..Report::new(evaluation, std::slice::from_ref(run.provenance))
    };
    let of = |protocol| ProtocolRows {
        rows: rows[protocol],
        segments: &cut.test[protocol],
        generated: &run.generated[protocol],
    };
    times.time("report", || {
        let write_rows = |path: &Path, protocol| match files.is_kept(path) {
            true => Ok(()),
            false => {
                tables::write_rows(path, evaluation, of(protocol), options.scope.row_positions)
            }
        };
        let (tables, (json, page)) = both(
            || {
                let (published, held_out) = both(
                    || write_rows(&files.rows, Protocol::Published),
                    || write_rows(&files.held_out_rows, Protocol::HeldOut),
                );
                published.and(held_out)?;
                tables::write_motion_rows(&files.motion, evaluation, &run.judged.motion)
            },
            || {
                both(
                    || inhand_report::evaluation_json(evaluation, report.provenance),
                    || {
                        let (html, figures) = inhand_report::html_and_figures(&report)?;
                        Ok::<_, SessionError>((
                            html,
                            write_figures(&files.figures, &figures, evaluation.key.as_deref())?,
                        ))
                    },
                )
            },
        );
        tables?;
        // The page is the last: it is of the evaluation beside it.
        let (html, figures) = page?;
        output::write_text(&files.evaluation, &json?)?;
        output::write_text(&files.report, &html)?;
        Ok(figures)
    })
}

/// Times of single plans, each method that plans.
pub(super) fn plan_times(generated: &[Generated]) -> BTreeMap<String, PlanMs> {
    (generated.iter())
        .filter(|g| !g.plan_times.is_empty())
        .map(|g| (g.method.name().to_owned(), PlanMs::new(&g.plan_times)))
        .collect()
}
