//! Gaussian kernels of many distances at once.

/// Demonstrations whose kernel is below `exp(-16)` of the nearest one's count as nothing.
const FARTHEST_EXPONENT: f64 = 16.0;
/// Numbers that are compared side by side.
const LANES: usize = 8;
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
    near.iter_mut().for_each(|x| *x = x.exp());
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

#[cfg(test)]
mod tests {
    use super::{kernels, smallest};

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
