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
    let measures = PathMeasures::new(path.len(), rate_hz, static_speed_m_s)?;
    let [facts] = measures.of([path]);
    facts
}

/// [`path_measures`] of many paths with the same number of positions.
#[derive(Clone, Debug)]
pub struct PathMeasures {
    rate_hz: f64,
    static_speed_m_s: f64,
    /// Number of speeds of a path.
    speeds: usize,
    /// `None` where the rate is too low for one.
    spectrum: Option<Spectrum>,
}

impl PathMeasures {
    /// Prepares measures of paths of this many positions. `None` for fewer than two, and a rate or speed that makes
    /// no sense.
    pub fn new(positions: usize, rate_hz: f64, static_speed_m_s: f64) -> Option<Self> {
        let speeds = positions.checked_sub(1).filter(|&speeds| speeds > 0)?;
        (is_positive(rate_hz) && is_positive(static_speed_m_s)).then(|| Self {
            rate_hz,
            static_speed_m_s,
            speeds,
            spectrum: Spectrum::new(speeds, rate_hz),
        })
    }

    /// Measures of paths, faster than one by one. `None` for a path of another number of positions, or with one that
    /// is not finite.
    pub fn of<F: Frame, const P: usize>(
        &self,
        paths: [&[Position<F>]; P],
    ) -> [Option<PathFacts>; P] {
        let speeds = paths.map(|path| {
            speeds_m_s(path, self.rate_hz).filter(|speeds| speeds.len() == self.speeds)
        });
        let profiles = (speeds.each_ref()).map(|speeds| speeds.as_deref().unwrap_or_default());
        let arcs =
            (self.spectrum.as_ref()).map_or([None; P], |spectrum| spectrum.arc_lengths(profiles));
        std::array::from_fn(|p| {
            let speeds_m_s = speeds[p].as_deref()?;
            let slow = (speeds_m_s.iter()).filter(|&&speed| speed < self.static_speed_m_s);
            Some(PathFacts {
                length_m: (paths[p].windows(2))
                    .map(|pair| pair[1].distance_m(pair[0]))
                    .sum(),
                peak_speed_m_s: speeds_m_s.iter().copied().fold(0.0, f64::max),
                static_share: slow.count() as f64 / speeds_m_s.len() as f64,
                sparc: arcs[p].unwrap_or(f64::NAN),
                ldlj: log_dimensionless_jerk(speeds_m_s, self.rate_hz).unwrap_or(f64::NAN),
            })
        })
    }
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
/// computed, each by its sum: O(N²) with the paper's settings. [`PathMeasures`] shares what many have in common.
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
    let [arc] = Spectrum::new(speeds_m_s.len(), rate_hz)?.arc_lengths([speeds_m_s]);
    arc
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
    if speeds_m_s.len() < 3 || !is_positive(rate_hz) || !speeds_are_sound(speeds_m_s) {
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

/// Finite, not negative, not all zero.
fn speeds_are_sound(speeds_m_s: &[f64]) -> bool {
    (speeds_m_s.iter()).all(|&speed| speed.is_finite() && speed >= 0.0)
        && speeds_m_s.iter().any(|&speed| speed > 0.0)
}

fn is_positive(number: f64) -> bool {
    number > 0.0 && number.is_finite()
}

/// Frequencies that are computed side by side, so that sums do not wait for each other.
const LANES: usize = 4;

/// The spectrum of speed profiles of one length up to the cut-off.
#[derive(Clone, Debug)]
struct Spectrum {
    speeds: usize,
    /// How many frequencies there are up to the cut-off, from 0.
    count: usize,
    /// Cosine and sine of each part of a turn; their number, that of the padded profile, is a power of two.
    turns: Vec<[f64; 2]>,
}

impl Spectrum {
    /// `None` for fewer than two speeds, and a rate whose spectrum ends before the cut-off.
    fn new(speeds: usize, rate_hz: f64) -> Option<Self> {
        if speeds < 2 || !is_positive(rate_hz) || CUTOFF_HZ >= rate_hz / 2.0 {
            return None;
        }
        let padded = (speeds.checked_next_power_of_two()?).checked_mul(1 << PADDING)?;
        let turn = |k: usize| {
            let (sine, cosine) = (TAU * (k as f64 / padded as f64)).sin_cos();
            [cosine, sine]
        };
        Some(Self {
            speeds,
            count: (CUTOFF_HZ / (rate_hz / padded as f64)) as usize + 1,
            turns: (0..padded).map(turn).collect(),
        })
    }

    /// Spectral arc lengths of several profiles; `None` for one of another length, or that is not sound.
    fn arc_lengths<const P: usize>(&self, profiles: [&[f64]; P]) -> [Option<f64>; P] {
        let is_sound =
            profiles.map(|speeds| speeds.len() == self.speeds && speeds_are_sound(speeds));
        let at = |k: usize| -> [f64; P] {
            std::array::from_fn(|p| if is_sound[p] { profiles[p][k] } else { 0.0 })
        };
        let profiles: Vec<_> = (0..self.speeds).map(at).collect();
        let magnitudes = self.magnitudes(&profiles);
        std::array::from_fn(|p| is_sound[p].then(|| arc_length(&magnitudes, p)).flatten())
    }

    /// Magnitudes of the discrete Fourier transform of profiles followed by zeros.
    fn magnitudes<const P: usize>(&self, profiles: &[[f64; P]]) -> Vec<[f64; P]> {
        let mut magnitudes = Vec::with_capacity(self.count + LANES);
        for first in (0..self.count).step_by(LANES) {
            let mut sums = [[[0.0; LANES]; 2]; P];
            let mut turn = [0; LANES];
            for speeds in profiles {
                let turns = turn.map(|turn| self.turns[turn & (self.turns.len() - 1)]);
                for (sums, speed) in sums.iter_mut().zip(speeds) {
                    for lane in 0..LANES {
                        sums[0][lane] += speed * turns[lane][0];
                        sums[1][lane] += speed * turns[lane][1];
                    }
                }
                for (lane, turn) in turn.iter_mut().enumerate() {
                    *turn += first + lane;
                }
            }
            let magnitude =
                |lane: usize| sums.map(|[real, imaginary]| real[lane].hypot(imaginary[lane]));
            magnitudes.extend((0..LANES).map(magnitude));
        }
        magnitudes.truncate(self.count);
        magnitudes
    }
}

/// The arc length of one of several profiles.
fn arc_length<const P: usize>(magnitudes: &[[f64; P]], profile: usize) -> Option<f64> {
    let largest = magnitudes[0][profile];
    let last = (magnitudes.iter()).rposition(|m| m[profile] / largest >= THRESHOLD)?;
    let length: f64 = (magnitudes[..=last].windows(2))
        .map(|pair| (1.0 / last as f64).hypot((pair[1][profile] - pair[0][profile]) / largest))
        .sum();
    (last > 0).then_some(-length)
}
