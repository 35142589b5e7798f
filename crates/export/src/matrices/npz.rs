//! `.npz`: a zip archive of `.npy` files, as `numpy.savez` and `numpy.savez_compressed` write it.

mod header;

use std::io::{Cursor, Read, Write as _};

use nalgebra::DMatrix;
use zip::result::ZipResult;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipArchive, ZipWriter};

use super::error::{Fault, not_written};
use super::number::matrix;
use super::{Variable, Variables};
use crate::error::ExportError;
use header::{Content, Header};

/// Extension of the arrays in the archive.
const ARRAY: &str = ".npy";

/// Reads every array of an archive.
pub(crate) fn read(bytes: &[u8], file: &str) -> Result<Variables, ExportError> {
    let archive = |error| Fault::new("a zip archive", error).at(file, "the archive");
    let mut zip = ZipArchive::new(Cursor::new(bytes)).map_err(archive)?;
    let mut variables = Variables::new();
    for n in 0..zip.len() {
        let place = format!("array {n} of the archive");
        let mut entry = (zip.by_index(n))
            .map_err(|error| Fault::new("a packed file", error).at(file, &place))?;
        let name = String::from_utf8_lossy(entry.name_raw()).into_owned();
        let Some(name) = name.strip_suffix(ARRAY) else {
            variables.insert(name, Variable::Other("a file that is no array".to_owned()));
            continue;
        };
        let variable =
            array(&mut entry).map_err(|fault| fault.at(file, format!("variable {name}")))?;
        variables.insert(name.to_owned(), variable);
    }
    Ok(variables)
}

fn array(input: &mut impl Read) -> Result<Variable, Fault> {
    let Header {
        content,
        by_column,
        shape,
    } = Header::read(input)?;
    let numbers = match content {
        Content::Numbers(numbers) => numbers,
        Content::Other(what) => return Ok(Variable::Other(what)),
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
    // One byte more than there should be: it shows whether there are more, and reading on to the end
    // lets the archive compare its checksum. The buffer grows with what is there, not with a size that
    // the header only claims.
    let most = (count * numbers.width) as u64;
    let mut bytes = Vec::new();
    (input.take(most.saturating_add(1)).read_to_end(&mut bytes))
        .map_err(|error| Fault::new("intact packed data", error))?;
    let numbers = numbers.read(&bytes, count)?;
    matrix(rows, columns, by_column, numbers).map(Variable::Numbers)
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
    zip.write_all(&header::written(matrix.nrows(), matrix.ncols()))?;
    let bytes: Vec<u8> = matrix.iter().flat_map(|v| v.to_le_bytes()).collect();
    zip.write_all(&bytes)?;
    Ok(())
}
