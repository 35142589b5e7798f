//! Small files in every shape.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{Cursor, Read, Seek, SeekFrom};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use inhand_container::{MetadataRecord, Selected, Selection, Source, metadata, select, verify};
use mcap::records::{MessageHeader, Metadata, Record};
use mcap::write::PrivateRecordOptions;
use mcap::{Attachment, Compression, WriteOptions};
use proptest::prelude::*;

/// Counts what is read.
pub(crate) struct Counting<R>(pub(crate) R, pub(crate) Arc<AtomicU64>);

impl<R: Read> Read for Counting<R> {
    fn read(&mut self, into: &mut [u8]) -> std::io::Result<usize> {
        let read = self.0.read(into)?;
        self.1.fetch_add(read as u64, Relaxed);
        Ok(read)
    }
}

impl<R: Seek> Seek for Counting<R> {
    fn seek(&mut self, to: SeekFrom) -> std::io::Result<u64> {
        self.0.seek(to)
    }
}

/// How a file is laid out.
#[derive(Clone, Debug)]
pub(crate) struct Shape {
    pub(crate) compression: Option<Compression>,
    pub(crate) chunks: bool,
    pub(crate) summary: bool,
    pub(crate) sums: bool,
}

pub(crate) const PLAIN: Shape = Shape {
    compression: None,
    chunks: true,
    summary: true,
    sums: true,
};

pub(crate) fn shapes() -> impl Strategy<Value = Shape> {
    let compressions = prop_oneof![
        Just(None),
        Just(Some(Compression::Zstd)),
        Just(Some(Compression::Lz4))
    ];
    (compressions, any::<[bool; 3]>()).prop_map(|(compression, [chunks, summary, sums])| Shape {
        compression,
        chunks,
        summary,
        sums,
    })
}

/// A message: channel 0 to 3, log time.
pub(crate) type Sent = (u16, u64);

/// Messages in any order of time.
pub(crate) fn messages() -> impl Strategy<Value = Vec<Sent>> {
    prop::collection::vec((0..4_u16, 0..1000_u64), 0..120)
}

/// The data of the n-th message.
pub(crate) fn content(n: usize) -> Vec<u8> {
    (0..40 + n % 90)
        .map(|k| ((n * 31 + k * k) % 251) as u8)
        .collect()
}

/// A file with an unused schema, a channel without schema, equal channels, metadata of one name twice,
/// an attachment, private records, and these messages. Channel 0 is `/tf_static`.
pub(crate) fn file(shape: &Shape, messages: &[Sent]) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    let mut writer = WriteOptions::new()
        .profile("a profile")
        .library("a library")
        .compression(shape.compression)
        .use_chunks(shape.chunks)
        .chunk_size(Some(700))
        .emit_summary_records(shape.summary)
        .emit_summary_offsets(shape.summary)
        .emit_message_indexes(shape.summary)
        .calculate_chunk_crcs(shape.sums)
        .calculate_data_section_crc(shape.sums)
        .calculate_summary_section_crc(shape.sums)
        .create(&mut out)
        .unwrap();
    let facts = |text: &str| BTreeMap::from([("key".to_owned(), text.to_owned())]);
    let metadata = |text: &str| Metadata {
        name: "notes".to_owned(),
        metadata: facts(text),
    };
    writer.write_metadata(&metadata("first")).unwrap();
    writer
        .add_schema_with_id(7, "unused", "jsonschema", b"{}")
        .unwrap();
    writer
        .add_schema_with_id(40, "used", "jsonschema", b"{}")
        .unwrap();
    let topics = [("/tf_static", 40), ("/a", 40), ("/b", 0), ("/a", 40)];
    for (n, (topic, schema)) in topics.into_iter().enumerate() {
        let said = facts(&format!("channel {n}"));
        writer
            .add_channel_with_id(n as u16, schema, topic, "json", &said)
            .unwrap();
    }
    writer
        .write_private_record(
            0x90,
            b"private",
            PrivateRecordOptions::IncludeInChunks.into(),
        )
        .unwrap();
    for (n, &(channel_id, log_time)) in messages.iter().enumerate() {
        let header = MessageHeader {
            channel_id,
            sequence: n as u32,
            log_time,
            publish_time: log_time / 2,
        };
        writer.write_to_known_channel(&header, &content(n)).unwrap();
        if n == messages.len() / 2 {
            let attachment = Attachment {
                log_time: 5,
                create_time: 6,
                name: "calibration".to_owned(),
                media_type: "text/plain".to_owned(),
                data: Cow::Borrowed(b"1 2 3"),
            };
            writer.attach(&attachment).unwrap();
        }
    }
    writer.write_metadata(&metadata("second")).unwrap();
    writer
        .write_private_record(0x91, b"private too", Default::default())
        .unwrap();
    writer.finish().unwrap();
    drop(writer);
    out.into_inner()
}

/// Records of the data in order, each in words; chunks are looked into.
pub(crate) fn records(bytes: &[u8]) -> Vec<String> {
    (mcap::read::ChunkFlattener::new(bytes).unwrap())
        .map(Result::unwrap)
        .take_while(|record| !matches!(record, Record::DataEnd(_)))
        .filter(|record| !matches!(record, Record::MessageIndex(_)))
        .map(|record| format!("{record:?}"))
        .collect()
}

/// Channel topic, sequence, log time and data of all messages in order.
pub(crate) fn sent(bytes: &[u8]) -> Vec<(String, u32, u64, Vec<u8>)> {
    (mcap::MessageStream::new(bytes).unwrap())
        .map(|message| {
            let message = message.unwrap();
            let topic = message.channel.topic.clone();
            (
                topic,
                message.sequence,
                message.log_time,
                message.data.to_vec(),
            )
        })
        .collect()
}

pub(crate) fn metadata_of(bytes: &[u8]) -> Vec<MetadataRecord> {
    metadata(&mut Source::open("out.mcap", Cursor::new(bytes)).unwrap()).unwrap()
}

/// What is selected, read back with every checksum.
pub(crate) fn selected(bytes: &[u8], selection: &Selection<'_>) -> (Vec<u8>, Selected) {
    let mut out = Vec::new();
    let mut source = Source::open("in.mcap", Cursor::new(bytes)).unwrap();
    let selected = select(&mut source, &mut out, selection).unwrap();
    check(&out, &selected.written);
    (out, selected)
}

pub(crate) fn check(bytes: &[u8], written: &inhand_container::Written) {
    let mut source = Source::open("out.mcap", Cursor::new(bytes)).unwrap();
    verify(&mut source, written).unwrap();
    let stats = mcap::Summary::read(bytes).unwrap().unwrap().stats.unwrap();
    assert_eq!(stats.message_count, written.messages);
    assert_eq!(u64::from(stats.channel_count), written.channels);
    assert_eq!(u64::from(stats.attachment_count), written.attachments);
}
