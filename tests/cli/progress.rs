//! The progress line on a terminal.

use std::fs::{File, OpenOptions};
use std::io::Read;
use std::process::{Child, Command, Stdio};

use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{Winsize, tcsetwinsize};

use crate::support::Bench;

/// A session and a pipe that nobody writes into.
fn bench() -> Bench {
    let bench = Bench::csv();
    let made = Command::new("mkfifo").arg(bench.path("pipe.csv")).status();
    assert!(made.expect("the system has pipes").success());
    bench
}

/// `inhand check` of a take, and of the pipe, which it waits for; and the terminal that it prints on.
fn check(bench: &Bench, options: &[&str]) -> (Child, File) {
    let terminal = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).expect("there are terminals");
    grantpt(&terminal).expect("it is ours");
    unlockpt(&terminal).expect("it is ours");
    let size = Winsize {
        ws_row: 24,
        ws_col: 60,
        ws_xpixel: 0,
        ws_ypixel: 0,
    };
    tcsetwinsize(&terminal, size).expect("it has a size");
    let name = ptsname(&terminal, Vec::new()).expect("it has a name");
    let name = name.to_str().expect("names are text").to_owned();
    let stderr = OpenOptions::new().read(true).write(true).open(name);
    let child = Command::new(env!("CARGO_BIN_EXE_inhand"))
        .args(["check", "session/test/cube_test_01.csv", "pipe.csv"])
        .args(options)
        .env("TERM", "xterm")
        .current_dir(bench.folder.path())
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(stderr.expect("it opens"))
        .spawn()
        .expect("the binary under test runs");
    (child, File::from(terminal))
}

/// Gives the pipe the take that was waited for; what the terminal shows then, and the exit code.
fn end(bench: &Bench, mut child: Child, mut terminal: File) -> (String, Option<i32>) {
    let take = bench.bytes("session/test/cube_test_01.csv");
    std::fs::write(bench.path("pipe.csv"), take).expect("somebody reads");
    let mut stdout = String::new();
    let pipe = child.stdout.as_mut().expect("stdout is a pipe");
    pipe.read_to_string(&mut stdout).expect("it prints text");
    assert!(
        !stdout.contains('\x1b') && !stdout.contains("left"),
        "{stdout}"
    );
    let status = child.wait().expect("it ends");
    let mut shown = Vec::new();
    // A terminal that nobody prints on ends with an error.
    let _ = terminal.read_to_end(&mut shown);
    (String::from_utf8_lossy(&shown).into_owned(), status.code())
}

#[test]
fn the_time_left_is_shown_in_one_line_that_vanishes() {
    let bench = bench();
    let (child, mut terminal) = check(&bench, &[]);
    let (mut shown, mut bytes) = (String::new(), [0; 256]);
    while !shown.contains(" left") {
        let count = terminal.read(&mut bytes).expect("it prints");
        shown += &String::from_utf8_lossy(&bytes[..count]);
    }
    let line = shown.rsplit('\n').next().expect("there is a last line");
    assert!(line.contains("checking  pipe.csv  about "), "{shown:?}");
    let (rest, code) = end(&bench, child, terminal);
    assert_eq!(code, Some(0), "{rest:?}");
    assert!(rest.ends_with("\r\x1b[2K"), "{rest:?}");
}

#[test]
fn quiet_is_quiet() {
    let bench = bench();
    let (child, terminal) = check(&bench, &["-q"]);
    // More than it takes until a line would be shown.
    std::thread::sleep(std::time::Duration::from_millis(2500));
    assert_eq!(end(&bench, child, terminal), (String::new(), Some(0)));
}
