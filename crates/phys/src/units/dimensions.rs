//! Whether what a spec adds, compares and equates measures the same, and which units its coefficients have.
//!
//! Units that are written are known; a constant or state without one has an unknown dimension, the same
//! wherever it stands, and every expression says something about the unknowns ([`unknowns`]). Number literals
//! take whatever unit fits, each for itself. Should the unknowns contradict each other, then the constants
//! without a unit are taken as literals are: a spec is refused only for units that it states.

mod form;
mod quantity;
mod unknowns;
mod words;

use crate::text::diagnostic::{Diagnostic, SourceId};
use crate::text::spec::{
    ConstantSpec, CsvSpec, DataSpec, DeriveSpec, InputSpec, NoiseSpec, PlaceSpec, SensorSpec, SensorValue,
    Spec, SyntheticSpec, Text,
};
use crate::units::unit::{Dimension, Unit};
use form::Form;
use phisindy_expr::{Ast, parse, parse_with};
use quantity::{Conflict, Measure, Quantity, infer};
use std::collections::{HashMap, HashSet};
use unknowns::Unknowns;
use words::{Words, in_unit};

/// In which SI units the coefficient of a term comes out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct CoefficientUnit {
    /// Of the coefficient; None if any fits.
    pub(crate) coefficient: Option<Dimension>,
    /// Of the coefficient times the inertia, where the spec states an inertia that is not part of the term.
    pub(crate) force: Option<Dimension>,
    /// Of the work of the term on its state: inertia (if stated) times state squared.
    pub(crate) energy: Option<Dimension>,
}

/// The SI units of what a spec leaves to be found, in its order; none where any fits.
pub(crate) struct Units {
    pub(crate) coefficients: Vec<CoefficientUnit>,
    /// Of the speed of each contact.
    pub(crate) contacts: Vec<Option<Dimension>>,
    /// Of what each place is of, and of how it enters each rate.
    pub(crate) places: Vec<(Option<Dimension>, Vec<Option<Dimension>>)>,
}

/// Checks a spec in which all names are known.
///
/// # Errors
/// What does not fit.
pub(crate) fn dimensions(spec: &Spec, source: SourceId) -> Result<Units, Vec<Diagnostic>> {
    let with = |shared| {
        let mut survey = Survey::new(spec, source, shared);
        let units = survey.all();
        if survey.mistakes.is_empty() { Ok(units) } else { Err(survey.mistakes) }
    };
    with(true).or_else(|_| with(false))
}

/// What each name of a spec measures, where that follows from all that it says. The spec has been checked.
///
/// ```
/// use phisindy_phys::{SourceId, measures, spec};
/// let text = r#"(states: { "x": "m", "v": "m/s" }, constants: { "m": (1.0, "kg"), "k": 4.0 }, known: { "x": "v", "v": "-k*x/m" })"#;
/// let (spec, _) = spec::read_without_data(text, SourceId(0)).unwrap();
/// assert_eq!(measures(&spec)["k"].to_string(), "N/m");
/// ```
pub fn measures(spec: &Spec) -> HashMap<String, Dimension> {
    let mut survey = Survey::new(spec, SourceId(0), true);
    survey.all();
    let known = survey
        .names
        .iter()
        .filter_map(|(name, q)| Some(((*name).to_owned(), survey.unit(q.measure.clone())?)));
    known.collect()
}

/// The factor times the candidate of a term.
struct Product<'s> {
    state: &'s str,
    /// What the whole term measures: a rate, or the force along a speed of a mechanism.
    due: Measure,
    product: Measure,
    /// Of its state, where the spec states one.
    inertia: Option<Measure>,
    /// Whether the term itself holds that inertia, so that its coefficient is a force already.
    inside: bool,
}

/// A walk through a spec.
struct Survey<'s> {
    spec: &'s Spec,
    words: Words,
    /// Whether what has no unit has one unknown unit everywhere, or any at each place.
    shared: bool,
    unknowns: Unknowns,
    names: HashMap<&'s str, Quantity>,
    mistakes: Vec<Diagnostic>,
}

impl<'s> Survey<'s> {
    fn new(spec: &'s Spec, source: SourceId, shared: bool) -> Self {
        let (unknowns, names) = (Unknowns::default(), HashMap::new());
        Survey { spec, words: Words::new(source), shared, unknowns, names, mistakes: vec![] }
    }

    fn all(&mut self) -> Units {
        let spec = self.spec;
        // Where no state has a unit, time need not be in seconds either.
        let bare = spec.states.iter().all(|(_, unit)| unit.value.trim().is_empty());
        let time = if bare { self.declared(None) } else { Measure::Fixed(Form::known(Dimension::SECOND)) };
        self.names.insert("t", Quantity::varying(time));
        let outputs = spec.outputs.iter().map(|(name, output)| (name, &output.unit));
        for (name, unit) in spec.states.iter().chain(&spec.inputs).map(|(n, u)| (n, u)).chain(outputs) {
            let measure = self.declared(Some(unit));
            self.names.insert(&name.value, Quantity::varying(measure));
        }
        self.constants();
        for (name, text) in &spec.definitions {
            let found = self.quantity(text);
            self.names.insert(&name.value, Quantity { value: None, ..found });
        }
        self.energies();
        for (force, point) in spec.structure.iter().flat_map(|s| &s.forces) {
            self.force_at(force, point);
        }
        for (name, text) in &spec.known {
            self.rate(name, text, "its rate");
        }
        for (name, output) in &spec.outputs {
            let found = self.quantity(&output.reads).measure;
            if let Some((due, is)) = self.differ(&self.of(name), &found) {
                let missing = self.suggestion(&due, &is);
                self.mistakes.push(self.words.assigned(
                    ("output", "what it reads"),
                    name,
                    &output.reads,
                    [&due, &is],
                    missing,
                ));
            }
        }
        let contacts: Vec<Measure> = spec.contacts.iter().map(|text| self.measure(text)).collect();
        let place = |survey: &mut Self, place: &'s PlaceSpec| {
            let enters = place.enters.iter().map(|(_, text)| survey.measure(text)).collect::<Vec<Measure>>();
            (survey.measure(&place.of), enters)
        };
        let places: Vec<(Measure, Vec<Measure>)> =
            spec.places.iter().map(|(_, of)| place(self, of)).collect();
        for (name, impact) in &spec.impacts {
            self.measure(&impact.when);
            let SensorValue::Constant(text) = &impact.restitution else { continue };
            let (due, is) = (Measure::Fixed(Form::none()), self.measure(text));
            if let Some((due, is)) = self.differ(&due, &is) {
                let missing = self.suggestion(&due, &is);
                let what = ("the restitution of", "what stands here");
                self.mistakes.push(self.words.assigned(what, name, text, [&due, &is], missing));
            }
        }
        // Times the square of its speed an inertia is an energy: kg for m/s, kg*m^2 for rad/s.
        let energy = Measure::Fixed(Form::known(Dimension::NEWTON.mul(Dimension::METRE)));
        for (name, text) in &spec.inertia {
            let (due, is) = (energy.times(&self.of(name), -2.0), self.measure(text));
            if let Some((due, is)) = self.differ(&due, &is) {
                let missing = self.suggestion(&due, &is);
                let what = ("the inertia of", "what stands here");
                self.mistakes.push(self.words.assigned(what, name, text, [&due, &is], missing));
            }
        }
        let products = self.products();
        for data in &spec.data {
            match data {
                DataSpec::Csv(csv) => self.csv(csv),
                DataSpec::Synthetic(synthetic) => self.synthetic(synthetic),
            }
        }
        // Only now is known all that the spec says.
        let unit = |of: &Measure| self.unit(of.clone());
        Units {
            coefficients: products.iter().map(|product| self.coefficient(product)).collect(),
            contacts: contacts.iter().map(unit).collect(),
            places: places.iter().map(|(of, enters)| (unit(of), enters.iter().map(unit).collect())).collect(),
        }
    }

    /// The unit, where it is known.
    fn unit(&self, measure: Measure) -> Option<Dimension> {
        self.unknowns.resolved(measure.plainly()?).dimension()
    }

    /// What a declaration says; no unit means that any fits.
    fn declared(&mut self, unit: Option<&Text>) -> Measure {
        match unit.filter(|u| !u.value.trim().is_empty()).and_then(|u| Unit::parse(&u.value).ok()) {
            Some(unit) => Measure::Fixed(Form::known(unit.dimension)),
            None if self.shared => Measure::Fixed(self.unknowns.add()),
            None => Measure::Loose(None),
        }
    }

    fn constants(&mut self) {
        let spec = self.spec;
        let of_records = || spec.data.iter().flat_map(DataSpec::constants);
        let overridden: HashSet<&str> = of_records().map(|(name, _)| name.value.as_str()).collect();
        let mut pending = Vec::new();
        for (name, constant) in spec.constants.iter().chain(of_records()) {
            match constant {
                ConstantSpec::Expression(text) => pending.push((name, text)),
                _ => {
                    let value = match constant {
                        ConstantSpec::Number { value, unit } if !overridden.contains(name.value.as_str()) => {
                            let factor = unit.as_ref().and_then(|u| Unit::parse(&u.value).ok());
                            Some(value.value * factor.map_or(1.0, |u| u.factor))
                        }
                        _ => None,
                    };
                    let measure = self.stated(constant);
                    self.define(name, Quantity { value, ..Quantity::constant(measure) });
                }
            }
        }
        // Each once all that it names are done; circles were refused before.
        while let Some(k) = pending.iter().position(|(_, text)| {
            let waits = |ast: &Ast| ast.names().any(|(n, _)| pending.iter().any(|(p, _)| p.value == n));
            !parse(&text.value).as_ref().is_ok_and(waits)
        }) {
            let (name, text) = pending.remove(k);
            let found = self.quantity(text);
            let value = found.value.filter(|_| !overridden.contains(name.value.as_str()));
            self.define(name, Quantity { value, ..Quantity::constant(found.measure) });
        }
    }

    fn stated(&mut self, constant: &ConstantSpec) -> Measure {
        match constant {
            ConstantSpec::Number { unit, .. } => self.declared(unit.as_ref()),
            ConstantSpec::Movable(movable) => self.declared(movable.unit.as_ref()),
            ConstantSpec::Find(find) => self.declared(find.unit.as_ref()),
            ConstantSpec::MaxAbs(input) => {
                self.names.get(input.value.as_str()).map_or(Measure::Loose(None), |q| q.measure.clone())
            }
            ConstantSpec::Expression(_) => Measure::Loose(None),
        }
    }

    /// A constant may be defined again by each record: always in the same dimension.
    fn define(&mut self, name: &'s Text, quantity: Quantity) {
        let Some(first) = self.names.get(name.value.as_str()) else {
            self.names.insert(&name.value, quantity);
            return;
        };
        match (&first.measure, &quantity.measure) {
            (Measure::Fixed(here), Measure::Fixed(there)) if !self.unknowns.equate(here, there) => {
                self.mistakes.push(self.words.defined_otherwise(name, there, here));
                // Said once is enough.
                self.names.insert(&name.value, Quantity::constant(Measure::Loose(None)));
            }
            (Measure::Loose(_), Measure::Fixed(_)) => {
                self.names.insert(&name.value, quantity);
            }
            _ => {}
        }
    }

    /// The rate of a state, per second.
    fn rate_of(&self, state: &str) -> Measure {
        let second = Measure::Fixed(Form::known(Dimension::SECOND));
        self.names.get(state).map_or(Measure::Loose(None), |q| q.measure.times(&second, -1.0))
    }

    fn rate(&mut self, state: &Text, text: &Text, what: &str) {
        let found = self.measure(text);
        if let Some((due, is)) = self.differ(&self.rate_of(&state.value), &found) {
            let declared = self.spec.states.iter().find(|(name, _)| name.value == state.value);
            let missing = self.suggestion(&due, &is);
            let unit = declared.map(|(_, unit)| unit);
            self.mistakes.push(self.words.rate(state, unit, text, what, [&due, &is], missing));
        }
    }

    /// All energies are of one kind, what is lost in a second too, and a force times its speed.
    fn energies(&mut self) {
        let Some(energy) = &self.spec.energy else { return };
        let kinetic = self.plain(&energy.kinetic);
        let power = kinetic.times(&Measure::Fixed(Form::known(Dimension::SECOND)), -1.0);
        let like = |survey: &mut Self, what: &str, due: &Measure, text: &Text, is: Measure| {
            if let Some((due, is)) = survey.differ(due, &is) {
                let missing = survey.suggestion(&due, &is);
                survey.mistakes.push(survey.words.energy(what, text, [&due, &is], missing));
            }
        };
        for (what, due, text) in
            [("potential", &kinetic, &energy.potential), ("dissipation", &power, &energy.dissipation)]
        {
            let Some(text) = text else { continue };
            let is = self.plain(text);
            like(self, what, due, text, is);
        }
        for (force, along) in &energy.forces {
            let is = self.plain(force).times(&self.plain(along), 1.0);
            like(self, "a force times its speed", &power, force, is);
        }
    }

    /// A force at a point, or along a speed, of a structure.
    fn force_at(&mut self, force: &'s Text, at: &'s Text) {
        let Some(structure) = &self.spec.structure else { return };
        let speed = format!("{}_{}_speed", structure.coordinates.value, at.value);
        let watt =
            Measure::Fixed(Form::known(Dimension::NEWTON.mul(Dimension::METRE).div(Dimension::SECOND)));
        let along = match self.names.get(speed.as_str()).map(|q| q.measure.clone()) {
            Some(measure) => measure,
            None => self.plain(at),
        };
        let (due, is) = (watt.times(&along, -1.0), self.plain(force));
        if let Some((due, is)) = self.differ(&due, &is) {
            let missing = self.suggestion(&due, &is);
            let mistake = self.words.energy("a force at a point", force, [&due, &is], missing);
            self.mistakes.push(mistake);
        }
    }

    /// What an expression measures if its literals are numbers without a unit: the half of a kinetic energy is one.
    fn plain(&mut self, text: &Text) -> Measure {
        let found = self.measure(text);
        found.plainly().map_or(Measure::Loose(None), |form| Measure::Fixed(form.clone()))
    }

    /// The force along a speed of a mechanism; the rate of another state.
    fn due_along(&mut self, state: &str) -> Measure {
        match self.spec.energy.as_ref().filter(|_| self.spec.is_moved(state)) {
            Some(energy) => {
                let said = self.mistakes.len();
                let work = self.plain(&energy.kinetic);
                self.mistakes.truncate(said);
                let second = Measure::Fixed(Form::known(Dimension::SECOND));
                let speed = self.names.get(state).map_or(Measure::Loose(None), |q| q.measure.clone());
                work.times(&speed.times(&second, 1.0), -1.0)
            }
            // Work over the displacement of a point.
            None if self.spec.is_moved(state) => {
                let work = Measure::Fixed(Form::known(Dimension::NEWTON.mul(Dimension::METRE)));
                let second = Measure::Fixed(Form::known(Dimension::SECOND));
                let speed = self.names.get(state).map_or(Measure::Loose(None), |q| q.measure.clone());
                work.times(&speed.times(&second, 1.0), -1.0)
            }
            None => self.rate_of(state),
        }
    }

    fn products(&mut self) -> Vec<Product<'s>> {
        let spec = self.spec;
        let mut products = Vec::new();
        for (name, unknown) in &spec.unknown {
            let factor = unknown.factor.as_ref().map_or(Measure::number(), |text| self.measure(text));
            let inertia = spec.inertia.iter().find(|(n, _)| n.value == name.value).map(|(_, text)| text);
            // Said once already, if something is wrong with it.
            let moved = spec.is_moved(&name.value);
            let measured = match inertia {
                Some(text) => Some(self.quietly(text)),
                None => moved.then(|| self.due_along(&name.value).times(&self.rate_of(&name.value), -1.0)),
            };
            for candidate in &unknown.candidates {
                let inside = moved
                    || inertia.is_some_and(|inertia| {
                        let own = names(inertia);
                        let term = unknown.factor.iter().chain([candidate]).flat_map(names);
                        own.is_empty() || term.into_iter().any(|name| own.contains(&name))
                    });
                let product = factor.times(&self.measure(candidate), 1.0);
                let due = self.due_along(&name.value);
                products.push(Product {
                    state: &name.value,
                    due,
                    product,
                    inertia: measured.clone(),
                    inside,
                });
            }
        }
        products
    }

    fn coefficient(&self, term: &Product<'_>) -> CoefficientUnit {
        let unit = |measure: Measure| self.unit(measure);
        let coefficient = term.due.times(&term.product, -1.0);
        let outside = term.inertia.as_ref().filter(|_| !term.inside);
        let force = outside.and_then(|inertia| unit(coefficient.times(inertia, 1.0)));
        let state = self.names.get(term.state).map_or(Measure::Loose(None), |q| q.measure.clone());
        let square = state.times(&state, 1.0);
        let energy = unit(term.inertia.as_ref().map_or(square.clone(), |m| square.times(m, 1.0)));
        CoefficientUnit { coefficient: unit(coefficient), force, energy }
    }

    fn csv(&mut self, csv: &'s CsvSpec) {
        self.derived(&csv.derive);
        self.sensors(&csv.sensors);
    }

    fn synthetic(&mut self, data: &'s SyntheticSpec) {
        for (state, text) in &data.truth {
            if !self.spec.is_moved(&state.value) {
                self.rate(state, text, "the truth's part of it");
                continue;
            }
            let (due, is) = (self.due_along(&state.value), self.measure(text));
            if let Some((due, is)) = self.differ(&due, &is) {
                let missing = self.suggestion(&due, &is);
                let what = ("the force along", "the truth's part of it");
                self.mistakes.push(self.words.assigned(what, state, text, [&due, &is], missing));
            }
        }
        self.derived(&data.derive);
        for (name, input) in &data.inputs {
            if let InputSpec::Formula(text) = input {
                let found = self.measure(text);
                if let Some((due, is)) = self.differ(&self.of(name), &found) {
                    let missing = self.suggestion(&due, &is);
                    self.mistakes.push(self.words.assigned(
                        ("input", "its formula"),
                        name,
                        text,
                        [&due, &is],
                        missing,
                    ));
                }
            }
        }
        self.sensors(&data.sensors);
        if let NoiseSpec::Sensor(columns) = &data.noise {
            for (name, (_, unit)) in columns {
                self.stated_as(&format!("the noise of `{}`", name.value), self.of(name), unit.as_ref());
            }
        }
    }

    fn of(&self, name: &Text) -> Measure {
        self.names.get(name.value.as_str()).map_or(Measure::Loose(None), |q| q.measure.clone())
    }

    fn derived(&mut self, derive: &'s [(Text, DeriveSpec)]) {
        for (name, DeriveSpec::Derivative(of, _)) in derive {
            if let Some((due, is)) = self.differ(&self.rate_of(&of.value), &self.of(name)) {
                let declared = self.spec.inputs.iter().find(|(n, _)| n.value == name.value).map(|(_, u)| u);
                self.mistakes.push(self.words.derivative(name, of, declared, [&due, &is]));
            }
        }
    }

    fn sensors(&mut self, sensors: &'s [(Text, SensorSpec)]) {
        let plain = Measure::Fixed(Form::none());
        let second = Measure::Fixed(Form::known(Dimension::SECOND));
        for (name, sensor) in sensors {
            let values = [
                ("offset", self.of(name), &sensor.offset),
                ("delay", second.clone(), &sensor.delay),
                ("gain", plain.clone(), &sensor.gain),
                ("clock", plain.clone(), &sensor.clock),
                ("lag", second.clone(), &sensor.lag),
            ];
            for (what, due, value) in values {
                let what = format!("the {what} of `{}`", name.value);
                match value {
                    Some(SensorValue::Find(find)) => self.stated_as(&what, due, find.unit.as_ref()),
                    Some(SensorValue::Constant(constant)) => self.named_as(&what, due, constant),
                    _ => {}
                }
            }
            for filter in sensor.lowpass.iter().chain(&sensor.highpass) {
                // The units of other cutoffs are looked at where they are read.
                if let SensorValue::Constant(constant) = &filter.cutoff.0 {
                    self.cutoff(constant);
                }
            }
        }
    }

    /// A constant that stands where only one dimension has a meaning.
    fn named_as(&mut self, what: &str, due: Measure, constant: &Text) {
        if let Some((due, is)) = self.differ(&due, &self.of(constant)) {
            self.mistakes.push(self.words.named(what, constant, [&due, &is]));
        }
    }

    /// A constant that is a cutoff: `rad/s` has the dimension of Hz and is another frequency.
    fn cutoff(&mut self, constant: &Text) {
        let own = self.spec.constants.iter().find(|(name, _)| name.value == constant.value);
        let unit = own.and_then(|(_, own)| own.unit()).map(|unit| unit.value.trim());
        let second = Measure::Fixed(Form::known(Dimension::SECOND));
        let is = match self.differ(&Measure::Fixed(Form::none()).times(&second, -1.0), &self.of(constant)) {
            Some((_, is)) => in_unit(&is),
            None => match unit.filter(|unit| !unit.is_empty() && !unit.ends_with("Hz")) {
                Some(unit) => format!("in {unit}"),
                None => return,
            },
        };
        self.mistakes.push(self.words.cutoff(constant, &is));
    }

    /// A unit that is written where only one dimension has a meaning.
    fn stated_as(&mut self, what: &str, due: Measure, unit: Option<&Text>) {
        let Some(unit) = unit else { return };
        let is = self.declared(Some(unit));
        if let Some((due, is)) = self.differ(&due, &is) {
            self.mistakes.push(self.words.unit(what, unit, [&due, &is]));
        }
    }

    /// Both dimensions, if they cannot be the same.
    fn differ(&mut self, due: &Measure, is: &Measure) -> Option<(Form, Form)> {
        match (due, is) {
            (Measure::Fixed(due), Measure::Fixed(is)) if !self.unknowns.equate(due, is) => {
                Some((due.clone(), is.clone()))
            }
            _ => None,
        }
    }

    fn measure(&mut self, text: &Text) -> Measure {
        self.quantity(text).measure
    }

    fn quietly(&mut self, text: &Text) -> Measure {
        let said = self.mistakes.len();
        let measure = self.measure(text);
        self.mistakes.truncate(said);
        measure
    }

    /// What an expression measures; its own mistakes are noted.
    fn quantity(&mut self, text: &Text) -> Quantity {
        let Ok(ast) = parse_with(&text.value, &["rate"]) else {
            return Quantity::varying(Measure::Loose(None));
        };
        let mut conflicts = Vec::new();
        let names = &self.names;
        let second = Measure::Fixed(Form::known(Dimension::SECOND));
        let rate = |name: &str| {
            let state = names.get(name.strip_prefix("rate ")?)?;
            Some(Quantity::varying(state.measure.times(&second, -1.0)))
        };
        let of = |name: &str| names.get(name).cloned().or_else(|| rate(name));
        let time = names.get("t").map_or(second.clone(), |t| t.measure.clone());
        let files = &self.spec.files;
        // A column without a unit takes whatever fits.
        let column = |path: &str, k: usize| {
            let unit = files.numbers(path, None).and_then(|table| table.headings.get(k)?.1.clone());
            let unit = unit.and_then(|unit| Unit::parse(&unit).ok());
            unit.map_or(Measure::Loose(None), |unit| Measure::Fixed(Form::known(unit.dimension)))
        };
        let tables = |path: &str| [0, 1].map(|k| column(path, k));
        let found = infer(&ast, of, (&time, &tables), &mut self.unknowns, &mut conflicts);
        for conflict in conflicts {
            let missing = match &conflict {
                Conflict::Operands { left: (_, due), right: (_, is), .. } => self.suggestion(due, is),
                Conflict::Table { due, form, .. } => self.suggestion(due, form),
                Conflict::Argument { form, .. }
                | Conflict::Time { form, .. }
                | Conflict::Exponent { form, .. }
                | Conflict::Base { form, .. } => self.suggestion(&Form::none(), form),
            };
            self.mistakes.push(self.words.conflict(text.span, &conflict, missing));
        }
        found
    }

    /// Constants that would make up for the difference: a factor `W`, a division by `m`.
    fn suggestion(&self, due: &Form, is: &Form) -> Option<String> {
        let missing = due.over(is);
        let like = |form: &Form| {
            let own = |name: &str| match self.names.get(name).map(|q| &q.measure) {
                Some(Measure::Fixed(own)) => own.over(form).is_none(),
                _ => false,
            };
            let constants = self.spec.constants.iter().filter(|(name, _)| own(&name.value));
            let few: Vec<String> = constants.map(|(name, _)| format!("`{}`", name.value)).take(3).collect();
            (!few.is_empty()).then(|| few.join(" or "))
        };
        let factor = like(&missing).map(|names| format!("a factor {names}"));
        factor.or_else(|| like(&missing.pow(-1.0)).map(|names| format!("a division by {names}")))
    }
}

fn names(text: &Text) -> HashSet<String> {
    parse(&text.value).map(|ast| ast.names().map(|(name, _)| name.to_owned()).collect()).unwrap_or_default()
}

#[cfg(test)]
mod tests;
