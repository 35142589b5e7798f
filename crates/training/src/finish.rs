//! The dictionary of a run whose rounds are done, and the whole of a run in one process.

use std::time::Instant;

use inhand_dictionary::{LearnError, describe_nmf, learn_nmf, learn_pca, smallest_objective};
use inhand_model::{Demonstrated, Dictionary, DictionaryKind, InputHash, Protocol, Provenance};
use inhand_session::matrices::Given;
use inhand_session::{Located as _, SessionError, provenance, steps};

use crate::folder::LearningFolder;
use crate::rounds::{Progress, Shard, begin_rounds, current, states, stats, update};
use crate::tables::TableColumns;

/// Largest size of all columns that one process holds at once, bytes; beyond it they are read block
/// by block in every round.
const IN_MEMORY_BYTES: usize = 1 << 30;

/// A dictionary that was learned, and how long it took.
#[derive(Clone, Debug)]
pub struct Learned {
    /// The dictionary.
    pub dictionary: Dictionary,
    /// The step that made it.
    pub provenance: Provenance,
    /// Time for the primitives, seconds.
    pub primitives_s: f64,
    /// Time for deviations from the cubic Hermite baseline, and the comparison of methods where that was asked
    /// for, seconds.
    pub deviations_s: f64,
}

/// Makes the dictionary of a run in which every start has stopped.
///
/// # Errors
///
/// [`SessionError::Data`] where rounds are left to do, and for files of another run.
pub fn finish(folder: &LearningFolder) -> Result<Learned, SessionError> {
    let begin = Instant::now();
    let current = current(folder)?;
    let found = current.progress();
    if !found.is_done() {
        return Err(SessionError::data(
            folder.root(),
            format!(
                "start {} of {} is in round {}: run `inhand learn stats` and `inhand learn update` \
                 until learning stops",
                found.start + 1,
                found.starts,
                found.round
            ),
        ));
    }
    let states = states(folder, &current)?;
    let best = smallest_objective(&states);
    let (problem, demonstrated) = folder.problem()?;
    let mut activations = |block| {
        let read = folder.activations(best, &states[best], block);
        read.map_err(LearnError::reading)
    };
    let dictionary = problem
        .finish(&states, demonstrated, &mut activations)
        .during("learning")?;
    with_the_rest(folder, dictionary, begin.elapsed().as_secs_f64())
}

/// Runs all that is left of a run in this process. Where the columns fit into memory and no round was
/// done, rounds are not written; the result has the same bits.
///
/// # Errors
///
/// As [`stats`], [`update`] and [`finish`].
pub fn learn_in(
    folder: &LearningFolder,
    keep_rounds: bool,
    watch: &mut dyn FnMut(&Progress),
) -> Result<Learned, SessionError> {
    let plan = folder.plan();
    let size = 8 * plan.segments * plan.layout.rows();
    let is_nmf = plan.settings.learn.kind == DictionaryKind::Nmf;
    if is_nmf && (keep_rounds || size > IN_MEMORY_BYTES) {
        let begin = Instant::now();
        begin_rounds(folder)?;
        loop {
            let reached = current(folder)?.progress();
            if reached.is_done() {
                break;
            }
            // A start that has stopped has no sums left to form: the update begins the next one.
            if reached.stop.is_none() {
                stats(folder, Shard::WHOLE, &mut || ())?;
            }
            watch(&update(folder, &[])?.measured);
        }
        let rounds_s = begin.elapsed().as_secs_f64();
        let learned = finish(folder)?;
        return Ok(Learned {
            primitives_s: learned.primitives_s + rounds_s,
            ..learned
        });
    }
    let begin = Instant::now();
    let columns = TableColumns::new(folder)?;
    let (problem, demonstrated) = folder.problem()?;
    let dictionary = if is_nmf {
        learn_nmf(&columns, demonstrated, &problem.settings)
    } else {
        learn_pca(&columns, demonstrated, problem.settings.rank)
    }
    .during("learning")?;
    with_the_rest(folder, dictionary, begin.elapsed().as_secs_f64())
}

/// A dictionary of primitives that were learned elsewhere, described by the takes of a folder.
/// `source` is the file they came from.
///
/// # Errors
///
/// [`SessionError::At`] for primitives that do not fit the segments.
pub fn learn_given(
    folder: &LearningFolder,
    given: &Given,
    source: InputHash,
) -> Result<Learned, SessionError> {
    let begin = Instant::now();
    let columns = TableColumns::new(folder)?;
    let (problem, demonstrated) = folder.problem()?;
    let offset_m = given.offset_m.as_ref().ok_or_else(|| {
        SessionError::data(
            &source.name,
            "expected `offset_m` beside the primitives: what was taken off each row of the data \
                  before factorising, metres (a single 0 where nothing was)",
        )
    })?;
    let dictionary = describe_nmf(
        &columns,
        demonstrated,
        &problem.settings,
        &given.primitives,
        offset_m,
    )
    .during("learning")?;
    let mut learned = with_the_rest(folder, dictionary, begin.elapsed().as_secs_f64())?;
    learned.provenance.inputs.push(source);
    Ok(learned)
}

fn with_the_rest(
    folder: &LearningFolder,
    dictionary: Dictionary,
    primitives_s: f64,
) -> Result<Learned, SessionError> {
    let begin = Instant::now();
    let settings = &folder.plan().settings;
    let demonstrated: &Demonstrated = &dictionary.demonstrated;
    // Segments of one protocol at a time: of long takes they are what takes memory.
    let (choice, residual_held_out) = {
        let held_out = TableColumns::under(Protocol::HeldOut, folder)?.demonstrations()?;
        let choice = steps::choice(&held_out, demonstrated, settings)?;
        let some = (!held_out.is_empty()).then(|| steps::deviations(&held_out, settings));
        (choice, some.transpose()?)
    };
    let published = TableColumns::new(folder)?.demonstrations()?;
    Ok(Learned {
        dictionary: Dictionary {
            choice,
            residual: Some(steps::deviations(&published, settings)?),
            residual_held_out,
            ..dictionary
        },
        provenance: provenance(
            "learn",
            settings,
            folder.plan().takes.iter().map(|take| take.file.clone()),
        ),
        primitives_s,
        deviations_s: begin.elapsed().as_secs_f64(),
    })
}
