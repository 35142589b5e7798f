//! Finds suspect samples in recordings and cleans them, with every change listed.
//!
//! * [`detect`] finds flipped bodies, swapped fingertips, spikes and lost labels, each with a range of
//!   samples, a score and what repair is suggested. Nothing is changed.
//! * [`repair`] does what was suggested; [`fill`](mod@fill), [`resample`] and [`offset`] are the other steps.
//! * [`clean`](fn@clean) chains the steps that are wished for.
//!
//! Every step says what it changed as [`Change`](inhand_model::Change)s. Nothing reads or writes files.

pub mod detect;
pub mod fill;
pub mod offset;
pub mod repair;

mod clean;
mod resample;

mod continuity;
mod error;
mod geometry;
mod lookup;
mod statistics;

pub use clean::{CleanSettings, Cleaned, clean};
pub use error::CleaningError;
pub use fill::{FillMethod, FillSettings, fill};
pub use offset::{PadOffset, to_pads};
pub use resample::resample;
