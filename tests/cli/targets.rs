//! Where outputs go, over all writing verbs: devices, FIFOs and links, inputs, new folders, modes; and what a process
//! leaves that is killed. The table is [`VERBS`].

use std::fs;
use std::os::unix::fs::{FileTypeExt as _, PermissionsExt as _, symlink};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use crate::support::{Bench, SMALL, stderr};

const TAKE: &str = "session/train/cube_train_01.csv";

/// Verbs that write one file: the call, the ending of its output, and files that it reads.
const VERBS: [(&str, &str, &[&str]); 25] = [
    ("convert TAKE", "mcap", &[TAKE, SETTINGS]),
    ("convert TAKE", "csv", &[TAKE]),
    ("convert TAKE --ros2", "mcap", &[TAKE]),
    ("clean TAKE --repair", "mcap", &[TAKE, SETTINGS]),
    ("process TAKE --settings s.toml", "mcap", &[TAKE, "s.toml"]),
    (
        "generate -d out/dictionary.mcap TAKE --methods hold",
        "mcap",
        &[TAKE, DICTIONARY, SETTINGS],
    ),
    (
        "plan -d out/dictionary.mcap --from TEST@2 --to TEST@2.9",
        "mcap",
        &[TEST, DICTIONARY],
    ),
    (
        "evaluate -d out/dictionary.mcap TEST --draws 100",
        "json",
        &[TEST, DICTIONARY],
    ),
    (
        "report out",
        "md",
        &["out/evaluation.json", "out/rows.parquet", "out/run.json"],
    ),
    (
        "report merge out --draws 100",
        "html",
        &["out/evaluation.json", "out/rows.parquet"],
    ),
    (
        "compare out --method line --against hold --draws 0",
        "md",
        &["out/evaluation.json", "out/rows.parquet"],
    ),
    ("check session", "json", &[TAKE, SETTINGS]),
    ("annotate add TEST --at 1 --label slip", "mcap", &[TEST]),
    (
        "annotate import TEST events.csv --vocabulary v.toml",
        "mcap",
        &[TEST, "events.csv", "v.toml"],
    ),
    ("annotate about TEST --set subject=s01", "mcap", &[TEST]),
    ("annotate export TEST", "csv", &[TEST]),
    ("export TAKE --layout tidy", "csv", &[TAKE, SETTINGS]),
    ("export out/dictionary.mcap", "npz", &[DICTIONARY]),
    ("view TEST", "mcap", &[TEST]),
    ("overlay TEST TEST2", "mcap", &[TEST, "test2.mcap"]),
    ("cut TEST --from 1 --to 2", "mcap", &[TEST]),
    ("filter TEST", "mcap", &[TEST]),
    (
        "merge TEST TEST2 --keep-both",
        "mcap",
        &[TEST, "test2.mcap"],
    ),
    ("recover TEST", "mcap", &[TEST]),
    ("layout TEST", "json", &[TEST]),
];
const SETTINGS: &str = "session/inhand.toml";
const DICTIONARY: &str = "out/dictionary.mcap";
const TEST: &str = "out/cube_test_01.mcap";

fn words(call: &str) -> Vec<String> {
    let word = |word: &str| match word {
        "TAKE" => TAKE.to_owned(),
        "TEST2" => "test2.mcap".to_owned(),
        other => other.replace("TEST", TEST),
    };
    call.split(' ').map(word).collect()
}

/// A session with results, and what else the verbs read.
fn bench() -> Bench {
    let bench = Bench::csv();
    bench.run("out", &["--methods", "line,hold"]);
    bench.write("s.toml", "");
    bench.write("v.toml", "label = [\"slip\"]\n");
    bench.write("events.csv", "start_s,end_s,label\n1,2,slip\n");
    let cut = ["cut", TEST, "--to", "5", "-o", "test2.mcap"];
    bench.ok(&cut);
    bench
}

/// Every verb, on two threads.
fn with_verbs(work: impl Fn(&Bench, &[&str], &str, &[&str]) + Sync) {
    let bench = bench();
    thread::scope(|scope| {
        for half in VERBS.chunks(VERBS.len() / 2) {
            let (bench, work) = (&bench, &work);
            scope.spawn(move || {
                for (call, ending, inputs) in half {
                    let call = words(call);
                    let call: Vec<&str> = call.iter().map(String::as_str).collect();
                    work(bench, &call, ending, inputs);
                }
            });
        }
    });
    assert_eq!(unfinished(&bench, "."), [""; 0]);
}

/// A file name of its own for each call.
fn name(call: &[&str], ending: &str) -> String {
    let call = call.concat().replace(|c: char| !c.is_alphanumeric(), "");
    format!("{call}.{ending}")
}

fn unfinished(bench: &Bench, folder: &str) -> Vec<String> {
    let files = bench.files(folder).into_iter();
    files
        .filter(|file| file.contains(".inhand-unfinished"))
        .collect()
}

/// A path of the bench as it can be spelled from its folder `away`; other words as they are.
fn respelled(bench: &Bench, word: &str) -> String {
    let path = word.split('@').next().unwrap_or_default();
    match bench.path(path).exists() {
        true => format!("../away/../{word}"),
        false => word.to_owned(),
    }
}

#[test]
fn outputs_hold_no_path_as_typed() {
    with_verbs(|bench, call, ending, _| {
        let name = name(call, ending);
        fs::create_dir_all(bench.path("away")).unwrap();
        let plain = bench.inhand(&[call, &["-o", &name, "-q"]].concat());
        let away: Vec<String> = call.iter().map(|word| respelled(bench, word)).collect();
        let output = Command::new(env!("CARGO_BIN_EXE_inhand"))
            .args(&away)
            .args(["-o", &name, "-q"])
            .current_dir(bench.path("away"))
            .output()
            .expect("the binary under test runs");
        assert_eq!(
            plain.status.code(),
            output.status.code(),
            "{away:?}: {}",
            stderr(&output)
        );
        let [own, other] = [name.clone(), format!("away/{name}")].map(|file| bench.bytes(&file));
        assert!(own == other, "{call:?} and {away:?}");
    });
}

#[test]
fn outputs_go_into_new_folders_through_fifos_and_through_links() {
    with_verbs(|bench, call, ending, _| {
        let name = name(call, ending);
        let new = format!("new/{}/x/{name}", call[0]);
        let to = |output: &str| {
            // Checks that data passes have other exit codes.
            let output = bench.inhand(&[call, &["-o", output, "--force", "-q"]].concat());
            assert!(
                matches!(output.status.code(), Some(0 | 3)),
                "{call:?}: {}",
                stderr(&output)
            );
        };
        to(&new);
        let expected = bench.bytes(&new);

        let fifo = bench.path(&format!("fifo-{name}"));
        let made = Command::new("mkfifo").arg(&fifo).status();
        assert!(made.expect("mkfifo runs").success());
        let from = fifo.clone();
        let reader = thread::spawn(move || fs::read(from).expect("a FIFO is read"));
        to(&format!("fifo-{name}"));
        assert!(reader.join().unwrap() == expected, "{call:?} to a FIFO");
        assert!(fs::symlink_metadata(fifo).unwrap().file_type().is_fifo());

        bench.write(&format!("linked/{name}"), "earlier");
        let mode = fs::Permissions::from_mode(0o640);
        fs::set_permissions(bench.path(&format!("linked/{name}")), mode).unwrap();
        symlink(
            format!("linked/{name}"),
            bench.path(&format!("link-{name}")),
        )
        .unwrap();
        to(&format!("link-{name}"));
        assert!(bench.path(&format!("link-{name}")).is_symlink(), "{call:?}");
        assert!(
            bench.bytes(&format!("linked/{name}")) == expected,
            "{call:?}"
        );
        let replaced = fs::metadata(bench.path(&format!("linked/{name}"))).unwrap();
        assert_eq!(replaced.permissions().mode() & 0o777, 0o640, "{call:?}");
    });
}

#[test]
fn no_verb_replaces_what_it_reads() {
    with_verbs(|bench, call, ending, inputs| {
        for (n, input) in inputs.iter().enumerate() {
            let before = bench.bytes(input);
            let name = format!("{n}-{}", name(call, ending));
            let [soft, hard] = ["soft", "hard"].map(|kind| format!("{kind}-{name}"));
            symlink(input, bench.path(&soft)).unwrap();
            fs::hard_link(bench.path(input), bench.path(&hard)).unwrap();
            let around = format!("session/../{soft}");
            for output in [&*soft, &hard, &around] {
                let output = bench.inhand(&[call, &["-o", output, "--force"]].concat());
                let message = stderr(&output);
                assert_eq!(output.status.code(), Some(2), "{call:?} {input}: {message}");
                assert!(
                    message.contains("also an input"),
                    "{call:?} {input}: {message}"
                );
            }
            assert!(bench.bytes(input) == before, "{call:?} {input}");
        }
        let nowhere = format!("nowhere-{}", name(call, ending));
        symlink("gone", bench.path(&nowhere)).unwrap();
        let output = bench.inhand(&[call, &["-o", &nowhere, "--force"]].concat());
        assert_eq!(
            output.status.code(),
            Some(2),
            "{call:?}: {}",
            stderr(&output)
        );
        assert!(!bench.path("gone").exists(), "{call:?}");
    });
}

#[test]
fn the_mask_of_the_user_counts_and_standard_output_may_be_a_file() {
    let bench = Bench::csv();
    let inhand = env!("CARGO_BIN_EXE_inhand");
    let script = format!(
        "umask 027; {inhand} convert {TAKE} -o new/a.mcap -q && {inhand} layout -o /dev/stdout -q > l.json"
    );
    let status = Command::new("sh")
        .args(["-c", &script])
        .current_dir(bench.folder.path())
        .status();
    assert!(status.unwrap().success());
    let mode = |name: &str| fs::metadata(bench.path(name)).unwrap().permissions().mode() & 0o777;
    assert_eq!((mode("new"), mode("new/a.mcap")), (0o750, 0o640));
    assert!(bench.ok(&["layout"]).as_bytes() == bench.bytes("l.json"));
}

#[test]
fn nothing_is_beside_a_device() {
    let bench = Bench::csv();
    symlink("/dev/null", bench.path("null.csv")).unwrap();
    symlink("/dev/null", bench.path("null")).unwrap();
    let before = bench.files(".");
    bench.ok(&["export", TAKE, "-o", "null.csv"]);
    bench.ok(&["export", TAKE, "-o", "null"]);
    let learn = words("learn TAKE --stride 10 --rank 4..8:4 --max-iterations 2 -o null");
    bench.ok(&learn.iter().map(String::as_str).collect::<Vec<_>>());
    assert_eq!(bench.files("."), before);
}

/// A call in the folder of a bench.
fn start(bench: &Bench, args: &[&str]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_inhand"))
        .args(args)
        .current_dir(bench.folder.path())
        .env("TMPDIR", bench.folder.path().join("tmp"))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("the binary under test runs")
}

fn signal(child: &Child, signal: &str) {
    let id = child.id().to_string();
    assert!(
        Command::new("kill")
            .args([signal, &id])
            .status()
            .expect("kill runs")
            .success()
    );
}

fn wait_for(path: &Path) {
    while !path.exists() {
        thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn a_folder_is_written_by_one_process_at_a_time() {
    let bench = Bench::csv();
    let run = [&["run", "session", "-o", "out"], &SMALL[..]].concat();
    let mut first = start(&bench, &run);
    wait_for(&bench.path("out/.inhand-unfinished-holder"));
    signal(&first, "-STOP");
    let refused = bench.inhand(&run);
    let batch = bench.inhand(&["batch", "session", "-o", "."]);
    // A single file in the folder is written, and nothing of the first process is removed.
    bench.ok(&["convert", TAKE, "-o", "out/other.mcap"]);
    assert_eq!(unfinished(&bench, "out"), [".inhand-unfinished-holder"]);
    signal(&first, "-CONT");
    assert!(first.wait().unwrap().success());
    assert_eq!(refused.status.code(), Some(2));
    let holder = format!("out: process {} (", first.id());
    assert!(stderr(&refused).contains(&holder), "{}", stderr(&refused));
    assert!(stderr(&refused).contains("is writing into this folder"));
    assert_ne!(
        batch.status.code(),
        Some(2),
        "a folder above is another one"
    );
    assert_eq!(unfinished(&bench, "."), [""; 0]);
}

#[test]
fn files_of_living_processes_stay() {
    let bench = Bench::csv();
    fs::create_dir(bench.path("tmp")).unwrap();
    for name in ["a", "b"] {
        let made = Command::new("mkfifo").arg(bench.path(name)).status();
        assert!(made.unwrap().success());
    }
    // Without a reader both wait with what they have written.
    let waiting = |name: &str, files: usize| {
        let child = start(&bench, &["convert", TAKE, "-o", name]);
        while bench.files("tmp").len() < files {
            thread::sleep(Duration::from_millis(1));
        }
        child
    };
    let mut first = waiting("a", 1);
    let mut killed = waiting("b", 2);
    signal(&killed, "-KILL");
    killed.wait().unwrap();
    assert_eq!(bench.files("tmp").len(), 2);
    // Removes what the killed one left, and not what the first one waits with.
    let mut last = waiting("b", 2);
    for (name, child) in [("a", &mut first), ("b", &mut last)] {
        let written = fs::read(bench.path(name)).unwrap();
        assert!(
            child.wait().unwrap().success() && !written.is_empty(),
            "{name}"
        );
    }
    assert_eq!(bench.files("tmp"), [""; 0]);
}

/// Calls that write several files or write for long, into `killed/NAME`, by that name.
const LONG: [(&str, &str); 8] = [
    (
        "r",
        "run session --methods line --stride 10 --rank 4 --max-iterations 2",
    ),
    (
        "b",
        "batch session --methods line --stride 10 --rank 4 --max-iterations 2",
    ),
    ("t", "convert TAKE session/test/cube_test_01.csv"),
    ("c", "cut ann.mcap --event slip"),
    (
        "w",
        "learn TAKE --stride 10 --rank 4 --max-iterations 2 --work killed/w/work",
    ),
    ("m", "report merge out -o killed/m/s.csv"),
    ("s", "simulate --takes 2 --duration 3"),
    (DEMO, "demo"),
];
/// Too long for the tests of every day.
const DEMO: &str = "d";

/// Kill points over all writing calls; `INHAND_KILLS=1000` for the long run, which has the demo too.
#[test]
fn a_killed_process_leaves_nothing_torn_and_the_next_one_clears_up() {
    let points: usize =
        std::env::var("INHAND_KILLS").map_or(1, |number| number.parse().expect("a number"));
    let bench = bench();
    bench.ok(&[
        "annotate", "add", TEST, "--at", "1..2", "--at", "3..4", "--label", "slip", "-o",
        "ann.mcap",
    ]);
    let long = LONG
        .iter()
        .filter(|(name, _)| *name != DEMO || points > LONG.len())
        .map(|&(name, call)| {
            let output = match name {
                "w" => "/d.mcap",
                "m" => "/s.html",
                _ => "",
            };
            (name.to_owned(), call, format!("killed/{name}{output}"))
        });
    let short = (0..)
        .zip(VERBS)
        .map(|(n, (call, ending, _))| (format!("v{n}"), call, format!("killed/v{n}/out.{ending}")));
    let calls: Vec<_> = long.chain(short).collect();
    let each = points.div_ceil(calls.len());
    for (name, call, output) in calls {
        let folder = format!("killed/{name}");
        let call = words(&format!("{call} -o {output} --force"));
        let call: Vec<&str> = call.iter().map(String::as_str).collect();
        let clear = || drop(fs::remove_dir_all(bench.path(&folder)));
        let begin = Instant::now();
        bench.ok(&call);
        let whole = begin.elapsed();
        let expected = contents(&bench, &folder);
        for point in 0..each {
            clear();
            let mut child = start(&bench, &call);
            thread::sleep(whole.mul_f64((point as f64 + 0.7) / each as f64));
            // It may have ended.
            let _ = child.kill();
            child.wait().unwrap();
            for (file, bytes) in contents(&bench, &folder) {
                let is_whole = expected
                    .iter()
                    .any(|(name, whole)| *name == file && *whole == bytes);
                let is_unfinished = file.contains(".inhand-unfinished-");
                assert!(
                    is_whole || is_unfinished || file.starts_with("work/"),
                    "{call:?}: {file} is torn"
                );
            }
            bench.ok(&call);
            assert!(contents(&bench, &folder) == expected, "{call:?}");
        }
        clear();
    }
}

/// Every file of a folder but records of times, which differ.
fn contents(bench: &Bench, folder: &str) -> Vec<(String, Vec<u8>)> {
    let files = bench.files(folder).into_iter();
    let files = files.filter(|file| !file.ends_with("run.json") && !file.ends_with("batch.json"));
    files
        .map(|file| (file.clone(), bench.bytes(&format!("{folder}/{file}"))))
        .collect()
}
