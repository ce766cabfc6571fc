//! A bar on standard error for work that takes over a second; nothing in pipes or with `--quiet`.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::time::{Duration, Instant};

const STEPS: u64 = 1000;

/// The progress of one spec.
pub(crate) struct Progress {
    bar: ProgressBar,
    begin: Instant,
    shown: bool,
}

impl Progress {
    /// Not to be seen yet.
    pub(crate) fn new(what: &str, quiet: bool) -> Progress {
        let bar = ProgressBar::with_draw_target(Some(STEPS), ProgressDrawTarget::hidden());
        let style = ProgressStyle::with_template("{msg} {bar:30} {percent:>3} % {eta}");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        bar.set_message(what.to_owned());
        let visible = !quiet && std::io::stderr().is_terminal();
        Progress { bar, begin: Instant::now(), shown: !visible }
    }

    /// Says what is being done.
    pub(crate) fn doing(&mut self, what: &str) {
        self.bar.set_message(what.to_owned());
    }

    /// Draws a fraction of the work.
    pub(crate) fn at(&mut self, fraction: f64) {
        if !self.shown && self.begin.elapsed() > Duration::from_secs(1) {
            self.bar.set_draw_target(ProgressDrawTarget::stderr());
            self.shown = true;
        }
        self.bar.set_position((fraction.clamp(0.0, 1.0) * STEPS as f64) as u64);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
