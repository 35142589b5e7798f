//! Streams that are read like files.

use std::io::{self, Read, Seek, SeekFrom};

/// Bytes that are made from their start on, such as those of a packed file: going back makes them anew, so
/// that none are retained. It is meant to be buffered.
pub struct Replayed<'a> {
    open: Box<dyn FnMut() -> io::Result<Box<dyn Read + Send + 'a>> + Send + 'a>,
    stream: Option<Box<dyn Read + Send + 'a>>,
    /// Bytes that were read of the stream.
    read: u64,
    /// Place of the next byte that is wanted.
    position: u64,
    bytes: u64,
}

impl<'a> Replayed<'a> {
    /// The stream of this many bytes that `open` gives at each call.
    pub fn new(
        bytes: u64,
        open: impl FnMut() -> io::Result<Box<dyn Read + Send + 'a>> + Send + 'a,
    ) -> Self {
        Self {
            open: Box::new(open),
            stream: None,
            read: 0,
            position: 0,
            bytes,
        }
    }
}

impl Read for Replayed<'_> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        if self.position < self.read {
            self.stream = None;
        }
        let stream = match &mut self.stream {
            Some(stream) => stream,
            none => {
                self.read = 0;
                none.insert((self.open)()?)
            }
        };
        let skipped = (&mut *stream).take(self.position - self.read);
        self.read += io::copy(&mut { skipped }, &mut io::sink())?;
        let read = stream.read(out)?;
        self.read += read as u64;
        self.position = self.read;
        Ok(read)
    }
}

impl Seek for Replayed<'_> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let position = match to {
            SeekFrom::Start(position) => Some(position),
            SeekFrom::Current(offset) => self.position.checked_add_signed(offset),
            SeekFrom::End(offset) => self.bytes.checked_add_signed(offset),
        };
        self.position = position.ok_or(io::ErrorKind::InvalidInput)?;
        Ok(self.position)
    }
}

impl std::fmt::Debug for Replayed<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        (f.debug_struct("Replayed"))
            .field("bytes", &self.bytes)
            .field("position", &self.position)
            .finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_place_of_a_stream_is_read_and_going_back_starts_it_anew() {
        let all: Vec<u8> = (0..100).collect();
        let mut opened = 0;
        let mut stream = Replayed::new(100, || {
            opened += 1;
            Ok(Box::new(&all[..]))
        });
        let mut read = |to| {
            let mut out = [0; 3];
            stream.seek(to).unwrap();
            stream.read_exact(&mut out).unwrap();
            out
        };
        assert_eq!(read(SeekFrom::Start(10)), [10, 11, 12]);
        assert_eq!(read(SeekFrom::Current(7)), [20, 21, 22]);
        assert_eq!(read(SeekFrom::End(-3)), [97, 98, 99]);
        assert_eq!(read(SeekFrom::Start(0)), [0, 1, 2]);
        let mut rest = Vec::new();
        stream.seek(SeekFrom::Start(200)).unwrap();
        assert_eq!(stream.read_to_end(&mut rest).unwrap(), 0);
        drop(stream);
        assert_eq!(opened, 2);
    }
}
