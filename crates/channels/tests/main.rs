//! Tests of the channels crate from outside: what is written, what is read back, what is refused.

#![expect(
    clippy::unwrap_used,
    reason = "helpers of tests may stop at what cannot fail"
)]

mod common;

mod schemas;
