//! Widths and codes of Helvetica, which files name and do not hold.

/// The encoding of the fonts: that of Windows, and signs of mathematics under codes that it leaves free.
pub(super) const ENCODING: &str = "<< /Type /Encoding /BaseEncoding /WinAnsiEncoding /Differences [1 /minus /lessequal /greaterequal] >>";

/// Letters outside Latin-1 with their codes.
const OTHERS: [(char, u8); 9] = [
    ('−', 1),
    ('≤', 2),
    ('≥', 3),
    ('…', 0x85),
    ('’', 0x92),
    ('–', 0x96),
    // Narrow spaces between groups of digits.
    ('\u{202f}', b' '),
    ('\u{2009}', b' '),
    ('⁻', 1),
];

/// A part of a text in one size.
pub(super) struct Run {
    /// Codes of its letters.
    bytes: Vec<u8>,
    /// Size, and height above the baseline, as shares of the text's size.
    pub(super) size: f64,
    pub(super) rise: f64,
}

/// The text in runs: exponents of which the font lacks the figures are small and raised.
pub(super) fn runs(text: &str) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    for letter in text.chars() {
        let (byte, raised) = code(letter);
        let (size, rise) = if raised { (0.65, 0.35) } else { (1.0, 0.0) };
        match runs.last_mut() {
            Some(last) if last.rise == rise => last.bytes.push(byte),
            _ => runs.push(Run {
                bytes: vec![byte],
                size,
                rise,
            }),
        }
    }
    runs
}

/// Code of a letter, that of a question mark where there is none, and whether it is raised.
fn code(letter: char) -> (u8, bool) {
    let byte = u8::try_from(u32::from(letter)).ok();
    match letter {
        ' '..='~' | '\u{a0}'..='ÿ' => (byte.unwrap_or(b'?'), false),
        '⁰' | '⁴'..='⁹' => (b'0' + (u32::from(letter) - u32::from('⁰')) as u8, true),
        _ => {
            let other = OTHERS.iter().find(|(own, _)| *own == letter);
            (other.map_or(b'?', |own| own.1), letter == '⁻')
        }
    }
}

impl Run {
    /// Width as a share of the text's size.
    pub(super) fn width(&self, bold: bool) -> f64 {
        let widths = if bold { &BOLD } else { &REGULAR };
        let width = |byte: &u8| widths.get(usize::from(*byte).wrapping_sub(32)).copied();
        // Most of what is not in the table is a letter or as wide as one.
        let thousandths = self.bytes.iter().map(|byte| width(byte).unwrap_or(565));
        self.size * thousandths.map(f64::from).sum::<f64>() / 1000.0
    }

    /// The letters as a string of PDF holds them.
    pub(super) fn escaped(&self) -> String {
        let escaped = |&byte: &u8| match byte {
            b'(' | b')' | b'\\' => format!("\\{}", char::from(byte)),
            b' '..=b'~' => char::from(byte).to_string(),
            _ => format!("\\{byte:03o}"),
        };
        self.bytes.iter().map(escaped).collect()
    }
}

/// Thousandths of the size of the letters from the space to the tilde (Adobe Core 14 font metrics).
#[rustfmt::skip]
const REGULAR: [u16; 95] = [
    278, 278, 355, 556, 556, 889, 667, 191, 333, 333, 389, 584, 278, 333, 278, 278, 556, 556, 556, 556, 556, 556, 556, 556,
    556, 556, 278, 278, 584, 584, 584, 556, 1015, 667, 667, 722, 722, 667, 611, 778, 722, 278, 500, 667, 556, 833, 722, 778,
    667, 778, 722, 667, 611, 722, 667, 944, 667, 667, 611, 278, 278, 278, 469, 556, 333, 556, 556, 500, 556, 556, 278, 556,
    556, 222, 222, 500, 222, 833, 556, 556, 556, 556, 333, 500, 278, 556, 500, 722, 500, 500, 500, 334, 260, 334, 584,
];

/// Thousandths of the size of the letters from the space to the tilde, bold (Adobe Core 14 font metrics).
#[rustfmt::skip]
const BOLD: [u16; 95] = [
    278, 333, 474, 556, 556, 889, 722, 238, 333, 333, 389, 584, 278, 333, 278, 278, 556, 556, 556, 556, 556, 556, 556, 556,
    556, 556, 333, 333, 584, 584, 584, 611, 975, 722, 722, 722, 722, 667, 611, 778, 722, 278, 556, 722, 611, 833, 722, 778,
    667, 778, 722, 667, 611, 722, 667, 944, 667, 667, 611, 333, 278, 333, 584, 556, 333, 556, 611, 556, 611, 556, 333, 611,
    611, 278, 278, 556, 278, 889, 611, 611, 611, 611, 389, 556, 333, 611, 556, 778, 556, 556, 500, 389, 280, 389, 584,
];
