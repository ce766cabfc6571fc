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

/// Room in a line for what stands before the words, and behind them for the `^C` of a terminal: a line that it
/// breaks is not drawn over.
const BESIDE: usize = 34;

/// The words as far as they fit a line.
fn fitted(words: &str) -> String {
    let wide = usize::from(console::Term::stderr().size().1).saturating_sub(BESIDE);
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
