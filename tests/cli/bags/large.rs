//! Bags that are larger than the memory that there is for them.

use std::fs::File;
use std::io::{Seek as _, SeekFrom, Write as _};
use std::process::{Command, Output};

use super::bag::{Bag, pose};
use super::folders::facts;
use crate::support::{Bench, stderr};

/// Memory of a run, KiB: with the program itself less than half of the bag.
const MEMORY_KIB: u32 = 160 << 10;

/// Bytes of a camera's image, and how many of them there are.
const IMAGE_BYTES: u64 = 8 << 20;
const IMAGES: u64 = 44;

/// Runs `inhand` with [`MEMORY_KIB`] of address space.
fn limited(bench: &Bench, args: &[&str]) -> Output {
    let program = env!("CARGO_BIN_EXE_inhand");
    Command::new("sh")
        .args(["-c", &format!("ulimit -v {MEMORY_KIB}; exec \"$@\""), "sh"])
        .arg(program)
        .args(["--threads", "1"])
        .args(args)
        .current_dir(bench.folder.path())
        .output()
        .expect("a shell runs")
}

/// A bag of a body at 100 Hz and of images, which are holes in the file.
fn write_bag(bench: &Bench, name: &str, first: u64, images: u64) {
    let start = 1_700_000_000_000_000_000;
    let mut bag = Bag::new();
    let body = bag.channel("/mocap/Hand/pose", "geometry_msgs/msg/PoseStamped");
    let image = bag.channel("/camera", "sensor_msgs/msg/Image");
    let mut file = File::create(bench.path(name)).expect("the file can be made");
    for n in first..first + images {
        for k in 5 * n..5 * n + 5 {
            let (time, angle) = (start + k * 10_000_000, k as f64 * 0.01);
            let rotation = [0.0, 0.0, angle.sin(), angle.cos()];
            bag.message(body, time, &pose(time, [angle, 1.0, 2.0], rotation));
        }
        bag.message_start(image, start + n * 50_000_000, IMAGE_BYTES);
        file.write_all(&bag.take()).expect("there is room");
        let hole = i64::try_from(IMAGE_BYTES).expect("it is small");
        file.seek(SeekFrom::Current(hole))
            .expect("files have holes");
    }
    file.write_all(&bag.end()).expect("there is room");
}

#[test]
fn memory_does_not_grow_with_a_bag() {
    let bench = Bench::empty();
    write_bag(&bench, "bag.mcap", 0, IMAGES);
    let bytes = std::fs::metadata(bench.path("bag.mcap")).expect("it is there");
    assert!(bytes.len() > 2048 * u64::from(MEMORY_KIB));
    let runs: [&[&str]; 5] = [
        &["info", "bag.mcap"],
        &["annotate", "list", "bag.mcap"],
        &["check", "bag.mcap"],
        &["convert", "bag.mcap", "-o", "take.mcap"],
        &["filter", "bag.mcap", "-n", "/camera", "-o", "poses.mcap"],
    ];
    for args in runs {
        let output = limited(&bench, args);
        let code = output.status.code();
        // The checks find that there are no fingers.
        let expected = if args[0] == "check" { 3 } else { 0 };
        assert_eq!(code, Some(expected), "{args:?}: {}", stderr(&output));
        // A check that could not read the bag ends with 3 too.
        let said = String::from_utf8_lossy(&output.stdout);
        assert!(!said.contains("out of memory"), "{args:?}: {said}");
        assert!(args[0] != "check" || said.contains("220 samples"), "{said}");
    }
    let take = inhand_channels::read_take(&bench.bytes("take.mcap"), "take").expect("a take");
    assert_eq!(take.recording.len() as u64, 5 * IMAGES);
}

#[test]
fn memory_does_not_grow_with_a_split_bag() {
    let bench = Bench::empty();
    std::fs::create_dir(bench.path("bag")).expect("the folder can be made");
    let names = ["a.mcap", "b.mcap"];
    for (n, name) in (0..).zip(names) {
        write_bag(&bench, &format!("bag/{name}"), n * IMAGES / 2, IMAGES / 2);
    }
    bench.write("bag/metadata.yaml", facts(&names, "mcap", ""));
    let output = limited(&bench, &["convert", "bag", "-o", "take.mcap"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let take = inhand_channels::read_take(&bench.bytes("take.mcap"), "take").expect("a take");
    assert_eq!(take.recording.len() as u64, 5 * IMAGES);
}
