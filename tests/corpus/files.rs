//! Single recordings of others.

use std::path::{Path, PathBuf};

use crate::{corpus, inhand, stderr, text};

#[test]
fn info_reads_every_recording_of_others() {
    let Some(corpus) = corpus() else { return };
    let files = mcap_files(&corpus.join("mcap"));
    assert!(files.len() > 430, "{} files", files.len());
    for file in files {
        let output = inhand(&["info", text(&file)]);
        // Of one, a chunk by itself, no message has a channel.
        let lossy = is_damaged(&file) || file.ends_with("zstd_chunk_with_padding.mcap");
        let expected = if lossy { 3 } else { 0 };
        assert_eq!(
            output.status.code(),
            Some(expected),
            "{}: {}",
            file.display(),
            stderr(&output)
        );
    }
}

#[test]
fn verify_finds_no_difference_in_sound_recordings_of_others() {
    let Some(corpus) = corpus() else { return };
    let files = mcap_files(&corpus.join("mcap"));
    let named: Vec<&str> = files.iter().map(|file| text(file)).collect();
    let output = inhand(&[&["verify", "--format", "json"], &named[..]].concat());
    assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
    let found: serde_json::Value =
        serde_json::from_slice(&output.stdout).expect("verify prints JSON");
    for file in found["files"].as_array().expect("files are listed") {
        let name = Path::new(file["file"].as_str().expect("files are named"));
        // Of the second, a chunk by itself, no message has a channel.
        let damaged = is_damaged(name) || name.ends_with("zstd_chunk_with_padding.mcap");
        assert_eq!(file["equal"], !damaged, "{file}");
    }
}

/// The one file of the corpus whose writer never finished.
pub(crate) fn is_damaged(file: &Path) -> bool {
    file.file_name()
        .is_some_and(|name| name == "chunk_not_closed.mcap")
}

pub(crate) fn mcap_files(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).expect("folders of the corpus can be read") {
        let path = entry.expect("folders of the corpus can be read").path();
        if path.is_dir() {
            files.extend(mcap_files(&path));
        } else if path.extension().is_some_and(|e| e == "mcap") && !path.ends_with("LICENSE.mcap") {
            files.push(path);
        }
    }
    files.sort();
    files
}
