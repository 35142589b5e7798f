//! Tests of the channels crate from outside: what is written, what is read back, what is refused.

#![expect(
    clippy::unwrap_used,
    reason = "helpers of tests may stop at what cannot fail"
)]

mod common;

/// Events on the time line.
mod annotations;
/// A stretch of a file.
mod cut;
/// Bytes that are no sound file, or none of ours: refused with the place, never a panic.
mod damaged;
/// Records and chunks whose lengths lie.
mod lengths;
/// Listing files, ours and those of the mcap crate in every shape.
mod listing;
/// What is written comes back bit for bit.
mod round_trip;
/// Generated code and descriptors.
mod schemas;
/// Segments of a take by the block.
mod segments;
/// What viewers are given, read with the mcap and foxglove crates.
mod view;
