//! The metadata records at the start of a file, without reading on.

use std::io::{self, Read};

use mcap::records::{Record, op};

use crate::metadata::Metadata;

/// Longest record that is read; one of a take with a thousand markers has some 100 KB.
const MAX_RECORD_BYTES: u64 = 64 << 20;

/// The metadata records before the first other record of an MCAP file, as
/// [`write_take`](crate::write_take) puts them. Bytes that are no MCAP file, or that are cut there, have none.
///
/// # Errors
///
/// Those of reading.
pub fn read_leading_metadata(mut file: impl Read) -> io::Result<Metadata> {
    let mut metadata = Metadata::default();
    let mut magic = Vec::new();
    file.by_ref()
        .take(mcap::MAGIC.len() as u64)
        .read_to_end(&mut magic)?;
    if magic != mcap::MAGIC {
        return Ok(metadata);
    }
    let mut body = Vec::new();
    loop {
        let mut prefix = [0; 9];
        match file.read_exact(&mut prefix) {
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => return Ok(metadata),
            result => result?,
        }
        let [opcode, length @ ..] = prefix;
        let length = u64::from_le_bytes(length);
        if !matches!(opcode, op::HEADER | op::METADATA) || length > MAX_RECORD_BYTES {
            return Ok(metadata);
        }
        body.clear();
        file.by_ref().take(length).read_to_end(&mut body)?;
        match mcap::parse_record(opcode, &body) {
            Ok(Record::Metadata(facts)) => {
                metadata.0.insert(facts.name, facts.metadata);
            }
            Ok(_) => {}
            Err(_) => return Ok(metadata),
        }
    }
}
