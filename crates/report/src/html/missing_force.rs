//! The force that a model lacks where no law and no formula explains it: its curve and band.

use crate::chart::{Axis, Chart, Mark, Panel, Place, Sheet, digits};
use phisindy_gap::{ForcePoint, MissingForce};

const HIGH: f64 = 200.0;
/// From one panel to the next.
const APART: f64 = 56.0;
/// Most curves in a panel.
const CURVES: usize = 3;

/// A curve: abscissa, force, half the band.
type Curve = Vec<(f64, f64, f64)>;

/// The curves over one quantity.
struct Over {
    name: &'static str,
    /// Each with what else it holds for.
    curves: Vec<(String, Curve)>,
}

/// The chart with a caption.
pub(crate) fn chart(of: &MissingForce, sheet: Sheet) -> (Chart, String) {
    let title = format!("The missing force at {}", of.at);
    let said = format!(
        "{title} without a formula: it depends on {}. Line and band (95 %): a spline in place of a law; it leaves {} times the noise.",
        of.on.name(),
        digits(of.left, 3)
    );
    let panels = panels(&of.points);
    // On a phone the name of an axis stands above it.
    let top = if sheet.is_phone() { 24.0 } else { 8.0 };
    let high = top - 8.0 + panels.len() as f64 * (HIGH + APART);
    let mut chart = Chart::new("missing-force", &title, &said, (sheet.width(), high));
    let panels: Vec<Panel> = panels.iter().map(panel).collect();
    let (x, width) = sheet.beside(panels.iter().map(|p| p.labels(HIGH)).fold(0.0, f64::max));
    for (k, panel) in panels.iter().enumerate() {
        let y = top + k as f64 * (HIGH + APART);
        chart.draw([panel.live(Place { x, y, width, height: HIGH })]);
    }
    (chart, said)
}

fn panel(over: &Over) -> Panel {
    let all = || over.curves.iter().flat_map(|(_, curve)| curve);
    let x = Axis::around(over.name, "SI", all().map(|p| p.0));
    let y = Axis::around("missing force", "SI", all().flat_map(|p| [p.1 - p.2, p.1 + p.2, 0.0]));
    let mut marks = vec![Mark::Level { class: "zero", y: 0.0 }];
    for (name, curve) in &over.curves {
        let band = curve.iter().map(|&(x, f, half)| (x, f - half, f + half)).collect();
        marks.push(Mark::Band { class: "band", points: band });
        marks.push(Mark::Line { class: "model", points: curve.iter().map(|p| (p.0, p.1)).collect() });
        if let Some(last) = curve.last().filter(|_| !name.is_empty()) {
            marks.push(Mark::Name { x: last.0, y: last.1, words: name.clone() });
        }
    }
    Panel { heading: String::new(), x, y, marks, labelled: true }
}

/// The panels: over the displacement, over the velocity, or over the displacement at a few velocities.
fn panels(points: &[ForcePoint]) -> Vec<Over> {
    // Where the band is wider than the force is large, the records do not tell it.
    let weight = |p: &&ForcePoint| p.band.powi(-2);
    let power: f64 = points.iter().map(|p| weight(&p) * p.force.powi(2)).sum();
    let size = (power / points.iter().map(|p| weight(&p)).sum::<f64>()).sqrt();
    let told = |p: &&ForcePoint| p.band <= 2.0 * size;
    let curve = |of: &dyn Fn(&ForcePoint) -> Option<f64>| -> Curve {
        let mut all: Curve =
            points.iter().filter(told).filter_map(|p| Some((of(p)?, p.force, p.band))).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        all
    };
    let alone = |own: Option<f64>, other: Option<f64>| own.filter(|_| other.is_none());
    let over_x = curve(&|p| alone(p.displacement, p.velocity));
    let over_v = curve(&|p| alone(p.velocity, p.displacement));
    let mut velocities: Vec<f64> =
        points.iter().filter(|p| p.displacement.is_some()).filter_map(|p| p.velocity).collect();
    velocities.sort_by(f64::total_cmp);
    velocities.dedup();
    let last = velocities.len().saturating_sub(1);
    let mut at: Vec<usize> = (0..CURVES).map(|k| k * last / (CURVES - 1)).collect();
    at.dedup();
    let slices = at.into_iter().filter_map(|k| velocities.get(k)).map(|&v| {
        (
            format!("at a velocity of {}", digits(v, 2)),
            curve(&|p| p.displacement.filter(|_| p.velocity == Some(v))),
        )
    });
    let displacement = |curves| Over { name: "displacement", curves };
    let all = [
        displacement(vec![(String::new(), over_x)]),
        Over { name: "velocity", curves: vec![(String::new(), over_v)] },
        displacement(slices.collect()),
    ];
    all.into_iter().filter(|over| over.curves.iter().any(|(_, curve)| curve.len() > 1)).collect()
}
