//! Accepts client connections.

use std::collections::BTreeMap;
use std::io;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::SyncSender;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use crate::control::Command;
use crate::error::LiveError;
use crate::guests::Guests;
use crate::outbox::{Merit, Outbox, Together};
use crate::viewer::{Wire, serve};

/// Connections at the same time. Where there are as many, one that wants or reads nothing has to go for a new one.
const MOST_VIEWERS: usize = 256;

/// Threads of connections, those that are ending included.
const MOST_THREADS: usize = 2 * MOST_VIEWERS;

/// Time in which a client may finish its handshake and say what it wants before it has to go for others.
const GRACE: Duration = Duration::from_millis(250);

/// Pause of accepting where the system has no more sockets.
const REST: Duration = Duration::from_millis(100);

/// Listens at an address.
pub(crate) fn bind(host: &str, port: u16) -> Result<TcpListener, LiveError> {
    TcpListener::bind((host, port)).map_err(|source| {
        let host = host.to_owned();
        match source.kind() {
            io::ErrorKind::AddrInUse => LiveError::PortInUse { host, port },
            _ => LiveError::Bind { host, port, source },
        }
    })
}

/// The thread that accepts connections.
pub(crate) struct Acceptor {
    address: SocketAddr,
    shut: Arc<AtomicBool>,
    connections: Connections,
    thread: Option<JoinHandle<()>>,
}

/// What ends a connection, and says which is to end first.
struct Connection {
    socket: TcpStream,
    address: SocketAddr,
    since: Instant,
    outbox: Arc<Outbox>,
}

type Connections = Arc<Mutex<BTreeMap<u64, Connection>>>;

impl Acceptor {
    pub(crate) fn open(
        listener: TcpListener,
        address: SocketAddr,
        guests: Guests,
        player: SyncSender<Command>,
    ) -> Result<Self, LiveError> {
        let (shut, connections) = (Arc::<AtomicBool>::default(), Connections::default());
        let reception = Reception {
            connections: Arc::clone(&connections),
            together: Together::default(),
            guests: Arc::new(guests),
            player,
        };
        let thread = thread::Builder::new().name("acceptor".to_owned()).spawn({
            let shut = Arc::clone(&shut);
            move || reception.accept_all(&listener, &shut)
        });
        Ok(Self {
            address,
            shut,
            connections,
            thread: Some(thread.map_err(|source| LiveError::Thread { source })?),
        })
    }
}

impl Drop for Acceptor {
    /// Ends all connections that are left, and all threads.
    fn drop(&mut self) {
        let Some(thread) = self.thread.take() else {
            return;
        };
        self.shut.store(true, Ordering::SeqCst);
        end_all(&self.connections);
        // The thread waits for a connection; this one wakes it.
        let wake = TcpStream::connect_timeout(&reachable(self.address), Duration::from_secs(1));
        if wake.is_ok() {
            let _ = thread.join();
        }
    }
}

/// An address for all interfaces of this computer cannot be connected to everywhere.
fn reachable(mut address: SocketAddr) -> SocketAddr {
    match address.ip() {
        IpAddr::V4(ip) if ip.is_unspecified() => address.set_ip(Ipv4Addr::LOCALHOST.into()),
        IpAddr::V6(ip) if ip.is_unspecified() => address.set_ip(Ipv6Addr::LOCALHOST.into()),
        _ => {}
    }
    address
}

/// What every new connection gets.
struct Reception {
    connections: Connections,
    together: Together,
    guests: Arc<Guests>,
    player: SyncSender<Command>,
}

impl Reception {
    fn accept_all(&self, listener: &TcpListener, shut: &AtomicBool) {
        let mut threads: Vec<JoinHandle<()>> = Vec::new();
        for number in 0.. {
            let arrived = listener.accept();
            if shut.load(Ordering::SeqCst) {
                break;
            }
            threads.retain(|thread| !thread.is_finished());
            match arrived {
                Ok((socket, address)) if threads.len() < MOST_THREADS && self.make_room() => {
                    threads.extend(self.connection(number, address, socket));
                }
                Ok((_, address)) => {
                    let _ = self.player.send(Command::Full(address, MOST_VIEWERS));
                }
                Err(_) => thread::sleep(REST),
            }
        }
        end_all(&self.connections);
        for thread in threads {
            let _ = thread.join();
        }
    }

    /// Whether there is room for one more, if need be after the end of a connection that deserves it least.
    fn make_room(&self) -> bool {
        let mut connections = lock(&self.connections);
        if connections.len() < MOST_VIEWERS {
            return true;
        }
        let ranked = connections.iter().map(|(&number, connection)| {
            let merit = connection.outbox.merit();
            (merit, connection.since, number)
        });
        let least = ranked
            .filter(|(merit, since, _)| *merit < Merit::Reading && since.elapsed() > GRACE)
            .min();
        let Some(connection) = least.and_then(|(.., number)| connections.remove(&number)) else {
            return false;
        };
        drop(connections);
        let _ = connection.socket.shutdown(Shutdown::Both);
        let _ = self.player.send(Command::PutOut(connection.address));
        true
    }

    /// The thread of a connection; `None`, and the connection ends, where the system has none to give.
    fn connection(
        &self,
        number: u64,
        address: SocketAddr,
        socket: TcpStream,
    ) -> Option<JoinHandle<()>> {
        let outbox = Arc::new(Outbox::new(Arc::clone(&self.together)));
        let connection = Connection {
            socket: socket.try_clone().ok()?,
            address,
            since: Instant::now(),
            outbox: Arc::clone(&outbox),
        };
        let wire = Wire::new(socket, outbox).ok()?;
        lock(&self.connections).insert(number, connection);
        let thread = thread::Builder::new().name("viewer".to_owned()).spawn({
            let (connections, player) = (Arc::clone(&self.connections), self.player.clone());
            let guests = Arc::clone(&self.guests);
            move || {
                serve(number, address, wire, &guests, &player);
                lock(&connections).remove(&number);
            }
        });
        if thread.is_err() {
            lock(&self.connections).remove(&number);
        }
        thread.ok()
    }
}

fn end_all(connections: &Connections) {
    for connection in lock(connections).values() {
        let _ = connection.socket.shutdown(Shutdown::Both);
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // Entries come and go in one statement each.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
