//! `phisindy open`: a local page to work on.

use crate::args::{OpenArgs, Options};
use crate::interrupt;
use crate::terminal::{INPUT, print, remark};
use anyhow::{Context, Result, bail};
use phisindy::files::Request;
use phisindy_page::Page;
use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use tempfile::NamedTempFile;

/// Serves the page until a signal or a limit ends it, and returns the exit code.
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
    let page = match &args.live {
        Some(source) => page.follow(source.clone())?,
        None => page,
    };
    interrupt::ask_for_work(page.work());
    print(&format!("{}\n", page.url()))?;
    if !options.quiet {
        remark(&format!("the page works in `{shown}`; end it with Ctrl-C, nothing is lost"));
    }
    // In a pipe another program takes the address.
    let wanted = !args.no_open && io::stdout().is_terminal();
    let way = if wanted { way_to(&page.url(), &folder) } else { None };
    let opened = way.as_ref().is_some_and(|way| shown_in_browser(way.path()));
    if wanted && !opened && !options.quiet {
        remark("no browser could be started: open the address above in one");
    }
    let lost = page.serve(&interrupt::reason);
    interrupt::tell();
    if let Some(lost) = lost {
        remark(&lost);
        return Ok(INPUT);
    }
    Ok(interrupt::code())
}

/// The working folder, and the name of the file in it to begin with.
fn place(path: Option<&Path>) -> Result<(PathBuf, Option<String>)> {
    let Some(path) = path else { return Ok((PathBuf::from("."), None)) };
    let data = path.metadata().with_context(|| format!("cannot open `{}`", path.display()))?;
    if data.is_dir() {
        return Ok((path.to_owned(), None));
    }
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let name = path.file_name().unwrap_or_default();
    // A browser asks for it by its name.
    let Some(name) = name.to_str() else {
        bail!(
            "the name of `{}` is not UTF-8 text, and the page cannot ask for it: rename it",
            path.display()
        );
    };
    Ok((folder.to_owned(), Some(name.to_owned())))
}

/// A file that leads a browser to an address, until it is dropped. Only the user can read it, while every user
/// of the machine sees the arguments of a program, and with them the token. It is in the working folder, for
/// some browsers see no temporary files of others.
fn way_to(url: &str, folder: &Path) -> Option<NamedTempFile> {
    let mut way =
        tempfile::Builder::new().prefix("phisindy-open-").suffix(".html").tempfile_in(folder).ok()?;
    let page = format!(
        "<!doctype html><meta charset=\"utf-8\"><meta name=\"referrer\" content=\"no-referrer\">\
         <meta http-equiv=\"refresh\" content=\"0; url={url}\"><title>phisindy</title>\n"
    );
    way.write_all(page.as_bytes()).and_then(|()| way.flush()).ok()?;
    Some(way)
}

/// Programs that open a page in the browser of the user, with the words before it.
const BROWSERS: &[&[&str]] = &[
    #[cfg(target_os = "macos")]
    &["open"],
    #[cfg(windows)]
    &["rundll32", "url.dll,FileProtocolHandler"],
    #[cfg(all(unix, not(target_os = "macos")))]
    &["xdg-open"],
];

/// Whether a browser was started.
fn shown_in_browser(page: &Path) -> bool {
    BROWSERS.iter().any(|words| {
        let mut command = Command::new(words[0]);
        command.args(&words[1..]).arg(page).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        command.spawn().is_ok()
    })
}
