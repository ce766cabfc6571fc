//! The forces of machines in one picture: the older and the newer record on top of each other, or those that need care on
//! top of the others.

use super::CompareReport;
use crate::chart::{Axis, Chart, Entry, Mark, Panel, Place, Sheet, Swatch, digits, legend};
use crate::html::page::Captioned;
use crate::html::table::unit as unit_words;
use phisindy_compare::{Comparison, Fleet, ForceCurve, HALF_WIDTH_95, mean_curve};

/// Height of a panel, and between panels.
const HEIGHT: f64 = 200.0;
const BETWEEN: f64 = 56.0;
/// Most machines that are drawn one by one: more lines are not told apart.
const ONE_BY_ONE: usize = 8;
/// From so many machines on the others are a band: of fewer, two deviations say little of where they lie.
const BAND_FROM: usize = 10;
/// Classes of a line and its band: the newer record, or the other machines; the older one, or those that need care.
const NEW: (&str, &str) = ("model", "band");
const OLD: (&str, &str) = ("before", "repeats");

/// The picture with its caption; none where no force depends on one speed or displacement alone.
pub(super) fn curves(report: &CompareReport, sheet: Sheet) -> Option<Captioned> {
    let drawn = match report {
        CompareReport::Pair(pair) => of_pair(pair),
        CompareReport::Fleet(fleet) => of_fleet(fleet),
    };
    if drawn.panels.is_empty() {
        return None;
    }
    let (keys, top) = legend(&drawn.entries, sheet);
    let size = (sheet.width(), top + drawn.panels.len() as f64 * (HEIGHT + BETWEEN));
    let said: Vec<String> = drawn.panels.iter().map(|panel| panel.said.clone()).collect();
    let mut chart = Chart::new("forces", drawn.title, &said.join("; "), size);
    chart.draw(keys);
    let panels: Vec<Panel> = drawn.panels.into_iter().map(Over::panel).collect();
    let (x, width) = sheet.beside(panels.iter().map(|panel| panel.labels(HEIGHT)).fold(0.0, f64::max));
    for (k, panel) in panels.iter().enumerate() {
        let y = top + k as f64 * (HEIGHT + BETWEEN);
        chart.draw([panel.live(Place { x, y, width, height: HEIGHT })]);
    }
    Some((chart, drawn.caption))
}

struct Drawn {
    title: &'static str,
    caption: String,
    entries: Vec<Entry>,
    panels: Vec<Over>,
}

/// The forces over one speed or displacement.
struct Over {
    of: ForceCurve,
    marks: Vec<Mark>,
    /// Points that must be seen.
    seen: Vec<(f64, f64)>,
    said: String,
}

impl Over {
    fn new(of: &ForceCurve, several: bool) -> Over {
        let at = if several { format!(" at {}", of.at) } else { String::new() };
        let force = (format!("{}{at}", of.force.0), of.force.1.clone());
        let of = ForceCurve { force, points: vec![], ..of.clone() };
        let said = format!("{} over {}", of.force.0, of.over.0);
        Over { of, marks: vec![Mark::Level { class: "zero", y: 0.0 }], seen: vec![], said }
    }

    fn add(&mut self, (line, band): (&'static str, &'static str), points: Vec<(f64, f64, f64)>) {
        let ends: Vec<(f64, f64, f64)> = {
            let end = |&(x, f, s): &(f64, f64, f64)| (x, f - HALF_WIDTH_95 * s, f + HALF_WIDTH_95 * s);
            points.iter().map(end).collect()
        };
        self.seen.extend(ends.iter().flat_map(|&(x, low, high)| [(x, low), (x, high)]));
        self.marks.push(Mark::Band { class: band, points: ends });
        self.marks.push(Mark::Line { class: line, points: points.iter().map(|p| (p.0, p.1)).collect() });
    }

    fn line(&mut self, class: &'static str, curve: &ForceCurve) {
        let points: Vec<(f64, f64)> = curve.points.iter().map(|p| (p.0, p.1)).collect();
        self.seen.extend(&points);
        self.marks.push(Mark::Line { class, points });
    }

    /// Says the largest force.
    fn say(&mut self, whose: &str, curve: &ForceCurve) {
        let largest = curve.points.iter().map(|p| p.1).fold(f64::NEG_INFINITY, f64::max);
        self.said += &format!(", {whose} up to {} {}", digits(largest, 3), curve.force.1);
    }

    fn panel(self) -> Panel {
        let Over { of, marks, seen, .. } = self;
        let x = Axis::around(&of.over.0, &unit_words(&of.over.1), seen.iter().map(|p| p.0));
        let y = Axis::around(&of.force.0, &unit_words(&of.force.1), seen.iter().map(|p| p.1));
        Panel { heading: String::new(), x, y, marks, labelled: true }
    }
}

/// The different forces of machines, in the order in which they come.
fn forces<'a>(all: impl Iterator<Item = &'a ForceCurve>) -> Vec<&'a ForceCurve> {
    let mut out: Vec<&ForceCurve> = Vec::new();
    for curve in all {
        if !out.iter().any(|other| other.is(curve)) {
            out.push(curve);
        }
    }
    out
}

fn several(forces: &[&ForceCurve]) -> bool {
    forces.iter().any(|force| force.at != forces[0].at)
}

fn of_pair(pair: &Comparison) -> Drawn {
    let forces = forces(pair.old.curves.iter().chain(&pair.new.curves));
    let panel = |force: &&ForceCurve| {
        let mut over = Over::new(force, several(&forces));
        for (unit, classes, whose) in [(&pair.old, OLD, "older"), (&pair.new, NEW, "newer")] {
            if let Some(own) = unit.curves.iter().find(|own| own.is(force)) {
                over.add(classes, own.points.clone());
                over.say(whose, own);
            }
        }
        over
    };
    Drawn {
        title: "Forces of the older and the newer record",
        caption: "Each force over the speed or displacement that it depends on, as far as the record went; positive where it opposes. Of the older record the band (95 %) is that of its numbers, of the newer one that of what changed.".to_owned(),
        entries: vec![
            (OLD.0, Swatch::Line, format!("older: {}", pair.old.name)),
            (NEW.0, Swatch::Line, format!("newer: {}", pair.new.name)),
        ],
        panels: forces.iter().map(panel).collect(),
    }
}

fn of_fleet(fleet: &Fleet) -> Drawn {
    let forces = forces(fleet.units.iter().flat_map(|unit| &unit.curves));
    let order = fleet.by_care();
    let (need, others): (Vec<usize>, Vec<usize>) = order.iter().partition(|&&unit| fleet.needs_care(unit));
    let of = |unit: usize, force: &ForceCurve| fleet.units[unit].curves.iter().find(|own| own.is(force));
    let banded = others.len() >= BAND_FROM;
    let panel = |force: &&ForceCurve| {
        let mut over = Over::new(force, several(&forces));
        let own: Vec<&ForceCurve> = others.iter().filter_map(|&unit| of(unit, force)).collect();
        // The places of the machine that went farthest.
        let reach = |curve: &&&ForceCurve| {
            curve.points.last().map_or(0.0, |p| p.0) - curve.points.first().map_or(0.0, |p| p.0)
        };
        let widest = own.iter().max_by(|a, b| reach(a).total_cmp(&reach(b)));
        if let Some(widest) = widest.filter(|_| banded) {
            let places: Vec<f64> = widest.points.iter().map(|p| p.0).collect();
            over.add(NEW, mean_curve(&own, &places));
        } else {
            own.iter().for_each(|curve| over.line(NEW.0, curve));
        }
        for &unit in need.iter().take(ONE_BY_ONE) {
            let Some(own) = of(unit, force) else { continue };
            over.line(OLD.0, own);
            over.say(&fleet.units[unit].name, own);
            if let Some(&(x, y, _)) = own.points.last() {
                over.marks.push(Mark::Name { x, y, words: fleet.units[unit].name.clone() });
            }
        }
        over
    };
    let (what, how) = if banded {
        ("the others, with a band", "the line is the mean of the others, the band holds 95 % of them")
    } else {
        ("the others", "each of the others has a line")
    };
    let more = need.len().saturating_sub(ONE_BY_ONE);
    let more = if more > 0 {
        format!(" Of those that need care the first {ONE_BY_ONE} are drawn, {more} are not.")
    } else {
        String::new()
    };
    Drawn {
        title: "Forces of the machines that need care, and of the others",
        caption: format!(
            "Each force over the speed or displacement that it depends on, as far as the records went; positive where it opposes; {how}.{more}"
        ),
        entries: vec![(NEW.0, Swatch::Line, what.to_owned()), (OLD.0, Swatch::Line, "needs care".to_owned())],
        panels: forces.iter().map(panel).filter(|over| !over.seen.is_empty()).collect(),
    }
}
