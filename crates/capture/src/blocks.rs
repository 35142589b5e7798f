//! Takes read block by block, for files of any length.

use std::io::Read;

use inhand_model::{Finding, Recording};

use crate::assembly::{Assembly, Opened, Text};
use crate::error::CaptureError;
use crate::lines::Lines;
use crate::settings::ReadSettings;
use crate::table::Extent;
use crate::{motive, qualisys, text, trc};

/// Most samples of a block.
const BLOCK_SAMPLES: usize = 16 * 1024;

/// Reads a header from the beginning of a file.
type Open = fn(&[u8], &str, &ReadSettings) -> Result<Opened, CaptureError>;

/// Whether a file that starts like this has its take in rows of one kind, so that [`Blocks`] reads
/// it. The row-typed Motive CSV before 1.2 names its markers only in its rows, and is read whole.
pub fn has_even_rows(beginning: &[u8]) -> bool {
    let text = beginning
        .strip_prefix(text::BYTE_ORDER_MARK)
        .unwrap_or(beginning);
    qualisys::looks_like(text) || trc::looks_like(text) || motive::looks_like(text)
}

/// A Motive CSV, Qualisys TSV or TRC file, read some thousand samples at a time: memory does not
/// grow with the length of the take.
///
/// ```
/// use inhand_capture::{Blocks, Extent, ReadSettings};
///
/// let csv = b"\
/// Format Version,1.23,Take Name,demo,Export Frame Rate,100,Length Units,Meters
/// ,Type,Marker,Marker,Marker
/// ,Name,Thumb,Thumb,Thumb
/// ,ID,A,A,A
/// ,,Position,Position,Position
/// Frame,Time (Seconds),X,Y,Z
/// 0,0.00,0.1,0.2,0.3
/// 2,0.02,0.1,0.2,
/// ";
/// let mut extent = Extent::default();
/// extent.add(csv);
/// let mut blocks = Blocks::open(&csv[..], extent, "demo.csv", &ReadSettings::default())?;
/// assert_eq!(blocks.header().markers[0].name, "Thumb");
/// let mut samples = 0;
/// while let Some(block) = blocks.next_block()? {
///     samples += block.len();
/// }
/// assert_eq!(samples, 3); // the frame left out is a missing sample
/// assert_eq!(blocks.findings().len(), 3); // no start time, a jump, a blank cell
/// # Ok::<(), inhand_capture::CaptureError>(())
/// ```
pub struct Blocks<R> {
    assembly: Assembly<Text<R>>,
    header: Recording,
}

impl<R: Read> Blocks<R> {
    /// Reads the header. `extent` is that of the whole file: it bounds how many missing samples a
    /// jump in the frame column may stand for.
    ///
    /// # Errors
    ///
    /// As for [`read`](crate::read).
    pub fn open(
        input: R,
        extent: Extent,
        file_name: &str,
        settings: &ReadSettings,
    ) -> Result<Self, CaptureError> {
        let mut lines = Lines::new(input, file_name);
        let opened = lines.head(|head| {
            let text = text::without_byte_order_mark(head, file_name)?;
            let mut opened = open_of(text)(text, file_name, settings)?;
            opened.data_start += head.len() - text.len();
            Ok(opened)
        })?;
        lines.skip_head(opened.data_start, opened.first_data_line);
        let mut assembly = Assembly::of_text(lines, opened, extent, false);
        let header = assembly.take_block()?;
        Ok(Self { assembly, header })
    }

    /// The take without any sample: its name, clock, source, markers and bodies.
    pub fn header(&self) -> &Recording {
        &self.header
    }

    /// The samples that follow those of the block before, as a take that starts where they do;
    /// `None` after the last ones. Its findings are empty: see [`Blocks::findings`].
    ///
    /// # Errors
    ///
    /// As for [`read`](crate::read); and where there is no sample at all.
    pub fn next_block(&mut self) -> Result<Option<Recording>, CaptureError> {
        if !self.assembly.advance(BLOCK_SAMPLES)? {
            return Ok(None);
        }
        self.assembly.take_block().map(Some)
    }

    /// What was odd about the file; complete after the last block.
    pub fn findings(&self) -> Vec<Finding> {
        self.assembly.findings()
    }
}

fn open_of(text: &[u8]) -> Open {
    if qualisys::looks_like(text) {
        qualisys::open
    } else if trc::looks_like(text) {
        trc::open
    } else {
        motive::open
    }
}

/// Reads a whole take from memory.
pub(crate) fn read_whole(
    open: Open,
    bytes: &[u8],
    file_name: &str,
    settings: &ReadSettings,
) -> Result<Recording, CaptureError> {
    let text = text::without_byte_order_mark(bytes, file_name)?;
    let opened = open(text, file_name, settings)?;
    let mut extent = Extent::default();
    extent.add(text);
    let mut lines = Lines::new(&text[opened.data_start..], file_name);
    lines.skip_head(0, opened.first_data_line);
    let mut assembly = Assembly::of_text(lines, opened, extent, true);
    assembly.read_whole()
}
