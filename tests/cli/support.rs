//! Running the binary on small simulated sessions.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;
use tempfile::TempDir;

/// A folder that vanishes, with a small session in it: two training takes and one test take of
/// 12 s, 100 Hz.
pub(crate) struct Bench {
    pub(crate) folder: TempDir,
}

/// Options that make learning on the small session possible and quick.
pub(crate) const SMALL: [&str; 6] = ["--stride", "10", "--rank", "12", "--max-iterations", "15"];

impl Bench {
    /// A session of Motive CSV takes.
    pub(crate) fn csv() -> Self {
        Self::simulated(&["--format", "csv"])
    }

    /// A session with more simulation options.
    pub(crate) fn simulated(options: &[&str]) -> Self {
        let bench = Self::empty();
        let sizes = ["--takes", "2", "--duration", "12", "--seed", "7"];
        let args = [&["simulate", "-o", "session"], &sizes[..], options].concat();
        bench.ok(&args);
        bench
    }

    /// Just the folder.
    pub(crate) fn empty() -> Self {
        Self {
            folder: tempfile::tempdir().expect("the system has a folder for temporary files"),
        }
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Runs `inhand` in the folder.
    pub(crate) fn inhand(&self, args: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_inhand"))
            .args(args)
            .current_dir(self.folder.path())
            .output()
            .expect("the binary under test runs")
    }

    /// Runs `inhand`, which must succeed; gives stdout.
    pub(crate) fn ok(&self, args: &[&str]) -> String {
        let output = self.inhand(args);
        assert_eq!(
            output.status.code(),
            Some(0),
            "inhand {args:?}\n{}",
            stderr(&output)
        );
        String::from_utf8(output.stdout).expect("output is UTF-8")
    }

    /// Runs the session into `out` with the options for small sessions.
    pub(crate) fn run(&self, out: &str, options: &[&str]) -> String {
        self.ok(&[&["run", "session", "-o", out], &SMALL[..], options].concat())
    }

    pub(crate) fn json(&self, name: &str) -> Value {
        serde_json::from_slice(&self.bytes(name)).expect("the file is JSON")
    }

    pub(crate) fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    pub(crate) fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        let path = self.path(name);
        let folder = path.parent().expect("a file in the folder has a parent");
        std::fs::create_dir_all(folder).expect("folders can be made");
        std::fs::write(path, content).expect("files can be written");
    }

    /// Changes the text of a file.
    pub(crate) fn edit(&self, name: &str, change: impl FnOnce(String) -> String) {
        let text = String::from_utf8(self.bytes(name)).expect("the file is text");
        self.write(name, change(text));
    }

    /// Every file below a folder, relative to it, sorted; empty where there is no such folder.
    pub(crate) fn files(&self, folder: &str) -> Vec<String> {
        fn walk(folder: &Path, root: &Path, found: &mut Vec<String>) {
            let Ok(entries) = std::fs::read_dir(folder) else {
                return;
            };
            for entry in entries.flatten() {
                let path = entry.path();
                if path.is_dir() {
                    walk(&path, root, found);
                } else if let Ok(relative) = path.strip_prefix(root) {
                    found.push(relative.to_string_lossy().into_owned());
                }
            }
        }
        let root = self.path(folder);
        let mut found = Vec::new();
        walk(&root, &root, &mut found);
        found.sort();
        found
    }
}

pub(crate) fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// An evaluation without what names its input files.
pub(crate) fn without_provenance(mut evaluation: Value) -> Value {
    let keys = evaluation
        .as_object_mut()
        .expect("an evaluation is an object");
    keys.remove("provenance");
    keys.remove("key");
    evaluation
}
