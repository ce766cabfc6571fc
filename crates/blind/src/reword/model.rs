//! The same model in other words: names, coordinates, spellings and units.

use super::answer::Back;
use super::data::{moved, other};
use super::question::{Question, expressions, heading, names as places_of_names, put, records};
use super::rewording::Reworded;
use crate::dice::Dice;
use phisindy_expr::{Ast, AstKind, Binary, Span, Unary, parse_with};
use phisindy_phys::spec::{ConstantSpec, Number, Spec, Text};
use phisindy_phys::splice::quoted;

/// Names that nobody chose with care.
const NAMES: &[&str] = &["q", "w_", "Weg", "ξ", "a_long_name_", "Z"];

/// Whether rates are written out, so that an expression in place of a state says the same; and no record says more
/// about a state than its column.
fn plain(spec: &Spec) -> bool {
    let rates = spec.energy.is_none() && spec.between.is_empty() && spec.places.is_empty();
    let unknown =
        spec.unknown.iter().all(|(_, u)| u.laws.is_empty() && u.search.is_empty() && u.within.is_empty());
    rates && unknown && records(spec).all(|r| r.start.is_empty() && r.sensors.is_empty())
}

fn pair(a: &str, b: &str) -> (String, String) {
    (a.to_owned(), b.to_owned())
}

/// Displacements and their speeds.
fn bodies(spec: &Spec) -> Vec<(&str, &str)> {
    let moves =
        spec.known.iter().filter(|(_, rate)| spec.states.iter().any(|(name, _)| name.value == rate.value));
    moves.map(|(x, v)| (x.value.as_str(), v.value.as_str())).collect()
}

/// The text of a rate, as it is known.
fn rate<'s>(spec: &'s Spec, state: &str) -> Option<&'s Text> {
    spec.known.iter().find(|(name, _)| name.value == state).map(|(_, rate)| rate)
}

pub(super) fn names(mut question: Question, spec: &Spec, dice: &mut Dice) -> Option<Reworded> {
    if spec.energy.is_some() || !spec.places.is_empty() || !spec.between.is_empty() {
        return None;
    }
    let constants = spec.constants.iter().map(|(name, _)| name);
    let states = spec.states.iter().chain(&spec.inputs).chain(&spec.definitions).map(|(name, _)| name);
    let all: Vec<&Text> = constants.chain(states).chain(spec.outputs.iter().map(|(name, _)| name)).collect();
    let fresh = |(k, name): (usize, &&Text)| (name.value.clone(), format!("{}{k}", dice.pick(NAMES)));
    let mut with: Vec<(String, String)> = all.iter().enumerate().map(fresh).collect();
    let rates: Vec<_> =
        with.iter().map(|(old, new)| (format!("rate {old}"), format!("rate({new})"))).collect();
    with.extend(rates);
    let mut places: Vec<(Span, String)> = places_of_names(spec)
        .into_iter()
        .chain(expressions(spec))
        .map(|e| (e.span, put(&e.value, &with)))
        .collect();
    for record in records(spec) {
        let columns = record.columns.iter().map(|(_, column)| column).chain([&record.time]);
        let heads = columns.map(|column| (column.header.span, format!("h_{}", column.header.value)));
        places.extend(heads);
        if let Some(sheet) = question.sheets.get_mut(&record.path.value) {
            let told = |head: &String| head.starts_with("h_");
            sheet.heads.iter_mut().filter(|head| !told(head)).for_each(|head| *head = format!("h_{head}"));
        }
    }
    let names = with.into_iter().map(|(old, new)| (new, old)).collect();
    Some(Reworded { question: question.edited(places), back: Back { names, ..Back::default() } })
}

/// Expressions with others in place of states; what stands for a rate is turned with it.
fn with_states(question: Question, spec: &Spec, with: &[(String, String)], turned: &[&str]) -> Question {
    let moves = bodies(spec);
    let keeps = |e: &Text| {
        let speed =
            |(x, rate): &(Text, Text)| rate == e && moves.contains(&(x.value.as_str(), rate.value.as_str()));
        spec.contacts.contains(e) || spec.known.iter().any(speed)
    };
    let mut places: Vec<(Span, String)> = Vec::new();
    for e in expressions(spec) {
        if !keeps(e) {
            places.push((e.span, put(&e.value, with)));
        }
    }
    for (state, rate) in
        spec.known.iter().filter(|(state, rate)| turned.contains(&&*state.value) && !keeps(rate))
    {
        places.retain(|(span, _)| *span != rate.span);
        places.push((rate.span, format!("-({})", put(&rate.value, with))));
        for (_, unknown) in spec.unknown.iter().filter(|(name, _)| name.value == state.value) {
            let Some(factor) = &unknown.factor else { continue };
            places.retain(|(span, _)| *span != factor.span);
            places.push((factor.span, format!("-({})", put(&factor.value, with))));
        }
    }
    question.edited(places)
}

pub(super) fn sign(mut question: Question, spec: &Spec, dice: &mut Dice) -> Option<Reworded> {
    let bodies = bodies(spec);
    let factors = spec.unknown.iter().all(|(_, unknown)| unknown.factor.is_some());
    if bodies.is_empty() || !plain(spec) || !factors {
        return None;
    }
    // Differences of speeds stay such where all are turned.
    let alone = |contact: &Text| spec.states.iter().any(|(name, _)| name.value == contact.value);
    let chosen = if spec.contacts.iter().all(alone) { vec![*dice.pick(&bodies)] } else { bodies };
    let turned: Vec<&str> = chosen.iter().flat_map(|(x, v)| [*x, *v]).collect();
    let mut with: Vec<_> = turned.iter().map(|name| ((*name).to_owned(), format!("(-{name})"))).collect();
    with.extend(turned.iter().map(|name| (format!("rate {name}"), format!("(-rate({name}))"))));
    let mut any = spec.outputs.iter().any(|_| true);
    for name in &turned {
        let minus =
            |text: &str| Some(text.strip_prefix('-').map_or_else(|| format!("-{text}"), str::to_owned));
        any |= question.rewrite(name, spec, minus).is_some();
    }
    let question = with_states(question, spec, &with, &turned);
    any.then(|| Reworded { question, back: Back { names: with, turned: true, ..Back::default() } })
}

pub(super) fn origin(mut question: Question, spec: &Spec, dice: &mut Dice) -> Option<Reworded> {
    let bodies = bodies(spec);
    if bodies.is_empty() || !plain(spec) {
        return None;
    }
    let (x, _) = *dice.pick(&bodies);
    let column = heading(records(spec).next()?, x)?;
    let unit = column
        .unit
        .as_ref()
        .map_or(1.0, |u| phisindy_phys::unit::Unit::parse(&u.value).map_or(1.0, |u| u.factor));
    let mut largest = 0.0_f64;
    question.clone().rewrite(x, spec, |text| {
        largest = largest.max(text.parse::<f64>().ok()?.abs());
        Some(text.to_owned())
    })?;
    let shift = crate::dice::rounded(largest * dice.between(0.5, 2.0) * dice.sign());
    question.rewrite(x, spec, |text| Some(format!("{:?}", text.parse::<f64>().ok()? + shift)))?;
    let with = [(x.to_owned(), format!("({x} - ({:e}))", shift * unit))];
    let back = vec![(x.to_owned(), format!("({x} + ({:e}))", shift * unit))];
    let question = with_states(question, spec, &with, &[]);
    Some(Reworded { question, back: Back { names: back, moved: true, ..Back::default() } })
}

pub(super) fn relative(question: Question, spec: &Spec, _: &mut Dice) -> Option<Reworded> {
    let bodies = bodies(spec);
    let rubs = |v: &str| spec.unknown.iter().any(|(name, _)| name.value == v);
    let [(x1, v1), (x2, v2)] = bodies[..] else { return None };
    // The second coordinate goes: what rubs there moves nothing else.
    let [(xa, va), (xb, vb)] = match (rubs(v1), rubs(v2)) {
        (true, true) => return None,
        (true, false) => [(x2, v2), (x1, v1)],
        _ => [(x1, v1), (x2, v2)],
    };
    if !plain(spec) || spec.states.len() != 4 || !spec.outputs.is_empty() {
        return None;
    }
    let with = [pair(xb, &format!("({xa} - rel)")), pair(vb, &format!("({va} - slip)"))];
    let (rate_a, rate_b) = (rate(spec, va)?, rate(spec, vb)?);
    let relative = format!("({}) - ({})", put(&rate_a.value, &with), put(&rate_b.value, &with));
    let unit =
        |state: &str| spec.states.iter().find(|(name, _)| name.value == state).map(|(_, u)| u.value.clone());
    let (mut states, mut known, mut inertia) = (vec![], vec![], vec![]);
    for (name, unit) in &spec.states {
        let name = [(xb, "rel"), (vb, "slip")]
            .iter()
            .find(|(old, _)| *old == name.value)
            .map_or(&*name.value, |n| n.1);
        states.push(format!("\"{name}\": {}", quoted(&unit.value)));
    }
    for (name, text) in [(xa, va), (va, &*put(&rate_a.value, &with)), ("rel", "slip"), ("slip", &*relative)] {
        known.push(format!("\"{name}\": {}", quoted(text)));
    }
    if let [(_, ma), (_, mb)] = &spec.inertia[..] {
        let (ma, mb) = if va == v1 { (ma, mb) } else { (mb, ma) };
        let (ma, mb) = (&ma.value, &mb.value);
        inertia.push(format!(
            "\"{va}\": {{ \"{va}\": \"{ma} + {mb}\", \"slip\": \"-{mb}\" }}, \"slip\": \"{mb}\""
        ));
    }
    let contact = |c: &Text| match c.value.replace(' ', "") {
        text if text == vb => Some(format!("\"{va} - slip\"")),
        text if text == va => Some(quoted(va)),
        text if text == format!("{v1}-{v2}") || text == format!("{v2}-{v1}") => Some(quoted("slip")),
        _ => None,
    };
    let contacts: Option<Vec<String>> = spec.contacts.iter().map(contact).collect();
    let mut unknown = vec![];
    for (name, u) in &spec.unknown {
        let (factor, sign) =
            (u.factor.as_ref().map_or("1", |f| &f.value), if name.value == vb { "-" } else { "" });
        let candidates: Vec<_> = u.candidates.iter().map(|c| quoted(&put(&c.value, &with))).collect();
        let factor = quoted(&format!("{sign}({})", put(factor, &with)));
        unknown.push(format!("\"slip\": (factor: {factor}, candidates: [{}])", candidates.join(", ")));
    }
    let mut outputs = vec![];
    let mut places = vec![];
    for (state, reading) in [(xb, "reading_x"), (vb, "reading_v")] {
        let mut keys =
            records(spec).flat_map(|r| &r.columns).filter(|(name, _)| name.value == state).peekable();
        if keys.peek().is_some() {
            let reads = put(state, &with);
            outputs.push(format!("\"{reading}\": (unit: {}, reads: \"{reads}\")", quoted(&unit(state)?)));
        }
        places.extend(keys.map(|(name, _)| (name.span, reading.to_owned())));
    }
    let map = |entries: Vec<String>| format!("{{ {} }}", entries.join(", "));
    let mut question = question.edited(places);
    for (field, value) in [
        ("states", map(states)),
        ("known", map(known)),
        ("contacts", format!("[{}]", contacts?.join(", "))),
        ("unknown", map(unknown)),
        ("outputs", map(outputs)),
        ("inertia", map(inertia)),
    ] {
        if value != "{  }" && value != "[]" {
            question = question.set(&[field], &value)?;
        }
    }
    let names = vec![
        pair("rel", &format!("({xa} - {xb})")),
        pair("slip", &format!("({va} - {vb})")),
        pair("reading_x", xb),
        pair("reading_v", vb),
    ];
    Some(Reworded { question, back: Back { names, rates: vec![pair("slip", vb)], ..Back::default() } })
}

/// An expression with its sums and products turned around, halves in place of divisions by two.
fn turned_around(ast: &Ast, at: usize, text: &str) -> String {
    let node = &ast.nodes[at];
    let of = |k: usize| turned_around(ast, k, text);
    let is_two = |k: usize| ast.nodes[k].kind == AstKind::Number(2.0);
    match &node.kind {
        AstKind::Number(_) | AstKind::Name(_) | AstKind::Table { .. } => text[node.span.range()].to_owned(),
        AstKind::Unary(Unary::Neg, a) => format!("(-{})", of(*a)),
        AstKind::Binary(Binary::Add, a, b) => format!("({} + {})", of(*b), of(*a)),
        AstKind::Binary(Binary::Sub, a, b) => format!("(-{} + {})", of(*b), of(*a)),
        AstKind::Binary(Binary::Mul, a, b) => format!("({}*{})", of(*b), of(*a)),
        AstKind::Binary(Binary::Div, a, b) if is_two(*b) => format!("(0.5*{})", of(*a)),
        AstKind::Binary(Binary::Div, a, b) => format!("({}/{})", of(*a), of(*b)),
        AstKind::Binary(Binary::Pow, a, b) => format!("({}^{})", of(*a), of(*b)),
        // The rest are functions, or bars.
        AstKind::Unary(_, a) | AstKind::Binary(_, a, _) => {
            let written = &text[node.span.range()];
            let name = written.split_once('(').map_or("", |(name, _)| name);
            let name = if written.starts_with('|') { "abs" } else { name };
            let second =
                if let AstKind::Binary(_, _, b) = node.kind { format!(", {}", of(b)) } else { String::new() };
            format!("{name}({}{second})", of(*a))
        }
    }
}

/// An expression changed by `to`, which sees its tree; a single name stays.
fn changed(text: &str, to: impl Fn(&Ast, usize) -> Option<String>) -> Option<String> {
    let ast = parse_with(text, &["rate"]).ok()?;
    let root = ast.nodes.len().checked_sub(2)? + 1;
    to(&ast, root)
}

pub(super) fn turned(question: Question, spec: &Spec, _: &mut Dice) -> Option<Reworded> {
    let around = |e: &Text| {
        let text = changed(&e.value, |ast, root| Some(turned_around(ast, root, &e.value)))?;
        Some((e.span, text))
    };
    let places =
        expressions(spec).into_iter().filter(|e| !spec.contacts.contains(e)).filter_map(around).collect();
    Some(question.edited(places).into())
}

pub(super) fn factored(question: Question, spec: &Spec, _: &mut Dice) -> Option<Reworded> {
    let out = |(_, rate): &(Text, Text)| {
        let text = changed(&rate.value, |ast, root| match ast.nodes[root].kind {
            AstKind::Binary(Binary::Div, a, b) => {
                let part = |k| turned_around(ast, k, &rate.value);
                Some(format!("1/{}*{}", part(b), part(a)))
            }
            _ => None,
        })?;
        Some((rate.span, text))
    };
    let places: Vec<_> = spec.known.iter().filter_map(out).collect();
    (!places.is_empty()).then(|| question.edited(places).into())
}

pub(super) fn named(question: Question, spec: &Spec, _: &mut Dice) -> Option<Reworded> {
    let states: Vec<&str> = spec.states.iter().map(|(name, _)| name.value.as_str()).collect();
    let (_, rate) = spec.known.iter().find(|(_, rate)| !states.contains(&rate.value.as_str()))?;
    if spec.energy.is_some() {
        return None;
    }
    let question = question.edited(vec![(rate.span, "by_another_name".to_owned())]);
    question.set(&["let", "by_another_name"], &quoted(&rate.value)).map(Reworded::from)
}

/// A constant that is a number with a unit and no record has for itself, drawn.
fn number<'s>(
    spec: &'s Spec,
    dice: &mut Dice,
    fits: impl Fn(&str) -> bool,
) -> Option<(&'s str, &'s Number, &'s str)> {
    let own = |name: &Text| records(spec).any(|r| r.constants.iter().any(|(n, _)| n.value == name.value));
    let all: Vec<_> = spec
        .constants
        .iter()
        .filter_map(|(name, constant)| match constant {
            ConstantSpec::Number { value, unit: Some(unit) } if fits(&unit.value) && !own(name) => {
                Some((name.value.as_str(), value, unit.value.as_str()))
            }
            _ => None,
        })
        .collect();
    (!all.is_empty()).then(|| *dice.pick(&all))
}

pub(super) fn constant(question: Question, spec: &Spec, dice: &mut Dice) -> Option<Reworded> {
    let (name, value, unit) = number(spec, dice, |_| true)?;
    let half = format!("({:?}, {})", 0.5 * value.value, quoted(unit));
    let question = question.set(&["constants", name], "\"2*half_of_it\"")?;
    question.set(&["constants", "half_of_it"], &half).map(Reworded::from)
}

pub(super) fn unit_of_constant(question: Question, spec: &Spec, dice: &mut Dice) -> Option<Reworded> {
    let (name, value, unit) =
        number(spec, dice, |unit| super::data::UNITS.iter().any(|(of, ..)| *of == unit))?;
    let (to, places) = other(unit, dice)?;
    let said = format!("({}, \"{to}\")", moved(&format!("{:e}", value.value), places)?);
    question.set(&["constants", name], &said).map(Reworded::from)
}

pub(super) fn units(question: Question, spec: &Spec, _: &mut Dice) -> Option<Reworded> {
    let declared = spec.states.iter().chain(&spec.inputs).map(|(_, unit)| unit);
    let units = declared.chain(spec.outputs.iter().map(|(_, output)| &output.unit));
    let small = |unit: &Text| {
        let to = match unit.value.as_str() {
            "m" => "mm",
            "m/s" => "mm/s",
            "m/s^2" => "mm/s^2",
            "N" => "kN",
            _ => return None,
        };
        Some((unit.span, to.to_owned()))
    };
    let places: Vec<_> = units.filter_map(small).collect();
    (spec.energy.is_none() && !places.is_empty()).then(|| question.edited(places).into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_turned_around_reads_as_the_same() {
        let text = "-(k*|x - y|)/2 + max(a + b, 1)^2 - exp(-|v|/(3.0))";
        let said = changed(text, |ast, root| Some(turned_around(ast, root, text)));
        assert_eq!(
            said.as_deref(),
            Some("(-exp((-(abs(v)/3.0))) + ((max((b + a), 1)^2) + (-(0.5*(abs((-y + x))*k)))))")
        );
    }
}
