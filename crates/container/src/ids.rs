//! Ids of schemas and channels of several files in one.

use std::collections::{BTreeMap, BTreeSet};

use mcap::records::Record;

use crate::error::{ContainerError, Place};
use crate::format::set_id;

/// The ids that schemas and channels of files get in a common file.
///
/// Equal ones of different files become one; those of one file stay apart. Ids are kept where they are
/// free. An id that a file uses again with other content is another one from there on.
pub(crate) struct Ids {
    /// Whether channels of one topic with different schemas or encodings may lie side by side.
    keep_both: bool,
    /// By name, encoding and data.
    schemas: Taken<(String, String, Vec<u8>)>,
    /// By topic, new id of the schema, encoding and metadata.
    channels: Taken<(String, u16, String, BTreeMap<String, String>)>,
    /// Schema id and encoding of the first channel of each topic, with its file's name.
    topics: BTreeMap<String, (u16, String, String)>,
    /// Topics with several channels of different schemas or encodings.
    pub(crate) side_by_side: BTreeSet<String>,
}

/// The ids that are taken, and what for.
struct Taken<K> {
    ids: BTreeMap<K, Equal>,
    taken: BTreeSet<u16>,
    first: u16,
    /// New ids by file and old id, as last defined.
    of_file: BTreeMap<(usize, u16), u16>,
}

/// Schemas or channels of equal content.
#[derive(Default)]
struct Equal {
    ids: Vec<u16>,
    /// How many of them each file has.
    of_each: BTreeMap<usize, usize>,
    /// New ids by file and old id.
    of_file: BTreeMap<(usize, u16), u16>,
}

impl<K: Ord> Taken<K> {
    fn starting_at(first: u16) -> Self {
        Self {
            ids: BTreeMap::new(),
            taken: BTreeSet::new(),
            first,
            of_file: BTreeMap::new(),
        }
    }

    /// The new id of a file's schema or channel; `None` where there is none left.
    fn id(&mut self, file: usize, old: u16, content: K) -> Option<u16> {
        let equal = self.ids.entry(content).or_default();
        let id = match equal.of_file.get(&(file, old)) {
            Some(id) => *id,
            None => {
                let of_this = equal.of_each.entry(file).or_default();
                let id = match equal.ids.get(*of_this) {
                    Some(id) => *id,
                    None => {
                        let is_free = |id: &u16| *id >= self.first && !self.taken.contains(id);
                        let id = Some(old).filter(is_free);
                        let id = id.or_else(|| (self.first..=u16::MAX).find(is_free))?;
                        self.taken.insert(id);
                        equal.ids.push(id);
                        id
                    }
                };
                *of_this += 1;
                equal.of_file.insert((file, old), id);
                id
            }
        };
        self.of_file.insert((file, old), id);
        Some(id)
    }
}

impl Ids {
    pub(crate) fn new(keep_both: bool) -> Self {
        Self {
            keep_both,
            schemas: Taken::starting_at(1),
            channels: Taken::starting_at(0),
            topics: BTreeMap::new(),
            side_by_side: BTreeSet::new(),
        }
    }

    /// The new id of a file's channel.
    pub(crate) fn channel(&self, file: usize, old: u16) -> Option<u16> {
        self.channels.of_file.get(&(file, old)).copied()
    }

    /// The new id of a file's schema.
    pub(crate) fn schema(&self, file: usize, old: u16) -> Option<u16> {
        self.schemas.of_file.get(&(file, old)).copied()
    }

    /// The topic of the channel with this new id.
    pub(crate) fn topic(&self, new: u16) -> Option<&str> {
        let mut known = self.channels.ids.iter();
        known
            .find(|(_, equal)| equal.ids.contains(&new))
            .map(|((topic, ..), _)| topic.as_str())
    }

    /// Learns a schema or channel of a file; its new id, `None` for other records.
    pub(crate) fn learn(
        &mut self,
        file: usize,
        place: Place<'_>,
        record: &Record<'_>,
    ) -> Result<Option<u16>, ContainerError> {
        let id = match record {
            Record::Schema { header, data } => {
                let content = (header.name.clone(), header.encoding.clone(), data.to_vec());
                self.schemas.id(file, header.id, content)
            }
            Record::Channel(channel) => {
                let schema = match channel.schema_id {
                    0 => 0,
                    id => *(self.schemas.of_file.get(&(file, id))).ok_or_else(|| {
                        let expected = format!("schema {id} of topic {} before it", channel.topic);
                        place.error("channel", expected, "none")
                    })?,
                };
                self.check_topic(place, &channel.topic, schema, &channel.message_encoding)?;
                let content = (
                    channel.topic.clone(),
                    schema,
                    channel.message_encoding.clone(),
                    channel.metadata.clone(),
                );
                self.channels.id(file, channel.id, content)
            }
            _ => return Ok(None),
        };
        id.map(Some).ok_or_else(|| ContainerError::Collision {
            file: place.file.to_owned(),
            what: "schemas and channels".to_owned(),
            expected: "at most 65535 of each in all files together".to_owned(),
            found: "more".to_owned(),
        })
    }

    /// Learns a schema or channel of a file; gives its body with new ids.
    pub(crate) fn define(
        &mut self,
        file: usize,
        place: Place<'_>,
        opcode: u8,
        body: &[u8],
    ) -> Result<Vec<u8>, ContainerError> {
        let record = place.parse(opcode, body)?;
        let id = self.learn(file, place, &record)?.unwrap_or_default();
        let mut body = body.to_vec();
        set_id(&mut body, id);
        if let Record::Channel(channel) = record
            // Number 0 means none, also where a file has a schema of that number.
            && channel.schema_id != 0
            && let Some(schema) = self.schemas.of_file.get(&(file, channel.schema_id))
        {
            set_id(&mut body[2..], *schema);
        }
        Ok(body)
    }

    /// Whether a topic may have a channel with this schema and encoding.
    fn check_topic(
        &mut self,
        place: Place<'_>,
        topic: &str,
        schema: u16,
        encoding: &str,
    ) -> Result<(), ContainerError> {
        let first = (self.topics.entry(topic.to_owned()))
            .or_insert_with(|| (schema, encoding.to_owned(), place.file.to_owned()));
        if (first.0, &*first.1) == (schema, encoding) {
            return Ok(());
        }
        if !self.keep_both {
            return Err(ContainerError::Collision {
                file: place.file.to_owned(),
                what: format!("topic {topic}"),
                expected: format!("the schema and encoding that {} has", first.2),
                found: "another one; --keep-both writes both channels, --exclude-topic-regex of \
                        `inhand filter` leaves one out"
                    .to_owned(),
            });
        }
        self.side_by_side.insert(topic.to_owned());
        Ok(())
    }
}
