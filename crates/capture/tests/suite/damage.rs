//! Files damaged at random: an answer or an error, never a panic, never memory without bound.

use inhand_capture::{ReadSettings, roles};
use proptest::prelude::*;

use super::text::{Motive, body, marker};

/// Pieces that damaged files tend to have in the wrong place.
const PIECES: [&[u8]; 16] = [
    b"",
    b"\0",
    b"\xFF\xFE",
    b"\xEF\xBB\xBF",
    b"\"",
    b"\n",
    b"\r",
    b",,,,",
    b"\t",
    b"NaN",
    b"1e999",
    b"-9007199254740993",
    b"99999999999999999999",
    b"Frame",
    b"Position",
    "上午".as_bytes(),
];

fn motive() -> Vec<u8> {
    let columns = [body("Hand"), marker("Thumb"), marker("Unlabeled 3")].concat();
    let rows: Vec<String> = (0..6)
        .map(|k| format!("{k},0.0{k},0,0,0.6,0.8,1.5,2,3,0.25,,,1,2,3"))
        .collect();
    let rows: Vec<&str> = rows.iter().map(String::as_str).collect();
    Motive::new(columns, &rows).text().into_bytes()
}

fn qualisys() -> Vec<u8> {
    b"NO_OF_FRAMES\t2\nFREQUENCY\t100\nDATA_INCLUDED\t3D\nMARKER_NAMES\ta_tip\tb\n\
      Frame\tTime\ta_tip X\ta_tip Y\ta_tip Z\tb X\tb Y\tb Z\n\
      1\t0.0\t1\t2\t3\t4\t5\t6\n2\t0.01\t1\t2\t3\tnan\tnan\tnan\n"
        .to_vec()
}

fn trc() -> Vec<u8> {
    b"PathFileType\t4\t(X/Y/Z)\ta.trc\nDataRate\tNumFrames\tNumMarkers\tUnits\n100\t2\t2\tmm\n\
      Frame#\tTime\ta_tip\t\t\tb\n\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n\n\
      1\t0.0\t1\t2\t3\t4\t5\t6\n2\t0.01\t1\t2\t3\t\t\t\n"
        .to_vec()
}

fn row_typed() -> Vec<u8> {
    b"comment,\"x\"\nrighthanded\ninfo,version,1.1\ninfo,framecount,3\n\
      rigidbody,\"Hand\",1,1,0.1,0.2,0.3\n\
      frame,0,0.0,1,1,1,2,3,0,0,0,1,9,9,9,2,1.5,2.5,3.5,3,Hand,-1,-2,-3,55,Marker-55\n\
      rigidbody,0,0.0,\"Hand\",1,0,1,1.4,2.4,3.4,3,1.5,2.5,3.5,1,0.75,0.01\n\
      frame,1,0.01,0,0\nrigidbody,1,0.01,\"Hand\",1,1,1,1.4,2.4,3.4,3,NAN,NAN,NAN,0,0,0\n\
      frame,3,0.03,0,1,0,0,1,0,\n"
        .to_vec()
}

fn whole_files() -> [Vec<u8>; 4] {
    [motive(), qualisys(), trc(), row_typed()]
}

/// Reads, and where that works resolves roles: all that matters is that both return.
fn survives(bytes: &[u8]) {
    if let Ok(recording) = inhand_capture::read(bytes, "a.csv", &ReadSettings::default()) {
        assert!(recording.len() <= 100_000 + 11 * bytes.len());
        let _ = roles::resolve(&recording, &roles::RoleSettings::default());
        let mut text = Vec::new();
        inhand_capture::motive::write(&recording, &mut text).expect("memory takes all");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(400) })]

    #[test]
    fn pieces_put_in_taken_out_and_doubled(
        whole in prop::sample::select(whole_files().to_vec()),
        changes in prop::collection::vec(
            (any::<prop::sample::Index>(), 0_usize..12, 0..PIECES.len()),
            1..6,
        ),
    ) {
        let mut bytes = whole;
        for (at, remove, piece) in changes {
            let at = at.index(bytes.len() + 1).min(bytes.len());
            let end = (at + remove).min(bytes.len());
            bytes.splice(at..end, PIECES[piece].iter().copied());
        }
        survives(&bytes);
    }

    #[test]
    fn noise_behind_a_true_beginning(
        start in prop::sample::select(vec![
            &b""[..],
            b"righthanded\nframe,0,0.0,",
            b"info,version,1.1\nrigidbody,\"a\",1,",
            b"Format Version,1.23\n",
            b"FREQUENCY\t100\n",
            b"PathFileType\t4\nDataRate\tUnits\n100\tm\n",
            b"PathFileType\t4\nDataRate\tUnits\n100\tm\nFrame#\tTime\n",
        ]),
        noise in prop::collection::vec(any::<u8>(), 0..400),
    ) {
        survives(&[start, &noise].concat());
    }
}

#[test]
fn every_cut() {
    for whole in whole_files() {
        for end in 0..=whole.len() {
            survives(&whole[..end]);
        }
    }
}

#[test]
fn every_byte_changed() {
    for whole in whole_files() {
        for at in 0..whole.len() {
            let mut bytes = whole.clone();
            for byte in [0, b',', b'\t', b'"', b'\n', 0x80, b'9', b'X'] {
                bytes[at] = byte;
                survives(&bytes);
            }
        }
    }
}

#[test]
fn a_file_of_line_ends_reserves_next_to_nothing() {
    let mut bytes = motive();
    bytes.extend(std::iter::repeat_n(b'\n', 4 << 20));
    let recording = inhand_capture::read(&bytes, "a.csv", &ReadSettings::default()).unwrap();
    assert_eq!(recording.len(), 6);
}

#[test]
fn binary_files_with_the_right_name_are_refused() {
    let mut noise = 1_u64;
    let mut next = || {
        noise = noise
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (noise >> 56) as u8
    };
    for start in [
        &b""[..],
        b"\x89PNG\r\n\x1A\n",
        b"PK\x03\x04",
        b"\x1F\x8B\x08",
        b"\0\0\0\0",
    ] {
        let mut bytes = start.to_vec();
        bytes.extend((0..100_000).map(|_| next()));
        let error = inhand_capture::read(&bytes, "a.csv", &ReadSettings::default()).unwrap_err();
        let message = error.to_string();
        assert!(
            message.starts_with("a.csv: not a capture file"),
            "{message}"
        );
        assert!(message.len() < 500, "{message}");
    }
    // Behind a beginning that is right, it is the first byte that is not that counts.
    for whole in whole_files() {
        let lines = whole.iter().filter(|&&byte| byte == b'\n').count();
        let mut bytes = whole;
        bytes.extend([0, 0xFF, b'\n', 0]);
        let error = inhand_capture::read(&bytes, "a.csv", &ReadSettings::default()).unwrap_err();
        let place = format!("a.csv, line {}, column 1", lines + 1);
        assert!(error.to_string().starts_with(&place), "{error}");
    }
}

#[test]
fn lines_of_megabytes_are_refused_by_their_number() {
    for whole in whole_files() {
        let lines = whole.iter().filter(|&&byte| byte == b'\n').count();
        for byte in [b'7', b',', b'\t', b' ', b'"', 0] {
            let mut bytes = whole.clone();
            bytes.extend(std::iter::repeat_n(byte, 9 << 20));
            let error = inhand_capture::read(&bytes, "a.csv", &ReadSettings::default());
            let message = error.unwrap_err().to_string();
            let expected = format!("a.csv, line {}: expected lines of at most", lines + 1);
            assert!(message.starts_with(&expected), "{message}");
        }
    }
}

#[test]
fn counts_that_cannot_be_are_findings() {
    for (whole, count, key) in [
        (qualisys(), "NO_OF_FRAMES\t2", "NO_OF_FRAMES"),
        (trc(), "100\t2\t2", "NumFrames"),
        (row_typed(), "framecount,3", "framecount"),
    ] {
        for absurd in ["99999999999999999999", "-1", "many", "18446744073709551615"] {
            let text = String::from_utf8(whole.clone()).unwrap();
            let text = match key {
                "NumFrames" => text.replace(count, &format!("100\t{absurd}\t2")),
                _ => text.replace(count, &format!("{}{absurd}", &count[..count.len() - 1])),
            };
            let recording =
                inhand_capture::read(text.as_bytes(), "a.csv", &ReadSettings::default()).unwrap();
            let said = recording
                .findings
                .iter()
                .filter(|finding| finding.place == key)
                .count();
            assert_eq!(said, 1, "{key} {absurd}: {:?}", recording.findings);
        }
    }
}
