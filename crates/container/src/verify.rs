//! Whether a file that was written reads back.

use std::io::{Read, Seek};

use mcap::records::Record;

use crate::error::ContainerError;
use crate::index::Written;
use crate::source::Source;
use crate::walk::{Depth, walk_source};

/// Reads a whole file, compares every checksum and counts, and compares with what was written.
///
/// # Errors
///
/// What reading can find, and [`ContainerError::Verification`] for another count.
pub fn verify<R: Read + Seek>(
    source: &mut Source<R>,
    written: &Written,
) -> Result<(), ContainerError> {
    source.rewind()?;
    let mut found = Written {
        bytes: source.bytes(),
        ..Written::default()
    };
    walk_source(source, |record| -> Result<Depth, ContainerError> {
        match record {
            Record::Message { header, .. } => {
                found.messages += 1;
                let of_channel = found.messages_by_channel.entry(header.channel_id);
                *of_channel.or_default() += 1;
            }
            Record::Chunk { .. } => found.chunks += 1,
            Record::Attachment { .. } => found.attachments += 1,
            Record::Metadata(_) => found.metadata += 1,
            _ => {}
        }
        Ok(Depth::Everything)
    })?;
    let counts = [
        ("bytes", written.bytes, found.bytes),
        ("messages", written.messages, found.messages),
        ("chunks", written.chunks, found.chunks),
        ("attachments", written.attachments, found.attachments),
        ("metadata records", written.metadata, found.metadata),
    ];
    for (what, expected, found) in counts {
        if expected != found {
            return Err(ContainerError::Verification {
                what: what.to_owned(),
                expected,
                found,
            });
        }
    }
    for (channel, &expected) in &written.messages_by_channel {
        let found = found.messages_by_channel.get(channel).copied();
        if found != Some(expected) {
            return Err(ContainerError::Verification {
                what: format!("messages of channel {channel}"),
                expected,
                found: found.unwrap_or_default(),
            });
        }
    }
    Ok(())
}
