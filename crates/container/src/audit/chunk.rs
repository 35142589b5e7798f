//! A chunk against its header, its message indexes and its entry in the summary.

use std::collections::BTreeMap;

use mcap::records::{ChunkHeader, ChunkIndex, MessageHeader, MessageIndex, MessageIndexEntry};

use super::differences::Differences;
use crate::format::spanned;
use crate::source::Head;

/// A chunk whose message indexes are being read.
pub(super) struct OpenChunk {
    head: Head,
    header: ChunkHeader,
    /// Messages of each channel that no index was compared with yet, in their order.
    messages: BTreeMap<u16, Vec<MessageIndexEntry>>,
    span: Option<(u64, u64)>,
    /// Where the message index of each channel is.
    indexes: BTreeMap<u16, u64>,
    /// End of the last message index, or of the chunk.
    end: u64,
}

impl OpenChunk {
    pub(super) fn new(head: Head, header: ChunkHeader) -> Self {
        Self {
            head,
            header,
            messages: BTreeMap::new(),
            span: None,
            indexes: BTreeMap::new(),
            end: head.end(),
        }
    }

    /// Where the chunk starts.
    pub(super) fn offset(&self) -> u64 {
        self.head.offset
    }

    /// Adds a message, whose record starts at this byte of the unpacked records.
    pub(super) fn message(&mut self, header: &MessageHeader, offset: u64) {
        let log_time = header.log_time;
        self.span = Some(spanned(self.span, log_time));
        let of_channel = self.messages.entry(header.channel_id).or_default();
        of_channel.push(MessageIndexEntry { log_time, offset });
    }

    /// Compares a message index with the messages of its channel.
    pub(super) fn index(&mut self, head: Head, index: MessageIndex, found: &mut Differences) {
        let channel = index.channel_id;
        let place = format_args!("byte {}: message index of channel {channel}", head.offset);
        self.end = head.end();
        if self.indexes.insert(channel, head.offset).is_some() {
            found.add(place, "one for each channel", "a second one");
            return;
        }
        let held = self.messages.remove(&channel).unwrap_or_default();
        let mut stated = index.records;
        stated.sort_by_key(|entry| entry.offset);
        let unlike = (0..held.len().max(stated.len())).find(|&k| held.get(k) != stated.get(k));
        if let Some(k) = unlike {
            found.add(place, in_words(held.get(k)), in_words(stated.get(k)));
        }
    }

    /// Compares what is left, with the entry of the summary where that has entries; whether the chunk has the message
    /// indexes that it needs.
    pub(super) fn close(
        self,
        entry: Option<ChunkIndex>,
        has_entries: bool,
        found: &mut Differences,
    ) -> bool {
        let header = &self.header;
        let place = format!("byte {}: chunk", self.head.offset);
        if let Some(span) = self.span {
            let stated = (header.message_start_time, header.message_end_time);
            found.compare(
                format_args!("{place}, log times"),
                times(span),
                times(stated),
            );
        }
        let has_indexes = !self.indexes.is_empty();
        if has_indexes {
            for channel in self.messages.keys() {
                let place = format_args!("{place}, message index of channel {channel}");
                found.add(place, "one", "none");
            }
        }
        match entry {
            Some(entry) => self.compare(&entry, found),
            None if has_entries => {
                found.add(format_args!("{place}, chunk index"), "one", "none");
            }
            None => {}
        }
        has_indexes || self.messages.is_empty()
    }

    fn compare(&self, entry: &ChunkIndex, found: &mut Differences) {
        let header = &self.header;
        let place = |what: &str| format!("chunk index of byte {}: {what}", self.head.offset);
        for (what, held, stated) in [
            (
                "length",
                self.head.end() - self.head.offset,
                entry.chunk_length,
            ),
            (
                "first log time",
                header.message_start_time,
                entry.message_start_time,
            ),
            (
                "last log time",
                header.message_end_time,
                entry.message_end_time,
            ),
            (
                "compressed size",
                header.compressed_size,
                entry.compressed_size,
            ),
            (
                "uncompressed size",
                header.uncompressed_size,
                entry.uncompressed_size,
            ),
            (
                "length of the message indexes",
                self.end - self.head.end(),
                entry.message_index_length,
            ),
        ] {
            found.compare(place(what), held, stated);
        }
        found.compare(
            place("compression"),
            &header.compression,
            &entry.compression,
        );
        let offsets = &entry.message_index_offsets;
        for channel in self.indexes.keys().chain(offsets.keys()) {
            let [held, stated] = [&self.indexes, offsets].map(|map| map.get(channel));
            if held != stated {
                let what = format!("message index of channel {channel}");
                found.add(place(&what), byte(held), byte(stated));
            }
        }
    }
}

fn byte(offset: Option<&u64>) -> String {
    offset.map_or_else(|| "none".to_owned(), |offset| format!("byte {offset}"))
}

fn times((first, last): (u64, u64)) -> String {
    format!("{first} to {last} ns")
}

fn in_words(entry: Option<&MessageIndexEntry>) -> String {
    entry.map_or_else(
        || "no further message".to_owned(),
        |MessageIndexEntry { log_time, offset }| {
            format!("a message of {log_time} ns at byte {offset} of the unpacked chunk")
        },
    )
}
