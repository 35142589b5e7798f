//! A text file as runs of whole lines, whatever it is read from, in memory for one run.

use std::io::{ErrorKind, Read};

use memchr::{memchr, memrchr};

use crate::error::CaptureError;

/// Bytes of a run: large against the cost of handing out its parts to threads, small beside the
/// caches that they share.
const RUN_BYTES: usize = 1024 * 1024;

/// Longest line. A row of a thousand markers has some 40 000 bytes; what is longer than this is no
/// text, or lost its line ends.
pub(crate) const MAX_LINE_BYTES: usize = 4 * 1024 * 1024;

/// Bytes that are read for the header at first, and at most. A take of a thousand markers needs a
/// few hundred thousand.
const FIRST_HEAD_BYTES: usize = 64 * 1024;
const MAX_HEAD_BYTES: usize = 16 * 1024 * 1024;

/// A file while it is read.
pub(crate) struct Lines<R> {
    input: R,
    file: String,
    buffer: Vec<u8>,
    /// Bytes of the buffer that are done with.
    used: usize,
    /// Bytes of the buffer that hold the file.
    filled: usize,
    at_end: bool,
    /// Line of the file, from 1, at `used`.
    line: usize,
}

/// Consecutive whole lines.
pub(crate) struct Run<'a> {
    pub(crate) bytes: &'a [u8],
    /// Line of the file on which they start.
    pub(crate) first_line: usize,
}

impl<R: Read> Lines<R> {
    pub(crate) fn new(input: R, file: &str) -> Self {
        Self {
            input,
            file: file.to_owned(),
            buffer: Vec::new(),
            used: 0,
            filled: 0,
            at_end: false,
            line: 1,
        }
    }

    /// Calls `parse` with the beginning of the file, and with more of it as long as that fails and
    /// there is more. What it sees ends with a whole line where it holds one.
    pub(crate) fn head<T>(
        &mut self,
        parse: impl Fn(&[u8]) -> Result<T, CaptureError>,
    ) -> Result<T, CaptureError> {
        let mut wanted = FIRST_HEAD_BYTES;
        loop {
            self.fill(wanted)?;
            let head = &self.buffer[..self.filled];
            let whole = match memrchr(b'\n', head) {
                Some(end) if !self.at_end => &head[..=end],
                _ => head,
            };
            let parsed = parse(whole);
            if parsed.is_ok() || self.at_end {
                return parsed;
            }
            if wanted >= MAX_HEAD_BYTES {
                return parsed.map_err(|error| error.of_header_within(MAX_HEAD_BYTES));
            }
            wanted *= 4;
        }
    }

    /// Leaves out the first bytes and lines of what [`Lines::head`] saw.
    pub(crate) fn skip_head(&mut self, bytes: usize, lines: usize) {
        self.used = bytes.min(self.filled);
        self.line = lines + 1;
    }

    /// The next run of lines; `None` at the end of the file.
    pub(crate) fn next_run(&mut self) -> Result<Option<Run<'_>>, CaptureError> {
        self.buffer.copy_within(self.used..self.filled, 0);
        self.filled -= self.used;
        self.used = 0;
        self.fill(RUN_BYTES)?;
        let end = if self.at_end && self.filled <= RUN_BYTES {
            self.filled
        } else {
            let run = &self.buffer[..self.filled.min(RUN_BYTES)];
            match memrchr(b'\n', run) {
                Some(end) => end + 1,
                None => self.end_of_long_line()?,
            }
        };
        if end == 0 {
            return Ok(None);
        }
        let first_line = self.line;
        let bytes = &self.buffer[..end];
        self.line += crate::text::count_lines(bytes);
        self.used = end;
        Ok(Some(Run { bytes, first_line }))
    }

    /// End of the line that starts the buffer.
    fn end_of_long_line(&mut self) -> Result<usize, CaptureError> {
        self.fill(MAX_LINE_BYTES + 1)?;
        let line = &self.buffer[..self.filled.min(MAX_LINE_BYTES + 1)];
        match memchr(b'\n', line) {
            Some(end) => Ok(end + 1),
            None if line.len() <= MAX_LINE_BYTES => Ok(line.len()),
            None => Err(CaptureError::line_too_long(
                &self.file,
                self.line,
                MAX_LINE_BYTES,
            )),
        }
    }

    /// Reads until the buffer holds `wanted` bytes or the file ends.
    fn fill(&mut self, wanted: usize) -> Result<(), CaptureError> {
        if self.buffer.len() < wanted {
            self.buffer.resize(wanted, 0);
        }
        while self.filled < wanted && !self.at_end {
            match self.input.read(&mut self.buffer[self.filled..wanted]) {
                Ok(0) => self.at_end = true,
                Ok(read) => self.filled += read,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(source) => {
                    return Err(CaptureError::Read {
                        file: self.file.clone(),
                        source,
                    });
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Hands out a few bytes at a time.
    struct Trickle<'a>(&'a [u8], usize);

    impl Read for Trickle<'_> {
        fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
            let length = out.len().min(self.1);
            Read::read(&mut self.0, &mut out[..length])
        }
    }

    fn runs(bytes: &[u8], step: usize) -> Result<Vec<(usize, Vec<u8>)>, String> {
        let mut lines = Lines::new(Trickle(bytes, step), "a.csv");
        let mut runs = Vec::new();
        while let Some(run) = lines.next_run().map_err(|e| e.to_string())? {
            runs.push((run.first_line, run.bytes.to_vec()));
        }
        Ok(runs)
    }

    #[test]
    fn runs_hold_whole_lines_and_all_of_them() {
        let text: String = (0..400_000).map(|k| format!("{k},1.5\r\n")).collect();
        for step in [10_007, 1 << 20, usize::MAX] {
            let runs = runs(text.as_bytes(), step).unwrap();
            assert!(runs.len() > 3);
            let mut line = 1;
            for (first_line, bytes) in &runs {
                assert_eq!(*first_line, line);
                assert!(bytes.ends_with(b"\n") && bytes.len() <= RUN_BYTES);
                assert!(bytes.starts_with(format!("{},", line - 1).as_bytes()));
                line += memchr::memchr_iter(b'\n', bytes).count();
            }
            let joined: Vec<u8> = runs.into_iter().flat_map(|(_, bytes)| bytes).collect();
            assert_eq!(joined, text.as_bytes());
        }
        assert_eq!(runs(b"", 1).unwrap(), []);
        assert_eq!(runs(b"a\nb", 1).unwrap(), [(1, b"a\nb".to_vec())]);
    }

    #[test]
    fn lines_are_long_up_to_a_bound() {
        for (length, fits) in [
            (RUN_BYTES + 1, true),
            (MAX_LINE_BYTES, true),
            (MAX_LINE_BYTES + 1, false),
            (3 * MAX_LINE_BYTES, false),
        ] {
            for end in ["", "\n", "\nb\n"] {
                let text = format!("a\n{}{end}", "7".repeat(length));
                let found = runs(text.as_bytes(), usize::MAX);
                match found {
                    Ok(runs) => {
                        assert!(fits, "{length} {end:?}");
                        let joined: Vec<u8> = runs.into_iter().flat_map(|(_, b)| b).collect();
                        assert_eq!(joined, text.as_bytes());
                    }
                    Err(message) => {
                        assert!(!fits, "{length} {end:?}");
                        assert!(message.starts_with("a.csv, line 2: "), "{message}");
                    }
                }
            }
        }
    }

    #[test]
    fn the_head_grows_until_it_is_enough() {
        let text = format!("{}\nend\n", "x\n".repeat(200_000));
        let mut lines = Lines::new(Trickle(text.as_bytes(), 5000), "a.csv");
        let at = lines
            .head(|head| {
                assert!(head.ends_with(b"\n"));
                let at = memchr::memmem::find(head, b"end\n");
                at.ok_or_else(|| CaptureError::no_samples(""))
            })
            .unwrap();
        lines.skip_head(at, 200_001);
        let run = lines.next_run().unwrap().unwrap();
        assert_eq!((run.bytes, run.first_line), (&b"end\n"[..], 200_002));
        assert!(lines.next_run().unwrap().is_none());
    }
}
