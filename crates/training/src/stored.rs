//! State between rounds, in files.

use inhand_dictionary::{Activations, NmfProblem, NmfState, Node, Sums};
use inhand_model::StopReason;
use inhand_session::SessionError;

use crate::arrays::{self, Array, Arrays};
use crate::folder::LearningFolder;
use crate::rounds::Current;

pub(crate) fn write_state(
    folder: &LearningFolder,
    start: usize,
    state: &NmfState,
) -> Result<(), SessionError> {
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

pub(crate) fn read_state(
    folder: &LearningFolder,
    problem: &NmfProblem,
    start: usize,
    round: usize,
) -> Result<NmfState, SessionError> {
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

pub(crate) fn write_activations(
    folder: &LearningFolder,
    current: &Current,
    block: usize,
    activations: Activations,
) -> Result<(), SessionError> {
    let round = current.state.round;
    let mut arrays = Arrays::default();
    let activations = match activations {
        Activations::F64(values) => Array::F64(values),
        Activations::F32(values) => Array::F32(values),
    };
    arrays.push("activations_m", activations);
    let label = folder.label("activations", current.start, round);
    let path = folder.activations(current.start, round, block);
    arrays::write(&path, &label, &arrays)
}

/// The activations that a block had last.
pub(crate) fn read_activations(
    folder: &LearningFolder,
    current: &Current,
    block: usize,
) -> Result<Activations, SessionError> {
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

/// The activations of a block are those of its last half step: of the round before, except after the
/// round in which learning stopped.
fn round_of_activations(state: &NmfState) -> usize {
    match state.stop {
        Some(_) => state.round,
        None => state.round.saturating_sub(1),
    }
}

pub(crate) fn sums_arrays(nodes: Vec<Node>) -> Arrays {
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

pub(crate) fn sums_nodes(mut arrays: Arrays, problem: &NmfProblem) -> Result<Vec<Node>, String> {
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
