//! Bounded send queue of one client.

use std::collections::VecDeque;
use std::mem;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use tungstenite::protocol::frame::FrameHeader;
use tungstenite::protocol::frame::coding::{Control, Data, OpCode};

/// Bytes that may wait for all viewers together, beyond those that each may have in any case.
const MOST_BYTES_TOGETHER: usize = 64 << 20;

/// Bytes that may wait for a viewer however many wait for others.
const LEAST_BYTES: usize = 256 << 10;

/// Bytes that may wait for one viewer; a viewer that is so far behind misses what comes.
const MOST_BYTES: usize = 16 << 20;

/// Bytes from which on frames go into another block.
const BLOCK_BYTES: usize = 64 << 10;

/// Time that bytes may be under way before a viewer counts as one that does not read.
const STUCK: Duration = Duration::from_secs(2);

/// Bytes that wait for all viewers of a server, those under way included.
pub(crate) type Together = Arc<AtomicUsize>;

/// Merits of a connection: the least is the first to go where there are too many.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Merit {
    /// It has not finished its handshake.
    Greeting,
    /// It wants nothing.
    Silent,
    /// It does not read what it wants.
    Behind,
    /// It reads.
    Reading,
}

/// Bytes that wait for one viewer, as whole frames.
pub(crate) struct Outbox {
    state: Mutex<State>,
    changed: Condvar,
    together: Together,
}

/// Whole frames, sent together.
#[derive(Default)]
struct Block {
    bytes: Vec<u8>,
    /// Messages of the recording among them.
    messages: u64,
}

struct State {
    waiting: VecDeque<Block>,
    /// Their bytes.
    bytes: usize,
    /// Bytes that are taken and being sent, and since when.
    under_way: usize,
    since: Instant,
    /// Nothing more comes.
    closed: bool,
    merit: Merit,
}

impl Outbox {
    pub(crate) fn new(together: Together) -> Self {
        Self {
            state: Mutex::new(State {
                waiting: VecDeque::new(),
                bytes: 0,
                under_way: 0,
                since: Instant::now(),
                closed: false,
                merit: Merit::Greeting,
            }),
            changed: Condvar::new(),
            together,
        }
    }

    /// Notes what the viewer does.
    pub(crate) fn deserves(&self, merit: Merit) {
        self.lock().merit = merit;
    }

    /// Merit of the viewer now.
    pub(crate) fn merit(&self) -> Merit {
        let state = self.lock();
        match state.is_stuck() {
            true => state.merit.min(Merit::Behind),
            false => state.merit,
        }
    }

    /// Adds a text; false where there was no room for it, or the connection is closed.
    pub(crate) fn text(&self, text: &str) -> bool {
        self.frame(OpCode::Data(Data::Text), &[text.as_bytes()], 0)
    }

    /// Adds a binary message made of parts; false as for [`Outbox::text`].
    pub(crate) fn binary(&self, parts: &[&[u8]]) -> bool {
        self.frame(OpCode::Data(Data::Binary), parts, 0)
    }

    /// Adds a message of the recording; false as for [`Outbox::text`].
    pub(crate) fn message(&self, parts: &[&[u8]]) -> bool {
        self.frame(OpCode::Data(Data::Binary), parts, 1)
    }

    fn frame(&self, opcode: OpCode, parts: &[&[u8]], messages: u64) -> bool {
        let length: usize = parts.iter().map(|part| part.len()).sum();
        let mut state = self.lock();
        let fits = !state.closed && self.has_room(&state, length);
        if fits {
            self.add(&mut state, messages, |bytes| {
                add(bytes, opcode, parts);
            });
        }
        fits
    }

    /// Whether there is room for so many bytes. A message of any size goes where nothing else waits. Otherwise a
    /// viewer may have half of what is left for all: those that do not read leave room for those that do
    /// (A. K. Choudhury and E. L. Hahne, *Dynamic queue length thresholds*, IEEE/ACM Trans. Networking 6(2), 1998).
    fn has_room(&self, state: &State, length: usize) -> bool {
        let own = state.bytes + state.under_way;
        let left = MOST_BYTES_TOGETHER.saturating_sub(self.together.load(Ordering::Relaxed));
        own == 0 || own + length <= (left / 2).clamp(LEAST_BYTES, MOST_BYTES)
    }

    /// Adds whole frames to the last block, or to a new one where that is full.
    fn add(&self, state: &mut State, messages: u64, add: impl FnOnce(&mut Vec<u8>)) {
        if (state.waiting.back()).is_none_or(|block| block.bytes.len() >= BLOCK_BYTES) {
            state.waiting.push_back(Block::default());
        }
        if let Some(block) = state.waiting.back_mut() {
            let before = block.bytes.len();
            add(&mut block.bytes);
            block.messages += messages;
            let more = block.bytes.len() - before;
            state.bytes += more;
            self.together.fetch_add(more, Ordering::Relaxed);
        }
    }

    /// Drops what waits; number of messages of the recording in it.
    fn drop_waiting(&self, state: &mut State) -> u64 {
        self.together.fetch_sub(state.bytes, Ordering::Relaxed);
        state.bytes = 0;
        state.waiting.drain(..).map(|block| block.messages).sum()
    }

    /// Drops what waits for a viewer that has not read anything for a while: it keeps nothing from others. Number
    /// of messages that it does not get.
    pub(crate) fn relieve(&self) -> u64 {
        let mut state = self.lock();
        match state.is_stuck() {
            true => self.drop_waiting(&mut state),
            false => 0,
        }
    }

    /// Adds frames as they are, such as answers to pings, where there is room.
    pub(crate) fn raw(&self, frames: &[u8]) {
        let mut state = self.lock();
        if !state.closed && self.has_room(&state, frames.len()) {
            self.add(&mut state, 0, |bytes| bytes.extend_from_slice(frames));
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
            self.add(&mut state, 0, |bytes| {
                add(bytes, OpCode::Control(Control::Close), &[&reason]);
            });
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
        self.drop_waiting(&mut state);
        drop(state);
        self.changed.notify_all();
    }

    /// Whether all was sent.
    pub(crate) fn is_empty(&self) -> bool {
        let state = self.lock();
        state.bytes == 0 && state.under_way == 0
    }

    /// Waits for bytes and takes the first of them, in exchange for those that were sent; `false` when nothing
    /// more comes.
    pub(crate) fn take(&self, sent: &mut Vec<u8>) -> bool {
        *sent = Vec::new();
        let mut state = self.lock();
        self.together.fetch_sub(state.under_way, Ordering::Relaxed);
        state.under_way = 0;
        while state.waiting.is_empty() && !state.closed {
            state = (self.changed.wait(state)).unwrap_or_else(PoisonError::into_inner);
        }
        let Some(block) = state.waiting.pop_front() else {
            return false;
        };
        *sent = block.bytes;
        state.bytes -= sent.len();
        (state.under_way, state.since) = (sent.len(), Instant::now());
        true
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        // What is guarded is whole between any two statements.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    fn is_stuck(&self) -> bool {
        self.under_way > 0 && self.since.elapsed() > STUCK
    }
}

impl Drop for Outbox {
    fn drop(&mut self) {
        let state = self.lock();
        let left = state.bytes + state.under_way;
        drop(state);
        self.together.fetch_sub(left, Ordering::Relaxed);
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
    use std::thread;

    use super::*;

    #[test]
    fn frames_are_taken_in_order() {
        let outbox = Outbox::new(Together::default());
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
        let outbox = Outbox::new(Together::default());
        // Alone it may be larger.
        let large = vec![0; MOST_BYTES + 1];
        assert!(outbox.binary(&[&large]));
        assert!(!outbox.binary(&[&[1]]));
        outbox.raw(&[0x8a, 0]);
        let mut sent = Vec::new();
        assert!(outbox.take(&mut sent));
        assert_eq!(sent.len(), 10 + large.len());
        assert!(!outbox.binary(&[&[1]]), "it is under way");
        outbox.finish();
        assert!(!outbox.take(&mut sent));
        assert_eq!(outbox.together.load(Ordering::Relaxed), 0);
    }

    #[test]
    fn those_who_do_not_read_leave_room_for_those_who_do() {
        let together = Together::default();
        let outboxes: Vec<Outbox> = (0..64)
            .map(|_| Outbox::new(Arc::clone(&together)))
            .collect();
        let message = vec![0; 64 << 10];
        while outboxes.iter().any(|outbox| outbox.binary(&[&message])) {}
        let held = together.load(Ordering::Relaxed);
        let most = MOST_BYTES_TOGETHER + outboxes.len() * LEAST_BYTES;
        assert!(held <= most, "{held}");
        let late = Outbox::new(Arc::clone(&together));
        for _ in 0..LEAST_BYTES / message.len() - 1 {
            assert!(late.binary(&[&message]));
        }
        drop((outboxes, late));
        assert_eq!(together.load(Ordering::Relaxed), 0);
    }

    #[test]
    fn a_waiting_thread_is_woken_by_the_end() {
        let outbox = Arc::new(Outbox::new(Together::default()));
        let waits = thread::spawn({
            let outbox = Arc::clone(&outbox);
            move || outbox.take(&mut Vec::new())
        });
        outbox.abandon();
        assert!(!waits.join().expect("taking does not panic"));
    }
}
