//! `.mat` of level 5, as MATLAB's `save -v6` and `save -v7`, Octave and SciPy write it ("MAT-File
//! Format", The MathWorks, chapter 1: Level 5 MAT-File Format).
//!
//! A header of 128 bytes, then elements: a tag with type and length, the data, and zeros up to a
//! multiple of eight bytes. A variable is an element of elements: flags, dimensions, name, numbers; by
//! default MATLAB packs each into an element of zlib data. Numbers are in the smallest type that
//! holds them, whatever the variable's class.

use std::io::Read as _;

use flate2::read::ZlibDecoder;
use nalgebra::DMatrix;

use super::number::{ByteOrder, Kind, Numbers, matrix};
use super::{Budget, Fault, Variable, Variables, not_written};
use crate::error::ExportError;

const HEADER_BYTES: usize = 128;

/// Start of the text of level 5 as most writers write it, but not all.
const TEXT: &[u8] = b"MATLAB 5.0 MAT-file";

/// Flag of complex numbers.
const COMPLEX: u32 = 0x0800;

/// Class of objects of MATLAB's newer kinds, whose elements are others.
const OPAQUE: u32 = 17;

/// Whether the bytes start as a file of level 5 does.
pub(crate) fn is_mat(bytes: &[u8]) -> bool {
    byte_order(bytes).is_some() || bytes.starts_with(TEXT)
}

/// Byte order of a file of level 5, by the version and the mark at the end of its header.
fn byte_order(bytes: &[u8]) -> Option<ByteOrder> {
    match bytes.get(124..HEADER_BYTES)? {
        [0, 1, b'I', b'M'] => Some(ByteOrder::Little),
        [1, 0, b'M', b'I'] => Some(ByteOrder::Big),
        _ => None,
    }
}

/// Whether the bytes start as a matrix of level 4 does: type, rows, columns, whether there is an
/// imaginary part, length of a name that ends with a zero.
pub(crate) fn looks_like_level_4(bytes: &[u8]) -> bool {
    let words = |read: fn([u8; 4]) -> u32| {
        let (words, _) = bytes.get(..20)?.as_chunks::<4>();
        let [kind, _, _, imaginary, name] = *words else {
            return None;
        };
        let name = usize::try_from(read(name)).ok()?;
        let end = bytes.get(19_usize.checked_add(name)?)?;
        Some(read(kind) <= 4052 && read(imaginary) <= 1 && name >= 2 && *end == 0)
    };
    [u32::from_le_bytes, u32::from_be_bytes]
        .into_iter()
        .any(|read| words(read) == Some(true))
}

/// Reads every variable.
pub(crate) fn read(bytes: &[u8], file: &str) -> Result<Variables, ExportError> {
    let Some(order) = byte_order(bytes) else {
        let expected = "a header of 128 bytes that ends with version 1.0 and IM or MI";
        let found = bytes
            .get(124..HEADER_BYTES)
            .unwrap_or_default()
            .escape_ascii();
        return Err(Fault::new(expected, format!("\"{found}\"")).at(file, "the header"));
    };
    let (mut variables, mut budget) = (Variables::new(), Budget::new());
    let mut elements = Elements::new(&bytes[HEADER_BYTES..], order);
    while !elements.rest.is_empty() {
        let at = bytes.len() - elements.rest.len();
        let mut name = String::new();
        let variable = element(&mut elements, &mut name, &mut budget).map_err(|fault| {
            let place = if name.is_empty() {
                format!("variable at byte {at}")
            } else {
                format!("variable {name}")
            };
            fault.at(file, place)
        })?;
        // MATLAB keeps data of its own without a name.
        if let Some(variable) = variable
            && !name.is_empty()
        {
            variables.insert(name, variable);
        }
    }
    Ok(variables)
}

/// One element of the file; `name` is set as soon as it is known.
fn element(
    elements: &mut Elements,
    name: &mut String,
    budget: &mut Budget,
) -> Result<Option<Variable>, Fault> {
    let order = elements.order;
    let (kind, data) = elements.next_element()?;
    match kind {
        MATRIX => variable(Elements::new(data, order), name, budget),
        COMPRESSED => {
            let mut input = ZlibDecoder::new(data);
            let fault = |error| Fault::new("intact zlib data", error);
            let mut start = [0; 8];
            input.read_exact(&mut start).map_err(fault)?;
            let Tag { kind, length, .. } = Tag::read(&start, order)?;
            if kind != MATRIX {
                return Err(Fault::new(
                    "a matrix in the packed data",
                    format!("type {kind}"),
                ));
            }
            // The buffer grows with what is there, not with a length that the tag only claims. One
            // byte more lets zlib compare its checksum.
            let mut body = Vec::new();
            let most = (length as u64).min(budget.left) + 1;
            (input.take(most).read_to_end(&mut body)).map_err(fault)?;
            if body.len() as u64 > budget.left {
                return Err(budget.spent());
            }
            if body.len() != length {
                let found = if body.len() < length { "fewer" } else { "more" };
                return Err(Fault::new(
                    format!("{length} bytes in the packed data"),
                    found,
                ));
            }
            variable(Elements::new(&body, order), name, budget)
        }
        // Others are allowed there, but hold no variable.
        _ => Ok(None),
    }
}

fn variable(
    mut parts: Elements,
    name: &mut String,
    budget: &mut Budget,
) -> Result<Option<Variable>, Fault> {
    if parts.rest.is_empty() {
        return Ok(None);
    }
    let flags = parts.integers()?;
    let flags =
        u32::try_from(flags.first().copied().unwrap_or_default() & 0xFFFF_FFFF).unwrap_or_default();
    let class = flags & 0xFF;
    let dimensions = if class == OPAQUE {
        Vec::new()
    } else {
        parts.integers()?
    };
    let (_, text) = parts.next_element()?;
    *name = String::from_utf8_lossy(text)
        .trim_end_matches('\0')
        .to_owned();
    let other = |what: &str| Ok(Some(Variable::Other(what.to_owned())));
    match class {
        1 => return other("a cell array"),
        2 => return other("a structure"),
        3 | OPAQUE => return other("an object"),
        4 => return other("text"),
        5 => return other("a sparse matrix: save full(...) of it"),
        6..=15 => {}
        16 => return other("a function"),
        _ => return other("a variable of unknown class"),
    }
    if flags & COMPLEX != 0 {
        return other("complex numbers");
    }
    let [rows, columns] = dimensions[..] else {
        return other(&format!("an array of {} dimensions", dimensions.len()));
    };
    let size = |n: i64| usize::try_from(n).map_err(|_| Fault::new("dimensions not below zero", n));
    let (rows, columns) = (size(rows)?, size(columns)?);
    let count = rows.checked_mul(columns);
    let count = count.ok_or_else(|| Fault::new("fewer numbers", format!("{rows} x {columns}")))?;
    let numbers = parts.numbers(count, budget)?;
    matrix(rows, columns, true, numbers).map(|numbers| Some(Variable::Numbers(numbers)))
}

/// Type of an element that is a variable.
const MATRIX: u32 = 14;
/// Type of an element that holds a variable packed by zlib.
const COMPRESSED: u32 = 15;

/// Bytes of a tag, and what elements are padded to.
const TAG_BYTES: usize = 8;

/// Type and length of an element.
#[derive(Clone, Copy, Debug)]
struct Tag {
    kind: u32,
    /// Bytes of the data.
    length: usize,
    /// Whether the data are the last four bytes of the tag itself.
    small: bool,
}

impl Tag {
    fn read(bytes: &[u8; TAG_BYTES], order: ByteOrder) -> Result<Self, Fault> {
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
struct Elements<'a> {
    rest: &'a [u8],
    order: ByteOrder,
}

impl<'a> Elements<'a> {
    fn new(bytes: &'a [u8], order: ByteOrder) -> Self {
        Self { rest: bytes, order }
    }

    /// Type and data of the next element.
    fn next_element(&mut self) -> Result<(u32, &'a [u8]), Fault> {
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
    fn integers(&mut self) -> Result<Vec<i64>, Fault> {
        let (kind, data) = self.next_element()?;
        let numbers = numbers_of_type(kind, self.order)?;
        let numbers = numbers.read(data, data.len() / numbers.width)?;
        Ok(numbers.into_iter().map(|v| v as i64).collect())
    }

    /// `count` numbers of the next element.
    fn numbers(&mut self, count: usize, budget: &mut Budget) -> Result<Vec<f64>, Fault> {
        let (kind, data) = self.next_element()?;
        let layout = numbers_of_type(kind, self.order)?;
        budget.take(8 * (data.len() / layout.width) as u64)?;
        layout.read(data, count)
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

/// Text at the start of written files.
const WRITTEN_TEXT: &[u8] = b"MATLAB 5.0 MAT-file, written by inhand";

/// Bytes of the header before where MATLAB's own data would be, the version and the byte order.
const TEXT_BYTES: usize = 116;

/// MATLAB takes no longer element.
const LONGEST: usize = i32::MAX as usize;

const INT8: u32 = 1;
const INT32: u32 = 5;
const UINT32: u32 = 6;
const DOUBLE: u32 = 9;

/// Class of matrices of 64-bit floats.
const DOUBLE_CLASS: u32 = 6;

/// Writes matrices one after the other, little endian and not packed: what every reader of the last 25 years takes.
pub(crate) fn write(
    file: &str,
    matrices: &[(&str, &DMatrix<f64>)],
) -> Result<Vec<u8>, ExportError> {
    let mut out = WRITTEN_TEXT.to_vec();
    out.resize(TEXT_BYTES, b' ');
    out.resize(HEADER_BYTES - 4, 0);
    out.extend([0, 1, b'I', b'M']);
    for (name, matrix) in matrices {
        let too_large = || {
            let (rows, columns) = matrix.shape();
            not_written(file, name, format!("{rows} x {columns} numbers: use .npz"))
        };
        let size = |n: usize| i32::try_from(n).map_err(|_| too_large());
        let dimensions = [size(matrix.nrows())?, size(matrix.ncols())?];
        let mut body = Vec::with_capacity(8 * matrix.len() + 128);
        let flags = [DOUBLE_CLASS, 0].map(u32::to_le_bytes);
        write_element(&mut body, UINT32, flags.as_flattened());
        write_element(
            &mut body,
            INT32,
            dimensions.map(i32::to_le_bytes).as_flattened(),
        );
        write_element(&mut body, INT8, name.as_bytes());
        let numbers: Vec<u8> = matrix.iter().flat_map(|v| v.to_le_bytes()).collect();
        write_element(&mut body, DOUBLE, &numbers);
        if body.len() > LONGEST {
            return Err(too_large());
        }
        write_element(&mut out, MATRIX, &body);
    }
    Ok(out)
}

/// Writes an element. Lengths fit where the whole body's was found to.
fn write_element(out: &mut Vec<u8>, kind: u32, data: &[u8]) {
    out.extend(kind.to_le_bytes());
    out.extend((data.len() as u32).to_le_bytes());
    out.extend(data);
    out.resize(out.len().next_multiple_of(TAG_BYTES), 0);
}
