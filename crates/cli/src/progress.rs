//! A line on standard error for work that a terminal waits for, drawn at once and alive until the work ends;
//! nothing in pipes or with `--quiet`.

use crate::interrupt;
use console::Term;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle, TermLike};
use phisindy::Options;
use std::io::{self, IsTerminal};
use std::ops::ControlFlow;
use std::sync::Mutex;
use std::time::Duration;

const STEPS: u64 = 1000;
/// Time between two drawings: the seconds that are shown go on where a step takes long.
const TICK: Duration = Duration::from_millis(120);
/// Most drawings in a second.
const DRAWINGS: u8 = 20;

/// The progress of one piece of work.
pub(crate) struct Progress {
    bar: ProgressBar,
    measured: bool,
}

impl Progress {
    /// Says what is being done, at once.
    pub(crate) fn new(what: &str, quiet: bool) -> Progress {
        let visible = !quiet && !console::is_dumb() && io::stderr().is_terminal();
        let screen = Screen(Term::buffered_stderr());
        let target = if visible {
            ProgressDrawTarget::term_like_with_hz(Box::new(screen), DRAWINGS)
        } else {
            ProgressDrawTarget::hidden()
        };
        let bar = ProgressBar::with_draw_target(Some(STEPS), target);
        // No time left: what comes depends on what is found.
        bar.set_style(style("{spinner} {elapsed} {msg}"));
        bar.set_message(fitted(what));
        if visible {
            bar.tick();
            bar.enable_steady_tick(TICK);
        }
        Progress { bar, measured: false }
    }

    /// Says what is being done.
    pub(crate) fn doing(&mut self, what: &str) {
        self.bar.set_message(fitted(what));
    }

    /// Draws a fraction of the work. It never goes back: a search that begins another round has more to do
    /// than it knew.
    pub(crate) fn at(&mut self, fraction: f64) {
        if !self.measured {
            self.bar.set_style(style("{spinner} {bar:12} {percent:>3} % {elapsed} {msg}"));
            self.measured = true;
        }
        let position = (fraction.clamp(0.0, 1.0) * STEPS as f64) as u64;
        self.bar.set_position(position.max(self.bar.position()));
    }
}

/// Does work of the library under a line of progress, until an early end is requested.
pub(crate) fn watched<R>(what: &str, quiet: bool, work: impl FnOnce(&Options<'_>) -> R) -> R {
    let progress = Mutex::new(Progress::new(what, quiet));
    let observe = |now: phisindy::Progress<'_>| {
        if let Ok(mut progress) = progress.lock() {
            if !now.activity.is_empty() {
                progress.doing(now.activity);
            }
            progress.at(now.fraction);
        }
        if interrupt::requested() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    work(&Options { observe: Some(&observe), ..Options::default() })
}

/// Columns that stay free for the `^C` that a terminal shows: the line is padded to its end, and one that
/// `^C` breaks would stay above the result.
const ECHO: u16 = 2;
/// Room in a line for what stands before the words, and for the echo.
const BESIDE: usize = 34;

/// Standard error without the last columns.
#[derive(Debug)]
struct Screen(Term);

impl TermLike for Screen {
    fn width(&self) -> u16 {
        TermLike::width(&self.0).saturating_sub(ECHO).max(1)
    }
    fn height(&self) -> u16 {
        TermLike::height(&self.0)
    }
    fn move_cursor_up(&self, n: usize) -> io::Result<()> {
        self.0.move_cursor_up(n)
    }
    fn move_cursor_down(&self, n: usize) -> io::Result<()> {
        self.0.move_cursor_down(n)
    }
    fn move_cursor_right(&self, n: usize) -> io::Result<()> {
        self.0.move_cursor_right(n)
    }
    fn move_cursor_left(&self, n: usize) -> io::Result<()> {
        self.0.move_cursor_left(n)
    }
    fn write_line(&self, text: &str) -> io::Result<()> {
        self.0.write_line(text)
    }
    fn write_str(&self, text: &str) -> io::Result<()> {
        self.0.write_str(text)
    }
    fn clear_line(&self) -> io::Result<()> {
        self.0.clear_line()
    }
    fn flush(&self) -> io::Result<()> {
        self.0.flush()
    }
}

/// The words as far as they fit a line.
fn fitted(words: &str) -> String {
    let wide = usize::from(Term::stderr().size().1).saturating_sub(BESIDE);
    console::truncate_str(words, wide.max(10), "…").into_owned()
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
