//! The variables of a functional mock-up unit. Their references count through the kinds in the order in which
//! `runtime/fmu.c` knows them.

use crate::export::subject::{Quantity, Subject};

/// What a variable is to an importer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Time,
    State,
    /// The rate of the state of this index.
    Rate(usize),
    Input,
    /// The rate of change of an input.
    Slope,
    Output,
    Parameter,
    Indicator,
    /// The mode of a contact, an integer.
    Mode,
}

/// One variable; its reference is its place.
#[derive(Clone, Debug)]
pub(super) struct Variable {
    pub(super) kind: Kind,
    pub(super) name: String,
    /// In words.
    pub(super) about: String,
    /// SI; empty if the spec states none.
    pub(super) unit: String,
    /// The value at the start, of what has one.
    pub(super) start: Option<f64>,
    /// The size of a state.
    pub(super) nominal: Option<f64>,
}

/// All variables of a model.
pub(super) struct Variables {
    pub(super) all: Vec<Variable>,
    /// The start state.
    pub(super) start: Vec<f64>,
    /// The size of each state.
    pub(super) nominal: Vec<f64>,
}

impl Variables {
    /// Those of a model, in the order of their references.
    pub(super) fn new(subject: &Subject) -> Variables {
        let (start, nominal) = start_and_sizes(subject);
        let plain = |kind, name: String, about: String, unit: &str| Variable {
            kind,
            name,
            about,
            unit: unit.to_owned(),
            start: None,
            nominal: None,
        };
        let of = |kind, q: &Quantity, about: &str| plain(kind, q.name.clone(), about.to_owned(), &q.unit);
        let rate = |q: &Quantity| (format!("der({})", q.name), per_second(&q.unit));
        let mut all = vec![plain(Kind::Time, "t".to_owned(), "Time".to_owned(), "s")];
        all.extend(subject.states.iter().enumerate().map(|(k, q)| Variable {
            start: Some(start[k]),
            nominal: Some(nominal[k]),
            ..of(Kind::State, q, "State")
        }));
        all.extend(subject.states.iter().enumerate().map(|(k, q)| {
            let (name, unit) = rate(q);
            plain(Kind::Rate(k), name, format!("Rate of {}", q.name), &unit)
        }));
        all.extend(
            subject.inputs.iter().map(|q| Variable { start: Some(0.0), ..of(Kind::Input, q, "Input") }),
        );
        all.extend(subject.inputs.iter().map(|q| {
            let (name, unit) = rate(q);
            let about = format!(
                "Rate of {}: matters where something sticks to what it moves; in co-simulation the input goes on by it within a step",
                q.name
            );
            Variable { start: Some(0.0), ..plain(Kind::Slope, name, about, &unit) }
        }));
        all.extend(subject.outputs.iter().map(|q| of(Kind::Output, q, "What a sensor reads")));
        all.extend(subject.constants.iter().map(|c| Variable {
            start: Some(c.value),
            ..plain(Kind::Parameter, c.name.clone(), "Constant".to_owned(), &c.unit)
        }));
        let contacts = &subject.switched.switches;
        all.extend(contacts.iter().map(|s| {
            let about = format!("Positive while the mode of {} may last", s.text);
            plain(Kind::Indicator, format!("indicator({})", s.text), about, "")
        }));
        all.extend(contacts.iter().map(|s| {
            let about = format!("Mode of {}: 1 slips forward, -1 backward, 0 sticks", s.text);
            plain(Kind::Mode, format!("mode({})", s.text), about, "")
        }));
        Variables { all, start, nominal }
    }

    /// References and variables of some kinds.
    pub(super) fn of(&self, wanted: impl Fn(Kind) -> bool) -> impl Iterator<Item = (usize, &Variable)> {
        self.all.iter().enumerate().filter(move |(_, v)| wanted(v.kind))
    }

    /// All names, in order.
    pub(super) fn names(&self) -> String {
        self.all.iter().map(|v| format!("{} [{}]\n", v.name, v.unit)).collect()
    }
}

/// The start state, and the size of each state: the largest value in the record where that is known, else the
/// size of its start value, else 1.
fn start_and_sizes(subject: &Subject) -> (Vec<f64>, Vec<f64>) {
    let note = subject.chosen();
    let known = subject.experiment.as_ref();
    // The first sample is what a sensor read.
    let first = |k: usize, read: f64| {
        let sensor = note.sensors.iter().find(|(column, _)| *column == subject.states[k].name);
        sensor.map_or(read, |(_, s)| (read - s.offset.start) / s.gain.start)
    };
    let start: Vec<f64> = (note.start.iter().enumerate())
        .map(|(k, x)| x.or(known.map(|e| first(k, e.first[k]))).filter(|x| x.is_finite()).unwrap_or(0.0))
        .collect();
    let size = |k: usize| known.map_or(start[k].abs(), |e| e.sizes[k]);
    let usable = |x: f64| if x.is_finite() && x > 0.0 { x } else { 1.0 };
    let nominal = (0..start.len()).map(|k| usable(size(k))).collect();
    (start, nominal)
}

/// The unit of a rate of change.
fn per_second(unit: &str) -> String {
    match unit {
        "" => String::new(),
        "rad" => "rad/s".to_owned(),
        "rad/s" => "rad/s^2".to_owned(),
        _ => match phisindy_phys::unit::Unit::parse(&format!("({unit})/s")) {
            Ok(parsed) if parsed.factor == 1.0 => parsed.dimension.to_string(),
            _ => format!("({unit})/s"),
        },
    }
}
