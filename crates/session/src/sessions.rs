//! Evaluations of many sessions: joined, compared, made in one go.
//!
//! What joins is a *part*: `evaluation.json` and, beside it, the `rows.parquet` of the same run. The parts
//! carry every judged instant, so that quantiles over sessions are exact, and recordings are not needed.

mod compare;
mod groups;
mod merge;
mod part;
mod settings;

pub use compare::{CompareOptions, compare};
pub use merge::{MergeOptions, merge};
pub use part::Part;
