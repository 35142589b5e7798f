//! Bytes as text: byte-order marks, encodings, excerpts for messages.

use std::borrow::Cow;

use crate::error::CaptureError;

/// Longest excerpt of a file in a message, characters: enough for any cell, short of a screen line.
const EXCERPT_CHARS: usize = 40;

/// The mark that some programs put before UTF-8 text.
const BYTE_ORDER_MARK: &[u8] = b"\xEF\xBB\xBF";

/// The bytes after a UTF-8 byte-order mark, if there is one.
///
/// # Errors
///
/// UTF-16 is refused, which spreadsheets call "Unicode text".
pub(crate) fn without_byte_order_mark<'a>(
    bytes: &'a [u8],
    file: &str,
) -> Result<&'a [u8], CaptureError> {
    if bytes.starts_with(&[0xFF, 0xFE]) || bytes.starts_with(&[0xFE, 0xFF]) {
        return Err(not_utf8(file, 1, "UTF-16", "save it as UTF-8"));
    }
    Ok(bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes))
}

/// A header, which must be UTF-8 without NUL bytes. `first_line` is the line it starts on.
///
/// # Errors
///
/// The first byte that does not fit is refused with its line.
pub(crate) fn header_text<'a>(
    header: &'a [u8],
    first_line: usize,
    file: &str,
) -> Result<&'a str, CaptureError> {
    let line = |at: usize| first_line + count_lines(&header[..at]);
    if let Some(at) = memchr::memchr(0, header) {
        let hint = "is it a binary or damaged file?";
        return Err(not_utf8(file, line(at), "a NUL byte", hint));
    }
    std::str::from_utf8(header).map_err(|e| {
        let at = e.valid_up_to();
        let found = format!("the byte 0x{:02X}", header[at]);
        not_utf8(file, line(at), &found, "save it as UTF-8")
    })
}

fn not_utf8(file: &str, line: usize, found: &str, hint: &str) -> CaptureError {
    let problem = format_args!("expected UTF-8 text, found {found}: {hint}");
    CaptureError::in_line(file, line, problem)
}

/// Line ends in `bytes`.
pub(crate) fn count_lines(bytes: &[u8]) -> usize {
    memchr::memchr_iter(b'\n', bytes).count()
}

/// The beginning of some bytes of the file, short enough for a message.
pub(crate) fn excerpt(bytes: &[u8]) -> String {
    // A character has at most four bytes.
    let head = &bytes[..bytes.len().min(4 * EXCERPT_CHARS)];
    let text = String::from_utf8_lossy(head);
    let short: String = text.chars().take(EXCERPT_CHARS).collect();
    if short.len() < text.len() || head.len() < bytes.len() {
        format!("{short}…")
    } else {
        short
    }
}

/// The cells of a line between tabs: without spaces and quotes around them, and without the blank ones that programs
/// leave behind the last one.
pub(crate) fn cells(line: &str) -> Vec<&str> {
    let mut cells: Vec<&str> = line.split('\t').map(unquoted).collect();
    let used = cells.iter().rposition(|cell| !cell.is_empty());
    cells.truncate(used.map_or(0, |last| last + 1));
    cells
}

/// A cell without the quotes that spreadsheets put around text.
fn unquoted(cell: &str) -> &str {
    let cell = cell.trim();
    let inner = cell
        .strip_prefix('"')
        .and_then(|cell| cell.strip_suffix('"'));
    inner.map_or(cell, str::trim)
}

/// A file name without folders and extension: the take's name where the file states none.
pub(crate) fn stem(file_name: &str) -> &str {
    let name = file_name.rsplit(['/', '\\']).next().unwrap_or(file_name);
    match name.rsplit_once('.') {
        Some((stem, _)) if !stem.is_empty() => stem,
        _ => name,
    }
}

/// The name of the marker at index `k`, its number from 1 where it has none: what has a name can be chosen.
pub(crate) fn name_or_number(name: &str, k: usize) -> Cow<'_, str> {
    match name {
        "" => Cow::Owned((k + 1).to_string()),
        name => Cow::Borrowed(name),
    }
}

/// Whether a marker is named as Motive names those it cannot identify: `Unlabeled:108` or
/// `Unlabeled 1036`.
pub(crate) fn is_unlabelled(name: &str) -> bool {
    let name = name.to_ascii_lowercase();
    name.starts_with("unlabeled") || name.starts_with("unlabelled")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn excerpts_are_short_and_never_split_a_character() {
        assert_eq!(excerpt(b"1.0.24"), "1.0.24");
        let long = "上".repeat(1000);
        assert_eq!(excerpt(long.as_bytes()).chars().count(), EXCERPT_CHARS + 1);
        assert_eq!(excerpt(&[0xFF; 3]).chars().count(), 3);
    }

    #[test]
    fn cells_are_bare() {
        let line = "TIME_STAMP\t\"2024-05-06, 14:15\"\t\t 7 \t\t \t";
        assert_eq!(cells(line), ["TIME_STAMP", "2024-05-06, 14:15", "", "7"]);
        assert_eq!(cells("\t\t"), [""; 0]);
        assert_eq!(cells("\""), ["\""]);
    }

    #[test]
    fn stems() {
        assert_eq!(stem("/a/b.c/Take 1.12.csv"), "Take 1.12");
        assert_eq!(stem(r"C:\takes\one.csv"), "one");
        assert_eq!(stem(".csv"), ".csv");
    }

    #[test]
    fn encodings_that_are_refused_say_where() {
        let message = |bytes: &[u8]| header_text(bytes, 1, "a.csv").unwrap_err().to_string();
        assert_eq!(
            message(b"a\nb\xE9"),
            "a.csv, line 2: expected UTF-8 text, found the byte 0xE9: save it as UTF-8"
        );
        assert!(message(b"a\0").contains("NUL"));
        assert!(without_byte_order_mark(b"\xFF\xFEF\0", "a.csv").is_err());
        assert_eq!(without_byte_order_mark(b"\xEF\xBB\xBFa", "").unwrap(), b"a");
    }
}
