//! `identified.ron`: the text of the spec with the identified terms and numbers, for predictions with
//! `simulate`. Comments and everything else stay.

use super::edit::{Text, first, head, number, records_of, sensor_of};
use crate::input::Input;
use phisindy_expr::{AstKind, Binary, Unary, parse};
use phisindy_learn::{FoundParameter, Identified, ParameterOf};
use phisindy_phys::spec::{ConstantSpec, DataSpec, SensorValue, Spec, UnknownSpec};
use phisindy_phys::unit::{Dimension, Unit};
use phisindy_phys::{SourceId, spec};

/// Name of the file.
pub const IDENTIFIED: &str = "identified.ron";

/// The text of `identified.ron`.
///
/// # Errors
/// In words: the result does not fit into the text, because of a mistake of this program or an unknown form
/// of the spec.
pub fn identified(input: Input<'_>, found: &Identified) -> Result<String, String> {
    let spec = input.spec;
    let mut text = Text(input.text.to_owned());
    rates(&mut text, spec, input, found)?;
    parameters(&mut text, spec, input, found)?;
    for (r, record) in found.records.iter().enumerate() {
        for own in record.adapted.iter().flat_map(|a| &a.values) {
            match &own.id.of {
                ParameterOf::Constant { index, name } => match filter_of(input, *index) {
                    Some((column, kind)) => cutoff(&mut text, r, column, kind, own.value)?,
                    None => of_data(&mut text, r, name, own.value / own.factor, &own.unit)?,
                },
                // Plain numbers of sensors are in SI units.
                ParameterOf::Sensor { name, part, .. } => {
                    text.set(&["data", &r.to_string(), "sensors", name, part.name()], &number(own.value))?
                }
            }
        }
        // The start of a synthetic record is that of the whole run, not that of its window.
        let windowed = matches!(&spec.data[r], DataSpec::Synthetic(s) if s.window.is_some());
        for (state, x) in input.case.system.states.iter().zip(&record.start).filter(|_| !windowed) {
            text.set(&["data", &r.to_string(), "start", &state.name], &number(x / state.factor))?;
        }
        if matches!(spec.data[r], DataSpec::Synthetic(_)) {
            text.set(&["data", &r.to_string(), "truth"], "{}")?;
        }
    }
    let word = found.verdict.word();
    let word = if found.verdict.holds() { word.to_owned() } else { word.to_uppercase() };
    let verdict = found.verdict.reason().map_or(word.clone(), |why| format!("{word}: {why}"));
    let measured = spec.data.iter().any(|d| matches!(d, DataSpec::Csv(_)));
    let data = if measured { "      (with --data DIR where its data files have moved)" } else { "" };
    let head = format!(
        "{}{}` (version {}) found: {verdict}.\n// The identified terms stand in `known`, their coefficients and the fitted \
         numbers in `constants`, `sensors` and `start`. To predict:\n//     phisindy simulate identified.ron{data}\n",
        head("run"),
        input.name,
        env!("CARGO_PKG_VERSION")
    );
    let text = head + &text.0;
    let (spec, _) = spec::read_with_files(&text, SourceId(0), &input.spec.files).map_err(|d| first(&d))?;
    phisindy_phys::check(&spec, SourceId(0)).map_err(|d| first(&d))?;
    Ok(text)
}

/// Writes the identified terms into the known rates and their coefficients into the constants.
fn rates(text: &mut Text, spec: &Spec, input: Input<'_>, found: &Identified) -> Result<(), String> {
    let system = &input.case.system;
    let units = speaks_of_units(spec);
    let mut given: Vec<String> = Vec::new();
    for (k, state) in system.states.iter().enumerate() {
        let own: Vec<_> = found.terms.iter().filter(|f| system.terms[f.term].state == k).collect();
        let named = |name: &phisindy_phys::spec::Text| name.value == state.name;
        let unknown = spec.unknown.iter().find(|(name, _)| named(name)).map(|(_, u)| u);
        let known = spec.known.iter().find(|(name, _)| named(name)).map(|(_, text)| text.value.as_str());
        // What acts along a speed of a mechanism is one more of its forces.
        let moved = spec.is_moved(&state.name);
        let known = known.or(moved.then_some("0"));
        let (Some(unknown), Some(known), false) = (unknown, known, own.is_empty()) else { continue };
        let mut terms = Vec::new();
        for (place, f) in own.iter().enumerate() {
            let term = &system.terms[f.term];
            let stem = format!("c_{}", state.name);
            let wish = if own.len() == 1 { stem } else { format!("{stem}_{}", place + 1) };
            let name = free(wish, input, &given);
            given.push(name.clone());
            let unit = term.unit.filter(|_| units).and_then(written_unit);
            let value = number(f.coefficient.value);
            text.set(
                &["constants", &name],
                &unit.map_or(value.clone(), |unit| format!("({value}, \"{unit}\")")),
            )?;
            terms.push((name, term.candidate.as_str()));
        }
        let whole = rate(known, unknown, &terms);
        if moved {
            text.set(&[spec.forces_along(&state.name), "forces", &whole], &format!("\"{}\"", state.name))?;
        } else {
            text.set(&["known", &state.name], &format!("\"{whole}\""))?;
        }
    }
    if !spec.unknown.is_empty() {
        text.set(&["unknown"], "{}")?;
    }
    Ok(())
}

/// Whether constants have units. One unit among plain numbers would have all of them checked.
fn speaks_of_units(spec: &Spec) -> bool {
    spec.constants.iter().any(|(_, c)| match c {
        ConstantSpec::Number { unit, .. } => unit.is_some(),
        ConstantSpec::Movable(m) => m.unit.is_some(),
        ConstantSpec::Find(f) => f.unit.is_some(),
        ConstantSpec::Expression(_) | ConstantSpec::MaxAbs(_) => false,
    })
}

/// A unit as a spec writes it; none for a plain number or a unit without such a form.
fn written_unit(dimension: Dimension) -> Option<String> {
    let text = dimension.to_string();
    let same = Unit::parse(&text).is_ok_and(|unit| unit.dimension == dimension && unit.factor == 1.0);
    (same && !dimension.is_none()).then_some(text)
}

/// A name that neither the spec nor another coefficient has.
fn free(mut name: String, input: Input<'_>, given: &[String]) -> String {
    while input.case.system.names.get(&name).is_some() || given.contains(&name) {
        name.push('_');
    }
    name
}

/// `known + factor*(c1*candidate1 + ...)`, simplified as people write it.
fn rate(known: &str, unknown: &UnknownSpec, terms: &[(String, &str)]) -> String {
    let factor = unknown.factor.as_ref().map_or("1", |f| f.value.trim());
    // A leading minus applies to the whole product.
    let (minus, factor) = match root(factor) {
        Some(AstKind::Unary(Unary::Neg, _)) if factor.starts_with('-') => (true, factor[1..].trim()),
        _ => (false, factor),
    };
    let factor = if factor == "1" { None } else { Some(bracketed(factor)) };
    let mut out = if known.trim() == "0" { String::new() } else { known.to_owned() };
    let mut add = |part: &str| {
        out.push_str(match (out.is_empty(), minus) {
            (true, true) => "-",
            (true, false) => "",
            (false, true) => " - ",
            (false, false) => " + ",
        });
        out.push_str(part);
    };
    let product = |(name, candidate): &(String, &str)| match candidate.trim() {
        "1" => name.clone(),
        other => format!("{name}*{}", bracketed(other)),
    };
    match (factor, terms) {
        (Some(factor), [one]) => add(&format!("{}*{factor}", product(one))),
        (Some(factor), _) => {
            let sum: Vec<String> = terms.iter().map(product).collect();
            add(&format!("{factor}*({})", sum.join(" + ")));
        }
        (None, _) => terms.iter().for_each(|term| add(&product(term))),
    }
    out
}

fn root(text: &str) -> Option<AstKind> {
    Some(parse(text).ok()?.nodes.last()?.kind.clone())
}

/// An expression as a factor of a product, in brackets if it needs them.
fn bracketed(text: &str) -> String {
    match root(text) {
        Some(AstKind::Binary(Binary::Add | Binary::Sub, ..) | AstKind::Unary(Unary::Neg, _)) => {
            format!("({text})")
        }
        _ => text.to_owned(),
    }
}

/// Writes fitted numbers into constants and sensors.
fn parameters(text: &mut Text, spec: &Spec, input: Input<'_>, found: &Identified) -> Result<(), String> {
    for p in &found.parameters {
        let value = p.estimate.value / p.factor;
        match (&p.id.of, p.id.record()) {
            (ParameterOf::Constant { name, .. }, None) => constant(text, spec, name, value)?,
            (ParameterOf::Constant { index, name }, Some(r)) => match filter_of(input, *index) {
                Some((column, kind)) => {
                    for r in records_of(input, r) {
                        cutoff(text, r, column, kind, p.estimate.value)?;
                    }
                }
                None => of_record(text, spec, input, name, r, p)?,
            },
            (ParameterOf::Sensor { .. }, Some(r)) => sensor(text, input, r, p)?,
            (ParameterOf::Sensor { .. }, None) => {}
        }
    }
    Ok(())
}

/// A movable constant stays movable and starts at its fitted value.
fn constant(text: &mut Text, spec: &Spec, name: &str, value: f64) -> Result<(), String> {
    let own = spec.constants.iter().find(|(n, _)| n.value == name);
    let Some((_, constant)) = own else { return restitution(text, spec, name, value) };
    let (field, within) = match constant {
        ConstantSpec::Movable(m) => ("value", &m.within),
        ConstantSpec::Find(f) => ("start", &f.within),
        _ => return Ok(()),
    };
    // Conversion to SI and back may move a value past its bound by one bit.
    text.set(&["constants", name, field], &number(value.clamp(within.0.value, within.1.value)))
}

/// The restitution of an impact starts at its fitted value.
fn restitution(text: &mut Text, spec: &Spec, name: &str, value: f64) -> Result<(), String> {
    let of = name.strip_suffix(".restitution").unwrap_or_default();
    let own = spec.impacts.iter().find(|(n, _)| n.value == of).map(|(_, impact)| &impact.restitution);
    let Some(SensorValue::Find(find)) = own else { return Ok(()) };
    let value = value.clamp(find.within.0.value, find.within.1.value);
    text.set(&["impacts", of, "restitution", "start"], &number(value))
}

/// A constant with one value per record becomes a constant of the records.
fn of_record(
    text: &mut Text,
    spec: &Spec,
    input: Input<'_>,
    name: &str,
    record: usize,
    p: &FoundParameter,
) -> Result<(), String> {
    let value = p.estimate.value / p.factor;
    // The default for records that have none of their own.
    text.set(&["constants", name], &with_unit(value, &p.unit))?;
    for r in 0..spec.data.len() {
        if r == record || input.records.get(r).is_some_and(|other| other.continues == Some(record)) {
            of_data(text, r, name, value, &p.unit)?;
        }
    }
    Ok(())
}

/// The constant of one record.
fn of_data(text: &mut Text, record: usize, name: &str, value: f64, unit: &str) -> Result<(), String> {
    text.set(&["data", &record.to_string(), "constants", name], &with_unit(value, unit))
}

/// The filter whose cutoff a parameter is: its column and the field of the sensor.
fn filter_of(input: Input<'_>, parameter: usize) -> Option<(&str, &'static str)> {
    let system = &input.case.system;
    let filter = system.filters.iter().find(|f| f.own_parameter == Some(parameter))?;
    Some((&system.outputs[filter.output].name, filter.kind.name()))
}

/// The cutoff of a record's filter in Hz.
fn cutoff(text: &mut Text, record: usize, column: &str, kind: &str, value: f64) -> Result<(), String> {
    let path = ["data", &record.to_string(), "sensors", column, kind, "cutoff"];
    text.set(&path, &with_unit(value, "Hz"))
}

/// A number as a spec writes it.
fn with_unit(value: f64, unit: &str) -> String {
    if unit.is_empty() { number(value) } else { format!("({}, \"{unit}\")", number(value)) }
}

/// A fitted sensor parameter becomes a fixed number.
fn sensor(text: &mut Text, input: Input<'_>, record: usize, p: &FoundParameter) -> Result<(), String> {
    let Some((column, part)) = sensor_of(p) else { return Ok(()) };
    for r in records_of(input, record) {
        // Plain numbers of sensors are in SI units.
        text.set(&["data", &r.to_string(), "sensors", column, part.name()], &number(p.estimate.value))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use phisindy_expr::Span;

    fn spliced(known: &str, factor: Option<&str>, terms: &[(&str, &str)]) -> String {
        let text = |t: &str| phisindy_phys::spec::Text { value: t.to_owned(), span: Span::new(0, 0) };
        let unknown = UnknownSpec {
            factor: factor.map(text),
            candidates: vec![],
            within: vec![],
            laws: vec![],
            search: vec![],
            span: Span::new(0, 0),
        };
        let terms: Vec<(String, &str)> = terms.iter().map(|&(name, c)| (name.to_owned(), c)).collect();
        let rate = rate(known, &unknown, &terms);
        assert!(parse(&rate).is_ok(), "{rate}");
        rate
    }

    #[test]
    fn terms_follow_the_known_rate() {
        assert_eq!(spliced("-k*x", Some("-sgn(y)/m"), &[("c", "1")]), "-k*x - c*sgn(y)/m");
        assert_eq!(spliced("-k*x", Some("sgn(y)"), &[("c", "1")]), "-k*x + c*sgn(y)");
        assert_eq!(
            spliced("-k*x", Some("-sgn(y)"), &[("c1", "1"), ("c2", "x^2"), ("c3", "x - y")]),
            "-k*x - sgn(y)*(c1 + c2*x^2 + c3*(x - y))"
        );
        assert_eq!(spliced("0", Some("-1/m"), &[("c", "x")]), "-c*x*1/m");
        assert_eq!(spliced("-x", None, &[("a", "sgn(y)"), ("b", "y")]), "-x + a*sgn(y) + b*y");
        assert_eq!(spliced("-x", Some("-1"), &[("a", "w"), ("b", "-w")]), "-x - a*w - b*(-w)");
        assert_eq!(spliced("-x", Some("a - b"), &[("c", "w")]), "-x + c*w*(a - b)");
        assert_eq!(spliced("-x", Some("-a + b"), &[("c", "w")]), "-x + c*w*(-a + b)");
    }

    #[test]
    fn a_unit_that_a_spec_can_write_is_written() {
        assert_eq!(written_unit(Dimension::NEWTON.div(Dimension::METRE)).as_deref(), Some("N/m"));
        assert_eq!(written_unit(Dimension::NONE), None);
    }
}
