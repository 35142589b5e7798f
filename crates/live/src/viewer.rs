//! One connection: a thread that listens to a viewer and one that sends to it.

use std::io::{self, Read, Write};
use std::net::{Shutdown, SocketAddr, TcpStream};
use std::sync::Arc;
use std::sync::mpsc::SyncSender;
use std::thread;
use std::time::Duration;

use tungstenite::handshake::server::{ErrorResponse, Request as Handshake, Response};
use tungstenite::http::{HeaderValue, StatusCode};
use tungstenite::protocol::WebSocketConfig;
use tungstenite::{Error, Message, WebSocket, accept_hdr_with_config};

use crate::control::{Command, Viewer};
use crate::event::DisconnectReason;
use crate::outbox::Outbox;
use crate::protocol::{Subprotocol, parse_bytes, parse_text};

/// Time that a viewer may take for the handshake.
const HANDSHAKE: Duration = Duration::from_secs(5);

/// Time that a viewer may read nothing while there is something to read. Systems buffer a good deal and take
/// it little by little, so that it may be three times as long before it shows.
const STALL: Duration = Duration::from_secs(10);

/// Bytes of the longest message that a viewer may send: subscriptions to thousands of channels.
const MOST_MESSAGE_BYTES: usize = 1 << 20;

const PROTOCOLS: &str = "Sec-WebSocket-Protocol";

/// Serves one connection until it ends.
pub(crate) fn serve(
    number: u64,
    address: SocketAddr,
    socket: TcpStream,
    player: &SyncSender<Command>,
) {
    let Some((socket, subprotocol)) = greet(socket) else {
        // The client asked for another protocol and was refused.
        let _ = player.send(Command::Strange(address));
        return;
    };
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

/// Agrees on a protocol.
fn greet(socket: TcpStream) -> Option<(WebSocket<Wire>, Subprotocol)> {
    socket.set_nodelay(true).ok()?;
    socket.set_read_timeout(Some(HANDSHAKE)).ok()?;
    socket.set_write_timeout(Some(STALL)).ok()?;
    // For clients that do not ask for a WebSocket, such as browsers.
    let mut plain = socket.try_clone().ok()?;
    let mut chosen = None;
    let mut refused = false;
    let config = WebSocketConfig::default()
        .read_buffer_size(16 << 10)
        .max_message_size(Some(MOST_MESSAGE_BYTES))
        .max_frame_size(Some(MOST_MESSAGE_BYTES));
    let wire = Wire {
        socket,
        outbox: Arc::default(),
        through_outbox: false,
    };
    #[expect(
        clippy::result_large_err,
        reason = "the callback's type is tungstenite's"
    )]
    let answer = |request: &Handshake, mut response: Response| {
        let offered = (request.headers().get_all(PROTOCOLS).iter())
            .flat_map(|header| header.to_str().unwrap_or_default().split(','));
        chosen = Subprotocol::choose(offered);
        let Some(chosen) = chosen else {
            refused = true;
            return Err(refusal());
        };
        (response.headers_mut()).insert(PROTOCOLS, HeaderValue::from_static(chosen.name()));
        Ok(response)
    };
    let accepted = accept_hdr_with_config(wire, answer, Some(config));
    let Ok(mut websocket) = accepted else {
        if !refused {
            // It may be gone already.
            let _ = plain.write_all(plain_refusal().as_bytes());
        }
        return None;
    };
    websocket.get_ref().socket.set_read_timeout(None).ok()?;
    websocket.get_mut().through_outbox = true;
    chosen.map(|chosen| (websocket, chosen))
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

/// Tells programs that speak something else over a WebSocket what this is.
fn refusal() -> ErrorResponse {
    let mut response = ErrorResponse::new(Some(REFUSAL.to_owned()));
    *response.status_mut() = StatusCode::BAD_REQUEST;
    response
}

/// Passes what a viewer says on to the player until it leaves.
fn listen(
    number: u64,
    mut socket: WebSocket<Wire>,
    player: &SyncSender<Command>,
) -> DisconnectReason {
    loop {
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
struct Wire {
    socket: TcpStream,
    outbox: Arc<Outbox>,
    through_outbox: bool,
}

impl Read for Wire {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        self.socket.read(bytes)
    }
}

impl Write for Wire {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.through_outbox {
            // tungstenite gives whole frames, and a vector takes all of them.
            self.outbox.raw(bytes);
            Ok(bytes.len())
        } else {
            self.socket.write(bytes)
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        self.socket.flush()
    }
}
