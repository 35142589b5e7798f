//! From takes to the tables of a learning folder, a few takes at a time.

use std::path::{Path, PathBuf};

use inhand_dictionary::NmfProblem;
use inhand_model::{BodySource, Motion, SegmentLayout};
use inhand_motion::{Cut, SegmentTable};
use inhand_session::steps::{self, Shown};
use inhand_session::{Located as _, Role, SessionError, Settings, TOOL, Take, read_clean};
use rayon::prelude::*;

use crate::folder::{LearningFolder, LearningPlan, PlannedTake, table_path};
use crate::tables::{TableColumns, read_table, write_table};

/// What is kept of a take once its table is written.
struct Gathered {
    file_name: String,
    sha256: String,
    path: PathBuf,
    samples: usize,
    rate_hz: f64,
    /// Samples at which the object is known; `None` where it is not tracked.
    object_known: Option<usize>,
    shown: Shown,
}

/// How takes turn into motions.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Processing {
    /// As an earlier step stored them.
    Stored,
    /// Each by itself.
    Each,
    /// All together: marker clusters have one template for the session.
    Together,
}

/// Why another way of processing is needed.
enum Stop {
    Instead(Processing),
    Failed(SessionError),
}

impl From<SessionError> for Stop {
    fn from(error: SessionError) -> Self {
        Stop::Failed(error)
    }
}

/// Reads takes and begins a run of learning in a folder: tables, problem, the first state. Takes with
/// processed channels are used as they are where `reuse` says so and all have them; others are
/// processed on the way. `seen` is told of every take that was read.
///
/// Memory: as many takes as there are threads, and a block of columns. Only takes whose bodies are
/// clusters of markers are all held at once, because one template is fitted for all of them; process
/// them first where that is too much.
///
/// # Errors
///
/// [`SessionError`] for a take that cannot be used, takes of different rates, segments that cannot
/// teach. The folder then holds no `learning.json`.
pub fn init(
    root: &Path,
    takes: &[PathBuf],
    settings: &Settings,
    reuse: bool,
    seen: &mut dyn FnMut(&Take),
) -> Result<LearningFolder, SessionError> {
    settings.validate()?;
    let mut way = if reuse {
        Processing::Stored
    } else {
        Processing::Each
    };
    let mut told = 0;
    let gathered = loop {
        let mut number = 0;
        let mut once = |take: &Take| {
            number += 1;
            if number > told {
                told = number;
                seen(take);
            }
        };
        match gather(root, takes, settings, way, &mut once) {
            Ok(gathered) => break gathered,
            Err(Stop::Instead(other)) => way = other,
            Err(Stop::Failed(error)) => return Err(error),
        }
    };
    begin(root, &gathered, settings)
}

fn gather(
    root: &Path,
    paths: &[PathBuf],
    settings: &Settings,
    way: Processing,
    seen: &mut dyn FnMut(&Take),
) -> Result<Vec<Gathered>, Stop> {
    let together = match way {
        Processing::Together => paths.len(),
        _ => rayon::current_num_threads(),
    };
    let mut gathered: Vec<Gathered> = Vec::with_capacity(paths.len());
    let mut used = steps::Tally::new(settings)?;
    for paths in paths.chunks(together.max(1)) {
        let read: Vec<_> = paths
            .par_iter()
            .map(|path| read_clean(path, settings))
            .collect();
        let takes = read.into_iter().collect::<Result<Vec<_>, _>>()?;
        takes.iter().for_each(&mut *seen);
        takes.iter().for_each(|take| used.add(take));
        let motions = motions(&takes, settings, way)?;
        let first = gathered.len();
        let tables: Vec<_> = (takes.par_iter().zip(&motions).enumerate())
            .map(|(i, (take, motion))| gather_one(root, first + i, take, motion))
            .collect();
        for table in tables {
            gathered.push(table?);
        }
        check_rates(&gathered)?;
    }
    used.finish()?;
    Ok(gathered)
}

fn motions(takes: &[Take], settings: &Settings, way: Processing) -> Result<Vec<Motion>, Stop> {
    let clusters = |take: &Take| {
        let bodies = take.roles.as_ref().map(|roles| {
            let object = roles.object.as_ref();
            std::iter::once(&roles.hand)
                .chain(object)
                .any(|body| matches!(body, BodySource::Markers(_)))
        });
        bodies.unwrap_or(false)
    };
    match way {
        Processing::Stored => {
            let stored = takes.iter().map(|take| take.stored_motion.clone());
            let stored: Option<Vec<_>> = stored.collect();
            let mut stored = stored.ok_or(Stop::Instead(Processing::Each))?;
            steps::select(&mut stored, takes, settings)?;
            Ok(stored)
        }
        Processing::Each if takes.iter().any(clusters) => Err(Stop::Instead(Processing::Together)),
        Processing::Each | Processing::Together => Ok(steps::process_takes(takes, settings)?),
    }
}

fn gather_one(
    root: &Path,
    number: usize,
    take: &Take,
    motion: &Motion,
) -> Result<Gathered, SessionError> {
    let table = SegmentTable::of(motion);
    write_table(&table_path(root, number), number, &table)?;
    let object = motion.object.as_ref();
    Ok(Gathered {
        file_name: take.hash.name.clone(),
        sha256: take.hash.sha256.clone(),
        path: take.path.clone(),
        samples: table.len(),
        rate_hz: motion.clock.rate_hz(),
        object_known: object.map(|track| track.iter().flatten().count()),
        shown: Shown::of(motion),
    })
}

fn check_rates(gathered: &[Gathered]) -> Result<(), SessionError> {
    let Some(first) = gathered.first() else {
        return Ok(());
    };
    match (gathered.iter()).find(|take| take.rate_hz != first.rate_hz) {
        None => Ok(()),
        Some(other) => Err(SessionError::data(
            &other.path,
            format!(
                "the take has {} Hz, but {} has {} Hz: training takes need one rate",
                other.rate_hz,
                first.path.display(),
                first.rate_hz
            ),
        )),
    }
}

fn begin(
    root: &Path,
    gathered: &[Gathered],
    settings: &Settings,
) -> Result<LearningFolder, SessionError> {
    let rate_hz = gathered.first().map_or(1.0, |take| take.rate_hz);
    let known =
        (gathered.iter()).map(|take| (take.file_name.as_str(), take.object_known, take.samples));
    let layout = SegmentLayout {
        object: steps::object_in_segments(known, settings)?,
        ..SegmentLayout::one_second(rate_hz)
    };
    let cut = Cut::new(&steps::cut_settings(layout, Role::Train, settings))
        .during("processing training takes")?;
    let cuts: Vec<_> = (0..gathered.len())
        .into_par_iter()
        .map(|i| Ok(cut.starts(&read_table(&table_path(root, i), i)?)))
        .collect();
    let cuts = cuts.into_iter().collect::<Result<Vec<_>, SessionError>>()?;
    let takes = (gathered.iter().zip(&cuts)).map(|(take, cut)| PlannedTake {
        name: take.file_name.clone(),
        sha256: take.sha256.clone(),
        samples: take.samples,
        segments: cut.starts.len(),
    });
    let segments = cuts.iter().map(|cut| cut.starts.len()).sum();
    let mut plan = LearningPlan {
        format: LearningFolder::new_format(),
        tool: TOOL.to_owned(),
        rate_hz,
        samples: layout.samples,
        object: layout.object,
        segments,
        left_out: cuts.iter().map(|cut| cut.left_out).sum(),
        blocks: 0,
        takes: takes.collect(),
        settings: settings.clone(),
    };
    let looked_through = LearningFolder::begin(root, plan.clone());
    let columns = TableColumns::new(&looked_through)?;
    let problem =
        NmfProblem::new(&columns, &steps::nmf_settings(segments, settings)).during("learning")?;
    let mut shown = Shown::default();
    for take in gathered {
        shown.add(&take.shown);
    }
    let demonstrated = shown.demonstrated()?;

    plan.blocks = problem.blocks();
    let folder = LearningFolder::begin(root, plan);
    folder.write_problem(&problem, &demonstrated)?;
    folder.commit()?;
    Ok(folder)
}
