//! Single files: each opens, or is refused with a reason that is right.

use std::path::{Path, PathBuf};

use crate::{corpus, inhand, ok, stderr, text};

/// Motive exports that must convert: file, options, frames.
const MOTIVE: [(&str, &[&str], u64); 6] = [
    ("v1.21_cmuphyscomp.csv", &[], 250),
    (
        "v1.22_euler_rigid-body-motion.csv",
        &["--units", "cm", "--rotation-order", "XYZ"],
        227,
    ),
    ("v1.23_gaps_aolab.csv", &[], 23480),
    ("v1.23_markers_mm_360hz_ha5dzs.csv", &[], 1353),
    ("v1.23_empty_ha5dzs.csv", &[], 1353),
    ("v1.23_quality_parse_optitrack_csv.csv", &[], 499),
];

/// Motive exports that cannot be read, and words of the reason.
const REFUSED: [(&str, &[&str]); 3] = [
    ("v1_olin.csv", &["v1"]),
    ("v1.1_olin.csv", &["v1"]),
    ("v1.22_euler_rigid-body-motion.csv", &["--units"]),
];

#[test]
fn motive_exports_convert() {
    let Some(corpus) = corpus() else { return };
    let folder = tempfile::tempdir().unwrap();
    for (file, options, frames) in MOTIVE {
        let input = corpus.join("real/motive").join(file);
        let output = folder.path().join(file).with_extension("mcap");
        ok(&[&["convert", text(&input), "-o", text(&output)], options].concat());
        let info: serde_json::Value =
            serde_json::from_str(&ok(&["info", text(&output), "--format", "json"])).unwrap();
        let samples = &info["metadata"]["inhand.recording"]["samples"];
        assert_eq!(
            samples.as_str(),
            Some(frames.to_string().as_str()),
            "{file}"
        );
    }
}

#[test]
fn what_cannot_be_read_says_why() {
    let Some(corpus) = corpus() else { return };
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("out.mcap");
    for (file, words) in REFUSED {
        let input = corpus.join("real/motive").join(file);
        let output = inhand(&["convert", text(&input), "-o", text(&target)]);
        assert!(matches!(output.status.code(), Some(1 | 2)), "{file}");
        for word in words {
            assert!(
                stderr(&output).contains(word),
                "{file}: {}",
                stderr(&output)
            );
        }
        assert!(!target.exists(), "{file}: nothing is written");
    }
}

#[test]
fn info_reads_every_recording_of_others() {
    let Some(corpus) = corpus() else { return };
    let files = mcap_files(&corpus.join("mcap"));
    assert!(files.len() > 430, "{} files", files.len());
    for file in files {
        let output = inhand(&["info", text(&file)]);
        let expected = if is_damaged(&file) { 3 } else { 0 };
        assert_eq!(
            output.status.code(),
            Some(expected),
            "{}: {}",
            file.display(),
            stderr(&output)
        );
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
