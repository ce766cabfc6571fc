//! The force that a model lacks where no law and no formula explains it: its curve and band.

use super::table::unit as unit_words;
use crate::chart::{Axis, Chart, Mark, Panel, Place, Sheet, digits};
use phisindy_gap::{ForcePoint, MissingForce};
use phisindy_phys::unit::Unit;

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
    unit: String,
    /// Each with what else it holds for.
    curves: Vec<(String, Curve)>,
}

/// The chart with a caption; `None` where the records tell nothing of the force.
pub(crate) fn chart(of: &MissingForce, sheet: Sheet) -> Option<(Chart, String)> {
    let title = format!("The missing force at {}", of.at);
    let said = format!(
        "{title} without a formula: it depends on {}. Line and band (95 %): a spline in place of a law; it leaves {} times the noise.",
        of.on.name(),
        digits(of.left, 3)
    );
    let panels = panels(of);
    if panels.is_empty() {
        return None;
    }
    // On a phone the name of an axis stands above it.
    let top = if sheet.is_phone() { 24.0 } else { 8.0 };
    let high = top - 8.0 + panels.len() as f64 * (HIGH + APART);
    let [_, _, force] = &of.units;
    let mut chart = Chart::new("missing-force", &title, &said, (sheet.width(), high));
    let panels: Vec<Panel> = panels.iter().map(|over| panel(over, &unit_words(force))).collect();
    let (x, width) = sheet.beside(panels.iter().map(|p| p.labels(HIGH)).fold(0.0, f64::max));
    for (k, panel) in panels.iter().enumerate() {
        let y = top + k as f64 * (HIGH + APART);
        chart.draw([panel.live(Place { x, y, width, height: HIGH })]);
    }
    Some((chart, said))
}

fn panel(over: &Over, unit: &str) -> Panel {
    let all = || over.curves.iter().flat_map(|(_, curve)| curve);
    let x = Axis::around(over.name, &over.unit, all().map(|p| p.0));
    let y = Axis::around("missing force", unit, all().flat_map(|p| [p.1 - p.2, p.1 + p.2, 0.0]));
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

/// A point in the units of its place.
fn in_units(point: &ForcePoint, units: &[String; 3]) -> ForcePoint {
    let [x, v, force] = units.each_ref().map(|unit| Unit::parse(unit).map_or(1.0, |u| u.factor));
    ForcePoint {
        displacement: point.displacement.map(|of| of / x),
        velocity: point.velocity.map(|of| of / v),
        force: point.force / force,
        band: point.band / force,
    }
}

/// The panels: over the displacement, over the velocity, or over the displacement at a few velocities.
fn panels(of: &MissingForce) -> Vec<Over> {
    let points: Vec<ForcePoint> = of.points.iter().map(|point| in_units(point, &of.units)).collect();
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
    let [x_unit, v_unit, _] = of.units.each_ref().map(|unit| unit_words(unit));
    let last = velocities.len().saturating_sub(1);
    let mut at: Vec<usize> = (0..CURVES).map(|k| k * last / (CURVES - 1)).collect();
    at.dedup();
    let slices = at.into_iter().filter_map(|k| velocities.get(k)).map(|&v| {
        (
            format!("at a velocity of {} {v_unit}", digits(v, 2)),
            curve(&|p| p.displacement.filter(|_| p.velocity == Some(v))),
        )
    });
    let displacement = |curves| Over { name: "displacement", unit: x_unit.clone(), curves };
    let all = [
        displacement(vec![(String::new(), over_x)]),
        Over { name: "velocity", unit: v_unit.clone(), curves: vec![(String::new(), over_v)] },
        displacement(slices.collect()),
    ];
    all.into_iter().filter(|over| over.curves.iter().any(|(_, curve)| curve.len() > 1)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use phisindy_gap::Dependence;

    /// A force at a body that is measured in millimetres, with this band.
    fn force(band: f64) -> MissingForce {
        let point = |x: f64| ForcePoint { displacement: Some(x), velocity: None, force: 40.0 * x, band };
        MissingForce {
            at: "v".into(),
            units: ["mm", "mm/s", "N"].map(str::to_owned),
            on: Dependence::Displacement,
            left: 1.2,
            points: [-0.05, 0.0, 0.05].map(point).to_vec(),
        }
    }

    #[test]
    fn axes_have_the_units_of_the_place() {
        let all = panels(&force(0.1));
        let [over] = &all[..] else { panic!("{} panels", all.len()) };
        assert_eq!(over.unit, "mm");
        assert!((over.curves[0].1[2].0 - 50.0).abs() < 1e-9, "{:?}", over.curves);
        let (chart, _) = chart(&force(0.1), Sheet::Page).expect("a force that is told");
        let drawn = chart.file();
        assert!(drawn.contains("(mm)") && drawn.contains("(N)") && !drawn.contains("SI"), "{drawn}");
    }

    #[test]
    fn nothing_is_drawn_of_a_force_that_the_records_do_not_tell() {
        assert!(chart(&force(1e3), Sheet::Page).is_none());
    }
}
