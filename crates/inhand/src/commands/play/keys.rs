//! Keys that control playing, where there is a terminal.

use inhand_live::{Control, Controls};

/// How far the arrows go, seconds.
const STEP_S: f64 = 5.0;

/// Keys and what they do; those with several bytes are what terminals send for arrows and Home.
const KEYS: [(&[u8], Control); 20] = [
    (b" ", Control::Toggle),
    (b"\x1b[C", Control::SeekBy(STEP_S)),
    (b"\x1bOC", Control::SeekBy(STEP_S)),
    (b"\x1b[D", Control::SeekBy(-STEP_S)),
    (b"\x1bOD", Control::SeekBy(-STEP_S)),
    (b"\x1b[A", Control::Faster),
    (b"\x1bOA", Control::Faster),
    (b"+", Control::Faster),
    (b"=", Control::Faster),
    (b"\x1b[B", Control::Slower),
    (b"\x1bOB", Control::Slower),
    (b"-", Control::Slower),
    (b"0", Control::SeekTo(0.0)),
    (b"\x1b[H", Control::SeekTo(0.0)),
    (b"\x1bOH", Control::SeekTo(0.0)),
    (b"\x1b[1~", Control::SeekTo(0.0)),
    (b"q", Control::Stop),
    (b"Q", Control::Stop),
    // Ctrl-D; Ctrl-C is a signal as ever.
    (b"\x04", Control::Stop),
    (b"\x1b[7~", Control::SeekTo(0.0)),
];

/// Controls for the bytes from a terminal, without those of unknown keys. Removes from `bytes` each whole
/// key.
fn controls(bytes: &mut Vec<u8>) -> Vec<Control> {
    let mut found = Vec::new();
    let mut rest = &bytes[..];
    while !rest.is_empty() {
        if let Some((key, control)) = KEYS.iter().find(|(key, _)| rest.starts_with(key)) {
            found.push(*control);
            rest = &rest[key.len()..];
        } else if KEYS.iter().any(|(key, _)| key.starts_with(rest)) {
            break;
        } else {
            rest = &rest[1..];
        }
    }
    *bytes = rest.to_vec();
    found
}

#[cfg(unix)]
mod terminal {
    use std::io::{self, IsTerminal, Read};
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::thread::{self, JoinHandle};

    use rustix::process::getpgrp;
    use rustix::termios::{
        LocalModes, OptionalActions, SpecialCodeIndex, Termios, tcgetattr, tcgetpgrp, tcsetattr,
    };

    use super::{Controls, controls};

    /// Keys are read until this is dropped; then the terminal is as it was.
    pub(crate) struct Keys {
        before: Termios,
        over: Arc<AtomicBool>,
        thread: Option<JoinHandle<()>>,
    }

    impl Keys {
        /// `None` without a terminal, or where it belongs to another job: reading would stop this one.
        pub(crate) fn listen(player: Controls, quiet: bool) -> Option<Self> {
            let stdin = io::stdin();
            let ours = tcgetpgrp(&stdin).is_ok_and(|group| group == getpgrp());
            if quiet || !ours || !io::stderr().is_terminal() {
                return None;
            }
            let before = tcgetattr(&stdin).ok()?;
            let mut keys = before.clone();
            // Key by key and without an echo. Ctrl-C stays a signal.
            keys.local_modes -= LocalModes::ICANON | LocalModes::ECHO;
            // Reading returns after a tenth of a second without a key.
            keys.special_codes[SpecialCodeIndex::VMIN] = 0;
            keys.special_codes[SpecialCodeIndex::VTIME] = 1;
            let over = Arc::<AtomicBool>::default();
            tcsetattr(&stdin, OptionalActions::Now, &keys).ok()?;
            let mut keys = Self {
                before,
                over: Arc::clone(&over),
                thread: None,
            };
            let thread = thread::Builder::new()
                .name("keys".to_owned())
                .spawn(move || read(&player, &over));
            keys.thread = Some(thread.ok()?);
            Some(keys)
        }
    }

    impl Drop for Keys {
        fn drop(&mut self) {
            self.over.store(true, Ordering::SeqCst);
            if let Some(thread) = self.thread.take() {
                // It reads for a tenth of a second at most.
                let _ = thread.join();
            }
            let _ = tcsetattr(io::stdin(), OptionalActions::Now, &self.before);
        }
    }

    fn read(player: &Controls, over: &AtomicBool) {
        let (mut pressed, mut bytes) = ([0; 32], Vec::new());
        while !over.load(Ordering::SeqCst) {
            match io::stdin().lock().read(&mut pressed) {
                // Whatever began a key and did not go on was none.
                Ok(0) => bytes.clear(),
                Ok(count) => bytes.extend_from_slice(&pressed[..count]),
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(_) => return,
            }
            for control in controls(&mut bytes) {
                if !player.send(control) {
                    return;
                }
            }
        }
    }
}

#[cfg(unix)]
pub(super) use terminal::Keys;

/// Without Unix terminals there are no keys.
#[cfg(not(unix))]
pub(super) struct Keys;

#[cfg(not(unix))]
impl Keys {
    pub(super) fn listen(_player: Controls, _quiet: bool) -> Option<Self> {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pressed(bytes: &[u8]) -> (Vec<Control>, Vec<u8>) {
        let mut bytes = bytes.to_vec();
        (controls(&mut bytes), bytes)
    }

    #[test]
    fn keys_are_told_apart_however_they_come() {
        let (found, rest) = pressed(b" \x1b[C\x1b[D\x1bOA-x\x1b[5~0q");
        let expected = [
            Control::Toggle,
            Control::SeekBy(5.0),
            Control::SeekBy(-5.0),
            Control::Faster,
            Control::Slower,
            Control::SeekTo(0.0),
            Control::Stop,
        ];
        assert_eq!((&found[..], &rest[..]), (&expected[..], &b""[..]));
    }

    #[test]
    fn half_a_key_waits_for_its_rest() {
        assert_eq!(pressed(b"\x1b["), (vec![], b"\x1b[".to_vec()));
        let (found, _) = pressed(b"\x1b[1~");
        assert_eq!(found, [Control::SeekTo(0.0)]);
        assert_eq!(pressed(b"\xff\x00").0, []);
    }
}
