//! Takes that hold the same samples.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use inhand_model::{PointTrack, World};

/// A take that shares most positions of a marker with an earlier one, to the last digit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Alike {
    /// The take.
    pub take: usize,
    /// The earlier one.
    pub other: usize,
    /// Positions that both have, whenever they were: a copy may be shifted or trimmed.
    pub shared: usize,
    /// Positions of the take.
    pub own: usize,
}

/// A position of a marker to the last digit.
pub type ExactPosition = [u64; 3];

/// Positions of a marker that is there.
pub fn exact_positions(track: Option<&PointTrack<World>>) -> Vec<ExactPosition> {
    let positions = track.into_iter().flat_map(|track| track.iter().flatten());
    positions
        .map(|position| position.to_array().map(f64::to_bits))
        .collect()
}

/// Takes that share more than half of the positions that the shorter one has with an earlier one, by a marker of
/// each.
pub fn takes_alike(takes: &[impl AsRef<[ExactPosition]>]) -> Vec<Alike> {
    let mut alike = Vec::new();
    let mut first_seen: HashMap<ExactPosition, usize> = HashMap::new();
    for (take, places) in takes.iter().enumerate() {
        let mut counts = vec![0; take];
        for &place in places.as_ref() {
            match first_seen.entry(place) {
                Entry::Vacant(entry) => {
                    entry.insert(take);
                }
                Entry::Occupied(entry) if *entry.get() < take => counts[*entry.get()] += 1,
                Entry::Occupied(_) => {}
            }
        }
        let own = places.as_ref().len();
        let most = (0..take).max_by_key(|&other| counts[other]);
        if let Some(other) = most
            && 2 * counts[other] > own.min(takes[other].as_ref().len())
        {
            alike.push(Alike {
                take,
                other,
                shared: counts[other],
                own,
            });
        }
    }
    alike
}

#[cfg(test)]
mod tests {
    use super::*;
    use inhand_model::Position;

    fn track(samples: std::ops::Range<i32>) -> Vec<ExactPosition> {
        exact_positions(Some(&PointTrack::from_measured(
            samples.map(|k| Some(Position::new(f64::from(k) * 0.1, 0.0, 1.0))),
        )))
    }

    #[test]
    fn copies_are_found_shifted_and_trimmed_and_pieces_are_none() {
        let whole = track(0..100);
        let [trimmed, first, last] = [1..100, 0..60, 60..100].map(track);
        let found = |a, b| takes_alike(&[a, b]);
        let expected = Alike {
            take: 1,
            other: 0,
            shared: 99,
            own: 99,
        };
        assert_eq!(found(&whole, &trimmed), [expected]);
        assert_eq!(found(&whole, &last).len(), 1);
        assert_eq!(found(&first, &last), []);
        assert_eq!(takes_alike(&[&exact_positions(None), &whole]), []);
    }
}
