//! Learning in one pass, batch by batch.

use crate::block::Basis;
use crate::columns::Columns;
use crate::error::LearnError;
use crate::product::add;
use crate::random::shuffled;
use crate::rounds::NmfProblem;

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
    /// Primitives (rank x rows) after one pass over the columns in batches, in an order drawn by the
    /// seed (Mairal, Bach, Ponce and Sapiro 2010, "Online learning for matrix factorization and sparse
    /// coding", JMLR 11, algorithm 1 with mini-batches).
    ///
    /// Every batch is fitted once to the primitives as they are, its sums join those of the batches
    /// before, and the primitives follow. Steps depend on one another: a pass has no shards.
    pub(crate) fn online_primitives(
        &self,
        columns: &dyn Columns,
        seed: u64,
    ) -> Result<Vec<f64>, LearnError> {
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
            add(&mut cross_m2, &block.cross(rank));
            seen = kept * seen + block.count() as f64;
            let penalty = settings.primitive_penalty.scaled(seen);
            self.descend_primitives(penalty, &gram_m2, &cross_m2, &mut primitives);
        }
        Ok(primitives)
    }
}
