//! Numbers of every type as 64-bit floats.

use nalgebra::DMatrix;

use super::Fault;

/// Integers beyond this are not all 64-bit floats.
const EXACT_INTEGER: i128 = 1 << 53;

/// Order of the bytes of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ByteOrder {
    Little,
    Big,
}

/// Type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Float,
    Signed,
    Unsigned,
}

/// Type of numbers and their layout in bytes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Numbers {
    pub(crate) kind: Kind,
    /// Bytes of one.
    pub(crate) width: usize,
    pub(crate) order: ByteOrder,
}

impl Numbers {
    /// `count` numbers from exactly these bytes.
    pub(crate) fn read(self, bytes: &[u8], count: usize) -> Result<Vec<f64>, Fault> {
        if count.checked_mul(self.width) != Some(bytes.len()) {
            let expected = format!("{count} numbers of {} bytes", self.width);
            return Err(Fault::new(expected, format!("{} bytes", bytes.len())));
        }
        if let (Kind::Float, 8, ByteOrder::Little) = (self.kind, self.width, self.order) {
            let numbers = bytes.as_chunks::<8>().0.iter();
            return Ok(numbers.map(|&bytes| f64::from_le_bytes(bytes)).collect());
        }
        bytes
            .chunks_exact(self.width)
            .map(|bytes| self.one(bytes))
            .collect()
    }

    fn one(self, bytes: &[u8]) -> Result<f64, Fault> {
        let mut bits = 0_u64;
        let mut shift = |byte: &u8| bits = bits << 8 | u64::from(*byte);
        match self.order {
            ByteOrder::Big => bytes.iter().for_each(&mut shift),
            ByteOrder::Little => bytes.iter().rev().for_each(&mut shift),
        }
        let unused = 64 - 8 * self.width as u32;
        match (self.kind, self.width) {
            (Kind::Float, 8) => Ok(f64::from_bits(bits)),
            (Kind::Float, 4) => Ok(f64::from(f32::from_bits(bits as u32))),
            (Kind::Float, 2) => Ok(half(bits as u16)),
            (Kind::Signed, 1 | 2 | 4 | 8) => exact(((bits << unused) as i64 >> unused).into()),
            (Kind::Unsigned, 1 | 2 | 4 | 8) => exact(bits.into()),
            (_, width) => Err(Fault::new("numbers of 1, 2, 4 or 8 bytes", width)),
        }
    }
}

fn exact(integer: i128) -> Result<f64, Fault> {
    if integer.abs() <= EXACT_INTEGER {
        return Ok(integer as f64);
    }
    Err(Fault::new("integers of at most 2^53", integer))
}

/// A float of two bytes (IEEE 754 binary16).
fn half(bits: u16) -> f64 {
    let sign = if bits >> 15 == 0 { 1.0 } else { -1.0 };
    let (exponent, fraction) = (i32::from(bits >> 10 & 0x1F), f64::from(bits & 0x3FF));
    sign * match exponent {
        0 => fraction * 2f64.powi(-24),
        0x1F if fraction == 0.0 => f64::INFINITY,
        0x1F => f64::NAN,
        _ => (1.0 + fraction / 1024.0) * 2f64.powi(exponent - 15),
    }
}

/// A matrix from its numbers, row by row or column by column.
pub(crate) fn matrix(
    rows: usize,
    columns: usize,
    by_column: bool,
    numbers: Vec<f64>,
) -> Result<DMatrix<f64>, Fault> {
    if rows.checked_mul(columns) != Some(numbers.len()) {
        let expected = format!("{rows} x {columns} numbers");
        return Err(Fault::new(expected, numbers.len()));
    }
    Ok(if by_column {
        DMatrix::from_vec(rows, columns, numbers)
    } else {
        DMatrix::from_row_slice(rows, columns, &numbers)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_every_type_are_what_they_say() {
        let numbers = |kind, width, order| Numbers { kind, width, order };
        let one = |numbers: Numbers, bytes: &[u8]| numbers.read(bytes, 1).map(|read| read[0]);
        use ByteOrder::{Big, Little};
        for (kind, width, bytes, expected) in [
            (Kind::Signed, 1, &[0xFE_u8][..], -2.0),
            (Kind::Signed, 2, &[0xFF, 0xFE], -2.0),
            (Kind::Unsigned, 2, &[0xFF, 0xFE], 65534.0),
            (Kind::Signed, 4, &[0x80, 0, 0, 0], -2147483648.0),
            (Kind::Signed, 8, &[0xFF; 8], -1.0),
            (
                Kind::Unsigned,
                8,
                &[0, 0x20, 0, 0, 0, 0, 0, 0],
                9007199254740992.0,
            ),
            (Kind::Float, 2, &[0x3E, 0x00], 1.5),
            (Kind::Float, 2, &[0x80, 0x01], -5.960464477539063e-8),
            (Kind::Float, 2, &[0xFC, 0x00], f64::NEG_INFINITY),
            (Kind::Float, 4, &[0x3F, 0xC0, 0, 0], 1.5),
            (Kind::Float, 8, &[0xBF, 0xF8, 0, 0, 0, 0, 0, 0], -1.5),
        ] {
            assert_eq!(one(numbers(kind, width, Big), bytes).unwrap(), expected);
            let reversed: Vec<u8> = bytes.iter().rev().copied().collect();
            assert_eq!(
                one(numbers(kind, width, Little), &reversed).unwrap(),
                expected
            );
        }
        let large = numbers(Kind::Unsigned, 8, Big);
        assert!(one(large, &[0xFF; 8]).is_err());
        assert!(large.read(&[0; 15], 2).is_err());
    }
}
