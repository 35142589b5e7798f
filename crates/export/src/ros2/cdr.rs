//! Messages in common data representation (CDR), version 1, little endian.

/// Plain CDR, little endian, without options.
const HEADER: [u8; 4] = [0, 1, 0, 0];

/// A message while it is written: every number is at a multiple of its own size behind the header.
pub(super) struct Cdr<'a> {
    out: &'a mut Vec<u8>,
    start: usize,
}

impl<'a> Cdr<'a> {
    /// Starts a message behind what `out` holds.
    pub(super) fn new(out: &'a mut Vec<u8>) -> Self {
        out.extend(HEADER);
        let start = out.len();
        Self { out, start }
    }

    fn number<const N: usize>(&mut self, bytes: [u8; N]) -> &mut Self {
        let length = self.out.len() - self.start;
        self.out.resize(self.start + length.next_multiple_of(N), 0);
        self.out.extend(bytes);
        self
    }

    pub(super) fn u8(&mut self, number: u8) -> &mut Self {
        self.number([number])
    }

    pub(super) fn i32(&mut self, number: i32) -> &mut Self {
        self.number(number.to_le_bytes())
    }

    /// A number, or the length of a sequence.
    pub(super) fn u32(&mut self, number: usize) -> &mut Self {
        // No message has four thousand million parts.
        self.number((number as u32).to_le_bytes())
    }

    pub(super) fn f32(&mut self, number: f32) -> &mut Self {
        self.number(number.to_le_bytes())
    }

    pub(super) fn f64s(&mut self, numbers: impl IntoIterator<Item = f64>) -> &mut Self {
        for number in numbers {
            self.number(number.to_le_bytes());
        }
        self
    }

    /// A text; its length counts the NUL at the end.
    pub(super) fn text(&mut self, text: &str) -> &mut Self {
        self.u32(text.len() + 1);
        self.out.extend(text.as_bytes());
        self.u8(0)
    }

    /// `builtin_interfaces/Time` or `Duration`.
    pub(super) fn time(&mut self, nanos: u64) -> &mut Self {
        // ROS counts seconds with 31 bits.
        let seconds = i32::try_from(nanos / 1_000_000_000).unwrap_or(i32::MAX);
        self.i32(seconds).u32((nanos % 1_000_000_000) as usize)
    }

    /// `std_msgs/Header`.
    pub(super) fn header(&mut self, unix_nanos: u64, frame: &str) -> &mut Self {
        self.time(unix_nanos).text(frame)
    }

    /// `geometry_msgs/Pose`, and `Transform`, which has the same layout.
    pub(super) fn pose(&mut self, pose: &nalgebra::Isometry3<f64>) -> &mut Self {
        self.f64s(pose.translation.vector.iter().copied())
            .f64s(pose.rotation.coords.iter().copied())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_at_multiples_of_their_size_behind_the_header() {
        let mut out = vec![9];
        Cdr::new(&mut out)
            .u8(7)
            .i32(-1)
            .text("ab")
            .f64s([1.5])
            .time(2_000_000_003);
        let mut expected = vec![9, 0, 1, 0, 0, 7, 0, 0, 0, 255, 255, 255, 255];
        expected.extend([3, 0, 0, 0, b'a', b'b', 0, 0]);
        expected.extend(1.5_f64.to_le_bytes());
        expected.extend([2, 0, 0, 0, 3, 0, 0, 0]);
        assert_eq!(out, expected);
    }
}
