//! Data of the report's figures beside the numbers of an evaluation.
//!
//! `segments` (usual and worst segments), `learned` (hulls, primitives, explained
//! variance), `clouds` (distances to clouds of points).

mod clouds;
mod learned;
mod segments;

use inhand_inspection::{Smoothing, take_gaps};
use inhand_model::{Dictionary, EvaluationRows, Illustrations, Motion, Segments};

use super::{Generated, TakeResult};
use crate::error::SessionError;
use crate::settings::Settings;

/// What illustrations are taken from: what a run has at its end.
#[derive(Clone, Copy, Debug)]
pub struct Illustrated<'a> {
    /// All takes, in the session's order.
    pub takes: &'a [TakeResult<'a>],
    /// Segments that the dictionary was learned from.
    pub train: &'a Segments,
    /// Segments that methods planned.
    pub test: &'a Segments,
    /// The takes those were cut from.
    pub test_motions: &'a [&'a Motion],
    /// The dictionary.
    pub dictionary: &'a Dictionary,
    /// Methods, the default one first.
    pub generated: &'a [Generated],
    /// Their errors.
    pub rows: &'a EvaluationRows,
    /// What was set.
    pub settings: &'a Settings,
}

/// Takes from a run what figures show. Nothing is random and nothing depends on the number of threads.
///
/// # Errors
///
/// [`SessionError::Settings`] for what the object is, [`SessionError::At`] for segments that teach
/// nothing.
pub fn illustrate(
    run: &Illustrated<'_>,
    smoothing: Smoothing,
) -> Result<Illustrations, SessionError> {
    let (explained, point_clouds) = inhand_parallel::both(
        || learned::explained(run.train, run.dictionary),
        || clouds::point_clouds(run),
    );
    Ok(Illustrations {
        gaps: (run.takes.iter())
            .map(|result| take_gaps(&result.take.name, result.role.name(), result.motion))
            .collect(),
        filtering: smoothing.filtering,
        spectrum: smoothing.spectrum,
        paths: segments::paths(run),
        worst: segments::worst(run),
        hulls: Some(run.dictionary.demonstrated.hulls.clone()),
        primitives: learned::primitives(run.dictionary),
        explained: explained?,
        point_clouds: point_clouds?,
    })
}
