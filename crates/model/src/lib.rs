//! The nouns of inhand: time, frames, poses, recordings, motions, segments, dictionaries,
//! trajectories, evaluations. Data and invariants, no algorithms, no files.
//!
//! Units are SI and stand in the names (`_m`, `_s`, `_m_s`, `_rad`); millimetres exist only in
//! reports. Frames are types: a [`Position<Hand>`] cannot be added to a [`Position<World>`], and a
//! [`Pose<To, From>`] reads target first, like its name in the code:
//!
//! ```
//! use inhand_model::{Hand, Object, Pose, Position, World};
//! use nalgebra::{Isometry3, Vector3};
//!
//! let world_from_hand = Pose::<World, Hand>::new(Isometry3::new(
//!     Vector3::new(1.0, 0.0, 0.0),
//!     Vector3::z() * std::f64::consts::FRAC_PI_2, // a quarter turn about z
//! ));
//! // One metre along the hand's x is one metre along the world's y, seen from where the hand is.
//! let tip_in_world = world_from_hand * Position::<Hand>::new(1.0, 0.0, 0.0);
//! assert!((tip_in_world.coords_m() - Vector3::new(1.0, 1.0, 0.0)).norm() < 1e-12);
//!
//! let world_from_object = Pose::<World, Object>::identity();
//! let hand_from_object: Pose<Hand, Object> = world_from_hand.inverse() * world_from_object;
//! # let _ = hand_from_object;
//! ```

mod annotations;
mod clock;
mod comparison;
mod contact_dynamics;
mod deviation_predictor;
mod dictionary;
mod evaluation;
mod finding;
mod finger;
mod formula;
mod frame;
mod illustrations;
mod inspection;
mod intervals;
mod motion;
mod movement;
mod names;
mod plan;
mod protocol;
mod provenance;
mod recording;
mod residual;
mod roles;
mod rows;
mod segments;
mod setting;
mod shape;
mod statistics;
mod stored;
mod summary;
mod track;
mod trajectory;
mod units;

// What these modules make public is the crate's: each noun has one name.
pub use annotations::*;
pub use clock::*;
pub use comparison::*;
pub use contact_dynamics::*;
pub use deviation_predictor::*;
pub use dictionary::*;
pub use evaluation::*;
pub use finding::*;
pub use finger::*;
pub use formula::*;
pub use frame::*;
pub use illustrations::*;
pub use inspection::*;
pub use intervals::*;
pub use motion::*;
pub use movement::*;
pub use plan::*;
pub use protocol::*;
pub use provenance::*;
pub use recording::*;
pub use residual::*;
pub use roles::*;
pub use rows::*;
pub use segments::*;
pub use setting::*;
pub use shape::*;
pub use statistics::*;
pub use stored::*;
pub use summary::*;
pub use track::*;
pub use trajectory::*;
