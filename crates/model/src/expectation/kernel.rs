//! Gaussian kernels of many distances at once.

/// Demonstrations whose kernel is below `exp(-16)` of the nearest one's count as nothing.
const FARTHEST_EXPONENT: f64 = 16.0;
/// Numbers that are compared side by side.
const LANES: usize = 8;
/// Adding this leaves a small number's nearest integer in the last bits (a half more than 2^52, so
/// that negative numbers stay in the same binade).
const ROUNDER: f64 = 6_755_399_441_055_744.0;
/// `ln 2` as a number of few digits, whose small multiples are exact, and the rest.
const LN_2: [f64; 2] = [0.693_147_180_369_123_8, 1.908_214_929_270_587_7e-10];
/// `1 / k!` for k = 13 down to 0. What follows is below `0.35^14 / 14!`, 5e-18.
const FACTORIALS: [f64; 14] = [
    1.0 / 6_227_020_800.0,
    1.0 / 479_001_600.0,
    1.0 / 39_916_800.0,
    1.0 / 3_628_800.0,
    1.0 / 362_880.0,
    1.0 / 40_320.0,
    1.0 / 5_040.0,
    1.0 / 720.0,
    1.0 / 120.0,
    1.0 / 24.0,
    1.0 / 6.0,
    0.5,
    1.0,
    1.0,
];

/// Squared distances to Gaussian kernels of a width, `exp(-(d² - nearest²) / (2 width²))`, in place;
/// returns their sum. Numbers that are none give zero.
pub(super) fn kernels(squared: &mut [f64], width: f64) -> f64 {
    let scale = 0.5 / (width * width);
    let nearest = smallest(squared);
    let farthest = nearest + FARTHEST_EXPONENT / scale;
    // Most are far: only the near ones, gathered, are worth an exponential.
    let mut places = vec![0; squared.len()];
    let mut near = vec![0.0; squared.len()];
    let mut count = 0;
    for (place, d) in squared.iter_mut().enumerate() {
        // Written in any case, and kept by counting it: nothing to predict.
        places[count] = place;
        near[count] = (nearest - *d) * scale;
        count += usize::from(*d <= farthest);
        *d = 0.0;
    }
    let near = &mut near[..count];
    near.iter_mut().for_each(|x| *x = exp(*x));
    let mut total = 0.0;
    for (&place, &kernel) in places.iter().zip(&*near) {
        squared[place] = kernel;
        total += kernel;
    }
    total
}

/// The smallest number; infinite where there is none.
fn smallest(numbers: &[f64]) -> f64 {
    let smaller = |a: f64, b: f64| if b < a { b } else { a };
    let mut lanes = [f64::INFINITY; LANES];
    let (chunks, rest) = numbers.as_chunks::<LANES>();
    for chunk in chunks {
        for (lane, number) in lanes.iter_mut().zip(chunk) {
            *lane = smaller(*lane, *number);
        }
    }
    lanes
        .into_iter()
        .chain(rest.iter().copied())
        .fold(f64::INFINITY, smaller)
}

/// `exp(x)` for `x` from -700 to 700, to a few units in the last place: without branch or table, so
/// that the compiler can do several at once.
#[inline(always)]
fn exp(x: f64) -> f64 {
    // x = k ln 2 + r with |r| <= ln(2) / 2.
    let shifted = x * std::f64::consts::LOG2_E + ROUNDER;
    let k = shifted - ROUNDER;
    let r = (x - k * LN_2[0]) - k * LN_2[1];
    let mut value = FACTORIALS[0];
    for factor in &FACTORIALS[1..] {
        value = value * r + factor;
    }
    // 2^k: the integer in the last bits of `shifted`, as an exponent.
    value * f64::from_bits((shifted.to_bits() << 52).wrapping_add(1.0_f64.to_bits()))
}

#[cfg(test)]
mod tests {
    use super::{exp, kernels, smallest};

    #[test]
    fn the_exponential_is_that_of_the_standard_library() {
        for i in -160_000..=160_000 {
            let x = f64::from(i) * 1.000_3e-4;
            let error = exp(x) / x.exp() - 1.0;
            assert!(error.abs() < 4.0 * f64::EPSILON, "{x}: {error}");
        }
        assert_eq!(exp(0.0), 1.0);
        assert_eq!(exp(-0.0), 1.0);
    }

    #[test]
    fn kernels_are_those_of_the_formula_whatever_their_number() {
        for count in [0, 1, 7, 8, 9, 64, 67] {
            let squared: Vec<f64> = (0..count)
                .map(|i| 3.0 + 40.0 * (0.37 * f64::from(i)).sin().abs())
                .collect();
            let nearest = squared.iter().copied().fold(f64::INFINITY, f64::min);
            assert_eq!(smallest(&squared), nearest);
            let expected: Vec<f64> = (squared.iter())
                .map(|d| (d - nearest) / (2.0 * 0.8 * 0.8))
                .map(|e| if e <= 16.0 { (-e).exp() } else { 0.0 })
                .collect();
            let mut found = squared.clone();
            let total = kernels(&mut found, 0.8);
            assert!((total - expected.iter().sum::<f64>()).abs() < 1e-13);
            for (found, expected) in found.iter().zip(expected) {
                assert!(
                    (found - expected).abs() <= 1e-14 * expected,
                    "{found} {expected}"
                );
            }
        }
    }

    #[test]
    fn what_is_no_number_is_near_to_nothing() {
        let mut squared = [f64::NAN, 2.0, f64::INFINITY];
        assert_eq!(kernels(&mut squared, 1.0), 1.0);
        assert_eq!(squared, [0.0, 1.0, 0.0]);
        let mut squared = [f64::NAN; 3];
        assert_eq!(kernels(&mut squared, 1.0), 0.0);
        assert_eq!(squared, [0.0; 3]);
    }
}
