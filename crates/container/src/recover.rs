//! Recovers intact data from a damaged file.

mod keeper;
mod report;
mod scan;

use std::io::{Read, Seek, Write};

use mcap::records::{ChunkHeader, op};

use crate::attachment::{check_attachment, pass_attachment, read_index};
use crate::chunk::{Packing, header_bytes, unpack_start};
use crate::error::ContainerError;
use crate::fields::{chunk_header, summed_bytes};
use crate::format::{PREFIX_BYTES, Records, is_made_anew, name_of};
use crate::overview::{CHUNK_START_BYTES, End, MetadataRecord, Overview};
use crate::source::{Head, MOST_RECORD_BYTES, Source};
use keeper::Keeper;
pub use report::{Loss, Recovered};

/// Bytes that are summed at once.
const SUMMED_BYTES: u64 = 1 << 20;

/// Writes what is sound of a file, which may be cut off, damaged anywhere, or never finished.
///
/// Records that parse and chunks whose checksum holds are kept byte for byte. Of a chunk that the end
/// of the file cuts, the whole messages before the cut are kept; a chunk whose checksum differs is left
/// out, since any of its messages may be wrong. After bytes that are no record, the next place is
/// looked for at which records follow each other. Schemas and channels that are missing where they are
/// needed are taken from the summary, if there is one. Summary and indexes are made anew.
///
/// Bytes outside chunks have no checksum of their own: a message there that still looks like one is
/// kept, and [`Recovered::unchecked`] says that nothing vouches for it.
///
/// `add` may give a metadata record about what is lost, which is added at the end of the data.
///
/// # Errors
///
/// [`ContainerError::NotMcap`] for bytes that are no MCAP file at all; [`ContainerError::Read`],
/// [`ContainerError::Write`].
pub fn recover(
    file: &str,
    input: impl Read + Seek + Send,
    out: &mut dyn Write,
    add: impl FnOnce(&Recovered) -> Option<MetadataRecord>,
) -> Result<Recovered, ContainerError> {
    let mut source = Source::unchecked(file, input)?;
    let overview = Overview::read(&mut source)?;
    let (header, start) = header(&mut source)?;
    let keeper = Keeper::create(out, header.as_deref().unwrap_or(&[0; 8]), overview)?;
    let mut recovery = Recovery {
        source,
        keeper,
        records: Vec::new(),
        after_data: false,
    };
    if header.is_none() || !recovery.starts_well()? {
        recovery.keeper.report.repair("the start of the file");
    }
    let mut offset = start;
    if header.is_none()
        && let Some(first) = recovery.source.head_at(start)?
        && recovery.source.fits(first)
        && recovery.source.may_start(first.end())?
    {
        // Whatever it calls itself now, it is where the header was.
        let what = "a damaged header".to_owned();
        recovery.lose(start, first.end() - start, what, None);
        offset = first.end();
    }
    while let Some(next) = recovery.step(offset)? {
        offset = next;
    }
    recovery.keeper.finish(add)
}

/// The body of the header record and where the record behind it starts.
fn header(source: &mut Source<'_>) -> Result<(Option<Vec<u8>>, u64), ContainerError> {
    let magic_bytes = mcap::MAGIC.len() as u64;
    let mut start = Vec::new();
    source.read_at(0, 64 << 10, &mut start)?;
    let records = start.get(mcap::MAGIC.len()..).unwrap_or_default();
    let first = Records(records).next().flatten();
    if let Some((op::HEADER, body)) = first
        && (source.place(magic_bytes).parse(op::HEADER, body)).is_ok()
    {
        return Ok((
            Some(body.to_vec()),
            magic_bytes + (PREFIX_BYTES + body.len()) as u64,
        ));
    }
    if start.starts_with(mcap::MAGIC) {
        return Ok((None, magic_bytes));
    }
    // Neither the mark nor what comes after it.
    Source::open(source.file(), std::io::Cursor::new(start)).map(|_| (None, 0))
}

struct Recovery<'a, 's> {
    source: Source<'s>,
    keeper: Keeper<'a>,
    records: Vec<u8>,
    /// Whether the record that ends the data has been met, after which nothing is missed.
    after_data: bool,
}

impl Recovery<'_, '_> {
    fn starts_well(&mut self) -> Result<bool, ContainerError> {
        let mut magic = Vec::new();
        self.source
            .read_at(0, mcap::MAGIC.len() as u64, &mut magic)?;
        Ok(magic == mcap::MAGIC)
    }

    /// Deals with what starts at this byte; gives where to go on, `None` at the end.
    fn step(&mut self, offset: u64) -> Result<Option<u64>, ContainerError> {
        if self.after_data && offset == self.source.bytes() {
            return Ok(None);
        }
        let Some(head) = self.source.head_at(offset)? else {
            let left = self.source.bytes().saturating_sub(offset);
            if left > 0 {
                self.lose(offset, left, "the start of a record".to_owned(), None);
            }
            self.no_end();
            return Ok(None);
        };
        let next = match head.opcode {
            op::CHUNK => self.chunk(head)?,
            op::FOOTER if self.source.is_end(head)? => return Ok(None),
            _ if !self.source.fits(head) => None,
            op::ATTACHMENT => self.attachment(head)?,
            _ if head.bytes > MOST_RECORD_BYTES => None,
            _ => self.record(head)?,
        };
        if next.is_some() {
            return Ok(next);
        }
        let channels = self.keeper.channel_ids();
        let next = self.source.next_record(offset + 1, &channels)?;
        let end = next.unwrap_or(self.source.bytes());
        let what = match self.source.fits(head) {
            true => format!("a damaged {}", name_of(head.opcode)),
            false if next.is_some() => "bytes that are no record".to_owned(),
            false => format!("a {} that is cut off", name_of(head.opcode)),
        };
        self.lose(offset, end - offset, what, None);
        if next.is_none() {
            self.no_end();
        }
        Ok(next)
    }

    /// The file has no footer.
    fn no_end(&mut self) {
        if self.after_data {
            self.keeper.report.repair("the end of the file");
        } else {
            self.keeper.report.unfinished = true;
        }
    }

    /// Bytes behind the data only repeat it and point into it.
    fn lose(&mut self, offset: u64, bytes: u64, what: String, span: Option<(u64, u64)>) {
        if self.after_data {
            self.keeper.report.repair("the summary");
        } else {
            self.keeper.report.lose(Loss {
                offset,
                bytes,
                what,
                span,
            });
        }
    }

    /// A record of moderate size outside chunks.
    fn record(&mut self, head: Head) -> Result<Option<u64>, ContainerError> {
        let mut body = Vec::new();
        self.source.read_at(head.body(), head.bytes, &mut body)?;
        let place = self.source.place(head.offset);
        // Kinds that nobody knows are more likely to be damage.
        let known = matches!(head.opcode, op::HEADER..=op::DATA_END);
        if !known && head.opcode < 0x80 {
            return Ok(None);
        }
        if known && place.parse(head.opcode, &body).is_err() {
            return Ok(None);
        }
        // Where nothing follows, either its length is wrong or what comes after it is damaged.
        if !self.source.may_start(head.end())? {
            let channels = self.keeper.channel_ids();
            let next = self.source.next_record(head.offset + 1, &channels)?;
            if next.is_some_and(|next| next < head.end()) {
                return Ok(None);
            }
        }
        match head.opcode {
            op::DATA_END => {
                self.after_data = true;
                if self.keeper.report.losses.is_empty() {
                    // All data are there; what follows repeats them.
                    self.check_data(head, &body)?;
                    self.check_summary()?;
                    return Ok(Some(self.source.bytes()));
                }
            }
            // The summary repeats them; others know what to do with private records of theirs there.
            op::SCHEMA | op::CHANNEL | 0x10.. if self.after_data => {}
            op::FOOTER => {}
            opcode if is_made_anew(opcode) => {}
            opcode => {
                if !self.keeper.report.losses.is_empty() {
                    // It may come from a chunk whose checksum was lost.
                    self.keeper.report.unchecked = true;
                }
                self.keeper.alone(opcode, &body)?;
            }
        }
        Ok(Some(head.end()))
    }

    /// Compares the checksum of all data.
    fn check_data(&mut self, head: Head, body: &[u8]) -> Result<(), ContainerError> {
        let stated = body.first_chunk().map_or(0, |sum| u32::from_le_bytes(*sum));
        if stated == 0 {
            return Ok(());
        }
        let (mut sum, mut offset, mut piece) = (crc32fast::Hasher::new(), 0, Vec::new());
        while offset < head.offset {
            let bytes = SUMMED_BYTES.min(head.offset - offset);
            self.source.read_at(offset, bytes, &mut piece)?;
            sum.update(&piece);
            offset += bytes;
        }
        if sum.finalize() != stated {
            self.keeper.report.unchecked = true;
        }
        Ok(())
    }

    /// Says what behind the data has to be made anew.
    fn check_summary(&mut self) -> Result<(), ContainerError> {
        match End::read(&mut self.source)? {
            None => self.keeper.report.repair("the end of the file"),
            Some(End::Damaged) => self.keeper.report.repair("the summary"),
            Some(End::Bare | End::Summary(_)) => {}
        }
        Ok(())
    }

    fn attachment(&mut self, head: Head) -> Result<Option<u64>, ContainerError> {
        let source = &mut self.source;
        let Ok(index) = read_index(source, head) else {
            return Ok(None);
        };
        match check_attachment(source, head, summed_bytes(&index), &mut std::io::sink()) {
            Ok(()) => {
                pass_attachment(source, head, &mut self.keeper.writer)?;
                Ok(Some(head.end()))
            }
            Err(error @ (ContainerError::Read { .. } | ContainerError::Write { .. })) => Err(error),
            Err(_) if self.source.may_start(head.end())? => {
                let what = format!("attachment \"{}\", whose checksum differs", index.name);
                self.lose(head.offset, head.end() - head.offset, what, None);
                Ok(Some(head.end()))
            }
            Err(_) => Ok(None),
        }
    }

    /// A chunk, whatever its lengths say; `None` where nothing here is one.
    fn chunk(&mut self, head: Head) -> Result<Option<u64>, ContainerError> {
        let end = self.source.bytes();
        let left = end - head.body().min(end);
        let mut start = Vec::new();
        let bytes = left.min(CHUNK_START_BYTES);
        self.source.read_at(head.body(), bytes, &mut start)?;
        let Some(header) =
            chunk_header(&start).filter(|header| Packing::from_name(&header.compression).is_some())
        else {
            return Ok(None);
        };
        let header_bytes = header_bytes(&header) as u64;
        let room = (left - header_bytes.min(left)).min(MOST_RECORD_BYTES);
        // The record and the chunk's header both say how long it is; either may be wrong.
        let by_record = head.bytes.checked_sub(header_bytes);
        let by_record = by_record.filter(|&bytes| bytes <= room);
        let by_header = Some(header.compressed_size).filter(|&bytes| bytes <= room);
        for packed_bytes in [by_header, by_record].into_iter().flatten() {
            if let Some(next) = self.whole_chunk(head, &header, packed_bytes)? {
                return Ok(Some(next));
            }
        }
        let span = (header.message_start_time, header.message_end_time);
        let span = Some(span).filter(|&(start, end)| end != 0 && end >= start);
        if by_header.is_none() && by_record.is_none() {
            self.open_chunk(head, &header, room, span)?;
            return Ok(Some(end));
        }
        let ends = [by_record, by_header].into_iter().flatten();
        for end in ends.map(|packed| head.body() + header_bytes + packed) {
            if self.source.may_start(end)? {
                let what = "a chunk whose content is damaged".to_owned();
                self.lose(head.offset, end - head.offset, what, span);
                return Ok(Some(end));
            }
        }
        Ok(None)
    }

    /// Unpacks so many packed bytes of a chunk as far as they are sound, and gives them where all are.
    fn unpack(
        &mut self,
        head: Head,
        header: &ChunkHeader,
        packed_bytes: u64,
    ) -> Result<Option<Vec<u8>>, ContainerError> {
        let mut packed = Vec::new();
        let start = head.body() + header_bytes(header) as u64;
        self.source.read_at(start, packed_bytes, &mut packed)?;
        let is_sound = unpack_start(header, &packed, &mut self.records);
        Ok(is_sound.then_some(packed))
    }

    /// Keeps a chunk of so many packed bytes if its checksum holds, or if it has none and is as long
    /// as it should be.
    fn whole_chunk(
        &mut self,
        head: Head,
        header: &ChunkHeader,
        packed_bytes: u64,
    ) -> Result<Option<u64>, ContainerError> {
        let packed = self.unpack(head, header, packed_bytes)?;
        let sound = match header.uncompressed_crc {
            0 => self.records.len() as u64 == header.uncompressed_size,
            crc => crc == crc32fast::hash(&self.records),
        };
        if !sound {
            return Ok(None);
        }
        (self.keeper).chunk(&self.records, &header.compression, packed.as_deref())?;
        let end = head.body() + header_bytes(header) as u64 + packed_bytes;
        // There may be more in the record than the packed bytes.
        let padded = head.end() > end && head.end() <= self.source.bytes();
        let next = match padded && self.source.may_start(head.end())? {
            true => head.end(),
            false => end,
        };
        Ok(Some(next))
    }

    /// Keeps the whole messages of a chunk that the end of the file cuts.
    fn open_chunk(
        &mut self,
        head: Head,
        header: &ChunkHeader,
        packed_bytes: u64,
        span: Option<(u64, u64)>,
    ) -> Result<(), ContainerError> {
        self.unpack(head, header, packed_bytes)?;
        let kept = (self.keeper).start_of_chunk(&self.records, &header.compression)?;
        let what = format!("the rest of a chunk that is cut off, after {kept} messages");
        let bytes = self.source.bytes() - head.offset;
        self.lose(head.offset, bytes, what, span);
        self.no_end();
        Ok(())
    }
}
