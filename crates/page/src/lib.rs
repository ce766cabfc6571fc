//! The local page of `phisindy open`: drop a data file, see and assign its columns, edit the model with its
//! mistakes below the line, run it, watch the gap shrink, read the report.
//!
//! ```text
//! browser --server (connections)--> request --guard (token, Host, Origin)--> routes
//!     routes --+-- columns: a data file, its columns, a spec for it
//!              +-- check:   a spec, its mistakes by line
//!              +-- edit:    a spec as a form and a sketch, one edit of its text at a time (terms)
//!              +-- jobs:    `run` and `gap` on a thread, their progress
//!              +-- live:    a record that grows, judged as it does
//!              +-- results: folders that are finished, their files, exports
//! ```
//!
//! It is a layer over the library `phisindy` and knows no numerics. Everything is a file in one folder: the
//! data, the spec, and each result in `results/NAME`. Nothing outside of that folder is written, and nothing is
//! read but data and laws in folders that were named when it was opened: no request names another one. The
//! server listens on the loopback interface alone, and answers only requests that know the random token of
//! its address.

mod check;
mod columns;
mod edit;
mod folder;
mod guard;
mod jobs;
mod live;
mod reply;
mod request;
mod results;
mod routes;
mod server;
mod site;
mod terms;

use folder::Working;
use guard::Guard;
use jobs::Jobs;
use live::Live;
pub use live::Source;
use phisindy::files::{Request, spec_text};
use phisindy_report::StopReason;
use phisindy_report::spec_text::named_data;
use server::Server;
use site::Site;
use std::io;
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Interval at which the page asks whether to stop.
const TICK: Duration = Duration::from_millis(100);
/// Time that work has to end, and to keep what is finished.
const GRACE: Duration = Duration::from_secs(60);

/// A page that is served.
pub struct Page {
    listener: TcpListener,
    site: Arc<Site>,
    /// The lines of a record that grows, and its file, until somebody reads them.
    growing: Mutex<Option<(live::Stream, live::RecordFile)>>,
}

impl Page {
    /// Listens on a free port of 127.0.0.1, or on `port`. The page works in `folder` and begins with its file
    /// `first`, a spec or a data file; `request` names further folders of data and laws, which are read only, as
    /// are those that the specs name which are in the folder now.
    ///
    /// # Errors
    /// There is no such folder, the port is taken, or the system gives no random numbers.
    pub fn open(folder: &Path, first: Option<&str>, port: u16, request: Request) -> io::Result<Page> {
        let folder = Working::open(folder)?;
        let specs =
            folder.names(&["ron"]).into_iter().filter_map(|name| spec_text(&folder.file(&name).ok()?).ok());
        let mut named: Vec<String> = Vec::new();
        for text in specs {
            named.extend(named_data(&text).into_iter().map(str::to_owned));
        }
        named.sort();
        named.dedup();
        let request = Request { named_data: Some(named), ..request };
        let listener = TcpListener::bind(SocketAddr::from((Ipv4Addr::LOCALHOST, port))).map_err(|why| {
            io::Error::new(why.kind(), format!("cannot listen on port {port} of 127.0.0.1: {why}"))
        })?;
        let site = Site {
            guard: Guard::new(listener.local_addr()?)?,
            folder,
            jobs: Jobs::default(),
            request,
            turn: Mutex::new(()),
            first: first.map(str::to_owned),
            live: None,
        };
        Ok(Page { listener, site: Arc::new(site), growing: Mutex::new(None) })
    }

    /// The page with a record that grows: its lines go into a file of the folder, `live.csv` or a name like it, and
    /// are judged while they come. Where the page begins with a spec, a copy of that which reads the record judges it.
    ///
    /// # Errors
    /// The source cannot be read, or the folder takes no file.
    pub fn follow(mut self, source: Source) -> io::Result<Page> {
        let site =
            Arc::get_mut(&mut self.site).ok_or_else(|| io::Error::other("the page is served already"))?;
        let (live, stream, to) = Live::open(&site.folder, source, site.first.as_deref())?;
        site.first = live.first().or(site.first.take());
        site.live = Some(live);
        self.growing = Mutex::new(Some((stream, to)));
        Ok(self)
    }

    /// The address, with the token.
    pub fn url(&self) -> String {
        self.site.guard.url()
    }

    /// Tells whether `run` or `gap` is under way.
    pub fn work(&self) -> impl Fn() -> bool + Send + Sync + use<> {
        let site = Arc::clone(&self.site);
        move || site.jobs.busy()
    }

    /// Answers requests until `stop` says why to end. Work that is under way is then asked to end, and keeps
    /// what is finished; the page is answered until it has. Returns what of a growing record was lost, in words.
    pub fn serve(&self, stop: &dyn Fn() -> Option<StopReason>) -> Option<String> {
        let server = Server::new(Arc::clone(&self.site));
        std::thread::scope(|threads| {
            threads.spawn(|| server.accept(&self.listener));
            let growing = self.growing.lock().unwrap_or_else(PoisonError::into_inner).take();
            let recorder = growing.map(|(stream, to)| {
                // Nobody waits for a judgement that is under way.
                let site = Arc::clone(&self.site);
                std::thread::spawn(move || {
                    if let Some(live) = &site.live {
                        live.judge(&site.folder, &site.request);
                    }
                });
                threads.spawn(|| self.site.live.as_ref()?.record(&self.site.folder, stream, to))
            });
            let why = loop {
                match stop() {
                    Some(why) => break why,
                    None => std::thread::sleep(TICK),
                }
            };
            self.site.jobs.close(why);
            self.site.live.iter().for_each(Live::close);
            let since = Instant::now();
            while self.site.jobs.busy() && since.elapsed() < GRACE {
                std::thread::sleep(TICK);
            }
            server.close(&self.listener);
            // An upload that is still under way has nobody left to take it.
            self.site.folder.remove_own_parts();
            recorder.and_then(|recorder| recorder.join().unwrap_or(None))
        })
    }

    /// The answer to the bytes of one request, as a connection would get it; empty if these are none.
    pub fn answered(&self, mut request: &[u8]) -> Vec<u8> {
        let mut sent = Vec::new();
        if let Ok(head) = request::Head::read(&mut request) {
            let reply = match self.site.guard.path(&head) {
                Ok(path) => routes::answer(&self.site, &head, path, &mut request),
                Err(refusal) => reply::Reply::wrong(403, refusal.words()),
            };
            // A vector takes everything.
            let _ = reply.send(&mut sent);
        }
        sent
    }
}
