//! Fingers that hold: balls around contact points that move with the object, as tangents.
//!
//! `|f - c| <= tau` is the intersection of its tangents `n · (f - c) <= tau`. Those at the points
//! where a motion leaves the ball are activated, until it leaves it nowhere by more than a
//! ten-millionth of tau.

use inhand_model::{ConstraintFamily, Finger, Object, Position, SegmentLayout};
use nalgebra::Vector3;

use super::{Family, Key, Row, TOLERANCE};
use crate::MM_PER_M;
use crate::target::Holding;

/// How far outside the ball a fingertip may be, relative to tau, before a tangent is activated: a
/// tenth of what is promised.
const OUTSIDE: f64 = 1e-7;

/// Contact point of each held finger at each sample, mm.
#[derive(Clone, Debug)]
pub(crate) struct Held {
    centres_mm: Vec<(Finger, Vec<Vector3<f64>>)>,
    tau_mm: f64,
}

impl Held {
    pub(crate) fn new(holding: &Holding) -> Self {
        let path = |contact: Position<Object>| {
            let poses = holding.hand_from_object.iter();
            poses
                .map(|&pose| (pose * contact).coords_m() * MM_PER_M)
                .collect()
        };
        Self {
            centres_mm: (holding.contacts.iter())
                .filter_map(|(finger, contact)| contact.map(|contact| (finger, path(contact))))
                .collect(),
            tau_mm: holding.tau_m * MM_PER_M,
        }
    }
}

impl Family for Held {
    fn family(&self) -> ConstraintFamily {
        ConstraintFamily::Holding
    }

    fn size(&self) -> (usize, usize) {
        let samples = self.centres_mm.first().map_or(0, |(_, path)| path.len());
        (self.centres_mm.len(), samples)
    }

    /// The balls themselves count, not their tangents.
    fn excess(&self, motion_mm: &[f64], held: usize, sample: usize) -> f64 {
        let (finger, path) = &self.centres_mm[held];
        (tip(motion_mm, sample, *finger) - path[sample]).norm() - self.tau_mm
    }

    fn scale_mm(&self, _held: usize) -> f64 {
        self.tau_mm
    }

    fn allowed_mm(&self, _held: usize) -> f64 {
        OUTSIDE * self.tau_mm
    }

    fn row(&self, motion_mm: &[f64], held: usize, sample: usize) -> Row {
        let (finger, path) = &self.centres_mm[held];
        let away = tip(motion_mm, sample, *finger) - path[sample];
        let direction = away / away.norm();
        let at = SegmentLayout::row(sample, *finger, 0);
        Row {
            family: ConstraintFamily::Holding,
            key: Key::Tangent {
                sample,
                finger: *finger,
                direction: [0, 1, 2].map(|axis| direction[axis].to_bits()),
            },
            terms: (0..3).map(|axis| (at + axis, -direction[axis])).collect(),
            bound: -(direction.dot(&path[sample]) + self.tau_mm),
            allowed: TOLERANCE * self.tau_mm,
            yielding: MM_PER_M,
        }
    }
}

/// A fingertip, mm.
pub(super) fn tip(motion_mm: &[f64], sample: usize, finger: Finger) -> Vector3<f64> {
    let row = SegmentLayout::row(sample, finger, 0);
    Vector3::new(motion_mm[row], motion_mm[row + 1], motion_mm[row + 2])
}
