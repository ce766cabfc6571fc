//! Laws for people: a list, one law with its parameters, a page with all pictures.

use crate::format::capital;
use crate::table::{aligned, short};
use crate::terminal::Look;
use phisindy_expr::{Id, Parity};
use phisindy_phys::{Law, LawEntry, LawRole};

/// One line for each law; at a terminal as many as its words need.
pub fn list(all: &[LawEntry], look: Option<Look>) -> String {
    if let Some(look) = look {
        // The name says what the id says: at a terminal the words need its room.
        let column = all.iter().map(|e| e.id.len()).max().unwrap_or(0) + 2;
        let about = |e: &LawEntry| look.wrapped(&e.law.about, column).split_off(column);
        return all.iter().map(|e| format!("{:column$}{}\n", e.id, about(e))).collect();
    }
    let rows: Vec<Vec<String>> =
        all.iter().map(|e| vec![e.id.clone(), e.law.name.clone(), e.law.about.clone()]).collect();
    aligned(&rows).join("\n") + "\n"
}

/// One law, for people: its name, what it says, its parameters, where it comes from, its text.
pub fn shown(entry: &LawEntry) -> String {
    let law = &entry.law;
    let mut lines = vec![format!("{} ({})", capital(&law.name), entry.id), law.about.clone(), String::new()];
    lines.extend(acts(law).into_iter().map(|Line { what, code }| match code {
        Some(code) => format!("{what}: {code}"),
        None => what,
    }));
    lines.extend(is(law));
    if !law.parameters.is_empty() {
        let mut rows = vec![["parameter", "unit", "within"].map(str::to_owned).to_vec()];
        for (name, p) in &law.parameters {
            let unit = if p.unit.is_empty() { "-".to_owned() } else { p.unit.clone() };
            rows.push(vec![name.clone(), unit, format!("{} to {}", short(p.within.0), short(p.within.1))]);
        }
        lines.push(String::new());
        lines.extend(aligned(&rows));
    }
    lines.push(String::new());
    lines.push(format!("Reference: {}", law.reference));
    lines.push(String::new());
    lines.push(format!("laws/{}.ron:", entry.id));
    lines.extend(entry.text.lines().map(|l| format!("    {l}").trim_end().to_owned()));
    lines.join("\n") + "\n"
}

/// All laws with their pictures, as a page of Markdown.
pub fn gallery(all: &[LawEntry]) -> String {
    let mut out = String::from(
        "# The catalogue of laws\n\nWritten by `phisindy laws --out docs/laws` from the files in `specs/laws`. Each picture is drawn along the motion `x = sin t`, `v = cos t`, with example\nnumbers; a law of your own gets one by a line `sketch: (over: \"v\", with: { ... })`.\n",
    );
    for e in all {
        let law = &e.law;
        out += &format!("\n## {} (`{}`)\n\n{}\n", capital(&law.name), e.id, law.about);
        if law.sketch.is_some() {
            out += &format!("\n![{}]({}.svg)\n", capital(&law.name), e.id);
        }
        out.push('\n');
        for Line { what, code } in acts(law) {
            out += &match code {
                Some(code) => format!("- {what}: `{code}`\n"),
                None => format!("- {what}\n"),
            };
        }
        out += &is(law).map_or(String::new(), |line| format!("- {line}\n"));
        for (name, p) in &law.parameters {
            let unit = if p.unit.is_empty() { "no unit" } else { p.unit.as_str() };
            let each = if p.each { ", one for each record" } else { "" };
            out += &format!("- `{name}`: {unit}, {} to {}{each}\n", short(p.within.0), short(p.within.1));
        }
        if !law.reference.is_empty() {
            out += &format!("\n{}\n", law.reference);
        }
    }
    out
}

/// A line about a law; an expression or a list behind it.
struct Line {
    what: String,
    code: Option<String>,
}

impl Line {
    fn new(what: &str, code: impl Into<String>) -> Line {
        Line { what: what.to_owned(), code: Some(code.into()) }
    }
}

/// What a law does.
fn acts(law: &Law) -> Vec<Line> {
    let mut lines = Vec::new();
    lines.extend(law.force.iter().map(|f| Line::new("force against the motion", f)));
    lines.extend(law.push.iter().map(|f| Line::new("push", f)));
    lines.extend(law.sensor.iter().map(|s| Line::new("property of a sensor", s)));
    let input =
        if law.acting().is_some() { "acts in the place of the input u" } else { "property of an input" };
    lines.extend(law.input.iter().map(|s| Line::new(input, s)));
    lines.extend(law.internal.iter().map(|(name, i)| Line {
        what: format!("with d{name}/dt = {} ({}, from {})", i.rate, i.unit, i.start),
        code: None,
    }));
    lines.extend(law.mirror.iter().map(|m| Line::new("or its mirror image", m)));
    let quantities: Vec<String> = law.roles.iter().map(|(name, unit)| format!("{name} in {unit}")).collect();
    if !quantities.is_empty() {
        lines.push(Line::new("of", quantities.join(", ")));
    }
    let number =
        |(name, (x, unit)): &(String, (f64, String))| format!("{name} = {x:?} {unit}").trim_end().to_owned();
    let given: Vec<String> = law.given.iter().map(number).collect();
    if !given.is_empty() {
        lines.push(Line::new("with", given.join(", ")));
    }
    lines
}

/// What a law is, as its expressions tell.
fn is(law: &Law) -> Option<String> {
    let mut all = Vec::new();
    let mut add = |holds: bool, words: &str| {
        if holds {
            all.push(words.to_owned());
        }
    };
    add(law.sticks(), "can stick");
    add(law.is_hysteretic(), "is a hysteresis");
    add(law.has_memory() && !law.is_hysteretic(), "has memory");
    add(law.has_clearance(), "has a clearance");
    match law.parity() {
        Some(Parity::Odd) => add(true, "is odd: the same in both directions"),
        Some(Parity::Even) => add(true, "is even: it does not turn with the motion"),
        None => {}
    }
    let moves = law.role(LawRole::Velocity).is_some();
    add(law.dissipates() == Some(true), "takes energy from every motion, whatever its numbers");
    add(moves && law.dissipates() == Some(false), "may feed the motion, within the bounds of its numbers");
    // A number of a law's memory is in its force by way of a state.
    let of = law.nodes();
    let direct = |k: &usize| {
        let uses = |roots: &[Id]| of.graph.uses(roots, &[of.parameters[*k]]);
        uses(&of.force.into_iter().collect::<Vec<_>>()) && !uses(&of.rates)
    };
    let linear = law.linear_parameters().into_iter().filter(direct);
    let linear: Vec<&str> = linear.map(|k| law.parameters[k].0.as_str()).collect();
    add(!linear.is_empty(), &format!("is linear in {}", linear.join(", ")));
    (!all.is_empty()).then(|| format!("it {}", all.join("; ")))
}
