//! The three messages that every other one holds, written by hand.
//!
//! Derived proto3 code leaves a field out when it equals zero, and `-0.0 == 0.0`: a recording would
//! not come back bit for bit. Points and quaternions therefore always carry every coordinate,
//! which the wire format allows and which makes them of fixed length and quick to write.

use prost::bytes::{Buf, BufMut};
use prost::encoding::{DecodeContext, WireType, double, skip_field};
use prost::{DecodeError, Message};

/// `google.protobuf.Timestamp`.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Message)]
pub(crate) struct Timestamp {
    /// Seconds since 1970-01-01 UTC.
    #[prost(int64, tag = "1")]
    pub(crate) seconds: i64,
    /// Nanoseconds of the second.
    #[prost(int32, tag = "2")]
    pub(crate) nanos: i32,
}

const NANOS_PER_SECOND: u64 = 1_000_000_000;

impl Timestamp {
    /// From nanoseconds since 1970-01-01 UTC.
    pub(crate) fn from_unix_nanos(unix_nanos: u64) -> Self {
        Self {
            // 2^64 nanoseconds are 1.8e10 seconds, and a remainder is below 1e9: both fit.
            seconds: (unix_nanos / NANOS_PER_SECOND) as i64,
            nanos: (unix_nanos % NANOS_PER_SECOND) as i32,
        }
    }
}

/// The time as viewer messages state it; those end with the year 2106.
pub(crate) fn viewer_time(unix_nanos: u64) -> foxglove::messages::Timestamp {
    let seconds = u32::try_from(unix_nanos / NANOS_PER_SECOND).unwrap_or(u32::MAX);
    foxglove::messages::Timestamp::new(seconds, (unix_nanos % NANOS_PER_SECOND) as u32)
}

macro_rules! doubles {
    ($(#[$doc:meta])* $name:ident { $($field:ident = $tag:literal),* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        pub(crate) struct $name {
            $(pub(crate) $field: f64,)*
        }

        impl Message for $name {
            fn encode_raw(&self, buf: &mut impl BufMut) {
                $(double::encode($tag, &self.$field, buf);)*
            }

            fn merge_field(
                &mut self,
                tag: u32,
                wire_type: WireType,
                buf: &mut impl Buf,
                ctx: DecodeContext,
            ) -> Result<(), DecodeError> {
                match tag {
                    $($tag => double::merge(wire_type, &mut self.$field, buf, ctx),)*
                    _ => skip_field(wire_type, tag, buf, ctx),
                }
            }

            fn encoded_len(&self) -> usize {
                // One byte of tag and eight of number each.
                9 * [$($tag),*].len()
            }

            fn clear(&mut self) {
                *self = Self::default();
            }
        }
    };
}

doubles! {
    /// `inhand.Point`, metres.
    Point { x = 1, y = 2, z = 3 }
}

doubles! {
    /// `inhand.Quaternion`.
    Quaternion { x = 1, y = 2, z = 3, w = 4 }
}

impl Point {
    pub(crate) fn to_array(self) -> [f64; 3] {
        [self.x, self.y, self.z]
    }
}

impl From<[f64; 3]> for Point {
    fn from([x, y, z]: [f64; 3]) -> Self {
        Self { x, y, z }
    }
}

impl From<[f64; 4]> for Quaternion {
    fn from([x, y, z, w]: [f64; 4]) -> Self {
        Self { x, y, z, w }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn negative_zero_and_zero_survive() {
        let point = Point::from([-0.0, 0.0, 1e-300]);
        let bytes = point.encode_to_vec();
        assert_eq!(bytes.len(), point.encoded_len());
        let back = Point::decode(bytes.as_slice()).unwrap();
        assert_eq!(
            back.to_array().map(f64::to_bits),
            point.to_array().map(f64::to_bits)
        );
    }

    #[test]
    fn absent_coordinates_are_zero_and_unknown_fields_are_skipped() {
        // Field 2 (y) = 1.0 and an unknown varint field 9, as another writer may leave zeros out.
        let mut bytes = vec![0x11];
        bytes.extend(1.0_f64.to_le_bytes());
        bytes.extend([0x48, 0x05]);
        assert_eq!(
            Point::decode(bytes.as_slice()).unwrap(),
            Point::from([0.0, 1.0, 0.0])
        );
    }

    #[test]
    fn times_split_at_the_second() {
        let time = Timestamp::from_unix_nanos(1_700_000_000_123_456_789);
        assert_eq!((time.seconds, time.nanos), (1_700_000_000, 123_456_789));
        assert_eq!(viewer_time(u64::MAX).sec(), u32::MAX);
    }
}
