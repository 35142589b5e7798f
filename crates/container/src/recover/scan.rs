//! Finds possible record starts in untrusted bytes.

use std::collections::BTreeSet;

use mcap::records::op;

use crate::chunk::Packing;
use crate::error::ContainerError;
use crate::fields::{attachment_index, chunk_header};
use crate::format::{MessageFacts, PREFIX_BYTES};
use crate::source::{Head, Source};

/// Bytes that are searched at once.
const WINDOW_BYTES: u64 = 1 << 20;

/// A record beyond this is taken for one by how it starts.
const PARSED_BYTES: u64 = 64 << 10;

impl Source<'_> {
    /// What the bytes here say as the head of a record; `None` where the file ends before it.
    pub(super) fn head_at(&mut self, offset: u64) -> Result<Option<Head>, ContainerError> {
        let mut prefix = Vec::new();
        self.read_at(offset, PREFIX_BYTES as u64, &mut prefix)?;
        Ok(head_of(offset, &prefix))
    }

    /// Whether the file is long enough for a record.
    pub(super) fn fits(&self, head: Head) -> bool {
        head.bytes <= self.bytes().saturating_sub(head.body())
    }

    /// Whether this is the footer at the very end.
    pub(super) fn is_end(&mut self, head: Head) -> Result<bool, ContainerError> {
        if !self.fits(head) {
            return Ok(false);
        }
        let mut magic = Vec::new();
        self.read_at(head.end(), mcap::MAGIC.len() as u64 + 1, &mut magic)?;
        Ok(magic == mcap::MAGIC)
    }

    /// Whether a record could start here, or the file ends here: so that the record before it is
    /// likely to be as long as it says.
    pub(super) fn may_start(&mut self, offset: u64) -> Result<bool, ContainerError> {
        let mut prefix = Vec::new();
        self.read_at(offset, PREFIX_BYTES as u64, &mut prefix)?;
        let magic = prefix.starts_with(mcap::MAGIC);
        Ok(match prefix.first() {
            None => offset == self.bytes(),
            Some(opcode) => magic || matches!(opcode, op::HEADER..=op::DATA_END | 0x80..),
        })
    }

    /// The first place from `offset` on at which a record starts that is followed by another one.
    pub(super) fn next_record(
        &mut self,
        mut offset: u64,
        channels: &BTreeSet<u16>,
    ) -> Result<Option<u64>, ContainerError> {
        let mut window = Vec::new();
        while offset < self.bytes() {
            self.read_at(offset, WINDOW_BYTES, &mut window)?;
            for start in 0..window.len().saturating_sub(PREFIX_BYTES - 1) {
                let at = offset + start as u64;
                if let Some(head) = head_of(at, &window[start..])
                    && self.is_likely(head)
                    && self.starts(head, channels)?
                {
                    return Ok(Some(at));
                }
            }
            if (window.len() as u64) < WINDOW_BYTES {
                break;
            }
            // A head may lie across two windows.
            offset += WINDOW_BYTES - (PREFIX_BYTES as u64 - 1);
        }
        Ok(None)
    }

    /// By its head alone.
    fn is_likely(&self, head: Head) -> bool {
        let least = match head.opcode {
            op::SCHEMA => 14,
            op::CHANNEL => 16,
            op::MESSAGE => 22,
            op::CHUNK => 40,
            op::MESSAGE_INDEX => 6,
            op::CHUNK_INDEX => 64,
            op::ATTACHMENT => 36,
            op::STATISTICS => 46,
            op::METADATA => 8,
            op::ATTACHMENT_INDEX => 48,
            op::METADATA_INDEX => 20,
            op::SUMMARY_OFFSET => return head.bytes == 17 && self.fits(head),
            op::DATA_END => return head.bytes == 4 && self.fits(head),
            op::FOOTER => return head.bytes == 20 && self.fits(head),
            _ => return false,
        };
        head.bytes >= least && (self.fits(head) || head.opcode == op::CHUNK)
    }

    /// By its content, and by what follows.
    fn starts(&mut self, head: Head, channels: &BTreeSet<u16>) -> Result<bool, ContainerError> {
        let mut body = Vec::new();
        self.read_at(head.body(), head.bytes.min(PARSED_BYTES), &mut body)?;
        let whole = body.len() as u64 == head.bytes;
        let content = match head.opcode {
            op::MESSAGE => {
                MessageFacts::read(&body).is_some_and(|message| channels.contains(&message.channel))
            }
            op::CHUNK => match chunk_header(&body) {
                // An open one that says nothing of its length says nothing of anything.
                Some(header) => {
                    Packing::from_name(&header.compression).is_some() && self.fits(head)
                }
                None => false,
            },
            op::ATTACHMENT => attachment_index(&body, head.bytes).is_some(),
            opcode if whole => self.place(head.offset).parse(opcode, &body).is_ok(),
            op::SCHEMA | op::CHANNEL | op::METADATA => true,
            _ => false,
        };
        if !content {
            return Ok(false);
        }
        // Two in a row are no accident.
        Ok(match self.head_at(head.end())? {
            None => true,
            Some(next) => {
                self.is_likely(next)
                    || self.is_end(head)?
                    || (matches!(next.opcode, op::HEADER..=op::DATA_END) && !self.fits(next))
            }
        })
    }
}

fn head_of(offset: u64, bytes: &[u8]) -> Option<Head> {
    let (&[opcode, ref length @ ..], _) = bytes.split_first_chunk::<PREFIX_BYTES>()?;
    let length = u64::from_le_bytes(*length);
    Some(Head {
        offset,
        opcode,
        // Lengths beyond any file would run over where they are added.
        bytes: length.min(u64::MAX >> 1),
    })
}
