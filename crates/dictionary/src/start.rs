//! Initial primitives.

use crate::block::Basis;
use crate::data::Columns;
use crate::error::LearnError;
use crate::product::add;
use crate::random::{draw, keyed, shuffled, uniform};
use crate::rounds::{NmfProblem, NmfState};
use crate::settings::Start;

/// Random primitives start between `1 - SPREAD` and 1, as nearly constant columns that become
/// different by what they learn. Wide enough to tell them apart, narrow enough that none begins
/// with its share of the motion already random: at the same reconstruction error, primitives grown
/// from 0.2 to 0.5 plan with some ten per cent less error on takes left out of training than those
/// grown from numbers between 0 and 1, because fewer activations end at their bound.
const SPREAD: f64 = 0.3;

/// Columns of a batch: enough for fast products, few enough that a thousand segments make several
/// steps.
const BATCH_COLUMNS: usize = 256;

/// Sweeps over the activations of a batch, which start from nothing and are met once.
const ACTIVATION_SWEEPS: usize = 10;

/// Exponent by which earlier batches are forgotten: after `t` batches the sums so far count
/// `(1 - 1 / t)^FORGETTING` (Mairal et al. 2010, section 3.4.1 of the paper): their activations
/// belong to primitives that were worse.
const FORGETTING: i32 = 2;

impl NmfProblem {
    /// The state that rounds start from with a seed.
    ///
    /// # Errors
    ///
    /// Errors of reading columns.
    pub fn start(&self, columns: &dyn Columns, seed: u64) -> Result<NmfState, LearnError> {
        let primitives = match self.settings.start {
            Start::Random => self.random_primitives(seed),
            Start::Segments => self.drawn_primitives(columns, seed)?,
            Start::Online => self.online_primitives(columns, seed)?,
            Start::Nndsvd => self.nndsvd_primitives(columns, seed)?,
        };
        Ok(NmfState {
            seed,
            primitives,
            ..NmfState::default()
        })
    }

    pub(crate) fn random_primitives(&self, seed: u64) -> Vec<f64> {
        let rank = self.settings.rank;
        let mut primitives = vec![0.0; rank * self.layout.rows()];
        for (row, numbers) in primitives.chunks_exact_mut(rank).enumerate() {
            let mut random = keyed(seed, row);
            for number in numbers {
                *number = 1.0 - SPREAD * uniform(&mut random);
            }
        }
        primitives
    }

    fn drawn_primitives(&self, columns: &dyn Columns, seed: u64) -> Result<Vec<f64>, LearnError> {
        let rank = self.settings.rank;
        let mut primitives = vec![0.0; rank * self.layout.rows()];
        for (j, segment) in draw(self.count, rank, seed).into_iter().enumerate() {
            let column = self.shifted::<f64>(self.read(columns, segment..segment + 1)?);
            for (numbers, v) in primitives.chunks_exact_mut(rank).zip(&column.data) {
                numbers[j] = *v;
            }
        }
        Ok(primitives)
    }

    /// Primitives (rank x rows) after one pass over the columns in batches, in an order drawn by the
    /// seed (Mairal, Bach, Ponce and Sapiro 2010, "Online learning for matrix factorization and sparse
    /// coding", JMLR 11, algorithm 1 with mini-batches).
    ///
    /// Every batch is fitted once to the primitives as they are, its sums join those of the batches
    /// before, and the primitives follow. Steps depend on one another: a pass has no shards.
    fn online_primitives(&self, columns: &dyn Columns, seed: u64) -> Result<Vec<f64>, LearnError> {
        let settings = &self.settings;
        let (rank, rows) = (settings.rank, self.layout.rows());
        let mut primitives = self.random_primitives(seed);
        let mut gram_m2 = vec![0.0; rank * rank];
        let mut cross_m2 = vec![0.0; rank * rows];
        let mut seen = 0.0;
        let batches = shuffled(self.count.div_ceil(BATCH_COLUMNS), seed);
        for (step, batch) in batches.into_iter().enumerate() {
            let first = batch * BATCH_COLUMNS;
            let segments = first..(first + BATCH_COLUMNS).min(self.count);
            let penalty = settings.activation_penalty.scaled(rows as f64);
            let basis = Basis::<f64>::new(&primitives, rank, penalty);
            let mut block = self.shifted::<f64>(self.read(columns, segments)?);
            block.start_activations(&basis, seed, first);
            let fit = block.fit(&basis, settings.update, ACTIVATION_SWEEPS);

            let kept = (step as f64 / (step + 1) as f64).powi(FORGETTING);
            for v in gram_m2.iter_mut().chain(&mut cross_m2) {
                *v *= kept;
            }
            add(&mut gram_m2, &fit.activation_gram_m2);
            add(&mut cross_m2, &block.cross(rank, &[]));
            seen = kept * seen + block.count() as f64;
            let penalty = settings.primitive_penalty.scaled(seen);
            self.descend_primitives(penalty, &gram_m2, &cross_m2, &mut primitives);
        }
        Ok(primitives)
    }
}
