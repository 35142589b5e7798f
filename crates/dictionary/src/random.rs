//! Random numbers by key: the same in any process and order.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Random numbers of one item (a primitive, a segment, a row), the same in any process and in
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
