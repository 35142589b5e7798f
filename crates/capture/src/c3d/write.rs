//! Markers as C3D.

use std::io::{self, Write};

use inhand_model::{Recording, UpAxis};

use super::{BLOCK_BYTES, KEY};
use crate::error::CaptureError;

/// Points at most: what a word can count.
const MAX_POINTS: usize = 65535;
/// Blocks of parameters at most: what a byte can count.
const MAX_PARAMETER_BLOCKS: usize = 255;
/// Texts of an array at most: what a byte can count.
const MAX_TEXTS: usize = 255;
/// Bytes of an array at most, so that the way to the next parameter is a positive word.
const MAX_ARRAY_BYTES: usize = 32_000;
/// Intel, as a file names it.
const INTEL: u8 = 84;
/// The block of the parameters.
const PARAMETER_BLOCK: u8 = 2;

/// Writes the markers of a recording as C3D: Intel, floating point, millimetres, residual -1 where a
/// sample is missing.
///
/// Coordinates keep the seven digits of single precision. What the format cannot hold is lost:
/// bodies, qualities, the mark on filled samples, the start time, findings.
///
/// `out` should be buffered.
///
/// # Errors
///
/// [`CaptureError::Output`] where `out` fails, or for more markers than the format can count.
pub fn write(recording: &Recording, out: &mut dyn Write) -> Result<(), CaptureError> {
    write_all(recording, out).map_err(|source| CaptureError::Output {
        format: "C3D",
        source,
    })
}

fn write_all(recording: &Recording, out: &mut dyn Write) -> io::Result<()> {
    let points = recording.markers.len();
    if points > MAX_POINTS {
        return Err(too_large("markers", MAX_POINTS, points));
    }
    // Their length does not depend on where the data starts, which one of them says.
    let blocks = (parameters(recording, 0).len() + 4).div_ceil(BLOCK_BYTES);
    if blocks > MAX_PARAMETER_BLOCKS {
        let [most, found] = [MAX_PARAMETER_BLOCKS, blocks].map(|blocks| blocks * BLOCK_BYTES);
        return Err(too_large("bytes of marker names", most, found));
    }
    let data_block = u16::from(PARAMETER_BLOCK) + blocks as u16;
    let mut head = header(recording, data_block);
    // Reserved, reserved, blocks, processor.
    head.extend([1, KEY, blocks as u8, INTEL]);
    head.extend(parameters(recording, data_block));
    head.resize((1 + blocks) * BLOCK_BYTES, 0);
    out.write_all(&head)?;
    for k in 0..recording.len() {
        for marker in &recording.markers {
            let numbers = match marker.track.get(k) {
                Some(position) => {
                    let [x, y, z] = position.to_array().map(|c| (c * 1000.0) as f32);
                    [x, y, z, 0.0]
                }
                None => [0.0, 0.0, 0.0, -1.0],
            };
            for number in numbers {
                out.write_all(&number.to_le_bytes())?;
            }
        }
    }
    // Files end with a whole block.
    let data = recording.len() * points * 16;
    out.write_all(&vec![0; data.next_multiple_of(BLOCK_BYTES) - data])?;
    out.flush()
}

fn too_large(what: &str, most: usize, found: usize) -> io::Error {
    io::Error::other(format!(
        "it holds at most {most} {what}, the recording has {found}: write another format"
    ))
}

/// A count as a word; one that does not fit is full.
fn word(count: usize) -> u16 {
    u16::try_from(count).unwrap_or(u16::MAX)
}

/// The first block.
fn header(recording: &Recording, data_block: u16) -> Vec<u8> {
    let mut block = vec![PARAMETER_BLOCK, KEY];
    let words = [
        word(recording.markers.len()),
        0,
        1,
        word(recording.len()),
        // The longest gap that was filled.
        0,
    ];
    block.extend(words.iter().flat_map(|word| word.to_le_bytes()));
    block.extend((-1.0_f32).to_le_bytes());
    block.extend(data_block.to_le_bytes());
    block.extend(0_u16.to_le_bytes());
    block.extend((recording.clock.rate_hz() as f32).to_le_bytes());
    block.resize(BLOCK_BYTES, 0);
    block
}

/// A parameter's content.
enum Content<'a> {
    Word(u16),
    /// A count in two words, the less significant one first.
    Long(u32),
    Real(f32),
    /// No values of a type.
    Empty(i8),
    Text(&'a str),
    Texts(&'a [&'a str]),
}

fn parameters(recording: &Recording, data_block: u16) -> Vec<u8> {
    let names: Vec<&str> = recording.markers.iter().map(|m| m.name.as_str()).collect();
    let (x_screen, y_screen) = match recording.source.up_axis {
        UpAxis::Y => ("+X", "+Y"),
        UpAxis::Z => ("+X", "+Z"),
    };
    let frames = recording.len();
    let mut bytes = Vec::new();
    let mut group = Group::start(&mut bytes, 1, "POINT");
    group.add("USED", &Content::Word(word(names.len())));
    group.add("SCALE", &Content::Real(-1.0));
    group.add("RATE", &Content::Real(recording.clock.rate_hz() as f32));
    group.add("DATA_START", &Content::Word(data_block));
    group.add("FRAMES", &Content::Word(word(frames)));
    group.add("UNITS", &Content::Text("mm"));
    group.add("X_SCREEN", &Content::Text(x_screen));
    group.add("Y_SCREEN", &Content::Text(y_screen));
    group.add_texts("LABELS", &names);
    group.add_texts("DESCRIPTIONS", &vec![""; names.len()]);
    let mut group = Group::start(&mut bytes, 2, "ANALOG");
    group.add("USED", &Content::Word(0));
    group.add("LABELS", &Content::Texts(&[]));
    group.add("DESCRIPTIONS", &Content::Texts(&[]));
    group.add("GEN_SCALE", &Content::Real(1.0));
    group.add("SCALE", &Content::Empty(4));
    group.add("OFFSET", &Content::Empty(2));
    group.add("UNITS", &Content::Texts(&[]));
    group.add("RATE", &Content::Real(recording.clock.rate_hz() as f32));
    let mut group = Group::start(&mut bytes, 3, "FORCE_PLATFORM");
    group.add("USED", &Content::Word(0));
    let mut group = Group::start(&mut bytes, 4, "TRIAL");
    group.add("ACTUAL_START_FIELD", &Content::Long(1));
    let last = u32::try_from(frames).unwrap_or(u32::MAX);
    group.add("ACTUAL_END_FIELD", &Content::Long(last));
    let mut group = Group::start(&mut bytes, 5, "MANUFACTURER");
    group.add("SOFTWARE", &Content::Text("inhand"));
    // The record behind the last one has no name.
    bytes.extend([0, 0]);
    bytes
}

/// A group while its parameters are added.
struct Group<'a> {
    bytes: &'a mut Vec<u8>,
    number: u8,
}

impl<'a> Group<'a> {
    fn start(bytes: &'a mut Vec<u8>, number: u8, name: &str) -> Self {
        bytes.push(name.len() as u8);
        bytes.push(number.wrapping_neg());
        bytes.extend(name.as_bytes());
        // To the next record: this word and the length of no description.
        bytes.extend([3, 0, 0]);
        Self { bytes, number }
    }

    fn add(&mut self, name: &str, content: &Content<'_>) {
        let (kind, sizes, values): (i8, Vec<u8>, Vec<u8>) = match content {
            Content::Word(word) => (2, vec![], word.to_le_bytes().to_vec()),
            // Two words, least significant first, are the bytes of one number.
            Content::Long(count) => (2, vec![2], count.to_le_bytes().to_vec()),
            Content::Real(real) => (4, vec![], real.to_le_bytes().to_vec()),
            Content::Empty(kind) => (*kind, vec![0], vec![]),
            Content::Text(text) => (-1, vec![text.len() as u8], text.as_bytes().to_vec()),
            Content::Texts(texts) => {
                let length = text_bytes(texts);
                let filled = texts.iter().flat_map(|text| {
                    let fill = length.saturating_sub(text.len());
                    text.bytes().chain(std::iter::repeat_n(b' ', fill))
                });
                (-1, vec![length as u8, texts.len() as u8], filled.collect())
            }
        };
        self.bytes.push(name.len() as u8);
        self.bytes.push(self.number);
        self.bytes.extend(name.as_bytes());
        // To the next record: this word, type, dimensions, values, the length of no description.
        let way = 2 + 2 + sizes.len() + values.len() + 1;
        self.bytes.extend((way as u16).to_le_bytes());
        self.bytes.extend(kind.to_le_bytes());
        self.bytes.push(sizes.len() as u8);
        self.bytes.extend(sizes);
        self.bytes.extend(values);
        self.bytes.push(0);
    }

    /// Texts in as many parameters as it takes: `LABELS`, `LABELS2`, ...
    fn add_texts(&mut self, name: &str, texts: &[&str]) {
        let texts: Vec<&str> = texts.iter().map(|text| shortened(text)).collect();
        let each = text_bytes(&texts).max(1);
        let chunks = texts.chunks(MAX_TEXTS.min(MAX_ARRAY_BYTES / each).max(1));
        if texts.is_empty() {
            self.add(name, &Content::Texts(&[]));
        }
        for (k, chunk) in chunks.enumerate() {
            let name = match k {
                0 => name.to_owned(),
                _ => format!("{name}{}", k + 1),
            };
            self.add(&name, &Content::Texts(chunk));
        }
    }
}

/// Bytes of the longest text.
fn text_bytes(texts: &[&str]) -> usize {
    texts.iter().map(|text| text.len()).max().unwrap_or(0)
}

/// As much of a text as a byte can count.
fn shortened(text: &str) -> &str {
    let mut end = text.len().min(MAX_TEXTS);
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    &text[..end]
}
