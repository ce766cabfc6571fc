//! The numbers that decide something, from the tables of the crates.

use crate::markdown::markdown;
use phisindy_phys::Decision;

/// A row for each decision: its name, value and unit, what it decides, and why it is what it is.
pub(crate) fn table() -> String {
    let crates = [
        ("sim", phisindy_sim::decisions()),
        ("learn", phisindy_learn::decisions()),
        ("gap", phisindy_gap::decisions()),
    ];
    let rows = crates.into_iter().flat_map(|(name, all)| all.iter().map(move |d| row(name, d)));
    markdown(&["crate", "name", "value", "unit", "decides", "basis"], &rows.collect::<Vec<_>>())
}

fn row(name: &str, decision: &Decision) -> Vec<String> {
    let values: Vec<String> = decision.value.iter().map(|x| number(*x)).collect();
    vec![
        name.to_owned(),
        format!("`{}`", decision.name),
        values.join(", "),
        decision.unit.to_owned(),
        decision.meaning.to_owned(),
        decision.basis.to_string(),
    ]
}

/// Four digits are enough to recognise a number.
fn number(x: f64) -> String {
    match x.abs() {
        0.0 | 1e-3..1e6 => ((x * 1e4).round() / 1e4).to_string(),
        _ => format!("{x:e}"),
    }
}
