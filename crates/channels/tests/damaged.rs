//! Bytes that are no sound file, or none of ours: refused with the place, never a panic.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::sync::LazyLock;

use inhand_channels::{
    ChannelError, info, read_dictionary, read_generated, read_leading_metadata, read_metadata,
    read_take, write_dictionary,
};
use inhand_container::ContainerError;
use inhand_model::Protocol;
use mcap::records::{MessageHeader, Record, op};
use mcap::{Compression, WriteOptions};
use proptest::prelude::*;

use crate::common;
use crate::round_trip::written;

fn small_take() -> Vec<u8> {
    let take = common::take(40, 20.0);
    let segments = common::segments(&take);
    let generated = common::generated(&["prior"], &segments);
    written(&common::take_file(&take, &generated, &[]), true)
}

static TAKE: LazyLock<Vec<u8>> = LazyLock::new(small_take);

/// The same content without compression and checksums, so that damage reaches every decoder.
static UNCHECKED: LazyLock<Vec<u8>> = LazyLock::new(|| unchecked(&TAKE, |_, _| {}, |_, _| {}));

/// The same in small chunks without checksums: packed by nothing, lz4 and zstd.
static CHUNKED: LazyLock<[Vec<u8>; 3]> = LazyLock::new(|| {
    [None, Some(Compression::Lz4), Some(Compression::Zstd)].map(|compression| {
        let options = WriteOptions::new()
            .compression(compression)
            .chunk_size(Some(2000))
            .calculate_chunk_crcs(false);
        rewritten(&TAKE, options, |_, _| {}, |_, _| {})
    })
});

/// A dictionary as it is written.
static SOUND_DICTIONARY: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let mut out = Cursor::new(Vec::new());
    let dictionary = common::dictionary(3, 10, 10.0);
    write_dictionary(&mut out, &dictionary, &common::provenance()).unwrap();
    out.into_inner()
});

static DICTIONARY: LazyLock<Vec<u8>> =
    LazyLock::new(|| unchecked(&SOUND_DICTIONARY, |_, _| {}, |_, _| {}));

/// Writes the file anew with changed metadata and messages, unchunked, without checksums.
fn unchecked(
    bytes: &[u8],
    change_facts: impl Fn(&str, &mut BTreeMap<String, String>),
    change_message: impl FnMut(&str, &mut (u64, Vec<u8>)),
) -> Vec<u8> {
    let options = WriteOptions::new().use_chunks(false);
    rewritten(bytes, options, change_facts, change_message)
}

/// Writes the file anew with changed metadata and messages, without checksums of data and summary.
fn rewritten(
    bytes: &[u8],
    options: WriteOptions,
    change_facts: impl Fn(&str, &mut BTreeMap<String, String>),
    mut change_message: impl FnMut(&str, &mut (u64, Vec<u8>)),
) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    let mut writer = options
        .calculate_data_section_crc(false)
        .calculate_summary_section_crc(false)
        .create(&mut out)
        .unwrap();
    for record in mcap::read::LinearReader::new(bytes).unwrap() {
        if let Record::Metadata(mut facts) = record.unwrap() {
            change_facts(&facts.name, &mut facts.metadata);
            writer.write_metadata(&facts).unwrap();
        }
    }
    for message in mcap::MessageStream::new(bytes).unwrap() {
        let message = message.unwrap();
        let schema = message.channel.schema.as_ref().unwrap();
        let schema = writer
            .add_schema(&schema.name, &schema.encoding, &schema.data)
            .unwrap();
        let topic = &message.channel.topic;
        let channel_id = writer
            .add_channel(schema, topic, "protobuf", &message.channel.metadata)
            .unwrap();
        let mut changed = (message.log_time, message.data.to_vec());
        change_message(topic, &mut changed);
        let (log_time, data) = changed;
        if data == b"drop" {
            continue;
        }
        let header = MessageHeader {
            channel_id,
            sequence: message.sequence,
            log_time,
            publish_time: log_time,
        };
        writer.write_to_known_channel(&header, &data).unwrap();
    }
    writer.finish().unwrap();
    drop(writer);
    out.into_inner()
}

/// Where the data ends and what follows only repeats it.
fn data_end(bytes: &[u8]) -> usize {
    let mut offset = 8;
    while bytes[offset] != op::DATA_END {
        offset +=
            9 + u64::from_le_bytes(bytes[offset + 1..offset + 9].try_into().unwrap()) as usize;
    }
    offset
}

fn read_all(bytes: &[u8]) {
    let _ = read_take(bytes, "x.mcap");
    let _ = read_generated(bytes, "x.mcap", Protocol::Published);
    let _ = read_dictionary(bytes, "x.mcap");
    let _ = read_metadata(bytes, "x.mcap");
    let _ = info(bytes, "x.mcap");
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(200) })]

    #[test]
    fn a_cut_file_is_refused_and_listed_as_far_as_it_goes(share in 0.0..1.0_f64) {
        let end = (share * TAKE.len() as f64) as usize;
        let cut = &TAKE[..end];
        prop_assert!(read_take(cut, "cut.mcap").is_err());
        if end >= 8 {
            prop_assert!(info(cut, "cut.mcap").unwrap().problem.is_some());
        }
        read_all(cut);
    }

    #[test]
    fn one_changed_byte_never_goes_unnoticed(
        share in 0.0..1.0_f64,
        change in 1..=255_u8,
        in_summary in any::<bool>(),
    ) {
        let mut bytes = TAKE.clone();
        let data_end = data_end(&bytes);
        let place = if in_summary {
            data_end + (share * (bytes.len() - data_end) as f64) as usize
        } else {
            (share * data_end as f64) as usize
        };
        bytes[place] ^= change;
        prop_assert!(read_take(&bytes, "changed.mcap").is_err(), "byte {place}");
        read_all(&bytes);
    }

    #[test]
    fn one_changed_byte_of_a_dictionary_never_goes_unnoticed(
        share in 0.0..1.0_f64,
        change in 1..=255_u8,
        in_summary in any::<bool>(),
    ) {
        let mut bytes = SOUND_DICTIONARY.clone();
        let first = if in_summary { data_end(&bytes) } else { 0 };
        let place = first + (share * (bytes.len() - first) as f64) as usize;
        bytes[place] ^= change;
        prop_assert!(read_dictionary(&bytes, "changed.mcap").is_err(), "byte {place}");
    }

    #[test]
    fn changed_bytes_under_a_checksum_that_was_made_to_fit_never_panic(
        changes in prop::collection::vec((0.0..0.6_f64, any::<u8>()), 1..6),
    ) {
        let mut bytes = SOUND_DICTIONARY.clone();
        let end = data_end(&bytes);
        for (share, value) in changes {
            bytes[(share * end as f64) as usize] = value;
        }
        let crc = crc32fast::hash(&bytes[..end]);
        bytes[end + 9..end + 13].copy_from_slice(&crc.to_le_bytes());
        read_all(&bytes);
    }

    #[test]
    fn changed_bytes_without_checksums_never_panic(
        changes in prop::collection::vec((0.0..1.0_f64, any::<u8>()), 1..6),
        end in 0.2..1.2_f64,
        which in 0..5_usize,
    ) {
        let mut bytes = match which {
            0 => UNCHECKED.clone(),
            1 => DICTIONARY.clone(),
            compression => CHUNKED[compression - 2].clone(),
        };
        for (share, value) in changes {
            let place = (share * bytes.len() as f64) as usize;
            bytes[place] = value;
        }
        bytes.truncate((end * bytes.len() as f64) as usize);
        read_all(&bytes);
    }

    #[test]
    fn any_bytes_after_the_mark_never_panic(tail in prop::collection::vec(any::<u8>(), 0..300)) {
        let mut bytes = mcap::MAGIC.to_vec();
        bytes.extend(tail);
        read_all(&bytes);
    }
}

#[test]
fn what_is_no_mcap_file_is_named() {
    let error = read_take(b"Format Version,1.23", "Take 1.csv")
        .unwrap_err()
        .to_string();
    assert!(error.starts_with("Take 1.csv: not an MCAP file"), "{error}");
    assert!(error.contains("\"Format Versi\" (19 bytes)"), "{error}");
    assert!(matches!(
        info(b"", "x"),
        Err(ChannelError::Container(ContainerError::NotMcap { .. }))
    ));
}

#[test]
fn a_cut_file_says_where_and_what() {
    let cut = &TAKE[..TAKE.len() / 2];
    match read_take(cut, "cut.mcap").unwrap_err() {
        ChannelError::Container(ContainerError::Truncated {
            file,
            offset,
            record,
            expected,
            found,
        }) => {
            assert_eq!((file.as_str(), record.as_str()), ("cut.mcap", "chunk"));
            assert_eq!(offset + found, cut.len() as u64);
            assert!(expected > found);
        }
        other => panic!("{other}"),
    }
    // At a record's end nothing looks wrong but that the footer is missing.
    let error = read_take(&TAKE[..data_end(&TAKE)], "cut.mcap")
        .unwrap_err()
        .to_string();
    assert!(error.contains("cut off: the footer"), "{error}");
    let error = read_take(&TAKE[..TAKE.len() - 3], "cut.mcap")
        .unwrap_err()
        .to_string();
    assert!(error.contains("the mark at the end"), "{error}");
}

#[test]
fn a_changed_byte_in_a_chunk_is_found_at_its_chunk() {
    // The first record with the opcode of a chunk, and a byte well inside what it packs.
    let mut start = 8;
    while TAKE[start] != op::CHUNK {
        start += 9 + u64::from_le_bytes(TAKE[start + 1..start + 9].try_into().unwrap()) as usize;
    }
    let mut bytes = TAKE.clone();
    bytes[start + 200] ^= 0x55;
    match read_take(&bytes, "changed.mcap").unwrap_err() {
        ChannelError::Container(ContainerError::Damaged { offset, record, .. }) => {
            assert_eq!((offset, record.as_str()), (start as u64, "chunk"));
        }
        other => panic!("{other}"),
    }
}

/// Reads the small take with one metadata fact replaced.
fn with_fact(record: &str, key: &str, value: &str) -> String {
    let bytes = unchecked(
        &TAKE,
        |name, facts| {
            if name == record {
                facts.insert(key.to_owned(), value.to_owned());
            }
        },
        |_, _| {},
    );
    read_take(&bytes, "x.mcap").unwrap_err().to_string()
}

#[test]
fn metadata_that_contradicts_is_refused_with_its_key() {
    for (key, value) in [
        ("rate_hz", "fast"),
        ("rate_hz", "-1"),
        ("rate_hz", "NaN"),
        ("start_unix_nanos", "-1"),
        ("start_time", "noon"),
        ("samples", "1e3"),
        ("source_up_axis", "x"),
        ("source_length_unit", "furlongs"),
        ("source_rotation", "XYW"),
        ("markers", "[{}]"),
        ("bodies", "{}"),
    ] {
        let error = with_fact("inhand.recording", key, value);
        assert!(error.contains(&format!("key \"{key}\"")), "{key}: {error}");
    }
    assert!(with_fact("inhand.roles", "hand", "Hand").contains("rigid_body"));
    assert!(with_fact("inhand.provenance.1", "inputs", "none").contains("sha256"));
    // As many samples as fit a number, and one more than there are.
    for samples in [u64::MAX.to_string(), "41".to_owned(), "39".to_owned()] {
        let error = with_fact("inhand.recording", "samples", &samples);
        assert!(error.contains("/recording/markers, message"), "{error}");
    }
    let error = with_fact("inhand.recording", "markers", "[]");
    assert!(
        error.contains("expected 0 entries, found 11 entries"),
        "{error}"
    );
    let error = with_fact("inhand.recording", "rate_hz", "21");
    assert!(error.contains("expected the time of sample 1"), "{error}");
}

/// Reads the small take with the third message of a topic replaced.
fn with_message(topic: &str, data: &[u8]) -> String {
    let mut seen = 0;
    let bytes = unchecked(
        &TAKE,
        |_, _| {},
        |found, (_, message)| {
            if found == topic {
                seen += 1;
                if seen == 3 {
                    *message = data.to_vec();
                }
            }
        },
    );
    read_take(&bytes, "x.mcap").unwrap_err().to_string()
}

#[test]
fn messages_that_break_their_promise_are_refused_with_topic_and_number() {
    let place = "x.mcap: /processed/fingertips, message 2: ";
    // No protobuf; no status at all; a thumb of status 9; a measured thumb without a position.
    for data in [
        &[0xFF_u8][..],
        &[],
        &[0x12, 2, 0x10, 9],
        &[0x12, 2, 0x10, 1],
    ] {
        let error = with_message("/processed/fingertips", data);
        assert!(error.starts_with(place), "{error}");
    }
    // A position of NaN.
    let mut thumb = vec![0x12, 13, 0x0A, 9, 0x09];
    thumb.extend(f64::NAN.to_le_bytes());
    thumb.extend([0x10, 1]);
    let error = with_message("/processed/fingertips", &thumb);
    assert!(error.contains("expected finite coordinates"), "{error}");
    // A rotation of length zero.
    let body = [0x12, 6, 0x12, 0, 0x1A, 0, 0x20, 1];
    let error = with_message("/processed/hand", &body);
    assert!(
        error.contains("unit length, found one of length 0"),
        "{error}"
    );
    // A message that is not there.
    let error = with_message("/recording/bodies", b"drop");
    assert!(
        error.contains("/recording/bodies, message 2: expected the time"),
        "{error}"
    );
}

#[test]
fn dictionaries_that_somebody_packed_anew_are_read_as_well() {
    let expected = read_dictionary(&SOUND_DICTIONARY, "d.mcap").unwrap();
    for compression in [None, Some(Compression::Lz4), Some(Compression::Zstd)] {
        let options = WriteOptions::new()
            .compression(compression)
            .chunk_size(Some(2000));
        let bytes = rewritten(&SOUND_DICTIONARY, options, |_, _| {}, |_, _| {});
        let read = read_dictionary(&bytes, "d.mcap").unwrap();
        assert!(read == expected, "{compression:?}");
    }
}

#[test]
fn dictionaries_whose_sizes_disagree_are_refused() {
    // Fields that come again at the end of a message replace the earlier ones.
    let refused = |fields: &[u8]| {
        let bytes = unchecked(
            &DICTIONARY,
            |_, _| {},
            |topic, message| {
                if topic == "/dictionary/model" {
                    message.1.extend(fields);
                }
            },
        );
        read_dictionary(&bytes, "d.mcap").unwrap_err().to_string()
    };
    // Field 14: the object is said to be there, but has no rows.
    let error = refused(&[0x70, 1]);
    assert!(
        error.contains("210 x 3 numbers for the primitives"),
        "{error}"
    );
    assert!(error.contains("found 450"), "{error}");
    // Field 15 (the deviation), in it field 7: a kernel of no width. Messages that come again merge.
    let mut narrow = vec![0x7A, 9, 0x39];
    narrow.extend(0f64.to_le_bytes());
    let error = refused(&narrow);
    assert!(error.contains("positive widths of the kernels"), "{error}");
    // In it field 3: primitives of a sixth part.
    let error = refused(&[0x7A, 4, 0x1A, 2, 0x08, 0]);
    assert!(error.contains("primitives of 5 parts"), "{error}");
    // In it field 12: another number of the covariance.
    let mut more = vec![0x7A, 10, 0x62, 8];
    more.extend(1f64.to_le_bytes());
    let error = refused(&more);
    assert!(error.contains("deviations' covariance"), "{error}");
    // Field 2: samples whose rows no machine can count, with the object or without.
    let samples = [0x10, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x7F];
    let error = refused(&samples);
    assert!(error.contains("expected fewer samples"), "{error}");
    let error = refused(&[&samples[..], &[0x70, 1]].concat());
    assert!(error.contains("expected fewer samples"), "{error}");
}

#[test]
fn sound_files_without_what_is_asked_for_say_what_they_have() {
    let error = read_dictionary(&TAKE, "take.mcap").unwrap_err().to_string();
    assert!(error.starts_with("take.mcap: no dictionary"), "{error}");
    assert!(error.contains("/recording/markers"), "{error}");
    let error = read_take(&DICTIONARY, "d.mcap").unwrap_err().to_string();
    assert!(error.starts_with("d.mcap: no recording"), "{error}");
    assert!(
        error.contains("/dictionary/model") && error.contains("inhand convert"),
        "{error}"
    );
}

#[test]
fn leading_metadata_with_a_huge_length_costs_no_memory() {
    // A length of 4 GiB: refused rather than trusted.
    for body in [&[255; 8][..], &[0, 0, 0, 0, 255, 255, 255, 255]] {
        let head = [&[op::METADATA], &8_u64.to_le_bytes()[..], body].concat();
        let found = read_leading_metadata(&[mcap::MAGIC, &head].concat()[..]).unwrap();
        assert!(found.provenance("a.mcap").unwrap().is_empty());
    }
}
