//! The MCAP writer as this crate uses it.

use std::collections::BTreeMap;
use std::io::Write;

use inhand_container::ContainerError;
use mcap::records::MessageHeader;
use mcap::write::NoSeek;
use mcap::{Compression, WriteOptions, Writer};

use crate::error::ChannelError;
use crate::schema::Logged;

/// A fixed name: the same nouns give the same bytes, whatever version of mcap wrote them.
const LIBRARY: &str = concat!("inhand ", env!("CARGO_PKG_VERSION"));

/// Uncompressed size at which a chunk ends: what a viewer has to read to show one instant.
const CHUNK_BYTES: u64 = 1024 * 1024;

/// Level 1: higher ones take several times as long for a few per cent, since most bytes are
/// mantissas that no level can shrink.
const ZSTD_LEVEL: u32 = 1;

/// How chunks are packed where a file is kept and read as a whole.
pub(crate) const PACKED: Option<Compression> = Some(Compression::Zstd);

/// A channel of the file being written.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ChannelId(u16);

/// A file being written, with one buffer for all messages.
pub(crate) struct Output<'a> {
    writer: Writer<NoSeek<&'a mut dyn Write>>,
    buffer: Vec<u8>,
    rename: fn(&str) -> &str,
}

impl<'a> Output<'a> {
    /// A file that states what kind of content it has.
    pub(crate) fn create_of(
        out: &'a mut dyn Write,
        packing: Option<Compression>,
        profile: &str,
    ) -> Result<Self, ChannelError> {
        let writer = WriteOptions::new()
            .profile(profile)
            .library(LIBRARY)
            .compression(packing)
            .compression_level(ZSTD_LEVEL)
            // Takes are written side by side; a pool inside each would only get in the way.
            .compression_threads(0)
            .chunk_size(Some(CHUNK_BYTES))
            // Each chunk goes out whole, so that anything that takes bytes will do.
            .disable_seeking(true)
            .create(NoSeek::new(out))
            .map_err(ChannelError::write)?;
        Ok(Self {
            writer,
            buffer: Vec::with_capacity(64 * 1024),
            rename: |topic| topic,
        })
    }

    /// Gives channels that are added from now on other topics.
    pub(crate) fn rename_topics(&mut self, rename: fn(&str) -> &str) {
        self.rename = rename;
    }

    pub(crate) fn metadata(
        &mut self,
        name: &str,
        facts: &BTreeMap<String, String>,
    ) -> Result<(), ChannelError> {
        let metadata = mcap::records::Metadata {
            name: name.to_owned(),
            metadata: facts.clone(),
        };
        (self.writer.write_metadata(&metadata)).map_err(ChannelError::write)
    }

    /// A channel whose coordinates are in `frame`, if it has any.
    pub(crate) fn channel<M: Logged>(
        &mut self,
        topic: &str,
        frame: Option<&str>,
    ) -> Result<ChannelId, ChannelError> {
        let schema = M::schema();
        let schema_id = (self.writer)
            .add_schema(&schema.name, "protobuf", &schema.descriptors)
            .map_err(ChannelError::write)?;
        let metadata = (frame.iter())
            .map(|frame| ("frame".to_owned(), (*frame).to_owned()))
            .collect();
        (self.writer)
            .add_channel(schema_id, (self.rename)(topic), "protobuf", &metadata)
            .map(ChannelId)
            .map_err(ChannelError::write)
    }

    /// Writes a message of the instant `unix_nanos`.
    pub(crate) fn message<M: Logged>(
        &mut self,
        channel: ChannelId,
        sequence: usize,
        unix_nanos: u64,
        message: &M,
    ) -> Result<(), ChannelError> {
        self.buffer.clear();
        message.encode_raw(&mut self.buffer);
        let header = MessageHeader {
            channel_id: channel.0,
            // The format has 32 bits for it; it only helps people who read a listing.
            sequence: sequence as u32,
            log_time: unix_nanos,
            // A sample is published when it is taken.
            publish_time: unix_nanos,
        };
        (self.writer)
            .write_to_known_channel(&header, &self.buffer)
            .map_err(ChannelError::write)
    }

    pub(crate) fn finish(mut self) -> Result<(), ChannelError> {
        self.writer.finish().map_err(ChannelError::write)?;
        let mut out = self.writer.into_inner();
        Ok(out
            .flush()
            .map_err(|source| ContainerError::Write { source })?)
    }
}
