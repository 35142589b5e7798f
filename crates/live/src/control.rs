//! Commands to a player: from its clients, and from the rest of the program.

use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::mpsc::SyncSender;

use crate::event::DisconnectReason;
use crate::outbox::Outbox;
use crate::protocol::{Request, Subprotocol};

/// A connected client.
#[derive(Clone)]
pub(crate) struct Viewer {
    pub(crate) number: u64,
    pub(crate) address: SocketAddr,
    pub(crate) subprotocol: Subprotocol,
    pub(crate) outbox: Arc<Outbox>,
}

/// A command to a player.
pub(crate) enum Command {
    Arrived(Viewer),
    Asked(u64, Request),
    Misunderstood(u64, String),
    Gone(u64, DisconnectReason),
    Strange(SocketAddr),
    Refused(SocketAddr, String),
    PutOut(SocketAddr),
    Full(SocketAddr, usize),
    Control(Control),
}

/// A control of playback.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Control {
    /// Pauses, or plays on; at the end, plays anew.
    Toggle,
    /// Goes to so many seconds after the first message.
    SeekTo(f64),
    /// Goes on by so many seconds, or back.
    SeekBy(f64),
    /// Plays at the next faster of the usual speeds.
    Faster,
    /// Plays at the next slower of the usual speeds.
    Slower,
    /// Disconnects all viewers and ends.
    Stop,
}

/// Speeds that go well by hand.
const USUAL: [f64; 10] = [0.05, 0.1, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0];

/// The next faster usual speed, or the one there is.
pub(crate) fn faster(speed: f64) -> f64 {
    let next = USUAL.into_iter().find(|&usual| usual > speed);
    next.unwrap_or(speed)
}

/// The next slower usual speed, or the one there is.
pub(crate) fn slower(speed: f64) -> f64 {
    let next = USUAL.into_iter().rfind(|&usual| usual < speed);
    next.unwrap_or(speed)
}

/// Controls a player from any thread.
#[derive(Clone, Debug)]
pub struct Controls {
    player: SyncSender<Command>,
}

impl Controls {
    pub(crate) fn new(player: SyncSender<Command>) -> Self {
        Self { player }
    }

    /// Asks for something; `false` where the player has ended.
    pub fn send(&self, control: Control) -> bool {
        self.player.send(Command::Control(control)).is_ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speeds_go_up_and_down_one_at_a_time() {
        assert_eq!((faster(1.0), slower(1.0)), (2.0, 0.5));
        assert_eq!((faster(1.2), slower(1.2)), (2.0, 1.0));
        assert_eq!((faster(50.0), slower(0.01)), (50.0, 0.01));
    }
}
