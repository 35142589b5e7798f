//! Messages from before a stretch that still hold in it.

use std::collections::BTreeMap;

use mcap::records::op;

use crate::channel::Latch;
use crate::format::{MESSAGE_HEADER_BYTES, MessageFacts, push_record, set_log_time};
use crate::interval::Interval;

/// Most bytes that are held for one channel; of more, the oldest messages go.
const MOST_BYTES: usize = 16 << 20;

/// Messages to start stretches with.
#[derive(Default)]
pub(super) struct Latched {
    /// By stretch and channel, in the order in which they came.
    held: BTreeMap<usize, BTreeMap<u16, Vec<Held>>>,
    came: u64,
}

struct Held {
    time: u64,
    order: u64,
    body: Vec<u8>,
}

impl Latched {
    /// Holds a message for the stretch that starts next after it. Gives how many messages are left
    /// out for it: itself where no stretch follows, or those that it replaces.
    pub(super) fn hold(
        &mut self,
        stretches: &[Interval],
        facts: MessageFacts,
        latch: Latch,
        body: &[u8],
    ) -> u64 {
        let next = (stretches.iter().enumerate())
            .filter(|(_, stretch)| stretch.from_unix_nanos() > facts.log_time)
            .min_by_key(|(_, stretch)| stretch.from_unix_nanos());
        let Some((stretch, _)) = next else {
            return 1;
        };
        let held = (self.held.entry(stretch).or_default())
            .entry(facts.channel)
            .or_default();
        let before = held.len();
        match latch {
            Latch::Last if held.iter().any(|held| held.time > facts.log_time) => return 1,
            Latch::Last => held.clear(),
            Latch::All => {
                held.retain(|held| {
                    held.time == facts.log_time || content(&held.body) != content(body)
                });
            }
        }
        let replaced = before - held.len();
        held.push(Held {
            time: facts.log_time,
            order: self.came,
            body: body.to_vec(),
        });
        self.came += 1;
        let mut forgotten = replaced as u64;
        while held.len() > 1 && held.iter().map(|held| held.body.len()).sum::<usize>() > MOST_BYTES
        {
            held.remove(0);
            forgotten += 1;
        }
        forgotten
    }

    /// Adds the messages of a stretch to records, with `log_time`; gives how many.
    pub(super) fn release(&mut self, stretch: usize, log_time: u64, records: &mut Vec<u8>) -> u64 {
        let Some(held) = self.held.remove(&stretch) else {
            return 0;
        };
        let mut held: Vec<Held> = held.into_values().flatten().collect();
        held.sort_by_key(|held| held.order);
        for held in &mut held {
            set_log_time(&mut held.body, log_time);
            push_record(records, op::MESSAGE, &held.body);
        }
        held.len() as u64
    }
}

/// The data of a message.
fn content(body: &[u8]) -> &[u8] {
    body.get(MESSAGE_HEADER_BYTES..).unwrap_or_default()
}
