//! Provenance of a file.

use serde::{Deserialize, Serialize};

/// An input and its content.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct InputHash {
    /// File name without folders, so that the same inputs give the same bytes anywhere.
    pub name: String,
    /// SHA-256 of its content, lower-case hexadecimal.
    pub sha256: String,
}

/// One step on the way to a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Provenance {
    /// Tool and version, such as `inhand 0.1.0`.
    pub tool: String,
    /// The step, such as `convert`.
    pub step: String,
    /// Every setting that had an effect, as JSON.
    pub settings_json: String,
    /// What went in.
    pub inputs: Vec<InputHash>,
}
