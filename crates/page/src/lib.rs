//! The local page of `phisindy open`: drop a data file, see and assign its columns, edit the model with its
//! mistakes below the line, run it, watch the gap shrink, read the report.
//!
//! ```text
//! browser --guard (token, Host, Origin)--> routes --+-- columns: a data file, its columns, a spec for it
//!                                                   +-- check:   a spec, its mistakes by line
//!                                                   +-- jobs:    `run` and `gap` on a thread, their progress
//!                                                   +-- results: folders that are finished, their files, exports
//! ```
//!
//! It is a layer over the library `phisindy` and knows no numerics. Everything is a file in one folder: the
//! data, the spec, and each result in `results/NAME`. Nothing outside of that folder is read or written. The
//! server listens on the loopback interface alone, and answers only requests that know the random token of
//! its address.

mod check;
mod columns;
mod folder;
mod guard;
mod jobs;
mod reply;
mod results;
mod routes;
mod site;

use folder::Working;
use guard::Guard;
use jobs::Jobs;
use phisindy::files::Request;
use site::Site;
use std::io;
use std::net::{Ipv4Addr, SocketAddr};
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};
use tiny_http::Server;

/// Interval at which the server asks whether to stop.
const TICK: Duration = Duration::from_millis(100);
/// Time that work has to end, and to keep what is finished.
const GRACE: Duration = Duration::from_secs(10);

/// A page that is served.
pub struct Page {
    server: Server,
    site: Arc<Site>,
}

impl Page {
    /// Listens on a free port of 127.0.0.1, or on `port`. The page works in `folder` and begins with its file
    /// `first`, a spec or a data file; `request` names further folders of data and laws, which are read only.
    ///
    /// # Errors
    /// The folder cannot be written, the port is taken, or the system gives no random numbers.
    pub fn open(folder: &Path, first: Option<&str>, port: u16, request: Request) -> io::Result<Page> {
        let folder = Working::open(folder)?;
        let server = Server::http(SocketAddr::from((Ipv4Addr::LOCALHOST, port)))
            .map_err(|why| io::Error::other(format!("cannot listen on port {port} of 127.0.0.1: {why}")))?;
        let address = server.server_addr().to_ip().ok_or_else(|| io::Error::other("there is no address"))?;
        let site = Site {
            guard: Guard::new(address)?,
            folder,
            jobs: Jobs::default(),
            request,
            first: first.map(str::to_owned),
        };
        Ok(Page { server, site: Arc::new(site) })
    }

    /// The address, with the token.
    pub fn url(&self) -> String {
        self.site.guard.url()
    }

    /// Answers requests until `stop` says so. Work that is under way is then asked to end, and keeps what is
    /// finished.
    ///
    /// # Errors
    /// The system takes the port away.
    pub fn serve(&self, stop: &dyn Fn() -> bool) -> io::Result<()> {
        while !stop() {
            if let Some(request) = self.server.recv_timeout(TICK)? {
                let site = Arc::clone(&self.site);
                // Each request has a thread: events are sent for as long as the page is open.
                std::thread::Builder::new()
                    .name("request".to_owned())
                    .spawn(move || routes::answer(&site, request))?;
            }
        }
        self.site.jobs.stop();
        let since = Instant::now();
        while self.site.jobs.busy() && since.elapsed() < GRACE {
            std::thread::sleep(TICK);
        }
        Ok(())
    }
}
