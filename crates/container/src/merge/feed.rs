//! A file that is read record by record at the pace of others.

use std::io::{Read, Seek};
use std::ops::Range;

use mcap::records::{Record, op};

use crate::chunk::{Extent, unpack};
use crate::error::ContainerError;
use crate::fault::Place;
use crate::format::{MessageFacts, PREFIX_BYTES};
use crate::select::header;
use crate::source::{Head, Source};
use crate::walk::{chunk_facts, chunk_fault, parse};

/// A file and the record that it stands at.
pub(super) struct Feed<'a, R> {
    pub(super) source: &'a mut Source<R>,
    pub(super) profile: String,
    /// Body of the record at hand where it lies outside chunks.
    alone: Vec<u8>,
    /// Records of the chunk at hand.
    records: Vec<u8>,
    /// Where the record at hand lies in it; `None` outside chunks.
    inside: Option<Range<usize>>,
    /// Where in `records` the next one starts.
    next: usize,
    /// Where in the file the record or its chunk starts.
    offset: u64,
    message: Option<u64>,
    packed: Vec<u8>,
}

/// What comes before the next message.
pub(super) enum Outside {
    /// A record with this opcode, which is the record at hand.
    Record(u8),
    /// An attachment, whose body is still to be read.
    Attachment(Head),
}

impl<'a, R: Read + Seek> Feed<'a, R> {
    pub(super) fn start(source: &'a mut Source<R>) -> Result<Self, ContainerError> {
        source.rewind()?;
        let mut body = Vec::new();
        let header = header(source, &mut body)?;
        let profile = match parse(source.place(0), op::HEADER, &header)? {
            Record::Header(header) => header.profile,
            _ => String::new(),
        };
        Ok(Self {
            source,
            profile,
            alone: body,
            records: Vec::new(),
            inside: None,
            next: 0,
            offset: 0,
            message: None,
            packed: Vec::new(),
        })
    }

    /// Log time of the message that the file stands at; `None` at its end.
    pub(super) fn message_time(&self) -> Option<u64> {
        self.message
    }

    pub(super) fn body(&self) -> &[u8] {
        match &self.inside {
            Some(range) => &self.records[range.clone()],
            None => &self.alone,
        }
    }

    pub(super) fn body_mut(&mut self) -> &mut [u8] {
        match &self.inside {
            Some(range) => &mut self.records[range.clone()],
            None => &mut self.alone,
        }
    }

    pub(super) fn in_chunk(&self) -> bool {
        self.inside.is_some()
    }

    pub(super) fn place(&self) -> Place<'_> {
        self.source.place(self.offset)
    }

    /// Goes on to the next record; `None` where that is a message, or there is none.
    pub(super) fn next(&mut self) -> Result<Option<Outside>, ContainerError> {
        self.message = None;
        loop {
            if let Some(opcode) = self.next_in_chunk() {
                return self.at(opcode);
            }
            let Some(head) = self.source.next_head()? else {
                return Ok(None);
            };
            self.offset = head.offset;
            match head.opcode {
                op::CHUNK => {
                    self.source.body(head, &mut self.packed)?;
                    let place = self.source.place(head.offset);
                    let facts = chunk_facts(place, &self.packed)?;
                    unpack(&facts, &self.packed, Extent::Whole, &mut self.records)
                        .map_err(|error| chunk_fault(place, &facts, &self.packed, error))?;
                    self.next = 0;
                }
                op::ATTACHMENT => return Ok(Some(Outside::Attachment(head))),
                op::DATA_END | op::FOOTER => {
                    // To the end, for its checksums.
                    self.source.body(head, &mut self.packed)?;
                    while let Some(head) = self.source.next_head()? {
                        self.source.body(head, &mut self.packed)?;
                    }
                    return Ok(None);
                }
                op::MESSAGE_INDEX
                | op::CHUNK_INDEX
                | op::ATTACHMENT_INDEX
                | op::METADATA_INDEX
                | op::STATISTICS
                | op::SUMMARY_OFFSET
                | op::HEADER => self.source.body(head, &mut self.packed)?,
                opcode => {
                    self.source.body(head, &mut self.alone)?;
                    self.inside = None;
                    return self.at(opcode);
                }
            }
        }
    }

    fn at(&mut self, opcode: u8) -> Result<Option<Outside>, ContainerError> {
        if opcode != op::MESSAGE {
            return Ok(Some(Outside::Record(opcode)));
        }
        let facts = MessageFacts::of(self.body()).ok_or_else(|| self.place().short(op::MESSAGE))?;
        self.message = Some(facts.log_time);
        Ok(None)
    }

    /// Opcode of the next record of the chunk at hand, which is then the record at hand.
    fn next_in_chunk(&mut self) -> Option<u8> {
        let rest = self.records.get(self.next..)?;
        let (&[opcode, ref length @ ..], _) = rest.split_first_chunk::<PREFIX_BYTES>()?;
        let start = self.next + PREFIX_BYTES;
        // Unpacked chunks hold whole records.
        let end = start + usize::try_from(u64::from_le_bytes(*length)).ok()?;
        self.inside = Some(start..end);
        self.next = end;
        Some(opcode)
    }
}
