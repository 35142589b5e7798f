//! Power spectral density by Welch's method.

use std::f64::consts::TAU;

use inhand_model::{Frame, PointTrack};
use nalgebra::DMatrix;

use crate::error::MotionError;

/// Windows that are transformed together: enough for a matrix product, few enough for any length of take.
const TOGETHER: usize = 64;

/// Adds up the power of windows of signals: Welch's method (Welch 1967, "The use of fast Fourier transform
/// for the estimation of power spectra"), as `scipy.signal.welch` with `window='hann'`,
/// `detrend='constant'` and half a window of overlap.
///
/// Each window loses its mean, is weighted by the periodic Hann window, and gives its squared transform;
/// the density is the mean over windows, one-sided, so that its sum times the width of a bin is the
/// variance of the signal. Windows of all signals and intervals count the same.
///
/// ```
/// use inhand_motion::Welch;
///
/// // 8 Hz with an amplitude of 2 mm has a variance of 2 mm².
/// let rate_hz = 64.0;
/// let signal: Vec<f64> = (0..1000)
///     .map(|k| 0.002 * (std::f64::consts::TAU * 8.0 * f64::from(k) / rate_hz).sin())
///     .collect();
/// let mut welch = Welch::new(64, rate_hz)?;
/// welch.add(&signal);
/// let density = welch.density().ok_or("there are windows")?;
/// let peak = density.iter().copied().fold(0.0, f64::max);
/// assert_eq!(peak, density[8]);
/// let variance_m2: f64 = density.iter().sum::<f64>() * welch.frequency_hz(1);
/// assert!((variance_m2 - 2e-6).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Welch {
    rate_hz: f64,
    hann: Vec<f64>,
    /// Weighted cosines and sines of each frequency (frequencies x window). A product with many windows at
    /// once is as quick as a fast transform of each, and takes any length of window.
    cosines: DMatrix<f64>,
    sines: DMatrix<f64>,
    /// Summed squares of the transforms, each frequency.
    power: Vec<f64>,
    windows: usize,
}

impl Welch {
    /// No window yet, each of `window` samples.
    ///
    /// # Errors
    ///
    /// [`MotionError::Setting`] for a window of fewer than two samples and for a rate that is not a positive
    /// number.
    pub fn new(window: usize, rate_hz: f64) -> Result<Self, MotionError> {
        let expected = "2 samples or more: one has no frequency";
        MotionError::unless(window >= 2, "window", window, expected)?;
        let expected = "a positive number of samples per second";
        let positive = rate_hz > 0.0 && rate_hz.is_finite();
        MotionError::unless(positive, "rate_hz", rate_hz, expected)?;
        let turn = |k: usize| TAU * (k % window) as f64 / window as f64;
        let hann: Vec<f64> = (0..window).map(|n| 0.5 - 0.5 * turn(n).cos()).collect();
        let frequencies = window / 2 + 1;
        // Products of places are reduced before they are angles, so that none loses digits.
        let of = |wave: fn(f64) -> f64| {
            DMatrix::from_fn(frequencies, window, |k, n| hann[n] * wave(turn(k * n)))
        };
        Ok(Self {
            rate_hz,
            cosines: of(f64::cos),
            sines: of(f64::sin),
            hann,
            power: vec![0.0; frequencies],
            windows: 0,
        })
    }

    /// Adds every window of an interval without gaps, half a window apart; a shorter interval gives none.
    pub fn add(&mut self, interval: &[f64]) {
        let window = self.hann.len();
        let step = window.div_ceil(2);
        let mut starts = (0..(interval.len() + 1).saturating_sub(window)).step_by(step);
        loop {
            let columns: Vec<f64> = starts
                .by_ref()
                .take(TOGETHER)
                .flat_map(|start| without_mean(&interval[start..start + window]))
                .collect();
            if columns.is_empty() {
                break;
            }
            self.add_windows(&DMatrix::from_vec(window, columns.len() / window, columns));
        }
    }

    /// Adds the three coordinates of every interval of a track without missing samples.
    pub fn add_points<F: Frame>(&mut self, track: &PointTrack<F>) {
        for run in track.present() {
            for axis in 0..3 {
                let coordinate = |k: usize| track.value(k).to_array()[axis];
                let interval: Vec<f64> = run.clone().map(coordinate).collect();
                self.add(&interval);
            }
        }
    }

    fn add_windows(&mut self, columns: &DMatrix<f64>) {
        let parts = [&self.cosines * columns, &self.sines * columns];
        self.windows += columns.ncols();
        for (k, power) in self.power.iter_mut().enumerate() {
            for part in &parts {
                *power += part.row(k).iter().map(|v| v * v).sum::<f64>();
            }
        }
    }

    /// Windows added so far.
    pub const fn windows(&self) -> usize {
        self.windows
    }

    /// Frequencies, from 0 to half the rate.
    pub const fn frequencies(&self) -> usize {
        self.power.len()
    }

    /// One of the frequencies, Hz.
    pub fn frequency_hz(&self, index: usize) -> f64 {
        index as f64 * self.rate_hz / self.hann.len() as f64
    }

    /// Density at each frequency, squared units of the signal a Hz; `None` before the first window.
    pub fn density(&self) -> Option<Vec<f64>> {
        if self.windows == 0 {
            return None;
        }
        let weight: f64 = self.hann.iter().map(|w| w * w).sum();
        let scale = 1.0 / (self.rate_hz * weight * self.windows as f64);
        let window = self.hann.len();
        // What a negative frequency would hold is the same once more; 0 has none, nor has half the rate.
        let sided = |k: usize| if k == 0 || 2 * k == window { 1.0 } else { 2.0 };
        let density = self.power.iter().enumerate();
        Some(density.map(|(k, power)| sided(k) * scale * power).collect())
    }
}

fn without_mean(window: &[f64]) -> impl Iterator<Item = f64> {
    let mean = window.iter().sum::<f64>() / window.len() as f64;
    window.iter().map(move |v| v - mean)
}
