//! Records that are read from a file.

use super::checker::Checker;
use super::record::quantity_names;
use crate::system::equations::System;
use crate::system::plan::{Origin, RecordPlan};
use crate::text::spec::{CsvSpec, DataSpec, Spec};
use crate::units::unit::{Dimension, Unit};
use std::collections::HashMap;

impl Checker {
    /// The plan of a record whose rows a file holds; none after an error.
    pub(super) fn csv(&mut self, csv: &CsvSpec, spec: &Spec, system: &System) -> Option<RecordPlan> {
        let errors = self.errors();
        let own_files = csv.streams.iter().filter_map(|stream| stream.path.as_ref());
        for name in [&csv.path].into_iter().chain(own_files.filter(|path| **path != csv.path)) {
            let plain = std::path::Path::new(&name.value)
                .components()
                .all(|c| matches!(c, std::path::Component::Normal(_) | std::path::Component::CurDir));
            if !csv.in_memory && (!plain || name.value.contains('\\')) {
                self.error(format!("`{}` leads out of the data folder", name.value), name.span, "")
                    .help
                    .push("name the file alone, and its folder with --data".into());
            }
        }
        let times =
            [&csv.time].into_iter().chain(csv.streams.iter().map(|s| &s.time).filter(|t| **t != csv.time));
        for unit in times.filter_map(|time| time.unit.as_ref()) {
            let theirs = self.unit(unit).dimension;
            if theirs != Dimension::SECOND {
                self.error(format!("`{}` is no unit of time", unit.value), unit.span, "")
                    .help
                    .push("times stand in \"s\", \"ms\", \"us\", \"min\", \"h\", ...".into());
            }
        }
        let names = quantity_names(system);
        for (name, column) in &csv.columns {
            if !names.contains(&name.value.as_str()) {
                self.unknown_name(&name.value, name.span, "state, output or input in `columns`", &names);
                continue;
            }
            let own: HashMap<&str, &str> = system.quantities().collect();
            if let Some(unit) = &column.unit {
                let theirs = self.unit(unit);
                let ours = Unit::parse(own[name.value.as_str()]).unwrap_or(Unit::ONE);
                if theirs.dimension != ours.dimension {
                    let message = format!(
                        "`{}` cannot be converted to `{}`, the unit of `{}`",
                        unit.value,
                        own[name.value.as_str()],
                        name.value
                    );
                    let help = format!(
                        "`(header, unit)` says in which unit the file's numbers stand: give one of `{}`, or another column",
                        own[name.value.as_str()]
                    );
                    self.error(message, unit.span, "").help.push(help);
                }
            }
        }
        let shown: Vec<&str> = names.iter().copied().filter(|n| system.column(n).is_some()).collect();
        // Arrays of the inputs alone can drive a simulation.
        if !csv.in_memory && !csv.columns.iter().any(|(n, _)| system.column(&n.value).is_some()) {
            self.error(
                "no column measures a state or an output, so there is nothing to fit",
                csv.path.span,
                "",
            )
            .help
            .push(format!("give at least one of {} a column", shown.join(", ")));
        }
        let has_column = |name: &str| csv.columns.iter().any(|(n, _)| n.value == name);
        for (name, _) in csv.sensors.iter().filter(|(name, _)| names.contains(&name.value.as_str())) {
            if !has_column(&name.value) {
                self.without_column(name, "sensor");
            }
        }
        let (derived, differentiators) = self.derived(&csv.derive, system);
        for (k, input) in system.inputs.iter().enumerate() {
            if derived[k].is_none() && !has_column(&input.name) {
                self.error(format!("input `{}` has neither a column nor a derivation in this record", input.name), csv.path.span, "")
                    .help
                    .push(format!("add `\"{0}\": (\"header\", \"{1}\")` to `columns`, or `derive: {{ \"{0}\": Derivative(...) }}`", input.name, input.unit));
            }
        }
        let unmeasured: Vec<_> = derived
            .iter()
            .enumerate()
            .map(|(k, of)| of.filter(|_| !has_column(&system.inputs[k].name)))
            .collect();
        let constants = self.record_constants(&DataSpec::Csv(Box::new(csv.clone())), spec, system, &csv.path);
        let plan = RecordPlan {
            name: csv.name.as_ref().map_or(csv.path.value.clone(), |n| n.value.clone()),
            role: csv.role,
            constants,
            sensors: self.sensors(&csv.sensors, &unmeasured, system),
            derived,
            differentiators,
            interpolation: self.interpolation(&csv.interpolate, system),
            start: self.start(&csv.start, system),
            origin: Origin::Csv(Box::new(csv.clone())),
        };
        (self.errors() == errors).then_some(plan)
    }
}
