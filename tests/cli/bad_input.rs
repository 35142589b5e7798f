//! Bad input: exit code 1 or 2, a message with place, expectation and finding, and no output.

use crate::support::{Bench, SMALL, stderr};

const TRAIN: &str = "session/train/cube_train_01.csv";

/// The session must be refused with these words, and leave nothing behind.
fn refused(bench: &Bench, options: &[&str], words: &[&str]) {
    let small = if options.contains(&"--rank") {
        &[][..]
    } else {
        &SMALL
    };
    let args = [&["run", "session", "-o", "out"], small, options].concat();
    let output = bench.inhand(&args);
    let message = stderr(&output);
    assert!(
        matches!(output.status.code(), Some(1 | 2)),
        "{:?} {message}",
        output.status
    );
    for word in words {
        assert!(message.contains(word), "\"{word}\" in: {message}");
    }
    assert!(!message.contains("panicked"), "{message}");
    assert_eq!(
        bench.files("out"),
        Vec::<String>::new(),
        "nothing is written"
    );
}

/// Changes one line (counted from 1) of a file.
fn edit_line(bench: &Bench, name: &str, line: usize, change: impl FnOnce(&str) -> String) {
    bench.edit(name, |text| {
        let mut lines: Vec<String> = text.split('\n').map(str::to_owned).collect();
        lines[line - 1] = change(&lines[line - 1]);
        lines.join("\n")
    });
}

#[test]
fn no_motive_file() {
    let bench = Bench::csv();
    bench.write(TRAIN, "time,x,y\n0,1,2\n");
    refused(&bench, &[], &["cube_train_01.csv", "Motive"]);
    bench.write(TRAIN, [0_u8, 159, 146, 150, 255, 0]);
    refused(&bench, &[], &["cube_train_01.csv"]);
    bench.write(TRAIN, "");
    refused(&bench, &[], &["cube_train_01.csv"]);
}

#[test]
fn cut_header() {
    let bench = Bench::csv();
    bench.edit(TRAIN, |text| {
        text.lines().take(5).collect::<Vec<_>>().join("\n")
    });
    refused(&bench, &[], &["cube_train_01.csv", "header"]);
}

#[test]
fn a_row_with_too_few_cells() {
    let bench = Bench::csv();
    edit_line(&bench, TRAIN, 100, |line| line[..line.len() / 2].to_owned());
    refused(&bench, &[], &["cube_train_01.csv", "line 100"]);
}

#[test]
fn a_cell_that_is_no_number() {
    let bench = Bench::csv();
    edit_line(&bench, TRAIN, 100, |line| {
        let (head, _) = line.trim_end().rsplit_once(',').expect("a row has cells");
        format!("{head},1.0.24\r")
    });
    refused(&bench, &[], &["cube_train_01.csv", "line 100", "1.0.24"]);
}

#[test]
fn units_or_rotation_that_nobody_states() {
    let bench = Bench::csv();
    edit_line(&bench, TRAIN, 1, |line| {
        line.replace("Length Units,Meters,", "")
    });
    refused(&bench, &[], &["cube_train_01.csv", "--units"]);
    bench.run("with_units", &["--units", "m"]);

    let bench = Bench::csv();
    edit_line(&bench, TRAIN, 1, |line| {
        line.replace("Rotation Type,Quaternion,", "")
    });
    let output = bench.inhand(&[&["run", "session", "-o", "out"], &SMALL[..]].concat());
    // Four rotation columns can only be a quaternion; three would need the order.
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
}

#[test]
fn fingers_that_cannot_be_told() {
    let bench = Bench::csv();
    edit_line(&bench, TRAIN, 4, |line| {
        line.replace("Little", "Marker 005")
    });
    refused(
        &bench,
        &[],
        &["cube_train_01.csv", "little", "Marker 005", "--finger"],
    );
    // Converting keeps whatever a take has.
    bench.ok(&["convert", TRAIN, "-o", "a.mcap"]);

    let bench = Bench::csv();
    edit_line(&bench, TRAIN, 4, |line| line.replace("Ring", "little_tip"));
    refused(&bench, &[], &["cube_train_01.csv", "little_tip", "Little"]);

    let bench = Bench::csv();
    refused(
        &bench,
        &["--finger", "pinkie=Little"],
        &["pinkie", "little"],
    );
    refused(
        &bench,
        &["--finger", "little=Nobody"],
        &["Nobody", "Little"],
    );
}

#[test]
fn takes_of_different_rates() {
    let bench = Bench::csv();
    edit_line(&bench, TRAIN, 1, |line| {
        line.replace(
            "Export Frame Rate,100.000000",
            "Export Frame Rate,120.000000",
        )
    });
    refused(&bench, &[], &["120 Hz", "100 Hz"]);
}

#[test]
fn a_test_take_that_is_a_training_take() {
    let bench = Bench::csv();
    bench.write("session/test/cube_test_01.csv", bench.bytes(TRAIN));
    refused(
        &bench,
        &[],
        &["also the training take", "allow_shared_takes"],
    );
}

#[test]
fn a_test_take_that_was_stored_otherwise_in_training() {
    let bench = Bench::csv();
    bench.ok(&["convert", TRAIN, "-o", "session/test/other.mcap"]);
    refused(&bench, &[], &["other.mcap", "also the training take"]);
    std::fs::remove_file(bench.path("session/test/other.mcap")).unwrap();
    // With other line ends and a number touched it is still the same motion.
    bench.write("session/test/other.csv", bench.bytes(TRAIN));
    bench.edit("session/test/other.csv", |text| text.replace("\r\n", "\n"));
    refused(&bench, &[], &["other.csv", "also the training take"]);
}

#[test]
fn a_take_with_the_name_of_the_dictionary() {
    let bench = Bench::csv();
    std::fs::rename(
        bench.path(TRAIN),
        bench.path("session/train/dictionary.csv"),
    )
    .unwrap();
    refused(&bench, &[], &["dictionary.csv", "rename"]);
}

#[test]
fn results_among_the_takes() {
    let bench = Bench::csv();
    let before = bench.files("session");
    let args = [&["run", "session", "-o", "session/train"], &SMALL[..]].concat();
    assert_eq!(bench.inhand(&args).status.code(), Some(2));
    assert_eq!(bench.files("session"), before);
}

#[test]
fn too_few_segments_for_the_rank() {
    let bench = Bench::csv();
    refused(&bench, &["--rank", "5000"], &["5000"]);
}

#[test]
fn a_truncated_recording() {
    let bench = Bench::csv();
    bench.ok(&["convert", TRAIN, "-o", "session/train/cube_train_01.mcap"]);
    std::fs::remove_file(bench.path(TRAIN)).unwrap();
    let whole = bench.bytes("session/train/cube_train_01.mcap");
    for share in [1, 20, 60, 99] {
        bench.write(
            "session/train/cube_train_01.mcap",
            &whole[..whole.len() * share / 100],
        );
        refused(&bench, &[], &["cube_train_01.mcap"]);
    }
}

#[test]
fn sessions_without_takes() {
    let bench = Bench::empty();
    std::fs::create_dir(bench.path("session")).unwrap();
    refused(&bench, &[], &["session", "train/"]);
    let bench = Bench::csv();
    std::fs::remove_dir_all(bench.path("session/test")).unwrap();
    refused(&bench, &[], &["no test take"]);
    let bench = Bench::empty();
    refused(&bench, &[], &["session"]);
}

#[test]
fn settings_that_cannot_be_used() {
    let bench = Bench::csv();
    let one_sentence = "expected cube:EDGE, box:XxYxZ or cylinder:DIAMETERxHEIGHT in metres, such as \
                        cube:0.05, found teapot:1\n";
    refused(&bench, &["--object", "teapot:1"], &[one_sentence]);
    refused(&bench, &["--tau-mm=-1"], &["tau_mm"]);
    refused(&bench, &["--filter", "mean"], &["mean", "median"]);
    refused(&bench, &["--rotation-order", "XYX"], &["XYX"]);
    refused(&bench, &["--units", "furlongs"], &["furlongs", "mm"]);
    refused(&bench, &["--methods", "magic"], &["magic", "prior"]);
    refused(&bench, &["--methods", "line,line"], &["line twice"]);
    bench.write("session/inhand.toml", "[learn]\nrnak = 3\n");
    refused(&bench, &[], &["inhand.toml", "rnak"]);
}

#[test]
fn wrong_usage_is_exit_code_2() {
    let bench = Bench::empty();
    for args in [
        &["frobnicate"][..],
        &["run"],
        &["run", "a", "--no-such-flag"],
        &["settings", "--threads", "100000"],
        &[],
    ] {
        assert_eq!(bench.inhand(args).status.code(), Some(2), "{args:?}");
    }
}

#[test]
fn info_points_to_what_reads_other_takes() {
    let bench = Bench::csv();
    let output = bench.inhand(&["info", TRAIN]);
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("not an MCAP file"), "{message}");
    for command in ["`inhand check`", "`inhand convert`"] {
        assert!(message.contains(command), "{message}");
    }
}
