//! A file read from front to back, record by record, whatever its size.

use std::io::{Read, Seek, SeekFrom, Write};

use crc32fast::Hasher;
use mcap::records::{ChunkHeader, Record, op};

use crate::chunk::unpack;
use crate::error::{ContainerError, Place, Rest};
use crate::format::{FOOTER_COVERED_BYTES, PREFIX_BYTES, prefix};

/// Bytes that go through memory at once where a record is passed on without being kept.
const PASSED_BYTES: u64 = 1 << 20;

/// Where a record is and what it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Head {
    pub(crate) offset: u64,
    pub(crate) opcode: u8,
    /// Bytes of its body.
    pub(crate) bytes: u64,
}

impl Head {
    /// Where its body starts.
    pub(crate) fn body(&self) -> u64 {
        self.offset + PREFIX_BYTES as u64
    }

    /// Where the next record starts.
    pub(crate) fn end(&self) -> u64 {
        self.body() + self.bytes
    }
}

/// Bytes that can be read from any place.
trait Input: Read + Seek + Send {}

impl<T: Read + Seek + Send> Input for T {}

/// An MCAP file that is read from front to back.
///
/// Checksums over all data and over the summary are compared where they stand, unless something
/// before them was skipped. Memory is taken for the largest record at most, and never more than the
/// file has bytes, whatever its lengths say.
pub struct Source<'a> {
    file: String,
    input: Box<dyn Input + 'a>,
    bytes: u64,
    /// Position of the input.
    position: u64,
    /// Where the record starts that comes next.
    next: u64,
    /// Of the part that is being read; `None` after a skip.
    sum: Option<Hasher>,
    part: Part,
}

/// Parts of a file that have a checksum of their own.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Part {
    Data,
    Summary,
    /// Behind the footer.
    End,
}

impl<'a> Source<'a> {
    /// Opens a file; `file` is what errors call it.
    ///
    /// # Errors
    ///
    /// [`ContainerError::NotMcap`] for anything that does not start as an MCAP file does,
    /// [`ContainerError::Read`].
    pub fn open(file: &str, input: impl Read + Seek + Send + 'a) -> Result<Self, ContainerError> {
        let mut source = Self::unchecked(file, input)?;
        let rest = source.rest(0)?;
        if !rest.start.starts_with(mcap::MAGIC) {
            return Err(ContainerError::NotMcap {
                file: source.file,
                found: rest.describe(),
            });
        }
        source.rewind()?;
        Ok(source)
    }

    /// A file of which not even the first bytes need to be sound.
    pub(crate) fn unchecked(
        file: &str,
        input: impl Read + Seek + Send + 'a,
    ) -> Result<Self, ContainerError> {
        let mut source = Self {
            file: file.to_owned(),
            input: Box::new(input),
            bytes: 0,
            position: 0,
            next: 0,
            sum: None,
            part: Part::Data,
        };
        let end = source.input.seek(SeekFrom::End(0));
        source.bytes = end.map_err(|error| source.unreadable(error))?;
        source.position = source.bytes;
        Ok(source)
    }

    /// What errors call the file.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// Size of the file.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Goes back to the first record.
    ///
    /// # Errors
    ///
    /// [`ContainerError::Read`].
    pub fn rewind(&mut self) -> Result<(), ContainerError> {
        self.jump(mcap::MAGIC.len() as u64)?;
        let mut sum = Hasher::new();
        sum.update(mcap::MAGIC);
        self.sum = Some(sum);
        self.part = Part::Data;
        Ok(())
    }

    /// Goes on with the record that starts at this byte; what lies between is in no checksum.
    pub(crate) fn jump(&mut self, offset: u64) -> Result<(), ContainerError> {
        self.next = offset;
        self.sum = None;
        self.seek(offset)
    }

    fn seek(&mut self, offset: u64) -> Result<(), ContainerError> {
        if self.position != offset {
            let difference = i64::try_from(i128::from(offset) - i128::from(self.position));
            let sought = match difference {
                // A buffered reader keeps what it has read.
                Ok(difference) => self.input.seek_relative(difference),
                Err(_) => self.input.seek(SeekFrom::Start(offset)).map(|_| ()),
            };
            sought.map_err(|error| self.unreadable(error))?;
            self.position = offset;
        }
        Ok(())
    }

    /// The record that comes next, whose body is still to be read; what was not read of the last one
    /// is skipped. `None` at the end of the file.
    pub(crate) fn next_head(&mut self) -> Result<Option<Head>, ContainerError> {
        if self.position != self.next {
            let next = self.next;
            self.jump(next)?;
        }
        if self.part == Part::End {
            self.check_end()?;
            return Ok(None);
        }
        let offset = self.next;
        if self.bytes.saturating_sub(offset) < PREFIX_BYTES as u64 {
            return Err(self.cut(offset)?);
        }
        let mut prefix = [0; PREFIX_BYTES];
        (self.input.read_exact(&mut prefix)).map_err(|error| self.unreadable(error))?;
        self.position += PREFIX_BYTES as u64;
        let [opcode, length @ ..] = prefix;
        let bytes = u64::from_le_bytes(length);
        if bytes > self.bytes - self.position {
            return Err(self.cut(offset)?);
        }
        let head = Head {
            offset,
            opcode,
            bytes,
        };
        self.next = head.end();
        if opcode == op::DATA_END || opcode == op::FOOTER {
            self.check_sum(head)?;
        } else if let Some(sum) = &mut self.sum {
            sum.update(&prefix);
        }
        Ok(Some(head))
    }

    /// Where the record starts that comes next.
    pub(crate) fn next_offset(&self) -> u64 {
        self.next
    }

    /// Compares the checksum that this record states of what is before it.
    fn check_sum(&mut self, head: Head) -> Result<(), ContainerError> {
        let sum = self.sum.take();
        let mut body = Vec::new();
        self.read_on(head.bytes.min(64), &mut body)?;
        let record = self.place(head.offset).parse(head.opcode, &body)?;
        let compared = match (record, sum, self.part) {
            (Record::DataEnd(end), Some(sum), Part::Data) => {
                let what = "checksum of everything before it";
                Some((what, end.data_section_crc, sum.finalize()))
            }
            (Record::Footer(footer), Some(mut sum), Part::Summary) => {
                sum.update(&prefix(head.opcode, head.bytes));
                sum.update(&body[..FOOTER_COVERED_BYTES]);
                Some((
                    "checksum of the summary",
                    footer.summary_crc,
                    sum.finalize(),
                ))
            }
            _ => None,
        };
        // The body can be asked for all the same.
        self.seek(head.body())?;
        self.part = match head.opcode {
            op::DATA_END => Part::Summary,
            _ => Part::End,
        };
        match compared {
            Some((what, stated, calculated)) if stated != 0 && stated != calculated => {
                Err(self.place(head.offset).bad_sum(what, stated, calculated))
            }
            _ => Ok(()),
        }
    }

    /// Reads the body of the record whose head was read last.
    pub(crate) fn body(&mut self, head: Head, body: &mut Vec<u8>) -> Result<(), ContainerError> {
        body.clear();
        self.place(head.offset)
            .check_memory(head.opcode, head.bytes)?;
        self.read_on(head.bytes, body)?;
        if (body.len() as u64) < head.bytes {
            return Err(self.cut(head.offset)?);
        }
        match head.opcode {
            // The checksum of the summary covers what comes after the end of the data.
            op::DATA_END => self.sum = Some(Hasher::new()),
            _ => {
                if let Some(sum) = &mut self.sum {
                    sum.update(body);
                }
            }
        }
        Ok(())
    }

    /// Reads the chunk whose head was read last, its records unpacked; see [`unpack`].
    pub(crate) fn chunk(
        &mut self,
        head: Head,
        body: &mut Vec<u8>,
        records: &mut Vec<u8>,
    ) -> Result<ChunkHeader, ContainerError> {
        self.body(head, body)?;
        unpack(self.place(head.offset), body, records)
    }

    /// The body of the header record, where the source is at one; then it is at the record behind it.
    pub(crate) fn header(&mut self) -> Result<Option<Vec<u8>>, ContainerError> {
        let mut body = Vec::new();
        if let Some(head) = self.next_head()?
            && head.opcode == op::HEADER
        {
            self.body(head, &mut body)?;
            self.place(head.offset).parse(head.opcode, &body)?;
            return Ok(Some(body));
        }
        self.rewind()?;
        Ok(None)
    }

    /// Reads from the record whose head was read last to the end, for the checksums there.
    pub(crate) fn read_to_end(&mut self, mut head: Head) -> Result<(), ContainerError> {
        let mut body = Vec::new();
        loop {
            self.body(head, &mut body)?;
            match self.next_head()? {
                Some(next) => head = next,
                None => return Ok(()),
            }
        }
    }

    /// Goes back to the body of the record whose head was read last.
    pub(crate) fn back_to(&mut self, head: Head) -> Result<(), ContainerError> {
        self.seek(head.body())
    }

    /// Passes the body of the record whose head was read last on, a piece at a time.
    pub(crate) fn pass_body(
        &mut self,
        head: Head,
        mut out: impl Write,
    ) -> Result<(), ContainerError> {
        let mut left = head.bytes;
        let mut piece = Vec::new();
        while left > 0 {
            piece.clear();
            self.read_on(left.min(PASSED_BYTES), &mut piece)?;
            if piece.is_empty() {
                return Err(self.cut(head.offset)?);
            }
            if let Some(sum) = &mut self.sum {
                sum.update(&piece);
            }
            out.write_all(&piece).map_err(ContainerError::write)?;
            left -= piece.len() as u64;
        }
        Ok(())
    }

    /// Reads these bytes of the file, or as many as there are; the record that comes next stays.
    pub(crate) fn read_at(
        &mut self,
        offset: u64,
        bytes: u64,
        into: &mut Vec<u8>,
    ) -> Result<(), ContainerError> {
        into.clear();
        self.seek(offset)?;
        self.read_on(bytes, into)
    }

    fn read_on(&mut self, bytes: u64, into: &mut Vec<u8>) -> Result<(), ContainerError> {
        // Room for all at once, since the file has them.
        let left = self.bytes.saturating_sub(self.position).min(bytes);
        into.reserve(usize::try_from(left).unwrap_or_default());
        let read = (&mut self.input).take(bytes).read_to_end(into);
        self.position += read.map_err(|error| self.unreadable(error))? as u64;
        Ok(())
    }

    /// The file ends before the record that starts here does.
    fn cut(&mut self, offset: u64) -> Result<ContainerError, ContainerError> {
        let rest = self.rest(offset)?;
        Ok(self.place(offset).cut(&rest, self.part == Part::End))
    }

    fn check_end(&mut self) -> Result<(), ContainerError> {
        let rest = self.rest(self.next)?;
        let magic = mcap::MAGIC.len() as u64;
        if rest.bytes < magic {
            return Err(self.cut(self.next)?);
        }
        if rest.bytes > magic || !rest.start.starts_with(mcap::MAGIC) {
            let expected = "\\x89MCAP0\\r\\n and nothing after it";
            let place = self.place(self.next);
            return Err(place.error("end of the file", expected, rest.describe()));
        }
        Ok(())
    }

    fn rest(&mut self, offset: u64) -> Result<Rest, ContainerError> {
        let mut start = Vec::new();
        self.read_at(offset, Rest::SHOWN as u64, &mut start)?;
        Ok(Rest {
            start,
            bytes: self.bytes.saturating_sub(offset),
        })
    }

    /// For errors about the record that starts at this byte.
    pub(crate) fn place(&self, offset: u64) -> Place<'_> {
        Place {
            file: &self.file,
            offset,
        }
    }

    fn unreadable(&self, source: std::io::Error) -> ContainerError {
        ContainerError::Read {
            file: self.file.clone(),
            source,
        }
    }
}

impl std::fmt::Debug for Source<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        (f.debug_struct("Source"))
            .field("file", &self.file)
            .field("bytes", &self.bytes)
            .finish_non_exhaustive()
    }
}
