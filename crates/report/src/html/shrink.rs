//! The gap after each effect: bars on a logarithmic axis, with the noise and what the motion repeats to.

use crate::chart::{Axis, Chart, Mark, Panel, Place, Scale, Sheet, digits, shortened, width_of, word};
use crate::gap::{basis, counted};
use phisindy_gap::Gap;

const ROW: f64 = 42.0;
const LEFT: f64 = 12.0;

/// The chart.
pub(crate) fn chart(found: &Gap, sheet: Sheet) -> (Chart, String) {
    let mut rows = vec![("The model as it is".to_owned(), counted(found.before))];
    for s in found.steps.iter().chain(&found.partial) {
        let name = format!("+ {} at {}", s.effect.entry.law.name, s.effect.place.at);
        rows.push((name, s.validate.map_or(s.fit.1, |v| v.1)));
    }
    let which = basis(found);
    let repeats = repeatability(found);
    let said: Vec<String> = rows.iter().map(|(name, gap)| format!("{name}: {}", digits(*gap, 3))).collect();
    let title = "The gap, step by step";
    let floor = repeats.map_or(String::new(), |(low, high)| {
        let range = if high > 1.05 * low { format!("{} to {}", digits(low, 2), digits(high, 2)) } else { digits(high, 2) };
        format!(" The shaded band ({range}) is how well the motion itself repeats from cycle to cycle: no model can do better.")
    });
    let caption = format!(
        "The gap after each step: rms of what the model leaves {which}, over the noise. At the dashed line (1) only noise is left.{floor}"
    );
    let text = format!("{caption} {}.", said.join("; "));
    let high = ROW * rows.len() as f64;
    let top = 26.0;
    let mut chart = Chart::new("gap", title, &text, (sheet.width(), high + top + 50.0));
    let finite = || rows.iter().map(|r| r.1).filter(|v| v.is_finite());
    let (least, most) = (finite().fold(1.0, f64::min), finite().fold(2.0, f64::max));
    let x = Axis::between(&format!("gap {which}"), "× noise", 0.6 * least, 1.25 * most).on(Scale::Log);
    // The number of a bar stands behind it, in bold letters.
    let numbers = rows.iter().map(|r| 1.1 * width_of(&digits(r.1, 3))).fold(50.0, f64::max);
    let width = sheet.width() - LEFT - numbers - 10.0;
    let place = Place { x: LEFT, y: top, width, height: high };
    let from = x.ends().0;
    let bar = |k: usize, value: f64| {
        let y = 1.0 - (k as f64 + 0.5) / rows.len() as f64;
        let half = 0.2 / rows.len() as f64;
        // The bar stands low in its row, below its name.
        (from, value, y - half - 0.9 * half, y + half - 0.9 * half)
    };
    let boxes = |of: std::ops::Range<usize>, class| Mark::Boxes {
        class,
        boxes: of.map(|k| bar(k, rows[k].1.min(1.25 * most))).collect(),
    };
    let mut marks = vec![];
    if let Some((low, high)) = repeats {
        // A single value is drawn as a thin band.
        let (low, high) = if high > 1.05 * low { (low, high) } else { (high / 1.04, high * 1.04) };
        let area = (low.max(from), high.min(1.25 * most), 0.0, 1.0);
        marks.extend((area.0 < area.1).then(|| Mark::Boxes { class: "repeats", boxes: vec![area] }));
        let at = LEFT + width * x.place(high.min(1.25 * most));
        let words = "repeatability";
        let class = if at + 92.0 < LEFT + width { ("small", at + 3.0) } else { ("small end", at - 3.0) };
        chart.draw([word(class.0, class.1, top - 8.0, words)]);
    }
    let noise = LEFT + width * x.place(1.0);
    let far = repeats.is_none_or(|(_, high)| LEFT + width * x.place(high) - noise > 44.0);
    if far {
        chart.draw([word("small", noise + 3.0, top - 8.0, "noise")]);
    }
    marks.extend([boxes(0..1, "bar was"), boxes(1..rows.len(), "bar")]);
    marks.push(Mark::Line { class: "limit", points: vec![(1.0, 0.0), (1.0, 1.0)] });
    let panel = Panel { heading: String::new(), x: x.clone(), y: Axis::bare(), marks, labelled: true };
    chart.draw(panel.drawn(place));
    for (k, (name, value)) in rows.iter().enumerate() {
        let y = place.y + ROW * k as f64;
        let end = place.x + place.width * x.place(value.min(1.25 * most));
        let name = shortened(name, sheet.width() - LEFT - 10.0);
        chart.draw([
            word("label halo", LEFT + 6.0, y + 14.0, &name),
            word("heading", end + 6.0, y + 34.0, &digits(*value, 3)),
        ]);
    }
    (chart, caption)
}

/// The least and the largest gap that the motion itself repeats to: the scatter from cycle to cycle over the
/// noise.
fn repeatability(found: &Gap) -> Option<(f64, f64)> {
    let over_noise = found.repeat.iter().filter_map(|c| {
        let noise = found.noise.iter().find(|(name, _)| *name == c.column)?.1;
        Some(c.repeat.rms / noise).filter(|x| x.is_finite() && *x > 0.0)
    });
    let (low, high) = over_noise.fold((f64::INFINITY, 0.0_f64), |(a, b), v| (a.min(v), b.max(v)));
    (low <= high).then_some((low, high))
}
