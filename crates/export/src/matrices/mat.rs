//! `.mat` of level 5, as MATLAB's `save -v6` and `save -v7`, Octave and SciPy write it ("MAT-File
//! Format", The MathWorks, chapter 1: Level 5 MAT-File Format).
//!
//! A header of 128 bytes, then elements: a tag with type and length, the data, and zeros up to a
//! multiple of eight bytes. A variable is an element of elements: flags, dimensions, name, numbers; by
//! default MATLAB packs each into an element of zlib data. Numbers are in the smallest type that
//! holds them, whatever the variable's class.

mod element;
mod write;

use std::io::Read as _;

use flate2::read::ZlibDecoder;

use super::error::Fault;
use super::number::{ByteOrder, matrix};
use super::{Variable, Variables};
use crate::error::ExportError;
use element::{COMPRESSED, Elements, MATRIX, Tag};
pub(crate) use write::write;

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
    let mut variables = Variables::new();
    let mut elements = Elements::new(&bytes[HEADER_BYTES..], order);
    while !elements.is_empty() {
        let at = bytes.len() - elements.len();
        let mut name = String::new();
        let variable = element(&mut elements, &mut name).map_err(|fault| {
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
fn element(elements: &mut Elements, name: &mut String) -> Result<Option<Variable>, Fault> {
    let order = elements.order();
    let (kind, data) = elements.next_element()?;
    match kind {
        MATRIX => variable(Elements::new(data, order), name),
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
            (input.take(length as u64 + 1).read_to_end(&mut body)).map_err(fault)?;
            if body.len() != length {
                let found = if body.len() < length { "fewer" } else { "more" };
                return Err(Fault::new(
                    format!("{length} bytes in the packed data"),
                    found,
                ));
            }
            variable(Elements::new(&body, order), name)
        }
        // Others are allowed there, but hold no variable.
        _ => Ok(None),
    }
}

fn variable(mut parts: Elements, name: &mut String) -> Result<Option<Variable>, Fault> {
    if parts.is_empty() {
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
    let numbers = parts.numbers(count)?;
    matrix(rows, columns, true, numbers).map(|numbers| Some(Variable::Numbers(numbers)))
}
