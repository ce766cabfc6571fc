//! The system of a spec in which every constant keeps its name: a sketch tells `k` from a number that is alike.

use phisindy_phys::spec::{ConstantSpec, DataSpec, Find, Number, Spec, Text};
use phisindy_phys::{SourceId, System, check_names};
use std::collections::HashMap;

/// The system with its constants as symbols, and what each is worth (SI) as far as that is known.
pub(super) struct Named {
    pub(super) system: System,
    pub(super) values: HashMap<String, f64>,
}

/// Reads a spec once more; `None` where it holds only with its numbers.
pub(super) fn named(spec: &Spec) -> Option<Named> {
    let mut freed = spec.clone();
    let of_records: Vec<(Text, ConstantSpec)> =
        spec.data.iter().flat_map(DataSpec::constants).cloned().collect();
    freed.data = vec![];
    for (name, constant) in of_records {
        if freed.constants.iter().all(|(n, _)| n.value != name.value) {
            freed.constants.push((name, constant));
        }
    }
    let mut known = vec![];
    for (name, constant) in &mut freed.constants {
        let free = |start: &Number, unit: Option<Text>| {
            ConstantSpec::Find(Find {
                within: (start.clone(), start.clone()),
                span: start.span,
                start: start.clone(),
                unit,
                sigma: None,
                each: false,
            })
        };
        match constant {
            ConstantSpec::Number { value, unit } => *constant = free(value, unit.clone()),
            ConstantSpec::MaxAbs(of) => *constant = free(&Number { value: 1.0, span: of.span }, None),
            ConstantSpec::Movable(_) => {}
            // What is looked for starts anywhere.
            ConstantSpec::Find(_) | ConstantSpec::Expression(_) => continue,
        }
        if !matches!(spec_constant(spec, &name.value), Some(ConstantSpec::MaxAbs(_))) {
            known.push(name.value.clone());
        }
    }
    let (case, _) = check_names(&freed, SourceId(0)).ok()?;
    let start = |name: String| {
        let parameter = case.system.parameters.iter().find(|p| p.name == name)?;
        Some((name, parameter.start))
    };
    let values = known.into_iter().filter_map(start).collect();
    Some(Named { system: case.system, values })
}

fn spec_constant<'a>(spec: &'a Spec, name: &str) -> Option<&'a ConstantSpec> {
    spec.constants.iter().find(|(n, _)| n.value == name).map(|(_, constant)| constant)
}
