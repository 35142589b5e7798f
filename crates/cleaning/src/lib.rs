//! What looks wrong in a recording, and cleaned recordings with every change listed.

#![warn(missing_docs)]

pub mod detect;
pub mod repair;

mod continuity;
mod error;
mod geometry;
mod lookup;
mod statistics;

pub use error::CleaningError;
