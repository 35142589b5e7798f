//! Sets of fingers: which ones hold the object.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::finger::{Finger, PerFinger};

/// A set of fingers, one bit each (bit 0 the thumb): the state of contact at an instant. 32 of them.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize,
)]
#[serde(from = "Vec<Finger>", into = "Vec<Finger>")]
pub struct FingerSet(u8);

impl FingerSet {
    /// How many sets there are.
    pub const COUNT: usize = 1 << Finger::COUNT;

    /// No finger.
    pub const NONE: FingerSet = FingerSet(0);

    /// Those fingers whose value is true.
    pub fn of(fingers: PerFinger<bool>) -> Self {
        (Finger::ALL.into_iter())
            .filter(|&finger| fingers[finger])
            .fold(Self::NONE, Self::with)
    }

    /// With one finger more, if it was not in it.
    #[must_use]
    pub fn with(self, finger: Finger) -> Self {
        Self(self.0 | 1 << finger.index())
    }

    /// The fingers that are in both.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    /// Whether the finger is in it.
    pub fn contains(self, finger: Finger) -> bool {
        self.0 & (1 << finger.index()) != 0
    }

    /// How many fingers are in it.
    pub fn len(self) -> usize {
        self.0.count_ones() as usize
    }

    /// Whether no finger is in it.
    pub fn is_empty(self) -> bool {
        self == Self::NONE
    }

    /// The five bits as a number from 0 to 31, the thumb counting 1.
    pub fn bits(self) -> u8 {
        self.0
    }

    /// The fingers in it, in their order.
    pub fn iter(self) -> impl Iterator<Item = Finger> {
        Finger::ALL
            .into_iter()
            .filter(move |&finger| self.contains(finger))
    }
}

impl From<Vec<Finger>> for FingerSet {
    fn from(fingers: Vec<Finger>) -> Self {
        fingers.into_iter().fold(Self::NONE, Self::with)
    }
}

impl From<FingerSet> for Vec<Finger> {
    fn from(fingers: FingerSet) -> Self {
        fingers.iter().collect()
    }
}

/// `thumb+index`, or `none`.
impl fmt::Display for FingerSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_empty() {
            return f.pad("none");
        }
        let names: Vec<&str> = self.iter().map(Finger::name).collect();
        f.pad(&names.join("+"))
    }
}
