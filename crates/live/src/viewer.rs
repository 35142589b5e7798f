//! One connection: a thread that listens to a viewer and one that sends to it.

use std::io::{self, Read, Write};
use std::net::{Shutdown, SocketAddr, TcpStream};
use std::sync::Arc;
use std::sync::mpsc::SyncSender;
use std::thread;
use std::time::{Duration, Instant};

use tungstenite::handshake::server::{ErrorResponse, Request as Handshake, Response};
use tungstenite::http::{HeaderValue, StatusCode};
use tungstenite::protocol::WebSocketConfig;
use tungstenite::{Error, Message, WebSocket, accept_hdr_with_config};

use crate::control::{Command, Viewer};
use crate::event::DisconnectReason;
use crate::guests::Guests;
use crate::outbox::{Merit, Outbox};
use crate::protocol::{Subprotocol, parse_bytes, parse_text};

/// Time that a viewer may take for the handshake.
const HANDSHAKE: Duration = Duration::from_secs(5);

/// Time that a viewer may read nothing while there is something to read. Systems buffer a good deal and take
/// it little by little, so that it may be three times as long before it shows.
const STALL: Duration = Duration::from_secs(10);

/// Bytes of the longest message that a viewer may send: subscriptions to thousands of channels.
const MOST_MESSAGE_BYTES: usize = 1 << 18;

/// Requests of a viewer a second, beyond a first burst of as many; who says more waits.
const REQUESTS_PER_S: u32 = 200;

const PROTOCOLS: &str = "Sec-WebSocket-Protocol";

/// Serves one connection until it ends.
pub(crate) fn serve(
    number: u64,
    address: SocketAddr,
    wire: Wire,
    guests: &Guests,
    player: &SyncSender<Command>,
) {
    let (socket, subprotocol) = match greet(wire, guests) {
        Ok(greeted) => greeted,
        Err(why) => {
            let _ = player.send(match why {
                Some(why) => Command::Refused(address, why),
                // It asked for another protocol, or for nothing.
                None => Command::Strange(address),
            });
            return;
        }
    };
    socket.get_ref().outbox.deserves(Merit::Silent);
    let viewer = Viewer {
        number,
        address,
        subprotocol,
        outbox: Arc::clone(&socket.get_ref().outbox),
    };
    let outbox = Arc::clone(&viewer.outbox);
    let how = match (socket.get_ref().socket.try_clone()).and_then(|to| sender(to, &outbox)) {
        Ok(sender) => {
            let how = match player.send(Command::Arrived(viewer)) {
                Ok(()) => listen(number, socket, player),
                // The player has stopped.
                Err(_) => DisconnectReason::Closed,
            };
            match how {
                DisconnectReason::Closed => outbox.finish(),
                _ => outbox.abandon(),
            }
            match sender.join() {
                Ok(Err(stalled)) => stalled,
                _ => how,
            }
        }
        Err(error) => DisconnectReason::Vanished(error.to_string()),
    };
    let _ = player.send(Command::Gone(number, how));
}

/// Agrees on a protocol; otherwise the reason, where it is another than that the client speaks something else.
fn greet(wire: Wire, guests: &Guests) -> Result<(WebSocket<Wire>, Subprotocol), Option<String>> {
    // For clients that do not ask for a WebSocket, such as browsers.
    let mut plain = wire.socket.try_clone().map_err(|_| None)?;
    let mut chosen = None;
    let mut refused = None;
    let config = WebSocketConfig::default()
        .read_buffer_size(16 << 10)
        .max_message_size(Some(MOST_MESSAGE_BYTES))
        .max_frame_size(Some(MOST_MESSAGE_BYTES));
    #[expect(
        clippy::result_large_err,
        reason = "the callback's type is tungstenite's"
    )]
    let answer = |request: &Handshake, mut response: Response| {
        if let Err(why) = guests.check(request.headers()) {
            let text = format!("{why}\n");
            refused = Some(Some(why));
            return Err(refusal(StatusCode::FORBIDDEN, text));
        }
        let offered = (request.headers().get_all(PROTOCOLS).iter())
            .flat_map(|header| header.to_str().unwrap_or_default().split(','));
        chosen = Subprotocol::choose(offered);
        let Some(chosen) = chosen else {
            refused = Some(None);
            return Err(refusal(StatusCode::BAD_REQUEST, REFUSAL.to_owned()));
        };
        (response.headers_mut()).insert(PROTOCOLS, HeaderValue::from_static(chosen.name()));
        Ok(response)
    };
    let accepted = accept_hdr_with_config(wire, answer, Some(config));
    let Ok(mut websocket) = accepted else {
        if refused.is_none() {
            // It may be gone already.
            let _ = plain.write_all(plain_refusal().as_bytes());
        }
        return Err(refused.flatten());
    };
    let wire = websocket.get_mut();
    wire.greeting_until = None;
    wire.socket.set_read_timeout(None).map_err(|_| None)?;
    chosen.map(|chosen| (websocket, chosen)).ok_or(None)
}

const REFUSAL: &str = "This is a recording for Foxglove and Lichtblick: open a Foxglove WebSocket connection.\n\
                       Expected the subprotocol foxglove.websocket.v1 or foxglove.sdk.v1.\n";

/// Tells browsers what this is.
fn plain_refusal() -> String {
    format!(
        "HTTP/1.1 400 Bad Request\r\nContent-Type: text/plain\r\nContent-Length: {}\r\n\
         Connection: close\r\n\r\n{REFUSAL}",
        REFUSAL.len()
    )
}

/// Tells programs why they are not let in.
fn refusal(status: StatusCode, text: String) -> ErrorResponse {
    let mut response = ErrorResponse::new(Some(text));
    *response.status_mut() = status;
    response
}

/// Passes what a viewer says on to the player until it leaves.
fn listen(
    number: u64,
    mut socket: WebSocket<Wire>,
    player: &SyncSender<Command>,
) -> DisconnectReason {
    let (mut from, mut requests) = (Instant::now(), 0);
    loop {
        if requests >= REQUESTS_PER_S {
            thread::sleep(Duration::from_secs(1).saturating_sub(from.elapsed()));
            (from, requests) = (Instant::now(), 0);
        }
        requests += 1;
        let said = match socket.read() {
            Ok(Message::Text(text)) => parse_text(text.as_str()),
            Ok(Message::Binary(bytes)) => parse_bytes(&bytes),
            Ok(_) => continue,
            Err(Error::ConnectionClosed | Error::AlreadyClosed) => return DisconnectReason::Closed,
            Err(Error::Io(error)) => return DisconnectReason::Vanished(error.to_string()),
            Err(error) => return DisconnectReason::Vanished(error.to_string()),
        };
        let command = match said {
            Ok(request) => Command::Asked(number, request),
            Err(why) => Command::Misunderstood(number, why),
        };
        if player.send(command).is_err() {
            return DisconnectReason::Closed;
        }
    }
}

type Sender = thread::JoinHandle<Result<(), DisconnectReason>>;

/// Sends what comes into an outbox until nothing more comes; then the connection ends.
fn sender(mut socket: TcpStream, outbox: &Arc<Outbox>) -> io::Result<Sender> {
    let outbox = Arc::clone(outbox);
    thread::Builder::new()
        .name("viewer's sender".to_owned())
        .spawn(move || {
            let mut bytes = Vec::new();
            let mut ended = Ok(());
            while outbox.take(&mut bytes) {
                if let Err(error) = socket.write_all(&bytes) {
                    outbox.abandon();
                    use io::ErrorKind::{TimedOut, WouldBlock};
                    ended = Err(match error.kind() {
                        TimedOut | WouldBlock => DisconnectReason::Stalled,
                        _ => DisconnectReason::Vanished(error.to_string()),
                    });
                    // Wakes the listening thread.
                    let _ = socket.shutdown(Shutdown::Both);
                    break;
                }
            }
            let _ = socket.shutdown(Shutdown::Write);
            ended
        })
}

/// A socket of which only the handshake writes itself: all else goes through the outbox, so that two
/// threads cannot write into each other's frames.
pub(crate) struct Wire {
    socket: TcpStream,
    outbox: Arc<Outbox>,
    /// Until the handshake is over: when it has to be, however little at a time the client says.
    greeting_until: Option<Instant>,
}

impl Wire {
    pub(crate) fn new(socket: TcpStream, outbox: Arc<Outbox>) -> io::Result<Self> {
        socket.set_nodelay(true)?;
        socket.set_write_timeout(Some(STALL))?;
        Ok(Self {
            socket,
            outbox,
            greeting_until: Some(Instant::now() + HANDSHAKE),
        })
    }
}

impl Read for Wire {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        if let Some(until) = self.greeting_until {
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Err(io::ErrorKind::TimedOut.into());
            }
            self.socket.set_read_timeout(Some(left))?;
        }
        self.socket.read(bytes)
    }
}

impl Write for Wire {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.greeting_until.is_some() {
            self.socket.write(bytes)
        } else {
            // tungstenite gives whole frames, and a vector takes all of them.
            self.outbox.raw(bytes);
            Ok(bytes.len())
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        self.socket.flush()
    }
}
