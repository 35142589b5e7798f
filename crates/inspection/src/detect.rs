//! Detectors of suspect samples. Nothing here changes a recording.
//!
//! Each kind is looked for with what is found before it out of the way: flips first, since a flipped
//! hand moves all fingers in its frame; then swaps; spikes in what swaps leave; then what unlabelled
//! markers could be, beside fingertips that are known.

mod excursions;
pub(crate) mod flips;
pub(crate) mod spikes;
pub(crate) mod swaps;
pub(crate) mod unlabelled;

use std::fmt;
use std::ops::Range;

use inhand_model::{Finger, Recording, Roles};
use nalgebra::Isometry3;

use crate::error::CleaningError;
use crate::repair;

pub use flips::flips;
pub use spikes::spikes;
pub use swaps::swaps;
pub use unlabelled::unlabelled;

/// A marker that is off its way for a few samples and comes back to it.
#[derive(Clone, Debug, PartialEq)]
pub struct Spike {
    /// Index of the marker in the recording.
    pub marker: usize,
    /// Name of the marker.
    pub name: String,
    /// Samples that are off.
    pub samples: Range<usize>,
    /// How far at most, metres, from the way through the samples beside them.
    pub off_m: f64,
    /// How many times the least distance that counts as a spike there; 1 or more. The suggested repair
    /// is to take the samples away.
    pub score: f64,
}

/// Fingertip labels that have changed places.
#[derive(Clone, Debug, PartialEq)]
pub struct Swap {
    /// The fingers, two or a longer cycle: the label of each carries the samples of the next, the last
    /// label those of the first.
    pub fingers: Vec<Finger>,
    /// Samples at which they are exchanged. The suggested repair is to exchange them back.
    pub samples: Range<usize>,
    /// How much more likely the take is with the labels exchanged back: the natural logarithm of the
    /// ratio. 0 or more; 10 is near certain.
    pub score: f64,
}

/// What to do about a body in a wrong pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FlipRepair {
    /// It comes back by the way it went, so that its true pose is known: the recorded pose times the
    /// inverse of this transform from the body recorded to the true body.
    TurnBack(Isometry3<f64>),
    /// It does not come back by that way: the samples are better taken away.
    Remove,
}

/// A body whose pose jumps to a wrong solution.
#[derive(Clone, Debug, PartialEq)]
pub struct Flip {
    /// Index of the body in the recording.
    pub body: usize,
    /// Name of the body.
    pub name: String,
    /// Samples at which it is wrong.
    pub samples: Range<usize>,
    /// By how much its orientation jumps, radians.
    pub turn_rad: f64,
    /// Mean marker error of those samples relative to the take's median, where errors are recorded: a
    /// wrong solution often has a larger one, but a symmetric body has the same.
    pub error_ratio: Option<f64>,
    /// How many times the largest turn that could be motion; 1 or more.
    pub score: f64,
    /// What to do about it.
    pub repair: FlipRepair,
}

/// A piece of an unlabelled marker that goes on where a fingertip is lost.
#[derive(Clone, Debug, PartialEq)]
pub struct Unlabelled {
    /// Index of the unlabelled marker in the recording.
    pub marker: usize,
    /// Name of that marker.
    pub name: String,
    /// The finger that it is. The suggested repair is to give it the samples.
    pub finger: Finger,
    /// Samples of the piece.
    pub samples: Range<usize>,
    /// Largest distance between an end of the piece and where the fingertip was or is next, metres,
    /// beyond what the motion there explains.
    pub jump_m: f64,
    /// How many times that distance could be before the piece would not be taken; 1 or more.
    pub score: f64,
}

/// Everything that looks wrong.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Suspects {
    /// Bodies in wrong poses.
    pub flips: Vec<Flip>,
    /// Exchanged fingertips.
    pub swaps: Vec<Swap>,
    /// Samples off their way, in the markers as they are recorded.
    pub spikes: Vec<Spike>,
    /// Lost fingertips among unlabelled markers.
    pub unlabelled: Vec<Unlabelled>,
}

impl Suspects {
    /// How many there are.
    pub fn len(&self) -> usize {
        self.flips.len() + self.swaps.len() + self.spikes.len() + self.unlabelled.len()
    }

    /// Whether nothing looks wrong.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Looks for everything that [`flips`], [`swaps`], [`spikes`] and [`unlabelled`] know.
///
/// Spikes inside swapped stretches are named by the marker that holds them in the recording.
///
/// # Errors
///
/// [`CleaningError::NotInTake`], [`CleaningError::Hand`].
pub fn all(recording: &Recording, roles: &Roles) -> Result<Suspects, CleaningError> {
    let found_flips = flips(recording);
    let mut state = recording.clone();
    let found_swaps = swaps(&state, roles)?;
    repair::swaps(&mut state, roles, &found_swaps)?;
    let mut found_spikes = spikes(&state);
    repair::spikes(&mut state, &found_spikes);
    let found_unlabelled = unlabelled::unlabelled_of_clean_tips(&state, roles)?;
    let tips = crate::lookup::tips(recording, roles)?;
    for spike in &mut found_spikes {
        if let Some(finger) = crate::lookup::finger_of(&tips, spike.marker) {
            let label = label_of(finger, spike.samples.start, &found_swaps);
            spike.marker = tips[label];
            spike.name.clone_from(&recording.markers[spike.marker].name);
        }
    }
    found_spikes.sort_by_key(|spike| (spike.samples.start, spike.marker));
    Ok(Suspects {
        flips: found_flips,
        swaps: found_swaps,
        spikes: found_spikes,
        unlabelled: found_unlabelled,
    })
}

/// The label that carries a finger's samples at sample `k`.
fn label_of(finger: Finger, k: usize, swaps: &[Swap]) -> Finger {
    for swap in swaps.iter().filter(|swap| swap.samples.contains(&k)) {
        if let Some(at) = swap.fingers.iter().position(|&f| f == finger) {
            // The label before the finger in the cycle carries it.
            return swap.fingers[(at + swap.fingers.len() - 1) % swap.fingers.len()];
        }
    }
    finger
}

impl fmt::Display for Spike {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let samples = self.samples.len();
        let plural = if samples == 1 { "" } else { "s" };
        let off_mm = self.off_m * 1e3;
        write!(
            f,
            "{} is {off_mm:.1} mm off its way for {samples} sample{plural}",
            self.name
        )
    }
}

impl fmt::Display for Swap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<_> = self.fingers.iter().map(|finger| finger.name()).collect();
        write!(f, "{} look swapped", names.join(" and "))
    }
}

impl fmt::Display for Flip {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let turn = self.turn_rad.to_degrees();
        write!(f, "{} jumps by {turn:.0} degrees", self.name)?;
        match self.repair {
            FlipRepair::TurnBack(_) => f.write_str(" and back"),
            FlipRepair::Remove => f.write_str(" and does not come back that way"),
        }
    }
}

impl fmt::Display for Unlabelled {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} goes on where {} is lost", self.name, self.finger)
    }
}
