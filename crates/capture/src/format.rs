//! Formats of capture files and the choice between them.

use inhand_model::Recording;

use crate::assembly::Open;
use crate::error::CaptureError;
use crate::settings::ReadSettings;
use crate::{c3d, motive, qualisys, text, trc};

/// A format of capture files.
pub(crate) struct Format {
    /// Extension of its files.
    pub(crate) extension: &'static str,
    looks_like: fn(&[u8]) -> bool,
    pub(crate) reader: Reader,
}

/// How files of a format are read.
pub(crate) enum Reader {
    /// Row by row after a header, so that memory need not grow with the take.
    Rows(Open),
    /// All at once.
    Whole(fn(&[u8], &str, &ReadSettings) -> Result<Recording, CaptureError>),
}

/// Every format, but for the row-typed Motive CSV, which [`motive::read`] tells apart itself.
pub(crate) const FORMATS: [Format; 4] = [
    Format {
        extension: "c3d",
        looks_like: c3d::looks_like,
        reader: Reader::Whole(c3d::read),
    },
    Format {
        extension: "tsv",
        looks_like: qualisys::looks_like,
        reader: Reader::Rows(qualisys::open),
    },
    Format {
        extension: "trc",
        looks_like: trc::looks_like,
        reader: Reader::Rows(trc::open),
    },
    Format {
        extension: "csv",
        looks_like: motive::looks_like,
        reader: Reader::Rows(motive::open),
    },
];

impl Format {
    /// The format of a file that begins with these bytes.
    pub(crate) fn sniff(beginning: &[u8]) -> Option<&'static Self> {
        let text = beginning.strip_prefix(text::BYTE_ORDER_MARK);
        let text = text.unwrap_or(beginning);
        const { &FORMATS }
            .iter()
            .find(|format| (format.looks_like)(text))
    }
}
