//! Messages of any kind into an MCAP file.

use std::collections::BTreeMap;
use std::io::Write;

use crate::container::Container;
use crate::error::ChannelError;
use crate::schema::Logged;

/// A fixed name: the same nouns give the same bytes.
const LIBRARY: &str = concat!("inhand ", env!("CARGO_PKG_VERSION"));

/// A channel of the file being written.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ChannelId(u16);

/// A file being written.
pub(crate) struct Output<'a> {
    container: Container<'a>,
}

impl<'a> Output<'a> {
    pub(crate) fn create(out: &'a mut dyn Write) -> Result<Self, ChannelError> {
        let container = Container::create(out, LIBRARY).map_err(ChannelError::write)?;
        Ok(Self { container })
    }

    pub(crate) fn metadata(
        &mut self,
        name: &str,
        facts: &BTreeMap<String, String>,
    ) -> Result<(), ChannelError> {
        (self.container.metadata(name, facts)).map_err(ChannelError::write)
    }

    /// A channel whose coordinates are in `frame`, if it has any.
    pub(crate) fn channel<M: Logged>(
        &mut self,
        topic: &str,
        frame: Option<&str>,
    ) -> Result<ChannelId, ChannelError> {
        let schema = M::schema();
        let metadata = (frame.iter())
            .map(|frame| ("frame".to_owned(), (*frame).to_owned()))
            .collect();
        (self.container)
            .channel(topic, &schema.name, &schema.descriptors, &metadata)
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
        // The format has 32 bits for the sequence; it only helps people who read a listing.
        (self.container)
            .message(channel.0, sequence as u32, unix_nanos, |buffer| {
                message.encode_raw(buffer);
            })
            .map_err(ChannelError::write)
    }

    pub(crate) fn finish(self) -> Result<(), ChannelError> {
        self.container.finish().map_err(ChannelError::write)
    }
}
