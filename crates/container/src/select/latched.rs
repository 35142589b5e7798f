//! Messages from before an interval that still hold in it.

use std::collections::BTreeMap;

use mcap::records::op;

use crate::channel::Latch;
use crate::format::{MESSAGE_HEADER_BYTES, MessageFacts, push_record, set_log_time};
use crate::interval::Interval;

/// Most bytes that are held for one channel; of more, the oldest messages go.
const MOST_BYTES: usize = 16 << 20;

/// Messages to start intervals with, by interval, in the order in which they came.
#[derive(Default)]
pub(super) struct Latched(BTreeMap<usize, Vec<Held>>);

struct Held {
    message: MessageFacts,
    body: Vec<u8>,
}

impl Held {
    fn data(&self) -> &[u8] {
        data(&self.body)
    }
}

impl Latched {
    /// Holds a message for the interval that starts next after it. Gives how many messages are left
    /// out for it: itself where no interval follows, or those that it replaces.
    pub(super) fn hold(
        &mut self,
        intervals: &[Interval],
        message: MessageFacts,
        latch: Latch,
        body: &[u8],
    ) -> u64 {
        let next = (intervals.iter().enumerate())
            .filter(|(_, interval)| interval.from_unix_nanos() > message.log_time)
            .min_by_key(|(_, interval)| interval.from_unix_nanos());
        let Some((interval, _)) = next else {
            return 1;
        };
        let held = self.0.entry(interval).or_default();
        let time = message.log_time;
        let of_channel = |held: &Held| held.message.channel == message.channel;
        let mut later = held.iter().filter(|held| held.message.log_time > time);
        if latch == Latch::Last && later.any(of_channel) {
            return 1;
        }
        let before = held.len();
        held.retain(|held| {
            let replaced = match latch {
                Latch::Last => true,
                Latch::All => held.message.log_time != time && held.data() == data(body),
            };
            !(of_channel(held) && replaced)
        });
        let body = body.to_vec();
        held.push(Held { message, body });
        loop {
            let mut own = (0..held.len()).filter(|&n| of_channel(&held[n]));
            let bytes: usize = own.clone().map(|n| held[n].body.len()).sum();
            match (own.next(), own.next()) {
                (Some(oldest), Some(_)) if bytes > MOST_BYTES => held.remove(oldest),
                _ => break,
            };
        }
        (before + 1 - held.len()) as u64
    }

    /// Adds the messages of an interval to records, with `log_time`; gives how many.
    pub(super) fn release(&mut self, interval: usize, log_time: u64, records: &mut Vec<u8>) -> u64 {
        let mut held = self.0.remove(&interval).unwrap_or_default();
        for held in &mut held {
            set_log_time(&mut held.body, log_time);
            push_record(records, op::MESSAGE, &held.body);
        }
        held.len() as u64
    }
}

/// The data of a message.
fn data(body: &[u8]) -> &[u8] {
    body.get(MESSAGE_HEADER_BYTES..).unwrap_or_default()
}
