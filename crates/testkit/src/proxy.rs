//! A TCP proxy that forwards, falls silent or cuts its connections, as a test demands.

use std::io::{Read, Write};
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::spawn;

/// Most bytes that are read at once.
const BUFFER: usize = 64 * 1024;

/// A proxy on a port of 127.0.0.1. Dropping it cuts everything.
pub struct Proxy {
    address: SocketAddr,
    state: Arc<State>,
}

struct State {
    /// The address of the server.
    target: SocketAddr,
    way: Mutex<Way>,
    /// The way has changed.
    changed: Condvar,
}

struct Way {
    /// Bytes pass, in both directions.
    is_open: bool,
    is_over: bool,
    /// Both ends of each connection, to cut it.
    connections: Vec<(TcpStream, TcpStream)>,
}

impl Proxy {
    /// Starts one that forwards to a port of 127.0.0.1, on a free port.
    ///
    /// # Panics
    /// When no port is free.
    pub fn start(target: u16) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
        let address = listener.local_addr().expect("its address");
        let way = Way {
            is_open: true,
            is_over: false,
            connections: Vec::new(),
        };
        let state = Arc::new(State {
            target: ([127, 0, 0, 1], target).into(),
            way: Mutex::new(way),
            changed: Condvar::new(),
        });
        let shared = Arc::clone(&state);
        spawn(move || shared.accept(&listener));
        Self { address, state }
    }

    pub fn port(&self) -> u16 {
        self.address.port()
    }

    /// Swallows the way: connections stay, but nothing passes; new ones are answered by nobody. This is a cable
    /// that was pulled: no end learns of it.
    pub fn vanish(&self) {
        self.state.way().is_open = false;
    }

    /// Lets everything pass again, what was held back first.
    pub fn appear(&self) {
        self.state.way().is_open = true;
        self.state.changed.notify_all();
    }

    /// Cuts all connections that there are; new ones are taken.
    pub fn cut(&self) {
        for (client, server) in self.state.way().connections.drain(..) {
            let _ = client.shutdown(Shutdown::Both);
            let _ = server.shutdown(Shutdown::Both);
        }
        self.state.changed.notify_all();
    }
}

impl Drop for Proxy {
    fn drop(&mut self) {
        self.state.way().is_over = true;
        self.cut();
        // Wakes the thread that waits for connections.
        let _ = TcpStream::connect(self.address);
    }
}

impl State {
    fn way(&self) -> MutexGuard<'_, Way> {
        self.way.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits until bytes may pass. False when the proxy is over.
    fn passes(&self) -> bool {
        let waits = |way: &mut Way| !way.is_open && !way.is_over;
        let way = self.changed.wait_while(self.way(), waits);
        !way.unwrap_or_else(PoisonError::into_inner).is_over
    }

    fn accept(self: &Arc<Self>, listener: &TcpListener) {
        while let Ok((client, _)) = listener.accept() {
            if !self.passes() {
                return;
            }
            // A server that is down looks as it does without a proxy: the connection ends.
            let Ok(server) = TcpStream::connect(self.target) else {
                continue;
            };
            let _ = client.set_nodelay(true);
            let _ = server.set_nodelay(true);
            let ends = [&client, &client, &server, &server].map(TcpStream::try_clone);
            let [Ok(client_in), Ok(client_out), Ok(server_in), Ok(server_out)] = ends else {
                continue;
            };
            self.way().connections.push((client, server));
            for (from, to) in [(client_in, server_out), (server_in, client_out)] {
                let shared = Arc::clone(self);
                spawn(move || shared.forward(from, to));
            }
        }
    }

    fn forward(&self, mut from: TcpStream, mut to: TcpStream) {
        let mut buffer = vec![0; BUFFER];
        while let Ok(length @ 1..) = from.read(&mut buffer) {
            if !self.passes() || to.write_all(&buffer[..length]).is_err() {
                break;
            }
        }
        // The end of a connection passes as late as what was sent on it.
        self.passes();
        let _ = from.shutdown(Shutdown::Read);
        let _ = to.shutdown(Shutdown::Write);
        let is_closed = |end: &TcpStream| end.peer_addr().is_err();
        self.way()
            .connections
            .retain(|(client, server)| !is_closed(client) && !is_closed(server));
    }
}
