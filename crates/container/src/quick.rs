//! The records of a sound file in place: nothing is copied, nothing is unpacked.

use mcap::records::{Record, op};

use crate::fields::parse_record;
use crate::format::{FOOTER_COVERED_BYTES, PREFIX_BYTES, Records};

/// Calls `visit` for the schemas, channels, messages, chunks (before what they hold) and metadata of
/// the file, in the order in which they lie there. Only chunks that are not packed are looked into.
///
/// `None` for files that have to be looked at more closely by [`walk`](crate::walk), which says what
/// is wrong with one: those without a checksum over all their data or whose checksums differ, and
/// whatever does not parse.
pub fn walk_in_place<'a>(bytes: &'a [u8], mut visit: impl FnMut(Record<'a>)) -> Option<()> {
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
