//! Reachability: each fingertip inside the half-spaces of its training hull.

use inhand_model::{ConstraintFamily, Finger, Hull, PerFinger, SegmentLayout};

use super::{Family, Key, Row, TOLERANCE};
use crate::MM_PER_M;
use crate::error::PlanError;

/// Half-spaces `normal * x <= offset` of each finger, mm, at every sample.
#[derive(Clone, Debug)]
pub(crate) struct Reach {
    faces: PerFinger<Vec<([f64; 3], f64)>>,
    samples: usize,
}

impl Reach {
    /// The half-spaces of `hulls`, moved outwards by a margin.
    pub(crate) fn new(
        hulls: &PerFinger<Hull>,
        margin_m: f64,
        layout: SegmentLayout,
    ) -> Result<Self, PlanError> {
        let faces = PerFinger::try_from_fn(|finger| {
            let hull = &hulls[finger];
            if hull.normals.is_empty() {
                return Err(PlanError::no_hull(finger));
            }
            let offsets = hull.offsets_m.iter().map(|b| (b + margin_m) * MM_PER_M);
            Ok(hull.normals.iter().copied().zip(offsets).collect())
        })?;
        Ok(Self {
            faces,
            samples: layout.samples,
        })
    }

    /// How far a fingertip is outside the face that it is farthest outside of, mm.
    fn highest(&self, motion_mm: &[f64], sample: usize, finger: Finger) -> (f64, usize) {
        let at = SegmentLayout::row(sample, finger, 0);
        let [x, y, z] = [motion_mm[at], motion_mm[at + 1], motion_mm[at + 2]];
        let mut highest = (f64::NEG_INFINITY, 0);
        for (face, ([a, b, c], offset)) in self.faces[finger].iter().enumerate() {
            let height = a * x + b * y + c * z - offset;
            if height > highest.0 {
                highest = (height, face);
            }
        }
        highest
    }
}

impl Family for Reach {
    fn family(&self) -> ConstraintFamily {
        ConstraintFamily::Reachability
    }

    fn size(&self) -> (usize, usize) {
        (Finger::COUNT, self.samples)
    }

    fn rows(&self) -> usize {
        let faces: usize = self.faces.iter().map(|(_, faces)| faces.len()).sum();
        faces * self.samples
    }

    fn scale_mm(&self, _finger: usize) -> f64 {
        1.0
    }

    fn excess(&self, motion_mm: &[f64], finger: usize, sample: usize) -> f64 {
        self.highest(motion_mm, sample, Finger::ALL[finger]).0
    }

    fn row(&self, motion_mm: &[f64], finger: usize, sample: usize) -> Row {
        let finger = Finger::ALL[finger];
        let (_, face) = self.highest(motion_mm, sample, finger);
        let (normal, offset) = self.faces[finger][face];
        let at = SegmentLayout::row(sample, finger, 0);
        Row {
            family: ConstraintFamily::Reachability,
            key: Key::Face {
                sample,
                finger,
                face,
            },
            terms: (0..3).map(|axis| (at + axis, -normal[axis])).collect(),
            bound: -offset,
            allowed: TOLERANCE,
            yielding: MM_PER_M,
        }
    }
}
