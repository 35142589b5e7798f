//! Files that are open only while they are read.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// A file that is opened for each read, so that any number of them can be read in turn. It is meant to be
/// buffered.
#[derive(Clone, Debug)]
pub struct Reopened {
    path: PathBuf,
    position: u64,
}

impl Reopened {
    /// Files that may stay open while they are read together; more than these are opened when they are read.
    pub const MOST_OPEN: usize = 200;

    /// The file at this path, from its start.
    pub fn new(path: &Path) -> Self {
        Self {
            path: path.to_owned(),
            position: 0,
        }
    }
}

impl Read for Reopened {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let mut file = File::open(&self.path)?;
        file.seek(SeekFrom::Start(self.position))?;
        let read = file.read(out)?;
        self.position += read as u64;
        Ok(read)
    }
}

impl Seek for Reopened {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let position = match to {
            SeekFrom::Start(position) => Some(position),
            SeekFrom::Current(offset) => self.position.checked_add_signed(offset),
            SeekFrom::End(offset) => {
                let bytes = std::fs::metadata(&self.path)?.len();
                bytes.checked_add_signed(offset)
            }
        };
        self.position = position.ok_or(io::ErrorKind::InvalidInput)?;
        Ok(self.position)
    }
}
