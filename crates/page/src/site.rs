//! What every request works on.

use crate::folder::Working;
use crate::guard::Guard;
use crate::jobs::Jobs;
use crate::live::Live;
use phisindy::files::Request;
use std::sync::Mutex;

/// What every request works on.
pub(crate) struct Site {
    pub(crate) guard: Guard,
    pub(crate) folder: Working,
    pub(crate) jobs: Jobs,
    /// Where data files and laws are looked for beside the folder.
    pub(crate) request: Request,
    /// Held by what takes much memory: one at a time.
    pub(crate) turn: Mutex<()>,
    /// The file that the page begins with.
    pub(crate) first: Option<String>,
    /// A record that grows.
    pub(crate) live: Option<Live>,
}
