//! A take in the hand's frame, cleaned.

use std::borrow::Cow;
use std::ops::Range;

use crate::clock::Clock;
use crate::finger::{Finger, PerFinger};
use crate::frame::{Hand, Object, World};
use crate::track::{PointTrack, PoseTrack, Status};

/// Fingertips and object in the frame of the hand, gaps handled, filtered.
#[derive(Clone, Debug)]
pub struct Motion {
    /// The take's name.
    pub name: String,
    /// When its samples were taken.
    pub clock: Clock,
    /// Fingertips in the hand's frame.
    pub fingertips: PerFinger<PointTrack<Hand>>,
    /// Object in the hand's frame (`hand_from_object`), where it was tracked.
    pub object: Option<PoseTrack<Hand, Object>>,
    /// The hand itself (`world_from_hand`), as measured and gap-filled, not filtered.
    pub hand: PoseTrack<World, Hand>,
    /// Samples that segments may be cut from, in order; `None` for all.
    pub selected: Option<Vec<Range<usize>>>,
}

impl Motion {
    /// Samples in the take.
    pub fn len(&self) -> usize {
        self.hand.len()
    }

    /// Whether the take has no sample.
    pub fn is_empty(&self) -> bool {
        self.hand.is_empty()
    }

    /// The motion with what is not selected missing: for what is learned from samples and not from
    /// segments.
    pub fn selected_only(&self) -> Cow<'_, Motion> {
        let Some(selected) = &self.selected else {
            return Cow::Borrowed(self);
        };
        let mut motion = self.clone();
        let mut next = selected.iter().peekable();
        for k in 0..self.len() {
            while next.next_if(|range| range.end <= k).is_some() {}
            if next.peek().is_some_and(|range| range.start <= k) {
                continue;
            }
            for finger in Finger::ALL {
                motion.fingertips[finger].set(k, None, Status::Missing);
            }
            if let Some(object) = &mut motion.object {
                object.set(k, None, Status::Missing);
            }
        }
        Cow::Owned(motion)
    }
}
