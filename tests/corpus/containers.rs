//! Files of every writer, copied, cut off and damaged. What is in a file is read by the mcap crate's
//! own reader, which shares nothing with what copies.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use inhand_channels::info;
use inhand_container::{Interval, Packing, Selection, Source, recover, select, verify};
use mcap::records::{Record, op};

use crate::files::{is_damaged, mcap_files};
use crate::{corpus, inhand, ok, stderr, text};

/// Records of the data, in order, each in words; chunks are looked into.
fn records(bytes: &[u8]) -> Vec<String> {
    let mut records = Vec::new();
    for record in mcap::read::ChunkFlattener::new(bytes).expect("the file is an MCAP file") {
        match record.expect("every record can be read") {
            Record::DataEnd(_) => break,
            Record::MessageIndex(_) => {}
            record => records.push(format!("{record:?}")),
        }
    }
    records
}

/// The same with the schemas and channels at its end that the summary alone lists.
fn all_records(bytes: &[u8]) -> Vec<String> {
    let mut all = records(bytes);
    let flat = mcap::read::ChunkFlattener::new(bytes).expect("the file is an MCAP file");
    let summary = (flat.map(|record| record.expect("every record can be read")))
        .skip_while(|record| !matches!(record, Record::DataEnd(_)))
        .filter(|record| matches!(record, Record::Schema { .. } | Record::Channel(_)));
    for record in summary.map(|record| format!("{record:?}")) {
        if !all.contains(&record) {
            all.push(record);
        }
    }
    all
}

/// How often each record is there.
fn counted(records: Vec<String>) -> BTreeMap<String, usize> {
    let mut counts = BTreeMap::new();
    for record in records {
        *counts.entry(record).or_default() += 1;
    }
    counts
}

fn selected(bytes: &[u8], selection: &Selection<'_>) -> Vec<u8> {
    let mut out = Vec::new();
    let mut source = Source::open("in.mcap", Cursor::new(bytes)).expect("the file opens");
    let selected = select(&mut source, &mut out, selection).expect("the file is sound");
    let mut written = Source::open("out.mcap", Cursor::new(&out)).expect("the output opens");
    verify(&mut written, &selected.written).expect("the output reads back");
    drop(written);
    out
}

fn sound_files() -> Option<Vec<(PathBuf, Vec<u8>)>> {
    let files = mcap_files(&corpus()?.join("mcap"));
    let sound = files.into_iter().filter(|file| !is_damaged(file));
    let read = |file: PathBuf| {
        let bytes = std::fs::read(&file).expect("files of the corpus can be read");
        (file, bytes)
    };
    Some(sound.map(read).collect())
}

#[test]
fn every_file_is_listed_and_copied_record_by_record() {
    let Some(files) = sound_files() else { return };
    assert!(files.len() >= 416 + 22 + 3, "{} files", files.len());
    let by_name = |name: &str| {
        files
            .iter()
            .filter(|(file, _)| text(file).contains(name))
            .count()
    };
    assert_eq!(by_name("/conformance/"), 416);
    for (file, bytes) in &files {
        let shown = text(file);
        let listed = info(bytes, shown).unwrap_or_else(|error| panic!("{shown}: {error}"));
        assert!(listed.problem.is_none(), "{shown}: {:?}", listed.problem);
        let before = all_records(bytes);
        let stretch = Selection {
            keep: vec![Interval::new(0, Some(u64::MAX))],
            ..Selection::default()
        };
        for selection in [Selection::default(), stretch] {
            let copy = selected(bytes, &selection);
            assert!(records(&copy) == before, "{shown}: a record has changed");
            let copied = info(&copy, shown).expect("the copy is an MCAP file");
            assert!(copied.problem.is_none() && copied.has_summary, "{shown}");
            assert_eq!(copied.channels, listed.channels, "{shown}");
            let summary = mcap::Summary::read(&copy).expect("the summary can be read");
            let stats = summary.and_then(|summary| summary.stats);
            let stats = stats.expect("a summary has statistics");
            // Messages that no channel is defined for are records all the same.
            let all = listed.messages + listed.messages_without_channel;
            assert_eq!(stats.message_count, all, "{shown}");
        }
    }
}

#[test]
fn packing_anew_changes_no_record() {
    let Some(files) = sound_files() else { return };
    for (file, bytes) in &files {
        // Chunks hold what lay outside them, so that only the order against others may change.
        let before = counted(all_records(bytes));
        for packing in [Packing::Zstd, Packing::Lz4, Packing::None] {
            let selection = Selection {
                packing: Some(packing),
                ..Selection::default()
            };
            let after = counted(records(&selected(bytes, &selection)));
            assert!(after == before, "{}: {packing:?}", file.display());
        }
    }
}

#[test]
fn the_command_copies_files_of_every_kind() {
    let Some(corpus) = corpus() else { return };
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("out.mcap");
    let files = [
        "ros2_mocap/mocap4r2.mcap",
        "ros2_mocap/pose_stamped.mcap",
        "crate/zstd_chunk_with_padding.mcap",
        "crate/uncompressed.mcap",
        "crate/compressed.mcap",
        "rosbag2/rosbag2_py/test/resources/mcap/wbag/wbag_0.mcap",
        "conformance/OneAttachment/OneAttachment-ax-pad-st-sum.mcap",
        "conformance/TenMessages/TenMessages.mcap",
    ];
    for file in files {
        let input = corpus.join("mcap").join(file);
        ok(&["cut", text(&input), "-o", text(&output), "--force"]);
        let bytes = std::fs::read(&input).unwrap();
        let copy = std::fs::read(&output).unwrap();
        assert!(records(&copy) == records(&bytes), "{file}");
    }
}

#[test]
fn a_cut_leaves_out_what_lies_outside_and_nothing_else() {
    let Some(corpus) = corpus() else { return };
    for file in [
        "ros2_mocap/mocap4r2.mcap",
        "crate/uncompressed.mcap",
        "crate/compressed.mcap",
    ] {
        let bytes = std::fs::read(corpus.join("mcap").join(file)).unwrap();
        let times = |bytes: &[u8]| -> Vec<(u64, u16, u32)> {
            (mcap::MessageStream::new(bytes).unwrap())
                .map(|message| {
                    let message = message.unwrap();
                    (message.log_time, message.channel.id, message.sequence)
                })
                .collect()
        };
        let all = times(&bytes);
        let first = all.iter().map(|(time, ..)| *time).min().unwrap();
        let last = all.iter().map(|(time, ..)| *time).max().unwrap();
        let (from, to) = (first + (last - first) / 3, first + (last - first) / 2);
        let selection = Selection {
            keep: vec![Interval::new(from, Some(to))],
            latch: &|_| None,
            ..Selection::default()
        };
        let expected: Vec<_> = (all.iter().filter(|(time, ..)| (from..to).contains(time)))
            .copied()
            .collect();
        assert!(!expected.is_empty() && expected.len() < all.len());
        assert_eq!(times(&selected(&bytes, &selection)), expected, "{file}");
    }
}

/// Files small enough to be damaged at many places, with checksums over all their messages.
fn chunked_files(corpus: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let files = mcap_files(&corpus.join("mcap"));
    let mut chosen: Vec<(PathBuf, Vec<u8>)> = Vec::new();
    for file in files {
        let bytes = std::fs::read(&file).unwrap();
        let name = text(&file);
        let small = bytes.len() < 20_000 || name.contains("ros2_mocap");
        let conformance = name.contains("/conformance/");
        if is_damaged(&file)
            || !small
            || (conformance && !name.contains("-ch-chx-mx-pad-rch-rsh-st-sum"))
        {
            continue;
        }
        chosen.push((file, bytes));
    }
    assert!(chosen.len() >= 10, "{} files", chosen.len());
    chosen
}

/// What of a recovered file the sound one does not have.
fn invented(sound: &[u8], recovered: &[u8]) -> Vec<String> {
    let original = counted(all_records(sound));
    let mut invented = counted(records(recovered));
    invented.retain(|record, count| {
        !record.starts_with("Header") && original.get(record).copied().unwrap_or(0) < *count
    });
    invented
        .into_keys()
        .map(|record| record.chars().take(200).collect())
        .collect()
}

fn recovered(bytes: &[u8]) -> Option<(Vec<u8>, inhand_container::Recovered)> {
    let mut out = Vec::new();
    let recovered = recover("damaged.mcap", Cursor::new(bytes), &mut out, false, |_| {
        None
    })
    .ok()?;
    let mut written = Source::open("out.mcap", Cursor::new(&out)).expect("the output opens");
    verify(&mut written, &recovered.written).expect("the output reads back");
    drop(written);
    Some((out, recovered))
}

#[test]
fn a_sound_file_loses_nothing_when_it_is_recovered() {
    let Some(files) = sound_files() else { return };
    for (file, bytes) in &files {
        let (out, recovered) = recovered(bytes).expect("a sound file can be recovered");
        if text(file).ends_with("zstd_chunk_with_padding.mcap") {
            // A chunk alone: nothing says of which channel its messages are.
            assert_eq!(recovered.without_channel.values().sum::<u64>(), 12);
            continue;
        }
        assert!(!recovered.is_lossy(), "{}: {recovered:#?}", file.display());
        assert!(records(&out) == all_records(bytes), "{}", file.display());
    }
}

#[test]
fn a_cut_file_gives_whole_records_from_before_the_cut() {
    let Some(corpus) = corpus() else { return };
    for (file, bytes) in chunked_files(&corpus) {
        let cuts = if bytes.len() < 20_000 { 60 } else { 12 };
        let step = (bytes.len() / cuts).max(1);
        let mut most = 0;
        for end in (8..bytes.len()).step_by(step) {
            let Some((out, recovered)) = recovered(&bytes[..end]) else {
                panic!("{}: nothing from {end} bytes", file.display())
            };
            assert_eq!(
                invented(&bytes, &out),
                [""; 0],
                "{}: cut at {end}",
                file.display()
            );
            // More of the file never gives less.
            assert!(
                recovered.written.messages >= most,
                "{}: {end}",
                file.display()
            );
            most = recovered.written.messages;
            assert!(
                recovered.is_lossy() || !recovered.repaired.is_empty(),
                "{}: cut at {end}",
                file.display()
            );
        }
    }
}

#[test]
fn a_changed_byte_never_changes_what_is_recovered() {
    let Some(corpus) = corpus() else { return };
    for (file, bytes) in chunked_files(&corpus) {
        let outside = outside_chunks(&bytes);
        let summed = states_data_sum(&bytes);
        // Comparing large files takes its time.
        let places = if bytes.len() < 20_000 { 61 } else { 7 };
        let step = (bytes.len() / places).max(1);
        for place in (8..bytes.len()).step_by(step) {
            for change in [0x01, 0x80, 0xff] {
                let mut damaged = bytes.clone();
                damaged[place] ^= change;
                let Some((out, recovered)) = recovered(&damaged) else {
                    continue;
                };
                let invented = invented(&bytes, &out);
                // A record outside chunks has no checksum of its own.
                let outside = outside(place) || !recovered.doubtful.is_empty();
                let unchecked = outside && (recovered.is_lossy() || !summed);
                assert!(
                    invented.is_empty() || unchecked,
                    "{}: byte {place} ^ {change}: {invented:#?}",
                    file.display()
                );
            }
        }
    }
}

/// Whether a file has a checksum over all its data.
fn states_data_sum(bytes: &[u8]) -> bool {
    mcap::read::LinearReader::new(bytes)
        .expect("the file is an MCAP file")
        .any(|record| matches!(record, Ok(Record::DataEnd(end)) if end.data_section_crc != 0))
}

/// Whether a byte of the data is in no chunk with a checksum.
fn outside_chunks(bytes: &[u8]) -> impl Fn(usize) -> bool + use<> {
    let mut ranges = Vec::new();
    let mut offset = 8;
    while let Some(&[opcode, ref length @ ..]) = bytes[offset..].first_chunk::<9>() {
        let end = offset + 9 + u64::from_le_bytes(*length) as usize;
        // That a chunk is one is in no checksum of its own; some writers make none at all.
        let sum = offset + 9 + 24..offset + 9 + 28;
        if opcode == op::CHUNK && bytes[sum] != [0; 4] {
            ranges.push(offset..offset + 1);
        } else if opcode != op::DATA_END {
            ranges.push(offset..end);
        }
        if opcode == op::DATA_END {
            break;
        }
        offset = end;
    }
    move |place| ranges.iter().any(|range| range.contains(&place))
}

#[test]
fn the_file_that_was_never_closed_gives_what_it_has() {
    let Some(corpus) = corpus() else { return };
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("out.mcap");
    let input = corpus.join("mcap/crate/chunk_not_closed.mcap");
    let refused = inhand(&["cut", text(&input), "-o", text(&output)]);
    assert_eq!(refused.status.code(), Some(1), "{}", stderr(&refused));
    assert!(!output.exists());
    let saved = inhand(&["recover", text(&input), "-o", text(&output)]);
    assert_eq!(saved.status.code(), Some(3), "{}", stderr(&saved));
    ok(&["info", text(&output)]);
}
