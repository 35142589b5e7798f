//! Outputs appear whole or not at all.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fs::{self, File, TryLockError};
use std::io::{self, BufWriter, Seek as _, Write as _};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::error::SessionError;

/// How the names of unfinished files and folders begin.
const PREFIX: &str = ".inhand-unfinished-";

/// What this process has not finished.
static OPEN: Mutex<Open> = Mutex::new(Open {
    unfinished: BTreeSet::new(),
    searched: BTreeSet::new(),
});

struct Open {
    unfinished: BTreeSet<PathBuf>,
    /// Folders that were searched for what killed processes left.
    searched: BTreeSet<PathBuf>,
}

fn open() -> MutexGuard<'static, Open> {
    OPEN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes the unfinished files and folders of this process, for its end: a thread that begins or finishes one
/// afterwards waits until the process ends.
pub fn remove_unfinished() {
    let open = open();
    open.unfinished.iter().for_each(|path| remove(path));
    std::mem::forget(open);
}

/// Removes a file or a folder. What cannot be removed does no harm.
fn remove(path: &Path) {
    let _ = fs::remove_file(path).or_else(|_| fs::remove_dir_all(path));
}

/// A file or folder that is removed when dropped. It is locked while it is open, so that other processes remove it
/// if this one is killed, and not before.
#[derive(Debug)]
pub struct Unfinished {
    path: PathBuf,
    /// `None` for a folder on a system that cannot open folders; other processes leave those.
    file: Option<File>,
}

impl Unfinished {
    /// Its path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Makes one in a folder, and removes what killed processes left there.
    fn make(
        folder: &Path,
        make: impl Fn() -> io::Result<(PathBuf, Option<File>)>,
    ) -> io::Result<Self> {
        let mut open = open();
        if open.searched.insert(folder.to_owned()) {
            remove_left(folder);
        }
        loop {
            let (path, file) = make()?;
            let lock = file.as_ref().map(File::try_lock);
            // Another process may remove it as left before it is locked. Without locks in a file system nothing is.
            if !matches!(lock, Some(Err(TryLockError::WouldBlock))) && path.exists() {
                open.unfinished.insert(path.clone());
                return Ok(Self { path, file });
            }
        }
    }

    /// Gives a finished file the name of its target, and the mode of the file that it replaces.
    fn finish(self, target: &Path) -> io::Result<()> {
        let _open = open();
        if let Ok(replaced) = fs::metadata(target) {
            fs::set_permissions(&self.path, replaced.permissions())?;
        }
        fs::rename(&self.path, target)
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        let mut open = open();
        remove(&self.path);
        open.unfinished.remove(&self.path);
    }
}

/// Removes what killed processes left in a folder: what nobody has locked.
fn remove_left(folder: &Path) {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    for entry in entries.filter(|e| e.file_name().to_string_lossy().starts_with(PREFIX)) {
        // A FIFO would wait for a writer.
        let kind = (entry.file_type().ok()).filter(|kind| kind.is_file() || kind.is_dir());
        let (path, mut options) = (entry.path(), File::options());
        // Network file systems lock files only where they are open for writing.
        let file = kind.map(|kind| options.read(true).write(kind.is_file()).open(&path));
        if let Some(Ok(file)) = file
            && file.try_lock().is_ok()
        {
            remove(&path);
        }
    }
}

/// A folder whose results only this process writes, until this is dropped.
#[derive(Debug)]
pub struct FolderClaim {
    _holder: Option<Unfinished>,
    _lock: File,
}

/// Claims a folder for the results of this process; it is created where it is missing. `None` where it cannot be
/// opened: writing into it says why.
///
/// # Errors
///
/// [`SessionError::Usage`] that names the process which has claimed it.
pub fn claim_folder(folder: &Path) -> Result<Option<FolderClaim>, SessionError> {
    let Ok(lock) = fs::create_dir_all(folder).and_then(|()| File::open(folder)) else {
        return Ok(None);
    };
    let path = folder.join(format!("{PREFIX}holder"));
    if matches!(lock.try_lock(), Err(TryLockError::WouldBlock)) {
        let holder = fs::read_to_string(path).unwrap_or_else(|_| "another process".to_owned());
        let message = "is writing into this folder: wait until it ends, or name another folder";
        return Err(SessionError::usage(folder, format!("{holder} {message}")));
    }
    let command: Vec<_> = std::env::args_os().collect();
    let command = command.join(OsStr::new(" "));
    let holder = Unfinished::make(folder, || {
        let mut file = File::create(&path)?;
        write!(
            file,
            "process {} ({})",
            std::process::id(),
            command.display()
        )?;
        Ok((path.clone(), Some(file)))
    });
    Ok(Some(FolderClaim {
        _holder: holder.ok(),
        _lock: lock,
    }))
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

/// The same; a `durable` file outlasts a crash of the machine.
///
/// # Errors
///
/// As [`write_atomic`].
pub fn write_whole(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<(), SessionError>,
    durable: bool,
) -> Result<(), SessionError> {
    let failed = || SessionError::io("write", path);
    let link = (path.is_symlink() && !is_stream(path)).then(|| path.canonicalize());
    let link = link.and_then(Result::ok);
    let target = link.as_deref().unwrap_or(path);
    let folder = folder_for_unfinished(target)?;
    let unfinished = Unfinished::make(&folder, || {
        let made = new_name(!is_stream(target)).tempfile_in(&folder)?;
        let (file, path) = made.keep()?;
        Ok((path, Some(file)))
    });
    let unfinished = unfinished.map_err(failed())?;
    let locked = unfinished.file.as_ref();
    let file = locked.map_or_else(|| File::create(unfinished.path()), File::try_clone);
    let file = file.map_err(failed())?;
    let mut out = BufWriter::with_capacity(1 << 20, file);
    write(&mut out)?;
    out.flush().map_err(failed())?;
    if is_stream(target) {
        return copy_into(target, out.get_ref()).map_err(failed());
    }
    if durable {
        // What is read by other processes, or by a later call after a crash, has to be on the disk
        // before its name is; and some network file systems say only now that there is no room.
        out.get_ref().sync_all().map_err(failed())?;
    }
    drop(out);
    unfinished.finish(target).map_err(failed())
}

/// Whether a path is a device, a FIFO, a socket, or an open file of this process.
pub fn is_stream(path: &Path) -> bool {
    let open = ["/dev/stdout", "/dev/stderr", "/dev/fd", "/proc"];
    let special = |facts: fs::Metadata| {
        !facts.is_dir() && (!facts.is_file() || open.iter().any(|open| path.starts_with(open)))
    };
    fs::metadata(path).is_ok_and(special)
}

/// Appends, since an open file may hold something before.
fn copy_into(stream: &Path, mut finished: &File) -> io::Result<()> {
    let mut stream = File::options().append(true).open(stream)?;
    finished.rewind()?;
    io::copy(&mut finished, &mut stream).map(drop)
}

/// Names for unfinished files and folders. A result has the mode of ordinary files, a copy for a stream is private.
fn new_name(ordinary: bool) -> tempfile::Builder<'static, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX);
    #[cfg(unix)]
    if ordinary {
        use std::os::unix::fs::PermissionsExt as _;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder
}

/// Folder of a file.
pub(crate) fn folder_of(path: &Path) -> &Path {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty());
    folder.unwrap_or(Path::new("."))
}

/// Folder of an output while it is unfinished, created where it is missing.
///
/// Some formats seek back while they are written, which a FIFO cannot: it gets the finished file.
fn folder_for_unfinished(path: &Path) -> Result<PathBuf, SessionError> {
    if is_stream(path) {
        return Ok(std::env::temp_dir());
    }
    let folder = folder_of(path);
    fs::create_dir_all(folder).map_err(SessionError::io("create folder", folder))?;
    Ok(folder.to_owned())
}

/// A temporary folder beside an output, on a disk that has room for it. For a device or a FIFO it is among the
/// temporary files of the system.
///
/// # Errors
///
/// [`SessionError::Io`].
pub fn scratch_folder(output: &Path) -> Result<Unfinished, SessionError> {
    let folder = folder_for_unfinished(output)?;
    let made = Unfinished::make(&folder, || {
        let path = new_name(false).tempdir_in(&folder)?.keep();
        let open = File::open(&path).ok();
        Ok((path, open))
    });
    made.map_err(SessionError::io("create a folder in", &folder))
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

/// Whether two paths name one file, also by links; or are the same where there is none.
pub fn same_file(a: &Path, b: &Path) -> bool {
    match (identity(a), identity(b)) {
        (Some(a), Some(b)) => a == b,
        _ => a == b,
    }
}

#[cfg(unix)]
fn identity(path: &Path) -> Option<(u64, u64)> {
    use std::os::unix::fs::MetadataExt as _;
    let facts = fs::metadata(path).ok()?;
    Some((facts.dev(), facts.ino()))
}

#[cfg(not(unix))]
fn identity(path: &Path) -> Option<PathBuf> {
    path.canonicalize().ok()
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
