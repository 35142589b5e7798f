//! Bags as `ros2 bag record` leaves them: folders, split files, files and messages that zstd packed.

use inhand_model::Recording;

use super::{TAKE, as_mocap4r2, as_stored, recorded};
use crate::support::{Bench, SMALL, stderr};

/// Facts of a bag, as far as they matter.
pub(super) fn facts(files: &[&str], storage: &str, compression: &str) -> String {
    let files: String = files.iter().map(|file| format!("    - {file}\n")).collect();
    format!(
        "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: {storage}\n  \
         relative_file_paths:\n{files}  compression_format: \"{compression}\"\n  compression_mode: \"\"\n"
    )
}

pub(super) fn zstd(bytes: &[u8]) -> Vec<u8> {
    // A frame of raw blocks, as its document lays it out: no packer is needed.
    let mut frame = vec![0x28, 0xB5, 0x2F, 0xFD, 0x00, 0x38];
    let blocks = bytes.chunks(1 << 16);
    let count = blocks.len();
    for (n, block) in blocks.enumerate() {
        let head = (block.len() as u32) << 3 | u32::from(n + 1 == count);
        frame.extend(&head.to_le_bytes()[..3]);
        frame.extend(block);
    }
    frame
}

/// The take in two bags, one after the other.
fn halves(recording: &Recording) -> [Vec<u8>; 2] {
    let middle = recording.len() / 2;
    [0..middle, middle..recording.len()].map(|part| as_mocap4r2(&recording.slice(part)))
}

/// A bench whose test take is a bag folder.
fn with_bag(facts: &str, files: &[(&str, &[u8])]) -> Bench {
    let bench = Bench::csv();
    std::fs::remove_file(bench.path(TAKE)).expect("the take can go");
    bench.write("session/test/cube_test_01/metadata.yaml", facts);
    for (name, bytes) in files {
        bench.write(&format!("session/test/cube_test_01/{name}"), bytes);
    }
    bench
}

#[test]
fn a_split_bag_gives_the_numbers_of_the_take_it_holds() {
    let bench = Bench::csv();
    bench.run("csv", &[]);
    let expected = bench.json("csv/evaluation.json");
    let [first, second] = halves(&recorded(&bench));
    let names = ["take_0.mcap.zstd", "cube_test_01/take_1.mcap"];
    let packed = zstd(&first);
    let files = [("take_0.mcap.zstd", &packed[..]), ("take_1.mcap", &second)];
    let bench = with_bag(&facts(&names, "mcap", "zstd"), &files);
    bench.run("bag", &[]);
    let found = bench.json("bag/evaluation.json");
    assert_eq!(found["methods"], expected["methods"]);
    let takes = [&found, &expected].map(|evaluation| {
        let mut takes = evaluation["session"]["test"].clone();
        for of_the_file in ["format", "up_axis"] {
            takes[0]["source"][of_the_file].take();
        }
        takes
    });
    assert_eq!(takes[0], takes[1]);

    let folder = "session/test/cube_test_01";
    let checked = bench.ok(&["check", folder]);
    assert!(checked.contains("1200 samples (12.00 s)"), "{checked}");
    bench.ok(&["convert", folder, "-o", "take.mcap"]);
    let info = bench.ok(&["info", folder]);
    assert!(
        info.contains("take_0.mcap.zstd") && info.contains("take_1.mcap"),
        "{info}"
    );
    // One recording is one take, as a bag too.
    bench.ok(&[&["run", folder, "-o", "one"], &SMALL[..]].concat());
    // What reads files record by record says what to name.
    let output = bench.inhand(&["cut", folder, "-o", "c.mcap", "--to", "3"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(
        stderr(&output).contains("inhand convert"),
        "{}",
        stderr(&output)
    );
}

#[test]
fn packed_files_and_messages_are_read() {
    let bench = Bench::csv();
    let recording = recorded(&bench);
    let whole = as_mocap4r2(&recording);
    bench.write("plain.mcap", &whole);
    bench.write("file.mcap.zstd", zstd(&whole));
    bench.write("messages.mcap", as_stored(&recording, zstd));
    let tables = ["plain.mcap", "file.mcap.zstd", "messages.mcap"].map(|bag| {
        bench.ok(&["convert", bag, "-o", "take.csv", "--force"]);
        let table = String::from_utf8(bench.bytes("take.csv")).expect("a table is text");
        let (_, rows) = table.split_once('\n').expect("a table has a header");
        rows.to_owned()
    });
    assert!(tables[0].lines().count() > 1200);
    assert!(tables.iter().all(|table| *table == tables[0]));
    bench.ok(&["convert", "file.mcap.zstd", "plain.mcap", "-o", "all"]);
    assert_eq!(bench.files("all"), ["file.mcap", "plain.mcap"]);
}

#[test]
fn what_steps_stored_is_read_of_packed_files_and_folders_too() {
    let bench = Bench::csv();
    bench.run("out", &["--methods", "residual,line"]);
    let dictionary = ["-d", "out/dictionary.mcap", "-o"];
    bench.ok(&["process", TAKE, "-o", "p.mcap", "--object", "cube:0.04"]);
    bench.ok(&[&["generate", "p.mcap"][..], &dictionary, &["g.mcap"]].concat());
    for name in ["p", "g"] {
        let file = bench.bytes(&format!("{name}.mcap"));
        bench.write(&format!("{name}.mcap.zstd"), zstd(&file));
        bench.write(
            &format!("{name}/metadata.yaml"),
            facts(&["x_0.mcap"], "mcap", ""),
        );
        bench.write(&format!("{name}/x_0.mcap"), file);
    }
    let shape = |name: &str| {
        let metadata =
            inhand_channels::read_metadata(&bench.bytes(name), name).expect("it is sound");
        metadata
            .shape(name)
            .expect("ours")
            .map(|shape| shape.to_string())
    };
    assert_eq!(shape("g.mcap").as_deref(), Some("cube:0.04"));
    let evaluated = |take: &str| {
        bench.ok(&[&["evaluate", take][..], &dictionary, &["e.json", "--force"]].concat());
        let evaluation = bench.json("e.json");
        assert!(evaluation["methods"][0].is_object(), "{take}");
        ["methods", "contacts", "held_out"].map(|key| evaluation[key].clone())
    };
    let topics = |take: &str| {
        bench.ok(&["convert", take, "--ros2", "-o", "bag.mcap", "--force"]);
        let summary = mcap::Summary::read(&bench.bytes("bag.mcap"));
        let summary = summary.expect("a file").expect("a summary");
        let channels = summary.channels.values();
        let mut topics: Vec<_> = channels.map(|channel| channel.topic.clone()).collect();
        topics.sort();
        topics
    };
    let shown = |take: &str| {
        let call = [
            "overlay",
            take,
            "--methods",
            "all",
            "-o",
            "o.mcap",
            "--force",
        ];
        bench.ok(&[&call[..], &["--name", "take"]].concat());
        bench.bytes("o.mcap").len()
    };
    let expected = (evaluated("g.mcap"), topics("g.mcap"));
    assert!(
        expected
            .1
            .contains(&"/generated/line/trajectory".to_owned())
    );
    let size = shown("g.mcap");
    for form in ["mcap.zstd", ""] {
        let [processed, generated] = ["p", "g"].map(|name| match form {
            "" => name.to_owned(),
            _ => format!("{name}.{form}"),
        });
        assert!(
            (evaluated(&generated), topics(&generated)) == expected,
            "{generated}"
        );
        // Names and hashes of files take a few bytes more or less.
        assert!(shown(&generated).abs_diff(size) < 1000, "{generated}");
        let call = ["generate", &processed];
        bench.ok(&[&call[..], &dictionary, &["again.mcap", "--force"]].concat());
        assert_eq!(
            shape("again.mcap").as_deref(),
            Some("cube:0.04"),
            "{processed}"
        );
    }

    bench.ok(&["annotate", "list", "g.mcap.zstd"]);
    let refused = |call: &[&str]| {
        let output = bench.inhand(call);
        assert_eq!(output.status.code(), Some(1), "{call:?}");
        stderr(&output).replace("error: ", "")
    };
    let cut = refused(&["cut", "g", "-o", "c.mcap", "--to", "3"]);
    assert!(cut.contains("`inhand convert FOLDER"), "{cut}");
    let add = [
        "annotate", "add", "g", "--at", "1", "--label", "slip", "-o", "a.mcap",
    ];
    assert_eq!(refused(&add), cut);
    assert_eq!(refused(&["annotate", "list", "g"]), cut);
}

#[test]
fn what_is_not_read_is_named_with_the_command_that_helps() {
    let sqlite = b"SQLite format 3\0 and pages";
    let folder = |storage, compression| facts(&["take_0.db3"], storage, compression);
    for (facts, words) in [
        (folder("sqlite3", ""), ["sqlite3", "mcap convert"]),
        (
            folder("mcap", "lz4"),
            ["compressed with lz4", "ros2 bag convert"],
        ),
        (folder("mcap", ""), ["SQLite", "mcap convert"]),
        (
            "something: else\n".to_owned(),
            ["metadata.yaml", "relative_file_paths"],
        ),
    ] {
        let bench = with_bag(&facts, &[("take_0.db3", sqlite)]);
        let output = bench.inhand(&[&["run", "session", "-o", "out"], &SMALL[..]].concat());
        assert_eq!(output.status.code(), Some(1));
        let said = stderr(&output);
        assert!(
            words.iter().all(|word| said.contains(word)),
            "{words:?}: {said}"
        );
        assert_eq!(bench.files("out"), Vec::<String>::new());
    }
    // A file that is missing is missing, in a bag too.
    let bench = with_bag(&folder("mcap", ""), &[]);
    for input in ["session/test/cube_test_01", "session"] {
        let output = bench.inhand(&["check", input]);
        assert_eq!(output.status.code(), Some(1), "{input}");
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(said.contains("take_0.db3"), "{said}");
    }
    // A single file among the takes stops too, instead of being left out.
    let bench = Bench::csv();
    for (name, bytes, word) in [
        ("bag.db3", &sqlite[..], "mcap convert"),
        ("take.mcap.gz", b"\x1F\x8B\x08", "gunzip"),
        (
            "take.mcap.zstd",
            b"\x28\xB5\x2F\xFDnot zstd",
            "expected zstd data",
        ),
    ] {
        bench.write(&format!("session/test/{name}"), bytes);
        let output = bench.inhand(&[&["run", "session", "-o", "out"], &SMALL[..]].concat());
        assert_eq!(output.status.code(), Some(1));
        assert!(
            stderr(&output).contains(word),
            "{word}: {}",
            stderr(&output)
        );
        std::fs::remove_file(bench.path(&format!("session/test/{name}"))).expect("it goes");
    }
}
