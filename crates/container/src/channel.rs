//! Channels and their schemas.

use std::collections::BTreeMap;

use mcap::records::Record;

/// The schema of a channel's messages.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SchemaFacts {
    /// Its name.
    pub name: String,
    /// How it is written, such as `protobuf`, `jsonschema`, `ros2msg`.
    pub encoding: String,
    /// The description itself.
    pub data: Vec<u8>,
}

/// A channel as its records describe it.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct ChannelFacts {
    /// Identifier in the file.
    pub id: u16,
    /// Topic.
    pub topic: String,
    /// `None` for a channel without one.
    pub schema: Option<SchemaFacts>,
    /// How messages are written, such as `protobuf`, `json`, `cdr`.
    pub message_encoding: String,
    /// What the writer says about the channel.
    pub metadata: BTreeMap<String, String>,
}

impl ChannelFacts {
    /// Name of its schema.
    pub fn schema_name(&self) -> Option<&str> {
        self.schema.as_ref().map(|schema| schema.name.as_str())
    }
}

/// Which messages of a channel hold beyond the instant at which they were sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Latch {
    /// The last one: each replaces the one before.
    Last,
    /// All of them, each adds to what was said before; of ones with equal content
    /// the latest counts.
    All,
}

/// Which messages of a channel hold on, by the conventions of ROS and Foxglove: all on a topic that
/// ends in `/tf_static`, and the last on a channel that its publisher declared transient local.
///
/// Where a cut starts later, these are moved to its start, since viewers would lack them otherwise.
pub fn latch(channel: &ChannelFacts) -> Option<Latch> {
    if channel.topic.rsplit('/').next() == Some("tf_static") {
        return Some(Latch::All);
    }
    // YAML, by number in older recorders and by name in newer ones.
    let qos = channel.metadata.get("offered_qos_profiles")?;
    let transient = qos.lines().any(|line| {
        let setting = line.trim_start_matches(['-', ' ']);
        let value = setting.strip_prefix("durability:").map(str::trim);
        matches!(value, Some("1" | "transient_local"))
    });
    transient.then_some(Latch::Last)
}

/// Schemas and channels of a file as far as they are known, the last of each id.
#[derive(Default)]
pub(crate) struct Definitions {
    pub(crate) schemas: BTreeMap<u16, SchemaFacts>,
    pub(crate) channels: BTreeMap<u16, ChannelFacts>,
}

impl Definitions {
    /// Learns a schema or a channel; gives a channel's id.
    pub(crate) fn add(&mut self, record: &Record<'_>) -> Option<u16> {
        match record {
            Record::Schema { header, data } => {
                let schema = SchemaFacts {
                    name: header.name.clone(),
                    encoding: header.encoding.clone(),
                    data: data.to_vec(),
                };
                self.schemas.insert(header.id, schema);
                None
            }
            Record::Channel(channel) => {
                let schema = self.schemas.get(&channel.schema_id);
                let facts = ChannelFacts {
                    id: channel.id,
                    topic: channel.topic.clone(),
                    schema: schema.cloned(),
                    message_encoding: channel.message_encoding.clone(),
                    metadata: channel.metadata.clone(),
                };
                self.channels.insert(channel.id, facts);
                Some(channel.id)
            }
            _ => None,
        }
    }
}
