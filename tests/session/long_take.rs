//! Vendor files read and written block by block.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use inhand_channels::{TakeFile, Views};
use inhand_inspection::Coverage;
use inhand_session::{LongTake, Settings, provenance, read, write_take_parts};

/// A take with gaps, of more samples than a block has.
fn long_csv(folder: &Path) -> PathBuf {
    let mut text = "Format Version,1.23,Take Name,long,Export Frame Rate,240,Rotation Type,\
                    Quaternion,Length Units,Millimeters,Total Exported Frames,7\r\n\r\n"
        .to_owned();
    let fingers = ["Thumb", "Index", "Middle", "Ring", "Little"];
    let body = |cell: &str| format!(",{cell}").repeat(7);
    let markers = |cells: [&str; 5]| cells.map(|cell| format!(",{cell}").repeat(3)).concat();
    let axes = format!(",X,Y,Z,W{}", ",X,Y,Z".repeat(6));
    let kinds = format!("{}{}", ",Rotation".repeat(4), ",Position".repeat(18));
    text += &format!(",Type{}{}\r\n", body("Rigid Body"), markers(["Marker"; 5]));
    text += &format!(",Name{}{}\r\n", body("Hand"), markers(fingers));
    text += &format!(",ID{}{}\r\n", body("H"), markers(["T", "I", "M", "R", "L"]));
    text += &format!(",{kinds}\r\nFrame,Time (Seconds){axes}\r\n");
    for k in 0..40_000 {
        let frame = if k < 30_000 { k } else { k + 20_000 };
        let ring = if k % 500 < 37 { ",,," } else { ",4,5,6.25" };
        let hand = if k % 5 == 0 {
            ",0,0,0,1,1,2,3"
        } else {
            ",,,,,,,"
        };
        let rest = format!(",{k}.5,2,3,1,2,3,1,2,{k}.125{ring},7,8,9");
        text += &format!("{frame},{:.6}{hand}{rest}\r\n", f64::from(frame) / 240.0);
    }
    let path = folder.join("long.csv");
    fs::write(&path, text).unwrap();
    path
}

fn assert_same_bytes(path: &Path, settings: &Settings) {
    let folder = tempfile::tempdir().unwrap();
    let long = LongTake::open(path, settings)
        .unwrap()
        .expect("a file of even rows");
    let whole = read(path, settings).unwrap();
    assert_eq!(long.hash, whole.hash);
    assert_eq!(long.roles, whole.roles);
    assert_eq!(long.coverage, Coverage::of(&whole.recording));
    assert_eq!(long.header.findings, whole.recording.findings);

    let chain = [provenance("convert", settings, [whole.hash.clone()])];
    for views in [Views::Default, Views::None] {
        let (a, b) = (folder.path().join("a.mcap"), folder.path().join("b.mcap"));
        let shape = settings.shape().unwrap();
        long.write(&a, &chain, shape, views).unwrap();
        let file = TakeFile {
            roles: whole.roles.as_ref().ok(),
            object_shape: settings.shape().unwrap(),
            annotations: Some(&whole.annotations),
            provenance: &chain,
            ..TakeFile::new(&whole.recording)
        };
        write_take_parts(&b, &file, views).unwrap();
        assert!(
            fs::read(&a).unwrap() == fs::read(&b).unwrap(),
            "{}",
            path.display()
        );
    }
}

#[test]
fn a_long_take_gives_the_bytes_of_one_in_memory() {
    let folder = tempfile::tempdir().unwrap();
    let path = long_csv(folder.path());
    let long = LongTake::open(&path, &Settings::default())
        .unwrap()
        .unwrap();
    assert_eq!(long.coverage.samples, 60_000);
    assert_eq!(long.coverage.markers[3].longest_gap, 20_000 + 37);
    assert_eq!(long.header.findings.len(), 3, "{:?}", long.header.findings);
    assert_same_bytes(&path, &Settings::default());

    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures");
    let mut files = 0;
    for session in ["cube/train", "cube/test", "cylinder_gaps/train"] {
        for entry in fs::read_dir(fixtures.join(session)).unwrap() {
            let file = entry.unwrap().path();
            if file.extension().is_some_and(|e| e == "csv") {
                assert_same_bytes(&file, &Settings::default());
                files += 1;
            }
        }
    }
    assert!(files > 0, "fixtures were looked at");
}

#[test]
fn a_file_that_changes_while_it_is_read_gives_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = long_csv(folder.path());
    let long = LongTake::open(&path, &Settings::default())
        .unwrap()
        .unwrap();
    let target = folder.path().join("out.mcap");
    let refused = |words: &str| {
        let error = long.write(&target, &[], None, Views::Default).unwrap_err();
        let cause = std::error::Error::source(&error).map(ToString::to_string);
        let message = format!("{error}: {}", cause.unwrap_or_default());
        assert!(message.contains(words), "{message}");
        assert_eq!(
            fs::read_dir(folder.path()).unwrap().count(),
            1,
            "nothing is left behind"
        );
    };
    let text = fs::read_to_string(&path).unwrap();
    // As long as before; then longer; then with a row that cannot be read.
    fs::write(&path, text.replacen("100.5", "100.6", 1)).unwrap();
    refused("changed while it was read");
    let mut file = fs::OpenOptions::new().append(true).open(&path).unwrap();
    writeln!(file, "60000,,{}", ",".repeat(21)).unwrap();
    refused("changed while it was read");
    writeln!(file, "60001,x").unwrap();
    refused("expected a number");
    fs::remove_file(&path).unwrap();
    assert!(long.write(&target, &[], None, Views::Default).is_err());
}

#[test]
fn what_is_read_whole() {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in [
        (
            "old.csv",
            &b"righthanded\nframe,0,0,0,0\nframe,1,0.01,0,0\n"[..],
        ),
        ("a.mcap", b"\x89MCAP0\r\n"),
        ("empty.csv", b""),
    ] {
        let path = folder.path().join(name);
        fs::write(&path, bytes).unwrap();
        assert!(
            LongTake::open(&path, &Settings::default())
                .unwrap()
                .is_none(),
            "{name}"
        );
    }
    assert!(LongTake::open(&folder.path().join("none.csv"), &Settings::default()).is_err());
}
