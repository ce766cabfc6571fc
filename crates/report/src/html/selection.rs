//! The path of term selection: criterion against number of terms.

use crate::chart::{Axis, Chart, Mark, Panel, Place, Scale, Sheet, Swatch, digits, legend};
use crate::format::capital;
use phisindy_learn::Identified;
use phisindy_phys::spec::Method;

/// The chart; none if there was no choice.
pub(crate) fn chart(found: &Identified, sheet: Sheet) -> Option<(Chart, String)> {
    // Of several models with the same number of terms the best one counts.
    let mut path: Vec<(usize, f64)> = Vec::new();
    for point in found.selection.iter().filter(|p| p.criterion.is_finite()) {
        match path.iter_mut().find(|(terms, _)| *terms == point.terms) {
            Some((_, best)) => *best = best.min(point.criterion),
            None => path.push((point.terms, point.criterion)),
        }
    }
    path.sort_by_key(|p| p.0);
    if path.len() < 2 {
        return None;
    }
    // Only differences of the criterion matter; the loss of method step is shown as it is.
    let step = found.method == Method::Step;
    let least = path.iter().map(|p| p.1).fold(f64::INFINITY, f64::min);
    let base = if step { 0.0 } else { least };
    let points: Vec<(f64, f64)> = path.iter().map(|(k, c)| (*k as f64, c - base)).collect();
    let chosen: Vec<(f64, f64)> =
        points.iter().filter(|p| p.0 as usize == found.terms.len()).copied().collect();
    let highest = points.iter().map(|p| p.1).fold(0.0, f64::max);
    let said: Vec<String> =
        points.iter().map(|(k, c)| format!("{}: {}", count(*k as usize), digits(*c, 3))).collect();
    let what = if step { "one-step loss" } else { "criterion above the least" };
    let description = format!("{}, by number of terms. {}.", capital(what), said.join("; "));
    let title = "Error against number of terms";
    let entries = [
        ("model", Swatch::Line, format!("{what}, along the path")),
        ("chosen", Swatch::Dot, format!("chosen: {}", count(found.terms.len()))),
    ];
    let (keys, top) = legend(&entries, sheet);
    let mut chart = Chart::new("selection", title, &description, (sheet.width(), top + 256.0));
    chart.draw(keys);
    let marks = vec![
        Mark::Line { class: "model", points: points.clone() },
        Mark::Dots { class: "model", points, radius: 3.5 },
        Mark::Dots { class: "chosen", points: chosen, radius: 6.0 },
    ];
    let (fewest, most) = (path[0].0 as f64, path[path.len() - 1].0 as f64);
    let x = Axis::between("number of terms", "", fewest - 0.4, most + 0.4).whole();
    let y = if step {
        Axis::between(what, "", 0.0, 1.1 * highest)
    } else {
        Axis::between(what, "", 0.0, 1.6 * highest.max(1.0)).on(Scale::FromZero)
    };
    let panel = Panel { heading: String::new(), x, y, marks, labelled: true };
    let (x, width) = sheet.beside(panel.labels(200.0));
    let place = Place { x, y: top, width, height: 200.0 };
    chart.draw([panel.live(place)]);
    let caption = if step {
        format!("{title}: the one-step loss at the end of each stage.")
    } else {
        format!(
            "{title}: the criterion is misfit plus a price for each term, above its least value, which is chosen."
        )
    };
    Some((chart, caption))
}

fn count(terms: usize) -> String {
    format!("{terms} {}", if terms == 1 { "term" } else { "terms" })
}
