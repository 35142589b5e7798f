//! Path length, speed and smoothness of fingertip motion.
//!
//! Two measures of smoothness are in use; both are negative, and nearer to 0 is smoother:
//!
//! * **SPARC**, the spectral arc length of the speed ([`spectral_arc_length`]), and
//! * **LDLJ-V**, the log dimensionless jerk of the speed ([`log_dimensionless_jerk`]),
//!
//! both by S. Balasubramanian, A. Melendez-Calderon, A. Roby-Brami and E. Burdet, *On the analysis of
//! movement smoothness*, J. NeuroEng. Rehabil. 12:112, 2015. Both are made for single movements of a few
//! seconds at most: over a whole take with pauses they count the pauses. The jerk measure grows with noise,
//! so only motions that were filtered alike can be compared by it.
//!
//! A function returns `None` instead of a number where its input is too short, does not move, or holds
//! NaN or an infinity. Speeds are those between neighbouring samples, |x(k + 1) - x(k)| rate; nothing is
//! filtered here.

use std::f64::consts::TAU;

use inhand_model::{Frame, PathFacts, Position};

/// The spectrum is taken of `2^(ceil(log2 N) + PADDING)` numbers, N speeds and then zeros. This, the
/// cut-off and the threshold are those of the paper: values from others cannot be compared with
/// published ones.
const PADDING: u32 = 4;

/// Frequencies above are left out, Hz.
const CUTOFF_HZ: f64 = 10.0;

/// The arc ends at the highest frequency (not above the cut-off) whose magnitude is at least this
/// share of the largest.
const THRESHOLD: f64 = 0.05;

/// A speed whose slope changes by less than this share of its peak from sample to sample is steady: a straight
/// line at constant speed, as it comes out of sums and differences, is not smooth to a degree.
const STEADY: f64 = 1e-9;

/// Measures of a path sampled at `rate_hz` without gaps. Steps slower than `static_speed_m_s` count as
/// standing still. A measure of smoothness that is not defined is NaN.
///
/// `None` for fewer than two positions, one that is not finite, and a rate or speed that makes no sense.
///
/// ```
/// use inhand_model::{Hand, Position};
/// use inhand_curves::smoothness::path_measures;
///
/// // 1 mm a sample along x at 100 Hz is 0.1 m/s; then it stands.
/// let path: Vec<Position<Hand>> = (0..=60)
///     .map(|k| Position::new(0.001 * f64::from(k.min(40)), 0.0, 0.0))
///     .collect();
/// let measures = path_measures(&path, 100.0, 0.005).unwrap();
/// assert!((measures.length_m - 0.04).abs() < 1e-12);
/// assert!((measures.peak_speed_m_s - 0.1).abs() < 1e-12);
/// assert!((measures.static_share - 1.0 / 3.0).abs() < 1e-12);
/// ```
pub fn path_measures<F: Frame>(
    path: &[Position<F>],
    rate_hz: f64,
    static_speed_m_s: f64,
) -> Option<PathFacts> {
    let speeds_m_s = speeds_m_s(path, rate_hz)?;
    if speeds_m_s.is_empty() || !is_positive(static_speed_m_s) {
        return None;
    }
    let n = speeds_m_s.len() as f64;
    let slow = speeds_m_s.iter().filter(|&&speed| speed < static_speed_m_s);
    Some(PathFacts {
        length_m: (path.windows(2))
            .map(|pair| pair[1].distance_m(pair[0]))
            .sum(),
        peak_speed_m_s: speeds_m_s.iter().copied().fold(0.0, f64::max),
        static_share: slow.count() as f64 / n,
        sparc: spectral_arc_length(&speeds_m_s, rate_hz).unwrap_or(f64::NAN),
        ldlj: log_dimensionless_jerk(&speeds_m_s, rate_hz).unwrap_or(f64::NAN),
    })
}

/// Speeds between neighbouring samples, m/s: one fewer than positions. `None` for a position that is not
/// finite and for a rate that is not positive.
pub fn speeds_m_s<F: Frame>(path: &[Position<F>], rate_hz: f64) -> Option<Vec<f64>> {
    let speeds: Vec<f64> = (path.windows(2))
        .map(|pair| pair[1].distance_m(pair[0]) * rate_hz)
        .collect();
    let usable = is_positive(rate_hz)
        && path.iter().all(|p| p.is_finite())
        && speeds.iter().all(|speed| speed.is_finite());
    usable.then_some(speeds)
}

/// Spectral arc length of a speed profile (SPARC), no unit, below 0: minus the length of the curve of
/// normalised magnitude over normalised frequency,
///
/// `- sum sqrt(((f(k+1) - f(k)) / (f(last) - f(0)))² + (M(k+1) - M(k))²)`,
///
/// with `M` the magnitude of the zero-padded spectrum over its largest value, from frequency 0 to the last
/// one not above the cut-off whose `M` is at least the threshold. A smooth point-to-point movement has
/// about -1.4 to -1.6; more ripples make it more negative. Neither the height of the speed nor when it
/// starts changes it.
///
/// Since no speed is negative, `M` is largest at frequency 0. Only the frequencies up to the cut-off are
/// computed, each by its sum: O(N²) with the paper's settings.
///
/// `None` for fewer than two speeds, one that is negative or not finite, no motion at all, and a rate of at
/// most twice the cut-off of 10 Hz, where the spectrum ends before the arc does.
///
/// ```
/// use inhand_curves::smoothness::spectral_arc_length;
///
/// // The example of the authors' own code, which prints -1.41403.
/// let bell: Vec<f64> = (-100..100).map(|k| (-5.0 * (f64::from(k) / 100.0).powi(2)).exp()).collect();
/// let sparc = spectral_arc_length(&bell, 100.0).unwrap();
/// assert!((sparc - -1.41403).abs() < 5e-6);
/// ```
pub fn spectral_arc_length(speeds_m_s: &[f64], rate_hz: f64) -> Option<f64> {
    if speeds_m_s.len() < 2 || !speeds_are_sound(speeds_m_s, rate_hz) || CUTOFF_HZ >= rate_hz / 2.0
    {
        return None;
    }
    let padded = (speeds_m_s.len().checked_next_power_of_two()?).checked_mul(1 << PADDING)?;
    let step_hz = rate_hz / padded as f64;
    let count = (CUTOFF_HZ / step_hz) as usize + 1;
    let magnitudes = magnitudes(speeds_m_s, padded, count);
    let largest = magnitudes[0];
    let last = (magnitudes.iter()).rposition(|m| m / largest >= THRESHOLD)?;
    if last == 0 {
        return None;
    }
    let length: f64 = (magnitudes[..=last].windows(2))
        .map(|pair| (1.0 / last as f64).hypot((pair[1] - pair[0]) / largest))
        .sum();
    Some(-length)
}

/// Log dimensionless jerk of a speed profile (LDLJ-V), no unit:
///
/// `- ln( T³ / v_peak² * sum ((v(k+1) - 2 v(k) + v(k-1)) rate²)² / rate )`,  `T = N / rate`
///
/// for N speeds, as the authors' code has it. A larger number (nearer to 0 where it is negative, as it is
/// for every movement of practice) is smoother. Neither unit of length nor duration changes it.
///
/// `None` for fewer than three speeds, one that is negative or not finite, no motion at all, and a speed that
/// never changes its slope (by more than rounding), which has no jerk and no logarithm.
///
/// ```
/// use inhand_curves::smoothness::log_dimensionless_jerk;
///
/// // The example of the authors' own code, which prints -5.81636.
/// let bell: Vec<f64> = (-100..100).map(|k| (-5.0 * (f64::from(k) / 100.0).powi(2)).exp()).collect();
/// let ldlj = log_dimensionless_jerk(&bell, 100.0).unwrap();
/// assert!((ldlj - -5.81636).abs() < 5e-6);
/// ```
pub fn log_dimensionless_jerk(speeds_m_s: &[f64], rate_hz: f64) -> Option<f64> {
    if speeds_m_s.len() < 3 || !speeds_are_sound(speeds_m_s, rate_hz) {
        return None;
    }
    // In speeds over their peak and times over the period of a sample, where the rate cancels:
    // (N / rate)³ rate⁴ / rate.
    let peak = speeds_m_s.iter().copied().fold(0.0, f64::max);
    let n = speeds_m_s.len() as f64;
    let bends = || {
        speeds_m_s
            .windows(3)
            .map(|v| (v[2] - 2.0 * v[1] + v[0]) / peak)
    };
    let squares: f64 = bends().map(|bend| bend * bend).sum();
    bends()
        .any(|bend| bend.abs() > STEADY)
        .then(|| -(n.powi(3) * squares).ln())
}

/// Finite, not negative, not all zero, at a rate that makes sense.
fn speeds_are_sound(speeds_m_s: &[f64], rate_hz: f64) -> bool {
    is_positive(rate_hz)
        && (speeds_m_s.iter()).all(|&speed| speed.is_finite() && speed >= 0.0)
        && speeds_m_s.iter().any(|&speed| speed > 0.0)
}

fn is_positive(number: f64) -> bool {
    number > 0.0 && number.is_finite()
}

/// The first `count` magnitudes of the discrete Fourier transform of `values` followed by zeros,
/// `padded` numbers in all, a power of two.
fn magnitudes(values: &[f64], padded: usize, count: usize) -> Vec<f64> {
    let turns: Vec<(f64, f64)> = (0..padded)
        .map(|k| (TAU * (k as f64 / padded as f64)).sin_cos())
        .collect();
    (0..count)
        .map(|bin| {
            let (mut real, mut imaginary) = (0.0, 0.0);
            let mut turn = 0;
            for value in values {
                let (sine, cosine) = turns[turn];
                real += value * cosine;
                imaginary -= value * sine;
                turn = (turn + bin) & (padded - 1);
            }
            f64::hypot(real, imaginary)
        })
        .collect()
}
