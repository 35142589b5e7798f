//! Learning in rounds over blocks.
//!
//! A round takes the primitives, fits the activations of every block to them and forms the sums that
//! the next primitives follow from. Nothing else passes from one round to the next but the
//! primitives and each block's activations, so rounds can run in one process, or block by block in
//! many: [`NmfProblem`] is what all of them know, [`NmfState`] what a round starts from,
//! [`Sums`] what it brings back. [`learn_nmf`](crate::learn_nmf) runs the same steps in memory.

use std::ops::Range;

use inhand_model::{SegmentLayout, StopReason};
use serde::{Deserialize, Serialize};

use crate::block::{BLOCK_COLUMNS, Basis, Block};
use crate::data::{Columns, at_every_sample, check_rank, survey};
use crate::descent::{Gram, descend_all};
use crate::error::LearnError;
use crate::missing::Missing;
use crate::multiplicative;
use crate::product::squared_norm;
use crate::random;
use crate::real::{Activations, Real};
use crate::residual::{Fold, folds};
use crate::settings::{NmfSettings, Penalty, Precision, Update};
use crate::sums::Sums;

/// Error relative to the data, as norms, at which a fit is exact: what is left is rounding, and
/// further iterations would only stir it.
const EXACT_FIT: f64 = 1e-13;

/// Rounds once there is a reason to stop: the first takes left-out segments up, the second has primitives that were
/// learned from them.
const LAST_ROUNDS: usize = 2;

/// A factorisation to be done: what does not change from round to round.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NmfProblem {
    /// Shape of the segments.
    pub layout: SegmentLayout,
    /// Number of segments (n).
    pub count: usize,
    /// Numbers that are there, over all segments.
    pub numbers: usize,
    /// Offset subtracted from each row before factorising, metres.
    pub offset_m: Vec<f64>,
    /// Segments that say when learning stops; `None` where all are learned from from the start.
    pub left_out: Option<LeftOut>,
    /// Settings of the factorisation.
    pub settings: NmfSettings,
}

/// Segments that all rounds but the last ones do not learn from.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct LeftOut {
    /// Segments whose error is measured, ascending; none overlaps another or one that is learned from.
    pub measured: Vec<usize>,
    /// Runs of segments that are not learned from: those and what overlaps them or is of the same takes.
    pub set_aside: Vec<Range<usize>>,
}

impl LeftOut {
    /// The first of the groups that cross-validation would leave out; `None` where that leaves less than
    /// `rank` segments to learn from.
    fn new(columns: &dyn Columns, rank: usize) -> Option<Self> {
        let count = columns.count();
        let origins: Vec<_> = (0..count).map(|segment| columns.origin(segment)).collect();
        let Fold {
            known,
            mut left_out,
        } = folds(&origins, columns.layout().samples)
            .into_iter()
            .next()?;
        (known.len() >= rank).then_some(())?;
        left_out.sort_unstable();
        let mut set_aside = Vec::new();
        let mut next = 0;
        for segment in known.into_iter().chain([count]) {
            if next < segment {
                set_aside.push(next..segment);
            }
            next = segment + 1;
        }
        Some(Self {
            measured: left_out,
            set_aside,
        })
    }
}

/// State at the start of a round, and the history so far.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct NmfState {
    /// Seed of the start.
    pub seed: u64,
    /// Iterations done: updates of the primitives since the start.
    pub round: usize,
    /// Primitives as rows (rank x rows).
    pub primitives: Vec<f64>,
    /// Primitives whose activations are set to zero before this round.
    pub revived: Vec<usize>,
    /// Objective after the start and after each iteration that was measured, m².
    pub objective_history_m2: Vec<f64>,
    /// Squared Frobenius norm of the shifted data, m²; 0 before the first round was measured.
    pub squared_norm_m2: f64,
    /// Squared Frobenius norm of the error that was measured last, m².
    pub squared_residual_m2: f64,
    /// Squared Frobenius norms of the error of left-out segments, one for each round that did not learn from them, m².
    pub left_out_history_m2: Vec<f64>,
    /// Reason to stop, and the round that does: from the round after it was found on, left-out segments are
    /// learned from.
    pub ending: Option<(StopReason, usize)>,
    /// Reason why learning stopped; the primitives are then the result.
    pub stop: Option<StopReason>,
}

/// Number of blocks of so many segments.
pub const fn blocks(segments: usize) -> usize {
    segments.div_ceil(BLOCK_COLUMNS)
}

impl NmfProblem {
    /// Looks through the columns once: whether they can teach, where they lie.
    ///
    /// # Errors
    ///
    /// As [`learn_nmf`](crate::learn_nmf).
    pub fn new(columns: &dyn Columns, settings: &NmfSettings) -> Result<Self, LearnError> {
        settings.check()?;
        let survey = survey(columns, settings.may_miss)?;
        let (layout, count) = (columns.layout(), columns.count());
        let rows = layout.rows();
        check_rank(settings.rank, count.min(rows), count, rows, "nmf")?;
        let lowest: Vec<f64> = (survey.min_m.iter())
            .map(|min| min - settings.offset_margin_m)
            .collect();
        Ok(Self {
            layout,
            count,
            numbers: rows * count - survey.missing,
            offset_m: at_every_sample(layout, &lowest),
            left_out: (settings.left_out_change > 0.0 && settings.max_iterations > LAST_ROUNDS)
                .then(|| LeftOut::new(columns, settings.rank))
                .flatten(),
            settings: settings.clone(),
        })
    }

    /// Number of blocks.
    pub fn blocks(&self) -> usize {
        blocks(self.count)
    }

    /// The segments of a block.
    pub fn block(&self, block: usize) -> std::ops::Range<usize> {
        let first = block * BLOCK_COLUMNS;
        first..(first + BLOCK_COLUMNS).min(self.count)
    }

    /// The columns of a block, metres: what [`sums`](Self::sums) works on.
    ///
    /// # Errors
    ///
    /// Errors of reading them.
    pub fn read_block(&self, columns: &dyn Columns, block: usize) -> Result<Vec<f64>, LearnError> {
        self.read(columns, self.block(block))
    }

    pub(crate) fn read(
        &self,
        columns: &dyn Columns,
        segments: std::ops::Range<usize>,
    ) -> Result<Vec<f64>, LearnError> {
        let mut columns_m = vec![0.0; segments.len() * self.layout.rows()];
        columns.read(segments, &mut columns_m)?;
        Ok(columns_m)
    }

    /// A round over one block: from its columns (of [`read_block`](Self::read_block)) and the
    /// activations of the round before (`None` in the first) to its sums and its new activations.
    ///
    /// # Errors
    ///
    /// [`LearnError::Data`] where the activations are of another block or precision.
    pub fn sums(
        &self,
        state: &NmfState,
        block: usize,
        columns_m: Vec<f64>,
        previous: Option<Activations>,
    ) -> Result<(Sums, Activations), LearnError> {
        match self.settings.precision {
            Precision::F64 => self.sums_of::<f64>(state, block, columns_m, previous),
            Precision::F32 => self.sums_of::<f32>(state, block, columns_m, previous),
        }
        .ok_or_else(|| unfit_activations(block, state.round))
    }

    fn sums_of<T: Real>(
        &self,
        state: &NmfState,
        block: usize,
        columns_m: Vec<f64>,
        previous: Option<Activations>,
    ) -> Option<(Sums, Activations)> {
        let basis = self.basis::<T>(state);
        let mut data = self.shifted(columns_m);
        if previous.is_some() != (state.round > 0) {
            return None;
        }
        if let Some(previous) = previous {
            data.activations = T::restored(previous)?;
            let expected = self.settings.rank * data.count();
            (data.activations.len() == expected).then_some(())?;
        }
        let first = self.block(block).start;
        let mut sums = self.fit(state, &basis, first, &mut data);
        let set_aside = self.set_aside(state, first, data.count());
        sums.cross_m2 = data.cross(self.settings.rank, &set_aside);
        Some((sums, T::stored(data.activations)))
    }

    /// The primitives of a state as a half step over activations needs them.
    pub(crate) fn basis<'a, T: Real>(&self, state: &'a NmfState) -> Basis<'a, T> {
        let penalty = (self.settings.activation_penalty).scaled(self.layout.rows() as f64);
        Basis::new(&state.primitives, self.settings.rank, penalty)
    }

    /// Columns less the offset, with a first guess where they are missing.
    pub(crate) fn shifted<T: Real>(&self, mut columns_m: Vec<f64>) -> Block<T> {
        let rows = self.layout.rows();
        for column in columns_m.chunks_exact_mut(rows) {
            for (v, offset) in column.iter_mut().zip(&self.offset_m) {
                *v -= offset;
            }
        }
        let missing = if self.settings.may_miss {
            let fingers = self.layout.finger_rows();
            let parts = [
                (0..fingers, inhand_model::SEGMENT_COORDINATES),
                (fingers..rows, inhand_model::OBJECT_COORDINATES),
            ];
            Missing::guess(&mut columns_m, rows, &parts)
        } else {
            Missing::default()
        };
        let data = columns_m.into_iter().map(T::of).collect();
        Block::with_missing(data, rows, missing)
    }

    /// A half step over the activations of a block whose first column has the given number.
    pub(crate) fn fit<T: Real>(
        &self,
        state: &NmfState,
        basis: &Basis<'_, T>,
        first: usize,
        block: &mut Block<T>,
    ) -> Sums {
        let settings = &self.settings;
        if state.round == 0 {
            block.start_activations(basis, state.seed, first);
        } else {
            block.clear_activations(&state.revived, settings.rank);
            block.expect_missing(basis);
        }
        let mut sums = block.fit(basis, settings.update, settings.sweeps);
        let set_aside = self.set_aside(state, first, block.count());
        if let Some(left_out) = (self.left_out.as_ref()).filter(|_| !set_aside.is_empty()) {
            let range = first..first + block.count();
            let measured = left_out
                .measured
                .iter()
                .filter(|segment| range.contains(segment));
            let measured: Vec<usize> = measured.map(|segment| segment - first).collect();
            sums.left_out_residual_m2 = block.squared_residual_of(&measured, basis);
            sums.activation_gram_m2 = block.gram(settings.rank, &set_aside);
        }
        sums
    }

    /// Which of some columns from a segment on the round does not learn from.
    pub(crate) fn set_aside(&self, state: &NmfState, first: usize, count: usize) -> Vec<usize> {
        let left_out = self.left_out.iter().filter(|_| state.ending.is_none());
        let runs = left_out.flat_map(|left_out| left_out.set_aside.iter());
        let inside = |run: &Range<usize>| run.start.max(first)..run.end.min(first + count);
        runs.flat_map(inside)
            .map(|segment| segment - first)
            .collect()
    }

    /// Takes what a round brought into the state, and says whether learning goes on.
    pub(crate) fn measure(&self, state: &mut NmfState, sums: &Sums) {
        let settings = &self.settings;
        let activations = (settings.activation_penalty)
            .scaled(self.layout.rows() as f64)
            .of(sums.activation_sum_m, sums.activation_squares_m2);
        let primitives = self.primitive_penalty().of_all(&state.primitives);
        let error = 0.5 * sums.squared_residual_m2;
        let objective = error + activations + primitives;
        let previous = state.objective_history_m2.last().copied();
        state.objective_history_m2.push(objective);
        state.squared_norm_m2 = sums.squared_norm_m2;
        state.squared_residual_m2 = sums.squared_residual_m2;
        let target = (settings.stop_rms_m).map_or(f64::NEG_INFINITY, |rms| {
            0.5 * rms * rms * self.numbers as f64
        });
        if let Some((reason, round)) = state.ending {
            state.stop = (state.round >= round).then_some(reason);
            return;
        }
        let last_rounds = if self.left_out.is_some() {
            LAST_ROUNDS
        } else {
            0
        };
        let no_longer_better = self.left_out.is_some() && self.is_no_longer_better(state, sums);
        let reason = if error <= target {
            Some(StopReason::TargetReached)
        } else if no_longer_better {
            Some(StopReason::NoLongerBetterOnLeftOutTakes)
        } else if previous.is_some_and(|p| p - objective < settings.relative_change * p)
            || error <= 0.5 * EXACT_FIT * EXACT_FIT * sums.squared_norm_m2
        {
            Some(StopReason::Converged)
        } else if state.round + last_rounds >= settings.max_iterations {
            Some(StopReason::IterationLimit)
        } else {
            None
        };
        match self.left_out {
            None => state.stop = reason,
            Some(_) => state.ending = reason.map(|reason| (reason, state.round + last_rounds)),
        }
    }

    /// Whether the error of left-out segments, which this notes, fell by less than the tolerance.
    fn is_no_longer_better(&self, state: &mut NmfState, sums: &Sums) -> bool {
        let (now, before) = (
            sums.left_out_residual_m2,
            state.left_out_history_m2.last().copied(),
        );
        state.left_out_history_m2.push(now);
        let kept = 1.0 - self.settings.left_out_change;
        before.is_some_and(|before| now > kept * kept * before)
    }

    /// From the sums over all blocks to the state of the next round: measures the round, and unless
    /// learning stops there, updates the primitives.
    ///
    /// # Errors
    ///
    /// Errors of reading a training segment that is needed to replace a primitive that has
    /// become zero.
    pub fn update(
        &self,
        mut state: NmfState,
        sums: &Sums,
        columns: &dyn Columns,
    ) -> Result<NmfState, LearnError> {
        self.measure(&mut state, sums);
        if state.stop.is_some() {
            return Ok(state);
        }
        self.step(state, &sums.activation_gram_m2, &sums.cross_m2, columns)
    }

    /// The half step over the primitives.
    pub(crate) fn step(
        &self,
        state: NmfState,
        activation_gram_m2: &[f64],
        cross_m2: &[f64],
        columns: &dyn Columns,
    ) -> Result<NmfState, LearnError> {
        let rank = self.settings.rank;
        let mut primitives = state.primitives;
        self.descend_primitives(
            self.primitive_penalty(),
            activation_gram_m2,
            cross_m2,
            &mut primitives,
        );
        let mut next = NmfState {
            round: state.round + 1,
            revived: Vec::new(),
            primitives,
            ..state
        };
        if self.settings.primitive_penalty.is_none() {
            self.revive(&mut next, rank, columns)?;
        }
        Ok(next)
    }

    fn primitive_penalty(&self) -> Penalty {
        self.settings.primitive_penalty.scaled(self.count as f64)
    }

    /// Descends with the primitives, which cost as much as given.
    pub(crate) fn descend_primitives(
        &self,
        penalty: Penalty,
        activation_gram_m2: &[f64],
        cross_m2: &[f64],
        primitives: &mut [f64],
    ) {
        let NmfSettings {
            rank,
            update,
            sweeps,
            ..
        } = self.settings;
        match update {
            Update::Hals => {
                let gram = Gram::new(activation_gram_m2, rank, penalty.l2);
                // Activations have new primitives to follow; these, averaged over all segments, hardly move.
                let sweeps = sweeps.div_ceil(2);
                descend_all(&gram, cross_m2, penalty.l1, primitives, sweeps);
            }
            Update::Multiplicative => {
                multiplicative::update_all(activation_gram_m2, cross_m2, penalty, primitives, rank);
            }
        }
    }

    /// Replaces primitives that have become zero by a training segment of unit length with activations
    /// zero: the product, and with it the objective, stays as it was, and the next half step is free
    /// to use them. Without this a zero primitive would stay zero for ever, and could not be scaled to
    /// unit length. (Under a penalty zero may be what is wanted, and stays.)
    fn revive(
        &self,
        state: &mut NmfState,
        rank: usize,
        columns: &dyn Columns,
    ) -> Result<(), LearnError> {
        let squares = column_squares(&state.primitives, rank);
        let dead = (0..rank).filter(|&j| !squares[j].is_normal());
        for j in dead {
            let purpose = (state.round - 1) * rank + j;
            let segment = random::drawn_segment(self.count, state.seed, purpose);
            let column = self.shifted::<f64>(self.read(columns, segment..segment + 1)?);
            let norm = squared_norm(&column.data).sqrt();
            for (numbers, v) in (state.primitives.chunks_exact_mut(rank)).zip(&column.data) {
                numbers[j] = if norm > 0.0 {
                    v / norm
                } else {
                    (self.layout.rows() as f64).sqrt().recip()
                };
            }
            state.revived.push(j);
        }
        Ok(())
    }
}

/// An error of activations of another block, round or precision.
pub(crate) fn unfit_activations(block: usize, round: usize) -> LearnError {
    LearnError::Data(format!(
        "activations of block {block} do not fit round {round}: expected those of the round before, \
         none in round 0, in the precision of the run"
    ))
}

/// Sums over the columns of a primitive matrix of rows (rank x rows): the squared length of each
/// primitive.
pub(crate) fn column_squares(primitives: &[f64], rank: usize) -> Vec<f64> {
    let mut squares = vec![0.0; rank];
    for numbers in primitives.chunks_exact(rank) {
        for (square, v) in squares.iter_mut().zip(numbers) {
            *square += v * v;
        }
    }
    squares
}
