//! The rounds of a run: the work of a shard, and the update from the sums of all shards.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use inhand_dictionary::{NmfProblem, NmfState, Node, Sums, Tree, smallest_objective};
use inhand_model::{DictionaryKind, StopReason};
use inhand_session::{Located as _, SessionError};

use crate::folder::LearningFolder;
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
        match (index.trim().parse(), of.trim().parse()) {
            (Ok(index @ 1..), Ok(of @ ..=MOST_SHARDS)) if index <= of => Ok(Self {
                index: index - 1,
                of,
            }),
            _ => Err(wrong()),
        }
    }
}

/// State of a run.
#[derive(Clone, Debug)]
pub struct Progress {
    /// Which of the random starts, from 0.
    pub start: usize,
    /// Number of starts.
    pub starts: usize,
    /// Iterations done in this start.
    pub round: usize,
    /// Last measured error, root mean square, metres; `None` before the first round.
    pub rms_m: Option<f64>,
    /// Reason why this start stopped, if it did.
    pub stop: Option<StopReason>,
}

impl Progress {
    /// Whether every start has stopped: there is nothing left but [`finish`](super::finish()).
    pub fn is_done(&self) -> bool {
        self.stop.is_some() && self.start + 1 == self.starts
    }
}

/// Result of an update.
#[derive(Clone, Debug)]
pub struct Updated {
    /// State before the update: the round that was measured.
    pub measured: Progress,
    /// State after it.
    pub progress: Progress,
}

/// The latest start of a run and the state of its latest round.
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
    if folder.latest_round(0).is_some() {
        // The last update of a run has none after it that removes what it left when it was killed.
        let current = current(folder)?;
        let is_stopped = current.state.stop.is_some();
        let needed = current.state.round.saturating_sub(usize::from(!is_stopped));
        remove_before(folder, current.start, needed)?;
        return match is_stopped {
            true => begin_next(folder, &current),
            false => Ok(()),
        };
    }
    begin_start(folder, &folder.problem()?.0, 0)
}

fn begin_start(
    folder: &LearningFolder,
    problem: &NmfProblem,
    start: usize,
) -> Result<(), SessionError> {
    let columns = TableColumns::new(folder)?;
    let seed = problem.settings.seed.wrapping_add(start as u64);
    folder.write_state(start, &problem.start(&columns, seed).during("learning")?)
}

/// The latest round of the latest start.
pub(crate) fn current(folder: &LearningFolder) -> Result<Current, SessionError> {
    refuse_pca(folder)?;
    let (problem, _) = folder.problem()?;
    let begun = |start: &usize| folder.latest_round(*start).is_some();
    let start = (0..problem.settings.restarts).rev().find(begun);
    let start = start.unwrap_or(0);
    Ok(Current {
        start,
        state: folder.state(&problem, start)?,
        problem,
    })
}

/// The latest state of each start up to and with the current one.
pub(crate) fn states(
    folder: &LearningFolder,
    current: &Current,
) -> Result<Vec<NmfState>, SessionError> {
    (0..=current.start)
        .map(|start| folder.state(&current.problem, start))
        .collect()
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
    let (start, round) = (current.start, current.state.round);
    let label = ("sums", start, round);
    let path = folder.round(start, round).join(shard.file_name());
    let blocks = shard.blocks(current.problem.blocks());
    let all_there = || {
        let path = |block| folder.activations_path(start, round, block);
        blocks.clone().all(|block| path(block).is_file())
    };
    if path.is_file() && folder.read::<Vec<Node>>(&path, label).is_ok() && all_there() {
        // An earlier call got this far.
        blocks.for_each(|_| tick());
        return Ok(path);
    }
    let tree = shard_sums(folder, &current, &columns, blocks, tick)?;
    folder.write(&path, label, &tree.into_nodes())?;
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
            _ => Some(folder.activations(current.start, &current.state, block)?),
        };
        Ok((columns_m.during("learning")?, previous))
    };
    let mut tree = Tree::default();
    let mut next = blocks.clone().next().map(load).transpose()?;
    for block in blocks.clone() {
        let Some((columns_m, previous)) = next.take() else {
            break;
        };
        let (done, loaded) = inhand_parallel::both(
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
        folder.write_activations(current.start, current.state.round, block, &activations)?;
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
    let round = current.state.round;
    if current.state.stop.is_none() {
        let total = total(folder, &current, sums)?;
        let columns = TableColumns::new(folder)?;
        let before = std::mem::take(&mut current.state);
        let next = current.problem.update(before, &total, &columns);
        current.state = next.during("learning")?;
        folder.write_state(current.start, &current.state)?;
        // What the round read is needed no more, nor what a killed update left behind.
        remove_before(folder, current.start, round)?;
    }
    if current.state.stop.is_some() {
        // Also where a call that was killed left the next start to be begun.
        begin_next(folder, &current)?;
    }
    Ok(Updated {
        measured: Progress {
            round,
            ..current.progress()
        },
        progress: self::current(folder)?.progress(),
    })
}

/// Begins the start after one that has stopped, unless it was the last.
fn begin_next(folder: &LearningFolder, stopped: &Current) -> Result<(), SessionError> {
    // Activations take room: of the starts that have stopped, those of the best are kept.
    let states = states(folder, stopped)?;
    let best = smallest_objective(&states);
    for (start, state) in states
        .iter()
        .enumerate()
        .filter(|(start, _)| *start != best)
    {
        remove(&folder.round(start, state.round).join("activations"))?;
    }
    let next = stopped.start + 1;
    if next < stopped.problem.settings.restarts {
        begin_start(folder, &stopped.problem, next)?;
    }
    Ok(())
}

/// Removes the rounds of a start before one.
fn remove_before(folder: &LearningFolder, start: usize, round: usize) -> Result<(), SessionError> {
    let mut older = folder.rounds(start).filter(|&older| older < round);
    older.try_for_each(|older| remove(&folder.round(start, older)))
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
    let label = ("sums", current.start, current.state.round);
    let mut nodes = Vec::new();
    for path in &files {
        for node in folder.read::<Vec<Node>>(path, label)? {
            if !fits(&node, &current.problem) {
                return Err(SessionError::data(path, "sums of a wrong size"));
            }
            nodes.push((node, path));
        }
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

/// Whether sums are of blocks of the problem, and of its sizes.
fn fits(node: &Node, problem: &NmfProblem) -> bool {
    let (rank, rows) = (problem.settings.rank, problem.layout.rows());
    let sizes = (node.sum.activation_gram_m2.len(), node.sum.cross_m2.len());
    node.level <= 40 && node.index < problem.blocks() && sizes == (rank * rank, rank * rows)
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
