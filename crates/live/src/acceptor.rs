//! Accepts client connections.

use std::collections::BTreeMap;
use std::io;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::SyncSender;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use crate::control::Command;
use crate::error::LiveError;
use crate::viewer::serve;

/// Viewers at the same time; each may have some MiB waiting.
const MOST_VIEWERS: usize = 32;

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
    sockets: Sockets,
    thread: Option<JoinHandle<()>>,
}

/// Sockets of all connections, to end them with.
type Sockets = Arc<Mutex<BTreeMap<u64, TcpStream>>>;

impl Acceptor {
    pub(crate) fn open(
        listener: TcpListener,
        address: SocketAddr,
        player: SyncSender<Command>,
    ) -> Result<Self, LiveError> {
        let (shut, sockets) = (Arc::<AtomicBool>::default(), Sockets::default());
        let thread = thread::Builder::new().name("acceptor".to_owned()).spawn({
            let (shut, sockets) = (Arc::clone(&shut), Arc::clone(&sockets));
            move || accept_all(&listener, &shut, &sockets, &player)
        });
        Ok(Self {
            address,
            shut,
            sockets,
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
        for socket in lock(&self.sockets).values() {
            let _ = socket.shutdown(Shutdown::Both);
        }
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

fn accept_all(
    listener: &TcpListener,
    shut: &AtomicBool,
    sockets: &Sockets,
    player: &SyncSender<Command>,
) {
    let mut threads: Vec<JoinHandle<()>> = Vec::new();
    for number in 0.. {
        let arrived = listener.accept();
        if shut.load(Ordering::SeqCst) {
            break;
        }
        threads.retain(|thread| !thread.is_finished());
        match arrived {
            Ok((_, address)) if threads.len() >= MOST_VIEWERS => {
                let _ = player.send(Command::Full(address, MOST_VIEWERS));
            }
            Ok((socket, address)) => {
                threads.extend(connection(number, address, socket, sockets, player));
            }
            Err(_) => thread::sleep(REST),
        }
    }
    for socket in lock(sockets).values() {
        let _ = socket.shutdown(Shutdown::Both);
    }
    for thread in threads {
        let _ = thread.join();
    }
}

/// The thread of a connection; `None`, and the connection ends, where the system has none to give.
fn connection(
    number: u64,
    address: SocketAddr,
    socket: TcpStream,
    sockets: &Sockets,
    player: &SyncSender<Command>,
) -> Option<JoinHandle<()>> {
    lock(sockets).insert(number, socket.try_clone().ok()?);
    let thread = thread::Builder::new().name("viewer".to_owned()).spawn({
        let (sockets, player) = (Arc::clone(sockets), player.clone());
        move || {
            serve(number, address, socket, &player);
            lock(&sockets).remove(&number);
        }
    });
    if thread.is_err() {
        lock(sockets).remove(&number);
    }
    thread.ok()
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // Entries come and go in one statement each.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
