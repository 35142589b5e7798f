//! `inhand play FILE`.

use std::net::SocketAddr;
use std::path::PathBuf;

use anyhow::Result;
use inhand_container::Timeline;
use inhand_live::{
    Control, Controls, Event, LiveError, Mode, Played, Progress, Repeat, Server, Settings,
};
use inhand_session::containers::{self, Instant};

use crate::commands::cut::{instant, seconds};
use crate::console::{Console, data};
use crate::exit::{Exit, UsageError};
use crate::interrupt;

/// Play an MCAP file live to Foxglove or Lichtblick
///
/// Open a "Foxglove WebSocket" connection to the printed address, with up to 256 viewers. Playback starts when the
/// first client subscribes. Foxglove has its own play bar; for all viewers together use the keys in this terminal:
/// space pauses, left and right seek by 5 s, up and down change the speed, 0 seeks to the start, q or Ctrl-C ends.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// An MCAP file.
    input: PathBuf,
    /// Address to listen at; 0.0.0.0 for viewers on other computers.
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1")]
    host: String,
    /// Origin of web pages that may connect, with its scheme; * for all.
    ///
    /// Without it pages on this computer, of app.foxglove.dev and of installed viewers may. Programs that are no
    /// browsers always may.
    #[arg(long, value_name = "ORIGIN")]
    allow_origin: Vec<String>,
    /// Port to listen at; 0 for any free port.
    #[arg(long, value_name = "PORT", default_value_t = 8765)]
    port: u16,
    /// Playback speed, 0.01 to 100.
    #[arg(
        long,
        value_name = "FACTOR",
        default_value_t = 1.0,
        allow_negative_numbers = true
    )]
    speed: f64,
    /// Start: seconds since the first message, or a UTC time.
    ///
    /// A UTC time is written as 2024-05-06T12:00:00Z.
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = instant)]
    start: Option<Instant>,
    /// Start paused.
    #[arg(long)]
    paused: bool,
    /// Start over at the end.
    #[arg(long = "loop")]
    repeat: bool,
    /// End after the file, when all viewers have received everything.
    #[arg(long, conflicts_with = "repeat")]
    once: bool,
    /// Start at once, and play without viewers too.
    #[arg(long)]
    now: bool,
}

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    let step = console.step("reading the index");
    let timeline = Timeline::open(containers::open(&args.input)?)?;
    drop(step);
    let settings = Settings {
        host: args.host.clone(),
        origins: args.allow_origin.clone(),
        port: args.port,
        name: timeline.file().to_owned(),
        speed: args.speed,
        start_s: start_s(args.start, timeline.span()),
        paused: args.paused,
        unattended: args.now,
        repeat: match (args.repeat, args.once) {
            (true, _) => Repeat::Always,
            (false, true) => Repeat::Finish,
            (false, false) => Repeat::Stay,
        },
    };
    let topics = timeline.channels().count();
    let seconds = seconds(timeline.span());
    let server = Server::open(timeline, &settings).map_err(usage)?;
    let controls = server.controls();
    interrupt::stops_by(move || {
        controls.send(Control::Stop);
    });
    let address = server.address();
    console.say(&format!(
        "playing  {}: {seconds:.1} s, {topics} channels",
        settings.name
    ));
    say_how(console, address);
    // For scripts: what they need to connect, as soon as they can.
    data(&format!("ws://{address}\n"))?;
    let keys = Keys::listen(server.controls(), console.quiet);
    let (bar, with_keys) = (console.bar("{msg}"), keys.is_some());
    let played = server.run(|event| match (&event, words(&event)) {
        (Event::Progress(now), _) => bar.set_message(progress_line(now, with_keys)),
        (_, Some(line)) => bar.suspend(|| console.say(&line)),
        _ => {}
    });
    // The terminal is as it was before anything more is said.
    bar.finish_and_clear();
    drop(keys);
    say_played(console, played?);
    Ok(Exit::Done)
}

/// Seconds from the first message to the start of playback.
fn start_s(start: Option<Instant>, span: Option<(u64, u64)>) -> f64 {
    let first = span.map_or(0, |(first, _)| first);
    match start {
        None => 0.0,
        Some(Instant::Utc(time)) if time < first => -((first - time) as f64) / 1e9,
        Some(Instant::Utc(time)) => (time - first) as f64 / 1e9,
        Some(Instant::SinceStart(seconds)) => seconds,
    }
}

/// Wrong values of options are wrong usage.
fn usage(error: LiveError) -> anyhow::Error {
    match error {
        LiveError::Speed { .. } | LiveError::Start { .. } => {
            UsageError(format!("--{error}")).into()
        }
        other => other.into(),
    }
}

fn say_how(console: &Console, address: SocketAddr) {
    let (shown, elsewhere) = match address.ip().is_unspecified() {
        true => (
            format!("localhost:{}", address.port()),
            "; on other computers with this one's name",
        ),
        false => (address.to_string(), ""),
    };
    console.say(&format!(
        "open     a Foxglove WebSocket connection to ws://{shown} in Foxglove or Lichtblick{elsewhere}"
    ));
}

fn say_played(console: &Console, played: Played) {
    let viewers = viewers(played.viewers);
    let missed = match played.missed {
        0 => String::new(),
        missed => format!(", {missed} left out for viewers that read too slowly"),
    };
    console.say(&format!(
        "played   {} messages to {viewers}{missed}",
        played.sent
    ));
}

/// A number of viewers in words.
fn viewers(count: u64) -> String {
    match count {
        1 => "1 viewer".to_owned(),
        _ => format!("{count} viewers"),
    }
}

/// The line about an event, except for progress.
fn words(event: &Event) -> Option<String> {
    Some(match event {
        Event::Arrived { viewer } => format!("viewer   {viewer} connected"),
        Event::Left { viewer, how } => format!("viewer   {viewer} {how}"),
        Event::Missed { viewer, messages } => {
            format!("warning  {viewer} reads too slowly: {messages} messages were left out for it")
        }
        Event::Strange { viewer } => format!(
            "warning  {viewer} connected without the Foxglove WebSocket protocol; it got instructions"
        ),
        Event::Refused { viewer, why } => format!("warning  {viewer} was refused: {why}"),
        Event::PutOut { viewer } => {
            format!("warning  {viewer} had to go for another: it wanted or read nothing")
        }
        Event::Full { viewer, viewers } => {
            format!("warning  {viewer} was refused: there are {viewers} connections already")
        }
        Event::LeftOut { topic, why } => format!("warning  {topic} is left out: {why}"),
        Event::Ended => "end      of the recording; viewers can seek back".to_owned(),
        _ => return None,
    })
}

/// The progress line; it lists the keys where keys are read.
fn progress_line(now: &Progress, keys: bool) -> String {
    let mode = match now.mode {
        Mode::Playing => "playing",
        Mode::Paused => "paused",
        Mode::Waiting => "waiting for a viewer",
        _ => "at the end",
    };
    let help = match keys {
        true => "  [space, arrows, 0, q]",
        false => "",
    };
    let viewers = viewers(now.viewers as u64);
    let (at, of) = (clock(now.at_s), clock(now.duration_s));
    format!("{at} of {of}  x{}  {viewers}  {mode}{help}", now.speed)
}

/// Minutes and seconds to the tenth, cut off.
fn clock(seconds: f64) -> String {
    let tenths = (seconds * 10.0) as u64;
    format!("{}:{:02}.{}", tenths / 600, tenths / 10 % 60, tenths % 10)
}

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
use terminal::Keys;

/// Without Unix terminals there are no keys.
#[cfg(not(unix))]
struct Keys;

#[cfg(not(unix))]
impl Keys {
    fn listen(_player: Controls, _quiet: bool) -> Option<Self> {
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

    #[test]
    fn times_are_minutes_and_seconds() {
        assert_eq!(clock(0.0), "0:00.0");
        assert_eq!(clock(59.99), "0:59.9");
        assert_eq!(clock(600.05), "10:00.0");
        assert_eq!(clock(6001.25), "100:01.2");
    }
}
