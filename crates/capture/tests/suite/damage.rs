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
        whole in prop::sample::select(vec![motive(), qualisys(), trc()]),
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
    for whole in [motive(), qualisys(), trc()] {
        for end in 0..=whole.len() {
            survives(&whole[..end]);
        }
    }
}

#[test]
fn every_byte_changed() {
    for whole in [motive(), qualisys(), trc()] {
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
