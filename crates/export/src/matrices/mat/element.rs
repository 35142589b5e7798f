//! Elements: tag, data, padding.

use crate::matrices::error::Fault;
use crate::matrices::number::{ByteOrder, Kind, Numbers};

/// Type of an element that is a variable.
pub(crate) const MATRIX: u32 = 14;
/// Type of an element that holds a variable packed by zlib.
pub(crate) const COMPRESSED: u32 = 15;

/// Bytes of a tag, and what elements are padded to.
pub(crate) const TAG_BYTES: usize = 8;

/// Type and length of an element.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tag {
    pub(crate) kind: u32,
    /// Bytes of the data.
    pub(crate) length: usize,
    /// Whether the data are the last four bytes of the tag itself.
    small: bool,
}

impl Tag {
    pub(crate) fn read(bytes: &[u8; TAG_BYTES], order: ByteOrder) -> Result<Self, Fault> {
        let word = |at: usize| {
            let word = [bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]];
            match order {
                ByteOrder::Little => u32::from_le_bytes(word),
                ByteOrder::Big => u32::from_be_bytes(word),
            }
        };
        let (first, second) = (word(0), word(4));
        // A type has only two bytes; where the others are used they are the length of small data.
        let small = first >> 16 != 0;
        let (kind, length) = if small {
            (first & 0xFFFF, first >> 16)
        } else {
            (first, second)
        };
        if small && length > 4 {
            return Err(Fault::new("at most 4 bytes in a tag", length));
        }
        let fault = |_| Fault::new("a length that memory has", length);
        Ok(Self {
            kind,
            length: usize::try_from(length).map_err(fault)?,
            small,
        })
    }
}

/// Elements that follow each other.
#[derive(Debug)]
pub(crate) struct Elements<'a> {
    rest: &'a [u8],
    order: ByteOrder,
}

impl<'a> Elements<'a> {
    pub(crate) fn new(bytes: &'a [u8], order: ByteOrder) -> Self {
        Self { rest: bytes, order }
    }

    pub(crate) fn order(&self) -> ByteOrder {
        self.order
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.rest.is_empty()
    }

    /// Bytes that are left.
    pub(crate) fn len(&self) -> usize {
        self.rest.len()
    }

    /// Type and data of the next element.
    pub(crate) fn next_element(&mut self) -> Result<(u32, &'a [u8]), Fault> {
        let left = |rest: &[u8]| format!("{} bytes", rest.len());
        let Some((start, rest)) = self.rest.split_first_chunk::<TAG_BYTES>() else {
            return Err(Fault::new("a tag of 8 bytes", left(self.rest)));
        };
        let tag = Tag::read(start, self.order)?;
        if tag.small {
            self.rest = rest;
            return Ok((tag.kind, &start[4..][..tag.length]));
        }
        let Some((data, rest)) = rest.split_at_checked(tag.length) else {
            let expected = format!("{} bytes of type {}", tag.length, tag.kind);
            return Err(Fault::new(expected, left(rest)));
        };
        // Packed elements have no padding, and the last one's may be left out.
        let padding = match tag.kind {
            COMPRESSED => 0,
            _ => tag.length.next_multiple_of(TAG_BYTES) - tag.length,
        };
        self.rest = rest.get(padding..).unwrap_or_default();
        Ok((tag.kind, data))
    }

    /// Whole numbers of the next element.
    pub(crate) fn integers(&mut self) -> Result<Vec<i64>, Fault> {
        let (kind, data) = self.next_element()?;
        let numbers = numbers_of_type(kind, self.order)?;
        let numbers = numbers.read(data, data.len() / numbers.width)?;
        Ok(numbers.into_iter().map(|v| v as i64).collect())
    }

    /// `count` numbers of the next element.
    pub(crate) fn numbers(&mut self, count: usize) -> Result<Vec<f64>, Fault> {
        let (kind, data) = self.next_element()?;
        numbers_of_type(kind, self.order)?.read(data, count)
    }
}

/// Layout of the numbers in an element of a type.
fn numbers_of_type(kind: u32, order: ByteOrder) -> Result<Numbers, Fault> {
    let (kind, width) = match kind {
        1 => (Kind::Signed, 1),
        2 => (Kind::Unsigned, 1),
        3 => (Kind::Signed, 2),
        4 => (Kind::Unsigned, 2),
        5 => (Kind::Signed, 4),
        6 => (Kind::Unsigned, 4),
        7 => (Kind::Float, 4),
        9 => (Kind::Float, 8),
        12 => (Kind::Signed, 8),
        13 => (Kind::Unsigned, 8),
        other => return Err(Fault::new("numbers", format!("data of type {other}"))),
    };
    Ok(Numbers { kind, width, order })
}
