//! The five fingers, in one order everywhere (thumb, index, middle, ring, little), and sets of them.

use std::fmt;
use std::ops::{Index, IndexMut};
use std::str::FromStr;

use serde::{Deserialize, Serialize, Serializer};
use thiserror::Error;

use crate::names::named;

named! {
    /// A finger of the recorded hand.
    #[derive(PartialOrd, Ord, Hash, Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum Finger {
        /// The thumb.
        Thumb = "thumb",
        /// The index finger.
        Index = "index",
        /// The middle finger.
        Middle = "middle",
        /// The ring finger.
        Ring = "ring",
        /// The little finger.
        Little = "little",
    }
}

impl Finger {
    /// How many fingers there are.
    pub const COUNT: usize = 5;

    /// Place in [`Finger::ALL`].
    pub const fn index(self) -> usize {
        self as usize
    }
}

impl fmt::Display for Finger {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// A word that names no finger.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("unknown finger \"{name}\": expected thumb, index, middle, ring or little")]
pub struct UnknownFinger {
    /// The word found.
    pub name: String,
}

impl FromStr for Finger {
    type Err = UnknownFinger;

    /// In any case; `pinky` is the little finger.
    fn from_str(name: &str) -> Result<Self, Self::Err> {
        let lower = name.to_ascii_lowercase();
        let wanted = if lower == "pinky" { "little" } else { &lower };
        Finger::ALL
            .into_iter()
            .find(|finger| finger.name() == wanted)
            .ok_or_else(|| UnknownFinger {
                name: name.to_owned(),
            })
    }
}

/// One value for each finger.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(from = "ByName<T>")]
pub struct PerFinger<T>([T; Finger::COUNT]);

impl<T> PerFinger<T> {
    /// Values in the order of [`Finger::ALL`].
    pub const fn new(values: [T; Finger::COUNT]) -> Self {
        Self(values)
    }

    /// Calls `make` once for each finger.
    pub fn from_fn(mut make: impl FnMut(Finger) -> T) -> Self {
        Self(Finger::ALL.map(&mut make))
    }

    /// Like [`PerFinger::from_fn`], stopping at the first error.
    ///
    /// # Errors
    ///
    /// The first error that `make` returns.
    pub fn try_from_fn<E>(mut make: impl FnMut(Finger) -> Result<T, E>) -> Result<Self, E> {
        let [a, b, c, d, e] = Finger::ALL;
        Ok(Self([make(a)?, make(b)?, make(c)?, make(d)?, make(e)?]))
    }

    /// Fingers with their values.
    pub fn iter(&self) -> impl Iterator<Item = (Finger, &T)> {
        Finger::ALL.into_iter().zip(&self.0)
    }

    /// Applies `change` to each value.
    pub fn map<U>(self, change: impl FnMut(T) -> U) -> PerFinger<U> {
        PerFinger(self.0.map(change))
    }

    /// Borrows each value.
    pub fn each_ref(&self) -> PerFinger<&T> {
        PerFinger(self.0.each_ref())
    }

    /// The values in order.
    pub fn as_array(&self) -> &[T; Finger::COUNT] {
        &self.0
    }

    /// The values in order, to change.
    pub fn as_mut_array(&mut self) -> &mut [T; Finger::COUNT] {
        &mut self.0
    }

    /// The values in order, owned.
    pub fn into_array(self) -> [T; Finger::COUNT] {
        self.0
    }
}

impl PerFinger<f64> {
    /// Mean over the fingers.
    pub fn mean(&self) -> f64 {
        self.0.iter().sum::<f64>() / Finger::COUNT as f64
    }
}

/// Values of fingers in a document, by the fingers' names.
#[derive(Deserialize)]
struct ByName<T> {
    thumb: T,
    index: T,
    middle: T,
    ring: T,
    little: T,
}

impl<T> From<ByName<T>> for PerFinger<T> {
    fn from(named: ByName<T>) -> Self {
        Self([
            named.thumb,
            named.index,
            named.middle,
            named.ring,
            named.little,
        ])
    }
}

impl<T: Serialize> Serialize for PerFinger<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.iter())
    }
}

/// A value of all fingers together, and one for each.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct HandAndFingers<T> {
    /// All fingers together.
    pub all: T,
    /// Each finger.
    #[serde(flatten)]
    pub by_finger: PerFinger<T>,
}

impl<T> HandAndFingers<T> {
    /// The value of all fingers (`None`), then that of each.
    pub fn from_fn(mut value: impl FnMut(Option<Finger>) -> T) -> Self {
        Self {
            all: value(None),
            by_finger: PerFinger::from_fn(|finger| value(Some(finger))),
        }
    }
}

impl<T> Index<Finger> for PerFinger<T> {
    type Output = T;

    fn index(&self, finger: Finger) -> &T {
        &self.0[finger.index()]
    }
}

impl<T> IndexMut<Finger> for PerFinger<T> {
    fn index_mut(&mut self, finger: Finger) -> &mut T {
        &mut self.0[finger.index()]
    }
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_round_trip_and_ignore_case() {
        for finger in Finger::ALL {
            assert_eq!(finger.name().to_uppercase().parse(), Ok(finger));
            assert_eq!(Finger::ALL[finger.index()], finger);
        }
        assert!("pinkie finger".parse::<Finger>().is_err());
    }
}
