//! Writes recovered records in a readable order: channels before their messages, schemas before
//! their channels.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;

use mcap::records::{Record, op};

use super::report::Recovered;
use crate::chunk::Packing;
use crate::error::ContainerError;
use crate::fields::parse_record;
use crate::format::{MessageFacts, Records, push_record, set_id};
use crate::overview::{MetadataRecord, Overview};
use crate::writer::Writer;

pub(super) struct Keeper<'a> {
    pub(super) writer: Writer<'a>,
    pub(super) report: Recovered,
    overview: Overview,
    schemas: BTreeMap<u16, Vec<u8>>,
    channels: BTreeMap<u16, Vec<u8>>,
    /// Records that are kept and not written yet.
    kept: Vec<u8>,
}

impl<'a> Keeper<'a> {
    pub(super) fn create(
        out: &'a mut dyn Write,
        header: &[u8],
        overview: Overview,
    ) -> Result<Self, ContainerError> {
        let counted = overview.statistics.as_ref();
        Ok(Self {
            writer: Writer::with_header(out, header, Packing::Zstd)?,
            report: Recovered {
                stated_messages: counted.map(|counted| counted.message_count),
                ..Recovered::default()
            },
            overview,
            schemas: BTreeMap::new(),
            channels: BTreeMap::new(),
            kept: Vec::new(),
        })
    }

    /// Channels that messages can be of.
    pub(super) fn channel_ids(&self) -> BTreeSet<u16> {
        (self.channels.keys().chain(self.overview.channels.keys()))
            .copied()
            .collect()
    }

    /// Writes a sound record that lies outside chunks.
    pub(super) fn alone(&mut self, opcode: u8, body: &[u8]) -> Result<(), ContainerError> {
        self.kept.clear();
        self.keep(opcode, body);
        for (opcode, body) in Records(&self.kept).flatten() {
            if let (op::METADATA, Ok(Record::Metadata(record))) =
                (opcode, parse_record(opcode, body))
            {
                self.report.metadata.insert(record.name);
            }
            self.writer.outside(opcode, body)?;
        }
        Ok(())
    }

    /// Writes the records of a sound chunk.
    pub(super) fn chunk(
        &mut self,
        records: &[u8],
        compression: &str,
        packed: Option<&[u8]>,
    ) -> Result<(), ContainerError> {
        self.keep_all(records);
        match packed.filter(|_| self.kept == records) {
            Some(packed) => self.writer.packed_chunk(records, compression, packed),
            None => self.write_kept(compression),
        }
    }

    /// Writes records from the start of a chunk; gives how many messages are kept.
    pub(super) fn start_of_chunk(
        &mut self,
        records: &[u8],
        compression: &str,
    ) -> Result<usize, ContainerError> {
        self.keep_all(records);
        let kept = Records(&self.kept).flatten();
        let messages = kept.filter(|(opcode, _)| *opcode == op::MESSAGE).count();
        self.write_kept(compression)?;
        Ok(messages)
    }

    fn write_kept(&mut self, compression: &str) -> Result<(), ContainerError> {
        let packing = Packing::from_name(compression).unwrap_or(Packing::Zstd);
        match self.kept.is_empty() {
            true => Ok(()),
            false => self.writer.chunk(&self.kept, packing),
        }
    }

    fn keep_all(&mut self, records: &[u8]) {
        self.kept.clear();
        for (opcode, body) in Records(records).flatten() {
            if matches!(opcode, op::SCHEMA | op::CHANNEL | op::MESSAGE | 0x80..) {
                self.keep(opcode, body);
            }
        }
    }

    /// Keeps a record, after what it needs.
    fn keep(&mut self, opcode: u8, body: &[u8]) {
        match opcode {
            op::SCHEMA => self.schema(body),
            op::CHANNEL => self.channel(body),
            op::MESSAGE => {
                let Some(MessageFacts { channel, .. }) = MessageFacts::read(body) else {
                    return;
                };
                if !self.channels.contains_key(&channel)
                    && let Some(body) = self.overview.channels.get(&channel).cloned()
                {
                    self.channel(&body);
                }
                if self.channels.contains_key(&channel) {
                    push_record(&mut self.kept, opcode, body);
                } else {
                    *self.report.without_channel.entry(channel).or_default() += 1;
                }
            }
            _ => push_record(&mut self.kept, opcode, body),
        }
    }

    fn schema(&mut self, body: &[u8]) {
        let Ok(Record::Schema { header, .. }) = parse_record(op::SCHEMA, body) else {
            self.report.contradictions += 1;
            return;
        };
        let first = (self.schemas.entry(header.id)).or_insert_with(|| body.to_vec());
        match first == body {
            true => push_record(&mut self.kept, op::SCHEMA, body),
            false => self.report.contradictions += 1,
        }
    }

    fn channel(&mut self, body: &[u8]) {
        let Ok(Record::Channel(channel)) = parse_record(op::CHANNEL, body) else {
            self.report.contradictions += 1;
            return;
        };
        let schema = channel.schema_id;
        if !self.schemas.contains_key(&schema)
            && let Some(body) = self.overview.schemas.get(&schema).cloned()
        {
            self.schema(&body);
        }
        let mut body = body.to_vec();
        if schema != 0 && !self.schemas.contains_key(&schema) {
            self.report.without_schema.insert(channel.topic);
            // Number 0 means none.
            set_id(&mut body[2..], 0);
        }
        let first = (self.channels.entry(channel.id)).or_insert_with(|| body.clone());
        match *first == body {
            true => push_record(&mut self.kept, op::CHANNEL, &body),
            false => self.report.contradictions += 1,
        }
    }

    /// Ends the file, after a record that says what was lost.
    pub(super) fn finish(
        mut self,
        add: impl FnOnce(&Recovered) -> Option<MetadataRecord>,
    ) -> Result<Recovered, ContainerError> {
        self.report.written = self.writer.written();
        if let Some(record) = add(&self.report) {
            self.writer.metadata(&record.name, &record.facts)?;
        }
        self.report.written = self.writer.finish()?;
        Ok(self.report)
    }
}
