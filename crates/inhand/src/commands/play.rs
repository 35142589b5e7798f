//! `inhand play FILE`.

mod keys;
mod status;

use std::net::SocketAddr;
use std::path::PathBuf;

use anyhow::{Context, Result};
use inhand_container::Timeline;
use inhand_live::{Control, Controls, LiveError, Played, Repeat, Server, Settings};
use inhand_session::containers::{self, Instant};

use crate::commands::cut::instant;
use crate::commands::play::keys::Keys;
use crate::commands::play::status::Status;
use crate::console::{Console, data};
use crate::exit::{Exit, UsageError};

/// Play an MCAP file live to Foxglove or Lichtblick
///
/// Open a "Foxglove WebSocket" connection to the printed address, with up to 32 viewers. Playback starts when the
/// first client subscribes. Foxglove has its own play bar; for all viewers together use the keys in this terminal:
/// space pauses, left and right seek by 5 s, up and down change the speed, 0 seeks to the start, q or Ctrl-C ends.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// An MCAP file.
    input: PathBuf,
    /// Address to listen at; 0.0.0.0 for viewers on other computers.
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1")]
    host: String,
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
    let step = console.step("looking at what is where");
    let timeline = Timeline::open(containers::open(&args.input)?)?;
    step.finish_and_clear();
    let settings = Settings {
        host: args.host.clone(),
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
    let seconds = super::cut::seconds(timeline.span());
    let server = Server::open(timeline, &settings).map_err(usage)?;
    stop_on_signals(server.controls())?;
    let address = server.address();
    console.say(&format!(
        "playing  {}: {seconds:.1} s, {topics} channels",
        settings.name
    ));
    say_how(console, address);
    // For scripts: what they need to connect, as soon as they can.
    data(&format!("ws://{address}\n"))?;
    let keys = Keys::listen(server.controls(), console.is_quiet());
    let mut status = Status::new(console, keys.is_some());
    let played = server.run(|event| status.tell(&event));
    // The terminal is as it was before anything more is said.
    drop((status, keys));
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
        LiveError::Speed { .. } => UsageError(format!("--{error}")).into(),
        LiveError::Start { .. } => UsageError(format!("--{error}")).into(),
        other => other.into(),
    }
}

fn stop_on_signals(controls: Controls) -> Result<()> {
    ctrlc::set_handler(move || {
        controls.send(Control::Stop);
    })
    .context("cannot listen to Ctrl-C")
}

fn say_how(console: &Console, address: SocketAddr) {
    if address.ip().is_unspecified() {
        let port = address.port();
        console.say(&format!(
            "open     a Foxglove WebSocket connection to ws://localhost:{port} in Foxglove or Lichtblick; on \
             other computers with this one's name"
        ));
    } else {
        console.say(&format!(
            "open     a Foxglove WebSocket connection to ws://{address} in Foxglove or Lichtblick"
        ));
    }
}

fn say_played(console: &Console, played: Played) {
    let viewers = match played.viewers {
        1 => "1 viewer".to_owned(),
        viewers => format!("{viewers} viewers"),
    };
    let missed = match played.missed {
        0 => String::new(),
        missed => format!(", {missed} left out for viewers that read too slowly"),
    };
    console.say(&format!(
        "played   {} messages to {viewers}{missed}",
        played.sent
    ));
}
