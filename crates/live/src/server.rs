//! A recording that viewers can connect to.

use std::net::{SocketAddr, TcpListener};
use std::sync::mpsc::{self, Receiver, SyncSender};
use std::time::{Duration, SystemTime};

use inhand_container::Timeline;

use crate::acceptor::{Acceptor, bind};
use crate::advertisement::Advertisement;
use crate::clients::Clients;
use crate::clock::{Clock, FASTEST, SLOWEST};
use crate::control::{Command, Controls};
use crate::error::LiveError;
use crate::event::Event;
use crate::guests::Guests;
use crate::player::{CLOSING, Ending, Player, Repeat, Times};
use crate::protocol::server_info;
use crate::retained::Retained;
use crate::start::StartOnSubscribe;

/// Commands that may wait; viewers that say more wait themselves.
const WAITING: usize = 256;

/// Time that viewers may take to read the rest of a recording that has ended.
const FINISHED: Duration = Duration::from_secs(30);

/// Settings of a server.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Address to listen at, such as `127.0.0.1`.
    pub host: String,
    /// Origins of pages that may connect, such as `https://viewer.example`, besides those on this computer and of
    /// the known viewers; `*` for all.
    pub origins: Vec<String>,
    /// Port; 0 for any that is free.
    pub port: u16,
    /// Name that viewers show.
    pub name: String,
    /// Seconds of the recording a second.
    pub speed: f64,
    /// Start of playback, seconds since the first message.
    pub start_s: f64,
    /// Whether playback is paused at first.
    pub paused: bool,
    /// Whether playback goes on while no client is subscribed.
    pub unattended: bool,
    /// Behaviour at the end.
    pub repeat: Repeat,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            host: "127.0.0.1".to_owned(),
            origins: Vec::new(),
            port: 8765,
            name: String::new(),
            speed: 1.0,
            start_s: 0.0,
            paused: false,
            unattended: false,
            repeat: Repeat::Stay,
        }
    }
}

/// Counts of a playback.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Played {
    /// Viewers that connected.
    pub viewers: u64,
    /// Messages that were sent, to all viewers together.
    pub sent: u64,
    /// Messages that viewers did not get because they read too slowly.
    pub missed: u64,
}

/// A recording that viewers can connect to.
///
/// ```no_run
/// use std::fs::File;
/// use std::io::BufReader;
///
/// use inhand_container::{Source, Timeline};
/// use inhand_live::{Server, Settings};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let file = BufReader::new(File::open("take.mcap")?);
/// let timeline = Timeline::open(Source::open("take.mcap", file)?)?;
/// let server = Server::open(timeline, &Settings::default())?;
/// println!("ws://{}", server.address());
/// server.run(|_event| {})?;
/// # Ok(())
/// # }
/// ```
pub struct Server<'a> {
    timeline: Timeline<'a>,
    span: (u64, u64),
    settings: Settings,
    listener: TcpListener,
    address: SocketAddr,
    sender: SyncSender<Command>,
    commands: Receiver<Command>,
}

impl<'a> Server<'a> {
    /// Takes the port. Viewers that connect are served when it runs.
    ///
    /// # Errors
    ///
    /// [`LiveError::Empty`], [`LiveError::Speed`], [`LiveError::Start`], [`LiveError::PortInUse`],
    /// [`LiveError::Bind`].
    pub fn open(timeline: Timeline<'a>, settings: &Settings) -> Result<Self, LiveError> {
        let file = || timeline.file().to_owned();
        let Some(span) = timeline.span() else {
            return Err(LiveError::Empty {
                file: file(),
                channels: timeline.channels().count(),
            });
        };
        if !(SLOWEST..=FASTEST).contains(&settings.speed) {
            return Err(LiveError::Speed {
                found: settings.speed,
                slowest: SLOWEST,
                fastest: FASTEST,
            });
        }
        let duration_s = span.1.saturating_sub(span.0) as f64 / 1e9;
        if !(0.0..=duration_s).contains(&settings.start_s) {
            return Err(LiveError::Start {
                file: file(),
                found: settings.start_s,
                duration_s,
            });
        }
        let listener = bind(&settings.host, settings.port)?;
        let address = listener.local_addr().map_err(|source| LiveError::Bind {
            host: settings.host.clone(),
            port: settings.port,
            source,
        })?;
        let (sender, commands) = mpsc::sync_channel(WAITING);
        Ok(Self {
            timeline,
            span,
            settings: settings.clone(),
            listener,
            address,
            sender,
            commands,
        })
    }

    /// Address that viewers connect to.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Controls playing from other threads.
    pub fn controls(&self) -> Controls {
        Controls::new(self.sender.clone())
    }

    /// Plays until the end or until a stop is requested. `notify` is called from this thread and should
    /// not take long.
    ///
    /// # Errors
    ///
    /// [`LiveError::File`] where the file is damaged or changes while it is played,
    /// [`LiveError::Thread`].
    pub fn run(self, notify: impl FnMut(Event)) -> Result<Played, LiveError> {
        let (settings, span) = (self.settings, self.span);
        let advertisement = Advertisement::new(self.timeline.channels());
        let start = span
            .0
            .saturating_add((settings.start_s * 1e9).round() as u64);
        let mut clock = Clock::new(span);
        clock.set_speed(Duration::ZERO, settings.speed);
        let mut player = Player {
            greeting: vec![
                server_info(&settings.name, &session(), span),
                advertisement.advertise(),
            ],
            retained: Retained::new(advertisement.adding()),
            timeline: self.timeline,
            advertisement,
            span,
            clock,
            start: StartOnSubscribe::new(settings.unattended),
            repeat: settings.repeat,
            wanted: !settings.paused,
            ended: false,
            shown: span.0,
            clients: Clients::default(),
            notify,
            times: Times::default(),
        };
        for (topic, why) in std::mem::take(&mut player.advertisement.left_out) {
            let why = why.to_owned();
            (player.notify)(Event::LeftOut { topic, why });
        }
        player.jump(Duration::ZERO, start)?;
        let acceptor = {
            let guests = Guests {
                origins: settings.origins.clone(),
                only_here: self.address.ip().is_loopback(),
            };
            Acceptor::open(self.listener, self.address, guests, self.sender)?
        };
        let result = player.play(&self.commands);
        if let Err(error) = &result {
            player.clients.fail(&error.to_string());
        }
        let patience = match result {
            Ok(Ending::Finished) => FINISHED,
            _ => CLOSING,
        };
        player.disconnect_all(&self.commands, patience);
        // Threads that still send commands must not wait for the player.
        drop(self.commands);
        drop(acceptor);
        result.map(|_| Played {
            viewers: player.clients.came,
            sent: player.clients.sent,
            missed: player.clients.missed,
        })
    }
}

/// Tells this server from one that was here before, so that viewers that reconnect begin anew.
fn session() -> String {
    let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
    let nanos = since.map_or(0, |since| since.as_nanos());
    format!("{nanos}-{}", std::process::id())
}

impl std::fmt::Debug for Server<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Server")
            .field("address", &self.address)
            .field("settings", &self.settings)
            .finish_non_exhaustive()
    }
}
