//! Writes recovered records in a readable order: channels before their messages, schemas before
//! their channels.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;

use mcap::records::{Record, op};

use super::report::Report;
use crate::chunk::Packing;
use crate::error::ContainerError;
use crate::format::{MessageFacts, Records, push_record};
use crate::index::Written;
use crate::overview::{Overview, schema_of};
use crate::writer::Writer;

pub(super) struct Keeper<W> {
    writer: Writer<W>,
    overview: Overview,
    schemas: BTreeMap<u16, Vec<u8>>,
    channels: BTreeMap<u16, Vec<u8>>,
    kept: Vec<u8>,
}

impl<W: Write> Keeper<W> {
    pub(super) fn create(
        out: W,
        header: &[u8],
        overview: Overview,
    ) -> Result<Self, ContainerError> {
        Ok(Self {
            writer: Writer::create(out, header, Packing::Zstd)?,
            overview,
            schemas: BTreeMap::new(),
            channels: BTreeMap::new(),
            kept: Vec::new(),
        })
    }

    pub(super) fn writer(&mut self) -> &mut Writer<W> {
        &mut self.writer
    }

    /// Channels that messages can be of.
    pub(super) fn channel_ids(&self) -> BTreeSet<u16> {
        (self.channels.keys().chain(self.overview.channels.keys()))
            .copied()
            .collect()
    }

    pub(super) fn stated_messages(&self) -> Option<u64> {
        self.overview.messages.map(|(messages, _)| messages)
    }

    /// A sound record that lies outside chunks.
    pub(super) fn alone(
        &mut self,
        opcode: u8,
        body: &[u8],
        report: &mut Report,
    ) -> Result<(), ContainerError> {
        let mut kept = std::mem::take(&mut self.kept);
        kept.clear();
        self.keep(opcode, body, &mut kept, report);
        for (opcode, body) in Records(&kept).flatten() {
            self.writer.outside(opcode, body)?;
        }
        self.kept = kept;
        Ok(())
    }

    /// A sound chunk.
    pub(super) fn chunk(
        &mut self,
        records: &[u8],
        compression: &str,
        packed: &[u8],
        report: &mut Report,
    ) -> Result<(), ContainerError> {
        let mut kept = std::mem::take(&mut self.kept);
        self.keep_all(records, &mut kept, report);
        if kept == records {
            self.writer.packed_chunk(records, compression, packed)?;
        } else if !kept.is_empty() {
            self.writer
                .chunk(&kept, Packing::of(compression).unwrap_or(Packing::Zstd))?;
        }
        self.kept = kept;
        Ok(())
    }

    /// Records from the start of a chunk; gives how many messages are kept.
    pub(super) fn part(
        &mut self,
        records: &[u8],
        compression: &str,
        report: &mut Report,
    ) -> Result<u64, ContainerError> {
        let mut kept = std::mem::take(&mut self.kept);
        self.keep_all(records, &mut kept, report);
        let messages = (Records(&kept).flatten())
            .filter(|(opcode, _)| *opcode == op::MESSAGE)
            .count();
        if !kept.is_empty() {
            self.writer
                .chunk(&kept, Packing::of(compression).unwrap_or(Packing::Zstd))?;
        }
        self.kept = kept;
        Ok(messages as u64)
    }

    fn keep_all(&mut self, records: &[u8], kept: &mut Vec<u8>, report: &mut Report) {
        kept.clear();
        for (opcode, body) in Records(records).flatten() {
            if matches!(opcode, op::SCHEMA | op::CHANNEL | op::MESSAGE | 0x80..) {
                self.keep(opcode, body, kept, report);
            }
        }
    }

    /// Adds a record to those that are kept, after what it needs.
    fn keep(&mut self, opcode: u8, body: &[u8], kept: &mut Vec<u8>, report: &mut Report) {
        match opcode {
            op::SCHEMA => self.schema(body, kept, report),
            op::CHANNEL => self.channel(body, kept, report),
            op::MESSAGE => {
                let Some(facts) = MessageFacts::of(body) else {
                    return;
                };
                if !self.channels.contains_key(&facts.channel)
                    && let Some(body) = self.overview.channels.get(&facts.channel).cloned()
                {
                    self.channel(&body, kept, report);
                }
                if self.channels.contains_key(&facts.channel) {
                    push_record(kept, opcode, body);
                } else {
                    report.without_channel(facts.channel);
                }
            }
            _ => push_record(kept, opcode, body),
        }
    }

    fn schema(&mut self, body: &[u8], kept: &mut Vec<u8>, report: &mut Report) {
        let Ok(Record::Schema { header, .. }) = crate::fields::parse_record(op::SCHEMA, body)
        else {
            return report.contradiction();
        };
        match self.schemas.get(&header.id) {
            Some(first) if first != body => report.contradiction(),
            _ => {
                self.schemas.insert(header.id, body.to_vec());
                push_record(kept, op::SCHEMA, body);
            }
        }
    }

    fn channel(&mut self, body: &[u8], kept: &mut Vec<u8>, report: &mut Report) {
        let (Ok(Record::Channel(channel)), Some(schema)) = (
            crate::fields::parse_record(op::CHANNEL, body),
            schema_of(body),
        ) else {
            return report.contradiction();
        };
        if schema != 0
            && !self.schemas.contains_key(&schema)
            && let Some(body) = self.overview.schemas.get(&schema).cloned()
        {
            self.schema(&body, kept, report);
        }
        let mut body = body.to_vec();
        if schema != 0 && !self.schemas.contains_key(&schema) {
            report.without_schema(&channel.topic);
            // Number 0 stands for none.
            body.splice(2..4, [0, 0]);
        }
        match self.channels.get(&channel.id) {
            Some(first) if *first != body => report.contradiction(),
            _ => {
                push_record(kept, op::CHANNEL, &body);
                self.channels.insert(channel.id, body);
            }
        }
    }

    pub(super) fn finish(self) -> Result<Written, ContainerError> {
        self.writer.finish()
    }
}
