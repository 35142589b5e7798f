//! `.npz`: a zip archive of `.npy` files, as `numpy.savez` and `numpy.savez_compressed` write it.

use std::io::{Cursor, Read, Write as _};

use nalgebra::DMatrix;
use zip::result::ZipResult;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipArchive, ZipWriter};

use super::number::{ByteOrder, Kind, Numbers, matrix};
use super::{Budget, Fault, Variable, Variables, not_written};
use crate::error::ExportError;

/// Extension of the arrays in the archive.
const ARRAY: &str = ".npy";

/// Reads every array of an archive.
pub(crate) fn read(bytes: &[u8], file: &str) -> Result<Variables, ExportError> {
    let archive = |error| Fault::new("a zip archive", error).at(file, "the archive");
    let mut zip = ZipArchive::new(Cursor::new(bytes)).map_err(archive)?;
    let (mut variables, mut budget) = (Variables::new(), Budget::new());
    for n in 0..zip.len() {
        let place = format!("array {n} of the archive");
        let mut entry = (zip.by_index(n))
            .map_err(|error| Fault::new("a packed file", error).at(file, &place))?;
        let name = String::from_utf8_lossy(entry.name_raw()).into_owned();
        let Some(name) = name.strip_suffix(ARRAY) else {
            variables.insert(name, Variable::Other("a file that is no array".to_owned()));
            continue;
        };
        let variable = array(&mut entry, &mut budget)
            .map_err(|fault| fault.at(file, format!("variable {name}")))?;
        variables.insert(name.to_owned(), variable);
    }
    Ok(variables)
}

fn array(input: &mut impl Read, budget: &mut Budget) -> Result<Variable, Fault> {
    let Header {
        content,
        by_column,
        shape,
    } = Header::read(input)?;
    let numbers = match content {
        Ok(numbers) => numbers,
        Err(what) => return Ok(Variable::Other(what)),
    };
    let (rows, columns) = match shape[..] {
        [] => (1, 1),
        [rows] => (rows, 1),
        [rows, columns] => (rows, columns),
        _ => {
            return Ok(Variable::Other(format!(
                "an array of {} dimensions",
                shape.len()
            )));
        }
    };
    let count = (rows.checked_mul(columns)).filter(|n| n.checked_mul(numbers.width).is_some());
    let count = count.ok_or_else(|| Fault::new("fewer numbers", format!("{rows} x {columns}")))?;
    // Numbers by row are put in another order, for which there are two of each.
    let copies = if by_column { 1 } else { 2 };
    let numbers = read_numbers(input, numbers, count, |n| {
        budget.take(copies * 8 * n as u64)
    })?;
    matrix(rows, columns, by_column, numbers).map(Variable::Numbers)
}

/// Numbers that are unpacked at a time.
const PIECE: usize = 1 << 13;

/// Reads `count` numbers and no more; memory grows with what is there, not with a size that the header only claims, and
/// `take` is asked for it.
fn read_numbers(
    input: &mut impl Read,
    layout: Numbers,
    count: usize,
    mut take: impl FnMut(usize) -> Result<(), Fault>,
) -> Result<Vec<f64>, Fault> {
    let (mut numbers, mut bytes) = (Vec::new(), Vec::new());
    loop {
        let left = count - numbers.len();
        let wanted = left.min(PIECE);
        take(wanted)?;
        // One byte more than there should be at the end: it shows whether there are more, and reading on to the end
        // lets the archive compare its checksum.
        let most = wanted * layout.width + usize::from(wanted == left);
        bytes.clear();
        (input.take(most as u64).read_to_end(&mut bytes))
            .map_err(|error| Fault::new("intact packed data", error))?;
        if bytes.len() != wanted * layout.width {
            let expected = format!("{count} numbers of {} bytes", layout.width);
            let found = numbers.len() * layout.width + bytes.len();
            return Err(Fault::new(expected, format!("{found} bytes")));
        }
        numbers.extend(layout.read(&bytes, wanted)?);
        if wanted == left {
            return Ok(numbers);
        }
    }
}

/// Writes an archive of arrays in Fortran order, not packed.
pub(crate) fn write(
    file: &str,
    matrices: &[(&str, &DMatrix<f64>)],
) -> Result<Vec<u8>, ExportError> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, matrix) in matrices {
        add(&mut zip, name, matrix).map_err(|error| not_written(file, name, error))?;
    }
    let archive = zip
        .finish()
        .map_err(|error| not_written(file, "all", error))?;
    Ok(archive.into_inner())
}

fn add(zip: &mut ZipWriter<Cursor<Vec<u8>>>, name: &str, matrix: &DMatrix<f64>) -> ZipResult<()> {
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Stored)
        // The same matrices give the same bytes.
        .last_modified_time(DateTime::default());
    zip.start_file(format!("{name}{ARRAY}"), options)?;
    zip.write_all(&header(matrix.nrows(), matrix.ncols()))?;
    let bytes: Vec<u8> = matrix.iter().flat_map(|v| v.to_le_bytes()).collect();
    zip.write_all(&bytes)?;
    Ok(())
}

const MARK: [u8; 6] = *b"\x93NUMPY";

/// The data starts at a multiple of this.
const ALIGNMENT: usize = 64;

/// Headers are far shorter; this much is read of one that claims to be longer.
const LONGEST: u64 = 1 << 16;

/// The header of a `.npy` file (NumPy's format specification, `numpy.lib.format`): a mark, a version,
/// a length and a Python dictionary of three entries, such as
/// `{'descr': '<f8', 'fortran_order': False, 'shape': (1500, 200), }`.
#[derive(Debug)]
struct Header {
    /// The type of its numbers, or what else is in it, in words.
    content: Result<Numbers, String>,
    by_column: bool,
    shape: Vec<usize>,
}

impl Header {
    fn read(input: &mut impl Read) -> Result<Self, Fault> {
        let fault = |error| Fault::new("the header of an array (.npy)", error);
        let mut start = [0; 8];
        input.read_exact(&mut start).map_err(fault)?;
        let [mark @ .., major, minor] = start;
        if mark != MARK {
            let found = mark.escape_ascii();
            return Err(Fault::new("an array that starts with \\x93NUMPY", found));
        }
        let bytes = match major {
            1 => 2,
            2 | 3 => 4,
            _ => {
                let found = format!("{major}.{minor}");
                return Err(Fault::new("version 1, 2 or 3 of the array's header", found));
            }
        };
        let mut length = [0; 4];
        input.read_exact(&mut length[..bytes]).map_err(fault)?;
        let length = u64::from(u32::from_le_bytes(length));
        if length > LONGEST {
            let expected = format!("a header of at most {LONGEST} bytes");
            return Err(Fault::new(expected, length));
        }
        let mut text = Vec::new();
        (input.take(length).read_to_end(&mut text)).map_err(fault)?;
        Self::parse(&String::from_utf8_lossy(&text))
    }

    fn parse(text: &str) -> Result<Self, Fault> {
        let entry = |key: &str, expected: &str| {
            value(text, key).ok_or_else(|| Fault::new(format!("{key}: {expected}"), text.trim()))
        };
        let by_column = match entry("fortran_order", "True or False")? {
            "True" => true,
            "False" => false,
            found => return Err(Fault::new("fortran_order: True or False", found)),
        };
        let shape = entry("shape", "a tuple of sizes")?;
        let shape = shape_of(shape).ok_or_else(|| Fault::new("shape: a tuple of sizes", shape))?;
        Ok(Self {
            content: content(entry("descr", "a type")?),
            by_column,
            shape,
        })
    }
}

/// The value of a key in a Python dictionary, as text.
fn value<'a>(text: &'a str, key: &str) -> Option<&'a str> {
    // A field of a structured type may have the same name, but no colon.
    let rest = ['\'', '"'].into_iter().find_map(|quote| {
        let quoted = format!("{quote}{key}{quote}");
        (text.match_indices(&quoted))
            .find_map(|(at, _)| text[at + quoted.len()..].trim_start().strip_prefix(':'))
    })?;
    let (mut depth, mut quoted) = (0_usize, None);
    for (at, c) in rest.char_indices() {
        match (quoted, c) {
            (Some(quote), _) if quote == c => quoted = None,
            (Some(_), _) => {}
            (None, '\'' | '"') => quoted = Some(c),
            (None, '(' | '[' | '{') => depth += 1,
            (None, ',' | '}') if depth == 0 => return Some(rest[..at].trim()),
            (None, ')' | ']' | '}') => depth = depth.checked_sub(1)?,
            _ => {}
        }
    }
    None
}

/// Sizes of a tuple such as `()`, `(3,)` or `(3, 4)`.
fn shape_of(tuple: &str) -> Option<Vec<usize>> {
    let sizes = tuple.strip_prefix('(')?.strip_suffix(')')?;
    let sizes = sizes
        .split(',')
        .map(str::trim)
        .filter(|size| !size.is_empty());
    // Python 2 wrote long integers with an L.
    sizes
        .map(|size| size.strip_suffix('L').unwrap_or(size).parse().ok())
        .collect()
}

/// Content of an array of a type such as `'<f8'`.
fn content(descr: &str) -> Result<Numbers, String> {
    let other = |what: &str| Err(format!("{what} ({descr})"));
    let quoted = ['\'', '"']
        .into_iter()
        .find_map(|quote| descr.strip_prefix(quote)?.strip_suffix(quote));
    let Some(name) = quoted else {
        return other("a structured array");
    };
    let mut letters = name.chars();
    let order = match letters.next() {
        // `=` is not written to files, and one byte has no order.
        Some('<' | '|') => ByteOrder::Little,
        Some('>') => ByteOrder::Big,
        _ => return other("an array of unknown type"),
    };
    let kind = match letters.next() {
        Some('f') => Kind::Float,
        Some('i') => Kind::Signed,
        Some('u' | 'b') => Kind::Unsigned,
        Some('c') => return other("complex numbers"),
        Some('U' | 'S' | 'a') => return other("text"),
        Some('O') => return other("Python objects"),
        Some('M' | 'm') => return other("times"),
        _ => return other("an array of unknown type"),
    };
    match (kind, letters.as_str().parse()) {
        (Kind::Float, Ok(width @ (2 | 4 | 8))) | (_, Ok(width @ (1 | 2 | 4 | 8))) => {
            if (kind, width) == (Kind::Float, 1) {
                return other("an array of unknown type");
            }
            Ok(Numbers { kind, width, order })
        }
        _ => other("numbers of an unusual width"),
    }
}

/// The header of a matrix of 64-bit floats, column by column.
fn header(rows: usize, columns: usize) -> Vec<u8> {
    let mut text =
        format!("{{'descr': '<f8', 'fortran_order': True, 'shape': ({rows}, {columns}), }}");
    // Mark, version and length are in front, a line feed ends it.
    let start = MARK.len() + 4;
    let length = (start + text.len() + 1).next_multiple_of(ALIGNMENT) - start;
    text.extend(std::iter::repeat_n(' ', length - 1 - text.len()));
    text.push('\n');
    let mut header = MARK.to_vec();
    header.extend([1, 0]);
    // Two sizes have at most forty digits.
    header.extend((length as u16).to_le_bytes());
    header.extend(text.as_bytes());
    header
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_are_found_in_any_order_and_quoting() {
        let text = r#"{"shape": (3L, 4), 'descr': [('a', '<f8'), ('shape', '<i4')], 'fortran_order': True}"#;
        assert_eq!(value(text, "shape"), Some("(3L, 4)"));
        assert_eq!(value(text, "fortran_order"), Some("True"));
        assert_eq!(shape_of("(3L, 4)"), Some(vec![3, 4]));
        assert_eq!(shape_of("()"), Some(vec![]));
        assert_eq!(shape_of("(7,)"), Some(vec![7]));
        assert_eq!(shape_of("(-1,)"), None);
        let header = Header::parse(text).unwrap();
        assert!(
            header
                .content
                .is_err_and(|what| what.contains("structured"))
        );
        assert!(Header::parse("{'descr': '<f8'}").is_err());
        assert!(Header::parse("{'descr': ))").is_err());
    }

    #[test]
    fn headers_are_aligned() {
        for (rows, columns) in [(0, 0), (1500, 200), (usize::MAX, usize::MAX)] {
            let bytes = super::header(rows, columns);
            assert_eq!(bytes.len() % ALIGNMENT, 0);
            let header = Header::read(&mut bytes.as_slice()).unwrap();
            assert!(header.by_column);
            assert_eq!(header.shape, [rows, columns]);
        }
    }
}
