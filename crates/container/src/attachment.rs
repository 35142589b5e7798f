//! Attachments of any size, passed on a piece at a time.

use std::io::{self, Read, Seek, Write};

use crc32fast::Hasher;
use mcap::records::op;

use crate::error::ContainerError;
use crate::index::AttachmentFacts;
use crate::source::{Head, Source};
use crate::writer::Writer;

/// Bytes of an attachment in which its name and media type have to end.
const START_BYTES: u64 = 1 << 20;

/// What stands in front of an attachment's data.
pub(crate) fn attachment_facts<R: Read + Seek>(
    source: &mut Source<R>,
    head: Head,
) -> Result<AttachmentFacts, ContainerError> {
    let mut start = Vec::new();
    source.read_at(head.body(), head.bytes.min(START_BYTES), &mut start)?;
    AttachmentFacts::of(&start, head.bytes)
        .ok_or_else(|| source.place(head.offset).short(op::ATTACHMENT))
}

/// Copies the attachment whose head was read last.
pub(crate) fn pass_attachment<R: Read + Seek, W: Write>(
    source: &mut Source<R>,
    head: Head,
    writer: &mut Writer<W>,
) -> Result<(), ContainerError> {
    let facts = attachment_facts(source, head)?;
    let summed = facts.summed_bytes;
    source.back_to(head)?;
    writer.attachment(facts, head.bytes, |out| {
        check_attachment(source, head, summed, out)
    })
}

/// Passes the body of an attachment on and compares its checksum, which covers `summed_bytes`.
pub(crate) fn check_attachment<R: Read + Seek>(
    source: &mut Source<R>,
    head: Head,
    summed_bytes: u64,
    out: &mut dyn Write,
) -> Result<(), ContainerError> {
    let mut summed = Summed {
        out,
        sum: Hasher::new(),
        left: summed_bytes,
        stated: Vec::with_capacity(4),
    };
    source.pass_body(head, &mut summed)?;
    let stated = summed
        .stated
        .first_chunk()
        .map(|sum| u32::from_le_bytes(*sum));
    let calculated = summed.sum.finalize();
    match stated {
        Some(stated) if stated != 0 && stated != calculated => {
            let error = mcap::McapError::BadAttachmentCrc {
                saved: stated,
                calculated,
            };
            Err(source.place(head.offset).damaged(op::ATTACHMENT, error))
        }
        _ => Ok(()),
    }
}

/// Sums the first bytes, behind which the sum stands.
struct Summed<'a> {
    out: &'a mut dyn Write,
    sum: Hasher,
    left: u64,
    stated: Vec<u8>,
}

impl Write for Summed<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.out.write(bytes)?;
        let summed = usize::try_from(self.left).map_or(written, |left| left.min(written));
        let (data, stated) = bytes[..written].split_at(summed);
        self.sum.update(data);
        self.left -= data.len() as u64;
        let room = 4 - self.stated.len();
        self.stated
            .extend_from_slice(&stated[..stated.len().min(room)]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}
