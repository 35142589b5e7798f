//! The records of a sound file in place: nothing is copied, nothing is unpacked.

use mcap::parse_record;
use mcap::records::{Record, op};

use super::fault::PREFIX_BYTES;

/// Bytes of a footer's body that the checksum of the summary covers: where the summary and its
/// offsets start.
const FOOTER_COVERED_BYTES: usize = 16;

/// Calls `visit` for the schemas, channels, messages, chunks (before what they hold) and metadata of
/// the file, in the order in which they lie there. Only chunks that are not packed are looked into.
///
/// `None` for files that have to be looked at more closely by [`walk`](super::walk), which says what
/// is wrong with one: those without a checksum over all their data or whose checksums differ, and
/// whatever does not parse.
pub(crate) fn walk_in_place<'a>(bytes: &'a [u8], mut visit: impl FnMut(Record<'a>)) -> Option<()> {
    let body = (bytes.strip_prefix(mcap::MAGIC)?).strip_suffix(mcap::MAGIC)?;
    let data_end = check_sums(bytes, body)?;
    for record in Records(&body[..data_end]) {
        let (opcode, body) = record?;
        match opcode {
            op::CHUNK => {
                let record = parse_record(opcode, body).ok()?;
                let Record::Chunk { header, data } = &record else {
                    return None;
                };
                // Without a packing the data lies at the end of the record as it is.
                let data = (header.compression.is_empty())
                    .then(|| body.split_at_checked(body.len().checked_sub(data.len())?))
                    .map(|split| split.map(|(_, data)| data));
                visit(record);
                for record in Records(data.flatten().unwrap_or_default()) {
                    let (opcode, body) = record?;
                    if matches!(opcode, op::SCHEMA | op::CHANNEL | op::MESSAGE) {
                        visit(parse_record(opcode, body).ok()?);
                    }
                }
            }
            op::SCHEMA | op::CHANNEL | op::MESSAGE | op::METADATA => {
                visit(parse_record(opcode, body).ok()?);
            }
            _ => {}
        }
    }
    Some(())
}

/// Where the record that ends the data starts behind the magic bytes, if the data and the summary
/// have the checksums that the file states, and it states one of the data.
fn check_sums(bytes: &[u8], body: &[u8]) -> Option<usize> {
    let mut start = 0;
    let mut data_end = None;
    for record in Records(body) {
        let (opcode, fields) = record?;
        let next = start + PREFIX_BYTES + fields.len();
        match (opcode, parse_of_interest(opcode, fields)) {
            (op::DATA_END, Some(Record::DataEnd(end))) => {
                let covered = &bytes[..mcap::MAGIC.len() + start];
                if end.data_section_crc == 0 || end.data_section_crc != crc32fast::hash(covered) {
                    return None;
                }
                data_end = Some((start, next));
            }
            (op::FOOTER, Some(Record::Footer(footer))) => {
                let (end, summary_start) = data_end?;
                let covered = &body[summary_start..];
                let covered =
                    covered.get(..start - summary_start + PREFIX_BYTES + FOOTER_COVERED_BYTES)?;
                let sound =
                    footer.summary_crc == 0 || footer.summary_crc == crc32fast::hash(covered);
                return (sound && next == body.len()).then_some(end);
            }
            _ => {}
        }
        start = next;
    }
    None
}

fn parse_of_interest(opcode: u8, fields: &[u8]) -> Option<Record<'_>> {
    match opcode {
        op::DATA_END | op::FOOTER => parse_record(opcode, fields).ok(),
        _ => None,
    }
}

/// Opcodes and bodies of the records that follow each other in these bytes; ends after `None`, where
/// one does not fit.
struct Records<'a>(&'a [u8]);

impl<'a> Iterator for Records<'a> {
    type Item = Option<(u8, &'a [u8])>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.0.is_empty() {
            return None;
        }
        let record = self.split();
        if record.is_none() {
            self.0 = &[];
        }
        Some(record)
    }
}

impl<'a> Records<'a> {
    fn split(&mut self) -> Option<(u8, &'a [u8])> {
        let (&[opcode, ref length @ ..], rest) = self.0.split_first_chunk::<PREFIX_BYTES>()?;
        let length = usize::try_from(u64::from_le_bytes(*length)).ok()?;
        let (body, rest) = rest.split_at_checked(length)?;
        self.0 = rest;
        Some((opcode, body))
    }
}
