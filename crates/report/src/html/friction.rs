//! The identified part of a rate against velocity, with its band and, for synthetic data, the truth.

use super::force::{dots, middle, points as grey_dots};
use super::table::unit as unit_words;
use crate::chart::{Axis, Chart, Entry, Mark, Panel, Place, Sheet, Swatch, digits, legend};
use crate::measured_force::Parts;
use crate::run::{Resistance, resistance};
use phisindy_expr::Id;
use phisindy_learn::{Curve, Identified, PartValues, UnknownPart, unknown_parts};
use phisindy_phys::unit::{Dimension, Unit};
use phisindy_phys::{Case, Record, System};

const HIGH: f64 = 200.0;
/// Most dots of a cloud.
const DOTS: usize = 3000;

/// Units of rates and of the corresponding forces.
const FORCES: [(&str, &str); 2] = [("m/s^2", "N"), ("rad/s^2", "N*m")];

/// A chart for each state whose rate has an identified part that depends on a velocity.
pub(crate) fn charts(
    case: &Case,
    records: &[Record],
    found: &Identified,
    sheet: Sheet,
) -> Vec<(Chart, String)> {
    let scale = case.system.states.iter().any(|s| force_unit(&s.unit).is_some());
    let parts = unknown_parts(case, records, found, scale);
    let of = |part: &UnknownPart| {
        let measured = resistance(case, records, found, part);
        part_charts(case, part, measured.as_ref(), sheet)
    };
    parts.iter().flat_map(of).collect()
}

/// The unit of the force that corresponds to the rate of a state.
pub(crate) fn force_unit(state: &str) -> Option<&'static str> {
    let rate = rate(state)?;
    let of = |(unit, force): &(&str, &'static str)| {
        Unit::parse(unit).is_ok_and(|u| u.dimension == rate).then_some(*force)
    };
    FORCES.iter().find_map(of)
}

pub(crate) fn rate(state: &str) -> Option<Dimension> {
    let second = Unit::parse("s").ok()?.dimension;
    Unit::parse(state).ok().map(|u| u.dimension.div(second))
}

/// One chart per curve, so that bands do not overlap; one for a cloud.
fn part_charts(
    case: &Case,
    part: &UnknownPart,
    measured: Option<&Resistance>,
    sheet: Sheet,
) -> Vec<(Chart, String)> {
    let state = &case.system.states[part.state];
    let unit = match (part.force, force_unit(&state.unit)) {
        (true, Some(force)) => force.to_owned(),
        (false, _) => rate(&state.unit).map_or(String::new(), |d| d.to_string()),
        (true, None) => String::new(),
    };
    let unit = unit_words(&unit);
    let what = if part.force { "resisting force" } else { "resistance" };
    let velocity = case.system.graph.text(part.velocity, &case.system.names);
    let velocity_unit = velocity_unit(&case.system, part.velocity);
    let axes = Axes { unit, what, measured, state: &state.name, velocity, velocity_unit, sheet };
    match &part.values {
        PartValues::Curves(curves) => {
            let of =
                |(k, (name, curve)): (usize, &(Option<String>, Curve))| axes.curve(k, name.as_deref(), curve);
            curves.iter().enumerate().map(of).collect()
        }
        PartValues::Cloud(cloud) => vec![axes.cloud(cloud)],
    }
}

/// Part of the largest velocity that counts as low.
const LOW: f64 = 0.05;
/// A force that changes there by this part of its range is drawn once more, larger.
const CHANGES: f64 = 0.08;

/// A panel of the low positive velocities, where friction changes fast: the lower right of a friction curve
/// is empty.
fn low_speeds(panel: &Panel) -> Option<Panel> {
    let line = panel.marks.iter().find_map(|m| match m {
        Mark::Line { class: "model", points } => Some(points),
        _ => None,
    })?;
    let range = |points: &mut dyn Iterator<Item = f64>| {
        let (low, high) = points.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        (low, high, high - low)
    };
    let fastest = line.iter().map(|p| p.0).fold(0.0, f64::max);
    let slow = || line.iter().filter(|p| p.0 > 0.0 && p.0 < LOW * fastest);
    let (lowest, _, whole) = range(&mut line.iter().map(|p| p.1));
    let (low, high, part) = range(&mut slow().map(|p| p.1));
    // The corner must be free: friction at positive velocities is positive, and there is something below
    // zero.
    if slow().count() < 8 || part < CHANGES * whole || low < 0.0 || lowest > -0.2 * whole {
        return None;
    }
    let points: Vec<(f64, f64)> = slow().copied().collect();
    let x = Axis::between("", "", 0.0, LOW * fastest);
    let marks = vec![Mark::Line { class: "model", points }];
    Some(Panel {
        heading: "low speeds".to_owned(),
        x,
        y: Axis::around("", "", [low, high]),
        marks,
        labelled: true,
    })
}

/// The unit of a velocity; a difference of velocities has that of the first.
fn velocity_unit(system: &System, velocity: Id) -> String {
    let of_states = system.states.iter().map(|s| (s.node, &s.unit));
    let mut all = of_states.chain(system.inputs.iter().map(|u| (u.node, &u.unit)));
    let used = |&(node, _): &(Id, &String)| system.graph.uses(&[velocity], &[node]);
    // Curves are in SI units.
    let unit = all.find(used).and_then(|(_, unit)| Unit::parse(unit).ok());
    unit.map_or(String::new(), |unit| unit_words(&unit.dimension.to_string()))
}

struct Axes<'a> {
    unit: String,
    what: &'a str,
    measured: Option<&'a Resistance>,
    state: &'a str,
    velocity: String,
    velocity_unit: String,
    sheet: Sheet,
}

impl Axes<'_> {
    /// The panel: what was measured lies behind the marks.
    fn panel(
        &self,
        points: impl Iterator<Item = (f64, f64)> + Clone,
        mut marks: Vec<Mark>,
        name: Option<&str>,
    ) -> Panel {
        let x = Axis::around(&self.velocity, &self.velocity_unit, points.clone().map(|p| p.0));
        let measured = middle(self.measured(name).flatten());
        let y = Axis::around(self.what, &self.unit, points.map(|p| p.1).chain([0.0]).chain(measured));
        marks.splice(0..0, dots(self.measured(name), (x.ends(), y.ends()), self.sheet));
        Panel { heading: String::new(), x, y, marks, labelled: true }
    }

    fn chart(&self, number: usize, title: &str, said: &str, panel: &Panel, entries: &[Entry]) -> Chart {
        let name = match number {
            0 => format!("friction-{}", self.state),
            k => format!("friction-{}-{}", self.state, k + 1),
        };
        let sheet = self.sheet;
        let (keys, top) = legend(entries, sheet);
        let mut chart = Chart::new(&name, title, said, (sheet.width(), top + HIGH + 50.0));
        chart.draw(keys);
        let (x, width) = sheet.beside(panel.labels(HIGH));
        let place = Place { x, y: top, width, height: HIGH };
        chart.draw([panel.live(place)]);
        if let Some(inset) = low_speeds(panel) {
            chart.draw(inset.drawn(Place {
                x: place.x + 0.62 * place.width,
                y: place.y + 0.6 * place.height,
                width: 0.34 * place.width,
                height: 0.24 * place.height,
            }));
        }
        chart
    }

    fn curve(&self, number: usize, name: Option<&str>, curve: &Curve) -> (Chart, String) {
        let against_velocity = |values: &[f64]| -> Vec<(f64, f64)> {
            curve.velocity.iter().copied().zip(values.iter().copied()).collect()
        };
        let mut entries: Vec<Entry> = self.measured_entry(name).into_iter().collect();
        entries.push(("model", Swatch::Line, "identified".to_owned()));
        let mut marks = Vec::new();
        let mut points = against_velocity(&curve.value);
        if let Some(band) = &curve.band {
            let area = curve.velocity.iter().zip(band).map(|(v, (a, b))| (*v, *a, *b)).collect();
            marks.push(Mark::Band { class: "band", points: area });
            entries.push(("band", Swatch::Box, "95 % band".to_owned()));
            points.extend(curve.velocity.iter().zip(band).flat_map(|(v, (a, b))| [(*v, *a), (*v, *b)]));
        }
        marks.push(Mark::Level { class: "zero", y: 0.0 });
        marks.push(Mark::Line { class: "model", points: against_velocity(&curve.value) });
        if let Some(truth) = &curve.truth {
            marks.push(Mark::Line { class: "truth", points: against_velocity(truth) });
            entries.push(("truth", Swatch::Line, "truth".to_owned()));
            points.extend(against_velocity(truth));
        }
        let of = name.map_or(String::new(), |name| format!(", {name}"));
        let title = format!("Identified {} in the equation of {}{of}", self.what, self.state);
        let said = format!("{}{}", self.said(curve), self.grey(name));
        let panel = self.panel(points.into_iter(), marks, name);
        let chart = self.chart(number, &title, &said, &panel, &entries);
        let caption = "positive where it opposes the motion";
        (chart, format!("{title}, {caption}.{}", self.grey(name)))
    }

    /// The measured points of the records that a curve is of: of all where it has no name.
    fn measured(&self, name: Option<&str>) -> impl Iterator<Item = &Vec<(f64, f64)>> + Clone {
        let all = self.measured.iter().flat_map(|m| &m.records);
        all.filter(move |(record, points)| !points.is_empty() && name.is_none_or(|name| name == record))
            .map(|(_, points)| points)
    }

    fn measured_entry(&self, name: Option<&str>) -> Option<Entry> {
        self.parts(name).map(|parts| ("measured", Swatch::Dot, parts.name().to_owned()))
    }

    /// What the grey dots are.
    fn grey(&self, name: Option<&str>) -> String {
        let smoothed = self.measured.map_or(0.0, |m| m.smoothed);
        grey_dots(self.parts(name), smoothed)
    }

    /// What they are made of, if there are any.
    fn parts(&self, name: Option<&str>) -> Option<Parts> {
        self.measured(name).next().and(self.measured).map(|m| m.parts)
    }

    /// Values at both ends and at half the largest velocity.
    fn said(&self, curve: &Curve) -> String {
        let last = curve.velocity.len() - 1;
        let half = curve.velocity.partition_point(|v| *v < 0.5 * curve.velocity[last]).min(last);
        let value = |k: usize| {
            let band = curve
                .band
                .as_ref()
                .map_or(String::new(), |b| format!(" [{}, {}]", digits(b[k].0, 4), digits(b[k].1, 4)));
            let truth =
                curve.truth.as_ref().map_or(String::new(), |t| format!(", truth {}", digits(t[k], 4)));
            let at = format!("{} = {}", self.velocity, digits(curve.velocity[k], 2));
            format!("{}{band} at {at}{truth}", digits(curve.value[k], 4))
        };
        let unit = if self.unit.is_empty() { String::new() } else { format!(" in {}", self.unit) };
        format!(
            "Over the velocities of the records; positive where it opposes the motion. Values{unit}: {}; {}; {}.",
            value(0),
            value(half),
            value(last)
        )
    }

    fn cloud(&self, cloud: &[(String, Vec<(f64, f64)>)]) -> (Chart, String) {
        let all: Vec<(f64, f64)> = cloud.iter().flat_map(|(_, points)| points.iter().copied()).collect();
        let every = all.len().div_ceil(DOTS).max(1);
        let points: Vec<(f64, f64)> = all.iter().step_by(every).copied().collect();
        let mut entries: Vec<Entry> = self.measured_entry(None).into_iter().collect();
        entries.push(("model", Swatch::Dot, "identified, along the simulated motion".to_owned()));
        let (low, high) =
            all.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), p| (a.min(p.1), b.max(p.1)));
        let title = format!("Identified {} in the equation of {}", self.what, self.state);
        let said = format!(
            "It depends on more than {}, so it is a cloud: {} to {} {}.{}",
            self.velocity,
            digits(low, 3),
            digits(high, 3),
            self.unit,
            self.grey(None)
        );
        let marks = vec![
            Mark::Level { class: "zero", y: 0.0 },
            Mark::Dots { class: "model", points: points.clone(), radius: 1.4 },
        ];
        let panel = self.panel(points.into_iter(), marks, None);
        let chart = self.chart(0, &title, &said, &panel, &entries);
        (chart, format!("{title}. {said}"))
    }
}
