//! `phisindy open`: a local page to work on.

use crate::args::{OpenArgs, Options};
use crate::interrupt;
use crate::terminal::{print, remark};
use anyhow::{Context, Result};
use phisindy::files::Request;
use phisindy_page::Page;
use std::io::{self, IsTerminal};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Serves the page until Ctrl-C, and returns the exit code.
///
/// # Errors
/// There is no such file or folder, or the port is taken.
pub(crate) fn open(args: &OpenArgs, options: &Options) -> Result<u8> {
    let (folder, first) = place(args.path.as_deref())?;
    let folder = folder.canonicalize().with_context(|| format!("cannot open `{}`", folder.display()))?;
    let shown = folder.display();
    // The page edits the spec itself: values of --set would not be seen there.
    let request = Request { assignments: vec![], seed: None, ..options.request() };
    let page = Page::open(&folder, first.as_deref(), args.port, request)
        .with_context(|| format!("cannot work in `{shown}`"))?;
    print(&format!("{}\n", page.url()))?;
    if !options.quiet {
        remark(&format!("the page works in `{shown}`; end it with Ctrl-C, nothing is lost"));
    }
    // In a pipe another program takes the address.
    if !args.no_open && io::stdout().is_terminal() && !shown_in_browser(&page.url()) && !options.quiet {
        remark("no browser could be started: open the address above in one");
    }
    page.serve(&interrupt::requested).context("the page has ended")?;
    Ok(0)
}

/// The working folder, and the name of the file in it to begin with.
fn place(path: Option<&Path>) -> Result<(PathBuf, Option<String>)> {
    let Some(path) = path else { return Ok((PathBuf::from("."), None)) };
    let data = path.metadata().with_context(|| format!("cannot open `{}`", path.display()))?;
    if data.is_dir() {
        return Ok((path.to_owned(), None));
    }
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let name = path.file_name().map(|n| n.to_string_lossy().into_owned());
    Ok((folder.to_owned(), name))
}

/// Programs that open an address in the browser of the user, with the words before it.
const BROWSERS: &[&[&str]] = &[
    #[cfg(target_os = "macos")]
    &["open"],
    #[cfg(windows)]
    &["rundll32", "url.dll,FileProtocolHandler"],
    #[cfg(all(unix, not(target_os = "macos")))]
    &["xdg-open"],
];

/// Whether a browser was started.
fn shown_in_browser(url: &str) -> bool {
    BROWSERS.iter().any(|words| {
        let mut command = Command::new(words[0]);
        command.args(&words[1..]).arg(url).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        command.spawn().is_ok()
    })
}
