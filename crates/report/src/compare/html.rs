//! The comparison as a page: a table, and each number of each machine with its interval.

use super::curves::curves;
use super::{CompareReport, Number, number, text, why};
use crate::chart::{Axis, Chart, Mark, Panel, Place, Sheet, Swatch, digits, legend};
use crate::format::capital;
use crate::html::page::{Banner, Captioned, Page, Tone, block};
use crate::html::reproduction::command;
use crate::html::table::{Cell, code, table, text as words};
use crate::input::Invocation;
use phisindy_compare::{Fleet, HALF_WIDTH_95, Unit};

/// Height of the line of a machine, of a panel at most, and between panels.
const LINE: f64 = 13.0;
/// The same where each has its name above it.
const NAMED: f64 = 26.0;
const HIGHEST: f64 = 420.0;
const BETWEEN: f64 = 66.0;
/// Most machines of a picture and of a table: beyond those that need care, `result.json` has the rest.
const SHOWN: usize = 200;

pub(super) fn page(report: &CompareReport, arguments: &[String]) -> Page {
    let (headline, tone, title) = match report {
        CompareReport::Pair(pair) => {
            let tone = match pair.verdict() {
                "unchanged" => Tone::Good,
                "changed" => Tone::Open,
                _ => Tone::Bad,
            };
            (capital(pair.verdict()), tone, format!("{} and {}", pair.old.name, pair.new.name))
        }
        CompareReport::Fleet(fleet) => {
            let (headline, tone) =
                if report.is_quiet() { ("All alike", Tone::Good) } else { ("Look here", Tone::Open) };
            (headline.to_owned(), tone, format!("{} machines", fleet.units.len()))
        }
    };
    // What changed begins with the name of a number, which keeps its case.
    let named = matches!(report, CompareReport::Pair(pair) if pair.verdict() == "changed");
    let sentence = if named { report.sentence() } else { capital(&report.sentence()) };
    let banner = Banner { tone, headline, text: sentence + ".", how: String::new() };
    let mut page = Page::of_refusal(&title, "compare", banner);
    page.figures("Forces on top of each other", |sheet| curves(report, sheet).into_iter().collect());
    page.figures("Numbers beside each other", |sheet| numbers(report, sheet).into_iter().collect());
    if let CompareReport::Fleet(fleet) = report {
        let rows = shown(fleet).into_iter().map(|unit| {
            let Unit { name, status, .. } = &fleet.units[unit];
            let sign = if fleet.needs_care(unit) { "!" } else { "" };
            vec![words(sign), code(name), words(status), Cell::Text(why(fleet, unit))]
        });
        let left = fleet.units.len().saturating_sub(rows.len());
        let left = if left > 0 {
            format!("; {left} more that do not stand out are in result.json")
        } else {
            String::new()
        };
        let caption = format!("Machines: those that need care first, then by their largest deviation{left}");
        page.section("Machines", table(&caption, &["", "machine", "status", "why"], rows.collect()));
    }
    let lines = text::lines(report).join("\n");
    page.section("The comparison as text", [block(&lines, "comparison")]);
    let how = Invocation { arguments: arguments.to_vec(), ..Invocation::default() };
    page.section("To repeat it", command(None, "", None, &how));
    page
}

/// The machines that need care, and others up to a number that can be read.
fn shown(fleet: &Fleet) -> Vec<usize> {
    let order = fleet.by_care();
    let need = order.iter().filter(|&&unit| fleet.needs_care(unit)).count();
    order.into_iter().take(need.max(SHOWN)).collect()
}

/// A number of all machines.
struct Numbers {
    name: String,
    unit: String,
    rows: Vec<Row>,
    /// Where 95 % of machines like the others lie.
    band: Option<(f64, f64)>,
}

/// A number of a machine, and whether it is told; of a pair, a number of its own name.
struct Row {
    name: Option<String>,
    value: f64,
    std_error: f64,
    told: bool,
}

/// Each number with the rows of the machines, from above.
fn panels(report: &CompareReport) -> Vec<Numbers> {
    match report {
        CompareReport::Pair(pair) => {
            let rows = pair.changes.differences.iter().map(|d| {
                let Number { before, by, std_error, .. } = number(pair, d);
                let part = if before == 0.0 { 1.0 } else { before.abs() / 100.0 };
                Row {
                    name: Some(d.name.clone()),
                    value: by / part,
                    std_error: std_error / part,
                    told: d.changed,
                }
            });
            let (name, unit) = ("change".to_owned(), "%".to_owned());
            vec![Numbers { name, unit, rows: rows.collect(), band: None }]
        }
        CompareReport::Fleet(fleet) => {
            let order = shown(fleet);
            let of = |(k, spread): (usize, &phisindy_compare::Spread)| {
                let numbers = |&unit: &usize| &fleet.population.members[unit].numbers;
                let own = order.iter().flat_map(numbers).filter(|number| number.spread == k);
                let row = |n: &phisindy_compare::Beside| Row {
                    name: None,
                    value: n.value / spread.factor,
                    std_error: n.std_error / spread.factor,
                    told: n.stands_out,
                };
                let reach = HALF_WIDTH_95 * spread.between;
                let band = ((spread.mean - reach) / spread.factor, (spread.mean + reach) / spread.factor);
                let rows = own.map(row).collect();
                Numbers { name: spread.name.clone(), unit: spread.unit.clone(), rows, band: Some(band) }
            };
            fleet.population.spreads.iter().enumerate().map(of).collect()
        }
    }
}

/// Each number in a panel of its own, the machines below each other.
fn numbers(report: &CompareReport, sheet: Sheet) -> Option<Captioned> {
    let panels = panels(report);
    let most = panels.iter().map(|panel| panel.rows.len()).max().filter(|rows| *rows > 0)?;
    let pair = matches!(report, CompareReport::Pair(_));
    let height = (if pair { NAMED } else { LINE } * (most as f64 + 1.0)).min(HIGHEST);
    let mut entries = vec![("model", Swatch::Dot, "estimate with its 95 % interval".to_owned())];
    entries.push(("chosen", Swatch::Dot, if pair { "changed" } else { "stands out" }.to_owned()));
    let (keys, top) = legend(&entries, sheet);
    let said: Vec<String> = panels
        .iter()
        .map(|Numbers { name, unit, rows, .. }| {
            let told = rows.iter().filter(|row| row.told).map(|row| digits(row.value, 4));
            let told: Vec<String> = told.collect();
            let told = if told.is_empty() { "none".to_owned() } else { told.join(", ") };
            format!("{name} ({unit}): {} values, told: {told}", rows.len())
        })
        .collect();
    let title = if pair { "What changed" } else { "Machines, those that need care above" };
    let whole = top + panels.len() as f64 * (height + BETWEEN);
    let mut chart = Chart::new("numbers", title, &said.join("; "), (sheet.width(), whole));
    chart.draw(keys);
    for (k, Numbers { name, unit, rows, band }) in panels.iter().enumerate() {
        let ends = rows.iter().flat_map(|row| {
            let reach = if row.std_error.is_finite() { HALF_WIDTH_95 * row.std_error } else { 0.0 };
            [row.value - reach, row.value + reach]
        });
        let x = Axis::around(name, unit, ends.chain(band.iter().flat_map(|&(low, high)| [low, high])));
        let count = rows.len() as f64;
        let at = |place: usize| (count - place as f64) / (count + 1.0);
        let mut marks = Vec::new();
        if let Some((low, high)) = *band {
            marks.push(Mark::Boxes { class: "band", boxes: vec![(low, high, 0.0, 1.0)] });
        }
        for told in [false, true] {
            let (class, line) = if told { ("chosen", "before") } else { ("model", "model") };
            let own = || rows.iter().enumerate().filter(move |(_, row)| row.told == told);
            for (place, row) in own() {
                let reach = HALF_WIDTH_95 * row.std_error;
                let points = vec![(row.value - reach, at(place)), (row.value + reach, at(place))];
                marks.push(Mark::Line { class: line, points });
            }
            marks.extend(own().filter_map(|(place, row)| {
                let words = row.name.clone()?;
                Some(Mark::Name { x: row.value, y: at(place), words })
            }));
            let points = own().map(|(place, row)| (row.value, at(place))).collect();
            marks.push(Mark::Dots { class, points, radius: 3.5 });
        }
        let panel = Panel { heading: String::new(), x, y: Axis::bare(), marks, labelled: true };
        let (x, width) = sheet.beside(0.0);
        chart.draw([panel.live(Place { x, y: top + k as f64 * (height + BETWEEN), width, height })]);
    }
    let caption = if pair {
        "Each number: its change with the 95 % interval, if it alone changed beside what is told.".to_owned()
    } else {
        "Each number of each machine with its 95 % interval; the band holds 95 % of machines that are like the others.".to_owned()
    };
    Some((chart, caption))
}
