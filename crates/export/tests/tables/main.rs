//! Tables of recordings, motions and events, and back.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod bids;
mod common;
mod events;
mod fingers;
mod parquet;
mod rows;
mod wide;
