//! Suspect samples: what detectors find, and what a repair would do about it.

use std::fmt;
use std::ops::Range;

use inhand_model::Finger;
use nalgebra::Isometry3;

/// Samples that look wrong.
#[derive(Clone, Debug, PartialEq)]
pub struct Suspect {
    /// What looks wrong about them.
    pub kind: SuspectKind,
    /// The samples.
    pub samples: Range<usize>,
    /// How sure the detector is, 1 or more: how many times its threshold the samples reach. For a swap
    /// 0 or more: the natural logarithm of how much more likely the take is with the labels exchanged
    /// back; 10 is near certain.
    pub score: f64,
}

/// What looks wrong, and with what.
#[derive(Clone, Debug, PartialEq)]
pub enum SuspectKind {
    /// A body whose pose jumps to a wrong solution of its fit.
    Flip {
        /// Index of the body in the recording.
        body: usize,
        /// Name of the body.
        name: String,
        /// By how much its orientation jumps, radians.
        turn_rad: f64,
        /// What to do about it.
        repair: FlipRepair,
    },
    /// Fingertip labels that have changed places. The suggested repair is to exchange them back.
    Swap {
        /// The fingers, two or a longer cycle: the label of each carries the samples of the next, the last
        /// label those of the first.
        fingers: Vec<Finger>,
    },
    /// A marker that is off its path for a few samples and comes back to it. The suggested repair is to
    /// remove the samples.
    Spike {
        /// Index of the marker in the recording.
        marker: usize,
        /// Name of the marker.
        name: String,
        /// How far at most, metres, from the path through the samples beside them.
        off_m: f64,
    },
    /// A piece of an unlabelled marker that goes on where a fingertip is lost. The suggested repair is to
    /// give the fingertip the samples.
    Unlabelled {
        /// Index of the unlabelled marker in the recording.
        marker: usize,
        /// Name of that marker.
        name: String,
        /// The finger that it is.
        finger: Finger,
    },
}

/// What to do about a body in a wrong pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FlipRepair {
    /// It comes back by the way it went, so that its true pose is known: the recorded pose times the
    /// inverse of this transform from the body recorded to the true body.
    TurnBack(Isometry3<f64>),
    /// It does not come back by that way: the samples are better removed.
    Remove,
}

impl SuspectKind {
    /// Identifier of its check results: `flips`, `swaps`, `spikes` or `unlabelled-stretches`.
    pub const fn id(&self) -> &'static str {
        match self {
            SuspectKind::Flip { .. } => "flips",
            SuspectKind::Swap { .. } => "swaps",
            SuspectKind::Spike { .. } => "spikes",
            SuspectKind::Unlabelled { .. } => "unlabelled-stretches",
        }
    }

    /// The marker, body or finger; for a swap all of them, such as `index and middle`.
    pub fn entity(&self) -> String {
        match self {
            SuspectKind::Flip { name, .. } | SuspectKind::Spike { name, .. } => name.clone(),
            SuspectKind::Swap { fingers } => {
                let names: Vec<_> = fingers.iter().map(|finger| finger.name()).collect();
                names.join(" and ")
            }
            SuspectKind::Unlabelled { finger, .. } => finger.name().to_owned(),
        }
    }
}

impl fmt::Display for Suspect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let entity = self.kind.entity();
        match &self.kind {
            SuspectKind::Flip {
                turn_rad, repair, ..
            } => {
                let back = match repair {
                    FlipRepair::TurnBack(_) => "and back",
                    FlipRepair::Remove => "and does not come back that way",
                };
                write!(
                    f,
                    "{entity} jumps by {:.0} degrees {back}",
                    turn_rad.to_degrees()
                )
            }
            SuspectKind::Swap { .. } => write!(f, "{entity} look swapped"),
            SuspectKind::Spike { off_m, .. } => {
                let samples = self.samples.len();
                let plural = if samples == 1 { "" } else { "s" };
                let off_mm = off_m * 1e3;
                write!(
                    f,
                    "{entity} is {off_mm:.1} mm off its path for {samples} sample{plural}"
                )
            }
            SuspectKind::Unlabelled { name, .. } => {
                write!(f, "{name} goes on where {entity} is lost")
            }
        }
    }
}
