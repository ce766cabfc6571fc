//! Sensors that are late: a delay or a lag that the records ask for is found beside the rest, and told.
//!
//! ```text
//! identify --LateColumn--> spec with a delay, spec with a lag --identify--> the more probable, if it convinces
//! ```

use crate::loaded::{Loaded, checked};
use phisindy_learn::{Identified, LateColumn, LearnError, LearnOptions, Warning, identify};
use phisindy_phys::{Record, RecordPlan, SensorParameter, SourceId, splice};
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
    let by = if delay { delay_name(&late.name) } else { lag_name(&late.name) };
    found.warnings.insert(0, Warning::Late { column: late.name.clone(), by, delay, errors });
    Some((loaded, found))
}

fn delay_name(column: &str) -> String {
    format!("{column}_delay").replace('.', "_")
}

fn lag_name(column: &str) -> String {
    format!("{column}_lag").replace('.', "_")
}

/// With a delay of the column in every record.
fn with_delay(loaded: &Loaded, late: &LateColumn) -> Option<Loaded> {
    let reach = late.reach * late.delay.abs();
    edited(loaded, late, "delay", &delay_name(&late.name), (-reach, reach))
}

/// With a lag of the column in every record; `None` where the column is early, or its lag is stated.
fn with_lag(loaded: &Loaded, late: &LateColumn) -> Option<Loaded> {
    let stated = |r: &Record| r.sensors[late.column].lag != SensorParameter::fixed(0.0);
    if late.delay <= 0.0 || loaded.records.iter().any(stated) {
        return None;
    }
    edited(loaded, late, "lag", &lag_name(&late.name), (0.0, late.reach * late.delay))
}

/// The text with one more constant, and a property of a column in every record that uses it; `None` if the text has
/// no place for it.
fn edited(
    loaded: &Loaded,
    late: &LateColumn,
    property: &str,
    name: &str,
    (low, high): (f64, f64),
) -> Option<Loaded> {
    let start = late.delay;
    let system = &loaded.case.system;
    let records = &loaded.records;
    if system.names.get(name).is_some() || loaded.case.records.len() != records.len() {
        return None;
    }
    let constant = format!("Find(start: {start:?}, unit: \"s\", within: ({low:?}, {high:?}))");
    let mut text = if loaded.parsed.constants.is_empty() {
        splice::set(&loaded.text, "constants", &format!("{{ \"{name}\": {constant} }}")).ok()?
    } else {
        splice::set(&loaded.text, &format!("constants.{name}"), &constant).ok()?
    };
    let column = if late.name.contains('.') { format!("\"{}\"", late.name) } else { late.name.clone() };
    for k in (0..records.len()).filter(|&k| records[k].columns[late.column].is_some()) {
        text = splice::set(&text, &format!("data.{k}.sensors.{column}.{property}"), &format!("\"{name}\""))
            .ok()?;
    }
    let (parsed, case, _) = checked(&text, SourceId(0), &loaded.parsed.files).ok()?;
    let with =
        |(record, plan): (&Record, &RecordPlan)| Record { sensors: plan.sensors.clone(), ..record.clone() };
    let records = records.iter().zip(&case.records).map(with).collect();
    // What is simulated without noise knows no sensor.
    let truths = loaded.truths.iter().map(|_| None).collect();
    Some(Loaded { text, parsed, case, records, truths, ..loaded.clone() })
}
