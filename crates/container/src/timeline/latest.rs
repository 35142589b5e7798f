//! Latest messages: the last one of each channel before an instant.

use std::cmp::Reverse;
use std::collections::btree_map::Entry as Place;
use std::collections::{BTreeMap, BTreeSet};

use crate::channel::{Latch, latch};
use crate::error::ContainerError;
use crate::format::MESSAGE_HEADER_BYTES;
use crate::timeline::blocks::Entry;
use crate::timeline::{KeptMessage, Timeline};

/// Most different messages of channels on which each adds to those before; of more, those that lie
/// first in the file count.
const MOST_LASTING: usize = 4096;

impl Timeline<'_> {
    /// What holds just before an instant, in the order of log time: of each channel the last message
    /// that is earlier, of those that hold on together ([`Latch::All`]) all different ones.
    ///
    /// Where the next messages are read from does not change.
    ///
    /// # Errors
    ///
    /// As for [`next_time`](Self::next_time).
    pub fn latest_before(&mut self, log_time: u64) -> Result<Vec<KeptMessage>, ContainerError> {
        let Some(last) = log_time.checked_sub(1) else {
            return Ok(Vec::new());
        };
        let adding: BTreeSet<u16> = (self.channels.values())
            .filter(|channel| latch(channel) == Some(Latch::All))
            .map(|channel| channel.id)
            .collect();
        let mut kept = self.lasting(&adding)?;
        kept.retain(|message| message.log_time <= last);
        kept.extend(self.last_of_each(&adding, last)?);
        // Stable: of equal times those that hold on come first.
        kept.sort_by_key(|message| message.log_time);
        Ok(kept)
    }

    /// The last message up to `last` of each channel but those in `without`.
    fn last_of_each(
        &mut self,
        without: &BTreeSet<u16>,
        last: u64,
    ) -> Result<Vec<KeptMessage>, ContainerError> {
        // The best of each channel so far, with its block.
        let mut found: BTreeMap<u16, (usize, KeptMessage)> = BTreeMap::new();
        // Whatever a block holds that counts is at most as late as this.
        let reach = |end: u64| end.min(last);
        let mut candidates: Vec<usize> = (0..self.blocks.len())
            .filter(|&block| self.blocks[block].span.0 <= last)
            .collect();
        candidates.sort_by_key(|&block| Reverse((reach(self.blocks[block].span.1), block)));
        for block in candidates {
            let reach = reach(self.blocks[block].span.1);
            let open = (self.blocks[block].channels.difference(without)).any(|channel| {
                (found.get(channel))
                    .is_none_or(|(best, message)| (message.log_time, *best) < (reach, block))
            });
            if !open {
                continue;
            }
            let records = self.records(block)?;
            for entry in self.entries(block, &records)? {
                if entry.log_time > last || without.contains(&entry.channel) {
                    continue;
                }
                // Of equal times the last in the file counts.
                let better = (found.get(&entry.channel)).is_none_or(|(best, message)| {
                    (message.log_time, *best) <= (entry.log_time, block)
                });
                if better {
                    let message = kept(&entry, &records);
                    found.insert(entry.channel, (block, message));
                }
            }
        }
        Ok(found.into_values().map(|(_, message)| message).collect())
    }

    /// All different messages of these channels, the first of equal ones. They are looked for once, in
    /// the whole file.
    fn lasting(&mut self, channels: &BTreeSet<u16>) -> Result<Vec<KeptMessage>, ContainerError> {
        if let Some(lasting) = &self.lasting {
            return Ok(lasting.clone());
        }
        let mut seen: BTreeMap<(u16, Vec<u8>), u64> = BTreeMap::new();
        for block in 0..self.blocks.len() {
            if self.blocks[block].channels.is_disjoint(channels) {
                continue;
            }
            let records = self.records(block)?;
            let entries = self.entries(block, &records)?;
            for entry in (entries.into_iter()).filter(|entry| channels.contains(&entry.channel)) {
                let message = kept(&entry, &records);
                let room = seen.len() < MOST_LASTING;
                match seen.entry((entry.channel, message.data)) {
                    Place::Occupied(mut time) => {
                        *time.get_mut() = entry.log_time.min(*time.get());
                    }
                    Place::Vacant(place) if room => {
                        place.insert(entry.log_time);
                    }
                    Place::Vacant(_) => {}
                }
            }
        }
        let lasting: Vec<_> = (seen.into_iter())
            .map(|((channel, data), log_time)| KeptMessage {
                channel,
                log_time,
                data,
            })
            .collect();
        self.lasting = Some(lasting.clone());
        Ok(lasting)
    }
}

fn kept(entry: &Entry, records: &[u8]) -> KeptMessage {
    let data = records[entry.body.clone()].get(MESSAGE_HEADER_BYTES..);
    KeptMessage {
        channel: entry.channel,
        log_time: entry.log_time,
        data: data.unwrap_or_default().to_vec(),
    }
}
