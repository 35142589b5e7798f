//! Plants faults of real captures into a simulated take, with a record of each.
//!
//! Lengths of intervals are log-uniform, so that short ones are as frequent as long ones:
//!
//! * **swap**: two fingertip labels change places for 50 ms to 2 s. Seven of ten pairs are
//!   neighbours; of four places drawn the one is taken where the two are nearest. At three of ten ends
//!   one label or both are lost for 10 to 120 ms about the change, as when fingers hide each other.
//!   A swap of which no sample remains is none.
//! * **flip**: a body's pose takes a wrong solution for 50 ms to 1.5 s: four of ten times a turn by
//!   90° or 180° about an own axis through the markers, with the marker error up to three times as
//!   large and an offset of up to 2 mm; otherwise the fit of the markers in a wrong order, with the
//!   error that this fit has. At three of ten ends the body is lost for 10 to 60 ms. Its markers go
//!   where the pose places them.
//! * **spike**: a fingertip is 5 to 50 mm off for one to three samples, in a direction of chance that
//!   scatters by a tenth from sample to sample. One of five lies beside a gap. Spikes may lie in
//!   swapped intervals.
//! * **unlabelled**: for 0.1 to 3 s the samples of a fingertip go to a new marker `Unlabeled <number>`;
//!   up to three samples are lost at each end.
//! * **ghost**: an unlabelled marker that is no fingertip, 3 to 15 cm from the middle of the fingers,
//!   carried by the hand, for 0.1 to 1 s.
//! * **gaps** of the settings, over everything.
//!
//! Swaps and unlabelled intervals of one finger stay 0.1 s apart, and so do flips of a body.

mod bodies;
mod labels;

use std::ops::Range;

use inhand_model::{Finger, PerFinger, Recording};

use crate::error::SimulationError;
use crate::random::{Purpose, Random};
use crate::settings::{GapSettings, TakeSettings, in_range};
use crate::take::{Fault, FaultKind, SimulatedTake, marker_name, simulate};

/// Most faults of a kind a minute: beyond it nothing would be left to tell them by.
const MAX_PER_MINUTE: f64 = 60.0;
/// Most samples in columns of unlabelled markers, for memory: some 600 MB.
const MAX_UNLABELLED_SAMPLES: f64 = 2e7;

/// Draws before a fault is said to find no place.
const MAX_DRAWS: usize = 1000;

/// Numbers of faults of each kind, a minute.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FaultSettings {
    /// Gaps of each fingertip marker.
    pub gaps: GapSettings,
    /// Intervals with two labels exchanged.
    pub swaps_per_minute: f64,
    /// Intervals in which a body takes a wrong pose.
    pub flips_per_minute: f64,
    /// Runs of one to three samples off their way.
    pub spikes_per_minute: f64,
    /// Intervals in which a fingertip has no label.
    pub unlabelled_per_minute: f64,
    /// Unlabelled markers that are no fingertip.
    pub ghosts_per_minute: f64,
}

impl FaultSettings {
    /// A bad session: 2 % gaps, and a minute 10 swaps, 5 flips, 20 spikes, 3 unlabelled intervals
    /// and 2 ghosts.
    pub const fn bad_session() -> Self {
        Self {
            gaps: GapSettings::with_share(0.02),
            swaps_per_minute: 10.0,
            flips_per_minute: 5.0,
            spikes_per_minute: 20.0,
            unlabelled_per_minute: 3.0,
            ghosts_per_minute: 2.0,
        }
    }

    fn check(&self, samples: usize, minutes: f64) -> Result<(), SimulationError> {
        for (setting, rate) in [
            ("swaps_per_minute", self.swaps_per_minute),
            ("flips_per_minute", self.flips_per_minute),
            ("spikes_per_minute", self.spikes_per_minute),
            ("unlabelled_per_minute", self.unlabelled_per_minute),
            ("ghosts_per_minute", self.ghosts_per_minute),
        ] {
            in_range(setting, rate, 0.0, MAX_PER_MINUTE)?;
        }
        let columns = (self.unlabelled_per_minute + self.ghosts_per_minute) * minutes;
        let held = columns * samples as f64;
        in_range("unlabelled samples", held, 0.0, MAX_UNLABELLED_SAMPLES)
    }
}

/// A simulated take with planted faults.
#[derive(Clone, Debug)]
pub struct FaultyTake {
    /// The take without them, and the truth.
    pub clean: SimulatedTake,
    /// What a capture with faults made of it.
    pub recording: Recording,
    /// The faults, in order of time.
    pub faults: Vec<Fault>,
}

impl FaultyTake {
    /// The take as it was captured with its faults; the truth's gaps are those of that recording.
    #[must_use]
    pub fn into_take(self) -> SimulatedTake {
        let mut truth = self.clean.truth;
        truth.gaps = PerFinger::from_fn(|finger| {
            (self.recording.marker(marker_name(finger))).map_or_else(Vec::new, |m| m.track.gaps())
        });
        SimulatedTake {
            recording: self.recording,
            truth,
            faults: self.faults,
        }
    }
}

/// Simulates a take and plants faults. Gaps of the take's own settings are not used: those of
/// `faults` are. The same settings and seed give the same bits.
///
/// # Errors
///
/// As [`simulate`]; [`SimulationError::Crowded`] where faults find no place beside each other.
pub fn simulate_faulty(
    settings: &TakeSettings,
    faults: &FaultSettings,
    seed: u64,
) -> Result<FaultyTake, SimulationError> {
    let plain = TakeSettings {
        gaps: None,
        ..settings.clone()
    };
    let clean = simulate(&plain, seed)?;
    let samples = clean.recording.len();
    let minutes = samples as f64 / settings.rate_hz / 60.0;
    faults.check(samples, minutes)?;
    let count = |per_minute: f64| (per_minute * minutes).round() as usize;
    let random = |kind| Random::new(seed, Purpose::Faults(kind));

    let mut planting = Planting::new(&clean);
    planting.swaps(count(faults.swaps_per_minute), &mut random(0))?;
    planting.unlabelled(count(faults.unlabelled_per_minute), &mut random(1))?;
    planting.gaps(&faults.gaps, seed)?;
    planting.spikes(count(faults.spikes_per_minute), &mut random(2))?;
    planting.ghosts(count(faults.ghosts_per_minute), &mut random(3))?;
    planting.flips(count(faults.flips_per_minute), &mut random(4))?;
    let (recording, mut faults) = (planting.recording, planting.faults);
    faults.sort_by_cached_key(|fault| {
        (
            fault.samples.start,
            fault.kind.name(),
            fault.entities.clone(),
        )
    });
    Ok(FaultyTake {
        clean,
        recording,
        faults,
    })
}

/// A take into which faults are being planted.
struct Planting<'a> {
    clean: &'a SimulatedTake,
    recording: Recording,
    faults: Vec<Fault>,
    /// Index of each fingertip's marker.
    tips: PerFinger<usize>,
    /// Intervals in which a finger's label is not its own.
    taken: PerFinger<Vec<Range<usize>>>,
    /// Samples that are lost where labels change, by finger.
    lost: PerFinger<Vec<Range<usize>>>,
    /// Number of the next unlabelled marker.
    next_unlabelled: usize,
}

impl<'a> Planting<'a> {
    fn new(clean: &'a SimulatedTake) -> Self {
        let recording = clean.recording.clone();
        let tips = PerFinger::from_fn(|finger| {
            (recording.markers.iter())
                .position(|marker| marker.name == marker_name(finger))
                .expect("a simulated take has a marker on every fingertip")
        });
        Self {
            clean,
            recording,
            faults: Vec::new(),
            tips,
            taken: PerFinger::from_fn(|_| Vec::new()),
            lost: PerFinger::from_fn(|_| Vec::new()),
            next_unlabelled: 1001,
        }
    }

    /// Samples in this many seconds, one at least.
    fn in_samples(&self, seconds: f64) -> usize {
        ((seconds * self.recording.clock.rate_hz()).round() as usize).max(1)
    }

    fn names(&self, fingers: &[Finger]) -> Vec<String> {
        let name = |&finger: &Finger| marker_name(finger).to_owned();
        fingers.iter().map(name).collect()
    }

    /// Adds a fault to the list.
    fn add(&mut self, kind: FaultKind, entities: Vec<String>, samples: Range<usize>) {
        self.faults.push(Fault {
            kind,
            entities,
            samples,
        });
    }

    /// An interval of `len` samples, not at the very ends of the take and `apart` from each of `taken`.
    fn free_stretch(
        &self,
        len: usize,
        apart: usize,
        taken: &[Range<usize>],
        random: &mut Random,
    ) -> Option<Range<usize>> {
        let places = self.recording.len().saturating_sub(len + 2 * apart);
        (0..if places > 0 { MAX_DRAWS } else { 0 })
            .map(|_| {
                let start = apart + random.below(places);
                start..start + len
            })
            .find(|stretch| {
                (taken.iter()).all(|other| {
                    other.end + apart <= stretch.start || stretch.end + apart <= other.start
                })
            })
    }

    /// The error of a fault that found no place: which it is of how many of a kind.
    fn crowded(&self, kind: &str, number: usize, count: usize) -> SimulationError {
        SimulationError::Crowded(format!(
            "no place was found for {kind} number {number} of {count} in {} samples: \
             ask for fewer faults or a longer take",
            self.recording.len()
        ))
    }
}

/// A length between the two, log-uniform.
fn log_uniform((low, high): (f64, f64), random: &mut Random) -> f64 {
    (low.ln() + (high.ln() - low.ln()) * random.unit()).exp()
}
