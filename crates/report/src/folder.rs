//! The folder of a result: every file of `--out` by its path in the folder, and its text.

use crate::gap::GapReport;
use crate::html::{self, HtmlReport};
use crate::input::Invocation;
use crate::run::RunReport;
use crate::spec_text::{COMPLETED, IDENTIFIED, completed, identified};
use crate::{Format, Input};
use phisindy_gap::DISCOVERED;
use phisindy_learn::Identified;

/// The files of a result.
#[derive(Clone, Debug, Default)]
pub struct Folder {
    /// Path in the folder, with `/` between its parts, and text. The report comes last.
    pub files: Vec<(String, String)>,
    /// What could not be written, and why.
    pub lacks: Option<String>,
}

impl Folder {
    /// What `run` keeps.
    pub fn of_run(report: &RunReport<'_>, input: Input<'_>, found: &Identified, how: &Invocation) -> Folder {
        let mut all = Folder::default();
        all.add("result.json", report.written(Format::Json));
        all.add("equation.tex", report.written(Format::Latex));
        match identified(input, found) {
            Ok(text) => all.add(IDENTIFIED, text),
            Err(why) => all.lacks = Some(format!("{IDENTIFIED} cannot be written: {why}")),
        }
        all.add_report(html::run(report, how));
        all
    }

    /// What `gap` keeps.
    pub fn of_gap(report: &GapReport<'_>, how: &Invocation) -> Folder {
        let mut all = Folder::default();
        all.add("result.json", report.json_lines());
        all.add("gap.txt", report.text_with_remarks());
        let (text, lacks) = completed(report);
        all.lacks = lacks.map(|why| format!("{COMPLETED} has no start states and sensors: {why}"));
        all.add(COMPLETED, text);
        let found = report.gap.steps.iter().filter(|s| s.effect.entry.id == DISCOVERED);
        for (k, step) in found.enumerate() {
            all.add(&format!("laws/{DISCOVERED}-{}.ron", k + 1), step.effect.entry.text.clone());
        }
        all.add_report(html::gap(report, how));
        all
    }

    fn add(&mut self, name: &str, text: String) {
        self.files.push((name.to_owned(), text));
    }

    fn add_report(&mut self, report: HtmlReport) {
        self.files.extend(report.figures.into_iter().map(|(name, svg)| (format!("figures/{name}"), svg)));
        self.add("report.html", report.page);
    }
}
