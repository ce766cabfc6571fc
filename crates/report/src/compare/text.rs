//! The comparison as lines of text.

use super::{CompareReport, Number, number, percent, why};
use crate::table::{aligned, short, with_error};
use phisindy_compare::{Comparison, FALSE_ALARMS, Fleet, HALF_WIDTH_95};

/// Most machines that are listed where they need no care.
const SHOWN: usize = 10;

pub(super) fn lines(report: &CompareReport) -> Vec<String> {
    match report {
        CompareReport::Pair(pair) => of_pair(pair, report),
        CompareReport::Fleet(fleet) => of_fleet(fleet, report),
    }
}

fn of_pair(pair: &Comparison, report: &CompareReport) -> Vec<String> {
    let mut out = vec![format!("{}: {}", pair.verdict(), report.sentence())];
    let mut rows = vec![["", "before", "change", ""].map(str::to_owned).to_vec()];
    for difference in &pair.changes.differences {
        let Number { before, by, std_error, unit } = number(pair, difference);
        let part = |x: f64| percent(100.0 * (x / before).abs());
        let sign = if by < 0.0 { "-" } else { "+" };
        let change = if before == 0.0 {
            with_error(by, HALF_WIDTH_95 * std_error)
        } else {
            format!("{sign}{} ± {} %", part(by), part(HALF_WIDTH_95 * std_error))
        };
        let mark = if difference.changed { "changed" } else { "" };
        let before = format!("{} {unit}", short(before)).trim_end().to_owned();
        rows.push(vec![difference.name.clone(), before, change, mark.to_owned()]);
    }
    if rows.len() > 1 {
        out.push(String::new());
        out.extend(aligned(&rows));
        let still = pair.changes.differences.iter().filter(|d| !d.changed).map(|d| d.name.as_str());
        let still: Vec<&str> = still.collect();
        if !still.is_empty() && pair.new.holds {
            out.push(format!("not changed beyond these errors: {}", still.join(", ")));
        }
        let chance = pair.changes.by_chance;
        let chance = if chance < 1e-12 { "below 1e-12".to_owned() } else { short(chance) };
        out.push("each change as if it were the only one beside those that are told".to_owned());
        out.push(format!(
            "differences as large as all of these where nothing changed: probability {chance} (a change is told below {FALSE_ALARMS})"
        ));
    }
    if !pair.changes.or.is_empty() {
        let others: Vec<String> = pair.changes.or.iter().map(|names| names.join(" and ")).collect();
        out.push(format!("not told apart from a change of: {}", others.join("; ")));
    }
    if !pair.old.holds {
        out.push(format!("the older record is not explained itself ({}): its numbers are those of a model that lacks something", pair.old.status));
    }
    out
}

fn of_fleet(fleet: &Fleet, report: &CompareReport) -> Vec<String> {
    let mut out = vec![report.sentence(), String::new()];
    let population = &fleet.population;
    let mut rows = vec![["", "mean", "spread", "machines"].map(str::to_owned).to_vec()];
    for spread in &population.spreads {
        let (mean, between) = (spread.mean / spread.factor, spread.between / spread.factor);
        let part = format!("{} ({} %)", short(between), percent(100.0 * (between / mean).abs()));
        let mean = format!("{} {}", with_error(mean, spread.mean_error / spread.factor), spread.unit);
        rows.push(vec![spread.name.clone(), mean.trim_end().to_owned(), part, spread.machines.to_string()]);
    }
    if rows.len() > 1 {
        out.extend(aligned(&rows));
        out.push(String::new());
    }
    let order = fleet.by_care();
    let need = order.iter().filter(|&&unit| fleet.needs_care(unit)).count();
    let mut rows = Vec::new();
    for &unit in order.iter().take(need.max(SHOWN)) {
        let mut row = vec![fleet.units[unit].name.clone(), fleet.units[unit].status.clone()];
        for (k, spread) in population.spreads.iter().enumerate() {
            let own = population.members[unit].numbers.iter().find(|number| number.spread == k);
            row.push(own.map_or("-".to_owned(), |n| {
                with_error(n.value / spread.factor, n.std_error / spread.factor)
            }));
        }
        row.push(why(fleet, unit));
        rows.push(row);
    }
    let head = ["machine", "status"].map(str::to_owned).into_iter();
    let head = head.chain(
        population
            .spreads
            .iter()
            .map(|s| if s.unit.is_empty() { s.name.clone() } else { format!("{} / {}", s.name, s.unit) }),
    );
    rows.insert(0, head.chain(["why".to_owned()]).collect());
    out.extend(aligned(&rows));
    if order.len() > rows.len() - 1 {
        out.push(format!("and {} more that do not stand out", order.len() + 1 - rows.len()));
    }
    out
}
