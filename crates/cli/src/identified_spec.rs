//! `identified.ron`: the spec's text with what was identified in it, so that `simulate` predicts. Comments and everything else stay.

use crate::load::Loaded;
use phisindy_expr::{AstKind, Binary, Unary, parse};
use phisindy_learn::{FoundParameter, Identified, Verdict};
use phisindy_phys::spec::{ConstantSpec, DataSpec, Spec, UnknownSpec};
use phisindy_phys::{SourceId, spec, splice};

/// The text.
///
/// # Errors
/// In words: the text cannot hold what was identified (a mistake of this program, or a spec that uses a form it does not know).
pub(crate) fn written(loaded: &Loaded, found: &Identified) -> Result<String, String> {
    let (spec, _) = spec::read(&loaded.text, SourceId(0)).map_err(|_| "the spec cannot be read again")?;
    let mut text = Text(loaded.text.clone());
    rates(&mut text, &spec, loaded, found)?;
    parameters(&mut text, &spec, loaded, found)?;
    for (r, record) in found.records.iter().enumerate() {
        // The start of a synthetic record is that of its run, not that of the window which was seen.
        let windowed = matches!(&spec.data[r], DataSpec::Synthetic(s) if s.window.is_some());
        for (state, x) in loaded.case.system.states.iter().zip(&record.start).filter(|_| !windowed) {
            text.set(&["data", &r.to_string(), "start", &state.name], &number(x / state.factor))?;
        }
        if matches!(spec.data[r], DataSpec::Synthetic(_)) {
            text.set(&["data", &r.to_string(), "truth"], "{}")?;
        }
    }
    let verdict = match &found.verdict {
        Verdict::Identified => "identified".to_owned(),
        Verdict::Rejected(why) => format!("REJECTED: {why}"),
    };
    let head = format!(
        "// What `phisindy run {}` (version {}) found: {verdict}.\n// The identified terms stand in `known`, the fitted numbers in `constants`, \
         `sensors` and `start`. To predict:\n//     phisindy simulate identified.ron\n",
        loaded.spec,
        env!("CARGO_PKG_VERSION")
    );
    let text = head + &text.0;
    let (spec, _) = spec::read(&text, SourceId(0)).map_err(|d| first(&d))?;
    phisindy_phys::check(&spec, SourceId(0)).map_err(|d| first(&d))?;
    Ok(text)
}

fn first(diagnostics: &[phisindy_phys::Diagnostic]) -> String {
    diagnostics.iter().find(|d| d.is_error()).map_or(String::new(), |d| d.message.clone())
}

/// A spec that changes.
struct Text(String);

impl Text {
    fn set(&mut self, path: &[&str], value: &str) -> Result<(), String> {
        // Names may hold dots in quotes only.
        let part = |p: &&str| if p.contains('.') { format!("\"{p}\"") } else { (*p).to_owned() };
        let path = path.iter().map(part).collect::<Vec<_>>().join(".");
        self.0 = splice::set(&self.0, &path, value).map_err(|e| e.to_string())?;
        Ok(())
    }
}

/// The identified terms into the known rates.
fn rates(text: &mut Text, spec: &Spec, loaded: &Loaded, found: &Identified) -> Result<(), String> {
    let system = &loaded.case.system;
    for (k, state) in system.states.iter().enumerate() {
        let terms: Vec<(f64, &str)> = found
            .terms
            .iter()
            .filter(|f| system.terms[f.term].state == k)
            .map(|f| (f.coefficient.value, system.terms[f.term].candidate.as_str()))
            .collect();
        let named = |name: &phisindy_phys::spec::Text| name.value == state.name;
        let unknown = spec.unknown.iter().find(|(name, _)| named(name)).map(|(_, u)| u);
        let known = spec.known.iter().find(|(name, _)| named(name)).map(|(_, text)| text.value.as_str());
        let (Some(unknown), Some(known), false) = (unknown, known, terms.is_empty()) else { continue };
        text.set(&["known", &state.name], &format!("\"{}\"", rate(known, unknown, &terms)))?;
    }
    if !spec.unknown.is_empty() {
        text.set(&["unknown"], "{}")?;
    }
    Ok(())
}

/// `known + factor*(c1*candidate1 + ...)`, as people write it.
fn rate(known: &str, unknown: &UnknownSpec, terms: &[(f64, &str)]) -> String {
    let factor = unknown.factor.as_ref().map_or("1", |f| f.value.trim());
    // A leading minus takes the whole product, and with it the sum.
    let (minus, factor) = match root(factor) {
        Some(AstKind::Unary(Unary::Neg, _)) if factor.starts_with('-') => (true, factor[1..].trim()),
        _ => (false, factor),
    };
    let factor = if factor == "1" { None } else { Some(bracketed(factor)) };
    let mut out = if known.trim() == "0" { String::new() } else { known.to_owned() };
    let mut add = |negative: bool, part: &str| {
        out.push_str(match (out.is_empty(), negative) {
            (true, true) => "-",
            (true, false) => "",
            (false, true) => " - ",
            (false, false) => " + ",
        });
        out.push_str(part);
    };
    let product = |c: f64, candidate: &str| match candidate.trim() {
        "1" => number(c.abs()),
        other => format!("{}*{}", number(c.abs()), bracketed(other)),
    };
    match (factor, terms) {
        (Some(factor), [(c, candidate)]) => {
            add(minus ^ (*c < 0.0), &format!("{}*{factor}", product(*c, candidate)))
        }
        (Some(factor), _) => {
            let mut sum = String::new();
            for &(c, candidate) in terms {
                sum.push_str(match (sum.is_empty(), c < 0.0) {
                    (true, true) => "-",
                    (true, false) => "",
                    (false, true) => " - ",
                    (false, false) => " + ",
                });
                sum.push_str(&product(c, candidate));
            }
            add(minus, &format!("{factor}*({sum})"));
        }
        (None, _) => terms.iter().for_each(|&(c, candidate)| add(minus ^ (c < 0.0), &product(c, candidate))),
    }
    out
}

fn root(text: &str) -> Option<AstKind> {
    Some(parse(text).ok()?.nodes.last()?.kind.clone())
}

/// An expression as a factor of a product.
fn bracketed(text: &str) -> String {
    match root(text) {
        Some(AstKind::Binary(Binary::Add | Binary::Sub, ..) | AstKind::Unary(Unary::Neg, _)) => {
            format!("({text})")
        }
        _ => text.to_owned(),
    }
}

/// Fitted numbers into constants and sensors.
fn parameters(text: &mut Text, spec: &Spec, loaded: &Loaded, found: &Identified) -> Result<(), String> {
    for p in &found.parameters {
        let value = p.estimate.value / p.factor;
        match (p.parameter, p.record) {
            (Some(_), None) => constant(text, spec, &p.name, value)?,
            (Some(k), Some(r)) => {
                of_record(text, spec, loaded, &loaded.case.system.parameters[k].name, r, p)?
            }
            (None, Some(r)) => sensor(text, loaded, r, p)?,
            (None, None) => {}
        }
    }
    Ok(())
}

/// A movable constant goes on moving, from where the fit ended.
fn constant(text: &mut Text, spec: &Spec, name: &str, value: f64) -> Result<(), String> {
    let Some((_, constant)) = spec.constants.iter().find(|(n, _)| n.value == name) else { return Ok(()) };
    let (field, within) = match constant {
        ConstantSpec::Movable(m) => ("value", &m.within),
        ConstantSpec::Find(f) => ("start", &f.within),
        _ => return Ok(()),
    };
    // A bound that went to SI and back may have moved by a bit.
    text.set(&["constants", name, field], &number(value.clamp(within.0.value, within.1.value)))
}

/// A constant with a value for each record becomes a constant of the records.
fn of_record(
    text: &mut Text,
    spec: &Spec,
    loaded: &Loaded,
    name: &str,
    record: usize,
    p: &FoundParameter,
) -> Result<(), String> {
    let value = format!("({}, \"{}\")", number(p.estimate.value / p.factor), p.unit);
    let value = if p.unit.is_empty() { number(p.estimate.value / p.factor) } else { value };
    // The default, for records that were not fitted.
    text.set(&["constants", name], &value)?;
    for r in 0..spec.data.len() {
        if r == record || loaded.records.get(r).is_some_and(|other| other.continues == Some(record)) {
            text.set(&["data", &r.to_string(), "constants", name], &value)?;
        }
    }
    Ok(())
}

/// What was found of a sensor is held.
fn sensor(text: &mut Text, loaded: &Loaded, record: usize, p: &FoundParameter) -> Result<(), String> {
    let plain = p.name.split(" [").next().unwrap_or(&p.name);
    let Some((column, which)) = plain.rsplit_once('.') else { return Ok(()) };
    for (r, other) in loaded.records.iter().enumerate() {
        if r == record || other.continues == Some(record) {
            // Plain numbers of sensors are in SI.
            text.set(&["data", &r.to_string(), "sensors", column, which], &number(p.estimate.value))?;
        }
    }
    Ok(())
}

/// The shortest text that reads back as the same number.
fn number(x: f64) -> String {
    format!("{x:?}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use phisindy_expr::Span;

    fn spliced(known: &str, factor: Option<&str>, terms: &[(f64, &str)]) -> String {
        let text = |t: &str| phisindy_phys::spec::Text { value: t.to_owned(), span: Span::new(0, 0) };
        let unknown = UnknownSpec {
            factor: factor.map(text),
            candidates: vec![],
            within: vec![],
            laws: vec![],
            span: Span::new(0, 0),
        };
        let rate = rate(known, &unknown, terms);
        assert!(parse(&rate).is_ok(), "{rate}");
        rate
    }

    #[test]
    fn terms_follow_the_known_rate() {
        assert_eq!(spliced("-k*x", Some("-sgn(y)/m"), &[(0.5, "1")]), "-k*x - 0.5*sgn(y)/m");
        assert_eq!(spliced("-k*x", Some("-sgn(y)"), &[(-0.5, "1")]), "-k*x + 0.5*sgn(y)");
        assert_eq!(
            spliced("-k*x", Some("-sgn(y)"), &[(0.5, "1"), (-0.25, "x^2"), (1e-7, "x - y")]),
            "-k*x - sgn(y)*(0.5 - 0.25*x^2 + 1e-7*(x - y))"
        );
        assert_eq!(spliced("0", Some("-1/m"), &[(2.0, "x")]), "-2.0*x*1/m");
        assert_eq!(spliced("-x", None, &[(2.0, "sgn(y)"), (-1.0, "y")]), "-x + 2.0*sgn(y) - 1.0*y");
        assert_eq!(spliced("-x", Some("-1"), &[(2.0, "w"), (1.0, "-w")]), "-x - 2.0*w - 1.0*(-w)");
        assert_eq!(spliced("-x", Some("a - b"), &[(2.0, "w")]), "-x + 2.0*w*(a - b)");
        assert_eq!(spliced("-x", Some("-a + b"), &[(2.0, "w")]), "-x + 2.0*w*(-a + b)");
    }
}
