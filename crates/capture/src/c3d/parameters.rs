//! The header block and the parameters.

use std::collections::BTreeMap;

use super::number::Processor;
use super::{BLOCK_BYTES, KEY, damaged};
use crate::error::CaptureError;

/// Deepest array of a parameter.
const MAX_DIMENSIONS: usize = 7;

/// Numbers of the first block.
pub(super) struct Header {
    pub(super) points: u16,
    pub(super) analog_per_frame: u16,
    pub(super) first_frame: u16,
    pub(super) last_frame: u16,
    pub(super) scale: f32,
    pub(super) data_block: u16,
    pub(super) analog_samples: u16,
    pub(super) rate_hz: f32,
}

impl Header {
    /// Number of the first frame. A word holds a negative one as a number behind the last frame.
    pub(super) fn first_frame(&self) -> i64 {
        match self.first_frame > self.last_frame.saturating_add(1) {
            true => self.first_frame.cast_signed().into(),
            false => self.first_frame.into(),
        }
    }

    /// Frames from the first to the last.
    pub(super) fn frames(&self) -> u64 {
        let frames = i64::from(self.last_frame) + 1 - self.first_frame();
        u64::try_from(frames).unwrap_or(0)
    }
}

/// A parameter's values.
enum Values {
    Texts(Vec<String>),
    Bytes(Vec<i8>),
    Integers(Vec<i16>),
    Reals(Vec<f32>),
}

/// Values and the byte where they are described, by group and name.
type ByName = BTreeMap<(String, String), (usize, Values)>;

/// Header and parameters of a file.
pub(super) struct Parameters {
    pub(super) processor: Processor,
    pub(super) header: Header,
    /// By group and name, upper case.
    values: ByName,
}

/// Reads bytes of a file one after the other.
struct ByteReader<'a> {
    file: &'a str,
    bytes: &'a [u8],
    at: usize,
}

impl<'a> ByteReader<'a> {
    fn take(&mut self, length: usize) -> Result<&'a [u8], CaptureError> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let Some((taken, _)) = rest.split_at_checked(length) else {
            let expected = format_args!("{length} bytes of a parameter");
            let found = format_args!("{} bytes to the end of the file", rest.len());
            return Err(damaged(self.file, self.at, expected, found));
        };
        self.at += length;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], CaptureError> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(N)?);
        Ok(array)
    }

    fn i8(&mut self) -> Result<i8, CaptureError> {
        Ok(i8::from_le_bytes(self.array()?))
    }
}

impl Parameters {
    /// Reads them from the beginning of a file.
    pub(super) fn read(bytes: &[u8], file: &str) -> Result<Self, CaptureError> {
        let &[block @ 1..=u8::MAX, KEY, ..] = bytes else {
            let expected = "the number of a block and the key 0x50";
            return Err(damaged(
                file,
                0,
                expected,
                format_args!("{} other bytes", bytes.len()),
            ));
        };
        let start = (usize::from(block) - 1) * BLOCK_BYTES;
        let mut reader = ByteReader {
            file,
            bytes,
            at: start,
        };
        let [_, _, _, code] = reader.array()?;
        let Some(processor) = Processor::from_code(code) else {
            let expected = "the processor: 84 (Intel), 85 (DEC) or 86 (MIPS)";
            return Err(damaged(file, start + 3, expected, code));
        };
        let header = header(bytes, processor, file)?;
        Ok(Self {
            processor,
            header,
            values: values(&mut reader, processor)?,
        })
    }

    fn get(&self, group: &str, name: &str) -> Option<&Values> {
        let (_, values) = self.values.get(&(group.to_owned(), name.to_owned()))?;
        Some(values)
    }

    /// A number, the first of an array; integers without their sign, as counts beyond 32767 are
    /// stored.
    pub(super) fn number(&self, group: &str, name: &str) -> Option<f64> {
        match self.get(group, name)? {
            Values::Texts(_) => None,
            Values::Bytes(values) => values.first().map(|&v| f64::from(v.cast_unsigned())),
            Values::Integers(values) => values.first().map(|&v| f64::from(v.cast_unsigned())),
            Values::Reals(values) => values.first().map(|&v| f64::from(v)),
        }
    }

    /// A count of `most` at most, in one number of any type. Parameters of floating point can say
    /// anything, and what no file can mean is refused before anything is computed with it.
    pub(super) fn count(
        &self,
        file: &str,
        (group, name): (&str, &str),
        most: u32,
    ) -> Result<Option<u64>, CaptureError> {
        let Some(number) = self.number(group, name) else {
            return Ok(None);
        };
        // No comparison holds for a number that is none.
        if (0.0..=f64::from(most)).contains(&number) {
            return Ok(Some(number as u64));
        }
        let place = self.values.get(&(group.to_owned(), name.to_owned()));
        let expected = format_args!("a count from 0 to {most} as {group}:{name}");
        let found = format_args!("{number}: export the file again, or correct the parameter");
        Err(damaged(
            file,
            place.map_or(0, |(at, _)| *at),
            expected,
            found,
        ))
    }

    /// A count in two words, the less significant one first, or in one number.
    pub(super) fn long(
        &self,
        file: &str,
        (group, name): (&str, &str),
    ) -> Result<Option<u64>, CaptureError> {
        match self.get(group, name) {
            Some(Values::Integers(words)) if words.len() >= 2 => {
                let [low, high] = [words[0], words[1]].map(|word| u64::from(word.cast_unsigned()));
                Ok(Some(high << 16 | low))
            }
            _ => self.count(file, (group, name), u32::MAX),
        }
    }

    /// The first text.
    pub(super) fn text(&self, group: &str, name: &str) -> Option<&str> {
        match self.get(group, name)? {
            Values::Texts(texts) => texts.first().map(String::as_str),
            _ => None,
        }
    }

    /// All floating-point numbers of a parameter and of those that go on where it had to end.
    pub(super) fn reals(&self, group: &str, name: &str) -> Vec<f32> {
        let parts = self.continued(group, name);
        let reals = parts.filter_map(|values| match values {
            Values::Reals(reals) => Some(reals),
            _ => None,
        });
        reals.flatten().copied().collect()
    }

    /// All texts of a parameter and of those that go on where it had to end: `LABELS`, `LABELS2`,
    /// `LABELS3`, ...
    pub(super) fn texts(&self, group: &str, name: &str) -> Vec<String> {
        let parts = self.continued(group, name);
        let texts = parts.filter_map(|values| match values {
            Values::Texts(texts) => Some(texts),
            _ => None,
        });
        texts.flatten().cloned().collect()
    }

    /// A parameter, then those with 2, 3, ... behind its name, as long as there are any.
    fn continued<'a>(&'a self, group: &'a str, name: &'a str) -> impl Iterator<Item = &'a Values> {
        let further = (2..).map(move |number| format!("{name}{number}"));
        let names = std::iter::once(name.to_owned()).chain(further);
        names.map_while(move |name| self.get(group, &name))
    }

    /// Texts and single numbers by `GROUP:NAME`, but for the lists of names.
    pub(super) fn facts(&self) -> BTreeMap<String, String> {
        let single = |((group, name), (_, values)): (&(String, String), &(usize, Values))| {
            let text = match values {
                Values::Texts(texts) => match &texts[..] {
                    [text] if !text.is_empty() => text.clone(),
                    _ => return None,
                },
                Values::Bytes(values) => one(values)?.to_string(),
                Values::Integers(values) => one(values)?.cast_unsigned().to_string(),
                Values::Reals(values) => one(values)?.to_string(),
            };
            Some((format!("{group}:{name}"), text))
        };
        self.values.iter().filter_map(single).collect()
    }
}

fn one<T: Copy>(values: &[T]) -> Option<T> {
    match values {
        [value] => Some(*value),
        _ => None,
    }
}

fn header(bytes: &[u8], processor: Processor, file: &str) -> Result<Header, CaptureError> {
    let Some(block) = bytes.get(..BLOCK_BYTES) else {
        let expected = format_args!("a header of {BLOCK_BYTES} bytes");
        return Err(damaged(
            file,
            0,
            expected,
            format_args!("{} bytes", bytes.len()),
        ));
    };
    // Words count from 1, as in the description of the format.
    let word = |number: usize| processor.u16([block[2 * number - 2], block[2 * number - 1]]);
    let real = |number: usize| {
        let at = 2 * number - 2;
        processor.f32([block[at], block[at + 1], block[at + 2], block[at + 3]])
    };
    Ok(Header {
        points: word(2),
        analog_per_frame: word(3),
        first_frame: word(4),
        last_frame: word(5),
        scale: real(7),
        data_block: word(9),
        analog_samples: word(10),
        rate_hz: real(11),
    })
}

/// Parameters by group and name. Records lie one after the other: length of the name, number of the
/// group (negative for the record of a group itself), name, way to the next record, content.
fn values(reader: &mut ByteReader<'_>, processor: Processor) -> Result<ByName, CaptureError> {
    let mut groups: BTreeMap<i8, String> = BTreeMap::new();
    let mut parameters: Vec<(i8, String, (usize, Values))> = Vec::new();
    // A file may end with its parameters, or fill the rest of their blocks with zeros.
    while reader.at < reader.bytes.len() {
        let name_length = usize::from(reader.i8()?.unsigned_abs());
        if name_length == 0 {
            break;
        }
        let group = reader.i8()?;
        let name = String::from_utf8_lossy(reader.take(name_length)?)
            .trim()
            .to_uppercase();
        let way_from = reader.at;
        let way = processor.u16(reader.array()?);
        if group < 0 {
            groups.insert(group, name);
        } else {
            let values = (reader.at, content(reader, processor, &name)?);
            parameters.push((group, name, values));
        }
        if way == 0 {
            break;
        }
        let next = way_from + usize::from(way);
        if next < way_from + 2 {
            return Err(damaged(
                reader.file,
                way_from,
                "the way to the next parameter",
                way,
            ));
        }
        reader.at = next;
    }
    let named = parameters.into_iter().filter_map(|(group, name, values)| {
        let group = groups.get(&group.checked_neg()?)?;
        Some(((group.clone(), name), values))
    });
    Ok(named.collect())
}

fn content(
    reader: &mut ByteReader<'_>,
    processor: Processor,
    name: &str,
) -> Result<Values, CaptureError> {
    let at = reader.at;
    let kind = reader.i8()?;
    let dimensions = usize::from(reader.i8()?.unsigned_abs());
    if dimensions > MAX_DIMENSIONS {
        let expected = format_args!("at most {MAX_DIMENSIONS} dimensions of parameter {name}");
        return Err(damaged(reader.file, at + 1, expected, dimensions));
    }
    let sizes = reader.take(dimensions)?;
    let width = match kind {
        -1 | 1 => 1,
        2 => 2,
        4 => 4,
        _ => {
            let expected = format_args!("the type of parameter {name}: -1, 1, 2 or 4");
            return Err(damaged(reader.file, at, expected, kind));
        }
    };
    // At most 4 * 255^7, which a usize of 64 bits holds; the bytes have to be there anyway.
    let bytes = (sizes.iter()).fold(width, |all: usize, &n| all.saturating_mul(n.into()));
    let content = reader.take(bytes)?;
    Ok(match kind {
        -1 => {
            let length = sizes.first().copied().unwrap_or(1).max(1);
            Values::Texts(content.chunks(length.into()).map(text).collect())
        }
        1 => Values::Bytes(content.iter().map(|b| b.cast_signed()).collect()),
        2 => {
            let words = content.chunks_exact(2);
            Values::Integers(words.map(|b| processor.i16([b[0], b[1]])).collect())
        }
        _ => {
            let words = content.chunks_exact(4);
            let real = |b: &[u8]| processor.f32([b[0], b[1], b[2], b[3]]);
            Values::Reals(words.map(real).collect())
        }
    })
}

/// A text of fixed length, filled up with blanks or NUL.
fn text(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(bytes);
    text.trim_matches(|c: char| c.is_whitespace() || c == '\0')
        .to_owned()
}
