//! The gap after each effect: bars on a logarithmic axis.

use crate::chart::{Axis, Chart, Mark, Panel, Place, Scale, WIDTH, digits, word};
use crate::gap::basis;
use phisindy_gap::Gap;

const LEFT: f64 = 24.0;
const ROW: f64 = 46.0;

/// The chart.
pub(crate) fn chart(found: &Gap) -> (Chart, String) {
    let shown = |(fit, validate): (f64, Option<f64>)| validate.unwrap_or(fit);
    let mut rows = vec![("The model as it is".to_owned(), shown(found.before))];
    for s in found.steps.iter().chain(&found.partial) {
        let name = format!("+ {} at {}", s.effect.entry.law.name, s.effect.place.at);
        rows.push((name, s.validate.map_or(s.fit.1, |v| v.1)));
    }
    let which = basis(found);
    let said: Vec<String> = rows.iter().map(|(name, gap)| format!("{name}: {}", digits(*gap, 3))).collect();
    let title = "The gap, step by step";
    let text = format!("rms of residual over noise {which}; 1 is perfect. {}.", said.join("; "));
    let high = ROW * rows.len() as f64;
    let mut chart = Chart::new("gap", title, &text, (WIDTH, high + 78.0));
    let finite = || rows.iter().map(|r| r.1).filter(|v| v.is_finite());
    let (least, most) = (finite().fold(1.0, f64::min), finite().fold(2.0, f64::max));
    let x = Axis::between(&format!("gap {which}"), "", 0.5 * least, 1.25 * most).on(Scale::Log);
    let width = WIDTH - LEFT - 70.0;
    let place = Place { x: LEFT, y: 18.0, width, height: high };
    let from = x.ends().0;
    let bar = |k: usize, value: f64| {
        let y = 1.0 - (k as f64 + 0.5) / rows.len() as f64;
        let half = 0.2 / rows.len() as f64;
        // The bar stands low in its row, below its name.
        (from, value, y - half - 0.4 * half, y + half - 0.4 * half)
    };
    let boxes = |of: std::ops::Range<usize>, class| Mark::Boxes {
        class,
        boxes: of.map(|k| bar(k, rows[k].1.min(1.25 * most))).collect(),
    };
    let noise = Mark::Line { class: "limit", points: vec![(1.0, 0.0), (1.0, 1.0)] };
    let marks = vec![boxes(0..1, "bar was"), boxes(1..rows.len(), "bar"), noise];
    let panel = Panel { heading: String::new(), x: x.clone(), y: Axis::bare(), marks, labelled: true };
    chart.draw(panel.drawn(place));
    for (k, (name, value)) in rows.iter().enumerate() {
        let y = place.y + ROW * k as f64;
        let end = place.x + place.width * x.place(value.min(1.25 * most));
        chart.draw([
            word("label halo", LEFT + 8.0, y + 15.0, name),
            word("heading", end + 8.0, y + 32.0, &digits(*value, 3)),
        ]);
    }
    (chart, format!("{title}: {text}"))
}
