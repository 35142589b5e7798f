//! One pass over a damaged file: its records one after the other, and the search for the next one
//! where they do not follow each other.

mod chunks;

use mcap::records::{Record, op};

use super::probe::{Known, Sought};
use crate::attachment::{check_attachment, read_index};
use crate::error::ContainerError;
use crate::fields::{stated_bytes, summed_bytes};
use crate::format::{FOOTER_COVERED_BYTES, MessageFacts, is_made_anew, name_of, prefix};
use crate::limit::memory_limit;
use crate::recover::report::Loss;
use crate::source::{Head, Source};

/// Bytes that are summed at once.
const SUMMED_BYTES: u64 = 1 << 20;

/// How far the records of a chunk are to be trusted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// Its checksum holds.
    Checked,
    /// It has no checksum, and is as long as it should be.
    Unchecked,
    /// It was never closed or the file ends within it; its first records.
    Open,
    /// Its checksum differs.
    Damaged,
}

/// A chunk that was found.
pub(super) struct FoundChunk<'a> {
    pub(super) kind: Kind,
    pub(super) compression: &'a str,
    /// Its packed records, where any reader unpacks them.
    pub(super) packed: Option<&'a [u8]>,
}

/// The checksum of a summary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sum {
    Holds,
    Absent,
    /// It differs, or the footer that states it is lost.
    Differs,
}

/// What is not as it should be.
pub(super) enum Damage {
    /// Bytes that cannot be used.
    Lost(Loss),
    /// Wrong bytes at this place that cost nothing.
    Mended(u64, &'static str),
    /// Records outside chunks may hold other bytes than were written.
    Unchecked,
    /// A part that only repeats others.
    Repaired(String),
    /// The file ends before its data do.
    Unfinished,
}

/// Takes what a scan finds, in the order of the file.
pub(super) trait Visitor: Known {
    /// A file starts: the first, or one that was joined to it.
    fn file(&mut self, number: usize, header: Option<&[u8]>) -> Result<(), ContainerError>;
    fn chunk(&mut self, chunk: &FoundChunk<'_>, records: &[u8]) -> Result<(), ContainerError>;
    /// A record of the data, outside chunks; whether its lengths agree and another follows it.
    fn record(&mut self, opcode: u8, body: &[u8], is_whole: bool) -> Result<(), ContainerError>;
    fn attachment(&mut self, source: &mut Source<'_>, head: Head) -> Result<(), ContainerError>;
    /// A schema or channel behind the data.
    fn in_summary(&mut self, opcode: u8, body: &[u8]);
    /// The summary ends, with this checksum; and the messages that it counts.
    fn summary_ends(&mut self, sum: Sum, stated_messages: Option<u64>);
    fn damage(&mut self, damage: Damage);
}

/// A pass over a file.
pub(super) struct Scan<'a, 's> {
    source: &'a mut Source<'s>,
    visitor: &'a mut dyn Visitor,
    /// Whether an earlier pass found every record sound.
    is_sound: bool,
    /// Records of the chunk at hand.
    records: Vec<u8>,
    /// Where the file at hand starts, and how many were before it.
    file: (u64, usize),
    /// Where the data end, once they did.
    data_end: Option<u64>,
    /// Bytes behind the data that are no records: they matter if there are data behind them.
    behind_data: Vec<Loss>,
    /// Messages that the summary counts.
    stated_messages: Option<u64>,
    has_loss: bool,
    /// Where the footer that was met last ends.
    footer_end: Option<u64>,
    /// Whether the file at hand has its end.
    is_finished: bool,
}

impl<'a, 's> Scan<'a, 's> {
    pub(super) fn new(
        source: &'a mut Source<'s>,
        visitor: &'a mut dyn Visitor,
        is_sound: bool,
    ) -> Self {
        Self {
            source,
            visitor,
            is_sound,
            records: Vec::new(),
            file: (0, 0),
            data_end: None,
            behind_data: Vec::new(),
            stated_messages: None,
            has_loss: false,
            footer_end: None,
            is_finished: false,
        }
    }

    pub(super) fn run(mut self) -> Result<(), ContainerError> {
        let magic_bytes = mcap::MAGIC.len() as u64;
        let has_magic = self.source.is_magic(0)?;
        let header = self.header_at(magic_bytes)?;
        let mut offset = if has_magic { magic_bytes } else { 0 };
        if let Some((body, end)) = &header {
            self.visitor.file(0, Some(body))?;
            offset = *end;
        }
        if !has_magic || header.is_none() {
            self.repair("the start of the file");
        }
        while offset < self.source.bytes() {
            offset = self.step(offset)?;
        }
        self.visitor.summary_ends(Sum::Differs, None);
        if self.data_end.is_none() {
            self.visitor.damage(Damage::Unfinished);
        } else if !self.is_finished {
            self.repair("the end of the file");
        }
        if !self.behind_data.is_empty() {
            self.repair("the summary");
        }
        Ok(())
    }

    fn repair(&mut self, what: &str) {
        self.visitor.damage(Damage::Repaired(what.to_owned()));
    }

    /// The body of a header record and where it ends.
    fn header_at(&mut self, offset: u64) -> Result<Option<(Vec<u8>, u64)>, ContainerError> {
        let head = self.source.head_at(offset)?;
        let Some(head) = head.filter(|head| {
            head.opcode == op::HEADER && self.source.fits(*head) && head.bytes <= memory_limit()
        }) else {
            return Ok(None);
        };
        let mut body = Vec::new();
        self.source.read_at(head.body(), head.bytes, &mut body)?;
        let parses = self.source.place(offset).parse(head.opcode, &body).is_ok();
        let Some(bytes) = stated_bytes(head.opcode, &body).filter(|_| parses) else {
            return Ok(None);
        };
        // Its own lengths, unless padding follows them rather than other records.
        let end = head.body() + bytes;
        let inside = (self.source).next_record(end, head.end(), Sought::Any, &*self.visitor)?;
        let padded = inside.is_none() && self.source.follows(head.end(), &*self.visitor)?;
        Ok(Some((body, if padded { head.end() } else { end })))
    }

    /// Deals with what starts at this byte; gives where to go on.
    fn step(&mut self, offset: u64) -> Result<u64, ContainerError> {
        let head = self.source.head_at(offset)?;
        if head.is_none_or(|head| head.opcode == mcap::MAGIC[0]) && self.source.is_magic(offset)? {
            return self.magic(offset);
        }
        let next = match head {
            None => None,
            Some(head) if head.opcode == op::CHUNK => self.chunk(head)?,
            Some(head) if !self.source.fits(head) => None,
            Some(head) if head.opcode == op::ATTACHMENT => self.attachment(head)?,
            Some(head) if head.bytes > memory_limit() => None,
            Some(head) => self.record(head)?,
        };
        if let Some(next) = next {
            return Ok(next);
        }
        let end = self.source.bytes();
        let found = (self.source).next_record(offset + 1, end, Sought::Any, &*self.visitor)?;
        let next = found.unwrap_or(end);
        let name = head.map_or("record", |head| name_of(head.opcode));
        let what = match (head.is_some_and(|head| self.source.fits(head)), found) {
            (true, _) => format!("a damaged {name}"),
            (false, Some(_)) => "bytes that are no record".to_owned(),
            (false, None) => format!("a {name} that is cut off"),
        };
        self.lose(offset, next, what, None);
        Ok(next)
    }

    /// The mark at the start or end of a file.
    fn magic(&mut self, offset: u64) -> Result<u64, ContainerError> {
        let end = offset + mcap::MAGIC.len() as u64;
        if self.footer_end == Some(offset) {
            self.is_finished = true;
            return Ok(end);
        }
        let Some((body, next)) = self.header_at(end)? else {
            return Ok(end);
        };
        // The data of the file before end here at the latest.
        if self.data_end.is_none() && offset > 0 {
            self.visitor.damage(Damage::Unfinished);
        }
        self.visitor.summary_ends(Sum::Differs, None);
        self.file = (offset, self.file.1 + 1);
        (self.data_end, self.is_finished, self.has_loss) = (None, false, false);
        self.behind_data.clear();
        self.repair(&format!("the joint with another file, at byte {offset}"));
        self.visitor.file(self.file.1, Some(&body))?;
        Ok(next)
    }

    fn lose(&mut self, offset: u64, end: u64, what: String, span: Option<(u64, u64)>) {
        let bytes = end - offset;
        let loss = Loss {
            offset,
            bytes,
            what,
            span,
        };
        if self.data_end.is_some() {
            self.behind_data.push(loss);
        } else {
            self.has_loss = true;
            self.visitor.damage(Damage::Lost(loss));
        }
    }

    /// There are data: if what looked like their end is behind, it was not.
    fn has_data(&mut self) {
        if self.data_end.take().is_some() {
            self.has_loss = true;
            self.is_finished = false;
            self.visitor.damage(Damage::Unchecked);
            for loss in std::mem::take(&mut self.behind_data) {
                self.visitor.damage(Damage::Lost(loss));
            }
        }
    }

    /// A record of moderate size outside chunks.
    fn record(&mut self, head: Head) -> Result<Option<u64>, ContainerError> {
        let mut body = Vec::new();
        self.source.read_at(head.body(), head.bytes, &mut body)?;
        // Kinds that nobody knows are more likely to be damage.
        let known = matches!(head.opcode, op::HEADER..=op::DATA_END);
        if !known && head.opcode < 0x80 {
            return Ok(None);
        }
        if known && (self.source.place(head.offset).parse(head.opcode, &body)).is_err() {
            return Ok(None);
        }
        let is_whole = self.is_sound || self.is_whole(head, &body)?;
        if !is_whole && !self.is_as_long(head)? {
            return Ok(None);
        }
        // Behind the data, it is more likely to be another record whose kind is damaged.
        let is_late = self.data_end.is_some() && head.opcode == op::MESSAGE;
        let message = MessageFacts::read(&body).filter(|_| is_late);
        if message.is_some_and(|message| self.visitor.spans(message) == Some(false)) {
            return Ok(None);
        }
        match head.opcode {
            op::DATA_END => {
                self.check_data(head, &body)?;
                self.data_end = Some(head.end());
                self.stated_messages = None;
            }
            op::FOOTER => self.footer(head)?,
            op::SCHEMA | op::CHANNEL if self.data_end.is_some() => {
                self.visitor.in_summary(head.opcode, &body);
            }
            op::STATISTICS => {
                if let Ok(Record::Statistics(counted)) =
                    self.source.place(head.offset).parse(head.opcode, &body)
                {
                    self.stated_messages = Some(counted.message_count);
                }
            }
            opcode if is_made_anew(opcode) => {}
            // Private records behind the data point into the file.
            0x80.. if self.data_end.is_some() => {}
            opcode => {
                self.has_data();
                if self.has_loss {
                    // It may come from a chunk whose checksum was lost.
                    self.visitor.damage(Damage::Unchecked);
                }
                self.visitor.record(opcode, &body, is_whole)?;
            }
        }
        Ok(Some(head.end()))
    }

    /// Whether another record follows, and the lengths in this one agree.
    fn is_whole(&mut self, head: Head, body: &[u8]) -> Result<bool, ContainerError> {
        let is_exact = stated_bytes(head.opcode, body) == Some(head.bytes);
        Ok(is_exact && self.source.follows(head.end(), &*self.visitor)?)
    }

    /// Whether a record is likely to end where it says: it holds no others, or none that lead to one that
    /// follows.
    fn is_as_long(&mut self, head: Head) -> Result<bool, ContainerError> {
        let followed = self.source.follows(head.end(), &*self.visitor)?;
        let mut from = head.body();
        while let Some(inside) =
            (self.source).next_record(from, head.end(), Sought::Any, &*self.visitor)?
        {
            if !followed || self.source.leads_to(inside, head.end())? {
                return Ok(false);
            }
            from = inside + 1;
        }
        let kept = matches!(
            head.opcode,
            op::SCHEMA | op::CHANNEL | op::MESSAGE | op::METADATA | 0x80..
        );
        if !followed && self.data_end.is_none() && kept {
            self.visitor.damage(Damage::Unchecked);
        }
        Ok(true)
    }

    /// Compares the checksum of all data, unless an earlier pass did or something is lost anyway.
    fn check_data(&mut self, head: Head, body: &[u8]) -> Result<(), ContainerError> {
        let stated = body.first_chunk().map_or(0, |sum| u32::from_le_bytes(*sum));
        let (start, _) = self.file;
        if stated != 0
            && !self.is_sound
            && !self.has_loss
            && self.sum(start, head.offset, &[])? != stated
        {
            self.visitor.damage(Damage::Unchecked);
        }
        Ok(())
    }

    /// Checksum of these bytes of the file and more.
    fn sum(&mut self, mut offset: u64, end: u64, more: &[u8]) -> Result<u32, ContainerError> {
        let (mut sum, mut piece) = (crc32fast::Hasher::new(), Vec::new());
        while offset < end {
            let bytes = SUMMED_BYTES.min(end - offset);
            self.source.read_at(offset, bytes, &mut piece)?;
            sum.update(&piece);
            offset += bytes;
        }
        sum.update(more);
        Ok(sum.finalize())
    }

    /// The footer: compares the checksum of the summary, wherever that starts by now.
    fn footer(&mut self, head: Head) -> Result<(), ContainerError> {
        self.footer_end = Some(head.end());
        let Some(data_end) = self.data_end else {
            return Ok(());
        };
        let mut body = Vec::new();
        self.source.read_at(head.body(), head.bytes, &mut body)?;
        let Ok(Record::Footer(footer)) = self.source.place(head.offset).parse(op::FOOTER, &body)
        else {
            return Ok(());
        };
        let stated = self.stated_messages.take();
        let covered = [&prefix(op::FOOTER, 20), &body[..FOOTER_COVERED_BYTES]].concat();
        let sum = match footer.summary_crc {
            0 => Sum::Absent,
            stated if self.sum(data_end, head.offset, &covered)? == stated => Sum::Holds,
            _ => Sum::Differs,
        };
        let start = data_end - self.file.0;
        if sum == Sum::Differs || (footer.summary_start != 0 && footer.summary_start != start) {
            self.repair("the summary");
        }
        let stated = stated.filter(|_| sum != Sum::Differs);
        self.visitor.summary_ends(sum, stated);
        Ok(())
    }

    fn attachment(&mut self, head: Head) -> Result<Option<u64>, ContainerError> {
        let Ok(index) = read_index(self.source, head) else {
            return Ok(None);
        };
        // What is no record behind the data does not make a file unsound.
        if self.is_sound && self.data_end.is_none() {
            self.visitor.attachment(self.source, head)?;
            return Ok(Some(head.end()));
        }
        let is_exact = summed_bytes(&index) + 4 == head.bytes;
        self.source.back_to(head)?;
        let mut sink = std::io::sink();
        match check_attachment(self.source, head, summed_bytes(&index), &mut sink) {
            Ok(is_checked) if is_checked || self.source.follows(head.end(), &*self.visitor)? => {
                self.has_data();
                self.source.back_to(head)?;
                self.visitor.attachment(self.source, head)?;
                Ok(Some(head.end()))
            }
            Err(error @ (ContainerError::Read { .. } | ContainerError::Write { .. })) => Err(error),
            Err(_) if is_exact && self.source.follows(head.end(), &*self.visitor)? => {
                self.has_data();
                let what = format!("attachment \"{}\", whose checksum differs", index.name);
                self.lose(head.offset, head.end(), what, None);
                Ok(Some(head.end()))
            }
            _ => Ok(None),
        }
    }
}
