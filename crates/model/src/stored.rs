//! Precision of computed numbers in files.

/// Adding it leaves no bits of a number below 2^-30, where doubles of its size end.
const ROUNDING: f64 = 1.5 * (1 << 22) as f64;

/// Numbers from here on are stored as they are.
const LARGE: f64 = (1 << 20) as f64;

/// A computed number as files store it: the nearest multiple of 2^-30, at most 0.47 nm off where it is a length in
/// metres. Without the bits below, which no measurement has, files are smaller by a third.
///
/// ```
/// use inhand_model::stored;
///
/// let error_m = 0.0123456789;
/// assert!((stored(error_m) - error_m).abs() <= 0.5 / f64::from(1 << 30));
/// assert_eq!((stored(error_m) * f64::from(1 << 30)).fract(), 0.0);
/// assert!(stored(f64::NAN).is_nan());
/// ```
pub fn stored(number: f64) -> f64 {
    match number.abs() < LARGE {
        true => (number + ROUNDING) - ROUNDING,
        false => number,
    }
}
