//! Checks that a written file reads back.

use mcap::records::Record;

use crate::error::ContainerError;
use crate::source::Source;
use crate::walk::{Depth, walk_source};
use crate::writer::Written;

/// Reads a whole file, compares every checksum and counts, and compares with what was written.
///
/// # Errors
///
/// What reading can find, and [`ContainerError::Verification`] for another count.
pub fn verify(source: &mut Source<'_>, written: &Written) -> Result<(), ContainerError> {
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
            Record::AttachmentIndex(_) => found.attachments += 1,
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
    ]
    .map(|(what, expected, found)| (what.to_owned(), expected, found));
    let by_channel = (written.messages_by_channel.iter()).map(|(channel, &expected)| {
        let found = found.messages_by_channel.get(channel).copied();
        let what = format!("messages of channel {channel}");
        (what, expected, found.unwrap_or_default())
    });
    let mut counts = counts.into_iter().chain(by_channel);
    match counts.find(|(_, expected, found)| expected != found) {
        None => Ok(()),
        Some((what, expected, found)) => Err(ContainerError::Verification {
            what,
            expected,
            found,
        }),
    }
}
