//! How well planned trajectories match recorded motion.

mod constraints;
mod contacts;
mod input;
mod instants;
mod method;
mod quality;
mod recorded;

pub use input::{EvaluationSettings, MethodResult, TestData};
pub use method::{Rows, evaluate_method};
pub use quality::recording_quality;
pub use recorded::{Recorded, recorded};
