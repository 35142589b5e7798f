//! Vendor files of any length to MCAP: read and written block by block.
//!
//! The start of a recording's file says what holds for all of it: how many samples there are, what
//! was odd, where its source's bytes are. So a file is read three times: for its length, for its hash
//! and what it holds, and to be written. What memory holds is a few blocks of some thousand samples.

use std::path::{Path, PathBuf};
use std::sync::mpsc::sync_channel;

use inhand_capture::roles::resolve;
use inhand_capture::{Blocks, Extent, ReadSettings};
use inhand_channels::{Outline, TakeFile, TakeWriter, Views};
use inhand_inspection::Coverage;
use inhand_model::{InputHash, Provenance, Recording, Roles, Shape};

use crate::error::{Located, SessionError};
use crate::files::{Hashed, name_of, open_rows};
use crate::output::write_atomic;
use crate::run::provenance;
use crate::settings::Settings;
use crate::take::{Take, read};
use crate::take_file::write_parts;

/// Blocks that are read ahead of the one that is being written.
const BLOCKS_AHEAD: usize = 2;

/// A vendor file that was read once, without keeping its samples.
#[derive(Debug)]
pub struct LongTake {
    /// The file.
    pub path: PathBuf,
    /// The take without any sample; its findings are those of the whole file.
    pub header: Recording,
    /// How much of its markers and bodies is there.
    pub coverage: Coverage,
    /// Which entity has which role, or why that is undetermined.
    pub roles: Result<Roles, String>,
    /// Content of the file.
    pub hash: InputHash,
    outline: Outline,
    extent: Extent,
    settings: ReadSettings,
}

/// A take to convert, in memory only where it has to be.
#[derive(Debug)]
pub enum TakeInput {
    /// On disk; its samples are read again to be written.
    Long(Box<LongTake>),
    /// In memory.
    Whole(Box<Take>),
}

impl TakeInput {
    /// Reads a take, whatever its format.
    ///
    /// # Errors
    ///
    /// As for [`read`].
    pub fn open(path: &Path, settings: &Settings) -> Result<Self, SessionError> {
        Ok(match LongTake::open(path, settings)? {
            Some(long) => TakeInput::Long(Box::new(long)),
            None => TakeInput::Whole(Box::new(read(path, settings)?)),
        })
    }

    /// Content of the file.
    pub fn hash(&self) -> &InputHash {
        match self {
            TakeInput::Long(take) => &take.hash,
            TakeInput::Whole(take) => &take.hash,
        }
    }

    /// The facts that hold for the whole take.
    pub fn header(&self) -> &Recording {
        match self {
            TakeInput::Long(take) => &take.header,
            TakeInput::Whole(take) => &take.recording,
        }
    }

    /// How much of its markers and bodies is there.
    pub fn coverage(&self) -> Coverage {
        match self {
            TakeInput::Long(take) => take.coverage.clone(),
            TakeInput::Whole(take) => Coverage::of(&take.recording),
        }
    }

    /// Which entity has which role, or why that is undetermined.
    pub fn roles(&self) -> Result<&Roles, &str> {
        let roles = match self {
            TakeInput::Long(take) => &take.roles,
            TakeInput::Whole(take) => &take.roles,
        };
        roles.as_ref().map_err(String::as_str)
    }

    /// Writes the take as MCAP, with these channels that viewers draw.
    ///
    /// # Errors
    ///
    /// [`SessionError`]; then no file appears.
    pub fn convert(
        &self,
        target: &Path,
        settings: &Settings,
        views: Views,
    ) -> Result<(), SessionError> {
        let made = provenance("convert", settings, [self.hash().clone()]);
        let shape = settings.shape()?;
        match self {
            TakeInput::Long(take) => take.write(target, &[made], shape, views),
            TakeInput::Whole(take) => {
                let provenance = take.made_by(&made);
                let file = TakeFile {
                    object_shape: shape,
                    ..take.file(&provenance)
                };
                write_parts(target, &file, views)
            }
        }
    }
}

impl LongTake {
    /// Reads a file once; `None` where it is none that can be read block by block, or no file on
    /// disk that can be read again.
    ///
    /// # Errors
    ///
    /// As for [`read`](crate::read).
    pub fn open(path: &Path, settings: &Settings) -> Result<Option<Self>, SessionError> {
        let Some((mut file, extent)) = open_rows(path)? else {
            return Ok(None);
        };
        let name = name_of(path);
        let read_settings = settings.read_settings()?;
        let mut blocks = Blocks::open(&mut file, extent, &name, &read_settings).in_file(path)?;
        let (mut outline, mut coverage) = (Outline::default(), Coverage::default());
        while let Some(block) = blocks.next_block().in_file(path)? {
            outline.add(&block);
            coverage.add(&block);
        }
        let mut header = blocks.header().clone();
        header.findings = blocks.findings();
        let roles = resolve(&header, &settings.role_settings()?);
        Ok(Some(Self {
            path: path.to_owned(),
            outline: outline.with_findings(header.findings.clone()),
            header,
            coverage,
            roles: roles.map_err(|error| error.to_string()),
            hash: InputHash {
                name,
                sha256: file.sha256(),
            },
            extent,
            settings: read_settings,
        }))
    }

    /// Writes the take as MCAP: the same bytes as if it had been read whole.
    ///
    /// # Errors
    ///
    /// [`SessionError`]; then no file appears. One is that the file has changed since it was
    /// opened.
    pub fn write(
        &self,
        target: &Path,
        provenance: &[Provenance],
        object_shape: Option<Shape>,
        views: Views,
    ) -> Result<(), SessionError> {
        write_atomic(target, |out| {
            let file = TakeFile {
                roles: self.roles.as_ref().ok(),
                object_shape,
                provenance,
                ..TakeFile::new(&self.header)
            };
            let mut writer = TakeWriter::begin(out, &file, &self.outline, views).in_file(target)?;
            std::thread::scope(|scope| {
                // Rows are parsed while those before them are written.
                let (sender, receiver) = sync_channel(BLOCKS_AHEAD);
                let reader = scope.spawn(move || self.blocks(|block| sender.send(block).is_ok()));
                let written =
                    (receiver.iter()).try_for_each(|block| writer.append(&TakeFile::new(&block)));
                // A reader that still has blocks stops when nobody takes them.
                drop(receiver);
                let read = reader
                    .join()
                    .unwrap_or_else(|panic| std::panic::resume_unwind(panic));
                read?;
                written.in_file(target)
            })?;
            writer.finish().in_file(target)
        })
    }

    /// Reads the file again and hands on its blocks, as long as they are taken.
    fn blocks(&self, mut take: impl FnMut(Recording) -> bool) -> Result<(), SessionError> {
        let io = |error| SessionError::io("read", &self.path)(error);
        let mut file = Hashed::open(&self.path).map_err(io)?;
        let mut blocks = Blocks::open(&mut file, self.extent, &self.hash.name, &self.settings)
            .in_file(&self.path)?;
        while let Some(block) = blocks.next_block().in_file(&self.path)? {
            if !take(block) {
                return Ok(());
            }
        }
        if file.sha256() == self.hash.sha256 {
            Ok(())
        } else {
            Err(SessionError::data(
                &self.path,
                "the file changed while it was read: convert it again when it is complete",
            ))
        }
    }
}
