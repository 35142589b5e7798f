//! Where the primitives start.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use crate::block::Block;
use crate::settings::Start;

/// Random primitives start between `1 - SPREAD` and 1, as nearly constant columns that become
/// different by what they learn. Wide enough to tell them apart, narrow enough that none begins
/// with its share of the motion already random: at the same reconstruction error, primitives grown
/// from 0.2 to 0.5 plan with some ten per cent less error on takes left out of training than those
/// grown from numbers between 0 and 1, because fewer activations end at their bound.
const SPREAD: f64 = 0.3;

/// Random numbers of one item (a primitive, a segment, a row), the same whoever draws them and in
/// whatever order.
fn keyed(seed: u64, item: usize) -> ChaCha8Rng {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(item as u64);
    random
}

/// A uniform random number in (0, 1].
fn uniform(random: &mut ChaCha8Rng) -> f64 {
    // 53 bits, as many as a double has.
    ((random.next_u64() >> 11) + 1) as f64 / (1_u64 << 53) as f64
}

/// Keeps the random numbers of segments apart from those of rows.
const SEGMENT_KEYS: u64 = 0x5345_474d_454e_5453;

/// Shares of a segment's activations, uniform between 0 and 2 with mean 1, without end.
pub(crate) fn activation_shares(seed: u64, segment: usize) -> impl Iterator<Item = f64> {
    let mut random = keyed(seed ^ SEGMENT_KEYS, segment);
    std::iter::repeat_with(move || 2.0 * uniform(&mut random))
}

/// Primitives as rows (`rank` x rows) to start from.
pub(crate) fn primitives(
    start: Start,
    blocks: &[Block],
    rows: usize,
    rank: usize,
    seed: u64,
) -> Vec<f64> {
    let mut basis = vec![0.0; rank * rows];
    match start {
        Start::Random => {
            for (row, numbers) in basis.chunks_exact_mut(rank).enumerate() {
                let mut random = keyed(seed, row);
                for number in numbers {
                    *number = 1.0 - SPREAD * uniform(&mut random);
                }
            }
        }
        Start::Segments => {
            for (primitive, segment) in draw(blocks, rank, seed).into_iter().enumerate() {
                for (row, number) in column(blocks, segment).iter().enumerate() {
                    basis[row * rank + primitive] = *number;
                }
            }
        }
    }
    basis
}

/// `rank` segments drawn without replacement: those with the smallest random keys. A key belongs
/// to its segment, so a draw can be made from parts of the data and merged.
fn draw(blocks: &[Block], rank: usize, seed: u64) -> Vec<usize> {
    let count = blocks.iter().map(Block::count).sum();
    let mut keys: Vec<(u64, usize)> = (0..count)
        .map(|segment| (keyed(seed, segment).next_u64(), segment))
        .collect();
    keys.sort_unstable();
    keys.truncate(rank);
    keys.into_iter().map(|(_, segment)| segment).collect()
}

/// A shifted column by its number over all blocks.
pub(crate) fn column(blocks: &[Block], segment: usize) -> &[f64] {
    let mut index = segment;
    for block in blocks {
        if index < block.count() {
            return &block.data[index * block.rows..][..block.rows];
        }
        index -= block.count();
    }
    &[]
}

/// One segment, drawn for the purpose with number `purpose`.
pub(crate) fn drawn_segment(blocks: &[Block], seed: u64, purpose: usize) -> usize {
    let count: usize = blocks.iter().map(Block::count).sum();
    // Streams of purposes are kept apart from those of segments and rows.
    let mut random = keyed(!seed, purpose);
    (random.next_u64() % count.max(1) as u64) as usize
}
