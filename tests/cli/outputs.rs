//! Outputs appear whole or not at all, and never over something else.

use crate::support::{Bench, SMALL, stderr};

#[test]
fn an_output_that_is_an_input_is_refused() {
    let bench = Bench::csv();
    bench.ok(&["convert", "session/train/cube_train_01.csv", "-o", "a.mcap"]);
    let before = bench.bytes("a.mcap");
    let output = bench.inhand(&["process", "a.mcap", "-o", "./a.mcap", "--force"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        stderr(&output).contains("also an input"),
        "{}",
        stderr(&output)
    );
    assert_eq!(bench.bytes("a.mcap"), before);
}

#[test]
fn what_others_wrote_needs_force() {
    let bench = Bench::csv();
    bench.write("a.mcap", "somebody's notes");
    let convert = ["convert", "session/train/cube_train_01.csv", "-o", "a.mcap"];
    let output = bench.inhand(&convert);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("--force"), "{}", stderr(&output));
    assert_eq!(bench.bytes("a.mcap"), b"somebody's notes");
    bench.ok(&[&convert[..], &["--force"]].concat());
    // The identical call may be repeated; another input or other settings need force.
    bench.ok(&convert);
    let bare = [&convert[..], &["--views=none"]].concat();
    assert_eq!(bench.inhand(&bare).status.code(), Some(2));
    let other = ["convert", "session/train/cube_train_02.csv", "-o", "a.mcap"];
    assert_eq!(bench.inhand(&other).status.code(), Some(2));
}

#[test]
fn run_replaces_its_own_results_only() {
    let bench = Bench::csv();
    bench.write("out/report.html", "my thesis");
    let args = [&["run", "session", "-o", "out"], &SMALL[..]].concat();
    let output = bench.inhand(&args);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    assert_eq!(bench.files("out"), ["report.html"]);
    assert_eq!(bench.bytes("out/report.html"), b"my thesis");
    bench.ok(&[&args[..], &["--force"]].concat());
    bench.run("out", &["--tau-mm", "4"]);
}

#[test]
fn results_of_another_session_need_force() {
    let bench = Bench::csv();
    bench.run("out", &[]);
    let other = [
        "simulate",
        "-o",
        "other",
        "--takes",
        "1",
        "--duration",
        "20",
        "--format",
        "csv",
    ];
    bench.ok(&[&other[..], &["--object", "cylinder:0.05x0.05"]].concat());
    let args = [&["run", "other", "-o", "out"], &SMALL[..]].concat();
    assert_eq!(bench.inhand(&args).status.code(), Some(2));
    bench.ok(&[&args[..], &["--force"]].concat());
    // What the other session left is gone with it.
    assert!(!bench.path("out/cube_test_01.mcap").exists());
    assert!(bench.path("out/cylinder_test_01.mcap").is_file());
}

#[test]
fn simulated_sessions_do_not_mix() {
    let bench = Bench::csv();
    let before = bench.files("session");
    let args = [
        "simulate",
        "-o",
        "session",
        "--object",
        "cylinder:0.05x0.05",
        "--force",
    ];
    let output = bench.inhand(&args);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    assert_eq!(bench.files("session"), before);
}

#[test]
fn leftovers_of_an_interrupted_run_vanish() {
    let bench = Bench::csv();
    bench.write("out/.inhand-unfinished-abc", "half a file");
    bench.run("out", &[]);
    assert!(!bench.path("out/.inhand-unfinished-abc").exists());
}

#[cfg(unix)]
#[test]
fn devices_and_fifos_are_written_to() {
    use std::os::unix::fs::FileTypeExt as _;
    let bench = Bench::csv();
    let take = "session/train/cube_train_01.csv";
    let made = std::process::Command::new("mkfifo")
        .arg(bench.path("pipe"))
        .status();
    assert!(made.expect("mkfifo runs").success());
    std::os::unix::fs::symlink("pipe", bench.path("link")).unwrap();
    bench.ok(&["convert", take, "-o", "take.mcap"]);
    for name in ["pipe", "link"] {
        let pipe = bench.path("pipe");
        let reader = std::thread::spawn(move || std::fs::read(pipe).unwrap());
        bench.ok(&["convert", take, "-o", name]);
        assert!(reader.join().unwrap() == bench.bytes("take.mcap"));
    }
    let kind = |path| std::fs::symlink_metadata(path).unwrap().file_type();
    assert!(kind(bench.path("pipe")).is_fifo());
    assert!(kind(bench.path("link")).is_symlink());
    for force in [&[][..], &["--force"]] {
        bench.ok(&[&["convert", take, "-o", "/dev/null"], force].concat());
        assert!(kind("/dev/null".into()).is_char_device());
    }
}

#[cfg(unix)]
#[test]
fn a_link_to_nothing_is_refused_before_the_work() {
    let bench = Bench::csv();
    std::os::unix::fs::symlink("nowhere.mcap", bench.path("link.mcap")).expect("a link");
    let output = bench.inhand(&[
        "convert",
        "session/train/cube_train_01.csv",
        "-o",
        "link.mcap",
        "--force",
    ]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("a link to a file that is not there"));
    assert!(bench.path("link.mcap").is_symlink());
}

#[test]
fn an_ending_that_is_not_written_is_refused() {
    let bench = Bench::empty();
    bench.write("a.mcap", "");
    bench.write("b.mcap", "");
    bench.write("evaluation.json", "");
    let state = "a.mcap@0";
    let plan = ["plan", "-d", "b.mcap", "--from", state, "--to", state];
    for verb in [
        &["convert", "a.mcap"][..],
        &["process", "a.mcap"],
        &["clean", "a.mcap", "--repair"],
        &["generate", "-d", "b.mcap", "a.mcap"],
        &["learn", "a.mcap"],
        &["cut", "a.mcap"],
        &["filter", "a.mcap"],
        &["merge", "a.mcap", "b.mcap"],
        &["recover", "a.mcap"],
        &["view", "a.mcap"],
        &["overlay", "a.mcap", "b.mcap"],
        &["annotate", "add", "a.mcap", "--at", "1", "--label", "x"],
        &plan,
        &["evaluate", "-d", "b.mcap", "a.mcap"],
        &["report", "evaluation.json"],
    ] {
        for name in ["x.tsv", "x", "new/x."] {
            let output = bench.inhand(&[verb, &["-o", name]].concat());
            let message = stderr(&output);
            assert_eq!(output.status.code(), Some(2), "{verb:?}: {message}");
            let wanted = format!("-o {name}: expected a file that ends in .");
            assert!(message.contains(&wanted), "{verb:?}: {message}");
        }
    }
    assert_eq!(bench.files("."), ["a.mcap", "b.mcap", "evaluation.json"]);
}

#[test]
fn the_identical_call_may_be_repeated_and_no_other_replaces_results() {
    let bench = Bench::csv();
    bench.run("out", &[]);
    let (train, test) = ("session/train/cube_train_01.csv", "out/cube_test_01.mcap");
    let (dictionary, evaluation) = ("out/dictionary.mcap", "out/evaluation.json");
    let (from, to) = ("out/cube_test_01.mcap@2", "out/cube_test_01.mcap@2.99");
    let plan = ["plan", "-d", dictionary, "--from", from, "--to", to];
    let learn = [
        "learn",
        train,
        "--stride",
        "10",
        "--rank",
        "12",
        "--max-iterations",
    ];
    // A call, its output, and what makes it another one.
    for (call, name, other) in [
        (&["process", train][..], "p.mcap", &["--views=none"][..]),
        (
            &["clean", train, "--repair"],
            "c.mcap",
            &["--fill", "cubic"],
        ),
        (&[&learn[..], &["5"]].concat(), "d.mcap", &["--seed", "5"]),
        (
            &["generate", "-d", dictionary, test, "--methods", "line,hold"],
            "g.mcap",
            &["--views=none"],
        ),
        (
            &["evaluate", "-d", dictionary, test],
            "e.json",
            &["--draws", "100"],
        ),
        (&plan, "plan.mcap", &["--fingers", "thumb"]),
        (&["cut", test, "--from", "1"], "cut.mcap", &["--to", "3"]),
        (&["filter", test], "f.mcap", &["--no-metadata"]),
        (
            &["annotate", "add", test, "--at", "1", "--label", "slip"],
            "a.mcap",
            &["--label", "finger=index"],
        ),
        (&["export", train], "t.csv", &["--layout", "tidy"]),
        (&["export", dictionary], "d.npz", &[]),
        (&["layout", test], "l.json", &[dictionary]),
        (&["report", evaluation], "r.md", &[]),
        (&["view", test], "v.mcap", &["--object", "cube:0.06"]),
    ] {
        let call = [call, &["-o", name]].concat();
        bench.ok(&call);
        let before = bench.bytes(name);
        bench.ok(&call);
        assert!(bench.bytes(name) == before, "{call:?}");
        let refused = |call: &[&str], before: &[u8]| {
            let output = bench.inhand(call);
            let message = stderr(&output);
            assert_eq!(output.status.code(), Some(2), "{call:?}: {message}");
            let wanted = format!("{name}: already exists; use --force to overwrite");
            assert!(message.contains(&wanted), "{call:?}: {message}");
            assert!(bench.bytes(name) == before, "{call:?}");
        };
        if !other.is_empty() {
            refused(&[&call[..], other].concat(), &before);
        }
        bench.write(name, "somebody's notes");
        refused(&call, b"somebody's notes");
        bench.ok(&[&call[..], &["--force"]].concat());
        assert!(bench.bytes(name) == before, "{call:?}");
    }
    let unfinished = bench.files(".").into_iter();
    let unfinished: Vec<_> = unfinished
        .filter(|name| name.contains("unfinished"))
        .collect();
    assert_eq!(unfinished, Vec::<String>::new());
}
