//! Formats of capture files and the choice between them.

use inhand_model::Recording;

use crate::error::CaptureError;
use crate::header::Opened;
use crate::motive::row_typed;
use crate::settings::ReadSettings;
use crate::text::{excerpt, without_byte_order_mark};
use crate::{c3d, motive, qualisys, trc};

/// A format of capture files.
pub(crate) struct Format {
    /// Extension of its files.
    pub(crate) extension: &'static str,
    looks_like: fn(&[u8]) -> bool,
    pub(crate) reader: Reader,
}

/// Reader of the files of a format, from the first byte after a byte-order mark.
pub(crate) enum Reader {
    /// Row by row after a header, so that memory need not grow with the take.
    Rows(fn(&[u8], &str, &ReadSettings) -> Result<Opened, CaptureError>),
    /// All at once.
    Whole(fn(&[u8], &str, &ReadSettings) -> Result<Recording, CaptureError>),
}

/// Every format.
pub(crate) static FORMATS: &[Format] = &[
    Format::new("c3d", c3d::looks_like, Reader::Whole(c3d::read)),
    Format::new("tsv", qualisys::looks_like, Reader::Rows(qualisys::open)),
    Format::new("trc", trc::looks_like, Reader::Rows(trc::open)),
    Format::new("csv", motive::looks_like, Reader::Rows(motive::open)),
    Format::new("csv", row_typed::looks_like, Reader::Whole(row_typed::read)),
];

impl Format {
    const fn new(extension: &'static str, looks_like: fn(&[u8]) -> bool, reader: Reader) -> Self {
        Self {
            extension,
            looks_like,
            reader,
        }
    }

    /// The format of a file that begins with these bytes, and the bytes after a byte-order mark.
    pub(crate) fn detect<'a>(
        bytes: &'a [u8],
        file: &str,
    ) -> Result<(&'static Self, &'a [u8]), CaptureError> {
        let bytes = without_byte_order_mark(bytes, file)?;
        let found = (FORMATS.iter()).find(|format| (format.looks_like)(bytes));
        match found {
            Some(format) => Ok((format, bytes)),
            None => Err(Self::unknown(bytes, file)),
        }
    }

    fn unknown(bytes: &[u8], file: &str) -> CaptureError {
        let line = bytes.split(|&b| b == b'\n' || b == b'\r').next();
        let found = match line.filter(|_| !bytes.is_empty()) {
            Some(line) => format!("{:?}", excerpt(line)),
            None => "an empty file".to_owned(),
        };
        let problem = format!(
            "not a capture file: expected Motive CSV (starts with \"Format Version,\"), Qualisys \
             TSV (starts with \"NO_OF_FRAMES\"), TRC (starts with \"PathFileType\") or C3D, found \
             {found}"
        );
        CaptureError::in_file(file, problem)
    }
}
