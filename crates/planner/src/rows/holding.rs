//! Fingers that hold: balls around contact points that move with the object, as tangents.
//!
//! `|f - c| <= tau` is the intersection of its tangents `n · (f - c) <= tau`. Those at the points
//! where a motion leaves the ball are taken up, until it leaves it nowhere by more than a
//! ten-millionth of tau.

use inhand_model::{ConstraintFamily, Finger, Object, Position, SegmentLayout};
use nalgebra::Vector3;

use super::{Key, Peaks, Row, TOLERANCE, Worst};
use crate::model::MM_PER_M;
use crate::target::Holding;

/// How far outside the ball a fingertip may be, relative to tau, before a tangent is taken up: a
/// tenth of what is promised.
const OUTSIDE: f64 = 1e-7;

/// Where each held finger's contact point is at each sample, mm.
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

    pub(crate) fn rows(&self) -> usize {
        self.centres_mm.iter().map(|(_, path)| path.len()).sum()
    }

    /// Largest violation of the balls themselves; relative to tau.
    pub(crate) fn worst(&self, motion_mm: &[f64]) -> Worst {
        let mut farthest = 0.0_f64;
        for (finger, path) in &self.centres_mm {
            for (sample, centre) in path.iter().enumerate() {
                farthest = farthest.max((tip(motion_mm, sample, *finger) - centre).norm());
            }
        }
        let excess = farthest - self.tau_mm;
        Worst {
            relative: excess / self.tau_mm,
            by: excess / MM_PER_M,
        }
    }

    pub(crate) fn violated(
        &self,
        motion_mm: &[f64],
        slack: f64,
        peaks_only: bool,
        rows: &mut Vec<Row>,
    ) {
        let radius = self.tau_mm + slack * MM_PER_M;
        let mut peaks = Peaks::new(rows, peaks_only);
        for (finger, path) in &self.centres_mm {
            for (sample, centre) in path.iter().enumerate() {
                let away = tip(motion_mm, sample, *finger) - centre;
                let excess = away.norm() - radius;
                if excess > OUTSIDE * self.tau_mm {
                    let direction = away / away.norm();
                    peaks.violated(excess, || self.row(sample, *finger, centre, direction));
                } else {
                    peaks.kept();
                }
            }
            peaks.kept();
        }
    }

    fn row(
        &self,
        sample: usize,
        finger: Finger,
        centre: &Vector3<f64>,
        direction: Vector3<f64>,
    ) -> Row {
        let at = SegmentLayout::row(sample, finger, 0);
        Row::new(
            ConstraintFamily::Holding,
            Key::Tangent {
                sample,
                finger,
                direction: [0, 1, 2].map(|axis| direction[axis].to_bits()),
            },
            (0..3).map(|axis| (at + axis, -direction[axis])),
            -(direction.dot(centre) + self.tau_mm),
            TOLERANCE * self.tau_mm,
            MM_PER_M,
        )
    }
}

fn tip(motion_mm: &[f64], sample: usize, finger: Finger) -> Vector3<f64> {
    let row = SegmentLayout::row(sample, finger, 0);
    Vector3::new(motion_mm[row], motion_mm[row + 1], motion_mm[row + 2])
}
