//! Files made by the mcap crate's writer, compared by its reader.

#![expect(
    clippy::unwrap_used,
    reason = "helpers of tests may stop at what cannot fail"
)]

mod audit;
mod kept;
mod merge;
mod recover;
mod select;
mod support;
mod timeline;
