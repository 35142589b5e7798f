//! Protocols of an evaluation: the motion that is the reference, and the boundary conditions that methods are given.

use std::ops::Index;

use serde::{Deserialize, Serialize};

use crate::names::named;

named! {
    /// Reference and boundary conditions of a segment.
    #[derive(Default, PartialOrd, Ord, Hash, Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum Protocol {
        /// The reference is the recorded motion after gap filling and filtering; boundary conditions are taken from
        /// it, so that up to half the filter's window of the segment reaches the planner.
        #[default]
        Published = "published",
        /// The reference is the recorded motion with gaps filled, not filtered; boundary conditions are values and
        /// slopes of least-squares lines over measured samples up to the segment's first and from its last on.
        HeldOut = "held_out",
    }
}

impl Protocol {
    /// Name in text.
    pub const fn title(self) -> &'static str {
        match self {
            Self::Published => "published",
            Self::HeldOut => "held out",
        }
    }
}

/// A value for each protocol.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PerProtocol<T> {
    /// That of [`Protocol::Published`].
    pub published: T,
    /// That of [`Protocol::HeldOut`].
    pub held_out: T,
}

impl<T> PerProtocol<T> {
    /// Calls `make` once for each protocol.
    ///
    /// # Errors
    ///
    /// The first that `make` gives.
    pub fn try_from_fn<E>(mut make: impl FnMut(Protocol) -> Result<T, E>) -> Result<Self, E> {
        Ok(Self {
            published: make(Protocol::Published)?,
            held_out: make(Protocol::HeldOut)?,
        })
    }

    /// References to both.
    pub const fn as_ref(&self) -> PerProtocol<&T> {
        PerProtocol {
            published: &self.published,
            held_out: &self.held_out,
        }
    }

    /// Changes both.
    pub fn map<U>(self, mut change: impl FnMut(T) -> U) -> PerProtocol<U> {
        PerProtocol {
            published: change(self.published),
            held_out: change(self.held_out),
        }
    }
}

impl<T> Index<Protocol> for PerProtocol<T> {
    type Output = T;

    fn index(&self, protocol: Protocol) -> &T {
        match protocol {
            Protocol::Published => &self.published,
            Protocol::HeldOut => &self.held_out,
        }
    }
}
