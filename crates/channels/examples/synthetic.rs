//! Writes a take and a dictionary made in memory, to look at in a viewer:
//! `cargo run --release -p inhand-channels --example synthetic FOLDER [MCAP...]`.
//!
//! Lists the MCAP files given after the folder.

#![expect(
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "a program to run by hand"
)]

#[path = "../tests/common/mod.rs"]
mod common;

use std::fs;
use std::io::Cursor;
use std::path::Path;
use std::time::Instant;

use inhand_channels::{TakeFile, Views, info, read_take, write_dictionary, write_take};

fn main() {
    let mut arguments = std::env::args().skip(1);
    let folder = arguments.next().expect("a folder to write to");
    let folder = Path::new(&folder);
    fs::create_dir_all(folder).unwrap();

    let take = common::take(12_000, 100.0);
    let segments = common::segments(&take);
    let generated = common::generated(
        &["prior", "paper", "hold", "line", "minimum_jerk", "hermite"],
        &segments,
    );
    let evaluated = common::evaluated(
        &["prior", "paper", "hold", "line", "minimum_jerk", "hermite"],
        &take,
    );
    let full = common::take_file(&take, &generated, &evaluated);
    let train = TakeFile {
        generated: &[],
        evaluated: &[],
        ..full.clone()
    };
    let write = |name: &str, write: &dyn Fn(&mut Cursor<Vec<u8>>)| {
        let mut bytes = Cursor::new(Vec::with_capacity(32 << 20));
        let start = Instant::now();
        write(&mut bytes);
        let written = start.elapsed();
        let bytes = bytes.into_inner();
        let start = Instant::now();
        let read = read_take(&bytes, name).is_ok();
        println!(
            "{name}: {} bytes, written in {written:?}, read ({read}) in {:?}",
            bytes.len(),
            start.elapsed()
        );
        fs::write(folder.join(name), bytes).unwrap();
    };
    write("take.mcap", &|out| {
        write_take(out, &full, Views::All).unwrap();
    });
    write("train.mcap", &|out| {
        write_take(out, &train, Views::All).unwrap();
    });
    write("train_plain.mcap", &|out| {
        write_take(out, &train, Views::None).unwrap();
    });
    write("recording.mcap", &|out| {
        let file = TakeFile {
            roles: Some(&take.roles),
            ..TakeFile::new(&take.recording)
        };
        write_take(out, &file, Views::All).unwrap();
    });
    write("bare.mcap", &|out| {
        write_take(out, &TakeFile::new(&take.recording), Views::All).unwrap();
    });
    let dictionary = common::dictionary(200, 100, 100.0);
    write("dictionary.mcap", &|out| {
        write_dictionary(out, &dictionary, &take.provenance).unwrap();
    });

    for file in arguments {
        match info(&fs::read(&file).unwrap(), &file) {
            Err(error) => println!("{file}: ERROR {error}"),
            Ok(info) => println!(
                "{file}: {} channels, {} messages, {:?}, {} attachments, {} metadata, summary {}, {}",
                info.channels.len(),
                info.messages,
                info.chunks,
                info.attachments.len(),
                info.metadata.0.len(),
                info.has_summary,
                info.problem
                    .map_or("sound".to_owned(), |p| format!("PROBLEM {p}")),
            ),
        }
    }
}
