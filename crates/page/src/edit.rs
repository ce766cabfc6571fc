//! The spec as a form and as a sketch that is edited: each action is one edit of its text, which keeps comments and layout.
//!
//! What belongs to a part is found in the text by its constants and by what it depends on, and taken only if the sketch
//! of the new text has changed by that part and by nothing else.

use crate::terms::{Ends, Terms, applied, factor};
use phisindy_expr::Span;
use phisindy_phys::spec::{ConstantSpec, CsvSpec, DataSpec, Number, Role, Spec, Text};
use phisindy_phys::splice::{SetError, push_at, quoted, remove_at, set_at};
use phisindy_phys::{Diagnostic, SourceId, spec};
use phisindy_report::{EditableSketch, SketchBody, SketchEnd, SketchPart, editable_sketch};
use serde_json::{Value, json};

/// A spec without mistakes and its sketch.
struct Model {
    text: String,
    spec: Spec,
    drawn: Option<EditableSketch>,
}

impl Model {
    fn read(text: &str) -> Result<Model, String> {
        let first = |all: Vec<Diagnostic>| {
            all.into_iter().find(Diagnostic::is_error).map_or(String::new(), |d| d.message)
        };
        let (spec, _) = spec::read(text, SourceId(0)).map_err(first)?;
        let (case, _) = phisindy_phys::check(&spec, SourceId(0)).map_err(first)?;
        let drawn = editable_sketch(&spec, &case);
        Ok(Model { text: text.to_owned(), spec, drawn })
    }

    fn drawn(&self) -> Result<&EditableSketch, String> {
        self.drawn.as_ref().ok_or_else(|| "the model has no sketch".to_owned())
    }

    fn part(&self, key: &str) -> Result<&SketchPart, String> {
        self.drawn()?.parts.iter().find(|p| p.key == key).ok_or_else(gone)
    }

    fn body(&self, key: &str) -> Result<&SketchBody, String> {
        self.drawn()?.bodies.iter().find(|b| b.key == key).ok_or_else(gone)
    }

    /// Whether forces follow from energies.
    fn has_energies(&self) -> bool {
        self.spec.energy.is_some()
    }

    /// A name that nothing has.
    fn free(&self, stem: &str) -> String {
        let Spec { constants, states, inputs, outputs, definitions, .. } = &self.spec;
        let taken = |name: &str| {
            let of_records = self.spec.data.iter().flat_map(DataSpec::constants);
            constants.iter().chain(of_records).any(|(n, _)| n.value == name)
                || [states, inputs, definitions].into_iter().flatten().any(|(n, _)| n.value == name)
                || outputs.iter().any(|(n, _)| n.value == name)
        };
        let names = std::iter::once(stem.to_owned()).chain((2..).map(|k| format!("{stem}{k}")));
        names.into_iter().find(|name| !taken(name)).unwrap_or_default()
    }
}

fn gone() -> String {
    "this part is no longer in the model".to_owned()
}

/// The constants of a spec, and its sketch; each is null while the text has mistakes in the way.
pub(crate) fn shown(text: &str) -> Value {
    let read = spec::read_without_files(text, SourceId(0)).ok();
    let model = Model::read(text).ok();
    let files = |(spec, _): &(Spec, _)| {
        let records = spec.data.iter().filter_map(DataSpec::of_file);
        records.map(|csv| json!({ "file": csv.path.value, "role": role(csv) })).collect::<Vec<_>>()
    };
    json!({
        "files": read.as_ref().map(files),
        "constants": read.map(|(spec, _)| constants(&spec, text)),
        "sketch": model.as_ref().and_then(|m| Some(sketch(m, m.drawn.as_ref()?))),
    })
}

fn sketch(model: &Model, drawn: &EditableSketch) -> Value {
    let part = |part: &SketchPart| {
        let mut can = vec![];
        if is_of_contact(part) || is_element(part) && !model.has_energies() {
            match part.ends {
                [SketchEnd::Ground, SketchEnd::Body(_)] => {
                    can.extend(drawn.bases.iter().any(|b| b[order(part)].is_some()).then_some("base"));
                }
                [SketchEnd::Base(_), _] => can.push("ground"),
                _ => {}
            }
            can.push("remove");
        }
        json!({ "key": part.key, "title": part.title, "constants": part.constants, "can": can })
    };
    let body = |body: &SketchBody| {
        let mut can = vec![];
        can.extend((!sticks(&model.spec, &body.speed)).then_some("contact"));
        if !model.has_energies() {
            can.push("damper");
            can.extend(body.displacement.is_some().then_some("spring"));
            can.extend(body.mass.is_none().then_some("mass"));
        }
        let [mass, damper, spring] = &body.units;
        let new = |stem: &str, unit: &str| json!({ "name": model.free(stem), "unit": plain(unit) });
        json!({ "key": body.key, "title": body.title, "constants": body.constants, "can": can,
                "new": { "mass": new("m", mass), "damper": new("d", damper), "spring": new("k", spring) } })
    };
    json!({
        "svg": drawn.svg,
        "parts": drawn.parts.iter().map(part).chain(drawn.bodies.iter().map(body)).collect::<Vec<_>>(),
    })
}

fn role(csv: &CsvSpec) -> &'static str {
    match csv.role {
        Role::Fit => "Fit",
        Role::Validate => "Validate",
    }
}

/// A unit as the spec writes it.
fn plain(unit: &str) -> String {
    unit.replace('·', "*").replace('²', "^2").replace('³', "^3")
}

fn constants(spec: &Spec, text: &str) -> Value {
    let written = |n: &Number| text.get(n.span.range()).unwrap_or_default().to_owned();
    let one = |record: Option<usize>, (name, constant): &(Text, ConstantSpec)| {
        let unit = constant.unit().map(|u| &u.value);
        let row = |kind: &str, value: &Number, within: Option<&(Number, Number)>| {
            let [low, high] = [within.map(|w| w.0.value), within.map(|w| w.1.value)];
            json!({ "kind": kind, "value": written(value), "low": low, "high": high })
        };
        let mut told = match constant {
            ConstantSpec::Number { value, .. } => row("held", value, None),
            ConstantSpec::Movable(m) => row("within", &m.value, Some(&m.within)),
            ConstantSpec::Find(f) => row("find", &f.start, Some(&f.within)),
            ConstantSpec::Expression(e) => json!({ "kind": "formula", "value": e.value }),
            ConstantSpec::MaxAbs(of) => json!({ "kind": "greatest", "value": of.value }),
        };
        (told["name"], told["unit"], told["record"]) = (json!(name.value), json!(unit), json!(record));
        told
    };
    let own = spec.constants.iter().map(|c| one(None, c));
    let of_records =
        spec.data.iter().enumerate().flat_map(|(k, d)| d.constants().iter().map(move |c| one(Some(k), c)));
    own.chain(of_records).collect()
}

/// The text with one edit, `{ text, what, ... }`.
///
/// # Errors
/// Why it is not made, in words.
pub(crate) fn edit(asked: &Value) -> Result<String, String> {
    let word = |key: &str| asked[key].as_str().unwrap_or_default();
    let (text, what) = (word("text"), word("what"));
    if what == "constant" {
        let new = constant(text, asked)?;
        // Of a text that has mistakes one may be mended at a time.
        return match (Model::read(text), Model::read(&new)) {
            (Ok(_), Err(why)) => Err(why),
            _ => Ok(new),
        };
    }
    let model =
        Model::read(text).map_err(|why| format!("the text has a mistake, which comes first: {why}"))?;
    match what {
        "remove" => changed(&model, model.part(word("part"))?, None),
        "ground" => changed(&model, model.part(word("part"))?, Some(SketchEnd::Ground)),
        "base" => {
            let part = model.part(word("part"))?;
            let base = model.drawn()?.bases.iter().position(|b| b[order(part)].is_some()).unwrap_or_default();
            changed(&model, part, Some(SketchEnd::Base(base)))
        }
        "mass" | "damper" | "spring" => added(&model, model.body(word("part"))?, what, &word),
        "record" => with_record(&model, word("file"), word("to")),
        "contact" => with_contact(&model, model.body(word("part"))?),
        _ => Err(format!("there is no edit `{what}`")),
    }
}

/// What a user types as a number, as it stands in a spec.
fn number(typed: &str) -> Result<String, String> {
    let typed = typed.trim().replace(',', ".");
    let value: f64 = typed
        .parse()
        .ok()
        .filter(|x: &f64| x.is_finite())
        .ok_or_else(|| format!("`{typed}` is no number"))?;
    let first = typed.trim_start_matches('-').starts_with(|c: char| c.is_ascii_digit());
    Ok(if first && !typed.ends_with('.') { typed } else { format!("{value:?}") })
}

/// A unit or a formula in its quotes.
fn words(typed: &str) -> Result<&str, String> {
    match typed.contains(['"', '\\', '\n']) {
        true => Err(format!("`{typed}` cannot stand here")),
        false => Ok(typed.trim()),
    }
}

/// Changes a field of a constant.
fn constant(text: &str, asked: &Value) -> Result<String, String> {
    let word = |key: &str| asked[key].as_str().unwrap_or_default();
    let (name, to) = (word("name"), word("to").trim());
    let first = |all: Vec<Diagnostic>| all.into_iter().next().map_or(String::new(), |d| d.message);
    let (spec, _) = spec::read_without_files(text, SourceId(0)).map_err(first)?;
    let record = asked["record"].as_u64().and_then(|k| usize::try_from(k).ok());
    let list = match record {
        Some(k) => spec.data.get(k).map_or(&[][..], DataSpec::constants),
        None => &spec.constants[..],
    };
    let (_, constant) =
        list.iter().find(|(n, _)| n.value == name).ok_or_else(|| format!("there is no constant `{name}`"))?;
    let k = record.unwrap_or_default().to_string();
    let set = |field: Option<&str>, value: &str| {
        let path: Vec<&str> =
            if record.is_some() { vec!["data", &k, "constants", name] } else { vec!["constants", name] };
        let path: Vec<&str> = path.into_iter().chain(field).collect();
        set_at(text, &path, value).map_err(|why| why.to_string())
    };
    let at = |span: Span, new: &str| Ok(applied(text, vec![(span, new.to_owned())]));
    let (value, within, plain) = match constant {
        ConstantSpec::Number { value, .. } => (value, None, true),
        ConstantSpec::Movable(m) => (&m.value, Some(&m.within), m.sigma.is_none() && !m.each),
        ConstantSpec::Find(f) => (&f.start, Some(&f.within), f.sigma.is_none() && !f.each),
        ConstantSpec::Expression(e) if word("field") == "value" => return at(e.span, words(to)?),
        _ => return Err(format!("`{name}` follows from others: change it in the text")),
    };
    let written = |n: &Number| text[n.span.range()].to_owned();
    // Of a belief without bounds the bounds stand nowhere.
    let within = within.filter(|(low, _)| low.span != value.span);
    match word("field") {
        "value" => match (to.split_once(char::is_whitespace), constant.unit()) {
            (Some((x, unit)), Some(old)) => {
                Ok(applied(text, vec![(value.span, number(x)?), (old.span, words(unit)?.to_owned())]))
            }
            _ => at(value.span, &number(to)?),
        },
        "unit" => match (constant.unit(), constant) {
            (Some(old), _) => at(old.span, words(to)?),
            (None, ConstantSpec::Number { .. }) => {
                at(value.span, &format!("({}, {})", written(value), quoted(words(to)?)))
            }
            (None, _) => set(Some("unit"), &quoted(words(to)?)),
        },
        "low" | "high" => {
            let (low, high) = within.ok_or_else(|| format!("`{name}` has no bounds in the text"))?;
            at(if word("field") == "low" { low.span } else { high.span }, &number(to)?)
        }
        "kind" if !plain => {
            Err(format!("`{name}` has a belief, or a value for each record: change it in the text"))
        }
        "kind" => {
            let (low, high) = within.map_or_else(|| bounds(value.value), |(l, h)| (written(l), written(h)));
            let unit = constant.unit().map(|u| format!(", unit: {}", quoted(&u.value))).unwrap_or_default();
            let (x, held) = (written(value), constant.unit().map(|u| quoted(&u.value)));
            match to {
                "held" => set(None, &held.map_or_else(|| x.clone(), |u| format!("({x}, {u})"))),
                "within" => set(None, &format!("(value: {x}{unit}, within: ({low}, {high}))")),
                "find" => set(None, &format!("Find(start: {x}{unit}, within: ({low}, {high}))")),
                _ => Err(format!("a constant cannot be `{to}`")),
            }
        }
        field => Err(format!("a constant has no `{field}`")),
    }
}

/// Bounds about a first guess: a decade to both sides.
fn bounds(x: f64) -> (String, String) {
    let (a, b) = match x {
        x if x > 0.0 => (x / 10.0, x * 10.0),
        x if x < 0.0 => (x * 10.0, x / 10.0),
        _ => (-1.0, 1.0),
    };
    let short = |x: f64| format!("{:?}", format!("{x:.3e}").parse::<f64>().unwrap_or(x));
    (short(a), short(b))
}

fn is_of_contact(part: &SketchPart) -> bool {
    part.kind == "friction"
}

/// Whether a part acts along displacements (0) or speeds (1).
fn order(part: &SketchPart) -> usize {
    usize::from(!part.kind.ends_with("spring"))
}

/// Whether a speed is one that can stick.
fn sticks(spec: &Spec, speed: &str) -> bool {
    spec.contacts.iter().any(|c| c.value.trim() == speed)
}

/// A spring or a damper that the spec states.
fn is_element(part: &SketchPart) -> bool {
    !part.sought && (part.kind.ends_with("spring") || part.kind.ends_with("damper"))
}

fn ends_of(drawn: &EditableSketch, ends: [SketchEnd; 2]) -> Ends {
    let mut all = Ends::default();
    for end in ends {
        match end {
            SketchEnd::Ground => {}
            SketchEnd::Base(k) => all.base = drawn.bases.get(k).cloned(),
            SketchEnd::Body(k) => {
                let body = drawn.bodies.get(k);
                all.bodies.extend(body.map(|b| [b.displacement.clone(), Some(b.speed.clone())]));
            }
        }
    }
    all
}

/// A part that is to go (`to` is none), or to stand on another support.
struct Change<'m> {
    model: &'m Model,
    part: &'m SketchPart,
    ends: Ends,
    to: Option<SketchEnd>,
    base: Option<[Option<String>; 2]>,
}

/// New texts at places, and entries that go.
#[derive(Default)]
struct Plan {
    edits: Vec<(Span, String)>,
    removed: Vec<Vec<String>>,
}

/// The text without a part (`None`), or with it on another support.
fn changed(model: &Model, part: &SketchPart, to: Option<SketchEnd>) -> Result<String, String> {
    let drawn = model.drawn()?;
    let (mut ends, order) = (ends_of(drawn, part.ends), order(part));
    let mut base = match to {
        Some(SketchEnd::Base(k)) => Some(drawn.bases.get(k).ok_or("no support moves in this model")?.clone()),
        _ => None,
    };
    if base.as_ref().is_some_and(|base| base[order].is_none()) {
        let what = ["displacement", "speed"][order];
        return Err(format!("the {what} of the base is no input of the model: add it to `inputs` first"));
    }
    if is_of_contact(part) {
        // What rubs depends on speeds; a displacement in its law is one of the body.
        ends.bodies.iter_mut().chain(&mut ends.base).chain(&mut base).for_each(|pair| pair[0] = None);
    }
    let change = Change { model, part, ends, to, base };
    // Terms that are exactly between the ends come first, then all with the constants of the part.
    for strict in [true, false] {
        let plan = change.plan(strict)?;
        let mut text = applied(&model.text, plan.edits);
        for path in plan.removed {
            let path: Vec<&str> = path.iter().map(String::as_str).collect();
            text = remove_at(&text, &path).map_err(|why| why.to_string())?;
        }
        let new = Model::read(&text).ok();
        if new.and_then(|new| new.drawn).is_some_and(|new| is_only(drawn, &new, part, to)) {
            return Ok(text);
        }
    }
    Err("this part is written together with others: change it in the text".to_owned())
}

impl Change<'_> {
    fn is_moving(&self, name: &str) -> bool {
        let Spec { states, inputs, .. } = &self.model.spec;
        states.iter().chain(inputs).any(|(n, _)| n.value == name)
    }

    /// Whether what moves among some names is the speeds at the ends.
    fn is_along(&self, names: &[&str]) -> bool {
        let speeds: Vec<&str> = self.ends.of(1).map(String::as_str).collect();
        let moving: Vec<&str> = names.iter().copied().filter(|n| self.is_moving(n)).collect();
        moving.iter().all(|n| speeds.contains(n)) && speeds.iter().all(|s| moving.contains(s))
    }

    fn plan(&self, strict: bool) -> Result<Plan, String> {
        let mut plan = Plan::default();
        let of_bodies = |state: &Text| self.ends.bodies.iter().any(|b| b[1].as_ref() == Some(&state.value));
        for (_, rate) in self.model.spec.known.iter().filter(|(state, _)| of_bodies(state)) {
            let Some(terms) = Terms::read(&rate.value) else { continue };
            let found = self.terms(&terms, strict);
            if !found.is_empty() {
                let new = match self.to {
                    None => terms.without(&found),
                    Some(_) => terms.moved(&found, &|n| self.is_moving(n), &self.ends, self.base.as_ref()),
                };
                plan.edits.push((rate.span, new.unwrap_or_else(|| "0".to_owned())));
            }
        }
        if is_of_contact(self.part) {
            self.contact(&mut plan)?;
        }
        Ok(plan)
    }

    /// The terms of a rate that are of the part.
    fn terms(&self, terms: &Terms<'_>, strict: bool) -> Vec<usize> {
        if is_of_contact(self.part) {
            return terms.with_sign(&|names| self.is_along(names));
        }
        let (order, constants) = (order(self.part), &self.part.constants);
        // A number without a name is known by what it multiplies.
        let bare = constants.is_empty();
        let wanted = |name: &str| match bare {
            true => self.ends.of(order).any(|n| n == name),
            false => constants.iter().any(|c| c == name),
        };
        let between = |&term: &usize| {
            let names = terms.names(terms.motion(term, &|n| self.is_moving(n)));
            let has = |name: &String| names.contains(&name.as_str());
            let own = |name: &str| self.ends.each().flatten().any(|n| n == name);
            let only = || names.iter().all(|n| own(n) || !self.is_moving(n));
            let all = || self.ends.each().all(|end| end.into_iter().any(has));
            self.ends.of(order).any(has) && (!strict || only() && all())
        };
        terms.with_names(&wanted, bare).into_iter().filter(between).collect()
    }

    /// What `contacts` and `unknown` say of a contact.
    fn contact(&self, plan: &mut Plan) -> Result<(), String> {
        let shifted = |text: &Text| {
            Some((text.span, Terms::read(&text.value)?.shifted(&self.ends, self.base.as_ref())?))
        };
        let along = |names: &[&str]| self.is_along(names);
        let rubs = |text: &Text| Terms::read(&text.value).is_some_and(|t| !t.with_sign(&along).is_empty());
        for (k, own) in self.model.spec.contacts.iter().enumerate() {
            if Terms::read(&own.value).is_some_and(|t| self.is_along(&t.names(t.root()))) {
                match self.to {
                    None => plan.removed.insert(0, vec!["contacts".to_owned(), k.to_string()]),
                    Some(_) => plan.edits.extend(shifted(own)),
                }
            }
        }
        for (state, unknown) in &self.model.spec.unknown {
            if !self.ends.of(1).any(|n| *n == state.value) {
                continue;
            }
            if !unknown.laws.is_empty() {
                let why = "`unknown` names laws here, whose contact comes with them: change it in the text";
                return Err(why.to_owned());
            }
            let (path, all) = (["unknown".to_owned(), state.value.clone()], &unknown.candidates);
            let factor = unknown.factor.as_ref().filter(|f| rubs(f));
            let own: Vec<usize> = (0..all.len()).filter(|&k| factor.is_some() || rubs(&all[k])).collect();
            match self.to {
                Some(_) => plan.edits.extend(own.iter().map(|&k| &all[k]).chain(factor).filter_map(shifted)),
                None if own.len() == all.len() => plan.removed.push(path.to_vec()),
                None => {
                    plan.removed.extend(own.iter().rev().map(|k| {
                        path.iter().cloned().chain(["candidates".to_owned(), k.to_string()]).collect()
                    }))
                }
            }
        }
        Ok(())
    }
}

/// Whether a sketch differs from another one by this part alone, which is gone, or at another support.
fn is_only(old: &EditableSketch, new: &EditableSketch, part: &SketchPart, to: Option<SketchEnd>) -> bool {
    let place = to.map(|to| (part.kind, [to, part.ends[1]]));
    let own = |p: &SketchPart| (p.kind, p.ends) == (part.kind, part.ends);
    let at = |p: &SketchPart| Some((p.kind, p.ends)) == place;
    let others = |all: &EditableSketch| -> Vec<(String, String)> {
        let kept = all.parts.iter().filter(|p| !own(p) && !at(p));
        kept.map(|p| (p.key.clone(), p.title.clone())).collect()
    };
    let bodies = |all: &EditableSketch| all.bodies.iter().map(|b| b.title.clone()).collect::<Vec<_>>();
    let mut same = [others(old), others(new)];
    same.iter_mut().for_each(|all| all.sort());
    let done = !new.parts.iter().any(own) && (to.is_none() || new.parts.iter().any(at));
    let only = same[0] == same[1] && bodies(old) == bodies(new) && old.pushes == new.pushes;
    done && only
}

/// The text with a mass that has a name, or with another damper or spring to the ground.
fn added<'v>(
    model: &Model,
    body: &SketchBody,
    what: &str,
    word: &dyn Fn(&'static str) -> &'v str,
) -> Result<String, String> {
    if model.has_energies() {
        return Err("the forces of this model follow from its energies: change these in the text".to_owned());
    }
    let (name, unit) = (words(word("name"))?, words(word("unit"))?);
    let is_name = name.starts_with(|c: char| c.is_alphabetic())
        && name.chars().all(|c| c.is_alphanumeric() || c == '_');
    if !is_name {
        return Err(format!("`{name}` is no name: letters, then digits"));
    }
    if model.free(name) != name {
        return Err(format!("`{name}` is the name of something else"));
    }
    let value = number(word("value"))?;
    let value = if unit.is_empty() { value } else { format!("({value}, {})", quoted(unit)) };
    let set =
        |text: &str, path: &[&str], value: &str| set_at(text, path, value).map_err(|why| why.to_string());
    let text = match what {
        "mass" => set(&model.text, &["inertia", &body.speed], &quoted(name))?,
        _ => {
            let place = if what == "spring" { body.displacement.as_ref() } else { Some(&body.speed) };
            let place = place.ok_or("this body has no displacement")?;
            let rate = model.spec.known.iter().find(|(state, _)| state.value == body.speed);
            let (_, rate) = rate.ok_or_else(gone)?;
            let terms = Terms::read(&rate.value).ok_or_else(gone)?;
            applied(
                &model.text,
                vec![(rate.span, terms.with_force(&format!("{name}*{place}"), body.mass.as_deref()))],
            )
        }
    };
    let text = set(&text, &["constants", name], &value)?;
    Model::read(&text).map(|_| text)
}

/// The text with a body that may stick to the ground, and a candidate for its friction where candidates are asked for.
fn with_contact(model: &Model, body: &SketchBody) -> Result<String, String> {
    let (spec, speed) = (&model.spec, body.speed.as_str());
    if sticks(spec, speed) {
        return Err(format!("`{speed}` can stick already"));
    }
    let why = |why: SetError| why.to_string();
    let mut text = push_at(&model.text, &["contacts"], &quoted(speed)).map_err(why)?;
    let rubs = |t: &Text| {
        Terms::read(&t.value).is_some_and(|t| !t.with_sign(&|names| names.contains(&speed)).is_empty())
    };
    match spec.unknown.iter().find(|(state, _)| state.value == speed) {
        Some((_, own)) if own.factor.iter().chain(&own.candidates).any(rubs) => {}
        Some(_) => {
            text = push_at(&text, &["unknown", speed, "candidates"], &quoted(&format!("sgn({speed})")))
                .map_err(why)?
        }
        None if spec.unknown.is_empty() => {}
        None => {
            // Along energies what acts is a force, divided by nothing.
            let mass = body.mass.as_ref().filter(|_| !spec.is_moved(speed));
            let over = mass.map_or(String::new(), |m| format!("/{}", factor(m)));
            let entry = format!("(factor: \"-sgn({speed}){over}\", candidates: [\"1\"])");
            text = set_at(&text, &["unknown", speed], &entry).map_err(why)?;
        }
    }
    Model::read(&text).map(|_| text)
}

/// A record of another file that is read as this one is, but as a whole.
///
/// # Errors
/// The text is no record.
pub(crate) fn record_like(record: &str, file: &str, role: &str) -> Result<String, SetError> {
    let mut spec = format!("(data: [{record}])");
    for field in ["name", "window", "run", "rows", "start"] {
        spec = remove_at(&spec, &["data", "0", field]).unwrap_or(spec);
    }
    spec = set_at(&spec, &["data", "0", "path"], &quoted(file))?;
    spec = set_at(&spec, &["data", "0", "role"], role)?;
    Ok(spec["(data: [".len()..spec.len() - "])".len()].to_owned())
}

/// The text with the records of a file for this, or for nothing; a new one is read as the first record is, but as a whole.
fn with_record(model: &Model, file: &str, to: &str) -> Result<String, String> {
    let why = |why: SetError| why.to_string();
    let all: Vec<(usize, &CsvSpec)> =
        model.spec.data.iter().enumerate().filter_map(|(k, d)| Some((k, d.of_file()?))).collect();
    let own: Vec<String> =
        all.iter().filter(|(_, c)| c.path.value == file).map(|(k, _)| k.to_string()).collect();
    let mut text = model.text.clone();
    match to {
        "none" => {
            for k in own.iter().rev() {
                text = remove_at(&text, &["data", k]).map_err(why)?;
            }
        }
        "Fit" | "Validate" => {
            for k in &own {
                text = set_at(&text, &["data", k, "role"], to).map_err(why)?;
            }
            if own.is_empty() {
                let (_, first) =
                    all.first().ok_or("the spec reads no file that another one could be like")?;
                let record = record_like(&text[first.span.range()], words(file)?, to).map_err(why)?;
                text = push_at(&text, &["data"], &record).map_err(why)?;
            }
        }
        _ => return Err(format!("a file is not for `{to}`")),
    }
    Model::read(&text).map(|_| text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use proptest::sample::select;

    const RIG: &str = r#"(
    constants: {
        "m": (2.0, "kg"), // weighed
        "k": (value: 800.0, unit: "N/m", within: (8.0, 8e4)),
        "c": 0.5, /* a guess */
        "w": "sqrt(k/m)",
    },
    states: { "x": "m", "v": "m/s" },
    inputs: { "u": "m", "du": "m/s" },
    known: { "x": "v", "v": "(-c*v - k*(x - u))/m" }, // the physics
    unknown: { "v": (factor: "-sgn(v)/m", candidates: ["1", "x"]) },
    contacts: ["v"],
    data: [Csv(path: "a.csv", time: "t", columns: { "x": "x", "u": "u" }, derive: { "du": Derivative("u") })],
)"#;

    fn done(text: &str, wish: Value) -> Result<String, String> {
        let mut wish = wish;
        wish["text"] = json!(text);
        edit(&wish)
    }

    /// What a line became, and that all others stay.
    fn line(text: &str, new: &str, from: &str, to: &str) {
        assert!(text.contains(from), "{from} in {text}");
        assert_eq!(new, text.replacen(from, to, 1));
    }

    #[test]
    fn parts_are_moved_and_removed_where_they_stand() {
        let of = |what: &str, part: &str| done(RIG, json!({ "what": what, "part": part })).unwrap();
        line(RIG, &of("base", "damper-ground-body0"), "-c*v - k", "-c*(v - du) - k");
        line(RIG, &of("ground", "spring-base0-body0"), "k*(x - u)", "k*x");
        line(RIG, &of("remove", "spring-base0-body0"), "(-c*v - k*(x - u))", "(-c*v)");
        line(RIG, &of("remove", "damper-ground-body0"), "(-c*v - k*(x - u))", "(-k*(x - u))");
        let rubs = of("base", "asked-friction-ground-body0");
        line(&RIG.replace("-sgn(v)", "-sgn(v - du)"), &rubs, "contacts: [\"v\"]", "contacts: [\"v - du\"]");
        assert_eq!(
            done(&rubs, json!({ "what": "ground", "part": "asked-friction-base0-body0" })).unwrap(),
            RIG
        );
        let bare = of("remove", "asked-friction-ground-body0");
        line(
            &RIG.replace("contacts: [\"v\"]", "contacts: []"),
            &bare,
            "\"v\": (factor: \"-sgn(v)/m\", candidates: [\"1\", \"x\"]) ",
            "",
        );
        // Written out it is one part all the same.
        let out = RIG.replace("(-c*v - k*(x - u))/m", "(du*c + k*u - c*v - k*x)/m");
        let new = done(&out, json!({ "what": "ground", "part": "damper-base0-body0" })).unwrap();
        line(&out, &new, "(du*c + k*u - c*v - k*x)", "(k*u - c*v - k*x)");
    }

    #[test]
    fn a_body_gets_parts() {
        let wish = |what: &str, name: &str, unit: &str| json!({ "what": what, "part": "body0", "name": name, "value": "3,5", "unit": unit });
        let new = done(RIG, wish("damper", "d", "N*s/m")).unwrap();
        assert!(
            new.contains("(-c*v - k*(x - u) - d*v)/m")
                && new.contains("\"w\": \"sqrt(k/m)\",\n        \"d\": (3.5, \"N*s/m\"),\n"),
            "{new}"
        );
        for (wrong, why) in [
            (wish("spring", "k", "N/m"), "name of something else"),
            (wish("spring", "k2", "N"), ""),
            (wish("spring", "2\"", "N/m"), ""),
            (wish("mass", "m3", "kg"), ""),
        ] {
            let told = done(RIG, wrong.clone());
            let fine = wrong["what"] == "mass" && told.is_ok();
            assert!(fine || told.as_ref().is_err_and(|t| t.contains(why)), "{wrong}: {told:?}");
        }
        assert!(done(RIG, json!({ "what": "contact", "part": "body0" })).unwrap_err().contains("already"));
        let free = RIG
            .replace("contacts: [\"v\"],", "")
            .replace("(factor: \"-sgn(v)/m\", candidates: [\"1\", \"x\"])", "(candidates: [\"x\"])");
        let new = done(&free, json!({ "what": "contact", "part": "body0" })).unwrap();
        assert!(
            new.contains("candidates: [\"x\", \"sgn(v)\"]") && new.contains("contacts: [\"v\"]"),
            "{new}"
        );
        let rates = r#"(constants: { "k": (9.0, "1/s^2") }, states: { "x": "m", "v": "m/s" }, known: { "x": "v", "v": "-k*x" }, data: [Csv(path: "a.csv", time: "t", columns: { "x": "x" })])"#;
        let new = done(rates, wish("mass", "m", "kg")).unwrap();
        assert!(new.contains("\"m\": (3.5, \"kg\")") && new.contains("inertia: { \"v\": \"m\" }"), "{new}");
    }

    #[test]
    fn constants_change_at_their_place_alone() {
        let set = |name: &str, field: &str, to: &str| {
            done(RIG, json!({ "what": "constant", "name": name, "field": field, "to": to }))
        };
        line(RIG, &set("m", "value", "1.6").unwrap(), "(2.0, \"kg\")", "(1.6, \"kg\")");
        line(RIG, &set("m", "value", "1600 g").unwrap(), "(2.0, \"kg\")", "(1600, \"g\")");
        line(RIG, &set("k", "high", "9e3").unwrap(), "8e4", "9e3");
        line(RIG, &set("k", "kind", "find").unwrap(), "(value: 800.0,", "Find(start: 800.0,");
        line(
            RIG,
            &set("k", "kind", "held").unwrap(),
            "(value: 800.0, unit: \"N/m\", within: (8.0, 8e4))",
            "(800.0, \"N/m\")",
        );
        line(
            RIG,
            &set("m", "kind", "find").unwrap(),
            "(2.0, \"kg\")",
            "Find(start: 2.0, unit: \"kg\", within: (0.2, 20.0))",
        );
        line(RIG, &set("c", "unit", "N*s/m").unwrap(), "0.5", "(0.5, \"N*s/m\")");
        line(RIG, &set("w", "value", "k/m").unwrap(), "sqrt(k/m)", "k/m");
        for (name, field, to) in [
            ("k", "value", "9e9"),
            ("m", "unit", "N"),
            ("m", "value", "much"),
            ("m", "unit", "\""),
            ("q", "value", "1"),
            ("m", "low", "1"),
            ("m", "kind", "odd"),
            ("m", "hat", "1"),
            ("m", "value", "1e999"),
        ] {
            assert!(set(name, field, to).is_err_and(|why| !why.is_empty()), "{name} {field} {to}");
        }
    }

    #[test]
    fn a_file_is_to_fit_to_validate_or_not_used() {
        let set = |text: &str, file: &str, to: &str| {
            done(text, json!({ "what": "record", "file": file, "to": to }))
        };
        let two = set(RIG, "b.csv", "Validate").unwrap();
        let record = r#"Csv(path: "b.csv", time: "t", columns: { "x": "x", "u": "u" }, derive: { "du": Derivative("u") }, role: Validate)"#;
        line(RIG, &two, "Derivative(\"u\") })]", &format!("Derivative(\"u\") }}), {record}]"));
        assert_eq!(set(&two, "b.csv", "none").unwrap(), RIG);
        let fit = set(&two, "b.csv", "Fit").unwrap();
        line(&two, &fit, "role: Validate", "role: Fit");
        assert!(
            set(RIG, "a.csv", "none").is_err()
                && set(RIG, "a\".csv", "Fit").is_err()
                && set(RIG, "b.csv", "odd").is_err()
        );
    }

    /// Every edit that is offered for any spec of the repository is made so that the text is good, or refused in words.
    #[test]
    fn what_is_offered_is_done_or_refused() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../specs");
        let (mut made, mut refused) = (0, vec![]);
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let Ok(text) = std::fs::read_to_string(&path) else { continue };
            let shown = shown(&text);
            for part in shown["sketch"]["parts"].as_array().into_iter().flatten() {
                for what in part["can"].as_array().unwrap() {
                    let new = &part["new"][what.as_str().unwrap()];
                    let wish = json!({ "what": what, "part": part["key"], "name": new["name"], "unit": new["unit"], "value": "1.5" });
                    match done(&text, wish) {
                        Ok(new) => {
                            made += 1;
                            assert!(Model::read(&new).is_ok() && new != text, "{path:?} {what} {part}");
                        }
                        Err(why) => refused.push(format!(
                            "{} {what} {}: {why}",
                            path.file_stem().unwrap().display(),
                            part["title"]
                        )),
                    }
                }
            }
        }
        assert!(made > 150 && refused.len() < 8, "{made} made; refused:\n{}", refused.join("\n"));
        for odd in [
            json!(null),
            json!([]),
            json!({}),
            json!({ "text": "(", "what": "constant" }),
            json!({ "text": RIG, "what": "remove", "part": 7 }),
            json!({ "text": RIG, "what": "constant", "name": "m", "record": 1e300, "field": "value", "to": "1" }),
        ] {
            assert!(edit(&odd).is_err() || odd["record"].is_number(), "{odd}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(300))]

        /// A text that is cut and joined anyhow is edited or refused, and what is made of a good text is good.
        #[test]
        fn no_text_makes_it_fail(
            (from, long) in (0..RIG.len(), 0..40_usize),
            piece in select(&["", "\"", "(", ")", "}", ",", "-", "sgn(v)", "|", "ä", "(x - u)", "1e999", "/*", "Find(", "r#\"v\"#", "energy: ()"][..]),
            (what, part) in (select(&["remove", "base", "ground", "mass", "damper", "spring", "contact", "constant", "record"][..]),
                select(&["spring-base0-body0", "damper-ground-body0", "asked-friction-ground-body0", "body0", ""][..])),
            (field, to) in (select(&["value", "unit", "low", "high", "kind"][..]), select(&["1 kg", "find", "held", "within", "-", "\u{7}", "v\"", "1e-400"][..])),
            name in select(&["m", "k", "c", "w", "q", "a.csv"][..]),
        ) {
            let text = format!("{}{piece}{}", &RIG[..from], &RIG[(from + long).min(RIG.len())..]);
            let _ = shown(&text);
            let made = done(&text, json!({ "what": what, "part": part, "name": name, "value": to, "unit": to, "field": field, "to": to, "file": name }));
            if let Ok(new) = made {
                prop_assert!(Model::read(&text).is_err() || Model::read(&new).is_ok(), "{new}");
            }
        }
    }
}
