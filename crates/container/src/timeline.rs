//! The messages of a file by log time, from any instant on.

mod blocks;
mod latest;
mod survey;

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};
use std::sync::Arc;

use mcap::records::{Record, op};

use crate::channel::ChannelFacts;
use crate::error::ContainerError;
use crate::format::spanned;
use crate::source::Source;
use crate::timeline::blocks::{Block, Cache, Entry};

/// A message of a [`Timeline`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct TimedMessage<'a> {
    /// Identifier of its channel.
    pub channel: u16,
    /// Its number as the writer counts.
    pub sequence: u32,
    /// When it was recorded, nanoseconds since 1970-01-01 UTC.
    pub log_time: u64,
    /// When it was sent, nanoseconds since 1970-01-01 UTC.
    pub publish_time: u64,
    /// Its bytes.
    pub data: &'a [u8],
}

/// A message that is kept.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct KeptMessage {
    /// Identifier of its channel.
    pub channel: u16,
    /// When it was recorded, nanoseconds since 1970-01-01 UTC.
    pub log_time: u64,
    /// Its bytes.
    pub data: Vec<u8>,
}

/// The messages of a file by log time, from any instant on.
///
/// Opening reads the summary; where a file has none, or one without indexes, it is walked through once.
/// After that only the chunks are read whose messages are asked for. In memory are the chunks that
/// overlap the instant at hand, at most 64 MiB of them or one; where more overlap, they are read again.
///
/// Messages of equal time come in the order in which they lie in the file.
///
/// ```
/// use std::io::Cursor;
///
/// use inhand_container::{Packing, Source, Timeline, Writer};
///
/// # fn main() -> Result<(), inhand_container::ContainerError> {
/// # let mut bag = Vec::new();
/// # let mut writer = Writer::new(&mut bag, "", "example", Packing::Zstd)?;
/// # let channel = writer.channel(0, "/a", "json", &Default::default())?;
/// # for log_time in [3, 1, 2] {
/// #     writer.message(channel, 0, log_time, |data| data.extend(b"{}"))?;
/// # }
/// # writer.finish()?;
/// let mut timeline = Timeline::open(Source::open("bag.mcap", Cursor::new(bag))?)?;
/// timeline.seek(2);
/// let mut times = Vec::new();
/// while let Some(message) = timeline.next_message()? {
///     times.push(message.log_time);
/// }
/// assert_eq!(times, [2, 3]);
/// assert_eq!(timeline.latest_before(2)?[0].log_time, 1);
/// # Ok(())
/// # }
/// ```
pub struct Timeline<'a> {
    source: Source<'a>,
    channels: BTreeMap<u16, ChannelFacts>,
    /// In the order of the file.
    blocks: Vec<Block>,
    /// Blocks by their first log time, then by their place in the file.
    by_start: Vec<usize>,
    cache: Cache,
    from: u64,
    /// How many of `by_start` have been looked at since the last seek.
    ahead: usize,
    active: BTreeMap<usize, Active>,
    /// Log time of the next message of each active block; ties by place in the file.
    due: BinaryHeap<Reverse<(u64, usize)>>,
    /// All different messages of channels on which each adds to those before, once they were asked for.
    lasting: Option<Vec<KeptMessage>>,
    /// What the message given last lies in.
    at_hand: Arc<Vec<u8>>,
}

/// A block with messages that are still to come.
struct Active {
    entries: Vec<Entry>,
    next: usize,
}

impl<'a> Timeline<'a> {
    /// Learns what is where in a file; starts at its first message.
    ///
    /// # Errors
    ///
    /// [`ContainerError::Truncated`] and [`ContainerError::Damaged`] where records do not follow each
    /// other or do not parse, [`ContainerError::Read`].
    pub fn open(mut source: Source<'a>) -> Result<Self, ContainerError> {
        let (definitions, blocks) = survey::survey(&mut source)?;
        let mut by_start: Vec<usize> = (0..blocks.len()).collect();
        by_start.sort_by_key(|&block| blocks[block].span.0);
        Ok(Self {
            source,
            channels: definitions.channels,
            blocks,
            by_start,
            cache: Cache::default(),
            from: 0,
            ahead: 0,
            active: BTreeMap::new(),
            due: BinaryHeap::new(),
            lasting: None,
            at_hand: Arc::default(),
        })
    }

    /// What errors call the file.
    pub fn file(&self) -> &str {
        self.source.file()
    }

    /// The channels by their identifiers, those without messages too.
    pub fn channels(&self) -> impl Iterator<Item = &ChannelFacts> {
        self.channels.values()
    }

    /// Log times of the earliest and the latest message, nanoseconds since 1970-01-01 UTC; `None`
    /// without messages.
    pub fn span(&self) -> Option<(u64, u64)> {
        (self.blocks.iter()).fold(None, |span, block| {
            Some(spanned(Some(spanned(span, block.span.0)), block.span.1))
        })
    }

    /// Goes to the first message that is not earlier.
    pub fn seek(&mut self, log_time: u64) {
        self.from = log_time;
        self.ahead = 0;
        self.active.clear();
        self.due.clear();
    }

    /// Log time of the message that comes next; `None` at the end.
    ///
    /// # Errors
    ///
    /// [`ContainerError::Truncated`] and [`ContainerError::Damaged`] where the file is not what it was
    /// when it was opened or its data is not sound, [`ContainerError::Read`].
    pub fn next_time(&mut self) -> Result<Option<u64>, ContainerError> {
        while let Some(&block) = self.by_start.get(self.ahead) {
            let (start, end) = self.blocks[block].span;
            if (self.due.peek()).is_some_and(|&Reverse((due, _))| due < start) {
                break;
            }
            self.ahead += 1;
            if end >= self.from {
                self.activate(block)?;
            }
        }
        Ok(self.due.peek().map(|&Reverse((due, _))| due))
    }

    /// The message that comes next; `None` at the end.
    ///
    /// # Errors
    ///
    /// As for [`next_time`](Self::next_time).
    pub fn next_message(&mut self) -> Result<Option<TimedMessage<'_>>, ContainerError> {
        self.next_time()?;
        let Some(Reverse((_, block))) = self.due.pop() else {
            return Ok(None);
        };
        self.at_hand = self.records(block)?;
        let Some(active) = self.active.get_mut(&block) else {
            return Ok(None);
        };
        let entry = active.entries[active.next].clone();
        active.next += 1;
        if let Some(next) = active.entries.get(active.next) {
            self.due.push(Reverse((next.log_time, block)));
        } else {
            self.active.remove(&block);
            self.cache.forget(block);
        }
        let place = self.source.place(self.blocks[block].offset);
        let body = self.at_hand.get(entry.body).unwrap_or_default();
        let Record::Message { header, data } = place.parse(op::MESSAGE, body)? else {
            return Err(place.short(op::MESSAGE));
        };
        Ok(Some(TimedMessage {
            channel: header.channel_id,
            sequence: header.sequence,
            log_time: header.log_time,
            publish_time: header.publish_time,
            data: &body[body.len() - data.len()..],
        }))
    }

    /// Takes the messages of a block in that are not too early.
    fn activate(&mut self, block: usize) -> Result<(), ContainerError> {
        let records = self.records(block)?;
        let mut entries = self.entries(block, &records)?;
        entries.retain(|entry| entry.log_time >= self.from);
        // Stable: of equal times the first in the file comes first.
        entries.sort_by_key(|entry| entry.log_time);
        if let Some(first) = entries.first() {
            self.due.push(Reverse((first.log_time, block)));
            self.active.insert(block, Active { entries, next: 0 });
        }
        Ok(())
    }

    /// The records of a block, unpacked.
    fn records(&mut self, block: usize) -> Result<Arc<Vec<u8>>, ContainerError> {
        if let Some(records) = self.cache.get(block) {
            return Ok(records);
        }
        let records = Arc::new(self.blocks[block].load(&mut self.source)?);
        self.cache.put(block, Arc::clone(&records));
        Ok(records)
    }

    /// The messages of a block in the order of the file.
    fn entries(&self, block: usize, records: &[u8]) -> Result<Vec<Entry>, ContainerError> {
        let block = &self.blocks[block];
        block.entries(records, self.source.place(block.offset), &self.channels)
    }
}

impl std::fmt::Debug for Timeline<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Timeline")
            .field("source", &self.source)
            .field("channels", &self.channels.len())
            .field("blocks", &self.blocks.len())
            .finish_non_exhaustive()
    }
}
