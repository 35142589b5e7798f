//! The rounds of a run: what a shard does, and what becomes of all of them.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use inhand_dictionary::{NmfProblem, NmfState, Sums, Tree, smallest_objective};
use inhand_model::{DictionaryKind, StopReason};
use inhand_session::{Located as _, SessionError};

use crate::arrays;
use crate::folder::LearningFolder;
use crate::stored::{
    read_activations, read_state, sums_arrays, sums_nodes, write_activations, write_state,
};
use crate::tables::TableColumns;

/// Most parts of the work; more have nothing to do.
const MOST_SHARDS: usize = 1_000_000;

/// One of several equal parts of the work: `I/N`, from `1/N` to `N/N`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Which one, from 0.
    index: usize,
    of: usize,
}

impl Shard {
    /// All of the work.
    pub const WHOLE: Self = Self { index: 0, of: 1 };

    /// The blocks of the shard: as many as the others, to one.
    fn blocks(self, blocks: usize) -> std::ops::Range<usize> {
        self.index * blocks / self.of..(self.index + 1) * blocks / self.of
    }

    fn file_name(self) -> String {
        format!("shard-{}-of-{}.sums", self.index + 1, self.of)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("expected I/N with I from 1 to N, such as 1/8, found {text}");
        let (index, of) = text.split_once('/').ok_or_else(wrong)?;
        let (index, of): (usize, usize) = (
            index.trim().parse().map_err(|_| wrong())?,
            of.trim().parse().map_err(|_| wrong())?,
        );
        if index == 0 || index > of || of > MOST_SHARDS {
            return Err(wrong());
        }
        Ok(Self {
            index: index - 1,
            of,
        })
    }
}

/// Where a run is.
#[derive(Clone, Debug)]
pub struct Progress {
    /// Which of the random starts, from 0.
    pub start: usize,
    /// How many there are.
    pub starts: usize,
    /// Iterations done in this start.
    pub round: usize,
    /// Last measured error, root mean square, metres; `None` before the first round.
    pub rms_m: Option<f64>,
    /// Why this start stopped, if it did.
    pub stop: Option<StopReason>,
}

impl Progress {
    /// Whether every start has stopped: there is nothing left but [`finish`](super::finish()).
    pub fn is_done(&self) -> bool {
        self.stop.is_some() && self.start + 1 == self.starts
    }
}

/// What an update gave.
#[derive(Clone, Debug)]
pub struct Updated {
    /// Where the run was: the round that was measured.
    pub measured: Progress,
    /// Where it is.
    pub progress: Progress,
}

/// A start of a run and the state of its latest round.
pub(crate) struct Current {
    pub(crate) start: usize,
    pub(crate) problem: NmfProblem,
    pub(crate) state: NmfState,
}

impl Current {
    pub(crate) fn progress(&self) -> Progress {
        Progress {
            start: self.start,
            starts: self.problem.settings.restarts,
            round: self.state.round,
            rms_m: (!self.state.objective_history_m2.is_empty())
                .then(|| self.problem.rms_m(&self.state)),
            stop: self.state.stop,
        }
    }
}

/// Writes where the primitives of the first start begin, unless that was done.
///
/// # Errors
///
/// [`SessionError`] for a folder that cannot be used or written.
pub fn begin_rounds(folder: &LearningFolder) -> Result<(), SessionError> {
    refuse_pca(folder)?;
    if latest_round(folder, 0).is_some() {
        return Ok(());
    }
    begin_start(folder, 0)
}

fn begin_start(folder: &LearningFolder, start: usize) -> Result<(), SessionError> {
    let (problem, _) = folder.read_problem(start)?;
    let columns = TableColumns::new(folder)?;
    let state = problem.start(&columns).during("learning")?;
    write_state(folder, start, &state)
}

/// Where a run is.
///
/// # Errors
///
/// [`SessionError::Data`] for a folder that cannot be used.
pub(crate) fn progress(folder: &LearningFolder) -> Result<Progress, SessionError> {
    Ok(current(folder)?.progress())
}

/// The latest round of the latest start.
pub(crate) fn current(folder: &LearningFolder) -> Result<Current, SessionError> {
    refuse_pca(folder)?;
    let starts = folder.plan().settings.learn.restarts;
    let start = (0..starts)
        .rev()
        .find(|&start| latest_round(folder, start).is_some());
    at_start(folder, start.unwrap_or(0))
}

/// The latest round of a start.
pub(crate) fn at_start(folder: &LearningFolder, start: usize) -> Result<Current, SessionError> {
    let (problem, _) = folder.read_problem(start)?;
    let round = latest_round(folder, start).unwrap_or(0);
    let state = read_state(folder, &problem, start, round)?;
    Ok(Current {
        start,
        problem,
        state,
    })
}

fn refuse_pca(folder: &LearningFolder) -> Result<(), SessionError> {
    if folder.plan().settings.learn.kind == DictionaryKind::Nmf {
        return Ok(());
    }
    Err(SessionError::data(
        folder.root(),
        "principal components have no rounds: learn them with `inhand learn` in one go",
    ))
}

fn latest_round(folder: &LearningFolder, start: usize) -> Option<usize> {
    rounds(folder, start)
        .filter(|&round| folder.state(start, round).is_file())
        .max()
}

/// Rounds of a start that have a folder.
fn rounds(folder: &LearningFolder, start: usize) -> impl Iterator<Item = usize> {
    let entries = std::fs::read_dir(folder.start(start));
    (entries.into_iter().flatten().flatten()).filter_map(|entry| {
        let name = entry.file_name();
        name.to_str()?.strip_prefix("round-")?.parse().ok()
    })
}

/// Does a shard's part of the round that the run is in, and returns the file of its sums. `tick` is
/// told after each block.
///
/// # Errors
///
/// [`SessionError::Data`] for a run that has stopped, and for files of another run or round.
pub fn stats(
    folder: &LearningFolder,
    shard: Shard,
    tick: &mut dyn FnMut(),
) -> Result<PathBuf, SessionError> {
    let current = current(folder)?;
    if current.state.stop.is_some() {
        let next = if current.progress().is_done() {
            "write the dictionary with `inhand learn finish`"
        } else {
            "begin the next start with `inhand learn update`"
        };
        return Err(SessionError::data(
            folder.root(),
            format!("this start has stopped: {next}"),
        ));
    }
    let columns = TableColumns::new(folder)?;
    let label = folder.label("sums", current.start, current.state.round);
    let path = folder
        .round(current.start, current.state.round)
        .join(shard.file_name());
    let blocks = shard.blocks(current.problem.blocks());
    let all_there = || {
        let activations = |block| folder.activations(current.start, current.state.round, block);
        blocks.clone().all(|block| activations(block).is_file())
    };
    if path.is_file() && arrays::read(&path, &label).is_ok() && all_there() {
        // An earlier call got this far.
        blocks.for_each(|_| tick());
        return Ok(path);
    }
    let tree = shard_sums(folder, &current, &columns, blocks, tick)?;
    arrays::write(&path, &label, &sums_arrays(tree.into_nodes()))?;
    Ok(path)
}

/// Sums over a run of blocks; the next block is read while one is worked on.
fn shard_sums(
    folder: &LearningFolder,
    current: &Current,
    columns: &TableColumns<'_>,
    blocks: std::ops::Range<usize>,
    tick: &mut dyn FnMut(),
) -> Result<Tree, SessionError> {
    let load = |block: usize| -> Result<_, SessionError> {
        let columns_m = current.problem.read_block(columns, block);
        let previous = match current.state.round {
            0 => None,
            _ => Some(read_activations(folder, current, block)?),
        };
        Ok((columns_m.during("learning")?, previous))
    };
    let mut tree = Tree::default();
    let mut next = blocks.clone().next().map(load).transpose()?;
    for block in blocks.clone() {
        let Some((columns_m, previous)) = next.take() else {
            break;
        };
        let (done, loaded) = rayon::join(
            || {
                let (state, problem) = (&current.state, &current.problem);
                problem.sums(state, block, columns_m, previous)
            },
            || {
                (block + 1 < blocks.end)
                    .then(|| load(block + 1))
                    .transpose()
            },
        );
        let (sums, activations) = done.during("learning")?;
        next = loaded?;
        write_activations(folder, current, block, activations)?;
        tree.push_block(block, sums).during("learning")?;
        tick();
    }
    Ok(tree)
}

/// Adds the sums of all shards, measures the round and writes the state of the next one; where
/// learning stops, marks the round as the last of its start and begins the next start. Sums are those
/// in the round's folder, or the given files.
///
/// # Errors
///
/// [`SessionError::Data`] for sums that are missing, there twice, damaged, or of another run or
/// round: which file, and why. Nothing is written then.
pub fn update(folder: &LearningFolder, sums: &[PathBuf]) -> Result<Updated, SessionError> {
    let mut current = current(folder)?;
    if current.state.stop.is_some() {
        // A call that was killed may have left the next start to be begun.
        begin_next(folder, &current)?;
        return Ok(Updated {
            measured: current.progress(),
            progress: progress(folder)?,
        });
    }
    let total = total(folder, &current, sums)?;
    let columns = TableColumns::new(folder)?;
    let round = current.state.round;
    let before = std::mem::take(&mut current.state);
    current.state = (current.problem)
        .update(before, &total, &columns)
        .during("learning")?;
    write_state(folder, current.start, &current.state)?;
    let measured = Progress {
        round,
        ..current.progress()
    };
    // What the round read is needed no more, nor what a killed update left behind.
    for older in rounds(folder, current.start).filter(|&older| older < round) {
        remove(&folder.round(current.start, older))?;
    }
    if current.state.stop.is_some() {
        begin_next(folder, &current)?;
    }
    Ok(Updated {
        measured,
        progress: progress(folder)?,
    })
}

/// Begins the start after one that has stopped, unless it was the last.
fn begin_next(folder: &LearningFolder, stopped: &Current) -> Result<(), SessionError> {
    keep_best(folder, stopped.start)?;
    let next = stopped.start + 1;
    if next < stopped.problem.settings.restarts {
        begin_start(folder, next)?;
    }
    Ok(())
}

/// Activations take room: of the starts that have stopped, those of the best are kept.
fn keep_best(folder: &LearningFolder, last: usize) -> Result<(), SessionError> {
    let starts = (0..=last).map(|start| at_start(folder, start));
    let starts = starts.collect::<Result<Vec<_>, _>>()?;
    let best = best_of(&starts);
    for (start, current) in starts.iter().enumerate() {
        if start != best {
            let round = folder.round(start, current.state.round);
            remove(&round.join("activations"))?;
        }
    }
    Ok(())
}

/// The start with the smallest objective.
pub(crate) fn best_of(starts: &[Current]) -> usize {
    let states: Vec<_> = (starts.iter())
        .map(|current| (current.problem.settings.seed, &current.state))
        .collect();
    smallest_objective(&states)
}

fn remove(folder: &Path) -> Result<(), SessionError> {
    match std::fs::remove_dir_all(folder) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(SessionError::io("remove", folder)(error))
        }
        _ => Ok(()),
    }
}

/// The sums of all shards of the round.
fn total(
    folder: &LearningFolder,
    current: &Current,
    given: &[PathBuf],
) -> Result<Sums, SessionError> {
    let round = folder.round(current.start, current.state.round);
    let files = if given.is_empty() {
        sums_files(&round)?
    } else {
        given.to_vec()
    };
    if files.is_empty() {
        return Err(SessionError::data(
            round,
            format!(
                "there are no sums of round {} yet: run `inhand learn stats` for every shard",
                current.state.round
            ),
        ));
    }
    let label = folder.label("sums", current.start, current.state.round);
    let mut nodes = Vec::new();
    for path in &files {
        let arrays = arrays::read(path, &label)?;
        let parsed = sums_nodes(arrays, &current.problem);
        let parsed = parsed.map_err(LearningFolder::wrong(path))?;
        nodes.extend(parsed.into_iter().map(|node| (node, path)));
    }
    nodes.sort_by_key(|(node, _)| node.first_block());
    let mut tree = Tree::default();
    let incomplete = |expected: usize, place: &Path| {
        SessionError::data(
            place,
            format!(
                "the sums of round {} go on at another block than {expected} of {}: a shard's file is \
             missing, or shards of different splits are mixed ({} files); run `inhand learn stats` \
             for every shard of one split, and remove the files of others",
                current.state.round,
                current.problem.blocks(),
                files.len()
            ),
        )
    };
    let mut expected = 0;
    for (node, path) in nodes {
        if node.first_block() != expected {
            return Err(incomplete(expected, path));
        }
        expected = (node.index + 1) << node.level;
        tree.push(node).during("learning")?;
    }
    if expected != current.problem.blocks() {
        return Err(incomplete(expected, &round));
    }
    tree.root(current.problem.blocks()).during("learning")
}

fn sums_files(round: &Path) -> Result<Vec<PathBuf>, SessionError> {
    if !round.is_dir() {
        return Ok(Vec::new());
    }
    let entries = std::fs::read_dir(round).map_err(SessionError::io("read", round))?;
    let mut files: Vec<_> = entries
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|e| e == "sums"))
        .collect();
    files.sort();
    Ok(files)
}
