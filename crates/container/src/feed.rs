//! A file that is read record by record at the pace of other files.

use std::ops::Range;

use mcap::records::op;

use crate::error::{ContainerError, Place};
use crate::format::{MessageFacts, PREFIX_BYTES, id_of, is_made_anew};
use crate::overview::Overview;
use crate::source::{Head, Source};

/// A file and the record at hand.
pub(crate) struct Feed<'a> {
    pub(crate) source: Source<'a>,
    /// Body of the header record.
    pub(crate) header: Option<Vec<u8>>,
    /// Body of the record at hand where it lies outside chunks, or of the chunk.
    outside: Vec<u8>,
    /// Records of the chunk at hand.
    records: Vec<u8>,
    /// Where the record at hand lies in it; `None` outside chunks.
    inside: Option<Range<usize>>,
    /// Where in `records` the next one starts.
    next: usize,
    /// Where in the file the record or its chunk starts.
    offset: u64,
    message: Option<u64>,
    /// The summary; schemas and channels that it alone lists are given at the end.
    listed: Overview,
    is_at_end: bool,
}

/// What comes before the next message.
pub(crate) enum Outside {
    /// A record with this opcode, which is the record at hand.
    Record(u8),
    /// An attachment, whose body is still to be read.
    Attachment(Head),
}

impl<'a> Feed<'a> {
    pub(crate) fn start(mut source: Source<'a>) -> Result<Self, ContainerError> {
        let listed = Overview::read(&mut source)?;
        Ok(Self {
            listed,
            header: source.header()?,
            source,
            outside: Vec::new(),
            records: Vec::new(),
            inside: None,
            next: 0,
            offset: 0,
            message: None,
            is_at_end: false,
        })
    }

    /// Log time of the message at hand; `None` at its end.
    pub(crate) fn message_time(&self) -> Option<u64> {
        self.message
    }

    pub(crate) fn body(&self) -> &[u8] {
        match &self.inside {
            Some(range) => &self.records[range.clone()],
            None => &self.outside,
        }
    }

    pub(crate) fn body_mut(&mut self) -> &mut [u8] {
        match &self.inside {
            Some(range) => &mut self.records[range.clone()],
            None => &mut self.outside,
        }
    }

    pub(crate) fn in_chunk(&self) -> bool {
        self.inside.is_some()
    }

    pub(crate) fn place(&self) -> Place<'_> {
        self.source.place(self.offset)
    }

    /// The body that the summary gives a schema or channel; taken, it is given no more.
    pub(crate) fn take_listed(&mut self, opcode: u8, id: u16) -> Option<Vec<u8>> {
        match opcode {
            op::SCHEMA => self.listed.schemas.remove(&id),
            _ => self.listed.channels.remove(&id),
        }
    }

    /// Goes on to the next record, at the end to those that the summary alone lists; `None` where that is a message, or there is none.
    pub(crate) fn next(&mut self) -> Result<Option<Outside>, ContainerError> {
        self.message = None;
        loop {
            if let Some(opcode) = self.next_in_chunk() {
                return self.at(opcode);
            }
            if self.is_at_end {
                return Ok(self.next_listed());
            }
            let Some(head) = self.source.next_head()? else {
                self.is_at_end = true;
                continue;
            };
            self.offset = head.offset;
            match head.opcode {
                op::CHUNK => {
                    (self.source).chunk(head, &mut self.outside, &mut self.records)?;
                    self.next = 0;
                }
                op::ATTACHMENT => return Ok(Some(Outside::Attachment(head))),
                op::DATA_END | op::FOOTER => {
                    self.source.read_to_end(head)?;
                    self.is_at_end = true;
                }
                opcode => {
                    self.source.body(head, &mut self.outside)?;
                    if !is_made_anew(opcode) {
                        self.inside = None;
                        return self.at(opcode);
                    }
                }
            }
        }
    }

    fn at(&mut self, opcode: u8) -> Result<Option<Outside>, ContainerError> {
        if let (op::SCHEMA | op::CHANNEL, Some(id)) = (opcode, id_of(self.body())) {
            self.take_listed(opcode, id);
        }
        if opcode != op::MESSAGE {
            return Ok(Some(Outside::Record(opcode)));
        }
        let message = MessageFacts::read(self.body());
        let message = message.ok_or_else(|| self.place().short(op::MESSAGE))?;
        self.message = Some(message.log_time);
        Ok(None)
    }

    /// The next schema or channel that only the summary lists.
    fn next_listed(&mut self) -> Option<Outside> {
        let (opcode, (_, body)) = match self.listed.schemas.pop_first() {
            Some(schema) => (op::SCHEMA, schema),
            None => (op::CHANNEL, self.listed.channels.pop_first()?),
        };
        self.outside = body;
        self.inside = None;
        Some(Outside::Record(opcode))
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
