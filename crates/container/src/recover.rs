//! Recovers intact data from a damaged file.

mod keeper;
mod probe;
mod report;
mod scan;
mod survey;

use std::io::{Read, Seek, Write};

use mcap::records::op;

use crate::error::ContainerError;
use crate::fields::stated_bytes;
use crate::format::Records;
use crate::overview::MetadataRecord;
use crate::source::Source;
use keeper::Keeper;
pub use report::{Loss, Recovered};
use scan::Scan;
use survey::Survey;

/// Writes what is intact of a file, which may be cut off, damaged anywhere, or never finished.
///
/// The file is read twice. The first pass looks for schemas and channels, wherever they are: in the data,
/// in any chunk, in a summary. Of contradicting ones those under a checksum count; those of a chunk whose
/// checksum differs count only where there are no others. The second pass writes:
///
/// * chunks whose checksum holds, byte for byte where any reader unpacks them, else packed anew;
/// * records outside chunks that look like some, in chunks; [`Recovered::unchecked`] says where no
///   checksum covers them;
/// * the first whole messages of a chunk that was never closed;
/// * with `keep_unverified`, the messages of chunks whose checksum differs, under topics that start with
///   `/unverified`: any of them may be wrong.
///
/// After bytes that are no record it goes on with the next record, and lengths that lead past other records
/// are not followed. Files that were joined become one; ids that are used again with other content are
/// renumbered. Summary and indexes are made anew.
///
/// `add` may give a metadata record about what is lost, which is added at the end of the data.
///
/// # Errors
///
/// [`ContainerError::NotMcap`] for bytes that hold nothing of an MCAP file; [`ContainerError::Read`],
/// [`ContainerError::Write`]; [`ContainerError::Collision`] where ids of channels run out.
pub fn recover(
    file: &str,
    input: impl Read + Seek + Send,
    out: &mut dyn Write,
    keep_unverified: bool,
    add: impl FnOnce(&Recovered) -> Option<MetadataRecord>,
) -> Result<Recovered, ContainerError> {
    let mut source = Source::unchecked(file, input)?;
    let mut survey = Survey::default();
    Scan::new(&mut source, &mut survey, false).run()?;
    if let Some(again) = survey.again() {
        survey = again;
        Scan::new(&mut source, &mut survey, false).run()?;
    }
    let mut start = Vec::new();
    source.read_at(0, 64 << 10, &mut start)?;
    if survey.is_empty() && !start.starts_with(mcap::MAGIC) {
        // The error says what there is instead.
        Source::open(file, std::io::Cursor::new(&start))?;
    }
    let header = start.get(mcap::MAGIC.len()..).and_then(|records| {
        let first = Records(records).next().flatten();
        let (_, body) = first.filter(|(opcode, _)| *opcode == op::HEADER)?;
        source.place(0).parse(op::HEADER, body).ok()?;
        // What follows its texts may be other records, which the next reader would find there.
        body.get(..usize::try_from(stated_bytes(op::HEADER, body)?).ok()?)
    });
    let is_sound = survey.is_sound();
    let header = header.unwrap_or(&[0; 8]);
    let mut keeper = Keeper::create(file, out, header, survey, keep_unverified)?;
    Scan::new(&mut source, &mut keeper, is_sound).run()?;
    keeper.finish(add)
}
