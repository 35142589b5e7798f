//! Intervals of a file that are read at once: chunks, and messages outside of them.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::sync::Arc;

use mcap::records::op;

use crate::channel::ChannelFacts;
use crate::chunk::unpack;
use crate::error::{ContainerError, Place};
use crate::format::{MessageFacts, PREFIX_BYTES, Records, name_of, spanned};
use crate::source::Source;

/// Unpacked blocks that are kept, however many overlap.
const KEPT_BYTES: usize = 64 << 20;

/// What a block is in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// One chunk record.
    Chunk,
    /// Message records that follow each other.
    Loose,
}

/// An interval of a file with messages.
#[derive(Clone, Debug)]
pub(super) struct Block {
    pub(super) kind: Kind,
    pub(super) offset: u64,
    /// With the prefixes of its records.
    pub(super) bytes: u64,
    /// Log times of its earliest and latest message.
    pub(super) span: (u64, u64),
    /// Channels with messages in it.
    pub(super) channels: BTreeSet<u16>,
}

/// A message of a block.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    pub(super) channel: u16,
    pub(super) log_time: u64,
    /// Where its body lies in the records of the block.
    pub(super) body: Range<usize>,
}

impl Block {
    /// Counts a message in.
    pub(super) fn add(&mut self, message: MessageFacts) {
        self.span = spanned(Some(self.span), message.log_time);
        self.channels.insert(message.channel);
    }

    /// Reads its records, unpacked, its checksum compared.
    pub(super) fn load(&self, source: &mut Source<'_>) -> Result<Vec<u8>, ContainerError> {
        let mut bytes = Vec::new();
        source.read_at(self.offset, self.bytes, &mut bytes)?;
        let place = source.place(self.offset);
        let found = bytes.len() as u64;
        let Some((&[opcode, ref length @ ..], body)) =
            (bytes.split_first_chunk::<PREFIX_BYTES>()).filter(|_| found == self.bytes)
        else {
            // The file has become shorter than it was.
            let record = match self.kind {
                Kind::Chunk => op::CHUNK,
                Kind::Loose => op::MESSAGE,
            };
            return Err(place.truncated(name_of(record), self.bytes, found));
        };
        if self.kind == Kind::Loose {
            return Ok(bytes);
        }
        if opcode != op::CHUNK || u64::from_le_bytes(*length) != body.len() as u64 {
            let expected = format!("a chunk of {} bytes, as when it was opened", self.bytes);
            return Err(place.error(name_of(op::CHUNK), expected, "other bytes"));
        }
        let mut records = Vec::new();
        unpack(place, body, &mut records)?;
        Ok(records)
    }

    /// Its messages in the order of the file.
    pub(super) fn entries(
        &self,
        records: &[u8],
        place: Place<'_>,
        channels: &BTreeMap<u16, ChannelFacts>,
    ) -> Result<Vec<Entry>, ContainerError> {
        let mut entries = Vec::new();
        for (facts, body) in messages(records, place) {
            let facts = facts?;
            let (start, end) = self.span;
            if !(start..=end).contains(&facts.log_time) {
                let expected = format!("a log time from {start} to {end}, as its chunk states");
                return Err(place.error(
                    name_of(op::MESSAGE),
                    expected,
                    facts.log_time.to_string(),
                ));
            }
            if !channels.contains_key(&facts.channel) {
                let found = format!("none with number {}", facts.channel);
                return Err(place.error(name_of(op::MESSAGE), "the channel that it names", found));
            }
            entries.push(Entry {
                channel: facts.channel,
                log_time: facts.log_time,
                body,
            });
        }
        Ok(entries)
    }
}

/// The messages among records, and where in them their bodies lie.
pub(super) fn messages<'a>(
    records: &'a [u8],
    place: Place<'a>,
) -> impl Iterator<Item = (Result<MessageFacts, ContainerError>, Range<usize>)> + 'a {
    let mut start = 0;
    Records(records).filter_map(move |record| {
        let Some((opcode, body)) = record else {
            return Some((Err(place.short(op::MESSAGE)), 0..0));
        };
        let range = start + PREFIX_BYTES..start + PREFIX_BYTES + body.len();
        start = range.end;
        let facts = || MessageFacts::read(body).ok_or_else(|| place.short(op::MESSAGE));
        (opcode == op::MESSAGE).then(|| (facts(), range))
    })
}

/// Unpacked blocks, those used last.
#[derive(Default)]
pub(super) struct Cache {
    /// The one used last comes last.
    kept: Vec<(usize, Arc<Vec<u8>>)>,
}

impl Cache {
    pub(super) fn get(&mut self, block: usize) -> Option<Arc<Vec<u8>>> {
        let place = self.kept.iter().rposition(|(kept, _)| *kept == block)?;
        self.kept[place..].rotate_left(1);
        self.kept.last().map(|(_, records)| Arc::clone(records))
    }

    pub(super) fn put(&mut self, block: usize, records: Arc<Vec<u8>>) {
        self.kept.push((block, records));
        let mut bytes: usize = self.kept.iter().map(|(_, records)| records.len()).sum();
        while bytes > KEPT_BYTES && self.kept.len() > 1 {
            bytes -= self.kept.remove(0).1.len();
        }
    }

    pub(super) fn forget(&mut self, block: usize) {
        self.kept.retain(|(kept, _)| *kept != block);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_blocks_used_last_are_kept_within_the_limit() {
        let mut cache = Cache::default();
        let third = Arc::new(vec![0; KEPT_BYTES / 3]);
        for block in 0..3 {
            cache.put(block, Arc::clone(&third));
        }
        assert!(cache.get(0).is_some());
        cache.put(3, Arc::clone(&third));
        let kept: Vec<bool> = (0..4).map(|block| cache.get(block).is_some()).collect();
        assert_eq!(kept, [true, false, true, true]);
        // One that is too large stays alone: it is being read.
        cache.put(4, Arc::new(vec![0; KEPT_BYTES + 1]));
        let kept: Vec<bool> = (0..5).map(|block| cache.get(block).is_some()).collect();
        assert_eq!(kept, [false, false, false, false, true]);
    }
}
