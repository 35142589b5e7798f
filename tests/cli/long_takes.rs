//! Memory that long takes need.

use std::fs::{self, File};
use std::io::{BufWriter, Write as _};
use std::process::Command;

use crate::support::{Bench, stderr};

/// Address space of a command, KiB: twice what it needs for the numbers of a short take, and less than the file has.
const LIMIT_KIB: u32 = 96 << 10;

/// Bytes of text behind each row, in a column that is not read.
const NOTE_BYTES: usize = 220 << 10;

#[test]
fn a_vendor_file_takes_the_memory_of_its_samples() {
    let bench = Bench::empty();
    let fixture = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../fixtures/cube/test/cube_test_01.csv"
    );
    let long = bench.path("long.csv");
    let text = fs::read_to_string(fixture).unwrap();
    let mut out = BufWriter::new(File::create(&long).unwrap());
    let mut head = ["", "", "Note", "Notes", "N", "Text", "Words"].into_iter();
    let note = "x".repeat(NOTE_BYTES);
    for line in text.lines() {
        let cell = match head.next() {
            Some(cell) => cell,
            None => &note,
        };
        let comma = if cell.is_empty() { "" } else { "," };
        write!(out, "{line}{comma}{cell}\r\n").unwrap();
    }
    drop(out);
    assert!(fs::metadata(&long).unwrap().len() > u64::from(LIMIT_KIB) << 10);

    let learn = "learn long.csv -o d.mcap --stride 25 --rank 2 --max-iterations 1";
    let learn: Vec<_> = learn.split(' ').collect();
    for args in [
        &["check", "long.csv"][..],
        &["convert", "long.csv", "-o", "take.mcap"],
        &["process", "long.csv", "-o", "processed.mcap"],
        &["clean", "long.csv", "--repair", "-o", "clean.mcap"],
        &["export", "long.csv", "-o", "take.parquet"],
        &learn,
    ] {
        let limited = format!("ulimit -v {LIMIT_KIB}; exec \"$@\"");
        let output = Command::new("sh")
            .args(["-c", &limited, "sh", env!("CARGO_BIN_EXE_inhand")])
            .args(args)
            .args(["--threads", "1"])
            .current_dir(bench.folder.path())
            .output()
            .unwrap();
        let code = output.status.code();
        assert_eq!(code, Some(0), "{args:?}\n{}", stderr(&output));
    }
}
