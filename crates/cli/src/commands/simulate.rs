//! Simulated runs as CSV: synthetic data (time, the noisy columns of the record, the exact states, the inputs), and the free run of a model
//! without unknown part along a measured record.

use super::spec_file::{failed, loaded};
use crate::args::Options;
use crate::draw;
use crate::load::{Loaded, Purpose};
use crate::terminal::{INPUT, NUMERICS, STDOUT};
use anyhow::{Context, Result, anyhow};
use phisindy_phys::{Origin, Record, RecordPlan, Sources, System};
use phisindy_signal::{Differentiator, standard_deviation};
use phisindy_sim::{Automaton, Drive, SimError, Trajectory};
use std::io::{self, Write};
use std::path::Path;

/// A state beyond this many times its size has diverged.
const DIVERGED: f64 = 1e4;

/// Simulates the records of a spec, prints them as CSV, and returns the exit code.
pub(crate) fn simulate(spec: &Path, record: Option<&str>, options: &Options) -> Result<u8> {
    let mut loaded = match loaded(spec, options, Purpose::Simulate, None) {
        Ok(loaded) => loaded,
        Err(code) => return Ok(code),
    };
    if loaded.records.is_empty() {
        return Err(anyhow!(
            "{}: the model has an unknown part and no `Synthetic` record: identify it first (`phisindy run {} --out DIR`), then simulate \
             DIR/identified.ron",
            loaded.spec,
            loaded.spec
        ));
    }
    if let Some(record) = record {
        loaded = match loaded.only(record) {
            Ok(loaded) => loaded,
            Err(mistake) => {
                draw::show([&mistake], &Sources::default());
                return Ok(INPUT);
            }
        };
    }
    let runs = match runs(&loaded) {
        Ok(runs) => runs,
        Err(Failure { why, diverged }) => {
            failed(&loaded.spec, &why, diverged);
            return Ok(NUMERICS);
        }
    };
    let mut out = io::BufWriter::new(io::stdout().lock());
    write(&loaded, &runs, &mut out).and_then(|()| Ok(out.flush()?)).context(STDOUT)?;
    Ok(0)
}

/// Why a model cannot be simulated.
struct Failure {
    /// In words.
    why: String,
    /// Whether a state grew without bound.
    diverged: bool,
}

impl From<String> for Failure {
    fn from(why: String) -> Failure {
        Failure { why, diverged: false }
    }
}

/// A run at the sample times of its record.
struct Run {
    /// For each state.
    columns: Vec<Vec<f64>>,
    /// Of a measured record: the model's prediction; of a synthetic one: the truth.
    predicted: bool,
}

/// The runs of all records.
///
/// # Errors
/// A model cannot be simulated.
fn runs(loaded: &Loaded) -> Result<Vec<Run>, Failure> {
    let one = |((record, truth), plan): ((&Record, &Option<Trajectory>), &RecordPlan)| match (
        truth,
        &plan.origin,
    ) {
        (Some(truth), Origin::Synthetic(made)) => {
            let row = |t: f64| (t / made.step).round() as usize;
            let column = |k: usize| record.time.iter().map(|&t| truth.states[row(t) * truth.n + k]).collect();
            Ok(Run { columns: (0..truth.n).map(column).collect(), predicted: false })
        }
        _ => predicted(&loaded.case.system, record)
            .map_err(|e| Failure { why: format!("record `{}`: {}", record.name, e.why), ..e }),
    };
    loaded.records.iter().zip(&loaded.truths).zip(loaded.simulated()).map(one).collect()
}

/// The free run from the record's start state; what the spec does not say of it is taken from the first sample.
fn predicted(system: &System, record: &Record) -> Result<Run, Failure> {
    let mut filled = record.clone();
    // A state that cannot be derived is asked for below, unless the spec states where it starts.
    let _ = filled.fill_velocities(system, Differentiator::default());
    let start = system.states.iter().enumerate().map(|(k, state)| {
        let sensor = &record.sensors[k];
        let first = filled.columns[k].as_ref().map(|c| {
            if record.columns[k].is_some() { (c[0] - sensor.offset.start) / sensor.gain.start } else { c[0] }
        });
        let name = &state.name;
        record.start[k]
            .or(first)
            .ok_or(format!("no column tells where {name} starts: add `start: {{ \"{name}\": ... }}`"))
    });
    let start: Vec<f64> = start.collect::<Result<_, _>>()?;
    let scale = start.iter().enumerate().map(|(k, x)| size(&filled, k).max(x.abs())).collect::<Vec<f64>>();
    let scale = scale.into_iter().map(|s| if s > 0.0 { s } else { 1.0 }).collect();
    let model = system.model(&[]);
    let automaton = Automaton::new(&model).map_err(|e| e.message(&model.names))?;
    let parameters: Vec<f64> =
        system.parameters.iter().map(|p| p.start).chain(record.constants.iter().copied()).collect();
    let drive = Drive { inputs: &record.inputs, parameters: &parameters };
    let options = phisindy_sim::Options { scale, diverged: DIVERGED, ..phisindy_sim::Options::default() };
    let run = phisindy_sim::simulate(&automaton, &drive, record.time[0], &start, &record.time, &options)
        .map_err(|e| Failure { why: e.to_string(), diverged: matches!(e, SimError::Diverged { .. }) })?;
    Ok(Run { columns: (0..run.n).map(|k| readings(record, &run, k)).collect(), predicted: true })
}

/// Standard deviation of the samples of a state; 0 without any.
fn size(record: &Record, state: usize) -> f64 {
    record.columns[state].as_ref().map_or(0.0, |column| standard_deviation(column))
}

/// What the sensor of a state would read along a run; the state itself where there is none.
fn readings(record: &Record, run: &Trajectory, state: usize) -> Vec<f64> {
    let values = run.column(state);
    if record.columns[state].is_none() {
        return values;
    }
    let sensor = &record.sensors[state];
    let (offset, gain, delay) = (sensor.offset.start, sensor.gain.start, sensor.delay.start);
    let rates = run.rates.iter().skip(state).step_by(run.n);
    values.iter().zip(rates).map(|(x, rate)| offset + gain * (x - delay * rate)).collect()
}

/// Writes all records of the case below one another; several are told apart by a first column.
fn write(loaded: &Loaded, runs: &[Run], out: &mut dyn Write) -> Result<()> {
    let system = &loaded.case.system;
    let states = 0..system.states.len();
    let measured: Vec<usize> =
        states.clone().filter(|&k| loaded.records.iter().any(|r| r.columns[k].is_some())).collect();
    let several = loaded.records.len() > 1;
    let kinds: Vec<bool> =
        [false, true].into_iter().filter(|&kind| runs.iter().any(|r| r.predicted == kind)).collect();
    let mut writer = csv::Writer::from_writer(out);
    let mut header: Vec<String> = Vec::new();
    if several {
        header.push("record".to_owned());
    }
    header.push("t".to_owned());
    header.extend(measured.iter().map(|&k| system.states[k].name.clone()));
    for &predicted in &kinds {
        let ending = if predicted { "model" } else { "true" };
        header.extend(system.states.iter().map(|s| format!("{}_{ending}", s.name)));
    }
    header.extend(system.inputs.iter().map(|u| u.name.clone()));
    writer.write_record(&header)?;
    for (record, run) in loaded.records.iter().zip(runs) {
        for i in 0..record.len() {
            let mut row: Vec<String> = Vec::with_capacity(header.len());
            if several {
                row.push(record.name.clone());
            }
            row.push(number(record.time[i]));
            row.extend(
                measured.iter().map(|&k| record.columns[k].as_ref().map_or(String::new(), |c| number(c[i]))),
            );
            for &predicted in &kinds {
                let cell = |k: usize| {
                    if run.predicted == predicted { number(run.columns[k][i]) } else { String::new() }
                };
                row.extend(states.clone().map(cell));
            }
            row.extend(record.inputs.iter().map(|signal| number(signal.value(record.time[i]))));
            writer.write_record(&row)?;
        }
    }
    writer.flush()?;
    Ok(())
}

/// The shortest text that reads back as the same number.
fn number(x: f64) -> String {
    let size = x.abs();
    if size != 0.0 && !(1e-4..1e15).contains(&size) { format!("{x:e}") } else { format!("{x}") }
}
