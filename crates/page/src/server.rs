//! Connections: how many, how long, and what becomes of those that say nothing.
//!
//! Each connection has a thread and carries one request. One that has not shown the token yet is a stranger;
//! of these the oldest makes room for a new one, so that no number of them keeps the page from its owner.

use crate::reply::Reply;
use crate::request::{Head, NoRequest};
use crate::routes;
use crate::site::Site;
use std::collections::VecDeque;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Most connections that have not shown the token.
const STRANGERS: usize = 64;
/// Most requests of the page that are answered at once.
const GUESTS: usize = 32;
/// Most threads: those whose connection was closed take a moment to end.
const THREADS: usize = 128;
/// Time for a head, and for each piece of a body or an answer.
const HEAD: Duration = Duration::from_secs(5);
const PIECE: Duration = Duration::from_secs(10);
/// Least rate of a body (bytes per second).
const SLOWEST: u64 = 1 << 18;
/// Time and bytes that are spent on what is sent after the answer, which would destroy the answer if it were
/// not read.
const AFTER: Duration = Duration::from_secs(1);
const MOST_AFTER: usize = 1 << 20;
/// Time between two tries when the system gives no connection or no thread.
const PAUSE: Duration = Duration::from_millis(20);

/// The connections of a server.
pub(crate) struct Server {
    site: Arc<Site>,
    strangers: Mutex<VecDeque<(u64, TcpStream)>>,
    guests: AtomicUsize,
    threads: AtomicUsize,
    next: AtomicU64,
    closed: AtomicBool,
}

impl Server {
    pub(crate) fn new(site: Arc<Site>) -> Arc<Server> {
        Arc::new(Server {
            site,
            strangers: Mutex::default(),
            guests: AtomicUsize::new(0),
            threads: AtomicUsize::new(0),
            next: AtomicU64::new(0),
            closed: AtomicBool::new(false),
        })
    }

    /// Takes connections until [`Server::close`]. What the system refuses (a connection that has gone, no more
    /// files) ends one connection, not the server.
    pub(crate) fn accept(self: &Arc<Server>, listener: &TcpListener) {
        while !self.closed.load(Ordering::SeqCst) {
            match listener.accept() {
                Ok((stream, _)) => self.take(stream),
                Err(_) => thread::sleep(PAUSE),
            }
        }
    }

    /// Takes no more connections, and gives those that are answered a moment.
    pub(crate) fn close(&self, listener: &TcpListener) {
        self.closed.store(true, Ordering::SeqCst);
        // The thread that waits for a connection gets one.
        let woken = listener.local_addr().and_then(|own| TcpStream::connect_timeout(&own, PIECE));
        let since = Instant::now();
        while self.guests.load(Ordering::SeqCst) > 0 && since.elapsed() < AFTER {
            thread::sleep(PAUSE);
        }
        drop(woken);
    }

    fn take(self: &Arc<Server>, stream: TcpStream) {
        let id = self.next.fetch_add(1, Ordering::SeqCst);
        let Ok(other) = stream.try_clone() else { return thread::sleep(PAUSE) };
        {
            let mut strangers = self.strangers();
            if strangers.len() >= STRANGERS
                && let Some((_, oldest)) = strangers.pop_front()
            {
                let _ = oldest.shutdown(Shutdown::Both);
            }
            strangers.push_back((id, other));
        }
        while self.threads.load(Ordering::SeqCst) >= THREADS {
            thread::sleep(Duration::from_millis(1));
        }
        let thread = Counted::new(self, |server| &server.threads);
        let work = move || {
            let server = &thread.server;
            server.serve(id, &stream);
            server.known(id);
            let _ = stream.shutdown(Shutdown::Both);
        };
        if thread::Builder::new().name("request".to_owned()).spawn(work).is_err() {
            self.known(id);
            thread::sleep(PAUSE);
        }
    }

    /// Reads a request and answers it.
    fn serve(self: &Arc<Server>, id: u64, stream: &TcpStream) {
        let mut timed = Timed { stream, until: Instant::now() + HEAD };
        let head = match Head::read(&mut timed) {
            Ok(head) => head,
            Err(NoRequest::Gone) => return,
            Err(NoRequest::TooLarge) => return timed.end(&Reply::wrong(431, "this request is too long")),
            Err(NoRequest::Malformed) => return timed.end(&Reply::wrong(400, "this is no request of HTTP")),
        };
        let path = match self.site.guard.path(&head) {
            Ok(path) => path,
            Err(refusal) => return timed.end(&Reply::wrong(403, refusal.words())),
        };
        self.known(id);
        let guest = Counted::new(self, |server| &server.guests);
        if self.guests.load(Ordering::SeqCst) > GUESTS {
            drop(guest);
            return timed.end(&Reply::wrong(503, "there are too many requests at once: try again"));
        }
        timed.until =
            Instant::now() + PIECE + Duration::from_secs(head.length().unwrap_or(0).min(1 << 40) / SLOWEST);
        if head.header("expect").is_some() {
            let _ = timed.write_all(b"HTTP/1.1 100 Continue\r\n\r\n");
        }
        let answered = catch_unwind(AssertUnwindSafe(|| routes::answer(&self.site, &head, path, &mut timed)));
        let reply =
            answered.unwrap_or_else(|_| Reply::wrong(500, "the program failed at this: please report it"));
        timed.end(&reply);
    }

    /// This connection is no stranger any more.
    fn known(&self, id: u64) {
        self.strangers().retain(|(other, _)| *other != id);
    }

    fn strangers(&self) -> MutexGuard<'_, VecDeque<(u64, TcpStream)>> {
        self.strangers.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// One of a number that is limited, as long as it lives.
struct Counted {
    server: Arc<Server>,
    which: fn(&Server) -> &AtomicUsize,
}

impl Counted {
    fn new(server: &Arc<Server>, which: fn(&Server) -> &AtomicUsize) -> Counted {
        which(server).fetch_add(1, Ordering::SeqCst);
        Counted { server: Arc::clone(server), which }
    }
}

impl Drop for Counted {
    fn drop(&mut self) {
        (self.which)(&self.server).fetch_sub(1, Ordering::SeqCst);
    }
}

/// A connection on which nothing waits for long.
struct Timed<'a> {
    stream: &'a TcpStream,
    /// When reading has to be done.
    until: Instant,
}

impl Timed<'_> {
    /// Sends the last answer; nobody is left to tell if the browser has gone.
    fn end(&mut self, reply: &Reply) {
        self.until = Instant::now() + AFTER;
        if reply.send(self).is_err() || self.stream.shutdown(Shutdown::Write).is_err() {
            return;
        }
        self.until = Instant::now() + AFTER;
        let (mut rest, mut piece) = (MOST_AFTER, [0; 4096]);
        while rest > 0 {
            match self.read(&mut piece) {
                Ok(n) if n > 0 => rest = rest.saturating_sub(n),
                _ => return,
            }
        }
    }
}

impl Read for Timed<'_> {
    fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
        let left = self.until.saturating_duration_since(Instant::now()).min(PIECE);
        if left.is_zero() {
            return Err(io::Error::new(ErrorKind::TimedOut, "it came too slowly"));
        }
        self.stream.set_read_timeout(Some(left))?;
        self.stream.read(to).map_err(|why| match why.kind() {
            // What a system says of a time that is over.
            ErrorKind::WouldBlock | ErrorKind::TimedOut => {
                io::Error::new(ErrorKind::TimedOut, "it came too slowly")
            }
            _ => why,
        })
    }
}

impl Write for Timed<'_> {
    fn write(&mut self, from: &[u8]) -> io::Result<usize> {
        self.stream.set_write_timeout(Some(PIECE))?;
        self.stream.write(from)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.stream.flush()
    }
}
