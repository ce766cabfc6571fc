//! What is wrong with the text of a law, with the places in it. The law itself is read by
//! [`super::Law::read`].

use super::graph::LawError;
use super::{INPUT, Law};
use crate::system::check::declared_names;
use crate::text::diagnostic::{Diagnostic, SourceId};
use crate::text::fields;
use crate::text::files::Files;
use crate::text::raw::{self, Node};
use crate::text::spec::group::Fields;
use crate::text::spec::reader::Reader;
use crate::text::spec::{ConstantSpec, LearnSpec, Number, OutputSpec, Spanned, Spec, Text};
use crate::units::dimensions::dimensions;
use crate::units::unit::{Dimension, Unit};
use phisindy_expr::{AstKind, AstNode, Binary, Span, nearest, parse};

/// A number of a law with its unit and bounds.
struct Parameter {
    name: Text,
    unit: Text,
}

/// What the check keeps of a law.
#[derive(Default)]
struct Written {
    roles: Vec<(Text, Text)>,
    parameters: Vec<Parameter>,
    given: Vec<(Text, Text)>,
    internal: Vec<(Text, Text, Text)>,
    /// Force, push, mirror: expressions that measure a force.
    forces: Vec<(&'static str, Text)>,
    /// `needs`, with the names of the parameters alone.
    closed: Vec<(String, Text, Vec<String>)>,
}

impl Law {
    /// Reads the text of a law and says where its mistakes are.
    ///
    /// # Errors
    /// All mistakes that were found: of form, units, bounds, roles, names, expressions.
    ///
    /// ```
    /// use phisindy_phys::{Law, SourceId};
    /// let text = r#"(name: "Drag", roles: { "v": "m/s" }, parameters: { "d": (unit: "N*s/m", within: (0.0, 9.0)) }, force: "d*v*abs(v)")"#;
    /// let mistakes = Law::checked(text, SourceId(0)).unwrap_err();
    /// // It is no force: the unit of `d` lacks a second and a metre.
    /// assert_eq!(mistakes.len(), 1);
    /// assert!(Law::checked(&text.replace("N*s/m", "N*s^2/m^2"), SourceId(0)).is_ok());
    /// ```
    pub fn checked(text: &str, source: SourceId) -> Result<Law, Vec<Diagnostic>> {
        let root = raw::parse(text).map_err(|mistake| vec![mistake.diagnostic(source)])?;
        let mut reader = Reader::new(text, source, None);
        let written = reader.law(&root);
        if let Some(written) = written.filter(|_| reader.found.is_empty()) {
            reader.meaning(&written, root.span);
        }
        if !reader.found.is_empty() {
            return Err(reader.found);
        }
        // What is left has no place that is better known.
        let other = |e: LawError| vec![Diagnostic::error(e.to_string()).at(source, root.span, "")];
        Law::read(text).map_err(other)
    }

    /// The laws that this law names and `known` does not hold, as warnings with their places in its text.
    pub fn unknown_references(text: &str, source: SourceId, known: &[&str]) -> Vec<Diagnostic> {
        let Ok(root) = raw::parse(text) else { return vec![] };
        let mut reader = Reader::new(text, source, None);
        let mut names: Vec<Text> = Vec::new();
        for entry in &root.entries {
            let field = entry.key.as_ref().map_or("", |key| reader.slice(key.span));
            match field {
                "simpler" | "same_as" => {
                    names.extend(reader.list(&entry.value, Reader::words).unwrap_or_default());
                }
                "told_apart_by" => {
                    let pairs = reader.map(&entry.value, Reader::prose).unwrap_or_default();
                    names.extend(pairs.into_iter().map(|(name, _)| name));
                }
                _ => {}
            }
        }
        let unknown = names.into_iter().filter(|name| !known.contains(&name.value.as_str()));
        let told = |name: Text| {
            let said = Diagnostic::warning(format!("there is no law `{}`", name.value)).at(
                source,
                name.span,
                "not in the catalogue",
            );
            match nearest(&name.value, known.iter().copied()) {
                Some(near) => said.help(format!("did you mean `{near}`?")),
                None => said.help("`phisindy laws` lists the laws"),
            }
        };
        unknown.map(told).collect()
    }
}

impl Reader<'_> {
    /// The form of a law.
    fn law(&mut self, node: &Node) -> Option<Written> {
        let fields = self.fields(node, &fields::LAW)?;
        self.required(&fields, "name", Self::prose);
        for field in ["about", "reference", "family"] {
            self.optional(&fields, field, Self::prose);
        }
        let mut out = Written { roles: self.pairs(&fields, "roles", Self::unit), ..Written::default() };
        self.roles(&out.roles);
        let parameters = self.pairs(&fields, "parameters", Self::law_parameter);
        out.parameters = parameters.into_iter().map(|(name, unit)| Parameter { name, unit }).collect();
        out.given = self.pairs(&fields, "given", Self::given_number);
        let internal = self.pairs(&fields, "internal", Self::internal_state);
        let numbers: Vec<String> = out.parameters.iter().map(|p| p.name.value.clone()).collect();
        for (name, (unit, rate, inertia)) in internal {
            let what = format!("the inertia of `{}`", name.value);
            out.closed.extend(inertia.map(|text| (what, text, numbers.clone())));
            out.internal.push((name, unit, rate));
        }
        for field in ["force", "push", "mirror"] {
            let text = self.optional(&fields, field, Self::words);
            out.forces.extend(text.map(|text| (field, text)));
        }
        self.kind(node, &fields, &mut out);
        if let Some(need) = fields.get("needs") {
            let inner = self.fields(need, &fields::NEED)?;
            let positive = self.required(&inner, "positive", Self::words);
            self.required(&inner, "because", Self::prose);
            let names = out.parameters.iter().map(|p| p.name.value.clone()).collect();
            out.closed.extend(positive.map(|text| ("`needs`".to_owned(), text, names)));
        }
        self.screen(&fields, &mut out);
        self.sketch(&fields, &out);
        for field in ["simpler", "same_as"] {
            self.optional(&fields, field, |r, n| r.list(n, Self::words));
        }
        self.pairs(&fields, "told_apart_by", Self::prose);
        if let Some(other) = fields.get("indistinguishable") {
            let inner = self.fields(other, &fields::INDISTINGUISHABLE)?;
            self.required(&inner, "cause", Self::prose);
            self.required(&inner, "check", Self::prose);
        }
        Some(out)
    }

    /// A displacement, a velocity and a load: one of each.
    fn roles(&mut self, roles: &[(Text, Text)]) {
        let mut seen: Vec<(Dimension, Span)> = Vec::new();
        for (name, unit) in roles {
            let Some(parsed) = self.parsed_unit(unit) else { continue };
            let is = parsed.dimension;
            let metre = Dimension::METRE;
            if ![metre, metre.div(Dimension::SECOND), Dimension::NEWTON].contains(&is) {
                let message = format!("the role `{}` is none of displacement, velocity, load", name.value);
                let help = "a role is a displacement in \"m\", a velocity in \"m/s\", or a load in \"N\"; what varies otherwise is no role";
                self.wrong::<()>(unit.span, message, "of this unit", help);
            } else if let Some(&(_, first)) = seen.iter().find(|(d, _)| *d == is) {
                let said = Diagnostic::error("two roles of one kind")
                    .at(self.source, unit.span, "again here")
                    .also(self.source, first, "first here")
                    .help("a law acts at one place, which has one displacement and one velocity");
                self.note(said);
            } else {
                seen.push((is, unit.span));
            }
        }
    }

    fn parsed_unit(&mut self, unit: &Text) -> Option<Unit> {
        Unit::parse(&unit.value).map_or_else(
            |why| {
                self.wrong(
                    unit.span,
                    format!("unknown unit `{}`: {why}", unit.value),
                    "",
                    "write SI units such as \"N*s/m\"",
                )
            },
            Some,
        )
    }

    fn law_parameter(&mut self, node: &Node) -> Option<Text> {
        let fields = self.fields(node, &fields::PARAMETER)?;
        let unit = self.required(&fields, "unit", Self::unit);
        self.required(&fields, "within", Self::bounds);
        self.optional(&fields, "each", Self::truth);
        self.optional(&fields, "whole", Self::truth);
        let unit = unit?;
        self.parsed_unit(&unit)?;
        Some(unit)
    }

    fn given_number(&mut self, node: &Node) -> Option<Text> {
        let [value, unit] = self.tuple(node, "a number and its unit like (1.0, \"m/s\")")?;
        let (value, unit) = (self.number(value), self.unit(unit));
        value?;
        let unit = unit?;
        self.parsed_unit(&unit)?;
        Some(unit)
    }

    fn internal_state(&mut self, node: &Node) -> Option<(Text, Text, Option<Text>)> {
        let fields = self.fields(node, &fields::INTERNAL)?;
        let unit = self.required(&fields, "unit", Self::unit);
        let rate = self.required(&fields, "rate", Self::words);
        self.required(&fields, "start", Self::number);
        let inertia = self.optional(&fields, "inertia", Self::words);
        let (unit, rate) = (unit?, rate?);
        self.parsed_unit(&unit)?;
        Some((unit, rate, inertia))
    }

    /// A law is one of force, push, property of a sensor, property of an input.
    fn kind(&mut self, node: &Node, fields: &Fields<'_, '_>, out: &mut Written) {
        let given: Vec<&str> =
            ["force", "push", "sensor", "input"].into_iter().filter(|f| fields.get(f).is_some()).collect();
        if given.len() != 1 {
            let message = if given.is_empty() {
                "the law says nothing".to_owned()
            } else {
                format!("the law is {} at once", given.join(" and "))
            };
            let help = "a law has one of `force` (subtracted), `push` (added), `sensor` and `input`";
            let at = given.get(1).and_then(|f| fields.get(f)).map_or(node.span, |n| n.span);
            self.wrong::<()>(at, message, "", help);
        }
        for (field, allowed) in
            [("sensor", &["offset", "gain", "delay", "lag"][..]), ("input", &["gain", "delay"][..])]
        {
            let Some(text) = fields.get(field).and_then(|n| self.words(n)) else { continue };
            if !allowed.contains(&text.value.as_str()) {
                let own = |name: &str| name == INPUT || out.internal.iter().any(|(z, ..)| z.value == name);
                let acts = || parse(&text.value).is_ok_and(|ast| ast.names().any(|(name, _)| own(name)));
                if field == "input" && acts() {
                    let unit = |value: &str| Text { value: value.to_owned(), span: text.span };
                    // An input is measured as a force is.
                    out.roles.push((unit(INPUT), unit("N")));
                    out.forces.push(("input", text));
                    continue;
                }
                let message = format!("no such property: `{}`", text.value);
                let more = if field == "input" {
                    ", or what acts in the place of `u`, like \"dead(u, d)\""
                } else {
                    ""
                };
                let help = format!("the properties of `{field}` are: {}{more}", allowed.join(", "));
                self.wrong::<()>(text.span, message, "", &help);
            }
            if out.parameters.len() != 1 {
                self.wrong::<()>(text.span, "such a law has one parameter", "", "the parameter is its value");
            }
        }
        if let (Some(mirror), None) = (fields.get("mirror"), fields.get("force")) {
            self.wrong::<()>(mirror.span, "a mirror image of no force", "", "`mirror` stands beside `force`");
        }
    }

    fn screen(&mut self, fields: &Fields<'_, '_>, out: &mut Written) -> Option<()> {
        let node = fields.get("screen")?;
        let inner = self.fields(node, &fields::SCREEN)?;
        let columns = self.required(&inner, "columns", |r, n| r.list(n, Self::words))?;
        self.optional(&inner, "rate", Self::words);
        let grid = self.pairs(&inner, "grid", Self::unit);
        let seeds = self.required(&inner, "seed", |r, n| r.map(n, Self::words))?;
        let names: Vec<String> = (1..=columns.len())
            .map(|k| format!("c{k}"))
            .chain(grid.iter().map(|(name, _)| name.value.clone()))
            .collect();
        for parameter in &out.parameters {
            if !seeds.iter().any(|(name, _)| name.value == parameter.name.value) {
                let message = format!("`screen` gives the parameter `{}` no start", parameter.name.value);
                self.wrong::<()>(node.span, message, "", "add it to `seed`");
            }
        }
        for (name, text) in seeds {
            if !out.parameters.iter().any(|p| p.name.value == name.value) {
                let names: Vec<&str> = out.parameters.iter().map(|p| p.name.value.as_str()).collect();
                self.unknown_name::<()>("parameter", name.span, &names);
            }
            out.closed.push((format!("the seed of `{}`", name.value), text, names.clone()));
        }
        Some(())
    }

    fn sketch(&mut self, fields: &Fields<'_, '_>, out: &Written) -> Option<()> {
        let node = fields.get("sketch")?;
        let inner = self.fields(node, &fields::SKETCH)?;
        let over = self.required(&inner, "over", Self::words);
        if let Some(over) = over.filter(|o| !["x", "v", "t"].contains(&o.value.as_str())) {
            self.unknown_name::<()>("quantity", over.span, &["x", "v", "t"]);
        }
        let with = self.required(&inner, "with", |r, n| r.map(n, Self::number))?;
        let missing = |p: &&Parameter| !with.iter().any(|(name, _)| name.value == p.name.value);
        if let Some(p) = out.parameters.iter().find(missing) {
            let message = format!("the sketch has no value of `{}`", p.name.value);
            self.wrong::<()>(node.span, message, "", "a sketch needs a value of every parameter");
        }
        Some(())
    }

    /// Names, expressions and units: the law as a small model of its own, in which the places of the text are
    /// kept.
    fn meaning(&mut self, law: &Written, whole: Span) {
        let names = law.roles.iter().map(|(name, _)| (name, "role"));
        let names = names
            .chain(law.parameters.iter().map(|p| (&p.name, "parameter")))
            .chain(law.given.iter().map(|(name, _)| (name, "number")))
            .chain(law.internal.iter().map(|(name, ..)| (name, "state")));
        self.found.extend(declared_names(self.source, names));
        let open =
            law.forces.iter().map(|(_, text)| text).chain(law.internal.iter().map(|(_, _, rate)| rate));
        let (mut outside, mut used): (Vec<String>, Vec<String>) = (vec![], vec![]);
        let told = self.found.len();
        for text in open {
            for name in self.names_of(text) {
                used.push(name.clone());
                if !law.declares(&name) && !outside.contains(&name) {
                    outside.push(name);
                }
            }
        }
        // The value of a property of a sensor stands in no expression, and what cannot be read may use any
        // name.
        let all_read = !law.forces.is_empty() && self.found.len() == told;
        for p in law.parameters.iter().filter(|p| all_read && !used.contains(&p.name.value)) {
            let message = format!("nothing depends on the parameter `{}`", p.name.value);
            self.wrong::<()>(p.name.span, message, "", "use it in the force or in a rate, or leave it out");
        }
        for (what, text, allowed) in &law.closed {
            let ast = parse(&text.value);
            self.names_of(text);
            for (name, span) in ast.iter().flat_map(|ast| ast.names()) {
                if !allowed.iter().any(|a| a == name) && name != "pi" {
                    let message = format!("{what}: the name `{name}` stands for nothing here");
                    let help = format!("known here: {}", allowed.join(", "));
                    self.wrong::<()>(span.shifted(text.span.start), message, "", &help);
                }
            }
        }
        if self.found.is_empty() {
            let spec = law.as_spec(&outside, whole);
            self.found.extend(dimensions(&spec, self.source).err().unwrap_or_default());
        }
    }

    /// The names of an expression; a mistake in it is noted.
    fn names_of(&mut self, text: &Text) -> Vec<String> {
        match parse(&text.value) {
            Ok(ast) => {
                let holds = |node: &&AstNode| matches!(node.kind, AstKind::Binary(Binary::Hold, ..));
                if let Some(node) = ast.nodes.iter().find(holds) {
                    let help = "a controller stands in the spec, in `known` or `let`";
                    let span = node.span.shifted(text.span.start);
                    self.wrong::<()>(span, "`hold` stands in no law", "", help);
                }
                ast.names().map(|(name, _)| name.to_owned()).filter(|n| n != "pi").collect()
            }
            Err(e) => {
                let said =
                    Diagnostic::error(e.to_string()).at(self.source, e.span.shifted(text.span.start), "");
                let said = e.hint().into_iter().fold(said, Diagnostic::help);
                self.note(said);
                vec![]
            }
        }
    }
}

impl Written {
    fn declares(&self, name: &str) -> bool {
        let all = self.roles.iter().map(|(n, _)| n).chain(self.parameters.iter().map(|p| &p.name));
        let all = all.chain(self.given.iter().map(|(n, _)| n)).chain(self.internal.iter().map(|(n, ..)| n));
        name == "t" || all.into_iter().any(|n| n.value == name)
    }

    /// A model whose inputs are the roles, whose states are those of the law, and whose outputs are its
    /// forces.
    fn as_spec(&self, outside: &[String], whole: Span) -> Spec {
        let put = |value: &str| Spanned { value: value.to_owned(), span: whole };
        let number =
            |unit: Option<Text>| ConstantSpec::Number { value: Number { value: 1.0, span: whole }, unit };
        let mut constants: Vec<(Text, ConstantSpec)> =
            self.parameters.iter().map(|p| (p.name.clone(), number(Some(p.unit.clone())))).collect();
        constants.extend(self.given.iter().map(|(name, unit)| (name.clone(), number(Some(unit.clone())))));
        // A name of the model may have any unit.
        constants.extend(outside.iter().map(|name| (put(name), number(None))));
        let output =
            |(field, text): &(&str, Text)| (put(field), OutputSpec { unit: put("N"), reads: text.clone() });
        Spec {
            structure: None,
            files: Files::default(),
            title: None,
            constants,
            states: self.internal.iter().map(|(name, unit, _)| (name.clone(), unit.clone())).collect(),
            inputs: self.roles.clone(),
            outputs: self.forces.iter().map(output).collect(),
            definitions: vec![],
            energy: None,
            known: self.internal.iter().map(|(name, _, rate)| (name.clone(), rate.clone())).collect(),
            inertia: vec![],
            between: vec![],
            unknown: vec![],
            contacts: vec![],
            places: vec![],
            impacts: vec![],
            limits: None,
            data: vec![],
            learn: LearnSpec::default(),
        }
    }
}
