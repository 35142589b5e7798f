//! Initial primitives.

use crate::columns::Columns;
use crate::error::LearnError;
use crate::random::{draw, keyed, uniform};
use crate::rounds::{NmfProblem, NmfState};
use crate::settings::Start;

/// Random primitives start between `1 - SPREAD` and 1, as nearly constant columns that become
/// different by what they learn. Wide enough to tell them apart, narrow enough that none begins
/// with its share of the motion already random: at the same reconstruction error, primitives grown
/// from 0.2 to 0.5 plan with some ten per cent less error on takes left out of training than those
/// grown from numbers between 0 and 1, because fewer activations end at their bound.
const SPREAD: f64 = 0.3;

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
}
