//! Smallest distances between fingertips.

use inhand_model::{Finger, Hand, PerFinger, Position};

/// The smallest distance between two fingertips at one instant, metres, and the two fingers in the
/// order of [`Finger::ALL`]. Of equally near pairs the first counts.
///
/// Pairs with a missing tip (NaN) are left out; without any pair the distance is NaN, of thumb and
/// index.
pub fn nearest_pair_m(tips: &PerFinger<Position<Hand>>) -> (f64, Finger, Finger) {
    let mut nearest = (f64::INFINITY, Finger::Thumb, Finger::Index);
    let mut known = false;
    for (place, &a) in Finger::ALL.iter().enumerate() {
        for &b in &Finger::ALL[place + 1..] {
            let squared = (tips[a].point() - tips[b].point()).norm_squared();
            known |= !squared.is_nan();
            if squared < nearest.0 {
                nearest = (squared, a, b);
            }
        }
    }
    let (squared, a, b) = nearest;
    (if known { squared.sqrt() } else { f64::NAN }, a, b)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tips(x_m: [f64; 5]) -> PerFinger<Position<Hand>> {
        PerFinger::new(x_m).map(|x| Position::new(x, 0.0, 0.0))
    }

    #[test]
    fn finds_the_pair() {
        let (d, a, b) = nearest_pair_m(&tips([0.0, 0.1, 0.25, 0.33, 0.5]));
        assert!((d - 0.08).abs() < 1e-15);
        assert_eq!((a, b), (Finger::Middle, Finger::Ring));
        // The nearest pair need not be of neighbours.
        let (d, a, b) = nearest_pair_m(&tips([0.0, 0.1, 0.25, 0.4, 0.01]));
        assert_eq!((a, b), (Finger::Thumb, Finger::Little));
        assert!((d - 0.01).abs() < 1e-15);
    }

    #[test]
    fn leaves_missing_tips_out() {
        let nan = f64::NAN;
        let (d, a, b) = nearest_pair_m(&tips([nan, 0.1, nan, 0.4, nan]));
        assert_eq!((a, b), (Finger::Index, Finger::Ring));
        assert!((d - 0.3).abs() < 1e-15);
        assert!(nearest_pair_m(&tips([nan, nan, nan, 0.4, nan])).0.is_nan());
    }
}
