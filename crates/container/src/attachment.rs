//! Attachments of any size, passed on a piece at a time.

use std::io::{self, Write};

use crc32fast::Hasher;
use mcap::records::{AttachmentIndex, op};

use crate::error::ContainerError;
use crate::fields::{attachment_index, summed_bytes};
use crate::format::name_of;
use crate::source::{Head, Source};
use crate::writer::Writer;

/// Bytes of an attachment in which its name and media type have to end.
const START_BYTES: u64 = 1 << 20;

/// The index entry of the attachment whose head was read last, yet without a place.
pub(crate) fn read_index(
    source: &mut Source<'_>,
    head: Head,
) -> Result<AttachmentIndex, ContainerError> {
    let mut start = Vec::new();
    source.read_at(head.body(), head.bytes.min(START_BYTES), &mut start)?;
    source.back_to(head)?;
    attachment_index(&start, head.bytes)
        .ok_or_else(|| source.place(head.offset).short(op::ATTACHMENT))
}

/// The index entry of the attachment whose head was read last, after its checksum is compared.
pub(crate) fn check_whole(
    source: &mut Source<'_>,
    head: Head,
) -> Result<AttachmentIndex, ContainerError> {
    let index = read_index(source, head)?;
    check_attachment(source, head, summed_bytes(&index), &mut io::sink())?;
    Ok(AttachmentIndex {
        offset: head.offset,
        length: head.end() - head.offset,
        ..index
    })
}

/// Copies the attachment whose head was read last.
pub(crate) fn pass_attachment(
    source: &mut Source<'_>,
    head: Head,
    writer: &mut Writer<'_>,
) -> Result<(), ContainerError> {
    let index = read_index(source, head)?;
    let summed = summed_bytes(&index);
    writer.attachment(index, head.bytes, |out| {
        check_attachment(source, head, summed, out).map(drop)
    })
}

/// Passes the body of an attachment on and compares its checksum, which covers `summed_bytes`; whether it
/// has one.
pub(crate) fn check_attachment(
    source: &mut Source<'_>,
    head: Head,
    summed_bytes: u64,
    out: &mut dyn Write,
) -> Result<bool, ContainerError> {
    let mut summed = Summed {
        out,
        sum: Hasher::new(),
        left: summed_bytes,
        stated: Vec::with_capacity(4),
    };
    source.pass_body(head, &mut summed)?;
    let calculated = summed.sum.finalize();
    match summed.stated.first_chunk() {
        Some(&stated) if stated != [0; 4] && stated != calculated.to_le_bytes() => {
            let place = source.place(head.offset);
            let stated = u32::from_le_bytes(stated);
            Err(place.bad_sum(name_of(op::ATTACHMENT), stated, calculated))
        }
        stated => Ok(stated.is_some_and(|stated| *stated != [0; 4])),
    }
}

/// Sums the first bytes, which the sum follows.
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
