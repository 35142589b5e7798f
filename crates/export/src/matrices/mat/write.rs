//! Writing level 5, little endian, not packed: what every reader of the last 25 years takes.

use nalgebra::DMatrix;

use super::HEADER_BYTES;
use super::element::{MATRIX, TAG_BYTES};
use crate::error::ExportError;
use crate::matrices::error::not_written;

const TEXT: &[u8] = b"MATLAB 5.0 MAT-file, written by inhand";

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

/// Writes matrices one after the other.
pub(crate) fn write(
    file: &str,
    matrices: &[(&str, &DMatrix<f64>)],
) -> Result<Vec<u8>, ExportError> {
    let mut out = TEXT.to_vec();
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
        element(&mut body, UINT32, flags.as_flattened());
        element(
            &mut body,
            INT32,
            dimensions.map(i32::to_le_bytes).as_flattened(),
        );
        element(&mut body, INT8, name.as_bytes());
        let numbers: Vec<u8> = matrix.iter().flat_map(|v| v.to_le_bytes()).collect();
        element(&mut body, DOUBLE, &numbers);
        if body.len() > LONGEST {
            return Err(too_large());
        }
        element(&mut out, MATRIX, &body);
    }
    Ok(out)
}

/// Lengths fit where the whole body's was found to.
fn element(out: &mut Vec<u8>, kind: u32, data: &[u8]) {
    out.extend(kind.to_le_bytes());
    out.extend((data.len() as u32).to_le_bytes());
    out.extend(data);
    out.resize(out.len().next_multiple_of(TAG_BYTES), 0);
}
