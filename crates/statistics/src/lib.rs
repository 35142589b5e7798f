//! Statistics of distributions: one definition each of quantile, summary and interval.
//!
//! * [`quantiles`]: quantiles and summaries of a distribution.
//! * [`bootstrap`]: intervals of statistics over clusters of rows, paired differences.
//!
//! ```
//! use inhand_statistics::quantiles::statistics;
//!
//! let summary = statistics(vec![4.0, 1.0, 2.0, 3.0], 0, 0);
//! assert_eq!((summary.n, summary.p50, summary.max), (4, 2.5, 4.0));
//! ```

pub mod bootstrap;
mod error;
pub mod quantiles;
mod sort;

pub use error::BootstrapError;
