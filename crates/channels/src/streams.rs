//! Messages of many channels, merged by time into one file.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::io::Write;

use inhand_container::{Packing, Writer};
use inhand_model::{Clock, Recording};

use crate::error::ChannelError;
use crate::made::Made;
use crate::metadata::Metadata;
use crate::schema::Logged;

/// A fixed name: the same nouns give the same bytes.
const LIBRARY: &str = concat!("inhand ", env!("CARGO_PKG_VERSION"));

/// How chunks are packed where a file is kept and read as a whole.
pub(crate) const PACKED: Packing = Packing::Zstd;

/// A file being written.
pub(crate) struct Output<'a> {
    writer: Writer<'a>,
    /// Gives channels that are added from now on other topics.
    pub(crate) rename: fn(&str) -> &str,
}

impl Output<'_> {
    /// Adds a channel whose coordinates are in `frame`, if it has any, and returns its id.
    pub(crate) fn channel<M: Logged>(
        &mut self,
        topic: &str,
        frame: Option<&str>,
    ) -> Result<u16, ChannelError> {
        let schema = M::schema();
        let schema_id = (self.writer).schema(&schema.name, "protobuf", &schema.data)?;
        let metadata = (frame.iter())
            .map(|frame| ("frame".to_owned(), (*frame).to_owned()))
            .collect();
        let topic = (self.rename)(topic);
        Ok((self.writer).channel(schema_id, topic, "protobuf", &metadata)?)
    }

    /// Writes a message of the instant `unix_nanos`.
    pub(crate) fn message<M: Logged>(
        &mut self,
        channel: u16,
        sequence: usize,
        unix_nanos: u64,
        message: &M,
    ) -> Result<(), ChannelError> {
        // The format has 32 bits for it; it only helps people who read a listing.
        let sequence = sequence as u32;
        let encode = |data: &mut Vec<u8>| message.encode_raw(data);
        Ok((self.writer).message(channel, sequence, unix_nanos, encode)?)
    }
}

/// Consecutive samples of a take that is written block by block.
#[derive(Clone, Copy)]
pub(crate) struct Block<'a> {
    pub(crate) recording: &'a Recording,
    /// Number of the first sample.
    pub(crate) first: usize,
    /// What methods made of the samples.
    pub(crate) made: &'a Made<'a>,
}

/// The sample that a message is about.
pub(crate) struct Instant<'a> {
    /// Number of the sample.
    pub(crate) k: usize,
    /// Its time.
    pub(crate) unix_nanos: u64,
    block: Option<Block<'a>>,
}

impl<'a> Instant<'a> {
    /// The recording that has the sample, and where: `whole`, or else the block that is being written.
    pub(crate) fn recorded(&self, whole: Option<&'a Recording>) -> Option<(&'a Recording, usize)> {
        let block = self.block.map(|block| (block.recording, block.first));
        let (recording, first) = whole.map(|recording| (recording, 0)).or(block)?;
        let row = self.k - first;
        (row < recording.len()).then_some((recording, row))
    }

    /// What methods made of the block with the sample.
    pub(crate) fn made(&self) -> Option<&'a Made<'a>> {
        self.block.map(|block| block.made)
    }
}

/// Samples that a channel has messages of.
#[derive(Clone, Copy)]
pub(crate) struct Sampling {
    pub(crate) clock: Clock,
    /// How many samples there are.
    pub(crate) samples: usize,
    /// Every how many samples there is a message.
    pub(crate) stride: usize,
}

impl Sampling {
    /// Every sample.
    pub(crate) fn all(clock: Clock, samples: usize) -> Self {
        Self {
            clock,
            samples,
            stride: 1,
        }
    }

    /// One of so many samples.
    pub(crate) fn every(self, stride: usize) -> Self {
        Self { stride, ..self }
    }

    fn time(&self, k: usize) -> Option<u64> {
        (k < self.samples).then(|| self.clock.unix_nanos(k))
    }
}

/// Writes the next message of a channel and gives the time of the one after it; `None` after the last.
type WriteNext<'a> =
    Box<dyn FnMut(Option<Block<'_>>, &mut Output<'_>) -> Result<Option<u64>, ChannelError> + 'a>;

/// A file being written, with the messages that wait for their time. Those of one instant come in the
/// order in which their channels were added.
pub(crate) struct Streams<'a> {
    pub(crate) output: Output<'a>,
    streams: Vec<WriteNext<'a>>,
    /// Time of the next message of each stream that goes on, with the number of the stream.
    due: BinaryHeap<Reverse<(u64, usize)>>,
}

impl<'a> Streams<'a> {
    /// Begins a file with its metadata.
    pub(crate) fn create(
        out: &'a mut dyn Write,
        packing: Packing,
        metadata: &Metadata,
    ) -> Result<Self, ChannelError> {
        let mut writer = Writer::new(out, "", LIBRARY, packing)?;
        for (name, facts) in &metadata.0 {
            writer.metadata(name, facts)?;
        }
        Ok(Self {
            output: Output {
                writer,
                rename: |topic| topic,
            },
            streams: Vec::new(),
            due: BinaryHeap::new(),
        })
    }

    /// Adds a stream whose first message is of the time `first`.
    fn push(&mut self, first: Option<u64>, write: WriteNext<'a>) {
        let stream = self.streams.len();
        self.due.extend(first.map(|time| Reverse((time, stream))));
        self.streams.push(write);
    }

    /// A channel with a single message, which is written at once.
    pub(crate) fn once<M: Logged>(
        &mut self,
        topic: &str,
        frame: Option<&str>,
        unix_nanos: u64,
        message: &M,
    ) -> Result<(), ChannelError> {
        let channel = self.output.channel::<M>(topic, frame)?;
        self.output.message(channel, 0, unix_nanos, message)
    }

    /// Messages that are known: sequence number, time, message; by time.
    pub(crate) fn listed<M: Logged>(
        &mut self,
        channel: u16,
        messages: impl IntoIterator<Item = (usize, u64, M), IntoIter: 'a>,
    ) {
        let mut messages = messages.into_iter().peekable();
        let first = messages.peek().map(|&(_, time, _)| time);
        self.push(
            first,
            Box::new(move |_, output| {
                if let Some((sequence, unix_nanos, message)) = messages.next() {
                    output.message(channel, sequence, unix_nanos, &message)?;
                }
                Ok(messages.peek().map(|&(_, time, _)| time))
            }),
        );
    }

    /// A channel with a message for each sample of which `message` makes one.
    pub(crate) fn sampled<M: Logged>(
        &mut self,
        topic: &str,
        frame: Option<&str>,
        sampling: Sampling,
        mut message: impl FnMut(&Instant<'_>) -> Option<M> + 'a,
    ) -> Result<(), ChannelError> {
        let channel = self.output.channel::<M>(topic, frame)?;
        self.add(sampling, move |at, output| match message(at) {
            Some(message) => output.message(channel, at.k, at.unix_nanos, &message),
            None => Ok(()),
        });
        Ok(())
    }

    /// Calls `write` for each sample.
    pub(crate) fn add(
        &mut self,
        sampling: Sampling,
        mut write: impl FnMut(&Instant<'_>, &mut Output<'_>) -> Result<(), ChannelError> + 'a,
    ) {
        let mut k = 0;
        self.push(
            sampling.time(0),
            Box::new(move |block, output| {
                let unix_nanos = sampling.clock.unix_nanos(k);
                let at = Instant {
                    k,
                    unix_nanos,
                    block,
                };
                write(&at, output)?;
                k += sampling.stride;
                Ok(sampling.time(k))
            }),
        );
    }

    /// Writes all messages up to a time.
    pub(crate) fn write_until(
        &mut self,
        unix_nanos: u64,
        block: Option<Block<'_>>,
    ) -> Result<(), ChannelError> {
        while let Some(&Reverse((time, stream))) = self.due.peek()
            && time <= unix_nanos
        {
            self.due.pop();
            let next = (self.streams[stream])(block, &mut self.output)?;
            self.due.extend(next.map(|time| Reverse((time, stream))));
        }
        Ok(())
    }

    /// Writes all that waits, and ends the file.
    pub(crate) fn finish(mut self) -> Result<(), ChannelError> {
        self.write_until(u64::MAX, None)?;
        self.output.writer.finish()?;
        Ok(())
    }
}
