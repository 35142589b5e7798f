//! Takes read block by block, for files of any length.

use std::io::Read;

use inhand_model::{Finding, Recording};

use crate::assembly::{Assembly, Text};
use crate::error::CaptureError;
use crate::format::{Format, Reader};
use crate::lines::Lines;
use crate::settings::ReadSettings;
use crate::table::Extent;
use crate::{motive, text};

/// Most samples of a block.
const BLOCK_SAMPLES: usize = 16 * 1024;

/// Whether a file that starts like this has its take in rows of one kind, so that [`Blocks`] reads
/// it. The row-typed Motive CSV before 1.2 names its markers only in its rows, and is read whole.
pub fn has_even_rows(beginning: &[u8]) -> bool {
    matches!(
        Format::sniff(beginning),
        Some(Format {
            reader: Reader::Rows(_),
            ..
        })
    )
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
            let open = match Format::sniff(text) {
                Some(Format {
                    reader: Reader::Rows(open),
                    ..
                }) => *open,
                // Says why the file is refused.
                _ => motive::open,
            };
            let mut opened = open(text, file_name, settings)?;
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
