//! `report.html`: the result of `run` or `gap` as one page that needs no network, and its figures as files. A
//! small script shows values, zooms and hides lines; without it everything is there.
//!
//! ```text
//! Report, Gap or a failure --> sections (tables, equations, figures) --> Page --> report.html, figures/*.svg
//! ```

mod correlation;
mod force;
pub(crate) mod friction;
mod gap;
mod hero;
mod leaderboard;
mod map;
mod mathml;
mod missing_force;
mod motion;
mod next;
pub(crate) mod page;
mod regimes;
pub(crate) mod reproduction;
mod residual;
mod run;
mod selection;
mod shrink;
pub(crate) mod table;

use crate::format::capital;
use crate::gap::GapReport;
use crate::input::{Input, Invocation};
use crate::run::RunReport;
use crate::seen::{measured, notes};
use next::Mistake;
pub use page::HtmlReport;
use page::{Banner, Page, Tone, add_data_remarks, block};
use phisindy_phys::{Diagnostic, Sources};

/// The report of `run`.
pub fn run(report: &RunReport<'_>, invocation: &Invocation) -> HtmlReport {
    run::page(report, invocation).html()
}

/// The report of `gap`.
pub fn gap(report: &GapReport<'_>, invocation: &Invocation) -> HtmlReport {
    gap::page(report, invocation).html()
}

/// A spec that cannot be used.
pub struct Refused<'a> {
    /// Its name as the user gave it.
    pub spec: &'a str,
    /// Its text as far as it could be read.
    pub text: Option<&'a str>,
    /// What is wrong with it.
    pub errors: Vec<&'a Diagnostic>,
    /// The texts that the errors point into.
    pub sources: &'a Sources,
    /// The errors as a terminal shows them.
    pub drawn: String,
}

/// The report of a wrong spec.
pub fn refusal(refused: &Refused<'_>, invocation: &Invocation) -> HtmlReport {
    let &Refused { spec, text, ref errors, sources, ref drawn } = refused;
    let all: Vec<Mistake<'_>> = errors.iter().map(|e| Mistake::new(e, sources)).collect();
    let said = match &all[..] {
        [] => "the spec or its data cannot be used as they are".to_owned(),
        [one] => one.said(),
        many => format!("{} mistakes in the spec or its data", many.len()),
    };
    let banner = Banner {
        tone: Tone::Bad,
        headline: "Not run".to_owned(),
        text: format!("Nothing was computed: {said}."),
        how: String::new(),
    };
    let title = text.and_then(next::title_of).unwrap_or_else(|| spec.to_owned());
    let mut page = Page::of_refusal(&title, spec, banner);
    next::add(&mut page, &next::repairs(&all, spec));
    page.section("What is wrong", [block(drawn.trim_end(), "mistakes")]);
    page.section("To repeat it", reproduction::command(None, spec, text, invocation));
    page.html()
}

/// The report of work that came to no result: why, and whether a state grew without bound, beside what was
/// measured.
pub fn failure(why: &str, diverged: bool, input: Input<'_>, invocation: &Invocation) -> HtmlReport {
    let banner = Banner {
        tone: Tone::Bad,
        headline: "Failed".to_owned(),
        text: format!("{}.", capital(why)),
        how: String::new(),
    };
    let mut page = Page::new(input, banner);
    let steps: Vec<String> = advice(diverged).map(capital).into_iter().collect();
    next::add(&mut page, &steps);
    let seen = measured(input);
    page.figures("Measured", |sheet| motion::charts(&seen, sheet));
    add_data_remarks(&mut page, input.doubts, &notes(input));
    reproduction::add(&mut page, input, invocation);
    page.html()
}

/// What to do about a state that grew without bound.
pub fn advice(diverged: bool) -> Option<&'static str> {
    diverged.then_some(
        "look at the units of the columns and of the constants that drive it (warnings above may say which), at the signs of stiffness and damping, and at where movable constants start",
    )
}
