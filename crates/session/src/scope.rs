//! Parts of the results of a run.

use inhand_channels::Views;

/// Parts of the results that are written; by default those that the report and a look at the test takes need.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OutputScope {
    /// Channels that viewers draw without set-up.
    pub views: Views,
    /// Whether training takes are written too.
    pub train_takes: bool,
    /// Whether test takes have the motion of every method: otherwise of the default one and of the best baseline.
    pub all_methods: bool,
    /// Whether the rows have planned and recorded positions.
    pub row_positions: bool,
}
