//! Several files as one, by time.

mod feed;

use std::collections::{BTreeMap, BTreeSet};
use std::io::{Read, Seek, Write};

use mcap::records::{Record, op};

use crate::attachment::pass_attachment;
use crate::chunk::Packing;
use crate::error::ContainerError;
use crate::format::{MessageFacts, push_text, set_channel};
use crate::index::Written;
use crate::overview::MetadataRecord;
use crate::source::Source;
use crate::walk::parse;
use crate::writer::Writer;
use feed::{Feed, Outside};

/// How files become one.
pub struct Merge<'a> {
    /// What the result says wrote it.
    pub library: &'a str,
    /// Whether channels of one topic with different schemas or encodings lie side by side; otherwise
    /// such files are refused.
    pub keep_both: bool,
    /// What becomes of a metadata record of the file with this number, counted from 0.
    pub metadata: &'a dyn Fn(usize, MetadataRecord) -> MetadataRecord,
    /// How chunks are packed.
    pub packing: Packing,
}

impl std::fmt::Debug for Merge<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        (f.debug_struct("Merge"))
            .field("library", &self.library)
            .field("keep_both", &self.keep_both)
            .field("packing", &self.packing)
            .finish_non_exhaustive()
    }
}

/// What became of files that are one now.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Merged {
    /// What the output holds.
    pub written: Written,
    /// Topics to which more than one file had messages in one channel.
    pub joined: BTreeSet<String>,
    /// Topics of which there are several channels, with different schemas or encodings.
    pub side_by_side: BTreeSet<String>,
    /// Metadata records that another file had as well, word for word.
    pub metadata_once: u64,
}

/// Writes the messages of all files in the order of their log times; those of one file stay in its
/// order, and of equal times those of the file named first come first.
///
/// Channels with equal topic, schema, encoding and metadata become one. Ids are kept where they are
/// free. Messages keep sequence, times and data, attachments and metadata records all of theirs;
/// metadata records that an earlier file has word for word are written once. Memory is taken for one
/// chunk of each file.
///
/// # Errors
///
/// [`ContainerError::Collision`] for a topic with different schemas, unless both are to be kept, and
/// where ids run out; the errors of reading and writing.
pub fn merge<R: Read + Seek, W: Write>(
    sources: &mut [Source<R>],
    out: W,
    settings: &Merge<'_>,
) -> Result<Merged, ContainerError> {
    let mut feeds = Vec::with_capacity(sources.len());
    let mut profiles = BTreeSet::new();
    for source in sources {
        let feed = Feed::start(source)?;
        profiles.insert(feed.profile.clone());
        feeds.push(feed);
    }
    let mut header = Vec::new();
    // Files of several kinds are of none.
    let profile = profiles.pop_first().filter(|_| profiles.is_empty());
    push_text(&mut header, &profile.unwrap_or_default());
    push_text(&mut header, settings.library);
    let mut merger = Merger {
        settings,
        writer: Writer::create(out, &header, settings.packing)?,
        schemas: Ids::starting_at(1),
        channels: Ids::starting_at(0),
        topics: BTreeMap::new(),
        files: (feeds.iter()).map(|_| FileIds::default()).collect(),
        metadata: BTreeMap::new(),
        result: Merged::default(),
    };
    for (n, feed) in feeds.iter_mut().enumerate() {
        merger.advance(n, feed)?;
    }
    loop {
        let next = (feeds.iter().enumerate())
            .filter_map(|(n, feed)| Some((feed.message_time()?, n)))
            .min();
        let Some((_, n)) = next else { break };
        merger.message(n, &mut feeds[n])?;
        merger.advance(n, &mut feeds[n])?;
    }
    merger.result.written = merger.writer.finish()?;
    Ok(merger.result)
}

/// New ids of one file's schemas and channels.
#[derive(Default)]
struct FileIds {
    schemas: BTreeMap<u16, u16>,
    channels: BTreeMap<u16, u16>,
    /// Channels that had a message.
    used: BTreeSet<u16>,
}

/// Ids by what they stand for.
struct Ids<K> {
    by_content: BTreeMap<K, u16>,
    taken: BTreeSet<u16>,
    first: u16,
}

impl<K: Ord> Ids<K> {
    fn starting_at(first: u16) -> Self {
        Self {
            by_content: BTreeMap::new(),
            taken: BTreeSet::new(),
            first,
        }
    }

    /// The id of this content and whether it is new; `None` where there is none left.
    fn of(&mut self, content: K, wish: u16) -> Option<(u16, bool)> {
        if let Some(&id) = self.by_content.get(&content) {
            return Some((id, false));
        }
        let id = if wish >= self.first && !self.taken.contains(&wish) {
            wish
        } else {
            (self.first..=u16::MAX).find(|id| !self.taken.contains(id))?
        };
        self.taken.insert(id);
        self.by_content.insert(content, id);
        Some((id, true))
    }
}

/// What makes two channels one: topic, schema, encoding, metadata.
type ChannelContent = (String, u16, String, BTreeMap<String, String>);

struct Merger<'a, W> {
    settings: &'a Merge<'a>,
    writer: Writer<W>,
    /// By what follows the id in the body.
    schemas: Ids<Vec<u8>>,
    channels: Ids<ChannelContent>,
    /// Schema id and encoding of the first channel of each topic, with its file's name.
    topics: BTreeMap<String, (u16, String, String)>,
    files: Vec<FileIds>,
    /// Bodies of metadata records with the first file that has them.
    metadata: BTreeMap<Vec<u8>, usize>,
    result: Merged,
}

impl<W: Write> Merger<'_, W> {
    /// Writes what is in a file up to its next message.
    fn advance<R: Read + Seek>(
        &mut self,
        n: usize,
        feed: &mut Feed<'_, R>,
    ) -> Result<(), ContainerError> {
        while let Some(outside) = feed.next()? {
            match outside {
                Outside::Attachment(head) => {
                    pass_attachment(feed.source, head, &mut self.writer)?;
                }
                Outside::Record(opcode) => match opcode {
                    op::SCHEMA => self.schema(n, feed)?,
                    op::CHANNEL => self.channel(n, feed)?,
                    op::METADATA => self.metadata(n, feed.body())?,
                    _ if feed.in_chunk() => self.writer.inside(opcode, feed.body())?,
                    _ => self.writer.outside(opcode, feed.body())?,
                },
            }
        }
        Ok(())
    }

    fn schema<R: Read + Seek>(
        &mut self,
        n: usize,
        feed: &Feed<'_, R>,
    ) -> Result<(), ContainerError> {
        let body = feed.body();
        let Record::Schema { header, .. } = parse(feed.place(), op::SCHEMA, body)? else {
            return Ok(());
        };
        let content = body.get(2..).unwrap_or_default();
        let id = self.schemas.of(content.to_vec(), header.id);
        let (id, new) = id.ok_or_else(|| none_left(feed, "schemas"))?;
        self.files[n].schemas.insert(header.id, id);
        if new {
            let mut body = body.to_vec();
            set_channel(&mut body, id);
            self.writer.inside(op::SCHEMA, &body)?;
        }
        Ok(())
    }

    fn channel<R: Read + Seek>(
        &mut self,
        n: usize,
        feed: &Feed<'_, R>,
    ) -> Result<(), ContainerError> {
        let body = feed.body();
        let Record::Channel(channel) = parse(feed.place(), op::CHANNEL, body)? else {
            return Ok(());
        };
        let schema = match channel.schema_id {
            0 => 0,
            id => *(self.files[n].schemas.get(&id)).ok_or_else(|| {
                let expected = format!("schema {id} of topic {} before it", channel.topic);
                feed.place().error("channel", expected, "none")
            })?,
        };
        let encoding = channel.message_encoding;
        let file = feed.source.file();
        let (first_schema, first_encoding, first_file) = (self.topics)
            .entry(channel.topic.clone())
            .or_insert_with(|| (schema, encoding.clone(), file.to_owned()));
        if (*first_schema, &*first_encoding) != (schema, &encoding) {
            if !self.settings.keep_both {
                return Err(ContainerError::Collision {
                    file: file.to_owned(),
                    what: format!("topic {}", channel.topic),
                    expected: format!("the schema and encoding that {first_file} has"),
                    found: "another one; --keep-both writes both channels, --exclude-topic-regex \
                            of `inhand filter` leaves one out"
                        .to_owned(),
                });
            }
            self.result.side_by_side.insert(channel.topic.clone());
        }
        let content = (channel.topic, schema, encoding, channel.metadata);
        let id = self.channels.of(content, channel.id);
        let (id, new) = id.ok_or_else(|| none_left(feed, "channels"))?;
        self.files[n].channels.insert(channel.id, id);
        if new {
            let mut body = body.to_vec();
            set_channel(&mut body, id);
            body.splice(2..4, schema.to_le_bytes());
            self.writer.inside(op::CHANNEL, &body)?;
        }
        Ok(())
    }

    fn metadata(&mut self, n: usize, body: &[u8]) -> Result<(), ContainerError> {
        let Some(record) = MetadataRecord::parse(body) else {
            return Ok(());
        };
        let changed = (self.settings.metadata)(n, record.clone());
        let body = if changed == record {
            body.to_vec()
        } else {
            changed.to_bytes()
        };
        if *self.metadata.entry(body.clone()).or_insert(n) != n {
            self.result.metadata_once += 1;
            return Ok(());
        }
        self.writer.outside(op::METADATA, &body)
    }

    /// Writes the message that a file stands at.
    fn message<R: Read + Seek>(
        &mut self,
        n: usize,
        feed: &mut Feed<'_, R>,
    ) -> Result<(), ContainerError> {
        let place = feed.place();
        let facts = MessageFacts::of(feed.body()).ok_or_else(|| place.short(op::MESSAGE))?;
        let Some(&channel) = self.files[n].channels.get(&facts.channel) else {
            let expected = format!("channel {} before its messages", facts.channel);
            return Err(place.error("message", expected, "none"));
        };
        if self.files[n].used.insert(channel) {
            let others = self.files.iter().enumerate();
            let shared = others.filter(|&(m, file)| m != n && file.used.contains(&channel));
            if shared.count() > 0
                && let Some(((topic, ..), _)) =
                    (self.channels.by_content.iter()).find(|(_, id)| **id == channel)
            {
                self.result.joined.insert(topic.clone());
            }
        }
        let body = feed.body_mut();
        set_channel(body, channel);
        self.writer.inside(op::MESSAGE, body)
    }
}

fn none_left<R: Read + Seek>(feed: &Feed<'_, R>, what: &str) -> ContainerError {
    ContainerError::Collision {
        file: feed.source.file().to_owned(),
        what: what.to_owned(),
        expected: "at most 65535 in all files together".to_owned(),
        found: "more".to_owned(),
    }
}
