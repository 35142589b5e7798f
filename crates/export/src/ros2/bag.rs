//! The file of a bag: topics, messages, and the facts that are beside it in a folder.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::Write;

use inhand_container::{MetadataRecord, Packing, Writer};

use super::cdr::Cdr;
use super::definitions::definition;
use crate::error::ExportError;

/// A fixed name: the same take gives the same bytes.
const LIBRARY: &str = concat!("inhand ", env!("CARGO_PKG_VERSION"));

/// Quality of service of topics whose last message holds on: reliable, transient local.
const LATCHED: &str = "- history: 1\n  depth: 1\n  reliability: 1\n  durability: 1\n  \
    deadline:\n    sec: 0\n    nsec: 0\n  lifespan:\n    sec: 0\n    nsec: 0\n  liveliness: 1\n  \
    liveliness_lease_duration:\n    sec: 0\n    nsec: 0\n  \
    avoid_ros_namespace_conventions: false\n";

/// Version of the facts beside a bag: that of Humble, which later ones read.
const YAML_VERSION: u32 = 5;

/// A bag that was written.
#[derive(Clone, Debug)]
pub struct Ros2Bag {
    topics: Vec<Topic>,
    /// Messages of all topics.
    pub messages: u64,
    /// Log times of the first and the last message, nanoseconds since 1970.
    span: (u64, u64),
}

#[derive(Clone, Debug)]
struct Topic {
    channel: u16,
    name: String,
    kind: String,
    qos: &'static str,
    messages: u32,
}

impl Ros2Bag {
    /// Number of topics.
    pub fn topics(&self) -> usize {
        self.topics.len()
    }

    /// The file `metadata.yaml` of a folder that holds the bag under this name.
    pub fn metadata_yaml(&self, file_name: &str) -> String {
        let (start, end) = self.span;
        let span = |indent: &str| {
            format!(
                "{indent}duration:\n{indent}  nanoseconds: {}\n{indent}starting_time:\n\
                 {indent}  nanoseconds_since_epoch: {start}\n{indent}message_count: {}\n",
                end - start,
                self.messages
            )
        };
        let file = format!("{file_name:?}");
        let mut yaml = format!(
            "rosbag2_bagfile_information:\n  version: {YAML_VERSION}\n  storage_identifier: mcap\n\
             {}  topics_with_message_count:\n",
            span("  ")
        );
        for topic in &self.topics {
            // Writing to a string cannot fail.
            let _ = write!(
                yaml,
                "    - topic_metadata:\n        name: {}\n        type: {}\n        \
                 serialization_format: cdr\n        offered_qos_profiles: {:?}\n      \
                 message_count: {}\n",
                topic.name, topic.kind, topic.qos, topic.messages
            );
        }
        yaml + "  compression_format: \"\"\n  compression_mode: \"\"\n  relative_file_paths:\n"
            + &format!(
                "    - {file}\n  files:\n    - path: {file}\n{}",
                span("      ")
            )
    }
}

/// A bag while it is written.
pub(super) struct BagWriter<'a> {
    writer: Writer<'a>,
    topics: Vec<Topic>,
}

impl<'a> BagWriter<'a> {
    pub(super) fn new(
        out: &'a mut dyn Write,
        records: &[MetadataRecord],
    ) -> Result<Self, ExportError> {
        let mut writer = Writer::new(out, "ros2", LIBRARY, Packing::Zstd)?;
        for record in records {
            writer.metadata(&record.name, &record.facts)?;
        }
        Ok(Self {
            writer,
            topics: Vec::new(),
        })
    }

    /// Adds a topic of a type such as `std_msgs/String` and returns its place.
    pub(super) fn topic(&mut self, name: &str, kind: &str) -> Result<usize, ExportError> {
        let qos = match name {
            "/tf_static" => LATCHED,
            _ => "",
        };
        let full_kind = kind.replacen('/', "/msg/", 1);
        let schema = (self.writer).schema(&full_kind, "ros2msg", definition(kind).as_bytes())?;
        let facts = BTreeMap::from([("offered_qos_profiles".to_owned(), qos.to_owned())]);
        self.topics.push(Topic {
            channel: self.writer.channel(schema, name, "cdr", &facts)?,
            name: name.to_owned(),
            kind: full_kind,
            qos,
            messages: 0,
        });
        Ok(self.topics.len() - 1)
    }

    pub(super) fn message(
        &mut self,
        topic: usize,
        unix_nanos: u64,
        encode: impl FnOnce(&mut Cdr<'_>),
    ) -> Result<(), ExportError> {
        let topic = &mut self.topics[topic];
        let written = (self.writer).message(topic.channel, topic.messages, unix_nanos, |data| {
            encode(&mut Cdr::new(data));
        });
        topic.messages += 1;
        Ok(written?)
    }

    pub(super) fn finish(self) -> Result<Ros2Bag, ExportError> {
        let written = self.writer.finish()?;
        Ok(Ros2Bag {
            topics: self.topics,
            messages: written.messages,
            span: written.span.unwrap_or_default(),
        })
    }
}
