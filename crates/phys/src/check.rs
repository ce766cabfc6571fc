//! Spec to [`System`]: every name resolved, every mistake of the file collected.

use crate::constants::{Constants, Value};
use crate::dimensions::dimensions;
use crate::plan::{RecordPlan, plan_records};
use crate::spec::{LearnSpec, Spec, Text, UnknownSpec};
use crate::system::holds_sign;
use crate::system::{Contact, Input, State, System, Term};
use crate::unit::Unit;
use crate::{Diagnostic, SourceId};
use phisindy_expr::{Graph, Id, Names, Span, Symbol, nearest, ops, parse};
use std::collections::{HashMap, HashSet};

/// A checked spec: the system, what its records will be, and how to learn.
#[derive(Clone, Debug)]
pub struct Case {
    /// The physics.
    pub system: System,
    /// In the order of the spec.
    pub records: Vec<RecordPlan>,
    /// As in the spec.
    pub learn: LearnSpec,
    /// Laws of the catalogue that `unknown` names, each with the state whose rate it may be missing in. The catalogue is not known here: whoever has
    /// it writes them into `known`.
    pub laws: Vec<(usize, Text)>,
}

impl Case {
    /// Whether something in its rates is asked for: candidates or laws.
    pub fn is_open(&self) -> bool {
        !self.system.terms.is_empty() || !self.laws.is_empty()
    }
}

/// Checks a spec.
///
/// # Errors
/// All mistakes found, errors and warnings; on success the warnings alone come with the case.
///
/// ```
/// use phisindy_phys::{SourceId, check, spec};
/// let text = |rate: &str| {
///     format!(
///         "(states: {{ \"x\": \"m\", \"v\": \"m/s\" }}, constants: {{ \"k\": (4.0, \"1/s^2\") }}, known: {{ \"x\": \"v\", \"v\": \"{rate}\" }},
///           unknown: {{ \"v\": (factor: \"-sgn(v)\", candidates: [\"1\", \"x\"]) }}, contacts: [\"v\"],
///           data: [Csv(path: \"run.csv\", time: \"t\", columns: {{ \"x\": \"x\" }})])"
///     )
/// };
/// let (good, _) = spec::read(&text("-k*x"), SourceId(0)).unwrap();
/// let (case, _) = check(&good, SourceId(0)).unwrap();
/// // A coefficient has the unit that makes its term a rate of the velocity.
/// assert_eq!(case.system.terms[1].unit.unwrap().to_string(), "1/s^2");
///
/// let (bad, _) = spec::read(&text("-k*v"), SourceId(0)).unwrap();
/// assert!(check(&bad, SourceId(0)).unwrap_err()[0].message.contains("m/s^2"));
/// ```
pub fn check(spec: &Spec, source: SourceId) -> Result<(Case, Vec<Diagnostic>), Vec<Diagnostic>> {
    checked(spec, source, true)
}

/// As [`check`], but for what the expressions measure: for texts that a program has changed after they were checked.
///
/// # Errors
/// All mistakes found.
pub fn check_names(spec: &Spec, source: SourceId) -> Result<(Case, Vec<Diagnostic>), Vec<Diagnostic>> {
    checked(spec, source, false)
}

/// Whether a constant with a unit may be added: not where the units of the states and inputs alone do not fit, which is only a warning as long as no constant speaks of units.
pub fn takes_units(spec: &Spec, source: SourceId) -> bool {
    speaks_of_units(spec) || dimensions(spec, source).is_ok()
}

/// Whether any constant has a unit: a spec without one does not speak of units, and is warned, not refused.
fn speaks_of_units(spec: &Spec) -> bool {
    use crate::spec::ConstantSpec;
    let all = spec.constants.iter().chain(spec.data.iter().flat_map(crate::constants::record_constants));
    all.into_iter().any(|(_, c)| match c {
        ConstantSpec::Number { unit, .. } => unit.is_some(),
        ConstantSpec::Movable(m) => m.unit.is_some(),
        ConstantSpec::Find(f) => f.unit.is_some(),
        ConstantSpec::Expression(_) | ConstantSpec::MaxAbs(_) => false,
    })
}

fn checked(
    spec: &Spec,
    source: SourceId,
    measured: bool,
) -> Result<(Case, Vec<Diagnostic>), Vec<Diagnostic>> {
    let mut checker = Checker::new(source);
    let mut system = checker.system(spec);
    let records = plan_records(&mut checker, spec, &system);
    checker.unused_constants(spec);
    // What names stand for must be settled before what they measure.
    if measured && !checker.diagnostics.iter().any(Diagnostic::is_error) {
        match dimensions(spec, source) {
            Ok(units) => {
                for (term, unit) in system.terms.iter_mut().zip(units) {
                    (term.unit, term.force, term.energy) = (unit.coefficient, unit.force, unit.energy);
                }
            }
            Err(mut mistakes) => {
                if !speaks_of_units(spec) {
                    mistakes.iter_mut().for_each(|m| m.severity = crate::Severity::Warning);
                }
                checker.diagnostics.extend(mistakes);
            }
        }
    }
    let diagnostics = std::mem::take(&mut checker.diagnostics);
    if diagnostics.iter().any(Diagnostic::is_error) {
        return Err(diagnostics);
    }
    let laws = checker.laws;
    Ok((Case { system, records, learn: spec.learn.clone(), laws }, diagnostics))
}

/// Most bytes of a name.
const LONGEST_NAME: usize = 100;

/// The state of a check: names so far, and what was found wrong.
pub(crate) struct Checker {
    pub(crate) source: SourceId,
    pub(crate) graph: Graph,
    pub(crate) names: Names,
    pub(crate) diagnostics: Vec<Diagnostic>,
    /// Where each name of the system was declared, to explain clashes and to offer hints.
    declared: Vec<(String, Span)>,
    pub(crate) constants: Constants,
    /// Constants that some expression uses.
    pub(crate) used: HashSet<String>,
    /// As [`Case::laws`].
    laws: Vec<(usize, Text)>,
}

impl Checker {
    fn new(source: SourceId) -> Self {
        Checker {
            source,
            graph: Graph::default(),
            names: Names::default(),
            diagnostics: vec![],
            declared: vec![],
            constants: Constants::default(),
            used: HashSet::new(),
            laws: vec![],
        }
    }

    pub(crate) fn error(&mut self, message: impl Into<String>, span: Span, label: &str) -> &mut Diagnostic {
        self.diagnostics.push(Diagnostic::error(message).at(self.source, span, label));
        let last = self.diagnostics.len() - 1;
        &mut self.diagnostics[last]
    }

    pub(crate) fn warn(&mut self, message: impl Into<String>, span: Span, label: &str) -> &mut Diagnostic {
        self.diagnostics.push(Diagnostic::warning(message).at(self.source, span, label));
        let last = self.diagnostics.len() - 1;
        &mut self.diagnostics[last]
    }

    /// Declares a name of the system.
    pub(crate) fn declare(&mut self, name: &Text, what: &str) -> Symbol {
        let text = name.value.as_str();
        let mut letters = text.chars();
        let proper = letters.next().is_some_and(|c| c.is_alphabetic() || c == '_')
            && letters.all(|c| c.is_alphanumeric() || c == '_');
        if !proper {
            self.error(format!("`{text}` cannot be a name"), name.span, "")
                .help
                .push("a name starts with a letter and holds letters, digits and underscores".into());
        } else if text.len() > LONGEST_NAME {
            self.error(format!("a name has at most {LONGEST_NAME} letters"), name.span, "")
                .help
                .push("shorten it: it stands in tables and in names of files".into());
        } else if text == "t" || text == "pi" || ops::function(text).is_some() {
            self.error(format!("`{text}` has a meaning of its own and cannot name a {what}"), name.span, "")
                .help
                .push("give it another name, here and in the expressions".into());
        }
        if let Some((_, span)) = self.declared.iter().find(|(n, _)| n == text) {
            let (span, source) = (*span, self.source);
            let d = self.error(format!("`{text}` is declared twice"), name.span, "again here");
            *d = d.clone().also(source, span, "first here").help("give one of the two another name");
        } else {
            self.declared.push((text.to_owned(), name.span));
        }
        self.names.intern(text)
    }

    /// Says that a name is not known, with the nearest of `allowed`.
    pub(crate) fn unknown_name(&mut self, name: &str, span: Span, what: &str, allowed: &[&str]) {
        let near = nearest(name, allowed.iter().copied());
        let declared = near.and_then(|n| self.declared.iter().find(|(d, _)| d == n)).map(|(_, s)| *s);
        let source = self.source;
        let d = self.error(format!("unknown {what} `{name}`"), span, "");
        if let Some(span) = declared {
            *d = d.clone().also(source, span, "a similar name is declared here");
        }
        d.help.push(match near {
            Some(near) => format!("did you mean `{near}`?"),
            None if allowed.is_empty() => format!("there is no {what} here"),
            None => format!("known here: {}", allowed.join(", ")),
        });
    }

    /// Parses and lowers an expression in which the `allowed` names (and constants) may stand; fixed constants become numbers.
    pub(crate) fn expression(&mut self, text: &Text, allowed: &[&str]) -> Option<Id> {
        let ast = match parse(&text.value) {
            Ok(ast) => ast,
            Err(e) => {
                let hint = e.hint();
                let d = self.error(e.to_string(), e.span.shifted(text.span.start), "");
                d.help.extend(hint);
                return None;
            }
        };
        for (name, _) in ast.names() {
            if self.constants.knows(name) {
                self.used.insert(name.to_owned());
            }
        }
        let (names, constants) = (&self.names, &self.constants);
        let known = |name: &str| allowed.contains(&name) || constants.knows(name);
        let lowered = self.graph.lower(&ast, |name| known(name).then(|| names.get(name)).flatten());
        match lowered {
            Ok(root) => Some(self.constants.folded(&mut self.graph, root)),
            Err(unknown) => {
                let constants: Vec<String> = self.constants.names().map(str::to_owned).collect();
                let mut all: Vec<&str> = allowed.to_vec();
                all.extend(constants.iter().map(String::as_str));
                let mut seen = HashSet::new();
                for u in unknown.into_iter().filter(|u| seen.insert(u.name.clone())) {
                    self.unknown_name(&u.name, u.span.shifted(text.span.start), "name", &all);
                }
                None
            }
        }
    }

    /// A unit's factor to SI; 1 after a diagnostic.
    pub(crate) fn unit(&mut self, unit: &Text) -> Unit {
        match Unit::parse(&unit.value) {
            Ok(unit) => unit,
            Err(e) => {
                let hint = e.hint();
                let d = self.error(e.message, e.span.shifted(unit.span.start), "");
                d.help.extend(hint);
                Unit::ONE
            }
        }
    }

    fn system(&mut self, spec: &Spec) -> System {
        let time = self.names.intern("t");
        let time = self.graph.symbol(time);
        let mut states = Vec::new();
        for (name, unit) in &spec.states {
            let symbol = self.declare(name, "state");
            let node = self.graph.symbol(symbol);
            let factor = self.unit(unit).factor;
            states.push(State {
                name: name.value.clone(),
                unit: unit.value.clone(),
                factor,
                node,
                velocity: None,
            });
        }
        let mut inputs = Vec::new();
        for (name, unit) in &spec.inputs {
            let symbol = self.declare(name, "input");
            let node = self.graph.symbol(symbol);
            let factor = self.unit(unit).factor;
            inputs.push(Input { name: name.value.clone(), unit: unit.value.clone(), factor, node });
        }
        let parameters = self.gather_constants(spec);
        let mut allowed: Vec<&str> = vec!["t"];
        allowed.extend(spec.states.iter().map(|(n, _)| n.value.as_str()));
        allowed.extend(spec.inputs.iter().map(|(n, _)| n.value.as_str()));

        let zero = self.graph.constant(0.0);
        let mut known = vec![zero; states.len()];
        let mut inertia = vec![None; states.len()];
        self.per_state("known", &spec.known, spec, |checker, k, text| {
            if let Some(id) = checker.expression(text, &allowed) {
                known[k] = id;
            }
        });
        for (name, _) in
            spec.states.iter().filter(|(n, _)| !spec.known.iter().any(|(k, _)| k.value == n.value))
        {
            self.error(format!("state `{}` has no rate", name.value), name.span, "declared here")
                .help
                .push(format!("add `\"{}\": \"...\"` to `known`; the rate may be \"0\"", name.value));
        }
        self.per_state("inertia", &spec.inertia, spec, |checker, k, text| {
            inertia[k] = checker.expression(text, &allowed);
        });
        for k in 0..states.len() {
            states[k].velocity = (0..states.len()).find(|&v| v != k && states[v].node == known[k]);
        }
        let mut terms = Vec::new();
        let entries: Vec<(Text, UnknownSpec)> = spec.unknown.clone();
        self.per_state("unknown", &entries, spec, |checker, k, unknown| {
            checker.terms(k, unknown, &allowed, &mut terms);
        });
        let system_states: Vec<Id> = states.iter().map(|s: &State| s.node).collect();
        let contacts = self.contacts(spec, &allowed, &states, &system_states, &known, &terms);
        System {
            title: spec.title.as_ref().map_or(String::new(), |t| t.value.clone()),
            graph: self.graph.clone(),
            names: self.names.clone(),
            time,
            states,
            inputs,
            known,
            inertia,
            terms,
            parameters,
            record_constants: self.constants.of_records(),
            constants: self.constants.fixed(),
            contacts,
        }
    }

    /// Calls `each` for the entries of a map from states to something.
    fn per_state<T>(
        &mut self,
        field: &str,
        map: &[(Text, T)],
        spec: &Spec,
        mut each: impl FnMut(&mut Self, usize, &T),
    ) {
        let names: Vec<&str> = spec.states.iter().map(|(n, _)| n.value.as_str()).collect();
        for (name, value) in map {
            match names.iter().position(|n| *n == name.value) {
                Some(k) => each(self, k, value),
                None => self.unknown_name(&name.value, name.span, &format!("state in `{field}`"), &names),
            }
        }
    }

    fn terms(&mut self, state: usize, unknown: &UnknownSpec, allowed: &[&str], terms: &mut Vec<Term>) {
        let one = self.graph.constant(1.0);
        let factor = match &unknown.factor {
            Some(text) => self.expression(text, allowed),
            None => Some(one),
        };
        if unknown.candidates.is_empty() && unknown.laws.is_empty() {
            self.error("there is nothing to look for: `candidates` is empty", unknown.span, "")
                .help
                .push("list candidates such as \"1\", or leave this entry out".into());
        }
        for law in &unknown.laws {
            if self.laws.iter().any(|(k, before)| *k == state && before.value == law.value) {
                self.error("the same law twice", law.span, "again here")
                    .help
                    .push("delete one of the two: no data can tell them apart".into());
                continue;
            }
            self.laws.push((state, law.clone()));
        }
        let texts: Vec<&str> = unknown.candidates.iter().map(|c| c.value.as_str()).collect();
        for (name, _) in unknown.within.iter().filter(|(name, _)| !texts.contains(&name.value.as_str())) {
            self.unknown_name(&name.value, name.span, "candidate in `within`", &texts);
        }
        let mut seen: HashMap<Id, Span> = HashMap::new();
        for candidate in &unknown.candidates {
            let (Some(factor), Some(bare)) = (factor, self.expression(candidate, allowed)) else { continue };
            if self.graph.value(bare) == Some(0.0) {
                self.error("this candidate is zero", candidate.span, "")
                    .help
                    .push("delete it, or correct the expression".into());
                continue;
            }
            if let Some(&first) = seen.get(&bare) {
                let source = self.source;
                let d = self.error("the same candidate twice", candidate.span, "again here");
                *d = d
                    .clone()
                    .also(source, first, "first here")
                    .help("delete one of the two: no data can tell them apart");
                continue;
            }
            seen.insert(bare, candidate.span);
            let value = self.graph.mul(factor, bare);
            let candidate = candidate.value.clone();
            let bounds = unknown.within.iter().find(|(name, _)| name.value == candidate);
            let within = bounds.map_or((f64::NEG_INFINITY, f64::INFINITY), |(_, within)| *within);
            let (unit, force, energy) = (None, None, None);
            let factor_text = unknown.factor.as_ref().map_or("1", |text| &text.value).to_owned();
            terms.push(Term {
                state,
                candidate,
                factor_text,
                factor,
                bare,
                value,
                within,
                unit,
                force,
                energy,
            });
        }
    }

    /// Contacts are velocities: linear in states, inputs and constants, with a state that is nobody's displacement.
    fn contacts(
        &mut self,
        spec: &Spec,
        allowed: &[&str],
        states: &[State],
        nodes: &[Id],
        known: &[Id],
        terms: &[Term],
    ) -> Vec<Contact> {
        let mut contacts: Vec<Contact> = Vec::new();
        for text in &spec.contacts {
            let Some(node) = self.expression(text, allowed) else { continue };
            let gradient = self.graph.gradient(node, nodes);
            let parts: Vec<usize> =
                (0..nodes.len()).filter(|&k| self.graph.value(gradient[k]) != Some(0.0)).collect();
            let linear = gradient.iter().all(|&g| self.graph.value(g).is_some());
            let displacement = parts.iter().copied().find(|&k| states[k].velocity.is_some());
            if parts.is_empty() || !linear || displacement.is_some() {
                let d =
                    self.error(format!("`{}` is no velocity, so it cannot stick", text.value), text.span, "");
                d.help.push(match displacement {
                    Some(k) => {
                        let (x, v) = (&states[k].name, states[k].velocity.map_or("", |v| &states[v].name));
                        format!("`{x}` is a displacement; its velocity is `{v}`")
                    }
                    None => {
                        "a contact is a velocity or a difference of velocities, such as \"v\" or \"v1-v2\""
                            .into()
                    }
                });
                continue;
            }
            let minus = self.graph.neg(node);
            if contacts.iter().any(|c| c.node == node || c.node == minus) {
                self.error("the same contact twice", text.span, "")
                    .help
                    .push("delete one of the two: the sign of a velocity makes no difference".into());
                continue;
            }
            let mut roots: Vec<Id> = known.to_vec();
            roots.extend(terms.iter().map(|t| t.value));
            // A law may bring the friction; its force is not known here.
            if self.laws.is_empty() && !holds_sign(&mut self.graph, &roots, node) {
                let message = format!(
                    "no rate holds `sgn({0})`: contact `{0}` has no friction and never sticks, unless `gap` finds some there",
                    text.value
                );
                self.warn(message, text.span, "");
            }
            contacts.push(Contact { text: text.value.clone(), node });
        }
        contacts
    }

    fn unused_constants(&mut self, spec: &Spec) {
        for (name, _) in &spec.constants {
            if !self.used.contains(&name.value) {
                self.warn(format!("constant `{}` is not used", name.value), name.span, "");
            }
        }
    }
}

/// The number of a record constant, where it is one.
pub(crate) fn number(value: &Value) -> Option<f64> {
    if let Value::Number(x) = value { Some(*x) } else { None }
}
