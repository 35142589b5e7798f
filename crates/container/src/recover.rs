//! Recovers intact data from a damaged file.

mod keeper;
mod report;
mod scan;

use std::io::{Read, Seek, Write};

use mcap::records::op;

use crate::attachment::{attachment_facts, check_attachment, pass_attachment};
use crate::chunk::{Extent, unpack};
use crate::error::ContainerError;
use crate::format::{ChunkFacts, PREFIX_BYTES, Records, name_of};
use crate::overview::{CHUNK_START_BYTES, End, Overview};
use crate::source::{Head, MOST_RECORD_BYTES, Source};
use crate::walk::parse;
use keeper::Keeper;
use report::Report;
pub use report::{Loss, Recovered};
use scan::Scan;

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
/// # Errors
///
/// [`ContainerError::NotMcap`] for bytes that are no MCAP file at all; [`ContainerError::Read`],
/// [`ContainerError::Write`].
pub fn recover<R: Read + Seek, W: Write>(
    file: &str,
    input: R,
    out: W,
) -> Result<Recovered, ContainerError> {
    let mut source = Source::unchecked(file, input)?;
    let overview = Overview::read(&mut source)?;
    let (header, start) = header(&mut source)?;
    let keeper = Keeper::create(out, header.as_deref().unwrap_or(&[0; 8]), overview)?;
    let mut recovery = Recovery {
        scan: Scan::new(source),
        keeper,
        report: Report::default(),
        records: Vec::new(),
        after_data: false,
    };
    if header.is_none() || !recovery.starts_well()? {
        recovery.report.repaired("the start of the file");
    }
    let mut offset = start;
    if header.is_none()
        && let Some(first) = recovery.scan.head(start)?
        && recovery.scan.fits(first)
        && recovery.scan.may_start(first.end())?
    {
        // Whatever it calls itself now, it is where the header was.
        let what = "a damaged header".to_owned();
        recovery.lose(start, first.end() - start, what, None);
        offset = first.end();
    }
    while let Some(next) = recovery.step(offset)? {
        offset = next;
    }
    recovery.finish()
}

/// The body of the header record and where the record behind it starts.
fn header<R: Read + Seek>(
    source: &mut Source<R>,
) -> Result<(Option<Vec<u8>>, u64), ContainerError> {
    let magic_bytes = mcap::MAGIC.len() as u64;
    let mut start = Vec::new();
    source.read_at(0, 64 << 10, &mut start)?;
    let records = start.get(mcap::MAGIC.len()..).unwrap_or_default();
    let first = Records(records).next().flatten();
    if let Some((op::HEADER, body)) = first
        && parse(source.place(magic_bytes), op::HEADER, body).is_ok()
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

struct Recovery<R, W> {
    scan: Scan<R>,
    keeper: Keeper<W>,
    report: Report,
    records: Vec<u8>,
    /// Whether the record that ends the data has been met, after which nothing is missed.
    after_data: bool,
}

impl<R: Read + Seek, W: Write> Recovery<R, W> {
    fn starts_well(&mut self) -> Result<bool, ContainerError> {
        let mut magic = Vec::new();
        let source = &mut self.scan.source;
        source.read_at(0, mcap::MAGIC.len() as u64, &mut magic)?;
        Ok(magic == mcap::MAGIC)
    }

    /// Deals with what starts at this byte; gives where to go on, `None` at the end.
    fn step(&mut self, offset: u64) -> Result<Option<u64>, ContainerError> {
        if self.after_data && offset == self.scan.source.bytes() {
            return Ok(None);
        }
        let Some(head) = self.scan.head(offset)? else {
            let left = self.scan.source.bytes().saturating_sub(offset);
            if left > 0 {
                self.lose(offset, left, "the start of a record".to_owned(), None);
            }
            self.no_end();
            return Ok(None);
        };
        let next = match head.opcode {
            op::CHUNK => self.chunk(head)?,
            op::FOOTER if self.scan.is_end(head)? => return Ok(None),
            _ if !self.scan.fits(head) => None,
            op::ATTACHMENT => self.attachment(head)?,
            _ if head.bytes > MOST_RECORD_BYTES => None,
            _ => self.record(head)?,
        };
        if next.is_some() {
            return Ok(next);
        }
        let next = self
            .scan
            .next_record(offset + 1, &self.keeper.channel_ids())?;
        let end = next.unwrap_or(self.scan.source.bytes());
        let what = match self.scan.fits(head) {
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
            self.report.repaired("the end of the file");
        } else {
            self.report.unfinished();
        }
    }

    /// Bytes behind the data only repeat it and point into it.
    fn lose(&mut self, offset: u64, bytes: u64, what: String, span: Option<(u64, u64)>) {
        if self.after_data {
            self.report.repaired("the summary");
        } else {
            self.report.lose(Loss {
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
        self.scan
            .source
            .read_at(head.body(), head.bytes, &mut body)?;
        let place = self.scan.source.place(head.offset);
        // Kinds that nobody knows are more likely to be damage.
        let known = matches!(head.opcode, op::HEADER..=op::DATA_END);
        if !known && head.opcode < 0x80 {
            return Ok(None);
        }
        if known && parse(place, head.opcode, &body).is_err() {
            return Ok(None);
        }
        // Where nothing follows, either its length is wrong or what comes after it is damaged.
        if !self.scan.may_start(head.end())? {
            let channels = self.keeper.channel_ids();
            let next = self.scan.next_record(head.offset + 1, &channels)?;
            if next.is_some_and(|next| next < head.end()) {
                return Ok(None);
            }
        }
        match head.opcode {
            op::DATA_END => {
                self.after_data = true;
                if !self.report.has_losses() {
                    // All data are there; what follows repeats them.
                    self.check_data(head, &body)?;
                    self.check_summary()?;
                    return Ok(Some(self.scan.source.bytes()));
                }
            }
            // The summary repeats them; others know what to do with private records of theirs there.
            op::SCHEMA | op::CHANNEL | 0x10.. if self.after_data => {}
            op::HEADER
            | op::FOOTER
            | op::MESSAGE_INDEX
            | op::CHUNK_INDEX
            | op::ATTACHMENT_INDEX
            | op::METADATA_INDEX
            | op::STATISTICS
            | op::SUMMARY_OFFSET => {}
            opcode => {
                if self.report.has_losses() {
                    // It may come from a chunk whose checksum was lost.
                    self.report.unchecked();
                }
                self.keeper.alone(opcode, &body, &mut self.report)?;
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
            self.scan.source.read_at(offset, bytes, &mut piece)?;
            sum.update(&piece);
            offset += bytes;
        }
        if sum.finalize() != stated {
            self.report.unchecked();
        }
        Ok(())
    }

    /// Says what behind the data has to be made anew.
    fn check_summary(&mut self) -> Result<(), ContainerError> {
        match End::read(&mut self.scan.source)? {
            None => self.report.repaired("the end of the file"),
            Some(End::Damaged) => self.report.repaired("the summary"),
            Some(End::Bare | End::Summary(_)) => {}
        }
        Ok(())
    }

    fn attachment(&mut self, head: Head) -> Result<Option<u64>, ContainerError> {
        let source = &mut self.scan.source;
        let Ok(facts) = attachment_facts(source, head) else {
            return Ok(None);
        };
        source.back_to(head)?;
        let checked = check_attachment(source, head, facts.summed_bytes, &mut std::io::sink());
        match checked {
            Ok(()) => {
                pass_attachment(source, head, self.keeper.writer())?;
                Ok(Some(head.end()))
            }
            Err(error @ (ContainerError::Read { .. } | ContainerError::Write { .. })) => Err(error),
            Err(_) if self.scan.may_start(head.end())? => {
                let what = format!("attachment \"{}\", whose checksum differs", facts.name);
                self.lose(head.offset, head.end() - head.offset, what, None);
                Ok(Some(head.end()))
            }
            Err(_) => Ok(None),
        }
    }

    /// A chunk, whatever its lengths say; `None` where nothing here is one.
    fn chunk(&mut self, head: Head) -> Result<Option<u64>, ContainerError> {
        let source = &mut self.scan.source;
        let left = source.bytes() - head.body().min(source.bytes());
        let mut start = Vec::new();
        source.read_at(head.body(), left.min(CHUNK_START_BYTES), &mut start)?;
        let Some(facts) = ChunkFacts::of(&start)
            .filter(|facts| crate::chunk::Packing::of(&facts.compression).is_some())
        else {
            return Ok(None);
        };
        let header_bytes = facts.header_bytes() as u64;
        let room = (left - header_bytes.min(left)).min(MOST_RECORD_BYTES);
        // The record and the chunk's header both say how long it is; either may be wrong.
        let by_record = head
            .bytes
            .checked_sub(header_bytes)
            .filter(|&bytes| bytes <= room);
        let by_header = Some(facts.packed_bytes).filter(|&bytes| bytes <= room);
        for packed_bytes in [by_header, by_record].into_iter().flatten() {
            if let Some(next) = self.whole_chunk(head, &facts, packed_bytes)? {
                return Ok(Some(next));
            }
        }
        let span = (facts.end != 0 && facts.end >= facts.start).then_some((facts.start, facts.end));
        if by_header.is_none() && by_record.is_none() {
            self.open_chunk(head, &facts, room, span)?;
            return Ok(Some(self.scan.source.bytes()));
        }
        let ends = [by_record, by_header].into_iter().flatten();
        for end in ends.map(|packed| head.body() + header_bytes + packed) {
            if self.scan.may_start(end)? {
                let what = "a chunk whose content is damaged".to_owned();
                self.lose(head.offset, end - head.offset, what, span);
                return Ok(Some(end));
            }
        }
        Ok(None)
    }

    /// Keeps a chunk of so many packed bytes if its checksum holds, or if it has none and is as long
    /// as it should be.
    fn whole_chunk(
        &mut self,
        head: Head,
        facts: &ChunkFacts,
        packed_bytes: u64,
    ) -> Result<Option<u64>, ContainerError> {
        let mut body = Vec::new();
        let bytes = facts.header_bytes() as u64 + packed_bytes;
        self.scan.source.read_at(head.body(), bytes, &mut body)?;
        let mut facts = facts.clone();
        facts.packed_bytes = packed_bytes;
        // The end of the packed bytes is found by the sum; where it is found is no matter.
        let _ = unpack(&facts, &body, Extent::Start, &mut self.records);
        let sound = match facts.crc {
            0 => self.records.len() as u64 == facts.unpacked_bytes,
            crc => crc == crc32fast::hash(&self.records),
        };
        if !sound {
            return Ok(None);
        }
        let packed = &body[facts.header_bytes()..];
        self.keeper
            .chunk(&self.records, &facts.compression, packed, &mut self.report)?;
        let end = head.body() + bytes;
        // There may be more in the record than the packed bytes.
        let padded = head.end() > end && head.end() <= self.scan.source.bytes();
        let next = match padded && self.scan.may_start(head.end())? {
            true => head.end(),
            false => end,
        };
        Ok(Some(next))
    }

    /// Keeps the whole messages of a chunk that the end of the file cuts.
    fn open_chunk(
        &mut self,
        head: Head,
        facts: &ChunkFacts,
        packed_bytes: u64,
        span: Option<(u64, u64)>,
    ) -> Result<(), ContainerError> {
        let mut body = Vec::new();
        let bytes = facts.header_bytes() as u64 + packed_bytes;
        self.scan.source.read_at(head.body(), bytes, &mut body)?;
        let _ = unpack(facts, &body, Extent::Start, &mut self.records);
        let kept = self
            .keeper
            .part(&self.records, &facts.compression, &mut self.report)?;
        let end = self.scan.source.bytes();
        let what = format!("the rest of a chunk that is cut off, after {kept} messages");
        self.lose(head.offset, end - head.offset, what, span);
        self.no_end();
        Ok(())
    }

    fn finish(self) -> Result<Recovered, ContainerError> {
        let stated = self.keeper.stated_messages();
        Ok(self.report.finish(self.keeper.finish()?, stated))
    }
}
