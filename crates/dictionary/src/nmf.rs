//! Non-negative matrix factorisation of training segments in memory.

use inhand_model::{Demonstrated, Dictionary, DictionaryKind, Learning, Restart, StopReason};
use nalgebra::{DMatrix, DVector};

use crate::block::Block;
use crate::covariance::moments_of;
use crate::data::Columns;
use crate::error::{LearnError, check_setting};
use crate::real::{Activations, Real};
use crate::rounds::{NmfProblem, NmfState, column_squares, unfit_activations};
use crate::settings::{NmfSettings, Precision, Update};
use crate::stability::matched_cosine;
use crate::sums::Tree;

/// Learns a dictionary of non-negative primitives from training segments.
///
/// Problem: with the segments as columns of `V` (rows x n, metres; 15 N rows, with the object 21 N),
/// minimise `1/2 |V - offset - W H|²` (Frobenius, m², over what is not missing) over `W >= 0`
/// (rows x rank) and `H >= 0` (rank x n), plus what the factors cost
/// ([`NmfSettings::primitive_penalty`]). `offset` is each coordinate's training minimum minus
/// [`offset_margin_m`](NmfSettings::offset_margin_m), the same at every sample, so that the shifted
/// data are positive. The object's rotation counts as the length it moves a point at
/// [`ROTATION_LEVER_M`](inhand_model::ROTATION_LEVER_M), so that one objective measures all rows. The
/// columns of `W` come out with unit length, the scale in `H`; the activations described by mean and
/// covariance are those of the last half step, for the very `W` returned.
///
/// Updates: HALS with several sweeps per product with the data (Cichocki and Phan, "Fast local
/// algorithms for large scale nonnegative matrix and tensor factorizations", IEICE Trans. 2009;
/// Gillis and Glineur, "Accelerated multiplicative updates and hierarchical ALS algorithms for
/// nonnegative matrix factorization", Neural Computation 2012), or multiplicative updates (Lee and
/// Seung 2001). The problem is not convex: a seed gives a local minimum, and the iteration limit
/// usually ends learning before that is reached, with
/// [`StopReason::IterationLimit`](inhand_model::StopReason::IterationLimit) in the result.
///
/// Cost of an iteration: about `4 * rows * n * rank` operations in matrix products, in parallel over
/// fixed chunks. On one machine the result has the same bits whatever the number of threads, and
/// those of [rounds](NmfProblem) over the same columns in many processes; between CPUs with and
/// without fused multiply-add the last digits differ.
///
/// The covariance of the activations is always shrunk (Ledoit and Wolf 2004), so that it is positive
/// definite and can be inverted by a planner.
///
/// # Errors
///
/// [`LearnError`] for no segments, rank 0, a rank above the number of segments or of numbers in a
/// segment, a number that is not finite (or, with [`NmfSettings::may_miss`], infinite), a fingertip's
/// coordinate that never changes, a setting out of range.
pub fn learn_nmf(
    segments: &dyn Columns,
    demonstrated: Demonstrated,
    settings: &NmfSettings,
) -> Result<Dictionary, LearnError> {
    let problem = NmfProblem::new(segments, settings)?;
    let mut states = Vec::with_capacity(settings.restarts);
    let mut activations = Vec::new();
    for restart in 0..settings.restarts {
        let seed = settings.seed.wrapping_add(restart as u64);
        let state = problem.start(segments, seed)?;
        let (state, solved) = match settings.precision {
            Precision::F64 => solve::<f64>(&problem, state, segments)?,
            Precision::F32 => solve::<f32>(&problem, state, segments)?,
        };
        states.push(state);
        // They take room: those of the best start so far are kept.
        if smallest_objective(&states) == restart {
            activations = solved;
        }
    }
    problem.finish(&states, demonstrated, &mut |block| {
        Ok(activations[block].clone())
    })
}

/// Sweeps over the activations for primitives that stay as they are.
const GIVEN_SWEEPS: usize = 500;

/// A dictionary of primitives that were learned elsewhere (rows x rank, non-negative): activations,
/// their mean and covariance, and the error are those of these segments. The offset (rows, metres) is
/// what was taken off the data that they were learned from.
///
/// Activations are found by HALS whatever the settings say, block by block, three times over: memory
/// does not depend on the number of segments.
///
/// # Errors
///
/// As [`learn_nmf`]; [`LearnError::Data`] for primitives or an offset of another number of rows than the
/// segments have, and for an offset above the data.
pub fn describe_nmf(
    columns: &dyn Columns,
    demonstrated: Demonstrated,
    settings: &NmfSettings,
    primitives: &DMatrix<f64>,
    offset_m: &DVector<f64>,
) -> Result<Dictionary, LearnError> {
    let mut problem = NmfProblem::new(
        columns,
        &NmfSettings {
            rank: primitives.ncols(),
            update: Update::Hals,
            max_iterations: 0,
            left_out_change: 0.0,
            sweeps: GIVEN_SWEEPS,
            restarts: 1,
            stop_rms_m: None,
            ..settings.clone()
        },
    )?;
    let rows = problem.layout.rows();
    for found in [primitives.nrows(), offset_m.nrows()] {
        if found != rows {
            return Err(LearnError::column_length(rows, found));
        }
    }
    for block in 0..problem.blocks() {
        let columns_m = problem.read_block(columns, block)?;
        for (i, v) in columns_m.iter().enumerate() {
            let row = i % rows;
            if *v < offset_m[row] - GIVEN_SLACK_M {
                return Err(LearnError::Data(format!(
                    "the offset of row {row} is {} m, but a training segment has {v} m there: \
                     non-negative primitives need data above the offset; give the offset that the \
                     primitives were learned with, and takes like those they were learned from",
                    offset_m[row]
                )));
            }
        }
    }
    problem.offset_m = offset_m.as_slice().to_vec();
    let given = NmfState {
        seed: settings.seed,
        primitives: primitives.transpose().as_slice().to_vec(),
        ..NmfState::default()
    };
    let fit = |block: usize| problem.sums(&given, block, problem.read_block(columns, block)?, None);
    let mut sums = Tree::default();
    for block in 0..problem.blocks() {
        sums.push_block(block, fit(block)?.0)?;
    }
    let mut state = given.clone();
    problem.measure(&mut state, &sums.root(problem.blocks())?);
    problem.finish(&[state], demonstrated, &mut |block| Ok(fit(block)?.1))
}

/// Largest distance of data below a given offset, metres: rounding of what other tools wrote.
const GIVEN_SLACK_M: f64 = 1e-6;

/// Index of the smallest last objective; the first of equal ones.
pub fn smallest_objective(states: &[NmfState]) -> usize {
    let last = |state: &NmfState| {
        let last = state.objective_history_m2.last().copied();
        last.unwrap_or(f64::INFINITY)
    };
    (1..states.len()).fold(0, |best, i| {
        if last(&states[i]) < last(&states[best]) {
            i
        } else {
            best
        }
    })
}

/// Rounds with everything in memory, to the last state and the activations of each block. The products
/// with the data that only an update of the primitives needs are formed after it is known that there
/// is one.
fn solve<T: Real>(
    problem: &NmfProblem,
    mut state: NmfState,
    columns: &dyn Columns,
) -> Result<(NmfState, Vec<Activations>), LearnError> {
    let mut blocks: Vec<Block<T>> = (0..problem.blocks())
        .map(|block| Ok(problem.shifted(problem.read_block(columns, block)?)))
        .collect::<Result<_, LearnError>>()?;
    iterate(problem, &mut state, &mut blocks, columns)?;
    let stored = blocks.into_iter().map(|block| T::stored(block.activations));
    Ok((state, stored.collect()))
}

/// Runs rounds until learning stops.
pub(crate) fn iterate<T: Real>(
    problem: &NmfProblem,
    state: &mut NmfState,
    blocks: &mut [Block<T>],
    columns: &dyn Columns,
) -> Result<(), LearnError> {
    loop {
        let basis = problem.basis(state);
        let mut fits = Tree::default();
        for (number, block) in blocks.iter_mut().enumerate() {
            let first = problem.block(number).start;
            fits.push_block(number, problem.fit(state, &basis, first, block))?;
        }
        let sums = fits.root(blocks.len())?;
        let set_aside = |number, block: &Block<T>| {
            problem.set_aside(state, problem.block(number).start, block.count())
        };
        let set_aside: Vec<_> = (0..)
            .zip(&*blocks)
            .map(|(n, block)| set_aside(n, block))
            .collect();
        problem.measure(state, &sums);
        if state.stop.is_some() {
            return Ok(());
        }
        let mut crosses = Tree::default();
        for (number, (block, set_aside)) in blocks.iter().zip(&set_aside).enumerate() {
            crosses.push_block(number, block.cross(problem.settings.rank, set_aside))?;
        }
        let cross_m2 = crosses.root(blocks.len())?;
        *state = problem.step(
            std::mem::take(state),
            &sums.activation_gram_m2,
            &cross_m2,
            columns,
        )?;
    }
}

impl NmfProblem {
    /// Results of several starts compared with the one at `best`; none for a single start.
    fn compare(&self, states: &[NmfState], best: usize) -> Vec<Restart> {
        if states.len() < 2 {
            return Vec::new();
        }
        let kept = self.primitives(&states[best]);
        (states.iter().enumerate())
            .map(|(i, state)| Restart {
                seed: state.seed,
                rms_m: self.rms_m(state),
                objective_m2: state
                    .objective_history_m2
                    .last()
                    .copied()
                    .unwrap_or(f64::NAN),
                matched_cosine: if i == best {
                    1.0
                } else {
                    matched_cosine(&kept, &self.primitives(state))
                },
            })
            .collect()
    }

    /// The dictionary of the best of the starts, all of which have stopped, with its activations block by
    /// block (each is asked for twice).
    ///
    /// # Errors
    ///
    /// Errors of `activations`, and [`LearnError::Data`] for some of another size.
    pub fn finish(
        &self,
        starts: &[NmfState],
        demonstrated: Demonstrated,
        activations: &mut dyn FnMut(usize) -> Result<Activations, LearnError>,
    ) -> Result<Dictionary, LearnError> {
        let best = smallest_objective(starts);
        let state = &starts[best];
        let rank = self.settings.rank;
        if !self.settings.activation_penalty.is_none()
            && state.squared_residual_m2 >= state.squared_norm_m2
        {
            return Err(LearnError::PenaltyOfEverything);
        }
        let lengths = self.lengths(state);
        let moments = moments_of(self.blocks(), rank, |block| {
            let mut values = activations(block)?.to_f64();
            if values.len() != rank * self.block(block).len() {
                return Err(unfit_activations(block, state.round));
            }
            for vector in values.chunks_exact_mut(rank) {
                for (v, length) in vector.iter_mut().zip(&lengths) {
                    *v *= length;
                }
            }
            Ok(values)
        })?;
        Ok(Dictionary {
            kind: DictionaryKind::Nmf,
            layout: self.layout,
            offset_m: DVector::from_vec(self.offset_m.clone()),
            primitives: self.primitives(state),
            activation_mean_m: moments.mean,
            activation_covariance_m2: moments.covariance,
            covariance_shrinkage: moments.shrinkage,
            learning: Learning {
                segments: self.count,
                rms_m: self.rms_m(state),
                relative_error: (state.squared_residual_m2 / state.squared_norm_m2).sqrt(),
                iterations: state.round,
                stop_reason: state.stop.unwrap_or(StopReason::IterationLimit),
                objective_history_m2: state.objective_history_m2.clone(),
                seed: state.seed,
                restarts: self.compare(starts, best),
            },
            demonstrated,
            residual: None,
            residual_held_out: None,
            choice: None,
        })
    }

    /// Root mean square of the error over all numbers that are there, metres.
    pub fn rms_m(&self, state: &NmfState) -> f64 {
        (state.squared_residual_m2 / self.numbers as f64).sqrt()
    }

    /// Length of each primitive.
    fn lengths(&self, state: &NmfState) -> Vec<f64> {
        let squares = column_squares(&state.primitives, self.settings.rank);
        squares.into_iter().map(f64::sqrt).collect()
    }

    /// Primitives of unit length (rows x rank); one that a penalty has emptied stays zero.
    fn primitives(&self, state: &NmfState) -> DMatrix<f64> {
        let (rank, lengths) = (self.settings.rank, self.lengths(state));
        DMatrix::from_fn(self.layout.rows(), rank, |row, j| {
            let v = state.primitives[row * rank + j];
            if lengths[j] > 0.0 { v / lengths[j] } else { v }
        })
    }
}

impl NmfSettings {
    /// Checks the numbers that do not depend on data.
    ///
    /// # Errors
    ///
    /// [`LearnError::Setting`]; [`LearnError::Data`] for a penalty of one factor alone, which the scale
    /// of the other would undo.
    pub fn check(&self) -> Result<(), LearnError> {
        let (h, w) = (self.activation_penalty, self.primitive_penalty);
        let stop_rms_m = self.stop_rms_m.unwrap_or(1.0);
        let weight = |name, found| (name, "a weight of 0 or more", found, 0.0..f64::INFINITY);
        let checks = [
            (
                "relative_change",
                "a number from 0 to below 1",
                self.relative_change,
                0.0..1.0,
            ),
            (
                "left_out_change",
                "a number from 0 to below 1",
                self.left_out_change,
                0.0..1.0,
            ),
            (
                "offset_margin_m",
                "a length of at least 0 m",
                self.offset_margin_m,
                0.0..f64::INFINITY,
            ),
            (
                "stop_rms_m",
                "a length above 0 m",
                stop_rms_m,
                f64::MIN_POSITIVE..f64::INFINITY,
            ),
            (
                "restarts",
                "1 or more",
                self.restarts as f64,
                1.0..f64::INFINITY,
            ),
            weight("activation_penalty.l1", h.l1),
            weight("activation_penalty.l2", h.l2),
            weight("primitive_penalty.l1", w.l1),
            weight("primitive_penalty.l2", w.l2),
        ];
        for (name, expected, found, range) in checks {
            check_setting(range.contains(&found), name, expected, found)?;
        }
        let (penalised, other) = match (h.is_none(), w.is_none()) {
            (false, true) => ("activations", "primitives"),
            (true, false) => ("primitives", "activations"),
            _ => return Ok(()),
        };
        Err(LearnError::Data(format!(
            "{penalised} are penalised and {other} are not: their scale would move to the {other} until \
             the penalty is nothing; penalise both"
        )))
    }
}
