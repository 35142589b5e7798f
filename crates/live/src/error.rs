//! Errors of playback.

use std::io;

use inhand_container::ContainerError;
use thiserror::Error;

/// Reasons why a recording is not played, or no longer.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LiveError {
    /// Another program listens there.
    #[error(
        "{host}:{port}: another program uses this port: end it (perhaps another `inhand play`), or take \
         another port: --port 0 takes any that is free"
    )]
    PortInUse {
        /// The address.
        host: String,
        /// The port.
        port: u16,
    },
    /// The address cannot be bound.
    #[error(
        "{host}:{port}: cannot listen: expected an address of this computer, such as 127.0.0.1 (viewers \
         here) or 0.0.0.0 (viewers anywhere), and a port that may be used"
    )]
    Bind {
        /// The address.
        host: String,
        /// The port.
        port: u16,
        /// The cause.
        source: io::Error,
    },
    /// There is nothing to play.
    #[error("{file}: no messages: expected at least one, found {channels} channels without any")]
    Empty {
        /// File that was read.
        file: String,
        /// Number of its channels.
        channels: usize,
    },
    /// A speed at which nothing can be played.
    #[error("speed {found}: expected {slowest} to {fastest} (1 is as recorded)")]
    Speed {
        /// The speed asked for.
        found: f64,
        /// The slowest.
        slowest: f64,
        /// The fastest.
        fastest: f64,
    },
    /// A start outside the file.
    #[error("start at {found} s: expected 0 to {duration_s} s, which {file} lasts")]
    Start {
        /// File that was read.
        file: String,
        /// The start asked for, seconds since the first message.
        found: f64,
        /// Seconds from the first to the last message.
        duration_s: f64,
    },
    /// The file could not be read, or not any more.
    #[error(transparent)]
    File(#[from] ContainerError),
    /// The system gives no threads.
    #[error("cannot start a thread for viewers")]
    Thread {
        /// The cause.
        source: io::Error,
    },
}
