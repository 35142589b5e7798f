//! Settings of a simulated take.

use inhand_model::Shape;

use crate::error::SimulationError;

/// Longest take, seconds: an hour, thirty times the takes that this imitates.
const MAX_DURATION_S: f64 = 3600.0;
/// Sample rates of capture systems, Hz. Below the lower one a lifted finger (0.28 s) would show in
/// fewer than five samples.
const RATE_RANGE_HZ: (f64, f64) = (20.0, 1000.0);
/// Largest noise, metres: beyond it fingertips 12 mm apart could change places.
const MAX_NOISE_M: f64 = 2e-3;
/// Most samples that may be missing, as a share.
const MAX_GAP_SHARE: f64 = 0.5;
/// Most samples of a take, for memory: about 1 kB a sample.
const MAX_SAMPLES: f64 = 1e6;

/// Runs of missing samples, drawn for each fingertip marker on its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GapSettings {
    /// Share of a marker's samples that is missing, 0 to 0.5.
    pub share: f64,
    /// Shortest run, samples, at least 1.
    pub min_samples: usize,
    /// Longest run, samples.
    pub max_samples: usize,
}

impl GapSettings {
    /// Runs of 2 to 23 samples, the lengths that short occlusions make at 100 Hz.
    pub const fn with_share(share: f64) -> Self {
        Self {
            share,
            min_samples: 2,
            max_samples: 23,
        }
    }
}

/// One take. [`TakeSettings::cube`] and [`TakeSettings::cylinder`] have the defaults of the demo.
#[derive(Clone, Debug, PartialEq)]
pub struct TakeSettings {
    /// The object in the hand: cross-section 35 to 80 mm each way, 30 to 100 mm along z.
    pub shape: Shape,
    /// Length of the take, seconds, up to an hour.
    pub duration_s: f64,
    /// Samples per second, 20 to 1000.
    pub rate_hz: f64,
    /// Standard deviation of the noise of each coordinate of each marker, metres, up to 2 mm.
    pub noise_m: f64,
    /// Gaps in the fingertip markers, if any.
    pub gaps: Option<GapSettings>,
    /// Whether the recording contains the object.
    pub track_object: bool,
    /// Name of the take.
    pub name: String,
}

impl TakeSettings {
    /// A take of the demo with this object: 120 s at 100 Hz, noise 0.1 mm (the jitter of a
    /// well-calibrated optical system), no gaps, object tracked.
    pub fn new(shape: Shape, name: impl Into<String>) -> Self {
        Self {
            shape,
            duration_s: 120.0,
            rate_hz: 100.0,
            noise_m: 1e-4,
            gaps: None,
            track_object: true,
            name: name.into(),
        }
    }

    /// [`TakeSettings::new`] with a cube of 50 mm.
    pub fn cube(name: impl Into<String>) -> Self {
        Self::new(Shape::Cuboid { edges_m: [0.05; 3] }, name)
    }

    /// [`TakeSettings::new`] with a cylinder of diameter and height 50 mm.
    pub fn cylinder(name: impl Into<String>) -> Self {
        let shape = Shape::Cylinder {
            diameter_m: 0.05,
            height_m: 0.05,
        };
        Self::new(shape, name)
    }

    /// Samples of the take.
    ///
    /// # Errors
    ///
    /// [`SimulationError::Setting`] for a setting out of range; the object's size is checked where
    /// it is grasped.
    pub(crate) fn samples(&self) -> Result<usize, SimulationError> {
        let (min_hz, max_hz) = RATE_RANGE_HZ;
        in_range("rate_hz", self.rate_hz, min_hz, max_hz)?;
        in_range("noise_m", self.noise_m, 0.0, MAX_NOISE_M)?;
        // Two samples at least: a take of one has no motion.
        let shortest_s = 2.0 / self.rate_hz;
        in_range("duration_s", self.duration_s, shortest_s, MAX_DURATION_S)?;
        let samples = (self.duration_s * self.rate_hz).round();
        in_range("duration_s * rate_hz", samples, 2.0, MAX_SAMPLES)?;
        if let Some(gaps) = &self.gaps {
            let longest = gaps.max_samples as f64;
            in_range("gaps.share", gaps.share, 0.0, MAX_GAP_SHARE)?;
            in_range("gaps.max_samples", longest, 1.0, samples - 1.0)?;
            in_range("gaps.min_samples", gaps.min_samples as f64, 1.0, longest)?;
        }
        Ok(samples as usize)
    }
}

pub(crate) fn in_range(
    setting: &str,
    found: f64,
    min: f64,
    max: f64,
) -> Result<(), SimulationError> {
    // A range contains no NaN.
    if (min..=max).contains(&found) {
        Ok(())
    } else {
        Err(SimulationError::Setting(format!(
            "setting {setting} is {found}: expected {min} to {max}"
        )))
    }
}
