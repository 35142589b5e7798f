//! Roles of tracked things: hand, object, fingers.

use serde::{Deserialize, Serialize};

use crate::finger::PerFinger;

/// What a body's pose is taken from.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BodySource {
    /// A rigid body of the take, by name.
    RigidBody(String),
    /// A cluster of three or more markers, by name; the pose is fitted to them.
    Markers(Vec<String>),
}

/// The roles of a take's entities.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Roles {
    /// The back of the hand.
    pub hand: BodySource,
    /// The manipulated object, where it was tracked.
    pub object: Option<BodySource>,
    /// Marker on each fingertip, by name.
    pub fingers: PerFinger<String>,
}
