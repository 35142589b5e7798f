//! Ctrl-C and SIGTERM: which results are kept, and how to go on.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

use inhand_session::{make_no_more, remove_unfinished};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use signal_hook::low_level::emulate_default_handler;

use crate::progress;

/// Interval at which signals are looked for and the progress line is drawn.
const TICK: Duration = Duration::from_millis(100);

/// What an interruption would leave. Signals are those of the process.
static STATE: Mutex<State> = Mutex::new(State {
    kept: None,
    files: 0,
    folders: Vec::new(),
    stop: None,
});

struct State {
    kept: Option<String>,
    files: usize,
    /// Folders that are written into, and whether folders in them are too.
    folders: Vec<(PathBuf, bool)>,
    stop: Option<Box<dyn Fn() + Send>>,
}

/// Listens to Ctrl-C and SIGTERM, and draws the progress line. A second signal ends the process at once.
pub(crate) fn attend() -> io::Result<()> {
    let (again, signal) = (Arc::<AtomicBool>::default(), Arc::<AtomicUsize>::default());
    for number in [SIGINT, SIGTERM] {
        flag::register_conditional_default(number, Arc::clone(&again))?;
        flag::register(number, Arc::clone(&again))?;
        flag::register_usize(number, Arc::clone(&signal), number as usize)?;
    }
    let attend = move || {
        loop {
            thread::sleep(TICK);
            match signal.swap(0, Ordering::SeqCst) {
                0 => progress::tick(),
                number => interrupted(number as i32),
            }
        }
    };
    thread::Builder::new()
        .name("signals".to_owned())
        .spawn(attend)?;
    Ok(())
}

/// States what is kept if the process is interrupted from now on, and how to go on.
pub(crate) fn keeps(words: impl Into<String>) {
    state().kept = Some(words.into());
}

/// Counts a file that is finished.
pub(crate) fn wrote() {
    state().files += 1;
}

/// Names a folder that unfinished files are removed from; `all` for those in it too.
pub(crate) fn writes_in(folder: &Path, all: bool) {
    let here = folder.as_os_str().is_empty();
    let folder = if here { Path::new(".") } else { folder };
    let entry = (folder.to_owned(), all);
    let folders = &mut state().folders;
    if !folders.contains(&entry) {
        folders.push(entry);
    }
}

/// Calls this instead of ending the process.
pub(crate) fn stops_by(stop: impl Fn() + Send + 'static) {
    state().stop = Some(Box::new(stop));
}

fn state() -> MutexGuard<'static, State> {
    STATE.lock().unwrap_or_else(PoisonError::into_inner)
}

fn interrupted(signal: i32) {
    let state = state();
    if let Some(stop) = &state.stop {
        return stop();
    }
    progress::end();
    let kept = match (&state.kept, state.files) {
        (Some(kept), _) => kept.clone(),
        (None, 0) => "nothing was written; run the same command again".to_owned(),
        (None, files) => {
            let files = if files == 1 { "file is" } else { "files are" };
            format!(
                "{} {files} written and kept; run the same command again",
                state.files
            )
        }
    };
    // There is no place to report a lost stderr.
    let _ = writeln!(io::stderr().lock(), "interrupted: {kept}");
    let mut folders = state.folders.clone();
    // Outputs that are devices or FIFOs are made there first.
    folders.push((std::env::temp_dir(), false));
    make_no_more();
    for (folder, all) in &folders {
        clean(folder, *all);
    }
    // A shell that runs a script ends it where a command ends by the signal, but not for an exit code.
    let _ = emulate_default_handler(signal);
    process::exit(128 + signal);
}

/// Removes unfinished files of this process.
fn clean(folder: &Path, all: bool) {
    remove_unfinished(folder, true);
    let entries = all.then(|| folder.read_dir().ok()).flatten();
    for entry in entries.into_iter().flatten().flatten() {
        if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
            clean(&entry.path(), true);
        }
    }
}
