//! The MCAP writer as this crate uses it.

use std::collections::BTreeMap;
use std::io::Write;

use inhand_container::{Packing, Writer};

use crate::error::ChannelError;
use crate::schema::Logged;

/// A fixed name: the same nouns give the same bytes.
const LIBRARY: &str = concat!("inhand ", env!("CARGO_PKG_VERSION"));

/// How chunks are packed where a file is kept and read as a whole.
pub(crate) const PACKED: Packing = Packing::Zstd;

/// A channel of the file being written.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ChannelId(u16);

/// A file being written.
pub(crate) struct Output<'a> {
    writer: Writer<&'a mut dyn Write>,
    rename: fn(&str) -> &str,
}

impl<'a> Output<'a> {
    pub(crate) fn create(out: &'a mut dyn Write, packing: Packing) -> Result<Self, ChannelError> {
        Ok(Self {
            writer: Writer::new(out, "", LIBRARY, packing)?,
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
        Ok(self.writer.metadata(name, facts)?)
    }

    /// A channel whose coordinates are in `frame`, if it has any.
    pub(crate) fn channel<M: Logged>(
        &mut self,
        topic: &str,
        frame: Option<&str>,
    ) -> Result<ChannelId, ChannelError> {
        let schema = M::schema();
        let schema_id = (self.writer).schema(&schema.name, "protobuf", &schema.descriptors)?;
        let metadata = (frame.iter())
            .map(|frame| ("frame".to_owned(), (*frame).to_owned()))
            .collect();
        let topic = (self.rename)(topic);
        let id = (self.writer).channel(schema_id, topic, "protobuf", &metadata)?;
        Ok(ChannelId(id))
    }

    /// Writes a message of the instant `unix_nanos`.
    pub(crate) fn message<M: Logged>(
        &mut self,
        channel: ChannelId,
        sequence: usize,
        unix_nanos: u64,
        message: &M,
    ) -> Result<(), ChannelError> {
        // The format has 32 bits for it; it only helps people who read a listing.
        let sequence = sequence as u32;
        let encode = |data: &mut Vec<u8>| message.encode_raw(data);
        Ok(self
            .writer
            .message(channel.0, sequence, unix_nanos, encode)?)
    }

    pub(crate) fn finish(self) -> Result<(), ChannelError> {
        self.writer.finish()?;
        Ok(())
    }
}
