//! The tables of a learning folder, made from takes, a few at a time.

use std::path::{Path, PathBuf};

use inhand_dictionary::{NmfProblem, blocks};
use inhand_model::{BodySource, Clock, InputHash, Motion, Protocol, SegmentLayout};
use inhand_motion::{Cut, SegmentTable};
use inhand_parallel::{try_map, try_up_to};
use inhand_session::steps::{self, Shown};
use inhand_session::{
    Located as _, Role, SessionError, Settings, TOOL, Take, check_rates, read_clean,
};

use crate::folder::{FORMAT, LearningFolder, LearningPlan, PlannedTake, table_path};
use crate::tables::{TableColumns, read_table, write_table};

/// Facts about a take whose table is written.
struct Gathered {
    planned: PlannedTake,
    path: PathBuf,
    clock: Clock,
    /// Samples at which the object is known; `None` where it is not tracked.
    object_known: Option<usize>,
    shown: Shown,
}

/// Source of the motions of takes.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Processing {
    /// As an earlier step stored them.
    Stored,
    /// Each by itself.
    Each,
    /// All together: marker clusters have one template for the session.
    Together,
}

/// Reads takes and begins a run of learning in a folder: tables, problem, the first state. Takes with
/// processed channels are used as they are where all have them by these settings; others are
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
    seen: &mut dyn FnMut(&Take),
) -> Result<LearningFolder, SessionError> {
    settings.validate()?;
    let mut told = 0;
    let mut gathered = None;
    for way in [Processing::Stored, Processing::Each, Processing::Together] {
        let mut number = 0;
        let mut once = |take: &Take| {
            number += 1;
            if number > told {
                told = number;
                seen(take);
            }
        };
        gathered = gather(root, takes, settings, way, &mut once)?;
        if gathered.is_some() {
            break;
        }
    }
    begin(root, &gathered.unwrap_or_default(), settings)
}

/// Writes the tables of all takes; `None` where another way of processing is needed.
fn gather(
    root: &Path,
    paths: &[PathBuf],
    settings: &Settings,
    way: Processing,
    seen: &mut dyn FnMut(&Take),
) -> Result<Option<Vec<Gathered>>, SessionError> {
    let together = match way {
        Processing::Together => paths.len(),
        _ => rayon::current_num_threads(),
    };
    let mut gathered: Vec<Gathered> = Vec::with_capacity(paths.len());
    let mut used = steps::Tally::new(settings)?;
    for paths in paths.chunks(together.max(1)) {
        let takes = try_map(paths, |path| read_clean(path, settings))?;
        takes.iter().for_each(&mut *seen);
        takes.iter().for_each(|take| used.add(take));
        let files: Vec<_> = (takes.iter().map(|take| take.hash.clone()))
            .zip(paths)
            .collect();
        let Some((held_out, stored)) = motions(takes, settings, way)? else {
            return Ok(None);
        };
        let first = gathered.len();
        write_tables(root, first, Protocol::HeldOut, &held_out)?;
        let published = match stored {
            Some(stored) => stored,
            None => steps::smooth_motions(held_out, settings)?,
        };
        write_tables(root, first, Protocol::Published, &published)?;
        let files = files.into_iter().zip(&published);
        gathered.extend(files.map(|((file, path), motion)| Gathered::new(file, path, motion)));
        check_rates(
            gathered
                .iter()
                .map(|take| (take.path.as_path(), take.clock)),
        )?;
    }
    used.finish()?;
    Ok(Some(gathered))
}

/// Motions before the filter, and after it where they are stored.
type Motions = (Vec<Motion>, Option<Vec<Motion>>);

/// Motions of some takes; `None` where they need another way of processing. The takes themselves are not held any longer.
fn motions(
    mut takes: Vec<Take>,
    settings: &Settings,
    way: Processing,
) -> Result<Option<Motions>, SessionError> {
    let clusters = |take: &Take| {
        take.roles.as_ref().is_ok_and(|roles| {
            std::iter::once(&roles.hand)
                .chain(&roles.object)
                .any(|body| matches!(body, BodySource::Markers(_)))
        })
    };
    match way {
        Processing::Stored => {
            let stored = steps::stored_motions(&mut takes, settings)?;
            Ok(stored.map(|motions| (motions.held_out, Some(motions.published))))
        }
        Processing::Each if takes.iter().any(clusters) => Ok(None),
        Processing::Each | Processing::Together => {
            let motions = steps::motions_in_hand(&takes, &|_| true, settings)?;
            Ok(Some((motions, None)))
        }
    }
}

fn write_tables(
    root: &Path,
    first: usize,
    protocol: Protocol,
    motions: &[Motion],
) -> Result<(), SessionError> {
    try_up_to(motions.len(), |i| {
        let number = first + i;
        let table = SegmentTable::from_motion(&motions[i]);
        write_table(&table_path(root, number, protocol), number, &table)
    })?;
    Ok(())
}

impl Gathered {
    fn new(file: InputHash, path: &Path, motion: &Motion) -> Self {
        let object = motion.object.as_ref();
        Self {
            planned: PlannedTake {
                file,
                samples: motion.len(),
                segments: 0,
                held_out_segments: 0,
            },
            path: path.to_owned(),
            clock: motion.clock,
            object_known: object.map(|track| track.iter().flatten().count()),
            shown: Shown::of(motion),
        }
    }
}

fn begin(
    root: &Path,
    gathered: &[Gathered],
    settings: &Settings,
) -> Result<LearningFolder, SessionError> {
    let rate_hz = (gathered.first()).map_or(1.0, |take| take.clock.rate_hz());
    let known = (gathered.iter()).map(|take| {
        (
            take.planned.file.name.as_str(),
            take.object_known,
            take.planned.samples,
        )
    });
    let layout = SegmentLayout {
        object: steps::object_in_segments(known, settings)?,
        ..SegmentLayout::one_second(rate_hz)
    };
    let starts = |protocol| -> Result<_, SessionError> {
        let cut = Cut::new(&steps::cut_settings(
            layout,
            (Role::Train, protocol),
            settings,
        ))
        .during("processing training takes")?;
        try_up_to(gathered.len(), |i| {
            Ok(cut.starts(&read_table(&table_path(root, i, protocol), i)?))
        })
    };
    let cuts = starts(Protocol::Published)?;
    let held_out = starts(Protocol::HeldOut)?;
    let takes = (gathered.iter().enumerate()).map(|(i, take)| PlannedTake {
        segments: cuts[i].starts.len(),
        held_out_segments: held_out[i].starts.len(),
        ..take.planned.clone()
    });
    let segments = cuts.iter().map(|cut| cut.starts.len()).sum();
    let plan = LearningPlan {
        format: FORMAT,
        tool: TOOL.to_owned(),
        layout,
        segments,
        left_out: cuts.iter().map(|cut| cut.left_out).sum(),
        blocks: blocks(segments),
        takes: takes.collect(),
        settings: settings.clone(),
    };
    let folder = LearningFolder::begin(root, plan);
    let columns = TableColumns::new(&folder)?;
    let problem =
        NmfProblem::new(&columns, &steps::nmf_settings(segments, settings)).during("learning")?;
    let mut shown = Shown::default();
    for take in gathered {
        shown.add(&take.shown);
    }
    let demonstrated = shown.demonstrated()?;
    folder.write_problem(&problem, &demonstrated)?;
    folder.commit()?;
    Ok(folder)
}
