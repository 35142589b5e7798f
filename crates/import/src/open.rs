//! MCAP files on disk, packed or split ones too, as one that is read record by record.

use std::fs::File;
use std::io::{self, BufRead as _, BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};

use inhand_container::{
    ContainerError, Merge, MetadataRecord, Packing, Reopened, Replayed, Source, is_mcap, is_zstd,
    merge, zstd_reader,
};

/// Bytes that are read at a time.
const BUFFER_BYTES: usize = 1 << 16;

/// Enough bytes of a file to say whether it is MCAP.
const MARK_BYTES: u64 = 8;

/// How the files of a bag become one.
const JOINED: Merge<'static> = Merge {
    library: "",
    keep_both: true,
    metadata: &|_, record: MetadataRecord| record,
    packing: Packing::None,
};

/// Opens an MCAP file, or several as one by time; `name` is what errors call it. What zstd packed is unpacked, and
/// several files are joined, while they are read and once before, for their length: memory is taken for a chunk of
/// each file. `None` for a file of another kind.
///
/// # Errors
///
/// [`ContainerError`] for files that cannot be read or unpacked; of several also for one that is no intact MCAP file.
pub fn open(files: &[PathBuf], name: &str) -> Result<Option<Source<'static>>, ContainerError> {
    if let [file] = files {
        return open_one(file, name, false);
    }
    let files = files.to_vec();
    let open_all = move || {
        let reopen = files.len() > Reopened::MOST_OPEN;
        let open = |file: &PathBuf| {
            let shown = file.display().to_string();
            match open_one(file, &shown, reopen)? {
                Some(source) => Ok(source),
                None => Source::open(&shown, File::open(file).map_err(unreadable(&shown))?),
            }
        };
        files.iter().map(open).collect::<Result<Vec<_>, _>>()
    };
    let mut length = Length(0);
    merge(open_all()?, &mut length, &JOINED)?;
    let joined = Replayed::new(length.0, move || {
        let sources = open_all().map_err(io::Error::other)?;
        let (reader, writer) = io::pipe()?;
        // It ends where the reader is dropped. An error ends the bytes early, which the reader reports.
        std::thread::spawn(move || {
            let mut out = BufWriter::with_capacity(BUFFER_BYTES, writer);
            merge(sources, &mut out, &JOINED).is_ok() && out.flush().is_ok()
        });
        Ok(Box::new(reader))
    });
    Source::open(name, BufReader::with_capacity(BUFFER_BYTES, joined)).map(Some)
}

fn open_one(
    file: &Path,
    name: &str,
    reopen: bool,
) -> Result<Option<Source<'static>>, ContainerError> {
    let open =
        |file: &Path| File::open(file).map(|file| BufReader::with_capacity(BUFFER_BYTES, file));
    let mut input = open(file).map_err(unreadable(name))?;
    let begin = input.fill_buf().map_err(unreadable(name))?;
    if is_mcap(begin) {
        let source = match reopen {
            true => Source::open(
                name,
                BufReader::with_capacity(BUFFER_BYTES, Reopened::new(file)),
            ),
            false => Source::open(name, input),
        };
        return source.map(Some);
    }
    if !is_zstd(begin) {
        return Ok(None);
    }
    let mut unpacked = zstd_reader(input).map_err(unreadable(name))?;
    let mut begin = Vec::new();
    let read = unpacked.by_ref().take(MARK_BYTES).read_to_end(&mut begin);
    if read.is_err() || !is_mcap(&begin) {
        return Ok(None);
    }
    let rest = io::copy(&mut unpacked, &mut io::sink());
    let damaged = |error| {
        io::Error::other(format!(
            "expected zstd data, found {error}; copy the file again"
        ))
    };
    let rest = rest.map_err(damaged).map_err(unreadable(name))?;
    let file = file.to_owned();
    let replayed = Replayed::new(begin.len() as u64 + rest, move || {
        Ok(Box::new(zstd_reader(open(&file)?)?))
    });
    Source::open(name, BufReader::with_capacity(BUFFER_BYTES, replayed)).map(Some)
}

fn unreadable(file: &str) -> impl Fn(io::Error) -> ContainerError + use<> {
    let file = file.to_owned();
    move |source| ContainerError::Read {
        file: file.clone(),
        source,
    }
}

/// Counts what is written.
struct Length(u64);

impl Write for Length {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0 += bytes.len() as u64;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
