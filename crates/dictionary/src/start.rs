//! Initial primitives.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use crate::columns::Columns;
use crate::error::LearnError;
use crate::rounds::{NmfProblem, NmfState};
use crate::settings::Start;

/// Random primitives start between `1 - SPREAD` and 1, as nearly constant columns that become
/// different by what they learn. Wide enough to tell them apart, narrow enough that none begins
/// with its share of the motion already random: at the same reconstruction error, primitives grown
/// from 0.2 to 0.5 plan with some ten per cent less error on takes left out of training than those
/// grown from numbers between 0 and 1, because fewer activations end at their bound.
const SPREAD: f64 = 0.3;

/// Random numbers of one item (a primitive, a segment, a row), the same whoever draws them and in
/// whatever order.
pub(crate) fn keyed(seed: u64, item: usize) -> ChaCha8Rng {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(item as u64);
    random
}

/// A uniform random number in (0, 1].
pub(crate) fn uniform(random: &mut ChaCha8Rng) -> f64 {
    // 53 bits, as many as a double has.
    ((random.next_u64() >> 11) + 1) as f64 / (1_u64 << 53) as f64
}

/// Keeps the random numbers of segments apart from those of rows.
const SEGMENT_KEYS: u64 = 0x5345_474d_454e_5453;

/// Keeps those of batches apart from both.
const BATCH_KEYS: u64 = 0x4241_5443_4845_5321;

/// Shares of a segment's activations, uniform between 0 and 2 with mean 1, without end.
pub(crate) fn activation_shares(seed: u64, segment: usize) -> impl Iterator<Item = f64> {
    let mut random = keyed(seed ^ SEGMENT_KEYS, segment);
    std::iter::repeat_with(move || 2.0 * uniform(&mut random))
}

impl NmfProblem {
    /// The state that rounds start from with a seed.
    ///
    /// # Errors
    ///
    /// What reading columns returns.
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

/// `rank` of `count` segments drawn without replacement: those with the smallest random keys, in the
/// order of the keys. A key belongs to its segment, so a draw can be made from parts of the data and
/// merged. All of them, in their own order, where there are no more.
pub fn draw(count: usize, rank: usize, seed: u64) -> Vec<usize> {
    if count <= rank {
        return (0..count).collect();
    }
    let mut keys: Vec<(u64, usize)> = (0..count)
        .map(|segment| (keyed(seed, segment).next_u64(), segment))
        .collect();
    keys.select_nth_unstable(rank);
    keys.truncate(rank);
    keys.sort_unstable();
    keys.into_iter().map(|(_, segment)| segment).collect()
}

/// All of `count` batches in an order drawn by the seed.
pub(crate) fn shuffled(count: usize, seed: u64) -> Vec<usize> {
    let mut keys: Vec<(u64, usize)> = (0..count)
        .map(|batch| (keyed(seed ^ BATCH_KEYS, batch).next_u64(), batch))
        .collect();
    keys.sort_unstable();
    keys.into_iter().map(|(_, batch)| batch).collect()
}

/// One of `count` segments, drawn for the purpose with number `purpose`.
pub(crate) fn drawn_segment(count: usize, seed: u64, purpose: usize) -> usize {
    // Streams of purposes are kept apart from those of segments and rows.
    let mut random = keyed(!seed, purpose);
    (random.next_u64() % count.max(1) as u64) as usize
}
