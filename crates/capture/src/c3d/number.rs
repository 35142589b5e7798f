//! Numbers of three kinds of processors.

/// The processor whose numbers a file holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Processor {
    /// Least significant byte first, IEEE 754.
    Intel,
    /// Integers as Intel, floating point as the VAX has it.
    Dec,
    /// Most significant byte first, IEEE 754.
    Mips,
}

/// Exponent of a VAX number whose mantissa is between 1 and 2.
const VAX_BIAS: i32 = 129;

impl Processor {
    /// The processor of that code in a file.
    pub(super) fn from_code(code: u8) -> Option<Self> {
        Some(match code {
            84 => Processor::Intel,
            85 => Processor::Dec,
            86 => Processor::Mips,
            _ => return None,
        })
    }

    pub(super) const fn name(self) -> &'static str {
        match self {
            Processor::Intel => "Intel",
            Processor::Dec => "DEC",
            Processor::Mips => "MIPS",
        }
    }

    pub(super) fn u16(self, bytes: [u8; 2]) -> u16 {
        match self {
            Processor::Intel | Processor::Dec => u16::from_le_bytes(bytes),
            Processor::Mips => u16::from_be_bytes(bytes),
        }
    }

    pub(super) fn i16(self, bytes: [u8; 2]) -> i16 {
        self.u16(bytes).cast_signed()
    }

    pub(super) fn f32(self, bytes: [u8; 4]) -> f32 {
        match self {
            Processor::Intel => f32::from_le_bytes(bytes),
            Processor::Mips => f32::from_be_bytes(bytes),
            Processor::Dec => vax(bytes),
        }
    }
}

/// A VAX number: two words, the more significant one first, each with its least significant byte
/// first; sign, eight bits of exponent, 23 bits of mantissa behind a hidden one.
fn vax([a, b, c, d]: [u8; 4]) -> f32 {
    let bits = u32::from_le_bytes([c, d, a, b]);
    let exponent = (bits >> 23 & 0xFF) as i32;
    if exponent == 0 {
        // Zero; with a sign it is an operand that no program may use.
        return if bits >> 31 == 0 { 0.0 } else { f32::NAN };
    }
    let mantissa = 1.0 + f64::from(bits & 0x7F_FFFF) / f64::from(1 << 23);
    let magnitude = mantissa * f64::from(exponent - VAX_BIAS).exp2();
    // The largest VAX number is half the largest of IEEE 754, so this fits.
    (if bits >> 31 == 0 {
        magnitude
    } else {
        -magnitude
    }) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_each_processor() {
        // Examples of the VAX architecture manual: 1 is 4080 hexadecimal, -0.5 is C000 and so on.
        for (bytes, value) in [
            ([0x80, 0x40, 0, 0], 1.0),
            ([0x00, 0xC0, 0, 0], -0.5),
            ([0x49, 0x41, 0xDB, 0x0F], std::f32::consts::PI),
            ([0x20, 0x44, 0, 0], 160.0),
            ([0, 0, 0, 0], 0.0),
        ] {
            let found = Processor::Dec.f32(bytes);
            assert!(
                (found - value).abs() <= 1e-5 * value.abs(),
                "{found} {value}"
            );
        }
        assert!(Processor::Dec.f32([0, 0x80, 0, 0]).is_nan());
        assert_eq!(Processor::Mips.f32(1.5_f32.to_be_bytes()), 1.5);
        assert_eq!(Processor::Intel.f32(1.5_f32.to_le_bytes()), 1.5);
        assert_eq!(Processor::Mips.i16([0xFF, 0xFE]), -2);
        assert_eq!(Processor::Dec.i16([0xFE, 0xFF]), -2);
    }
}
