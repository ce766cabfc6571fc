//! Sensors that are late: a delay or a lag that the records ask for is found beside the rest, and told.
//!
//! ```text
//! identify --LateColumn--> spec with a delay, spec with a lag --identify--> the more probable, if it convinces
//! ```

use crate::loaded::{Loaded, checked};
use phisindy_learn::{Identified, LateColumn, LearnError, LearnOptions, Warning, identify};
use phisindy_phys::{Record, SourceId, System, splice};
use std::f64::consts::TAU;
use std::ops::ControlFlow;

impl Loaded {
    /// Identifies, and again with what each sensor is late by where the records ask for it; each then stands in the
    /// text as a constant that is to be found, and a warning tells of it.
    ///
    /// # Errors
    /// As [`identify`].
    pub fn identified(
        self,
        options: &LearnOptions,
        observe: &mut (dyn FnMut(f64) -> ControlFlow<()> + Send),
    ) -> Result<(Loaded, Identified), LearnError> {
        let found = identify(&self.case, &self.records, options, observe)?;
        let mut best = (self, found);
        // What was written out is compared with the model that lacks it, which knows of no delay.
        while let Some(late) = best.1.late.clone().filter(|_| best.0.case.without_laws.is_none()) {
            if best.1.interrupted() {
                break;
            }
            let again = |loaded: Loaded| {
                let found = identify(&loaded.case, &loaded.records, options, &mut |_| observe(LAST)).ok()?;
                Some((loaded, found))
            };
            let with = [with_delay(&best.0, &late), with_lag(&best.0, &late)].into_iter().flatten();
            let all: Vec<(Loaded, Identified)> = with.filter_map(again).collect();
            let Some((loaded, mut found)) = convincing(&late, &best.1, all) else { break };
            let earlier = best.1.warnings.into_iter().filter(|w| matches!(w, Warning::Late { .. }));
            found.warnings.splice(0..0, earlier);
            best = (loaded, found);
        }
        Ok(best)
    }
}

/// The part of the work that is done when what is late is looked for.
const LAST: f64 = 0.95;

/// Of the same model with a delay and with a lag, the more probable one: if the delay convinces, and the model is
/// more probable than without.
fn convincing(
    late: &LateColumn,
    before: &Identified,
    all: Vec<(Loaded, Identified)>,
) -> Option<(Loaded, Identified)> {
    let deviance = |found: &Identified| found.deviance.unwrap_or(f64::INFINITY);
    let errors = all.iter().find_map(|(_, found)| {
        let delay = found.parameters.iter().find(|p| p.id.to_string() == delay_name(&late.name))?;
        Some((delay.estimate.value / delay.estimate.std_error).abs())
    })?;
    let (loaded, mut found) = all.into_iter().min_by(|a, b| deviance(&a.1).total_cmp(&deviance(&b.1)))?;
    let more_probable = before.deviance.is_none_or(|d| deviance(&found) < d);
    // Beside a law that is missing a delay is what comes nearest to it: it must leave noise.
    let leaves_more = found.warnings.iter().any(Warning::doubts_residual);
    if !more_probable || leaves_more || errors.powi(2) <= late.needed {
        return None;
    }
    let delay = found.parameters.iter().any(|p| p.id.to_string() == delay_name(&late.name));
    let by = if delay { delay_name(&late.name) } else { cutoff_name(&late.name) };
    found.warnings.insert(0, Warning::Late { column: late.name.clone(), by, delay, errors });
    Some((loaded, found))
}

fn delay_name(column: &str) -> String {
    format!("{column}_delay").replace('.', "_")
}

fn cutoff_name(column: &str) -> String {
    format!("{column}_cutoff").replace('.', "_")
}

/// With a delay of the column in every record.
fn with_delay(loaded: &Loaded, late: &LateColumn) -> Option<Loaded> {
    let reach = late.reach * late.delay.abs();
    let found =
        Number { name: delay_name(&late.name), start: late.delay, unit: "s", within: (-reach, reach) };
    edited(loaded, late, &found, "delay", &format!("\"{}\"", found.name))
}

/// With a low-pass of first order before the column in every record.
fn with_lag(loaded: &Loaded, late: &LateColumn) -> Option<Loaded> {
    let system = &loaded.case.system;
    if late.delay <= 0.0 || system.filters.iter().any(|f| system.outputs[f.output].name == late.name) {
        return None;
    }
    let start = 1.0 / (TAU * late.delay);
    let found = Number {
        name: cutoff_name(&late.name),
        start,
        unit: "Hz",
        within: (start / late.reach, start * late.reach),
    };
    let filter = format!("(order: 1, cutoff: \"{}\")", found.name);
    edited(loaded, late, &found, "lowpass", &filter)
}

/// A constant that is to be found.
struct Number {
    name: String,
    start: f64,
    unit: &'static str,
    within: (f64, f64),
}

/// The text with one more constant, and a property of a column in every record that uses it; `None` if the text has
/// no place for it.
fn edited(loaded: &Loaded, late: &LateColumn, found: &Number, property: &str, value: &str) -> Option<Loaded> {
    let Number { name, start, unit, within: (low, high) } = found;
    let system = &loaded.case.system;
    let records = &loaded.records;
    if system.names.get(name).is_some() || loaded.case.records.len() != records.len() {
        return None;
    }
    let constant = format!("Find(start: {start:?}, unit: \"{unit}\", within: ({low:?}, {high:?}))");
    let mut text = if loaded.parsed.constants.is_empty() {
        splice::set(&loaded.text, "constants", &format!("{{ \"{name}\": {constant} }}")).ok()?
    } else {
        splice::set(&loaded.text, &format!("constants.{name}"), &constant).ok()?
    };
    let column = if late.name.contains('.') { format!("\"{}\"", late.name) } else { late.name.clone() };
    for k in (0..records.len()).filter(|&k| records[k].columns[late.column].is_some()) {
        text = splice::set(&text, &format!("data.{k}.sensors.{column}.{property}"), value).ok()?;
    }
    let (parsed, case, _) = checked(&text, SourceId(0), &loaded.parsed.files).ok()?;
    let records = records.iter().zip(&case.records).map(|(record, plan)| {
        let places = laid_out(record, system, &case.system);
        let columns = places.iter().map(|place| record.columns[(*place)?].clone()).collect();
        let own_times = record.own_times.at(places.into_iter());
        Record {
            columns,
            own_times,
            sensors: plan.sensors.clone(),
            start: plan.start.clone(),
            ..record.clone()
        }
    });
    let records = records.collect();
    // What is simulated without noise knows no sensor.
    let truths = loaded.truths.iter().map(|_| None).collect();
    Some(Loaded { text, parsed, case, records, truths, ..loaded.clone() })
}

/// Where a record has the columns that another system has: a filtered state is read as an output of its name.
fn laid_out(record: &Record, from: &System, to: &System) -> Vec<Option<usize>> {
    let own =
        |name: &str| (0..from.columns()).find(|&k| from.measured(k).0 == name && record.columns[k].is_some());
    let shown = |k: usize| to.outputs.iter().any(|o| o.name == to.states[k].name);
    (0..to.columns())
        .map(|k| if k < to.states.len() && shown(k) { None } else { own(to.measured(k).0) })
        .collect()
}
