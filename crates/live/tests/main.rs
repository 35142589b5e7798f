//! A server and clients on loopback. Nothing here depends on how long anything takes, but for limits
//! after which a test fails instead of hanging.

#![expect(
    clippy::unwrap_used,
    reason = "helpers of tests may stop at what cannot fail"
)]

mod client;
mod control;
mod files;
mod hostile;
mod playing;
mod refused;
mod viewers;
