//! Listing files, ours and those of the mcap crate in every shape.

use std::collections::BTreeMap;
use std::io::Cursor;

use inhand_channels::{ChannelError, Views, info, is_mcap, write_take};
use inhand_container::ContainerError;
use inhand_model::Finger;
use mcap::records::MessageHeader;
use mcap::{Compression, WriteOptions};

use crate::common;
use crate::round_trip::written;

#[test]
fn our_own_files_are_listed_with_gaps_and_frames() {
    let take = common::take(600, 100.0);
    let bytes = written(&common::take_file(&take, &[], &[]), true);
    let info = info(&bytes, "take.mcap").unwrap();
    assert!(info.problem.is_none() && info.has_summary);
    assert!(info.library.starts_with("inhand ") && info.profile.is_empty());
    assert_eq!(info.bytes, bytes.len() as u64);
    assert_eq!(info.chunks.compression.keys().collect::<Vec<_>>(), ["zstd"]);
    assert!((info.duration_s() - 5.99).abs() < 1e-9);
    let markers = &info.channels[0];
    assert_eq!(markers.topic, "/recording/markers");
    assert_eq!(markers.schema.as_deref(), Some("inhand.Markers"));
    assert_eq!(markers.schema_encoding.as_deref(), Some("protobuf"));
    assert_eq!(markers.metadata["frame"], "world");
    assert_eq!(markers.messages, 600);
    assert!((markers.rate_hz().unwrap() - 100.0).abs() < 1e-9);

    // The ring finger is hidden for 30 samples every 500, the little finger for one in 700.
    let tips = info
        .fingertips
        .iter()
        .find(|tips| tips.topic == "/recording/fingertips")
        .unwrap();
    let ring = tips.fingers[Finger::Ring];
    assert_eq!((ring.counts.measured, ring.counts.missing), (540, 60));
    assert_eq!((ring.gaps, ring.longest_gap), (2, 30));
    assert!((ring.longest_gap_s - 0.3).abs() < 1e-9);
    assert_eq!(tips.fingers[Finger::Little].gaps, 1);
    assert_eq!(tips.fingers[Finger::Thumb].counts.missing, 0);
    let processed = info
        .fingertips
        .iter()
        .find(|tips| tips.topic == "/processed/fingertips")
        .unwrap();
    assert_eq!(processed.fingers[Finger::Little].counts.filled, 1);

    let edges: Vec<_> = (info.frames.iter())
        .map(|edge| {
            (
                edge.parent.as_str(),
                edge.child.as_str(),
                edge.topic.as_str(),
            )
        })
        .collect();
    assert_eq!(
        edges,
        [
            ("hand", "object", "/tf"),
            ("upright", "world", "/tf_static"),
            ("world", "hand", "/tf")
        ]
    );
}

#[test]
fn summaries_indexes_and_checksums_hold() {
    // Long enough for many chunks.
    let take = common::take(9000, 100.0);
    let bytes = written(&common::take_file(&take, &[], &[]), true);
    let listed = info(&bytes, "take.mcap").unwrap();
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    let statistics = summary.stats.as_ref().unwrap();
    assert!(summary.chunk_indexes.len() > 16);
    assert_eq!(statistics.chunk_count as usize, summary.chunk_indexes.len());
    assert_eq!(statistics.message_count, listed.messages);
    assert_eq!(statistics.metadata_count as usize, listed.metadata.0.len());
    assert_eq!(
        Some(statistics.message_start_time),
        listed.first_unix_nanos()
    );
    assert_eq!(Some(statistics.message_end_time), listed.last_unix_nanos());
    for channel in &listed.channels {
        assert_eq!(
            statistics.channel_message_counts[&channel.id],
            channel.messages
        );
        assert_eq!(summary.channels[&channel.id].topic, channel.topic);
    }
    for index in &summary.metadata_indexes {
        assert_eq!(
            mcap::read::metadata(&bytes, index).unwrap().name,
            index.name
        );
    }
    let mut through_chunks = 0;
    for chunk in &summary.chunk_indexes {
        through_chunks += summary.stream_chunk(&bytes, chunk).unwrap().count() as u64;
        let indexes = summary.read_message_indexes(&bytes, chunk).unwrap();
        let (channel, entries) = indexes.iter().next().unwrap();
        let last = entries.last().unwrap();
        let message = summary.seek_message(&bytes, chunk, last).unwrap();
        assert_eq!(message.log_time, last.log_time);
        assert_eq!(message.channel.topic, channel.topic);
    }
    assert_eq!(through_chunks, listed.messages);
    // Checksums of data and summary, by the mcap crate.
    let mut reader = mcap::sans_io::LinearReader::new_with_options(
        mcap::sans_io::LinearReaderOptions::default()
            .with_validate_chunk_crcs(true)
            .with_validate_data_section_crc(true)
            .with_validate_summary_section_crc(true)
            .with_check_finishes_after_end_magic(true),
    );
    let mut rest = bytes.as_slice();
    while let Some(event) = reader.next_event() {
        if let mcap::sans_io::LinearReadEvent::ReadRequest(want) = event.unwrap() {
            let (now, later) = rest.split_at(want.min(rest.len()));
            reader.insert(now.len()).copy_from_slice(now);
            reader.notify_read(now.len());
            rest = later;
        }
    }
    assert!(rest.is_empty());
}

#[test]
fn a_full_disk_is_an_error() {
    struct Full(usize);
    impl std::io::Write for Full {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            self.0 = (self.0)
                .checked_sub(bytes.len())
                .ok_or(std::io::ErrorKind::StorageFull)?;
            Ok(bytes.len())
        }
        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }
    let take = common::take(300, 100.0);
    let file = common::take_file(&take, &[], &[]);
    for room in [0, 100, 10_000, written(&file, true).len() - 1] {
        let error = write_take(&mut Full(room), &file, Views::All).unwrap_err();
        assert!(
            matches!(error, ChannelError::Container(ContainerError::Write { .. })),
            "{error:?}"
        );
    }
}

/// A file of the mcap crate with a channel without schema, one of ROS 2, an attachment and
/// metadata; times are not in order.
fn foreign(options: WriteOptions) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    let mut writer = options.create(&mut out).unwrap();
    let schema = writer
        .add_schema("std_msgs/msg/String", "ros2msg", b"string data")
        .unwrap();
    let bare = writer
        .add_channel(0, "/bare", "json", &BTreeMap::new())
        .unwrap();
    let ros = writer
        .add_channel(schema, "/ros", "cdr", &BTreeMap::new())
        .unwrap();
    for n in 0..10_u64 {
        for (channel_id, log_time) in [(bare, 1_000_000_000 - n), (ros, n * 100_000_000)] {
            let header = MessageHeader {
                channel_id,
                sequence: n as u32,
                log_time,
                publish_time: log_time,
            };
            writer.write_to_known_channel(&header, b"{}").unwrap();
        }
    }
    writer
        .attach(&mcap::Attachment {
            log_time: 1,
            create_time: 2,
            name: "photo".to_owned(),
            media_type: "image/png".to_owned(),
            data: vec![7; 100].into(),
        })
        .unwrap();
    let facts = BTreeMap::from([("key".to_owned(), "value".to_owned())]);
    writer
        .write_metadata(&mcap::records::Metadata {
            name: "facts".to_owned(),
            metadata: facts,
        })
        .unwrap();
    writer.finish().unwrap();
    drop(writer);
    out.into_inner()
}

#[test]
fn files_of_others_are_listed_in_every_shape() {
    let shapes = [
        (WriteOptions::new().compression(None), "none"),
        (
            WriteOptions::new().compression(Some(Compression::Zstd)),
            "zstd",
        ),
        (
            WriteOptions::new().compression(Some(Compression::Lz4)),
            "lz4",
        ),
        (WriteOptions::new().use_chunks(false), ""),
        (
            WriteOptions::new()
                .compression(None)
                .emit_summary_records(false)
                .emit_summary_offsets(false)
                .emit_message_indexes(false)
                .calculate_chunk_crcs(false)
                .calculate_data_section_crc(false),
            "none",
        ),
    ];
    for (options, compression) in shapes {
        let bytes = foreign(options.profile("ros2").chunk_size(Some(64)));
        let info = info(&bytes, "foreign.mcap").unwrap();
        assert!(info.problem.is_none(), "{compression}: {:?}", info.problem);
        assert_eq!(info.profile, "ros2");
        assert_eq!((info.messages, info.messages_without_channel), (20, 0));
        let compressions: Vec<_> = info.chunks.compression.keys().map(String::as_str).collect();
        let expected: &[&str] = if compression.is_empty() {
            &[]
        } else {
            &[compression]
        };
        assert_eq!(compressions, expected);
        let [bare, ros] = info.channels.as_slice() else {
            panic!("{:?}", info.channels);
        };
        assert_eq!(
            (bare.schema.as_ref(), bare.schema_encoding.as_ref()),
            (None, None)
        );
        assert_eq!(bare.message_encoding, "json");
        assert_eq!(bare.first_unix_nanos, Some(999_999_991));
        assert_eq!(bare.last_unix_nanos, Some(1_000_000_000));
        assert_eq!(ros.schema_encoding.as_deref(), Some("ros2msg"));
        assert!((ros.rate_hz().unwrap() - 10.0).abs() < 1e-9);
        assert_eq!(info.attachments[0].bytes, 100);
        assert_eq!(info.metadata.0["facts"]["key"], "value");
    }
}

#[test]
fn a_file_without_messages_is_listed() {
    let mut out = Cursor::new(Vec::new());
    WriteOptions::new()
        .create(&mut out)
        .unwrap()
        .finish()
        .unwrap();
    let info = info(out.get_ref(), "empty.mcap").unwrap();
    assert!(info.problem.is_none() && info.channels.is_empty());
    assert_eq!((info.first_unix_nanos(), info.duration_s()), (None, 0.0));
    assert!(is_mcap(out.get_ref()) && !is_mcap(b"\x89MCAP"));
}
