//! Takes read whole or block by block: sniff, header, rows of numbers, assembly.

use std::io::Read;

use inhand_model::{Finding, Recording};

use crate::assembly::Assembly;
use crate::error::CaptureError;
use crate::format::{Format, Reader};
use crate::lines::Lines;
use crate::settings::ReadSettings;
use crate::table::{Extent, Table};

/// Most samples of a block.
const BLOCK_SAMPLES: usize = 16 * 1024;

/// Reads a vendor file; its first bytes tell which format it has.
///
/// `file_name` is what messages call the file; its stem is the take's name where the file states
/// none.
///
/// # Errors
///
/// [`CaptureError`] where the file is of no known format, is damaged, or leaves open what
/// `settings` do not say.
pub fn read(
    bytes: &[u8],
    file_name: &str,
    settings: &ReadSettings,
) -> Result<Recording, CaptureError> {
    let (format, content) = Format::detect(bytes, file_name)?;
    match format.reader {
        Reader::Rows(_) => {
            let mut extent = Extent::default();
            extent.add(bytes);
            read_rows(bytes, extent, file_name, settings)
        }
        Reader::Whole(read) => read(content, file_name, settings),
    }
}

/// As [`read()`] for a file with even rows ([`has_even_rows`]) of any size, of which memory holds the
/// samples alone. `extent` is that of the whole file.
///
/// # Errors
///
/// As for [`read()`].
pub fn read_rows(
    input: impl Read,
    extent: Extent,
    file_name: &str,
    settings: &ReadSettings,
) -> Result<Recording, CaptureError> {
    Blocks::start(input, extent, file_name, settings, true)?.read_whole()
}

/// Whether a file that starts like this has its take in rows of one kind, so that [`Blocks`] reads
/// it. The row-typed Motive CSV before 1.2 names its markers only in its rows, and is read whole.
pub fn has_even_rows(beginning: &[u8]) -> bool {
    Format::detect(beginning, "").is_ok_and(|(format, _)| matches!(format.reader, Reader::Rows(_)))
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
    lines: Lines<R>,
    table: Table,
    assembly: Assembly,
    header: Recording,
}

impl<R: Read> Blocks<R> {
    /// Reads the header. `extent` is that of the whole file: it bounds how many missing samples a
    /// jump in the frame column may stand for.
    ///
    /// # Errors
    ///
    /// As for [`read`].
    pub fn open(
        input: R,
        extent: Extent,
        file_name: &str,
        settings: &ReadSettings,
    ) -> Result<Self, CaptureError> {
        Self::start(input, extent, file_name, settings, false)
    }

    /// Reads the header. The tracks get room for as many samples as the file can hold if `whole`.
    fn start(
        input: R,
        extent: Extent,
        file_name: &str,
        settings: &ReadSettings,
        whole: bool,
    ) -> Result<Self, CaptureError> {
        let mut lines = Lines::new(input, file_name);
        let (opened, mark_bytes) = lines.head(|head| {
            let (format, text) = Format::detect(head, file_name)?;
            match format.reader {
                Reader::Rows(open) => {
                    Ok((open(text, file_name, settings)?, head.len() - text.len()))
                }
                Reader::Whole(_) => Err(CaptureError::unsupported(
                    file_name,
                    "this format in blocks",
                    "read the file whole",
                )),
            }
        })?;
        let header_bytes = opened.header_bytes + mark_bytes;
        lines.skip_head(header_bytes, opened.header_lines);
        let below = extent.below(header_bytes, opened.header_lines);
        let rows_at_most = opened.table.rows_at_most(below);
        let mut assembly =
            Assembly::new(file_name, opened.take, opened.table.values(), rows_at_most);
        // The first row says when the take starts.
        read_run(&mut lines, &opened.table, &mut assembly)?;
        let mut header = assembly.take_block(if whole { rows_at_most as usize } else { 0 })?;
        header.annotations = assembly.annotations.clone();
        Ok(Self {
            lines,
            table: opened.table,
            assembly,
            header,
        })
    }

    /// The take without any sample: its name, clock, source, markers, bodies and events.
    pub fn header(&self) -> &Recording {
        &self.header
    }

    /// The samples that follow those of the block before, as a take that starts where they do;
    /// `None` after the last ones. Its findings are empty: see [`Blocks::findings`].
    ///
    /// # Errors
    ///
    /// As for [`read`]; and where there is no sample at all.
    pub fn next_block(&mut self) -> Result<Option<Recording>, CaptureError> {
        if !self.fill(BLOCK_SAMPLES)? {
            return Ok(None);
        }
        self.assembly.take_block(BLOCK_SAMPLES).map(Some)
    }

    /// Findings about the file; complete after the last block.
    pub fn findings(&self) -> Vec<Finding> {
        self.assembly.findings()
    }

    fn read_whole(mut self) -> Result<Recording, CaptureError> {
        while self.fill(usize::MAX)? {}
        self.assembly.finish()
    }

    /// Adds samples to the tracks, at most so many; false at the end of the file.
    fn fill(&mut self, at_most: usize) -> Result<bool, CaptureError> {
        while !self.assembly.has_pending() {
            if !read_run(&mut self.lines, &self.table, &mut self.assembly)? {
                return self.assembly.end().map(|()| false);
            }
        }
        self.assembly.fill(at_most);
        Ok(true)
    }
}

/// Gives the rows of the next run of lines their places; false at the end of the file.
fn read_run<R: Read>(
    lines: &mut Lines<R>,
    table: &Table,
    assembly: &mut Assembly,
) -> Result<bool, CaptureError> {
    let Some(run) = lines.next_run()? else {
        return Ok(false);
    };
    for rows in table.parse(&run) {
        assembly.add(rows?)?;
    }
    Ok(true)
}
