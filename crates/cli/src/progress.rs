//! A line on standard error for work that a terminal waits for, drawn at once and alive until the work ends;
//! nothing in pipes or with `--quiet`.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::time::Duration;

const STEPS: u64 = 1000;
/// Time between two drawings: the seconds that are shown go on where a step takes long.
const TICK: Duration = Duration::from_millis(120);

/// The progress of one piece of work.
pub(crate) struct Progress {
    bar: ProgressBar,
    measured: bool,
}

impl Progress {
    /// Says what is being done, at once.
    pub(crate) fn new(what: &str, quiet: bool) -> Progress {
        let visible = !quiet && std::io::stderr().is_terminal();
        let target = if visible { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let bar = ProgressBar::with_draw_target(Some(STEPS), target);
        // No time left: what comes depends on what is found.
        bar.set_style(style("{spinner} {wide_msg} {elapsed}"));
        bar.set_message(what.to_owned());
        if visible {
            bar.tick();
            bar.enable_steady_tick(TICK);
        }
        Progress { bar, measured: false }
    }

    /// Says what is being done.
    pub(crate) fn doing(&mut self, what: &str) {
        self.bar.set_message(what.to_owned());
    }

    /// Draws a fraction of the work. It never goes back: a search that begins another round has more to do
    /// than it knew.
    pub(crate) fn at(&mut self, fraction: f64) {
        if !self.measured {
            self.bar.set_style(style("{spinner} {bar:12} {percent:>3} % {elapsed} {wide_msg}"));
            self.measured = true;
        }
        let position = (fraction.clamp(0.0, 1.0) * STEPS as f64) as u64;
        self.bar.set_position(position.max(self.bar.position()));
    }
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
