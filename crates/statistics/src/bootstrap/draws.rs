//! Which clusters each draw takes.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Draws of clusters with replacement, as many as there are.
///
/// Anyone can repeat them: the numbers of draw `d` are those of ChaCha with 8 rounds, a 64-bit
/// counter and a 64-bit stream number (Bernstein's layout), with the seed's eight bytes and 24 zeros
/// (little-endian) as key and `d` as stream. Each 64-bit word `x` (two 32-bit words, the lower first)
/// takes cluster `floor(x * clusters / 2^64)`. (A cluster's probability is off by less than
/// 2^-32 of itself.)
///
/// ```
/// use inhand_statistics::bootstrap::Draws;
///
/// let mut times = vec![0; 5];
/// Draws { clusters: 5, seed: 1 }.times(0, &mut times);
/// assert_eq!(times.iter().sum::<u32>(), 5);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Draws {
    /// How many clusters there are, and how many a draw takes.
    pub clusters: usize,
    /// The seed.
    pub seed: u64,
}

impl Draws {
    /// How many times draw number `draw` takes each cluster, into the first `clusters` places of
    /// `times`.
    ///
    /// # Panics
    ///
    /// If `times` has fewer places.
    pub fn times(&self, draw: u64, times: &mut [u32]) {
        let times = &mut times[..self.clusters];
        times.fill(0);
        let mut key = [0; 32];
        key[..8].copy_from_slice(&self.seed.to_le_bytes());
        let mut random = ChaCha8Rng::from_seed(key);
        random.set_stream(draw);
        for _ in 0..self.clusters {
            let place = (u128::from(random.next_u64()) * self.clusters as u128) >> 64;
            times[place as usize] += 1;
        }
    }
}
