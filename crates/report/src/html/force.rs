//! The force of an effect that `gap` added, against the displacement, velocity or time that its law depends
//! on.

use super::table::unit as unit_words;
use crate::chart::{Axis, Chart, Entry, Mark, Panel, Place, Swatch, WIDTH, digits, legend};
use phisindy_gap::{ForceHistory, Gap, Step, force_history};
use phisindy_phys::Record;

const LEFT: f64 = 70.0;
const HIGH: f64 = 220.0;
/// Most dots of all records together.
const DOTS: usize = 3000;

/// The chart of a step; none for an effect on a sensor.
pub(crate) fn chart(found: &Gap, number: usize, step: &Step, records: &[Record]) -> Option<(Chart, String)> {
    let history = force_history(found, step, records)?;
    let law = &step.effect.entry.law.name;
    let what = match (history.push, history.force) {
        (true, _) => "push",
        (false, true) => "resisting force",
        (false, false) => "resistance",
    };
    let all = || history.records.iter().flat_map(|(_, points)| points.iter().copied());
    let marks = [Mark::Level { class: "zero", y: 0.0 }].into_iter().chain(marks(&history)).collect();
    let panel = Panel {
        heading: String::new(),
        x: Axis::around(&history.over, &unit_words(&history.over_unit), all().map(|p| p.0)),
        y: Axis::around(what, &unit_words(&history.unit), all().map(|p| p.1).chain([0.0])),
        marks,
        labelled: true,
    };
    let title = format!("{law} at {}", step.effect.place.at);
    let said = said(&history, what);
    let entries: [Entry; 1] = if history.function {
        [("model", Swatch::Line, law.clone())]
    } else {
        [("model", Swatch::Dot, format!("{law}, along the simulated motion"))]
    };
    let mut chart = Chart::new(&format!("effect-{number}"), &title, &said, (WIDTH, HIGH + 106.0));
    chart.draw(legend(&entries, 20.0, 20.0));
    chart.draw(panel.drawn(Place { x: LEFT, y: 44.0, width: WIDTH - LEFT - 14.0, height: HIGH }));
    Some((chart, format!("{title}: {said}")))
}

/// A line for each record, or dots.
fn marks(history: &ForceHistory) -> Vec<Mark> {
    let count: usize = history.records.iter().map(|(_, points)| points.len()).sum();
    let every = count.div_ceil(DOTS).max(1);
    let mark = |(_, points): &(String, Vec<(f64, f64)>)| {
        if history.function {
            Mark::Line { class: "model", points: points.clone() }
        } else {
            let points = points.iter().step_by(every).copied().collect();
            Mark::Dots { class: "model", points, radius: 1.4 }
        }
    };
    history.records.iter().map(mark).collect()
}

/// What it is, and over which range.
fn said(history: &ForceHistory, what: &str) -> String {
    let all = || history.records.iter().flat_map(|(_, points)| points.iter().copied());
    let range = |values: &mut dyn Iterator<Item = f64>| {
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        format!("{} to {}", digits(low, 3), digits(high, 3))
    };
    let unit = |unit: &str| if unit.is_empty() { String::new() } else { format!(" {}", unit_words(unit)) };
    let how = if history.function {
        String::new()
    } else {
        format!(" It depends on more than {}, so that it is a cloud.", history.over)
    };
    format!(
        "{what} from {}{} while {} goes from {}{}.{how}",
        range(&mut all().map(|p| p.1)),
        unit(&history.unit),
        history.over,
        range(&mut all().map(|p| p.0)),
        unit(&history.over_unit)
    )
}
