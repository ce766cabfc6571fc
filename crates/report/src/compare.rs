//! Results beside each other: what changed between two, and who stands out of many.

mod curves;
mod forces;
mod html;
mod json;
mod text;

use crate::format::Format;
use crate::html::HtmlReport;
use crate::table::{short, with_error};
pub use forces::force_curves;
use phisindy_compare::{Cause, Comparison, Difference, Fleet, Unit};

/// Two records of one machine, or many machines.
#[derive(Clone, Debug)]
pub enum CompareReport {
    /// An older and a newer record.
    Pair(Box<Comparison>),
    /// At least three machines.
    Fleet(Fleet),
}

impl CompareReport {
    /// Whether nothing changed, or nobody needs care.
    pub fn is_quiet(&self) -> bool {
        match self {
            CompareReport::Pair(pair) => pair.verdict() == "unchanged",
            CompareReport::Fleet(fleet) => !(0..fleet.units.len()).any(|unit| fleet.needs_care(unit)),
        }
    }

    /// The result in one of its forms, with an end of line. The table is the same in LaTeX, as comments.
    pub fn written(&self, format: Format) -> String {
        match format {
            Format::Json => json::object(self).to_string() + "\n",
            of_text => of_text.lines(text::lines(self)),
        }
    }

    /// `result.json`: the object on lines of its own.
    pub fn json_lines(&self) -> String {
        serde_json::to_string_pretty(&json::object(self)).unwrap_or_default() + "\n"
    }

    /// The report with its picture; `arguments` are the words of the command line.
    pub fn html(&self, arguments: &[String]) -> HtmlReport {
        html::page(self, arguments).html()
    }

    /// The finding in a sentence.
    pub fn sentence(&self) -> String {
        match self {
            CompareReport::Pair(pair) => of_pair(pair),
            CompareReport::Fleet(fleet) => of_fleet(fleet),
        }
    }
}

fn of_pair(pair: &Comparison) -> String {
    let changed = pair.changes.changed().map(|changed| of_change(pair, changed));
    let all: Vec<String> = changed.chain(pair.new.causes.iter().map(of_cause)).collect();
    let compared = pair.changes.differences.len();
    match pair.verdict() {
        "unchanged" if compared == 0 => {
            "the model of the older record explains the newer one, and has no numbers to compare".to_owned()
        }
        "unchanged" => format!("nothing changed: {compared} numbers, and no law is missing"),
        "changed" => all.join("; "),
        _ if all.is_empty() => {
            "the newer record is not of the model of the older one, and neither a number nor a law says why"
                .to_owned()
        }
        _ => format!(
            "the newer record is not of the model of the older one; nearest comes: {}",
            all.join("; ")
        ),
    }
}

/// A number that changed, in words.
fn of_change(pair: &Comparison, changed: &Difference) -> String {
    let sure = short((10.0 * changed.by.abs() / changed.std_error).round() / 10.0);
    let Number { before, by, std_error, unit } = number(pair, changed);
    let way = if by * before >= 0.0 { "rose" } else { "fell" };
    let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
    let part = 100.0 * (by / before).abs();
    let part = if part.is_finite() { format!(" by {} %", percent(part)) } else { String::new() };
    let now = with_error(before + by, std_error);
    format!("{} {way}{part}, from {} to {now}{unit} ({sure} standard errors)", changed.name, short(before))
}

/// A number of a pair, in its unit.
struct Number<'a> {
    /// As the model of the older record has it.
    before: f64,
    by: f64,
    std_error: f64,
    unit: &'a str,
}

fn number<'a>(pair: &'a Comparison, difference: &Difference) -> Number<'a> {
    let of = |unit: &'a Unit| unit.estimates.position(&difference.name).map(|k| (&unit.estimates, k));
    let (before, factor, unit) = match of(&pair.old).or_else(|| of(&pair.new)) {
        Some((e, k)) => (e.values[k], e.numbers[k].factor, e.numbers[k].unit.as_str()),
        None => (0.0, 1.0, ""),
    };
    let &Difference { relative, by, std_error, .. } = difference;
    let (by, std_error) =
        if relative { (before * by.exp_m1(), before.abs() * by.exp() * std_error) } else { (by, std_error) };
    Number { before: before / factor, by: by / factor, std_error: std_error / factor, unit }
}

/// What the newer record has beside the model of the older one, in words.
fn of_cause(cause: &Cause) -> String {
    let number = |(name, value, (low, high), unit): &(String, f64, (f64, f64), String)| {
        let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
        format!("{name} {}{unit} [{}, {}]", short(*value), short(*low), short(*high))
    };
    let numbers = cause.numbers.iter().map(number).collect::<Vec<_>>().join(", ");
    match (cause.stated, cause.numbers.first()) {
        (Some(stated), Some((name, value, ..))) => {
            let way = if value.abs() > stated.abs() { "rose" } else { "fell" };
            let by = percent(100.0 * (value / stated - 1.0).abs());
            format!("{name} {way} by {by} %, from {} (held before): {numbers}", short(stated))
        }
        _ => format!("new: {} at {} ({numbers})", cause.law, cause.at),
    }
}

fn of_fleet(fleet: &Fleet) -> String {
    let need: Vec<usize> = fleet.by_care().into_iter().filter(|&unit| fleet.needs_care(unit)).collect();
    let count = fleet.units.len();
    match need.as_slice() {
        [] => format!("{count} machines, none of which stands out"),
        [one] => format!("of {count} machines, {} needs care: {}", fleet.units[*one].name, why(fleet, *one)),
        [first, ..] => format!(
            "of {count} machines, {} need care; first {}: {}",
            need.len(),
            fleet.units[*first].name,
            why(fleet, *first)
        ),
    }
}

/// Why a machine needs care; empty if it does not.
fn why(fleet: &Fleet, unit: usize) -> String {
    let numbers = fleet.population.members[unit].numbers.iter().filter(|number| number.stands_out);
    let number = |n: &phisindy_compare::Beside| {
        let spread = &fleet.population.spreads[n.spread];
        let way = if n.value > spread.mean { "above" } else { "below" };
        let by = percent(100.0 * ((n.value - spread.mean) / spread.mean).abs());
        format!(
            "{} is {by} % {way} the others ({} of their spread)",
            spread.name,
            short((10.0 * n.deviation.abs()).round() / 10.0)
        )
    };
    let mut all: Vec<String> = numbers.map(number).collect();
    all.extend(fleet.odd_causes(unit).map(of_cause));
    if !fleet.units[unit].holds {
        all.push(format!("its model does not hold ({})", fleet.units[unit].status));
    }
    all.join("; ")
}

/// Two digits.
fn percent(x: f64) -> String {
    match x {
        x if x >= 99.5 => format!("{x:.0}"),
        x if x >= 9.95 => format!("{x:.1}"),
        x => format!("{x:.2}"),
    }
}
