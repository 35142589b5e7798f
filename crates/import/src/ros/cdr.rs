//! Common data representation (CDR), version 1: how ROS 2 lays messages out.
//!
//! Four bytes of header say the order of bytes; behind them every number is at a multiple of its
//! own size, counted from the end of the header.
//!
//! ROS 1 stores the same numbers, texts and sequences one after the other: without header and padding, least
//! significant byte first.

use std::borrow::Cow;

use crate::reading::{Fault, Stored};

/// Encoding of the messages of ROS 1.
pub(crate) const ROS1: &str = "ros1";

/// Bytes in front of the message: kind and options.
const HEADER_BYTES: usize = 4;

/// The kinds of plain CDR, big and little endian.
const KINDS: [[u8; 2]; 2] = [[0, 0], [0, 1]];

/// Writers may pad a message to a multiple of this.
const PADDING_BYTES: usize = 4;

/// A message while it is read; nothing is taken on trust, nothing is allocated.
pub(crate) struct Cdr<'a> {
    payload: &'a [u8],
    at: usize,
    little_endian: bool,
    is_ros1: bool,
}

impl<'a> Cdr<'a> {
    /// A message from its start.
    pub(crate) fn new(message: Stored<'a>) -> Result<Self, Fault> {
        let bytes = message.bytes;
        if message.encoding == ROS1 {
            return Ok(Self {
                payload: bytes,
                at: 0,
                little_endian: true,
                is_ros1: true,
            });
        }
        let Some((header, payload)) = bytes.split_first_chunk::<HEADER_BYTES>() else {
            return Err(Fault::new(
                "the four bytes of a CDR header",
                format!("{} bytes", bytes.len()),
            ));
        };
        let kind = [header[0], header[1]];
        if !KINDS.contains(&kind) {
            return Err(Fault::new(
                "plain CDR, header 00 00 or 00 01",
                format!("header {:02x} {:02x}", kind[0], kind[1]),
            ));
        }
        Ok(Self {
            payload,
            at: 0,
            little_endian: kind == KINDS[1],
            is_ros1: false,
        })
    }

    pub(crate) fn is_ros1(&self) -> bool {
        self.is_ros1
    }

    pub(crate) fn i8(&mut self) -> Result<i8, Fault> {
        self.number().map(i8::from_le_bytes)
    }

    pub(crate) fn u32(&mut self) -> Result<u32, Fault> {
        self.number().map(u32::from_le_bytes)
    }

    pub(crate) fn i32(&mut self) -> Result<i32, Fault> {
        self.number().map(i32::from_le_bytes)
    }

    pub(crate) fn f64(&mut self) -> Result<f64, Fault> {
        self.number().map(f64::from_le_bytes)
    }

    pub(crate) fn f64s<const N: usize>(&mut self) -> Result<[f64; N], Fault> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = self.f64()?;
        }
        Ok(numbers)
    }

    /// A text; bytes that are no UTF-8 are replaced.
    pub(crate) fn text(&mut self) -> Result<Cow<'a, str>, Fault> {
        let length = self.u32()?;
        let bytes = self.take(length as usize, || format!("a text of {length} bytes"))?;
        // The length counts the NUL at the end.
        let bytes = bytes.strip_suffix(&[0]).unwrap_or(bytes);
        Ok(String::from_utf8_lossy(bytes))
    }

    /// The length of a sequence whose elements have at least `element_bytes` each.
    pub(crate) fn count(&mut self, element_bytes: usize) -> Result<usize, Fault> {
        let count = self.u32()? as usize;
        let left = self.payload.len() - self.at;
        if count > left / element_bytes.max(1) {
            return Err(Fault::new(
                format!("room for a sequence of {count} elements"),
                format!("{left} bytes left"),
            ));
        }
        Ok(count)
    }

    /// Makes sure that nothing follows but padding.
    pub(crate) fn end(&self) -> Result<(), Fault> {
        let left = self.payload.len() - self.at;
        if left < PADDING_BYTES {
            return Ok(());
        }
        Err(Fault::new(
            format!("the message to end after {} bytes", self.at),
            format!("{left} bytes more: the message type has another layout here"),
        ))
    }

    fn header_bytes(&self) -> usize {
        if self.is_ros1 { 0 } else { HEADER_BYTES }
    }

    /// The bytes of a number, least significant first.
    fn number<const N: usize>(&mut self) -> Result<[u8; N], Fault> {
        let aligned = if self.is_ros1 {
            self.at
        } else {
            self.at.next_multiple_of(N)
        };
        let padding = aligned - self.at;
        self.take(padding, || format!("{padding} bytes of padding"))?;
        let bytes = self.take(N, || format!("a number of {N} bytes"))?;
        let mut number = [0; N];
        number.copy_from_slice(bytes);
        if !self.little_endian {
            number.reverse();
        }
        Ok(number)
    }

    fn take(&mut self, length: usize, what: impl Fn() -> String) -> Result<&'a [u8], Fault> {
        let rest = self.payload.get(self.at..).unwrap_or_default();
        match rest.split_at_checked(length) {
            Some((bytes, _)) => {
                self.at += length;
                Ok(bytes)
            }
            None => Err(Fault::new(
                format!("{} at byte {}", what(), self.header_bytes() + self.at),
                format!("{} bytes left", rest.len()),
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ros2(bytes: &[u8]) -> Result<Cdr<'_>, Fault> {
        Cdr::new(Stored {
            encoding: "cdr",
            bytes,
        })
    }

    #[test]
    fn numbers_lie_at_multiples_of_their_size_in_either_order() {
        let little = [0, 1, 0, 0, 7, 0, 0, 0, 1, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];
        let mut cdr = ros2(&little).unwrap();
        assert_eq!(cdr.i8().unwrap(), 7);
        assert_eq!(cdr.u32().unwrap(), 0x201); // three bytes of padding before it
        assert_eq!(cdr.f64().unwrap(), 0.0); // none: byte 8 behind the header
        cdr.end().unwrap();

        let mut big = vec![0, 0, 0, 0, 0, 0, 2, 1];
        big.extend([0; 4]);
        big.extend(1.5_f64.to_be_bytes());
        let mut cdr = ros2(&big).unwrap();
        assert_eq!(cdr.i32().unwrap(), 0x201);
        assert_eq!(cdr.f64().unwrap(), 1.5); // four bytes of padding
        cdr.end().unwrap();
    }

    #[test]
    fn ros_1_has_neither_header_nor_padding() {
        let bytes = [
            7, 1, 2, 0, 0, 2, 0, 0, 0, b'a', b'b', 0, 0, 0, 0, 0, 0, 0xF8, 0x3F,
        ];
        let message = Stored {
            encoding: ROS1,
            bytes: &bytes,
        };
        let mut ros1 = Cdr::new(message).unwrap();
        assert_eq!((ros1.i8().unwrap(), ros1.u32().unwrap()), (7, 0x201));
        assert_eq!((&*ros1.text().unwrap(), ros1.f64().unwrap()), ("ab", 1.5));
        ros1.end().unwrap();
        assert!(ros1.u32().unwrap_err().to_string().contains("at byte 19"));
    }

    #[test]
    fn texts_end_with_nul_or_do_not() {
        let mut bytes = vec![0, 1, 0, 0, 3, 0, 0, 0, b'a', b'b', 0, 0xff];
        bytes.extend([1, 0, 0, 0, 0xff, 0, 0, 0, 0, 0, 0, 0]);
        let mut cdr = ros2(&bytes).unwrap();
        assert_eq!(cdr.text().unwrap(), "ab");
        assert_eq!(cdr.text().unwrap(), "\u{fffd}");
        assert_eq!(cdr.text().unwrap(), "");
    }

    #[test]
    fn what_does_not_fit_is_refused_by_its_place() {
        let fault = |bytes: &[u8], read: fn(&mut Cdr<'_>) -> Result<(), Fault>| {
            let fault = ros2(bytes).and_then(|mut cdr| read(&mut cdr));
            fault.unwrap_err().to_string()
        };
        assert!(fault(&[0, 1, 0], |_| Ok(())).contains("CDR header"));
        let other = fault(&[0, 7, 0, 0], |_| Ok(()));
        assert!(other.contains("header 00 07"), "{other}");
        let text = fault(&[0, 1, 0, 0, 255, 255, 255, 255, 0], |cdr| {
            cdr.text().map(drop)
        });
        assert!(text.contains("4294967295 bytes at byte 8"), "{text}");
        let sequence = fault(&[0, 1, 0, 0, 9, 0, 0, 0, 0], |cdr| cdr.count(1).map(drop));
        assert!(sequence.contains("9 elements"), "{sequence}");
        let rest = fault(&[0; 9], |cdr| cdr.end());
        assert!(rest.contains("5 bytes more"), "{rest}");
        assert!(ros2(&[0; 7]).unwrap().end().is_ok());
    }
}
