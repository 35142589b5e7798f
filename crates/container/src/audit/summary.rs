//! The summary of a file as it is stored.

use std::collections::BTreeMap;

use mcap::records::{
    AttachmentIndex, ChunkIndex, Footer, MetadataIndex, Record, Statistics, SummaryOffset, op,
};

use super::differences::Differences;
use crate::channel::Definitions;
use crate::error::ContainerError;
use crate::format::{PREFIX_BYTES, Records, name_of};
use crate::overview::{StoredFooter, footer, summary_bytes};
use crate::source::Source;

/// What the summary of a file states.
#[derive(Default)]
pub(super) struct Summary {
    /// Whether the file has a summary that can be taken apart.
    pub(super) is_there: bool,
    pub(super) definitions: Definitions,
    /// Entries by the byte that they point to.
    pub(super) chunks: BTreeMap<u64, ChunkIndex>,
    pub(super) attachments: BTreeMap<u64, AttachmentIndex>,
    pub(super) metadata: BTreeMap<u64, MetadataIndex>,
    pub(super) statistics: Option<Statistics>,
    pub(super) has_chunks: bool,
    has_statistics: bool,
    has_sum: bool,
    /// Runs of records of one kind: opcode, first byte, bytes.
    groups: Vec<(u8, u64, u64)>,
    offsets: Vec<(u64, SummaryOffset)>,
}

impl Summary {
    /// Reads the summary and compares it with its checksum and its offsets.
    pub(super) fn read(
        source: &mut Source<'_>,
        found: &mut Differences,
    ) -> Result<Self, ContainerError> {
        let Some(stored) = footer(source)? else {
            return Ok(Self::default());
        };
        let StoredFooter { offset, footer, .. } = stored;
        if footer.summary_start == 0 {
            return Ok(Self::default());
        }
        let place = format!("byte {offset}: footer");
        let Some((summary, sum)) = summary_bytes(source, &stored)? else {
            let expected = format!("a summary before byte {offset}");
            found.add(
                place,
                expected,
                format_args!("byte {}", footer.summary_start),
            );
            return Ok(Self::default());
        };
        if footer.summary_crc != 0 && footer.summary_crc != sum {
            let crc = |sum: u32| format!("CRC {sum:08x}");
            let place = format!("{place}, checksum of the summary");
            found.add(place, crc(footer.summary_crc), crc(sum));
        }
        let mut read = Self {
            has_sum: footer.summary_crc != 0,
            ..Self::default()
        };
        let mut at = footer.summary_start;
        for record in Records(&summary) {
            let Some((opcode, body)) = record else {
                found.add(
                    format_args!("byte {at}: summary"),
                    "records up to the footer",
                    "bytes that are none",
                );
                return Ok(Self::default());
            };
            match source.place(at).parse(opcode, body) {
                Ok(record) => read.record(at, opcode, record, body.len()),
                Err(error) => found.fault(error)?,
            }
            at += (PREFIX_BYTES + body.len()) as u64;
        }
        read.is_there = true;
        read.has_chunks = !read.chunks.is_empty();
        read.has_statistics = read.statistics.is_some();
        read.check_offsets(&footer, found);
        Ok(read)
    }

    fn record(&mut self, at: u64, opcode: u8, record: Record<'_>, body_bytes: usize) {
        let bytes = (PREFIX_BYTES + body_bytes) as u64;
        match self.groups.last_mut() {
            Some((last, _, length)) if *last == opcode => *length += bytes,
            _ => self.groups.push((opcode, at, bytes)),
        }
        match record {
            Record::Schema { .. } | Record::Channel(_) => {
                self.definitions.add(&record);
            }
            Record::ChunkIndex(index) => {
                self.chunks.insert(index.chunk_start_offset, index);
            }
            Record::AttachmentIndex(index) => {
                self.attachments.insert(index.offset, index);
            }
            Record::MetadataIndex(index) => {
                self.metadata.insert(index.offset, index);
            }
            Record::Statistics(statistics) => self.statistics = Some(statistics),
            Record::SummaryOffset(offset) => self.offsets.push((at, offset)),
            _ => {}
        }
    }

    /// Summary offsets against the records that they point to.
    fn check_offsets(&self, footer: &Footer, found: &mut Differences) {
        let first = self.offsets.first().map_or(0, |(at, _)| *at);
        if footer.summary_offset_start != 0 {
            let place = "footer, start of the summary offsets";
            found.compare(place, first, footer.summary_offset_start);
        }
        let shown = |opcode: u8, start: u64, length: u64| {
            format!(
                "{} records at byte {start}, {length} bytes",
                name_of(opcode)
            )
        };
        for (at, stated) in &self.offsets {
            let (opcode, start) = (stated.group_opcode, stated.group_start);
            let groups = self.groups.iter();
            let group = groups.clone().find(|(own, ..)| *own == opcode);
            let same = |group: &&(u8, u64, u64)| **group == (opcode, start, stated.group_length);
            // Some writers name groups without a record.
            if stated.group_length == 0 || groups.clone().any(|group| same(&group)) {
                continue;
            }
            let held = group.map_or_else(
                || format!("no {} records", name_of(opcode)),
                |&(opcode, start, length)| shown(opcode, start, length),
            );
            let stated = shown(opcode, start, stated.group_length);
            found.add(format_args!("byte {at}: summary offset"), held, stated);
        }
        let listed = |opcode: u8| {
            self.offsets
                .iter()
                .any(|(_, own)| own.group_opcode == opcode)
        };
        for &(opcode, start, _) in &self.groups {
            if !self.offsets.is_empty() && opcode != op::SUMMARY_OFFSET && !listed(opcode) {
                let place = format!("summary offset of the {} records", name_of(opcode));
                found.add(place, format_args!("byte {start}"), "none");
            }
        }
    }

    /// What a summary could say and this one does not.
    pub(super) fn notes(&self, chunks: u64) -> Vec<String> {
        if !self.is_there {
            return vec!["no summary: readers have to read the whole file".to_owned()];
        }
        let lacks = [
            (!self.has_statistics, "no statistics"),
            (!self.has_chunks && chunks > 0, "no chunk indexes"),
            (self.definitions.channels.is_empty(), "no channels"),
            (self.offsets.is_empty(), "no offsets of its parts"),
            (!self.has_sum, "no checksum"),
        ];
        let lacks: Vec<&str> = (lacks.into_iter())
            .filter_map(|(lacks, what)| lacks.then_some(what))
            .collect();
        match &*lacks {
            [] => Vec::new(),
            lacks => vec![format!("the summary has {}", lacks.join(", "))],
        }
    }
}
