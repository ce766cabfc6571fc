//! The folder of a result: every file of `--out` by its path in the folder, and its text.

use crate::format::capital;
use crate::gap::GapReport;
use crate::html::{self, HtmlReport};
use crate::input::{Ending, Invocation};
use crate::run::RunReport;
use crate::spec_text::{COMPLETED, IDENTIFIED, completed, identified};
use crate::{CompareReport, Format, Input};
use phisindy_gap::DISCOVERED;
use phisindy_learn::Identified;

/// Names of the files of all results.
const FILES: [&str; 10] =
    [RESULT, EQUATION, GAP, IDENTIFIED, COMPLETED, REPORT, SPEC, PROVENANCE, DRIVE, MOTION];
/// The numbers of a result.
pub const RESULT: &str = "result.json";
/// The spec that a result was made from.
pub const SPEC: &str = "spec.ron";
/// What else a result was made from.
pub const PROVENANCE: &str = "provenance.json";
const EQUATION: &str = "equation.tex";
const GAP: &str = "gap.txt";
/// The inputs of the next run.
pub(crate) const DRIVE: &str = "drive.csv";
/// What models predict of it.
pub(crate) const MOTION: &str = "motion.csv";
const REPORT: &str = "report.html";
const FIGURES: &str = "figures";
const LAWS: &str = "laws";

/// The files of a result.
#[derive(Clone, Debug, Default)]
pub struct Folder {
    /// Path in the folder, with `/` between its parts, and text.
    pub files: Vec<(String, String)>,
    /// What could not be written, and why.
    pub lacks: Option<String>,
}

impl Folder {
    /// A report alone: of a spec that cannot be used, or of work that came to no result.
    pub fn of_page(report: HtmlReport) -> Folder {
        let mut all = Folder::default();
        all.add_report(report);
        all
    }

    /// Whether a result may have a file of this path.
    pub fn may_hold(path: &str) -> bool {
        match path.split_once('/') {
            None => FILES.contains(&path),
            Some((FIGURES, name)) => name.ends_with(".svg"),
            Some((LAWS, name)) => name.starts_with(DISCOVERED) && name.ends_with(".ron"),
            Some(_) => false,
        }
    }

    /// Whether a result may have a folder of this name.
    pub fn may_hold_folder(name: &str) -> bool {
        [FIGURES, LAWS].contains(&name)
    }

    /// What `run` keeps.
    pub fn of_run(report: &RunReport<'_>, input: Input<'_>, found: &Identified, how: &Invocation) -> Folder {
        let mut all = Folder::default();
        all.add(RESULT, report.written(Format::Json));
        all.add(EQUATION, report.written(Format::Latex));
        match identified(input, found) {
            Ok(text) => all.add(IDENTIFIED, text),
            Err(why) => all.lacks = Some(format!("{IDENTIFIED} cannot be written: {why}")),
        }
        all.add_report(html::run(report, how));
        all.mark(&report.ending);
        all
    }

    /// What `gap` keeps.
    pub fn of_gap(report: &GapReport<'_>, how: &Invocation) -> Folder {
        let mut all = Folder::default();
        all.add(RESULT, report.json_lines());
        all.add(GAP, report.text_with_remarks());
        let (text, lacks) = completed(report);
        all.lacks = lacks.map(|why| format!("{COMPLETED} has no start states and sensors: {why}"));
        all.add(COMPLETED, text);
        let found = report.gap.steps.iter().filter(|s| s.effect.entry.id == DISCOVERED);
        for (k, step) in found.enumerate() {
            all.add(&format!("{LAWS}/{DISCOVERED}-{}.ron", k + 1), step.effect.entry.text.clone());
        }
        all.add_report(html::gap(report, how));
        all.mark(&report.ending);
        all
    }

    /// Adds a file by its path in the folder.
    pub fn add(&mut self, name: &str, text: String) {
        self.files.push((name.to_owned(), text));
    }

    /// What `compare` keeps.
    pub fn of_comparison(report: &CompareReport, arguments: &[String]) -> Folder {
        let mut all = Folder::default();
        all.add(RESULT, report.json_lines());
        all.add_report(report.html(arguments));
        all
    }

    pub(crate) fn add_report(&mut self, report: HtmlReport) {
        self.files.extend(report.figures.into_iter().map(|(name, svg)| (format!("{FIGURES}/{name}"), svg)));
        self.add(REPORT, report.page);
    }

    /// Says in every file that the work was stopped, where the file does not say it by itself.
    fn mark(&mut self, ending: &Ending) {
        let Some(stopped) = ending.stopped_words() else { return };
        let words = format!("{} before the end: what was found so far.", capital(&stopped));
        for (name, text) in &mut self.files {
            if name.ends_with(".svg") {
                text.push_str(&format!("<!-- {words} -->\n"));
            } else if name.ends_with(".ron") {
                // The first line of a spec says what it is.
                let first = text.find('\n').filter(|_| text.starts_with("//")).map_or(0, |at| at + 1);
                text.insert_str(first, &format!("// {words}\n"));
            }
        }
    }
}
