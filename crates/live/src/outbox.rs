//! Bounded send queue of one client.

use std::mem;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

use tungstenite::protocol::frame::FrameHeader;
use tungstenite::protocol::frame::coding::{Control, Data, OpCode};

/// Bytes that may wait for one viewer; a viewer that is so far behind misses what comes.
const MOST_BYTES: usize = 16 << 20;

/// Bytes that wait for one viewer, as whole frames.
#[derive(Default)]
pub(crate) struct Outbox {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Default)]
struct State {
    bytes: Vec<u8>,
    /// Bytes that are taken and being sent.
    under_way: bool,
    /// Nothing more comes.
    closed: bool,
}

impl Outbox {
    /// Adds a text; false where there was no room for it, or the connection is closed.
    pub(crate) fn text(&self, text: &str) -> bool {
        self.frame(OpCode::Data(Data::Text), &[text.as_bytes()])
    }

    /// Adds a binary message made of parts; false as for [`Outbox::text`].
    pub(crate) fn binary(&self, parts: &[&[u8]]) -> bool {
        self.frame(OpCode::Data(Data::Binary), parts)
    }

    fn frame(&self, opcode: OpCode, parts: &[&[u8]]) -> bool {
        let length: usize = parts.iter().map(|part| part.len()).sum();
        let mut state = self.lock();
        // A message of any size goes where nothing else waits.
        let full = !state.bytes.is_empty() && state.bytes.len() + length > MOST_BYTES;
        let fits = !full && !state.closed;
        if fits {
            add(&mut state.bytes, opcode, parts);
        }
        fits
    }

    /// Adds frames as they are, such as answers to pings, where there is room.
    pub(crate) fn raw(&self, frames: &[u8]) {
        let mut state = self.lock();
        if !state.closed && state.bytes.len() + frames.len() <= MOST_BYTES {
            state.bytes.extend_from_slice(frames);
            drop(state);
            self.changed.notify_all();
        }
    }

    /// Says that there is something to send: once after many frames.
    pub(crate) fn wake(&self) {
        self.changed.notify_all();
    }

    /// Closes the connection after what waits.
    pub(crate) fn close(&self) {
        let mut state = self.lock();
        if !mem::replace(&mut state.closed, true) {
            // Code 1001: the server goes away.
            let reason = 1001_u16.to_be_bytes();
            add(
                &mut state.bytes,
                OpCode::Control(Control::Close),
                &[&reason],
            );
        }
        drop(state);
        self.changed.notify_all();
    }

    /// Sends what waits and no more.
    pub(crate) fn finish(&self) {
        self.lock().closed = true;
        self.changed.notify_all();
    }

    /// Sends nothing more.
    pub(crate) fn abandon(&self) {
        let mut state = self.lock();
        state.closed = true;
        state.bytes = Vec::new();
        drop(state);
        self.changed.notify_all();
    }

    /// Whether all was sent.
    pub(crate) fn is_empty(&self) -> bool {
        let state = self.lock();
        state.bytes.is_empty() && !state.under_way
    }

    /// Waits for bytes and takes all of them, in exchange for the empty `sent`; `false` when nothing
    /// more comes.
    pub(crate) fn take(&self, sent: &mut Vec<u8>) -> bool {
        sent.clear();
        // The memory of a burst is given back.
        sent.shrink_to(1 << 20);
        let mut state = self.lock();
        state.under_way = false;
        while state.bytes.is_empty() && !state.closed {
            state = (self.changed.wait(state)).unwrap_or_else(PoisonError::into_inner);
        }
        mem::swap(&mut state.bytes, sent);
        state.under_way = !sent.is_empty();
        state.under_way
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        // What is guarded is whole between any two statements.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn add(bytes: &mut Vec<u8>, opcode: OpCode, parts: &[&[u8]]) {
    let length: usize = parts.iter().map(|part| part.len()).sum();
    let header = FrameHeader {
        opcode,
        ..FrameHeader::default()
    };
    let start = bytes.len();
    match header.format(length as u64, bytes) {
        Ok(()) => parts.iter().for_each(|part| bytes.extend_from_slice(part)),
        // Vectors take everything: there is no other error that it could give.
        Err(_) => bytes.truncate(start),
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::thread;

    use super::*;

    #[test]
    fn frames_are_taken_in_order() {
        let outbox = Outbox::default();
        assert!(outbox.text("ab"));
        assert!(outbox.binary(&[&[1], &[2, 3]]));
        let mut sent = Vec::new();
        assert!(outbox.take(&mut sent));
        assert_eq!(sent, [0x81, 2, b'a', b'b', 0x82, 3, 1, 2, 3]);
        assert!(!outbox.is_empty(), "it is being sent");
        outbox.close();
        assert!(!outbox.text("late"));
        assert!(outbox.take(&mut sent));
        assert_eq!(sent, [0x88, 2, 0x03, 0xe9]);
        assert!(!outbox.take(&mut sent));
        assert!(outbox.is_empty());
    }

    #[test]
    fn what_does_not_fit_is_left_out_whole() {
        let outbox = Outbox::default();
        // Alone it may be larger.
        let large = vec![0; MOST_BYTES + 1];
        assert!(outbox.binary(&[&large]));
        assert!(!outbox.binary(&[&[1]]));
        outbox.raw(&[0x8a, 0]);
        let mut sent = Vec::new();
        assert!(outbox.take(&mut sent));
        assert_eq!(sent.len(), 10 + large.len());
        assert!(outbox.binary(&[&[1]]));
    }

    #[test]
    fn a_waiting_thread_is_woken_by_the_end() {
        let outbox = Arc::new(Outbox::default());
        let waits = thread::spawn({
            let outbox = Arc::clone(&outbox);
            move || outbox.take(&mut Vec::new())
        });
        outbox.abandon();
        assert!(!waits.join().expect("taking does not panic"));
    }
}
