//! Real and simulated recordings that are not part of this repository: the folder named by
//! `INHAND_CORPUS`. Without it every test here says so and checks nothing.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod c3d;
mod capture;
mod check;
mod containers;
mod faults;
mod files;
mod odd_files;
#[path = "../cli/plant.rs"]
mod plant;
mod real;
mod ros2;
mod sessions;

use std::io::Write as _;
use std::path::PathBuf;
use std::process::{Command, Output};

use serde_json::Value;

/// The corpus, or `None` after saying that there is none.
fn corpus() -> Option<PathBuf> {
    let folder = std::env::var_os("INHAND_CORPUS").map(PathBuf::from);
    match &folder {
        None => {
            // Straight to stderr: what macros print is hidden while tests pass.
            let message = "NOT RUN: INHAND_CORPUS names no folder with recordings";
            writeln!(std::io::stderr(), "{message}").expect("stderr can be written");
        }
        Some(folder) => assert!(
            folder.is_dir(),
            "INHAND_CORPUS: {} is no folder",
            folder.display()
        ),
    }
    folder
}

fn inhand(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_inhand"))
        .args(args)
        .output()
        .expect("the binary under test runs")
}

fn ok(args: &[&str]) -> String {
    let output = inhand(args);
    assert_eq!(
        output.status.code(),
        Some(0),
        "inhand {args:?}\n{}",
        stderr(&output)
    );
    String::from_utf8(output.stdout).expect("output is UTF-8")
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn json(path: &std::path::Path) -> Value {
    let text = std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    serde_json::from_slice(&text).expect("the file is JSON")
}

fn text(path: &std::path::Path) -> &str {
    path.to_str().expect("paths of the corpus are UTF-8")
}
