//! Ctrl-C and SIGTERM: which results are kept, and how to go on.

use std::io::{self, Write};
use std::process;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

use inhand_session::remove_unfinished;
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
    stop: None,
});

struct State {
    kept: Option<String>,
    files: usize,
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
    remove_unfinished();
    // A shell that runs a script ends it where a command ends by the signal, but not for an exit code.
    let _ = emulate_default_handler(signal);
    process::exit(128 + signal);
}
