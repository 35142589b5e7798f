//! Outputs appear whole or not at all.

use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};
use std::sync::{LazyLock, PoisonError, RwLock};
use std::time::SystemTime;

use tempfile::{TempDir, TempPath};

use crate::error::SessionError;

/// How the names of unfinished files begin.
const TEMPORARY_PREFIX: &str = ".inhand-unfinished-";

/// Held while an unfinished file or a scratch folder is made or gets its name.
static MAKING: RwLock<()> = RwLock::new(());

/// Lets no thread of this process make or finish files or scratch folders any more: whoever tries waits until the
/// process ends. For the end of a process, before [`remove_unfinished`].
pub fn make_no_more() {
    std::mem::forget(MAKING.write().unwrap_or_else(PoisonError::into_inner));
}

/// How the names of unfinished files of this process begin.
///
/// Processes on other machines, and in other containers, may have the same number.
fn own_prefix() -> &'static str {
    static PREFIX: LazyLock<String> = LazyLock::new(|| {
        let begin = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
        let nanos = begin.map_or(0, |since| since.as_nanos());
        format!("{TEMPORARY_PREFIX}{}-{nanos:x}-", std::process::id())
    });
    &PREFIX
}

/// Removes unfinished files from a folder: those of any process, or only those and the scratch folders of this one.
pub fn remove_unfinished(folder: &Path, own: bool) {
    let prefix = if own { own_prefix() } else { TEMPORARY_PREFIX };
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    for entry in entries.filter(|e| e.file_name().to_string_lossy().starts_with(prefix)) {
        // What cannot be removed does no harm.
        if std::fs::remove_file(entry.path()).is_err() && own {
            let _ = std::fs::remove_dir_all(entry.path());
        }
    }
}

/// Writes a file beside its target and renames it, so that nobody ever sees half of it. A device or a FIFO
/// is written to, and a link is followed: neither is replaced.
///
/// # Errors
///
/// [`SessionError::Io`], or what `write` returns; then the target is as it was.
pub fn write_atomic(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<(), SessionError>,
) -> Result<(), SessionError> {
    write_whole(path, write, false)
}

/// The same for a file that must outlast a crash of the machine.
///
/// # Errors
///
/// As [`write_atomic`].
pub fn write_durable(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<(), SessionError>,
) -> Result<(), SessionError> {
    write_whole(path, write, true)
}

fn write_whole(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<(), SessionError>,
    durable: bool,
) -> Result<(), SessionError> {
    let link = path.is_symlink().then(|| path.canonicalize());
    let link = link.and_then(Result::ok);
    let path = link.as_deref().unwrap_or(path);
    let folder = folder_for_unfinished(path)?;
    let making = MAKING.read();
    let temporary = tempfile::Builder::new()
        .prefix(own_prefix())
        .tempfile_in(folder)
        .map_err(SessionError::io("write", path))?;
    drop(making);
    let (file, temporary) = temporary.into_parts();
    let mut out = BufWriter::with_capacity(1 << 20, file);
    write(&mut out)?;
    out.flush().map_err(SessionError::io("write", path))?;
    if is_stream(path) {
        return copy_into(path, &temporary).map_err(SessionError::io("write", path));
    }
    let _naming = MAKING.read();
    rename(out, temporary, path, durable)
}

/// Whether a path is a device, a FIFO or a socket.
pub fn is_stream(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|facts| !facts.is_file() && !facts.is_dir())
}

fn copy_into(stream: &Path, finished: &Path) -> std::io::Result<()> {
    let mut stream = File::options().write(true).open(stream)?;
    std::io::copy(&mut File::open(finished)?, &mut stream)?;
    Ok(())
}

/// Gives a temporary file the name of its target.
fn rename(
    out: BufWriter<File>,
    temporary: TempPath,
    path: &Path,
    durable: bool,
) -> Result<(), SessionError> {
    if durable {
        // What is read by other processes, or by a later call after a crash, has to be on the disk
        // before its name is; and some network file systems say only now that there is no room.
        out.get_ref()
            .sync_all()
            .map_err(SessionError::io("write", path))?;
    }
    drop(out);
    // Temporary files are private to their owner; a result is an ordinary file.
    set_ordinary_permissions(&temporary)?;
    temporary
        .persist(path)
        .map_err(|error| SessionError::io("write", path)(error.error))
}

/// Folder of a file.
pub(crate) fn folder_of(path: &Path) -> &Path {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty());
    folder.unwrap_or(Path::new("."))
}

/// Folder of a file to be written, created where it is missing.
fn make_folder_of(path: &Path) -> Result<&Path, SessionError> {
    let folder = folder_of(path);
    std::fs::create_dir_all(folder).map_err(SessionError::io("create folder", folder))?;
    Ok(folder)
}

/// Folder of an output while it is unfinished.
///
/// Some formats seek back while they are written, which a FIFO cannot: it gets the finished file.
fn folder_for_unfinished(path: &Path) -> Result<PathBuf, SessionError> {
    match is_stream(path) {
        true => Ok(std::env::temp_dir()),
        false => make_folder_of(path).map(Path::to_owned),
    }
}

/// A temporary folder beside an output, on a disk that has room for it. For a device or a FIFO it is among the
/// temporary files of the system.
///
/// # Errors
///
/// [`SessionError::Io`].
pub fn scratch_folder(output: &Path) -> Result<TempDir, SessionError> {
    let folder = folder_for_unfinished(output)?;
    let _making = MAKING.read();
    tempfile::Builder::new()
        .prefix(own_prefix())
        .tempdir_in(&folder)
        .map_err(SessionError::io("create a folder in", &folder))
}

/// Writes text by [`write_atomic`].
///
/// # Errors
///
/// [`SessionError::Io`].
pub fn write_text(path: &Path, text: &str) -> Result<(), SessionError> {
    write_atomic(path, |out| {
        out.write_all(text.as_bytes())
            .map_err(SessionError::io("write", path))
    })
}

/// Whether two paths name one file: the same one on disk, or the same path where there is none.
pub fn same_file(a: &Path, b: &Path) -> bool {
    match (a.canonicalize(), b.canonicalize()) {
        (Ok(a), Ok(b)) => a == b,
        _ => a == b,
    }
}

/// Refuses an output that is also an input, or that exists and may not be replaced; a device or a FIFO is never replaced.
///
/// # Errors
///
/// [`SessionError::Usage`].
pub fn check_target(
    path: &Path,
    inputs: &[&Path],
    may_replace: impl FnOnce() -> bool,
) -> Result<(), SessionError> {
    let refuse = |message: &str| Err(SessionError::usage(path, message));
    if !path.exists() && path.is_symlink() {
        return refuse("the output is a link to a file that is not there: name that file");
    }
    if !path.exists() {
        return Ok(());
    }
    if inputs.iter().any(|input| same_file(path, input)) {
        return refuse("the output is also an input: name another file");
    }
    if path.is_dir() {
        return refuse("the output is a folder: name a file in it");
    }
    if is_stream(path) || may_replace() {
        return Ok(());
    }
    Err(already_exists(path))
}

/// An output, or a folder of outputs, that exists and must not change without --force.
pub fn already_exists(path: &Path) -> SessionError {
    SessionError::usage(path, "already exists; use --force to overwrite")
}

#[cfg(unix)]
fn set_ordinary_permissions(path: &Path) -> Result<(), SessionError> {
    use std::os::unix::fs::PermissionsExt as _;
    let permissions = std::fs::Permissions::from_mode(0o644);
    std::fs::set_permissions(path, permissions).map_err(SessionError::io("write", path))
}

#[cfg(not(unix))]
fn set_ordinary_permissions(_path: &Path) -> Result<(), SessionError> {
    Ok(())
}
