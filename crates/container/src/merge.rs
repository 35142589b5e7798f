//! Several files as one, by time.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};
use std::io::Write;

use mcap::records::{Record, op};

use crate::attachment::pass_attachment;
use crate::chunk::Packing;
use crate::error::ContainerError;
use crate::feed::{Feed, Outside};
use crate::format::{id_of, set_id};
use crate::ids::Ids;
use crate::overview::MetadataRecord;
use crate::source::Source;
use crate::writer::{Writer, Written};

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
    /// Longest time between two messages of the output, nanoseconds.
    pub longest_pause: u64,
}

/// Writes the messages of all files in the order of their log times; those of one file stay in its
/// order, and of equal times those of the file named first come first.
///
/// Channels of different files with equal topic, schema, encoding and metadata become one. Ids are kept
/// where they are free. Messages keep sequence, times and data, attachments and metadata records all of
/// theirs; metadata records that an earlier file has word for word are written once. Memory is taken for
/// one chunk of each file.
///
/// # Errors
///
/// [`ContainerError::Collision`] for a topic with different schemas, unless both are to be kept, and
/// where ids run out; the errors of reading and writing.
pub fn merge(
    sources: Vec<Source<'_>>,
    out: &mut dyn Write,
    settings: &Merge<'_>,
) -> Result<Merged, ContainerError> {
    let feeds: Result<Vec<_>, _> = sources.into_iter().map(Feed::start).collect();
    let mut feeds = feeds?;
    let mut profiles = BTreeSet::new();
    for feed in &feeds {
        let header = feed.header.as_deref().unwrap_or(&[0; 8]);
        if let Record::Header(header) = feed.place().parse(op::HEADER, header)? {
            profiles.insert(header.profile);
        }
    }
    // Files of several kinds are of none.
    let profile = profiles.pop_first().filter(|_| profiles.is_empty());
    let profile = profile.unwrap_or_default();
    let mut merger = Merger {
        settings,
        writer: Writer::new(out, &profile, settings.library, settings.packing)?,
        ids: Ids::new(settings.keep_both),
        used: BTreeMap::new(),
        metadata: BTreeMap::new(),
        result: Merged::default(),
    };
    let mut due = BinaryHeap::new();
    for (n, feed) in feeds.iter_mut().enumerate() {
        merger.advance(n, feed)?;
        due.extend(feed.message_time().map(|time| Reverse((time, n))));
    }
    let mut last = None;
    while let Some(Reverse((time, n))) = due.pop() {
        let pause = time.saturating_sub(last.replace(time).unwrap_or(time));
        merger.result.longest_pause = merger.result.longest_pause.max(pause);
        merger.message(n, &mut feeds[n])?;
        merger.advance(n, &mut feeds[n])?;
        due.extend(feeds[n].message_time().map(|time| Reverse((time, n))));
    }
    let shared = merger.used.iter().filter(|(_, files)| files.len() > 1);
    let topics = shared.filter_map(|(&channel, _)| merger.ids.topic(channel));
    Ok(Merged {
        joined: topics.map(str::to_owned).collect(),
        side_by_side: merger.ids.side_by_side,
        written: merger.writer.finish()?,
        ..merger.result
    })
}

struct Merger<'a> {
    settings: &'a Merge<'a>,
    writer: Writer<'a>,
    ids: Ids,
    /// Which files had messages in a channel.
    used: BTreeMap<u16, BTreeSet<usize>>,
    /// Bodies of metadata records with the first file that has them.
    metadata: BTreeMap<Vec<u8>, usize>,
    result: Merged,
}

impl Merger<'_> {
    /// Writes what is in a file up to its next message.
    fn advance(&mut self, n: usize, feed: &mut Feed<'_>) -> Result<(), ContainerError> {
        while let Some(outside) = feed.next()? {
            match outside {
                Outside::Attachment(head) => {
                    pass_attachment(&mut feed.source, head, &mut self.writer)?;
                }
                Outside::Record(opcode @ (op::SCHEMA | op::CHANNEL)) => {
                    let body = self.ids.define(n, feed.place(), opcode, feed.body())?;
                    self.writer.inside_once(opcode, &body)?;
                }
                Outside::Record(op::METADATA) => self.metadata(n, feed)?,
                Outside::Record(opcode) if feed.in_chunk() => {
                    self.writer.inside(opcode, feed.body())?;
                }
                Outside::Record(opcode) => self.writer.outside(opcode, feed.body())?,
            }
        }
        Ok(())
    }

    fn metadata(&mut self, n: usize, feed: &Feed<'_>) -> Result<(), ContainerError> {
        let Record::Metadata(record) = feed.place().parse(op::METADATA, feed.body())? else {
            return Ok(());
        };
        let record = MetadataRecord::from(record);
        let changed = (self.settings.metadata)(n, record.clone());
        let body = match changed == record {
            true => feed.body().to_vec(),
            false => changed.to_bytes(),
        };
        if *self.metadata.entry(body.clone()).or_insert(n) != n {
            self.result.metadata_once += 1;
            return Ok(());
        }
        self.writer.outside(op::METADATA, &body)
    }

    /// Writes the message at hand of a file.
    fn message(&mut self, n: usize, feed: &mut Feed<'_>) -> Result<(), ContainerError> {
        let old = id_of(feed.body()).unwrap_or_default();
        if self.ids.channel(n, old).is_none()
            && let Some(channel) = feed.take_listed(op::CHANNEL, old)
        {
            self.define_listed(n, feed, &channel)?;
        }
        let channel = set_channel(&self.ids, n, feed)?;
        self.used.entry(channel).or_default().insert(n);
        self.writer.inside(op::MESSAGE, feed.body())
    }
}

impl Merger<'_> {
    /// Writes a channel that the summary of a file lists, after its schema.
    fn define_listed(
        &mut self,
        n: usize,
        feed: &mut Feed<'_>,
        channel: &[u8],
    ) -> Result<(), ContainerError> {
        let schema = channel.get(2..).and_then(id_of);
        let schema = schema.and_then(|id| feed.take_listed(op::SCHEMA, id));
        let listed = schema.iter().map(|body| (op::SCHEMA, &body[..]));
        for (opcode, body) in listed.chain([(op::CHANNEL, channel)]) {
            let body = self.ids.define(n, feed.place(), opcode, body)?;
            self.writer.inside_once(opcode, &body)?;
        }
        Ok(())
    }
}

/// Gives the message at hand of a file its new channel.
pub(crate) fn set_channel(
    ids: &Ids,
    file: usize,
    feed: &mut Feed<'_>,
) -> Result<u16, ContainerError> {
    let old = id_of(feed.body()).unwrap_or_default();
    let channel = ids.channel(file, old).ok_or_else(|| {
        let expected = format!("channel {old} before its messages");
        feed.place().error("message", expected, "none")
    })?;
    set_id(feed.body_mut(), channel);
    Ok(channel)
}
