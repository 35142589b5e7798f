//! Takes that `convert` refuses, and its messages.

use crate::support::{Bench, stderr};

const HEADER: &str = "Format Version,1.23,Take Name,a,Export Frame Rate,100,Length Units,Meters\n\
                      ,Type,Marker,Marker,Marker\n,Name,Thumb,Thumb,Thumb\n,ID,A,A,A\n\
                      ,,Position,Position,Position\nFrame,Time (Seconds),X,Y,Z\n";

/// The message of a refusal, which leaves no file behind.
fn refusal(bench: &Bench, name: &str, bytes: &[u8]) -> String {
    bench.write(name, bytes);
    let before = bench.files(".").len();
    let output = bench.inhand(&["convert", name, "-o", "out.mcap"]);
    assert_eq!(output.status.code(), Some(1), "{name}");
    assert_eq!(
        bench.files(".").len(),
        before,
        "{name}: nothing is left behind"
    );
    stderr(&output)
}

#[test]
fn files_that_cannot_be_read_say_where_and_leave_nothing() {
    let bench = Bench::empty();
    let with = |row: &[u8]| [HEADER.as_bytes(), b"0,0,1,2,3\n", row].concat();
    for (name, bytes, expected) in [
        (
            "long.csv",
            with(&vec![b'7'; 6 << 20]),
            "line 8: expected lines of at most 4194304 bytes",
        ),
        (
            "nul.csv",
            with(b"1,0.01,1,\0,3\n"),
            "line 8, column 4 (\"Thumb\" Position Y)",
        ),
        (
            "cut.csv",
            with(b"1,0.01,1\n"),
            "line 8: expected 5 cells, found 3: the row is cut off",
        ),
        (
            "binary.csv",
            vec![0x89, 0, 0xFF, 0x10],
            "not a capture file",
        ),
        ("empty.csv", Vec::new(), "not a capture file"),
        (
            "header.csv",
            HEADER.as_bytes()[..150].to_vec(),
            "the header is cut",
        ),
        (
            "rows.csv",
            HEADER.as_bytes().to_vec(),
            "followed by no samples",
        ),
        ("jump.csv", with(b"9000000,,1,2,3\n"), "cannot be one take"),
        (
            "latin.csv",
            HEADER
                .replace("Thumb", "Daum?")
                .into_bytes()
                .iter()
                .map(|&b| if b == b'?' { 0xE9 } else { b })
                .collect(),
            "line 3: expected UTF-8 text, found the byte 0xE9",
        ),
        (
            "old.csv",
            b"righthanded\nframe,0,0,4000000000,1\n".to_vec(),
            "line 2: expected 44000000004 cells, found 5",
        ),
    ] {
        let message = refusal(&bench, name, &bytes);
        assert!(message.contains(expected), "{name}: {message}");
        assert!(message.len() < 1000, "{name}: {message}");
    }
}

#[test]
fn doubts_are_said_and_kept() {
    let bench = Bench::empty();
    let header = HEADER.replace("Length Units", "Total Exported Frames,many,Length Units");
    bench.write("a.csv", format!("{header}0,0,1,2,3\n4,0.04,1,,3\n"));
    let output = bench.inhand(&["convert", "a.csv", "-o", "a.mcap"]);
    assert_eq!(output.status.code(), Some(0));
    let said = stderr(&output);
    for words in [
        "expected a count, found \"many\"",
        "jumps 1 times and leaves out 3 frames",
        "some of its cells are blank in 1 rows, first on line 8",
        "100 Hz",
        "5 samples, 0.05 s",
    ] {
        assert!(said.contains(words), "{said}");
    }
    // Again from the same file, without being told to replace.
    bench.ok(&["convert", "a.csv", "-o", "a.mcap"]);
    bench.write("b.csv", format!("{HEADER}0,0,1,2,3\n"));
    let other = bench.inhand(&["convert", "b.csv", "-o", "a.mcap"]);
    assert_eq!(other.status.code(), Some(2));
    bench.ok(&["convert", "b.csv", "-o", "a.mcap", "--force"]);
}

#[test]
fn events_that_a_vendor_file_states_are_in_what_is_made_of_it() {
    let bench = Bench::empty();
    let header = "NO_OF_FRAMES\t3\r\nFREQUENCY\t100\r\nTIME_STAMP\t2024-05-06, 14:15:16.250\r\n\
                  DATA_INCLUDED\t3D\r\nEVENT\tgrasp\t12\t0.11000\r\nMARKER_NAMES\tThumb\r\n";
    // A range of its capture: the first frame is the eleventh.
    let rows = "11\t0.10\t1\t2\t3\r\n12\t0.11\t1\t2\t4\r\n13\t0.12\t1\t2\t5\r\n";
    bench.write("take.tsv", format!("{header}{rows}"));
    // Read block by block.
    bench.ok(&["convert", "take.tsv", "-o", "take.mcap"]);
    let listed = bench.ok(&["annotate", "list", "take.mcap"]);
    let words: Vec<&str> = listed.split_whitespace().collect();
    assert_eq!(words, ["1", "0.01", "..", "0.01", "label=grasp"]);
    let info = bench.ok(&["info", "take.mcap"]);
    assert!(info.contains("1715004916350000000"), "{info}");
    // Read whole.
    bench.ok(&[
        "export",
        "take.tsv",
        "-o",
        "bids",
        "--bids",
        "sub=01,task=rotate",
    ]);
    let events = bench.bytes("bids/sub-01/motion/sub-01_task-rotate_events.tsv");
    assert_eq!(events, b"onset\tduration\tlabel\n0.01\t0\tgrasp\n");
}
