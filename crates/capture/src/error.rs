//! Errors of reading and writing vendor files.

use inhand_model::Setting;
use inhand_model::{ClockError, RecordingError};
use thiserror::Error;

/// Why a vendor file cannot be read or written. Lines and columns count from 1, as a spreadsheet
/// shows them.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CaptureError {
    /// The bytes are of no format that is read here.
    #[error(
        "{file}: not a capture file: expected Motive CSV (starts with \"Format Version,\"), \
         Qualisys TSV (starts with \"NO_OF_FRAMES\"), TRC (starts with \"PathFileType\") or C3D, \
         found {found}"
    )]
    UnknownFormat {
        /// The file.
        file: String,
        /// How it starts.
        found: String,
    },
    /// A format that is known, but not read.
    #[error("{file}: {found} is not read yet: {hint}")]
    UnsupportedFormat {
        /// The file.
        file: String,
        /// The format it is in.
        found: String,
        /// What to do instead.
        hint: &'static str,
    },
    /// Text that is not UTF-8, or not text.
    #[error("{file}, line {line}: expected UTF-8 text, found {found}: {hint}")]
    Encoding {
        /// The file.
        file: String,
        /// Line of the first byte that does not fit.
        line: usize,
        /// What that byte is.
        found: String,
        /// What to do.
        hint: &'static str,
    },
    /// The header is cut or damaged.
    #[error("{file}, line {line}: expected {expected}, found {found}: {hint}")]
    Header {
        /// The file.
        file: String,
        /// The line.
        line: usize,
        /// What belongs there.
        expected: String,
        /// What is there.
        found: String,
        /// What to do.
        hint: &'static str,
    },
    /// The header has no value, or none that makes sense, for a key that is needed.
    #[error("{file}, line {line}: \"{key}\" is {found}: expected {expected}")]
    HeaderValue {
        /// The file.
        file: String,
        /// The line of the key.
        line: usize,
        /// The key.
        key: &'static str,
        /// A value that would do.
        expected: &'static str,
        /// The value found, or that there is none.
        found: String,
    },
    /// Columns of a marker or body that do not make a position or pose.
    #[error(
        "{file}, line {line}, column {column}: {entity} has {found}: expected {expected}; \
         export the take again with all its columns"
    )]
    Columns {
        /// The file.
        file: String,
        /// Line of the axis labels.
        line: usize,
        /// First column of the entity.
        column: usize,
        /// The marker or body.
        entity: String,
        /// The columns it needs.
        expected: &'static str,
        /// The columns it has.
        found: String,
    },
    /// The file does not say in which unit its lengths are.
    #[error(
        "{file}: the header has no \"{key}\": say it with {} \
         (metres, centimetres, millimetres, inches, feet)",
        Setting::Units
    )]
    NoUnits {
        /// The file.
        file: String,
        /// The key that would state it.
        key: &'static str,
    },
    /// The file does not say in which order its Euler angles apply.
    #[error(
        "{file}: the header has no \"Rotation Type\" and {entity} has three rotation columns: say \
         in which order the angles apply with {} (XYZ, XZY, YXZ, YZX, ZXY or ZYX){}",
        Setting::RotationOrder,
        if *.no_units {
            format!(
                "; it has no \"Length Units\" either: say it with {} (metres, centimetres, \
                 millimetres, inches, feet)",
                Setting::Units
            )
        } else {
            String::new()
        }
    )]
    NoRotationOrder {
        /// The file.
        file: String,
        /// The first body concerned.
        entity: String,
        /// Whether the unit of length is not stated either.
        no_units: bool,
    },
    /// A setting says something else than the file.
    #[error(
        "{file}: {option} says {given}, but the file itself states {stated}: leave {option} out"
    )]
    Contradiction {
        /// The file.
        file: String,
        /// The setting.
        option: String,
        /// What the setting says.
        given: String,
        /// What the file says.
        stated: String,
    },
    /// A line of which no end is in sight.
    #[error(
        "{file}, line {line}: expected lines of at most {limit_bytes} bytes, found a longer one: is \
         it a binary file, or did it lose its line ends?"
    )]
    LineTooLong {
        /// The file.
        file: String,
        /// The line.
        line: usize,
        /// The longest line that is read.
        limit_bytes: usize,
    },
    /// A row with fewer cells than the header promises.
    #[error("{file}, line {line}: expected {expected} cells, found {found}: the row is cut off")]
    TooFewCells {
        /// The file.
        file: String,
        /// The line.
        line: usize,
        /// Cells that the header promises.
        expected: usize,
        /// Cells of the row.
        found: usize,
    },
    /// A row with more cells than the header has columns.
    #[error(
        "{file}, line {line}, column {column}: expected no more than the header's {expected} \
         columns, found {found:?}: is a comma used as decimal point?"
    )]
    TooManyCells {
        /// The file.
        file: String,
        /// The line.
        line: usize,
        /// The first column without a header.
        column: usize,
        /// Columns of the header.
        expected: usize,
        /// What that column holds.
        found: String,
    },
    /// A cell that is no number.
    #[error(
        "{file}, line {line}, column {column} ({entity}): expected {expected}, found {found:?}"
    )]
    Cell {
        /// The file.
        file: String,
        /// The line.
        line: usize,
        /// The column.
        column: usize,
        /// What the column is, such as `"Ring" Position Y`.
        entity: String,
        /// What belongs there.
        expected: &'static str,
        /// What is there.
        found: String,
    },
    /// Frame numbers that do not rise.
    #[error(
        "{file}, line {line}: frame {found} follows frame {previous}: expected rising frame \
         numbers; are two takes joined in this file?"
    )]
    FrameOrder {
        /// The file.
        file: String,
        /// The line.
        line: usize,
        /// Frame of the row before.
        previous: i64,
        /// Frame of the row.
        found: i64,
    },
    /// Frame numbers that leave out so much that the rows cannot be one take.
    #[error(
        "{file}, line {line}: frame {found} follows frame {previous}: {left_out} frames left out \
         in a file of {rows} rows cannot be one take (at most {limit} are taken as missing \
         samples); split the file there"
    )]
    FrameJump {
        /// The file.
        file: String,
        /// The line.
        line: usize,
        /// Frame of the row before.
        previous: i64,
        /// Frame of the row.
        found: i64,
        /// Frames left out so far.
        left_out: u64,
        /// Rows of the file, at most.
        rows: u64,
        /// Frames that may be left out.
        limit: u64,
    },
    /// Bytes of a binary file that do not make sense.
    #[error(
        "{file}: not a sound {format} file: at byte {offset} expected {expected}, found {found}; \
         copy the file again or export the take anew"
    )]
    Binary {
        /// The file.
        file: String,
        /// What kind of file it is.
        format: &'static str,
        /// The byte, counted from 0.
        offset: usize,
        /// What belongs there.
        expected: String,
        /// What is there.
        found: String,
    },
    /// A header without any row of data.
    #[error("{file}: the header is followed by no samples: was the export interrupted?")]
    NoSamples {
        /// The file.
        file: String,
    },
    /// A rate that no clock can have.
    #[error("{file}: {source}")]
    Clock {
        /// The file.
        file: String,
        /// Why.
        source: ClockError,
    },
    /// The parts read do not make a recording.
    #[error("{file}: {source}")]
    Recording {
        /// The file.
        file: String,
        /// Why.
        source: RecordingError,
    },
    /// The input cannot be read.
    #[error("{file}: cannot read on: {source}")]
    Read {
        /// The file.
        file: String,
        /// Why.
        source: std::io::Error,
    },
    /// A recording with more than a format can count.
    #[error(
        "{format} holds at most {most} {what}, the recording has {found}: write another format"
    )]
    TooLarge {
        /// The format.
        format: &'static str,
        /// Of what there is too much.
        what: &'static str,
        /// What the format can count.
        most: usize,
        /// What there is.
        found: usize,
    },
    /// The output cannot be written.
    #[error("cannot write {format}: {source}")]
    Output {
        /// What kind of file it is.
        format: &'static str,
        /// Why.
        source: std::io::Error,
    },
    /// The output cannot be written.
    #[error("cannot write Motive CSV: {source}")]
    Write {
        /// Why.
        #[from]
        source: std::io::Error,
    },
}
