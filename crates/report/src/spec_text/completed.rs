//! `completed.ron`: the text of the spec with the effects that `gap` found.

use super::edit::{Text, first, head, number, records_of, sensor_of};
use crate::gap::GapReport;
use crate::input::Input;
use phisindy_gap::Gap;
use phisindy_phys::spec::{self, DataSpec, Find, SensorValue};
use phisindy_phys::unit::Unit;
use phisindy_phys::{Origin, SensorPart, SourceId};

/// Name of the file.
pub const COMPLETED: &str = "completed.ron";

/// The text of `completed.ron`, and why it lacks start states and sensors, if it does.
pub fn completed(report: &GapReport<'_>) -> (String, Option<String>) {
    let GapReport { input, gap: found, .. } = *report;
    let measured = input.case.records.iter().any(|plan| matches!(plan.origin, Origin::Csv(_)));
    let data = if measured {
        "      (with --data DIR where its data files have moved)"
    } else {
        "\n// Synthetic records are made anew from `known` and `truth`: take out of `truth` what now stands in `known`, or it acts twice."
    };
    let (text, why) = match filled(input, found) {
        Ok(text) => (text, None),
        Err(why) => (found.completed.clone(), Some(why)),
    };
    let text = format!(
        "{}{}` (version {}) made of it: {}.\n// The effects stand in `known`, their numbers in `constants`, `sensors` and `start`, from where a fit ended:\n//     phisindy run completed.ron{data}\n{text}",
        head("gap"),
        input.name,
        env!("CARGO_PKG_VERSION"),
        found.status.name(),
    );
    (text, why)
}

/// The completed text with fitted values of each measured record: its start state, and the start values of
/// searched sensor parameters. (The start of a synthetic record defines its data; it is not a fitted value.)
///
/// # Errors
/// In words: the text has no place for a value.
fn filled(input: Input<'_>, found: &Gap) -> Result<String, String> {
    let mut text = Text(found.completed.clone());
    let (spec, _) = spec::read_with_files(&text.0, SourceId(0), &input.spec.files).map_err(|d| first(&d))?;
    let measured = |r: usize| matches!(spec.data.get(r), Some(DataSpec::Csv(_)));
    for p in &found.parameters {
        let (Some(owner), Some((column, part))) = (p.id.record(), sensor_of(p)) else { continue };
        for r in records_of(input, owner) {
            let at = r.to_string();
            if let Some(find) = spec.data.get(r).and_then(|data| searched(data, column, part)) {
                let factor =
                    find.unit.as_ref().and_then(|u| Unit::parse(&u.value).ok()).map_or(1.0, |u| u.factor);
                let value = (p.estimate.value / factor).clamp(find.within.0.value, find.within.1.value);
                text.set(&["data", &at, "sensors", column, part.name(), "start"], &number(value))?;
            }
        }
    }
    for (r, record) in found.simulated.records.iter().enumerate().filter(|(r, _)| measured(*r)) {
        for (state, x) in found.simulated.system.states.iter().zip(&record.start) {
            if x.is_finite() {
                text.set(&["data", &r.to_string(), "start", &state.name], &number(x / state.factor))?;
            }
        }
    }
    let (spec, _) = spec::read_with_files(&text.0, SourceId(0), &input.spec.files).map_err(|d| first(&d))?;
    phisindy_phys::check_names(&spec, SourceId(0)).map_err(|d| first(&d))?;
    Ok(text.0)
}

/// The searched parameter of a record's sensor, if it is one.
fn searched<'a>(data: &'a DataSpec, column: &str, part: SensorPart) -> Option<&'a Find> {
    let sensors = match data {
        DataSpec::Csv(csv) => &csv.sensors,
        DataSpec::Synthetic(synthetic) => &synthetic.sensors,
    };
    let (_, sensor) = sensors.iter().find(|(name, _)| name.value == column)?;
    let value = match part {
        SensorPart::Offset => &sensor.offset,
        SensorPart::Gain => &sensor.gain,
        SensorPart::Delay => &sensor.delay,
        SensorPart::Clock => &sensor.clock,
        SensorPart::Lag => &sensor.lag,
    };
    match value {
        Some(SensorValue::Find(find)) => Some(find),
        _ => None,
    }
}
