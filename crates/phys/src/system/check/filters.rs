//! Filters of sensors: each becomes states of the system behind an output.

use super::checker::Checker;
use crate::system::equations::{Output, System};
use crate::system::filter::FilterKind;
use crate::text::spec::{DataSpec, FilterSpec, SensorSpec, SensorValue, Spec, Text};
use phisindy_expr::Id;

/// Most poles of a filter: data loggers have eight at most, and more make stiff equations.
const MOST_POLES: u32 = 10;

impl Checker {
    /// Adds the filters of all records to the system, high-pass before low-pass.
    pub(super) fn filters(&mut self, spec: &Spec, system: &mut System) {
        let all: Vec<(&DataSpec, &Text, &SensorSpec)> = spec
            .data
            .iter()
            .flat_map(|data| sensors_of(data).iter().map(move |(name, sensor)| (data, name, sensor)))
            .filter(|(.., sensor)| sensor.lowpass.is_some() || sensor.highpass.is_some())
            .collect();
        let mut done: Vec<&str> = Vec::new();
        for (_, name, _) in &all {
            let column = name.value.as_str();
            if done.contains(&column) || system.sensor(column).is_none() {
                continue; // an unknown name is told with the sensors
            }
            done.push(column);
            let Some(output) = self.filtered_output(name, system) else { continue };
            for kind in [FilterKind::Highpass, FilterKind::Lowpass] {
                let of = |sensor: &'_ SensorSpec| match kind {
                    FilterKind::Highpass => sensor.highpass.clone(),
                    FilterKind::Lowpass => sensor.lowpass.clone(),
                };
                let own: Vec<Option<FilterSpec>> = spec
                    .data
                    .iter()
                    .filter(|data| measures(data, column))
                    .map(|data| {
                        sensors_of(data).iter().find(|(n, _)| n.value == column).and_then(|(_, s)| of(s))
                    })
                    .collect();
                self.filter(column, output, kind, &own, system);
            }
        }
        let connected = system.connect_filters();
        (self.graph, self.names) = (system.graph.clone(), system.names.clone());
        if let Err((output, _)) = connected {
            let column = &system.outputs[output].name;
            let span = all.iter().find(|(_, name, _)| name.value == *column).map(|(_, name, _)| name.span);
            let span = span.expect("a filtered output has a sensor");
            self.error(
                format!("`{column}` cannot be filtered: its reading is not linear in `rate(...)`"),
                span,
                "",
            )
            .help
            .push("a filter takes `a + b*rate(v)` with a constant `b`, or a reading without rates".into());
        }
    }

    /// The output that a filtered column shows: of a state, an output of its own with the same name.
    fn filtered_output(&mut self, name: &Text, system: &mut System) -> Option<usize> {
        let column = name.value.as_str();
        if let Some(k) = system.outputs.iter().position(|o| o.name == column) {
            return Some(k);
        }
        let Some(state) = system.state(column) else {
            self.error(format!("the filter of the input `{column}` cannot be undone"), name.span, "")
                .help
                .push(
                    "measure the input without a filter, or give all columns the same one and leave it out"
                        .into(),
                );
            return None;
        };
        let state = &system.states[state];
        system.outputs.push(Output {
            name: state.name.clone(),
            unit: state.unit.clone(),
            factor: state.factor,
            reads: state.name.clone(),
            reading: state.node,
            node: state.node,
        });
        Some(system.outputs.len() - 1)
    }

    /// Adds one filter, as the records that measure the column write it.
    fn filter(
        &mut self,
        column: &str,
        output: usize,
        kind: FilterKind,
        own: &[Option<FilterSpec>],
        system: &mut System,
    ) {
        let Some(first) = own.iter().flatten().next() else { return };
        if own.iter().any(|f| f.as_ref().is_none_or(|f| f.order.value != first.order.value)) {
            self.error(format!("the {} of `{column}` differs between records", kind.name()), first.span, "")
                .help
                .push("filter the column alike in all records that have it, or give it an output for each filter".into());
            return;
        }
        if first.order.value > MOST_POLES {
            self.error(format!("a filter has at most {MOST_POLES} poles"), first.order.span, "")
                .help
                .push("give the order of the sensor's data sheet: 1 to 8 as a rule".into());
            return;
        }
        let name = format!("{column}.{}.cutoff", kind.name());
        let Some((cutoff, own_parameter)) = self.cutoff(&name, own, first, system) else { return };
        system.add_filter(output, kind, first.order.value as usize, cutoff, own_parameter);
    }

    /// The node of the cutoff of a filter, and the parameter that it is where each record finds its own.
    fn cutoff(
        &mut self,
        name: &str,
        own: &[Option<FilterSpec>],
        first: &FilterSpec,
        system: &mut System,
    ) -> Option<(Id, Option<usize>)> {
        let values: Vec<(&SensorValue, f64)> =
            own.iter().flatten().map(|f| Some((&f.cutoff.0, self.hertz(f)?))).collect::<Option<_>>()?;
        let mixed = |checker: &mut Checker| {
            checker.error("the cutoff is of another kind in another record", first.span, "").help.push(
                "write a number in every record, or `Find(...)` in every record, or the same constant".into(),
            );
            None
        };
        match &first.cutoff.0 {
            SensorValue::Number(number) => {
                let mut all = Vec::new();
                for (value, factor) in values {
                    let SensorValue::Number(number) = value else { return mixed(self) };
                    if number.value <= 0.0 {
                        self.error("a cutoff is greater than zero", number.span, "").help.push(
                            "give the frequency at which the filter halves the power, or leave it out".into(),
                        );
                        return None;
                    }
                    all.push(self.si(number, factor));
                }
                if all.iter().any(|f| *f != all[0]) {
                    self.error("the cutoff differs between records", number.span, "").help.push(
                        "write it as `Find(...)`, which each record has for itself, or give the column an output for each filter"
                            .into(),
                    );
                    return None;
                }
                Some((system.graph.constant(all[0]), None))
            }
            SensorValue::Find(find) => {
                let mut within = (f64::INFINITY, 0.0_f64);
                for (value, factor) in values {
                    let SensorValue::Find(f) = value else { return mixed(self) };
                    let (low, high) = (self.si(&f.within.0, factor), self.si(&f.within.1, factor));
                    within = (within.0.min(low), within.1.max(high));
                }
                if within.0 <= 0.0 {
                    self.error("a cutoff is greater than zero", find.span, "")
                        .help
                        .push("let the bounds begin above zero".into());
                    return None;
                }
                let factor = self.hertz(first)?;
                let start = self.si(&find.start, factor);
                let k = system.add_parameter(name, "Hz", start, within, true);
                system.parameters[k].sigma = find.sigma.as_ref().map(|s| self.si(s, factor));
                Some((system.parameters[k].node, Some(k)))
            }
            SensorValue::Constant(constant) => {
                let same =
                    |v: &SensorValue| matches!(v, SensorValue::Constant(c) if c.value == constant.value);
                if !values.iter().all(|(v, _)| same(v)) {
                    return mixed(self);
                }
                self.used.insert(constant.value.clone());
                let node = system.constants.iter().any(|(n, _)| *n == constant.value)
                    || system.parameters.iter().any(|p| p.name == constant.value);
                let node = node.then(|| system.quantity(&constant.value)).flatten();
                if node.is_none() {
                    let names: Vec<&str> = system.constants.iter().map(|(n, _)| n.as_str()).collect();
                    self.unknown_name(&constant.value, constant.span, "constant", &names);
                }
                Some((node?, None))
            }
        }
    }

    /// The factor from the unit of a cutoff to Hz; none after a diagnostic.
    fn hertz(&mut self, filter: &FilterSpec) -> Option<f64> {
        let unit = match &filter.cutoff {
            (SensorValue::Find(find), _) => find.unit.as_ref(),
            (_, unit) => unit.as_ref(),
        };
        let Some(unit) = unit else { return Some(1.0) };
        let factor = self.unit(unit);
        if unit.value.trim().ends_with("Hz") {
            return Some(factor.factor);
        }
        self.error(format!("a cutoff is a frequency, `{}` is not", unit.value), unit.span, "")
            .help
            .push("give it in Hz or kHz; 1 Hz is 6.283 rad/s".into());
        None
    }
}

fn sensors_of(data: &DataSpec) -> &[(Text, SensorSpec)] {
    match data {
        DataSpec::Csv(csv) => &csv.sensors,
        DataSpec::Synthetic(synthetic) => &synthetic.sensors,
    }
}

/// Whether a record has a column of this name, or may have one.
fn measures(data: &DataSpec, column: &str) -> bool {
    match data {
        DataSpec::Csv(csv) => csv.columns.iter().any(|(n, _)| n.value == column),
        DataSpec::Synthetic(synthetic) => {
            synthetic.measure.as_ref().is_none_or(|list| list.iter().any(|n| n.value == column))
        }
    }
}
