//! Plays a recording to viewers over the Foxglove WebSocket protocol: play, pause, seek, speed.
//!
//! A [`Server`] serves any MCAP file: messages go to viewers byte for byte, at the pace
//! at which they were recorded. It speaks `foxglove.sdk.v1` (Foxglove, with playback control) and the
//! older `foxglove.websocket.v1` (Lichtblick; there the time that goes back shows a seek).
//!
//! One thread reads the file and keeps the time; each viewer has a thread that listens to it and one that
//! sends to it. Everything for a viewer goes through one bounded queue: what comes after a seek cannot
//! overtake what came before it, and a viewer that reads too slowly misses messages, is warned, and
//! delays no other.

mod acceptor;
mod advertisement;
mod clients;
mod clock;
mod control;
mod error;
mod event;
mod guests;
mod outbox;
mod player;
mod protocol;
mod retained;
mod server;
mod start;
mod viewer;

pub use clock::{Clock, FASTEST, SLOWEST};
pub use control::{Control, Controls};
pub use error::LiveError;
pub use event::{DisconnectReason, Event, Mode, Progress};
pub use player::Repeat;
pub use server::{Played, Server, Settings};
