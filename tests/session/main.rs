//! The steps on values, against what is true of simulated takes; takes too long for memory on files.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod demo;
mod held_out;
mod long_take;
mod truth;
