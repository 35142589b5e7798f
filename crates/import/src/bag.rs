//! ROS 2 bag folders and packed files.

use std::borrow::Cow;

use inhand_container::{is_zstd, unpack_zstd};

/// The file that makes a folder a ROS 2 bag.
pub const BAG_FACTS: &str = "metadata.yaml";

/// Converts what ROS recorders wrote before MCAP.
const CONVERT: &str = "`mcap convert FILE take.mcap` (or, with ROS 2, `ros2 bag convert` with storage_id: mcap) makes MCAP of it";

/// Formats that are recognised and not read: first bytes, name, remedy.
const UNREAD: [(&[u8], &str, &str); 6] = [
    (
        b"SQLite format 3\0",
        "a ROS 2 bag in SQLite (.db3)",
        CONVERT,
    ),
    (b"#ROSBAG V", "a ROS 1 bag", CONVERT),
    (
        b"\x1F\x8B",
        "compressed with gzip",
        "unpack it with `gunzip FILE`",
    ),
    (
        b"\x04\x22\x4D\x18",
        "compressed with lz4",
        "unpack it with `lz4 -d FILE`",
    ),
    (
        b"BZh",
        "compressed with bzip2",
        "unpack it with `bunzip2 FILE`",
    ),
    (
        b"\xFD7zXZ\0",
        "compressed with xz",
        "unpack it with `unxz FILE`",
    ),
];

/// Endings of packed files; only zstd is read.
const PACKED: [&str; 6] = ["zstd", "zst", "gz", "lz4", "bz2", "xz"];

/// The name of a file without the ending of a compression.
pub fn unpacked_name(name: &str) -> &str {
    let is_packed = |ending: &str| PACKED.iter().any(|one| ending.eq_ignore_ascii_case(one));
    match name.rsplit_once('.') {
        Some((stem, ending)) if is_packed(ending) => stem,
        _ => name,
    }
}

/// The content of a file, unpacked where zstd packed it.
///
/// # Errors
///
/// Why a file of another compression or storage is not read, with the command that helps.
pub fn unpack_file(bytes: &[u8]) -> Result<Cow<'_, [u8]>, String> {
    if is_zstd(bytes) {
        let unpacked = unpack_zstd(bytes);
        let damaged =
            |error| format!("damaged: expected zstd data, found {error}; copy the file again");
        return unpacked.map(Cow::Owned).map_err(damaged);
    }
    match UNREAD.iter().find(|(first, ..)| bytes.starts_with(first)) {
        Some((_, what, remedy)) => Err(format!("{what}, which is not read: {remedy}")),
        None => Ok(Cow::Borrowed(bytes)),
    }
}

/// The names of a bag's files in their order, from its `metadata.yaml`.
///
/// # Errors
///
/// Why the bag is not read, with the command that helps.
pub fn bag_files(facts: &str) -> Result<Vec<String>, String> {
    // Recorders write one key a line; a list begins on the line after its key.
    let plain = |text: &str| text.trim().trim_matches(['"', '\'']).to_owned();
    let value = |key: &str| {
        let mut lines = facts.lines();
        let value = lines.find_map(|line| line.trim().strip_prefix(key)?.strip_prefix(':'));
        value.map(plain).unwrap_or_default()
    };
    if value("storage_identifier") == "sqlite3" {
        return Err(format!(
            "storage sqlite3 (.db3), which is not read: {CONVERT}"
        ));
    }
    let compression = value("compression_format");
    if !["", "zstd"].contains(&compression.as_str()) {
        return Err(format!(
            "compressed with {compression}, which is not read: with ROS 2, `ros2 bag convert` without a \
             compression_format unpacks it"
        ));
    }
    let lines = facts
        .lines()
        .skip_while(|line| line.trim() != "relative_file_paths:");
    let items = lines
        .skip(1)
        .map_while(|line| line.trim().strip_prefix("- "));
    // Files of old bags are named with the folder in front; all are in it.
    let name = |item: &str| {
        plain(item)
            .rsplit('/')
            .next()
            .unwrap_or_default()
            .to_owned()
    };
    let files: Vec<String> = items.map(name).collect();
    match files.is_empty() {
        true => Err(
            "expected a list relative_file_paths with the files of a bag, found none".to_owned(),
        ),
        false => Ok(files),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As `ros2 bag record` writes it, shortened.
    const FACTS: &str = "rosbag2_bagfile_information:
  version: 5
  storage_identifier: mcap
  relative_file_paths:
    - take1_0.mcap.zstd
    - \"take1/take1_1.mcap.zstd\"
  topics_with_message_count:
    - topic_metadata:
        name: /markers
  compression_format: \"zstd\"
  compression_mode: FILE
";

    #[test]
    fn files_of_a_bag_are_those_that_it_lists() {
        let files = ["take1_0.mcap.zstd", "take1_1.mcap.zstd"];
        assert_eq!(bag_files(FACTS).unwrap(), files);
        let refused = |from: &str, to: &str| bag_files(&FACTS.replace(from, to)).unwrap_err();
        assert!(refused("identifier: mcap", "identifier: sqlite3").contains("mcap convert"));
        assert!(refused("\"zstd\"", "lz4").contains("compressed with lz4"));
        assert!(refused("relative_file_paths", "paths").contains("relative_file_paths"));
    }

    #[test]
    fn compressions_that_are_not_read_are_named() {
        for (bytes, word) in [
            (&b"SQLite format 3\0..."[..], "SQLite"),
            (b"BZh91", "bunzip2"),
        ] {
            let refused = unpack_file(bytes).unwrap_err();
            assert!(refused.contains(word), "{refused}");
        }
        assert_eq!(
            &unpack_file(b"Format Version,1.23").unwrap()[..],
            b"Format Version,1.23"
        );
        assert!(
            unpack_file(b"\x28\xB5\x2F\xFDnot")
                .unwrap_err()
                .contains("zstd")
        );
    }
}
