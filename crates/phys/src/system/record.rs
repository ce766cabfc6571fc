//! A record: sampled data of one run, in SI, checked against the system.

use crate::system::constants::Value;
use crate::system::equations::System;
use crate::system::measured::Measured;
use crate::system::note::Note;
use crate::system::own_times::OwnTimes;
use crate::system::plan::{Origin, RecordPlan};
use crate::system::sensor::Sensor;
use crate::system::table::{Table, enough, finer};
use crate::text::diagnostic::{Diagnostic, SourceId};
use crate::text::spec::{ColumnSpec, CsvSpec, Role, Text};
use crate::units::unit::Unit;
use phisindy_signal::{
    Differentiated, Differentiator, Interpolation, Signal, SignalError, differentiate, mean_step,
    noise_level_at, rounding_error, standard_deviation,
};
use std::borrow::Cow;
use std::fmt;
use std::ops::Range;
use std::sync::Arc;

/// One run as it was sampled.
#[derive(Clone, Debug)]
pub struct Record {
    /// Shown to the user.
    pub name: String,
    /// Fitted or only predicted.
    pub role: Role,
    /// Seconds, strictly increasing.
    pub time: Arc<[f64]>,
    /// Samples of each state, then of each output (SI); `None` without a column. A column with times of its own holds
    /// what lies on straight lines where it has no sample.
    pub columns: Vec<Option<Vec<f64>>>,
    /// Which samples each column has.
    pub own_times: OwnTimes,
    /// For each input, as a function of time (SI); its samples may have times of their own.
    pub inputs: Vec<Signal>,
    /// One number for each of [`System::record_constants`].
    pub constants: Vec<f64>,
    /// One for each state, then each output, then each input.
    pub sensors: Vec<Sensor>,
    /// Start values that the spec states.
    pub start: Vec<Option<f64>>,
    /// The size of each state that no column shows, as far as the outputs tell it; empty where they do not.
    pub sizes: Vec<f64>,
    /// Index of the record whose run this one continues.
    pub continues: Option<usize>,
    /// The inputs that were derived from measured ones.
    pub derivations: Vec<Derivation>,
    /// What was done to the data.
    pub notes: Vec<Note>,
}

/// Times and values of a column, as they were sampled.
pub type OwnColumn<'a> = (Cow<'a, [f64]>, Cow<'a, [f64]>);

/// An input that was derived from a measured one.
#[derive(Clone, Debug)]
pub struct Derivation {
    /// The input.
    pub input: usize,
    /// What it is the derivative of.
    pub of: usize,
    /// The samples of that one, before they were smoothed (SI), at the times of its signal.
    pub column: Vec<f64>,
}

/// The units in which a file holds the columns of a record.
#[derive(Clone, Debug, PartialEq)]
pub struct Units {
    /// Of the time.
    pub time: Unit,
    /// Of the columns of `CsvSpec::columns`, in that order.
    pub columns: Vec<Unit>,
}

impl Units {
    /// As the record states them. A column without a unit has that of its state, output or input.
    pub fn of(csv: &CsvSpec, system: &System) -> Units {
        let own: Vec<_> = system.quantities().collect();
        // The check refuses texts that are no unit.
        let unit = |text: &str| Unit::parse(text).unwrap_or(Unit::ONE);
        let column = |(name, column): &(Text, ColumnSpec)| match &column.unit {
            Some(stated) => unit(&stated.value),
            None => own.iter().find(|(n, _)| *n == name.value).map_or(Unit::ONE, |(_, own)| unit(own)),
        };
        Units {
            time: csv.time.unit.as_ref().map_or(Unit::ONE, |stated| unit(&stated.value)),
            columns: csv.columns.iter().map(column).collect(),
        }
    }
}

impl Record {
    /// Number of samples.
    pub fn len(&self) -> usize {
        self.time.len()
    }

    /// Whether there are no samples.
    pub fn is_empty(&self) -> bool {
        self.time.is_empty()
    }

    /// The arguments of a system's expressions at a sample, in the order of [`crate::System::arguments`]. The
    /// caller gives states and parameters.
    pub fn arguments_at<'a>(
        &'a self,
        sample: usize,
        states: impl Iterator<Item = f64> + 'a,
        parameters: &'a [f64],
    ) -> impl Iterator<Item = f64> + 'a {
        let inputs = (0..self.inputs.len()).map(move |k| self.input_at(k, sample));
        let rest = parameters.iter().chain(&self.constants).copied();
        [self.time[sample]].into_iter().chain(states).chain(inputs).chain(rest)
    }

    /// An input at the time of a sample.
    pub fn input_at(&self, input: usize, sample: usize) -> f64 {
        let signal = &self.inputs[input];
        if Arc::ptr_eq(signal.time(), &self.time) {
            return signal.values()[sample];
        }
        signal.value(self.time[sample])
    }

    /// An input at the times of the samples.
    pub fn input_samples(&self, input: usize) -> Cow<'_, [f64]> {
        let signal = &self.inputs[input];
        if Arc::ptr_eq(signal.time(), &self.time) {
            return Cow::Borrowed(signal.values());
        }
        let mut near = 0;
        self.time.iter().map(|&t| signal.value_and_slope(t, &mut near).0).collect()
    }

    /// Times and values of a column, as they were sampled.
    pub fn own_column(&self, column: usize) -> Option<OwnColumn<'_>> {
        let values = self.columns.get(column)?.as_deref()?;
        Some((self.own_times.of(column, &self.time), self.own_times.of(column, values)))
    }

    /// A column smoothed, with its derivative, at all times of the record.
    ///
    /// # Errors
    /// It has too few samples.
    pub fn differentiated(
        &self,
        column: usize,
        how: Differentiator,
    ) -> Option<Result<Differentiated, SignalError>> {
        let (time, values) = self.own_column(column)?;
        let everywhere = |own: Vec<f64>| -> Result<Vec<f64>, SignalError> {
            if self.own_times.all(column) {
                return Ok(own);
            }
            let between = Signal::new(time.as_ref().into(), own, Interpolation::Cubic)?;
            let mut near = 0;
            Ok(self.time.iter().map(|&t| between.value_and_slope(t, &mut near).0).collect())
        };
        let of = |d: Differentiated| -> Result<Differentiated, SignalError> {
            Ok(Differentiated { values: everywhere(d.values)?, derivative: everywhere(d.derivative)?, ..d })
        };
        Some(differentiate(&time, &values, how).and_then(of))
    }

    /// The noise of a column, by its own samples; 0 without a column. See [`noise_level_at`].
    pub fn noise_level(&self, column: usize) -> f64 {
        self.own_column(column).map_or(0.0, |(time, values)| noise_level_at(&time, &values))
    }

    /// Standard deviation of the rounding of a column, by the step that its sensor states or that it shows; 0
    /// without a column.
    pub fn rounding(&self, column: usize) -> f64 {
        let Some((_, values)) = self.own_column(column) else { return 0.0 };
        let stated = self.sensors[column].quantum.map(|step| step / f64::sqrt(12.0));
        stated.unwrap_or_else(|| rounding_error(&values))
    }

    /// The mean time between the samples of a column.
    pub fn step(&self, column: usize) -> f64 {
        mean_step(&self.own_times.of(column, &self.time))
    }

    /// The standard deviation of a column, by its own samples; 0 without a column.
    pub fn deviation(&self, column: usize) -> f64 {
        self.own_column(column).map_or(0.0, |(_, values)| standard_deviation(&values))
    }

    /// Number of measured values: samples of all columns of states and outputs.
    pub fn readings(&self) -> usize {
        self.readings_of(0..self.len())
    }

    /// Number of measured values among some samples.
    pub fn readings_of(&self, samples: Range<usize>) -> usize {
        let measured = (0..self.columns.len()).filter(|&k| self.columns[k].is_some());
        measured.map(|k| self.own_times.count(k, samples.clone())).sum()
    }

    /// Some samples of the record. It continues no other one, and starts as the spec states if these are its first.
    ///
    /// # Panics
    /// The record is shorter.
    pub fn within(&self, samples: Range<usize>) -> Record {
        let of = |column: &Option<Vec<f64>>| column.as_ref().map(|c| c[samples.clone()].to_vec());
        let start = if samples.start == 0 { self.start.clone() } else { vec![None; self.start.len()] };
        Record {
            columns: self.columns.iter().map(of).collect(),
            own_times: self.own_times.within(samples.clone()),
            time: self.time[samples].into(),
            continues: None,
            start,
            ..self.clone()
        }
    }

    /// Builds a record from the rows of a file, with derived inputs.
    ///
    /// # Errors
    /// Diagnostics that point into the spec (a window outside the data, too few samples).
    pub fn from_table(
        plan: &RecordPlan,
        table: &Table,
        system: &System,
        spec: SourceId,
    ) -> Result<Record, Vec<Diagnostic>> {
        let Origin::Csv(csv) = &plan.origin else {
            return Err(vec![Diagnostic::error("a synthetic record has no file")]);
        };
        enough(csv, table, spec).map_err(|d| vec![d])?;
        finer(csv, table, plan, system, spec).map_err(|d| vec![d])?;
        let time: Arc<[f64]> = table.time.as_slice().into();
        let column = |name: &str| -> Option<Vec<f64>> {
            let k = csv.columns.iter().position(|(n, _)| n.value == name)?;
            Some(table.columns[k].clone())
        };
        let own =
            |(k, (name, _)): (usize, (&str, &str))| column(name).filter(|_| system.column(name) == Some(k));
        let columns = system.quantities().take(system.columns()).enumerate().map(own).collect();
        let place = |(k, (name, _)): (usize, (&str, &str))| {
            csv.columns.iter().position(|(n, _)| n.value == name && system.column(name) == Some(k))
        };
        let own_times = table.own_times.at(system.quantities().take(system.columns()).enumerate().map(place));
        let since = table.extent.map_or(0.0, |(first, _)| first);
        let sensors: Vec<Sensor> = plan.sensors.iter().map(|s| Sensor { since, ..s.clone() }).collect();
        let mut raw = Vec::new();
        for (k, input) in system.inputs.iter().enumerate() {
            let sensor = &sensors[system.columns() + k];
            let place = csv.columns.iter().position(|(n, _)| n.value == input.name);
            raw.push(place.map(|place| Measured::of(table, place, &time).corrected(sensor)));
        }
        let (mut notes, mut derivations) = (Vec::new(), Vec::new());
        for (k, of) in plan.derived.iter().enumerate().filter_map(|(k, of)| of.map(|of| (k, of))) {
            if let (None, Some(source)) = (&raw[k], &raw[of]) {
                let how = plan.differentiators[k];
                let (smooth, slope, smoothing) = source.differentiated(how).map_err(|d| vec![d])?;
                let (input, of_name) = (system.inputs[k].name.clone(), system.inputs[of].name.clone());
                notes.push(Note::DerivedInput { input, of: of_name, smoothing });
                let column = raw[of].replace(smooth).map_or_else(Vec::new, |source| source.values);
                derivations.push(Derivation { input: k, of, column });
                raw[k] = Some(slope);
            }
        }
        let mut inputs = Vec::new();
        for (k, measured) in raw.into_iter().enumerate() {
            let name = &system.inputs[k].name;
            let measured =
                measured.ok_or_else(|| vec![Diagnostic::error(format!("input `{name}` has no data"))])?;
            inputs.push(measured.signal(plan.interpolation[k]).map_err(|e| vec![no_signal(name, &e)])?);
        }
        let constants = plan.constants.iter().filter_map(Value::number).collect();
        Ok(Record {
            name: plan.name.clone(),
            role: plan.role,
            time,
            columns,
            own_times,
            inputs,
            constants,
            sensors,
            start: plan.start.clone(),
            continues: None,
            sizes: vec![],
            derivations,
            notes,
        })
    }

    /// The record with its derived inputs computed by another differentiator; `None` if that fails.
    pub fn rederived(&self, how: Differentiator) -> Option<Record> {
        let mut out = self.clone();
        for Derivation { input, of, column } in &self.derivations {
            let time = self.inputs[*of].time();
            let d = differentiate(time, column, how).ok()?;
            for (k, values) in [(*input, d.derivative), (*of, d.values)] {
                out.inputs[k] = Signal::new(time.clone(), values, self.inputs[k].kind()).ok()?;
            }
        }
        Some(out)
    }

    /// Gives each velocity without a column the derivative of its measured displacement; method `step` needs
    /// samples of every state. Returns what was done.
    ///
    /// # Errors
    /// The names of the states that remain without samples.
    pub fn fill_velocities(
        &mut self,
        system: &System,
        how: Differentiator,
    ) -> Result<Vec<Note>, Vec<String>> {
        let mut done = Vec::new();
        for (k, state) in system.states.iter().enumerate() {
            let Some(v) = state.velocity.filter(|_| self.columns[k].is_some()) else { continue };
            if self.columns[v].is_none()
                && let Some(Ok(d)) = self.differentiated(k, how)
            {
                let (velocity, displacement) = (system.states[v].name.clone(), state.name.clone());
                done.push(Note::DerivedVelocity { velocity, displacement, smoothing: d.smoothing });
                self.columns[v] = Some(d.derivative);
                self.columns[k] = Some(d.values);
            }
        }
        let missing = |k: &usize| self.columns[*k].is_none();
        let missing: Vec<String> =
            (0..system.states.len()).filter(missing).map(|k| system.states[k].name.clone()).collect();
        if missing.is_empty() { Ok(done) } else { Err(missing) }
    }
}

fn no_signal(input: &str, error: &SignalError) -> Diagnostic {
    Diagnostic::error(format!("input `{input}`: {error}"))
}

/// Whether two records show the same run of the same file, whatever their windows: the same rows, and a state
/// that both read from the same column. A file may hold one experiment beside the other, in columns.
fn same_run(a: &CsvSpec, b: &CsvSpec, system: &System) -> bool {
    let rows = |csv: &'_ CsvSpec| -> Vec<(String, f64)> {
        csv.rows.iter().map(|(name, value)| (name.value.clone(), value.value)).collect()
    };
    let run = |csv: &CsvSpec| csv.run.as_ref().map(|run| run.value);
    let sheet = |csv: &CsvSpec| csv.sheet.as_ref().map(|sheet| sheet.value.clone());
    let column = |csv: &'_ CsvSpec, state: &str| -> Option<(String, String)> {
        let (_, column) = csv.columns.iter().find(|(name, _)| name.value == state)?;
        let stream = csv.streams.iter().find(|stream| stream.name.value == state);
        let file = stream.and_then(|stream| stream.path.as_ref()).unwrap_or(&csv.path);
        Some((file.value.clone(), column.header.value.clone()))
    };
    let shared = |name: &String| column(a, name).is_some_and(|own| column(b, name) == Some(own));
    // The origin of arrays in memory is not known.
    !a.in_memory
        && system.quantities().take(system.columns()).any(|(name, _)| shared(&name.to_owned()))
        && sheet(a) == sheet(b)
        && rows(a) == rows(b)
        && run(a) == run(b)
}

/// A Validate record that holds samples of a Fit record: there it is no independent check.
#[derive(Clone, Debug, PartialEq)]
pub struct Overlap {
    /// The Validate record, as a message names it.
    pub validate: String,
    /// The Fit record.
    pub fit: String,
    /// The samples of the Validate record that both show.
    pub shared: usize,
    /// All samples of the Validate record.
    pub samples: usize,
    /// First and last time that both show, in seconds.
    pub from_to: (f64, f64),
}

impl fmt::Display for Overlap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Overlap { validate, fit, shared, samples, from_to: (begin, end) } = self;
        write!(
            f,
            "{validate} should be validated on, and {shared} of its {samples} samples are fitted: from {begin} s to {end} s it shows \
             what {fit} shows, so it is no independent check there"
        )
    }
}

/// Validate records that hold samples of a Fit record.
pub fn overlaps(system: &System, records: &[Record], plans: &[RecordPlan]) -> Vec<Overlap> {
    let mut all = Vec::new();
    let name = |k: usize| {
        let alone = records.iter().filter(|r| r.name == records[k].name).count() == 1;
        if alone { format!("`{}`", records[k].name) } else { format!("record {k} (`{}`)", records[k].name) }
    };
    for (v, validate) in records.iter().enumerate().filter(|(_, r)| r.role == Role::Validate) {
        for (f, fit) in records.iter().enumerate().filter(|(_, r)| r.role == Role::Fit) {
            let (Origin::Csv(a), Origin::Csv(b)) = (&plans[v].origin, &plans[f].origin) else { continue };
            let begin = validate.time[0].max(fit.time[0]);
            let end = validate.time[validate.len() - 1].min(fit.time[fit.len() - 1]);
            let shared = validate.time.iter().filter(|t| (begin..=end).contains(t)).count();
            // Windows that touch share the sample between them.
            if same_run(a, b, system) && shared > 2 {
                let (validate, samples, fit) = (name(v), validate.len(), name(f));
                all.push(Overlap { validate, fit, shared, samples, from_to: (begin, end) });
            }
        }
    }
    all
}

/// Marks Validate windows that continue a Fit window of the same file. Their start state is the end of that
/// run.
pub fn link_continuations(system: &System, records: &mut [Record], plans: &[RecordPlan]) {
    for k in 0..records.len() {
        let before = (0..k).rev().find(|&j| {
            let (Origin::Csv(a), Origin::Csv(b)) = (&plans[j].origin, &plans[k].origin) else { return false };
            let gap = records[k].time[0] - records[j].time[records[j].len() - 1];
            same_run(a, b, system) && gap.abs() <= 2.5 * mean_step(&records[j].time)
        });
        if records[k].role == Role::Validate {
            records[k].continues = before.filter(|&j| records[j].role == Role::Fit);
        }
    }
}
