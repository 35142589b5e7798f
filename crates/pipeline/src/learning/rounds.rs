//! The rounds of a run: what a shard does, and what becomes of all of them.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use inhand_dictionary::{Activations, NmfProblem, NmfState, Node, Sums, Tree, smallest_objective};
use inhand_model::StopReason;

use super::arrays::{self, Array, Arrays};
use super::folder::LearningFolder;
use super::tables::{TableColumns, activations_array};
use crate::error::PipelineError;
use crate::steps::learn_error;

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
        if index == 0 || index > of {
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
pub(super) struct Current {
    pub(super) start: usize,
    pub(super) problem: NmfProblem,
    pub(super) state: NmfState,
}

impl Current {
    pub(super) fn progress(&self) -> Progress {
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

/// Where a run is.
///
/// # Errors
///
/// [`PipelineError::Learning`] for a folder that cannot be used.
pub(super) fn progress(folder: &LearningFolder) -> Result<Progress, PipelineError> {
    Ok(current(folder)?.progress())
}

/// The latest round of the latest start.
pub(super) fn current(folder: &LearningFolder) -> Result<Current, PipelineError> {
    refuse_pca(folder)?;
    let starts = folder.plan().settings.learn.restarts;
    let start = (0..starts)
        .rev()
        .find(|&start| latest_round(folder, start).is_some());
    at_start(folder, start.unwrap_or(0))
}

/// The latest round of a start.
pub(super) fn at_start(folder: &LearningFolder, start: usize) -> Result<Current, PipelineError> {
    let (problem, _) = folder.read_problem(start)?;
    let round = latest_round(folder, start).unwrap_or(0);
    let state = read_state(folder, &problem, start, round)?;
    Ok(Current {
        start,
        problem,
        state,
    })
}

fn refuse_pca(folder: &LearningFolder) -> Result<(), PipelineError> {
    if folder.plan().settings.learn.kind == "nmf" {
        return Ok(());
    }
    Err(PipelineError::Learning {
        path: folder.root().to_owned(),
        message: "principal components have no rounds: learn them with `inhand learn` in one go"
            .to_owned(),
    })
}

fn latest_round(folder: &LearningFolder, start: usize) -> Option<usize> {
    let entries = std::fs::read_dir(folder.start(start)).ok()?;
    entries
        .flatten()
        .filter_map(|entry| {
            let name = entry.file_name();
            let round = name.to_str()?.strip_prefix("round-")?.parse().ok()?;
            folder.state(start, round).is_file().then_some(round)
        })
        .max()
}

/// The activations of a block are those of its last half step: of the round before, except after the
/// round in which learning stopped.
fn round_of_activations(state: &NmfState) -> usize {
    match state.stop {
        Some(_) => state.round,
        None => state.round.saturating_sub(1),
    }
}

pub(super) fn write_state(
    folder: &LearningFolder,
    start: usize,
    state: &NmfState,
) -> Result<(), PipelineError> {
    let mut arrays = Arrays::default();
    arrays.push_f64("primitives", state.primitives.clone());
    arrays.push_u64("revived", state.revived.iter().copied());
    arrays.push_f64("objective_history_m2", state.objective_history_m2.clone());
    arrays.push_f64("squared_norm_m2", vec![state.squared_norm_m2]);
    arrays.push_f64("squared_residual_m2", vec![state.squared_residual_m2]);
    let stop = state
        .stop
        .and_then(|stop| STOPS.iter().position(|s| *s == stop));
    arrays.push_u64("stop", stop);
    let path = folder.state(start, state.round);
    arrays::write(&path, &folder.label("state", start, state.round), &arrays)
}

/// Reasons to stop by their number in files.
const STOPS: [StopReason; 3] = [
    StopReason::Converged,
    StopReason::TargetReached,
    StopReason::IterationLimit,
];

fn read_state(
    folder: &LearningFolder,
    problem: &NmfProblem,
    start: usize,
    round: usize,
) -> Result<NmfState, PipelineError> {
    let path = folder.state(start, round);
    let mut arrays = arrays::read(&path, &folder.label("state", start, round))?;
    let mut parse = || {
        let primitives = arrays.take_f64("primitives")?;
        let expected = problem.settings.rank * problem.layout.rows();
        if primitives.len() != expected {
            let found = primitives.len();
            return Err(format!(
                "primitives have {found} numbers, expected {expected}"
            ));
        }
        let revived = arrays.take_u64("revived")?;
        if revived.iter().any(|&j| j >= problem.settings.rank) {
            return Err("a primitive that is not there was revived".to_owned());
        }
        let stop = match arrays.take_u64("stop")?.as_slice() {
            [] => None,
            [number] => Some(*STOPS.get(*number).ok_or("an unknown reason to stop")?),
            _ => return Err("more than one reason to stop".to_owned()),
        };
        Ok(NmfState {
            round,
            primitives,
            revived,
            objective_history_m2: arrays.take_f64("objective_history_m2")?,
            squared_norm_m2: arrays.take_number("squared_norm_m2")?,
            squared_residual_m2: arrays.take_number("squared_residual_m2")?,
            stop,
        })
    };
    parse().map_err(LearningFolder::wrong(&path))
}

/// Does a shard's part of the round that the run is in, and returns the file of its sums. `tick` is
/// told after each block.
///
/// # Errors
///
/// [`PipelineError::Learning`] for a run that has stopped, and for files of another run or round.
pub fn stats(
    folder: &LearningFolder,
    shard: Shard,
    tick: &mut dyn FnMut(),
) -> Result<PathBuf, PipelineError> {
    let current = current(folder)?;
    if current.state.stop.is_some() {
        let next = if current.progress().is_done() {
            "write the dictionary with `inhand learn finish`"
        } else {
            "begin the next start with `inhand learn update`"
        };
        return Err(PipelineError::Learning {
            path: folder.root().to_owned(),
            message: format!("this start has stopped: {next}"),
        });
    }
    let columns = TableColumns::new(folder)?;
    let label = folder.label("sums", current.start, current.state.round);
    let path = folder
        .round(current.start, current.state.round)
        .join(shard.file_name());
    let blocks = shard.blocks(current.problem.blocks());
    if path.is_file() && arrays::read(&path, &label).is_ok() {
        // An earlier call got this far; its activations were written before.
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
) -> Result<Tree, PipelineError> {
    let load = |block: usize| -> Result<_, PipelineError> {
        let columns_m = current.problem.read_block(columns, block);
        let previous = match current.state.round {
            0 => None,
            _ => Some(read_activations(folder, current, block)?),
        };
        Ok((columns_m.map_err(learn_error)?, previous))
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
        let (sums, activations) = done.map_err(learn_error)?;
        next = loaded?;
        write_activations(folder, current, block, activations)?;
        tree.push_block(block, sums).map_err(learn_error)?;
        tick();
    }
    Ok(tree)
}

fn write_activations(
    folder: &LearningFolder,
    current: &Current,
    block: usize,
    activations: Activations,
) -> Result<(), PipelineError> {
    let round = current.state.round;
    let mut arrays = Arrays::default();
    arrays.push("activations_m", activations_array(activations));
    let label = folder.label("activations", current.start, round);
    let path = folder.activations(current.start, round, block);
    arrays::write(&path, &label, &arrays)
}

/// The activations that a block had last.
pub(super) fn read_activations(
    folder: &LearningFolder,
    current: &Current,
    block: usize,
) -> Result<Activations, PipelineError> {
    let round = round_of_activations(&current.state);
    let path = folder.activations(current.start, round, block);
    let mut arrays = arrays::read(&path, &folder.label("activations", current.start, round))?;
    match arrays.take("activations_m") {
        Ok(Array::F64(values)) => Ok(Activations::F64(values)),
        Ok(Array::F32(values)) => Ok(Activations::F32(values)),
        _ => Err(LearningFolder::wrong(&path)(
            "there are no activations in it".to_owned(),
        )),
    }
}

/// Adds the sums of all shards, measures the round and writes the state of the next one; where
/// learning stops, marks the round as the last of its start and begins the next start. Sums are those
/// in the round's folder, or the given files.
///
/// # Errors
///
/// [`PipelineError::Learning`] for sums that are missing, there twice, damaged, or of another run or
/// round: which file, and why. Nothing is written then.
pub fn update(folder: &LearningFolder, sums: &[PathBuf]) -> Result<Updated, PipelineError> {
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
        .map_err(learn_error)?;
    write_state(folder, current.start, &current.state)?;
    let measured = Progress {
        round,
        ..current.progress()
    };
    // What the round read is needed no more.
    if let Some(read) = round.checked_sub(1) {
        remove(&folder.round(current.start, read))?;
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
fn begin_next(folder: &LearningFolder, stopped: &Current) -> Result<(), PipelineError> {
    keep_best(folder, stopped.start)?;
    let next = stopped.start + 1;
    if next < stopped.problem.settings.restarts {
        let (problem, _) = folder.read_problem(next)?;
        let columns = TableColumns::new(folder)?;
        let state = problem.start(&columns).map_err(learn_error)?;
        write_state(folder, next, &state)?;
    }
    Ok(())
}

/// Activations take room: of the starts that have stopped, those of the best are kept.
fn keep_best(folder: &LearningFolder, last: usize) -> Result<(), PipelineError> {
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
pub(super) fn best_of(starts: &[Current]) -> usize {
    let states: Vec<_> = (starts.iter())
        .map(|current| (current.problem.settings.seed, &current.state))
        .collect();
    smallest_objective(&states)
}

fn remove(folder: &Path) -> Result<(), PipelineError> {
    match std::fs::remove_dir_all(folder) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(PipelineError::io("remove", folder)(error))
        }
        _ => Ok(()),
    }
}

/// The sums of all shards of the round.
fn total(
    folder: &LearningFolder,
    current: &Current,
    given: &[PathBuf],
) -> Result<Sums, PipelineError> {
    let round = folder.round(current.start, current.state.round);
    let files = if given.is_empty() {
        sums_files(&round)?
    } else {
        given.to_vec()
    };
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
    let incomplete = |expected: usize, place: &Path| PipelineError::Learning {
        path: place.to_owned(),
        message: format!(
            "the sums of round {} go on at another block than {expected} of {}: a shard's file is \
             missing, or shards of different splits are mixed ({} files); run `inhand learn stats` \
             for every shard of one split, and remove the files of others",
            current.state.round,
            current.problem.blocks(),
            files.len()
        ),
    };
    let mut expected = 0;
    for (node, path) in nodes {
        if node.first_block() != expected {
            return Err(incomplete(expected, path));
        }
        expected = (node.index + 1) << node.level;
        tree.push(node).map_err(learn_error)?;
    }
    if expected != current.problem.blocks() {
        return Err(incomplete(expected, &round));
    }
    tree.root(current.problem.blocks()).map_err(learn_error)
}

fn sums_files(round: &Path) -> Result<Vec<PathBuf>, PipelineError> {
    let entries = std::fs::read_dir(round).map_err(PipelineError::io("read", round))?;
    let mut files: Vec<_> = entries
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|e| e == "sums"))
        .collect();
    files.sort();
    Ok(files)
}

fn sums_arrays(nodes: Vec<Node>) -> Arrays {
    let mut arrays = Arrays::default();
    arrays.push_u64("level", nodes.iter().map(|node| node.level as usize));
    arrays.push_u64("index", nodes.iter().map(|node| node.index));
    for (i, node) in nodes.into_iter().enumerate() {
        let sums = node.sum;
        arrays.push_u64(&format!("{i}.count"), [sums.count]);
        let numbers = vec![
            sums.squared_norm_m2,
            sums.squared_residual_m2,
            sums.activation_sum_m,
        ];
        arrays.push_f64(&format!("{i}.numbers"), numbers);
        arrays.push_f64(&format!("{i}.activation_gram_m2"), sums.activation_gram_m2);
        arrays.push_f64(&format!("{i}.cross_m2"), sums.cross_m2);
    }
    arrays
}

fn sums_nodes(mut arrays: Arrays, problem: &NmfProblem) -> Result<Vec<Node>, String> {
    let (rank, rows) = (problem.settings.rank, problem.layout.rows());
    let levels = arrays.take_u64("level")?;
    let indices = arrays.take_u64("index")?;
    let wrong = || "sums of a wrong size".to_owned();
    if levels.len() != indices.len() || levels.iter().any(|level| *level > 40) {
        return Err(wrong());
    }
    let nodes = levels.into_iter().zip(indices).enumerate();
    nodes
        .map(|(i, (level, index))| {
            let numbers = arrays.take_f64(&format!("{i}.numbers"))?;
            let counts = arrays.take_u64(&format!("{i}.count"))?;
            let activation_gram_m2 = arrays.take_f64(&format!("{i}.activation_gram_m2"))?;
            let cross_m2 = arrays.take_f64(&format!("{i}.cross_m2"))?;
            let ([count], &[norm, residual, sum]) = (counts.as_slice(), numbers.as_slice()) else {
                return Err(wrong());
            };
            let sizes = (activation_gram_m2.len(), cross_m2.len());
            if sizes != (rank * rank, rank * rows) || index >= problem.blocks() {
                return Err(wrong());
            }
            Ok(Node {
                level: level as u32,
                index,
                sum: Sums {
                    count: *count,
                    squared_norm_m2: norm,
                    squared_residual_m2: residual,
                    activation_sum_m: sum,
                    activation_gram_m2,
                    cross_m2,
                },
            })
        })
        .collect()
}
