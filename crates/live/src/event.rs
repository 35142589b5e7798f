//! Events of a playback, for the console.

use std::fmt;
use std::net::SocketAddr;

/// Reason why a viewer is disconnected.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum DisconnectReason {
    /// It closed the connection.
    Closed,
    /// The connection broke; the error of the system.
    Vanished(String),
    /// It read nothing for so long that it was disconnected.
    Stalled,
}

impl fmt::Display for DisconnectReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            DisconnectReason::Closed => f.write_str("left"),
            DisconnectReason::Vanished(why) => write!(f, "vanished ({why})"),
            DisconnectReason::Stalled => {
                f.write_str("was disconnected: it read nothing for too long")
            }
        }
    }
}

/// A change while a recording is played.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Event {
    /// A viewer has connected.
    Arrived {
        /// Its address.
        viewer: SocketAddr,
    },
    /// A viewer is no longer there.
    Left {
        /// Its address.
        viewer: SocketAddr,
        /// The reason.
        how: DisconnectReason,
    },
    /// A viewer read too slowly, did not get some messages, and goes on from here.
    Missed {
        /// Its address.
        viewer: SocketAddr,
        /// Messages that it did not get.
        messages: u64,
    },
    /// A client connected that does not speak the protocol.
    Strange {
        /// Its address.
        viewer: SocketAddr,
    },
    /// A client was not let in.
    Refused {
        /// Its address.
        viewer: SocketAddr,
        /// The reason.
        why: String,
    },
    /// A client that wants or reads nothing was disconnected, to make room for another.
    PutOut {
        /// Its address.
        viewer: SocketAddr,
    },
    /// There are too many viewers for one more.
    Full {
        /// Its address.
        viewer: SocketAddr,
        /// Number of viewers.
        viewers: usize,
    },
    /// A topic cannot be advertised.
    LeftOut {
        /// Its name.
        topic: String,
        /// The reason.
        why: String,
    },
    /// The end is reached.
    Ended,
    /// The state of playback; comes a few times a second, and at every change.
    Progress(Progress),
}

/// The state of playback.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Progress {
    /// Seconds since the first message.
    pub at_s: f64,
    /// Seconds from the first to the last message.
    pub duration_s: f64,
    /// Seconds of the recording a second.
    pub speed: f64,
    /// Mode of playback.
    pub mode: Mode,
    /// Number of connected viewers.
    pub viewers: usize,
}

/// Mode of playback.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Mode {
    /// Time passes.
    Playing,
    /// Paused on request.
    Paused,
    /// Paused because no client is subscribed.
    Waiting,
    /// Paused at the end.
    Ended,
}
