//! Files by name, hash and record: what every step that reads or changes one shares.

use std::borrow::Cow;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use inhand_capture::{Extent, has_even_rows};
use inhand_channels::Metadata;
use inhand_container::{Selected, Selection, Source};
use inhand_model::InputHash;
use sha2::{Digest, Sha256};

use crate::error::{Located, SessionError};
use crate::output::write_atomic;

/// Bytes read at a time where nothing is parsed.
const READ_BYTES: usize = 1 << 20;

/// The metadata record that makes a file a take.
pub(crate) const RECORDING: &str = "inhand.recording";

/// A file that is read record by record.
pub type FileSource = Source<'static>;

/// Opens an MCAP file for reading record by record.
///
/// # Errors
///
/// [`SessionError::Io`], and [`SessionError::At`] for a file of another kind.
pub fn open(path: &Path) -> Result<FileSource, SessionError> {
    refuse_folder(path)?;
    let file = File::open(path).map_err(SessionError::io("read", path))?;
    let mut reader = BufReader::with_capacity(1 << 16, file);
    let begin = reader.fill_buf().map_err(SessionError::io("read", path))?;
    if inhand_container::is_zstd(begin) {
        let message = "compressed with zstd: unpack it with `zstd -d FILE`";
        return Err(SessionError::data(path, message));
    }
    unpack(path, begin)?;
    Source::open(&name_of(path), reader).in_file(path)
}

/// Refuses a folder where a file is changed or read record by record.
pub(crate) fn refuse_folder(path: &Path) -> Result<(), SessionError> {
    if !path.is_dir() {
        return Ok(());
    }
    let message = "a folder: expected an MCAP file; `inhand convert FOLDER -o take.mcap` makes one of a ROS 2 bag";
    Err(SessionError::data(path, message))
}

/// The files of a take in their order: itself, or those of a ROS 2 bag.
///
/// # Errors
///
/// [`SessionError::Data`] for a folder that is no bag, or a bag that is not read; [`SessionError::Io`].
pub fn take_files(path: &Path) -> Result<Vec<PathBuf>, SessionError> {
    if !path.is_dir() {
        return Ok(vec![path.to_owned()]);
    }
    let facts = path.join(inhand_import::BAG_FACTS);
    if !facts.is_file() {
        let message = format!(
            "a folder: expected a take, or a ROS 2 bag with {}",
            inhand_import::BAG_FACTS
        );
        return Err(SessionError::data(path, message));
    }
    let text = std::fs::read_to_string(&facts).map_err(SessionError::io("read", &facts))?;
    let names =
        inhand_import::bag_files(&text).map_err(|message| SessionError::data(&facts, message))?;
    Ok(names.iter().map(|name| path.join(name)).collect())
}

/// Opens the MCAP file of a take, packed or not, or the files of a bag as one; `name` is what errors call it. `None` for
/// a file of another kind and for a stream, which can be read only once.
///
/// # Errors
///
/// [`SessionError::Io`], [`SessionError::At`], and [`SessionError::Data`] for a folder that is no bag or a packing that
/// is not read.
pub fn open_take(path: &Path, name: &str) -> Result<Option<FileSource>, SessionError> {
    let files = take_files(path)?;
    if let [file] = &*files
        && !file.is_file()
        && file == path
    {
        return Ok(None);
    }
    for file in &files {
        let mut begin = Vec::new();
        let opened = File::open(file).and_then(|opened| opened.take(64).read_to_end(&mut begin));
        opened.map_err(SessionError::io("read", file))?;
        if !inhand_container::is_zstd(&begin) {
            unpack(file, &begin)?;
        }
    }
    inhand_import::open(&files, name).in_file(path)
}

/// SHA-256 of the files of a take, one after the other.
pub(crate) fn hash_files(path: &Path) -> Result<String, SessionError> {
    let mut hash = Sha256::new();
    for path in take_files(path)? {
        let hashed = File::open(&path).and_then(|file| {
            let mut file = Hashed { file, hash };
            io::copy(&mut file, &mut io::sink())?;
            Ok(file.hash)
        });
        hash = hashed.map_err(SessionError::io("read", &path))?;
    }
    Ok(hex(&hash.finalize()))
}

/// The content of a take's file, unpacked where zstd packed it.
///
/// # Errors
///
/// [`SessionError::Data`] with the compression that is not read and the command that helps.
pub(crate) fn unpack<'a>(path: &Path, stored: &'a [u8]) -> Result<Cow<'a, [u8]>, SessionError> {
    inhand_import::unpack_file(stored).map_err(|message| SessionError::data(path, message))
}

/// Name of a take: that of its file without endings, or of its folder.
pub fn take_name(path: &Path) -> String {
    let name = name_of(path);
    let stem = Path::new(inhand_import::unpacked_name(&name)).file_stem();
    match stem.filter(|_| !path.is_dir()) {
        Some(stem) => stem.to_string_lossy().into_owned(),
        None => name,
    }
}

pub(crate) fn name_of(path: &Path) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    name.to_string_lossy().into_owned()
}

/// Folder and name of a file, the same however its path is spelled.
pub(crate) fn folder_and_name(path: &Path) -> String {
    let folder = path.canonicalize().ok();
    let folder = folder
        .as_deref()
        .and_then(Path::parent)
        .and_then(Path::file_name);
    folder.map_or_else(
        || name_of(path),
        |folder| format!("{}/{}", folder.to_string_lossy(), name_of(path)),
    )
}

/// When a take's first sample is, nanoseconds since 1970-01-01 UTC; `None` for a file without a take.
pub(crate) fn take_start(metadata: &Metadata) -> Option<u64> {
    let facts = metadata.0.get(RECORDING)?;
    facts.get("start_unix_nanos")?.parse().ok()
}

/// Name and content of a file of any size.
///
/// # Errors
///
/// [`SessionError::Io`].
pub fn hash_file(path: &Path) -> Result<InputHash, SessionError> {
    Ok(InputHash {
        name: name_of(path),
        sha256: hash_files(path)?,
    })
}

/// The file of facts beside a wide table of a recording: `<table>.json`.
pub fn facts_path(table: &Path) -> PathBuf {
    let mut path = table.as_os_str().to_owned();
    path.push(".json");
    path.into()
}

/// Writes what `selection` keeps of a file, byte for byte.
///
/// # Errors
///
/// [`SessionError::At`] with the byte at which the file is wrong, [`SessionError::Io`].
pub fn filter(
    input: &Path,
    output: &Path,
    selection: &Selection<'_>,
) -> Result<Selected, SessionError> {
    select(&mut open(input)?, input, output, selection)
}

pub(crate) fn select(
    source: &mut FileSource,
    input: &Path,
    output: &Path,
    selection: &Selection<'_>,
) -> Result<Selected, SessionError> {
    let mut selected = Selected::default();
    write_atomic(output, |out| {
        selected = inhand_container::select(source, out, selection).in_file(input)?;
        Ok(())
    })?;
    Ok(selected)
}

/// A file on disk with its take in rows of one kind, which is hashed as it is read, and its length; `None` for any
/// other.
pub(crate) fn open_rows(path: &Path) -> Result<Option<(Hashed, Extent)>, SessionError> {
    let io = |error| SessionError::io("read", path)(error);
    if path.exists() && !path.is_file() {
        return Ok(None);
    }
    let mut file = BufReader::with_capacity(READ_BYTES, File::open(path).map_err(io)?);
    if !has_even_rows(file.fill_buf().map_err(io)?) {
        return Ok(None);
    }
    let mut extent = Extent::default();
    loop {
        let bytes = file.fill_buf().map_err(io)?;
        let read = bytes.len();
        if read == 0 {
            return Ok(Some((Hashed::open(path).map_err(io)?, extent)));
        }
        extent.add(bytes);
        file.consume(read);
    }
}

/// A file that is hashed as it is read.
pub(crate) struct Hashed {
    file: File,
    hash: Sha256,
}

impl Hashed {
    pub(crate) fn open(path: &Path) -> io::Result<Self> {
        Ok(Self {
            file: File::open(path)?,
            hash: Sha256::new(),
        })
    }

    /// The hash of what was read, as lower-case hexadecimal.
    pub(crate) fn sha256(self) -> String {
        hex(&self.hash.finalize())
    }
}

impl Read for Hashed {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let read = self.file.read(out)?;
        self.hash.update(&out[..read]);
        Ok(read)
    }
}

/// SHA-256 as lower-case hexadecimal.
pub fn hex_sha256(bytes: &[u8]) -> String {
    hex_sha256_of([bytes])
}

/// SHA-256 of parts, one after the other.
pub(crate) fn hex_sha256_of<'a>(parts: impl IntoIterator<Item = &'a [u8]>) -> String {
    let mut hash = Sha256::new();
    parts.into_iter().for_each(|part| hash.update(part));
    hex(&hash.finalize())
}

/// Bytes as lower-case hexadecimal.
pub(crate) fn hex(bytes: &[u8]) -> String {
    bytes
        .iter()
        .fold(String::with_capacity(64), |mut text, byte| {
            use std::fmt::Write as _;
            // Writing to a string cannot fail.
            let _ = write!(text, "{byte:02x}");
            text
        })
}
