//! A take in blocks is the take read whole.

use std::io::Read;

use inhand_capture::{Blocks, CaptureError, Extent, ReadSettings, has_even_rows};
use inhand_model::{Finding, Pose, Position, Recording};
use proptest::prelude::*;

use super::text::{Motive, body, marker, quality};

/// Hands out at most so many bytes at a time.
struct Trickle<'a>(&'a [u8], usize);

impl Read for Trickle<'_> {
    fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
        let length = out.len().min(self.1);
        self.0.read(&mut out[..length])
    }
}

fn blocks(bytes: &[u8], step: usize) -> Result<(Vec<Recording>, Vec<Finding>), CaptureError> {
    let mut extent = Extent::default();
    extent.add(bytes);
    let input = Trickle(bytes, step);
    let mut blocks = Blocks::open(input, extent, "take.csv", &ReadSettings::default())?;
    let mut all = Vec::new();
    while let Some(block) = blocks.next_block()? {
        all.push(block);
    }
    Ok((all, blocks.findings()))
}

/// Every number of samples `range`, NaN where there is none, as bits.
fn bits(recording: &Recording) -> Vec<Vec<[u64; 10]>> {
    let mut all = Vec::new();
    for marker in &recording.markers {
        let quality = |k: usize| marker.quality.as_ref().map_or(0.0, |q| q[k]);
        let row = |k| {
            let [x, y, z] = marker
                .track
                .get(k)
                .map_or([f64::NAN; 3], Position::to_array);
            [x, y, z, quality(k), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0].map(f64::to_bits)
        };
        all.push((0..recording.len()).map(row).collect());
    }
    for body in &recording.bodies {
        let error = |k: usize| body.marker_error_m.as_ref().map_or(0.0, |e| e[k]);
        let row = |k| {
            let pose = body.track.get(k);
            let [x, y, z] = pose.map_or([f64::NAN; 3], |p| p.origin().to_array());
            let [a, b, c, d] = pose.map_or([f64::NAN; 4], Pose::quaternion_xyzw);
            [x, y, z, a, b, c, d, error(k), 0.0, 0.0].map(f64::to_bits)
        };
        all.push((0..recording.len()).map(row).collect());
    }
    all
}

fn assert_same(bytes: &[u8], step: usize) -> usize {
    let whole = inhand_capture::read(bytes, "take.csv", &ReadSettings::default());
    let (whole, parts) = match (whole, blocks(bytes, step)) {
        (Ok(whole), Ok(parts)) => (whole, parts),
        (Err(whole), Err(parts)) => {
            assert_eq!(whole.to_string(), parts.to_string());
            return 0;
        }
        (whole, parts) => panic!("{whole:?}\n{parts:?}"),
    };
    let (parts, findings) = parts;
    assert_eq!(findings, whole.findings);
    let mut joined = vec![Vec::new(); whole.markers.len() + whole.bodies.len()];
    let mut samples = 0;
    for part in &parts {
        assert_eq!(part.clock, whole.clock.starting_at(samples));
        assert!(part.len() <= 16 * 1024, "{}", part.len());
        samples += part.len();
        for (all, more) in joined.iter_mut().zip(bits(part)) {
            all.extend(more);
        }
    }
    assert_eq!(samples, whole.len());
    assert!(joined == bits(&whole), "the same numbers");
    parts.len()
}

fn take(rows: usize, jumps: &[(usize, i64)]) -> Vec<u8> {
    let columns = [
        body("Hand"),
        quality("Rigid Body", "Hand", "B0", "Mean Marker Error"),
        marker("Thumb"),
        quality("Marker", "Thumb", "M0", "Marker Quality"),
    ];
    let mut frame = 7;
    let rows: Vec<String> = (0..rows)
        .map(|k| {
            frame += 1 + jumps
                .iter()
                .find(|jump| jump.0 == k)
                .map_or(0, |jump| jump.1);
            let time = (frame - 8) as f64 / 100.0;
            match k % 97 {
                13 => format!("{frame},{time:.6},,,,,,,,,1.5,,,0.5"),
                14 => format!("{frame},{time:.6},,,,,,,,,,,,"),
                _ => format!("{frame},{time:.6},0,0,0.6,0.8,{k}.5,2,3,0.25,1,2,{k},0.5"),
            }
        })
        .collect();
    let rows: Vec<&str> = rows.iter().map(String::as_str).collect();
    Motive::new(columns.concat(), &rows).text().into_bytes()
}

#[test]
fn long_takes_and_long_jumps() {
    assert!(assert_same(&take(60_000, &[]), usize::MAX) > 2);
    let jumps = [(1, 3), (5_000, 60_000), (5_001, 1), (29_999, 16_384)];
    assert!(assert_same(&take(30_000, &jumps), 100_003) > 5);
    let mut marked = b"\xEF\xBB\xBF".to_vec();
    marked.extend(take(3000, &[(2999, 9)]));
    assert_same(&marked, 4096);
    // Too far for one take: the same words.
    assert_eq!(assert_same(&take(300, &[(200, 900_000)]), 4096), 0);
}

#[test]
fn what_is_read_in_blocks() {
    assert!(has_even_rows(b"Format Version,1.23"));
    assert!(has_even_rows(b"\xEF\xBB\xBFNO_OF_FRAMES\t3"));
    assert!(has_even_rows(b"PathFileType\t4"));
    for other in [&b"comment,\"x\""[..], b"\x89MCAP0\r\n", b"", b"Format"] {
        assert!(!has_even_rows(other));
    }
}

#[test]
fn a_disk_that_fails_is_an_error() {
    struct Broken<'a>(&'a [u8]);
    impl Read for Broken<'_> {
        fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
            match self.0.read(out)? {
                0 => Err(std::io::Error::other("the disk is gone")),
                read => Ok(read),
            }
        }
    }
    let text = take(40_000, &[]);
    let mut extent = Extent::default();
    extent.add(&text);
    let mut blocks =
        Blocks::open(Broken(&text), extent, "a.csv", &ReadSettings::default()).unwrap();
    let error = loop {
        match blocks.next_block() {
            Ok(block) => assert!(block.is_some(), "the end must not look like one"),
            Err(error) => break error,
        }
    };
    assert_eq!(error.to_string(), "a.csv: cannot read on: the disk is gone");
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(60) })]

    #[test]
    fn every_file_reads_the_same_both_ways(
        rows in 1_usize..400,
        jumps in prop::collection::vec((0_usize..400, 1_i64..200), 0..4),
        cut in any::<prop::sample::Index>(),
        whole in any::<bool>(),
        step in 1_usize..5000,
    ) {
        let mut text = take(rows, &jumps);
        if !whole {
            text.truncate(cut.index(text.len()));
        }
        if has_even_rows(&text) {
            assert_same(&text, step);
        }
    }
}

/// A file that only starts with its header, which has a row beyond the limit.
#[test]
fn a_header_beyond_the_limit_is_refused_with_the_limit() {
    let long = "\tT".repeat(9 << 20);
    let facts = "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\n100\t100\t1\t1\tmm\n";
    for (file, place, missing, text) in [
        (
            "a.csv",
            "a.csv, line 2: ",
            "axis labels",
            format!(
                "Format Version,1.23,Length Units,Meters\n{}\n",
                long.replace('\t', ",")
            ),
        ),
        (
            "a.tsv",
            "a.tsv, line 2: ",
            "MARKER_NAMES",
            format!("FREQUENCY\t100\nMARKER_NAMES{long}\n"),
        ),
        (
            "a.trc",
            "a.trc, line 4: ",
            "",
            format!("PathFileType\t4\t(X/Y/Z)\ta.trc\n{facts}Frame#\tTime{long}\n"),
        ),
    ] {
        let bytes = text.as_bytes();
        let settings = ReadSettings::default();
        let whole = inhand_capture::read(bytes, file, &settings).unwrap_err();
        let mut extent = Extent::default();
        extent.add(bytes);
        let blocks = Blocks::open(bytes, extent, file, &settings).err().unwrap();
        for message in [whole.to_string(), blocks.to_string()] {
            assert!(message.starts_with(place), "{message}");
            assert!(message.contains(missing), "{message}");
            let limit = " within the first 16777216 bytes of the file, found a longer header: ";
            assert!(message.contains(limit), "{message}");
            assert!(
                message.ends_with("export fewer markers and bodies"),
                "{message}"
            );
        }
    }
}
