//! The next run as a page: its drive, and what each model predicts of it.

use super::{NextReport, text};
use crate::chart::{Axis, Chart, Mark, Panel, Place, Sheet, Swatch, legend};
use crate::format::capital;
use crate::html::page::{Banner, Captioned, Page, Tone, block};
use crate::html::reproduction::command;
use crate::input::Invocation;
use phisindy_compare::HALF_WIDTH_95;

/// Height of a panel, and between panels.
const HEIGHT: f64 = 150.0;
const BETWEEN: f64 = 56.0;
/// More points than this are not seen in a line.
const POINTS: usize = 2000;

pub(super) fn page(report: &NextReport, arguments: &[String]) -> Page {
    let text = capital(&report.sentence()) + ".";
    let banner = Banner { tone: Tone::Open, headline: "Measure next".to_owned(), text, how: String::new() };
    let mut page = Page::of_refusal(&report.name, "next", banner);
    page.figures("The best run", |sheet| vec![motions(report, sheet)]);
    let lines = text::lines(report).join("\n");
    page.section("The runs", [block(&lines, "runs")]);
    let how = Invocation { arguments: arguments.to_vec(), ..Invocation::default() };
    page.section("To repeat it", command(None, "", None, &how));
    page
}

/// The inputs above, the measured columns below: each model with a band of 95 %.
fn motions(report: &NextReport, sheet: Sheet) -> Captioned {
    let trial = &report.design.runs[0].trial;
    let every = trial.samples.div_ceil(POINTS);
    let times: Vec<f64> = (0..trial.samples).step_by(every).map(|i| trial.step * i as f64).collect();
    let lines = [("model", "band"), ("before", "repeats"), ("truth", "unfitted")];
    let class = |k: usize| lines[k.min(lines.len() - 1)];
    let entries: Vec<_> = report
        .rivals
        .iter()
        .take(report.predicted.len())
        .enumerate()
        .map(|(k, rival)| (class(k).0, Swatch::Line, rival.name.clone()))
        .collect();
    let (keys, top) = legend(&entries, sheet);
    let driven: Vec<usize> = (0..trial.inputs.len())
        .filter(|&k| trial.inputs[k].iter().any(|x| *x != trial.inputs[k][0]))
        .collect();
    let panels = driven.len() + report.columns.len();
    let whole = top + panels as f64 * (HEIGHT + BETWEEN);
    let said = report.sentence();
    let mut chart =
        Chart::new("next-run", "The drive, and what each model predicts", &said, (sheet.width(), whole));
    chart.draw(keys);
    let mut place = 0;
    let mut draw = |chart: &mut Chart, name: &str, unit: &str, marks: Vec<Mark>, values: Vec<f64>| {
        let x = Axis::between("t", "s", 0.0, trial.duration());
        let panel =
            Panel { heading: String::new(), x, y: Axis::around(name, unit, values), marks, labelled: true };
        let (x, width) = sheet.beside(0.0);
        let y = top + f64::from(place) * (HEIGHT + BETWEEN);
        chart.draw([panel.live(Place { x, y, width, height: HEIGHT })]);
        place += 1;
    };
    for k in driven {
        let shown = &report.inputs[k];
        let values: Vec<f64> = trial.inputs[k].iter().step_by(every).map(|x| x / shown.factor).collect();
        let points = times.iter().copied().zip(values.iter().copied()).collect();
        draw(&mut chart, &shown.name, &shown.unit, vec![Mark::Line { class: "measured", points }], values);
    }
    for (c, shown) in report.columns.iter().enumerate() {
        let (mut marks, mut values) = (Vec::new(), Vec::new());
        for (k, predicted) in report.predicted.iter().enumerate() {
            let (line, band) = class(k);
            let at = |i: usize| {
                let (mean, reach) = (predicted.mean[c][i], HALF_WIDTH_95 * predicted.std_error[c][i]);
                (trial.step * i as f64, mean, reach)
            };
            let all: Vec<(f64, f64, f64)> = (0..trial.samples).step_by(every).map(at).collect();
            values.extend(all.iter().flat_map(|(_, mean, reach)| [mean - reach, mean + reach]));
            marks.push(Mark::Band {
                class: band,
                points: all.iter().map(|(t, m, r)| (*t, m - r, m + r)).collect(),
            });
            marks.push(Mark::Line { class: line, points: all.iter().map(|(t, m, _)| (*t, *m)).collect() });
        }
        draw(&mut chart, &shown.name, &shown.unit, marks, values);
    }
    let caption = "Above what drives the rig, below what each model predicts that its sensors show, with bands of 95 % from the errors of its numbers.";
    (chart, caption.to_owned())
}
