//! The state of a check: names so far, expressions lowered among them, and what was found wrong.

use crate::system::constants::Constants;
use crate::system::curve::Curve;
use crate::system::equations::TableRead;
use crate::text::diagnostic::{Diagnostic, SourceId};
use crate::text::files::Files;
use crate::text::spec::{Number, Text};
use crate::units::unit::{Scale, Unit};
use phisindy_expr::{Graph, Id, Names, Span, Symbol, nearest, ops, parse_with};
use std::collections::{HashMap, HashSet};

/// Most bytes of a name.
const LONGEST_NAME: usize = 100;

/// The state of a check: names so far, and what was found wrong.
pub(super) struct Checker {
    pub(super) source: SourceId,
    pub(super) graph: Graph,
    pub(super) names: Names,
    pub(super) diagnostics: Vec<Diagnostic>,
    /// Where each name of the system was declared, to explain clashes and to offer hints.
    declared: Vec<(String, Span)>,
    pub(super) constants: Constants,
    /// What the names of `let` stand for.
    definitions: HashMap<Id, Id>,
    /// Constants that some expression uses.
    pub(super) used: HashSet<String>,
    /// Names in the periods and delays of what is held.
    pub(super) timing: HashSet<String>,
    /// Laws of the catalogue that `unknown` names, each with its state.
    pub(super) laws: Vec<(usize, Text)>,
    /// The files that the spec names beside its records.
    files: Files,
    /// Tables that some expression reads.
    pub(super) tables: Vec<TableRead>,
    /// What `unknown` asks a formula for.
    pub(super) searches: Vec<(usize, Vec<Text>)>,
}

impl Checker {
    pub(super) fn new(source: SourceId, files: &Files) -> Self {
        Checker {
            source,
            graph: Graph::default(),
            names: Names::default(),
            diagnostics: vec![],
            declared: vec![],
            constants: Constants::default(),
            definitions: HashMap::new(),
            used: HashSet::new(),
            timing: HashSet::new(),
            laws: vec![],
            searches: vec![],
            files: files.clone(),
            tables: vec![],
        }
    }

    pub(super) fn error(&mut self, message: impl Into<String>, span: Span, label: &str) -> &mut Diagnostic {
        self.diagnostics.push(Diagnostic::error(message).at(self.source, span, label));
        let last = self.diagnostics.len() - 1;
        &mut self.diagnostics[last]
    }

    pub(super) fn warn(&mut self, message: impl Into<String>, span: Span, label: &str) -> &mut Diagnostic {
        self.diagnostics.push(Diagnostic::warning(message).at(self.source, span, label));
        let last = self.diagnostics.len() - 1;
        &mut self.diagnostics[last]
    }

    /// The number of errors so far.
    pub(super) fn errors(&self) -> usize {
        self.diagnostics.iter().filter(|d| d.is_error()).count()
    }

    /// Warns of what is said of a column that the record does not have.
    pub(super) fn without_column(&mut self, name: &Text, what: &str) {
        self.warn(
            format!("this record has no column of `{}`, so its {what} does nothing", name.value),
            name.span,
            "",
        )
        .help
        .push(format!("give `{}` a column, or leave its {what} out", name.value));
    }

    /// Declares a name of the system.
    pub(super) fn declare(&mut self, name: &Text, what: &str) -> Symbol {
        let text = name.value.as_str();
        let article = if what.starts_with(['a', 'e', 'i', 'o', 'u']) { "an" } else { "a" };
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
        } else if ["t", "pi", "table"].contains(&text) || ops::function(text).is_some() {
            self.error(
                format!("`{text}` has a meaning of its own and cannot name {article} {what}"),
                name.span,
                "",
            )
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

    /// Reports an unknown name, with the nearest of `allowed`.
    pub(super) fn unknown_name(&mut self, name: &str, span: Span, what: &str, allowed: &[&str]) {
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

    /// Lets a name stand for an expression in all that follow.
    pub(super) fn define(&mut self, name: &Text, text: &Text, allowed: &[&str]) {
        let symbol = self.declare(name, "name for an expression");
        let node = self.graph.symbol(symbol);
        // After a mistake the name stays known: what else uses it is right.
        let meaning = self.expression(text, allowed).unwrap_or_else(|| self.graph.constant(1.0));
        self.definitions.insert(node, meaning);
    }

    /// Parses and lowers an expression in which the `allowed` names (and constants) may stand; fixed
    /// constants become numbers.
    pub(super) fn expression(&mut self, text: &Text, allowed: &[&str]) -> Option<Id> {
        self.expression_with(text, allowed, &[])
    }

    /// As [`Checker::expression`], in which an accessor may stand before a name: see [`parse_with`].
    pub(super) fn expression_with(
        &mut self,
        text: &Text,
        allowed: &[&str],
        accessors: &[&str],
    ) -> Option<Id> {
        let ast = match parse_with(&text.value, accessors) {
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
        let files = &self.files;
        let (mut wrong, mut read) = (Vec::new(), Vec::new());
        let table = |graph: &mut Graph, path: &str, cubic: bool, of: Id| {
            // Whoever read the spec has told of a file that is missing.
            let numbers = files.numbers(path, None)?;
            Some(match Curve::of(numbers) {
                Ok(curve) => {
                    let value = curve.value(graph, of, cubic);
                    read.push(TableRead { path: path.to_owned(), of, within: curve.within() });
                    value
                }
                Err(why) => {
                    wrong.push((path.to_owned(), why));
                    of
                }
            })
        };
        let resolve = |name: &str| known(name).then(|| names.get(name)).flatten();
        let lowered = self.graph.lower_with(&ast, resolve, table);
        for table in read {
            // A name of `let` stands for what it is.
            let of = self.graph.replace(&[table.of], &self.definitions)[0];
            let table = TableRead { of: self.constants.folded(&mut self.graph, of), ..table };
            if !self.tables.contains(&table) {
                self.tables.push(table);
            }
        }
        if let Some((path, why)) = wrong.into_iter().next() {
            let at = ast
                .files()
                .find(|(own, _)| *own == path)
                .map_or(text.span, |(_, at)| at.shifted(text.span.start));
            self.error(format!("`{path}`: {why}"), at, "").help.push(
                "two columns: the argument, which grows, and the value; more points than needed cost time"
                    .into(),
            );
            return None;
        }
        match lowered {
            Ok(root) => {
                let root = self.graph.replace(&[root], &self.definitions)[0];
                let root = self.constants.folded(&mut self.graph, root);
                self.timings(text, &ast, root);
                Some(root)
            }
            Err(unknown) => {
                let constants: Vec<String> = self.constants.names().map(str::to_owned).collect();
                let mut all: Vec<&str> = allowed.to_vec();
                all.extend(constants.iter().map(String::as_str));
                let mut seen = HashSet::new();
                for u in unknown.into_iter().filter(|u| seen.insert(u.name.clone())) {
                    let span = u.span.shifted(text.span.start);
                    match u.name.strip_prefix("rate ") {
                        Some(of) => {
                            let states: Vec<&str> =
                                all.iter().filter_map(|n| n.strip_prefix("rate ")).collect();
                            self.unknown_name(of, span, "state in `rate(...)`", &states);
                        }
                        None => {
                            let plain: Vec<&str> = all.iter().copied().filter(|n| !n.contains(' ')).collect();
                            self.unknown_name(&u.name, span, "name", &plain);
                        }
                    }
                }
                None
            }
        }
    }

    /// The unit that a text names; the unit 1 after a diagnostic.
    pub(super) fn unit(&mut self, unit: &Text) -> Unit {
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

    /// A number in SI; 1 after a diagnostic if it is too large for a double.
    pub(super) fn si(&mut self, number: &Number, factor: f64) -> f64 {
        // As numbers in files are converted: by shifting the decimal point where possible, so that 3 mm are
        // exactly 0.003 m.
        let si = Scale::of(factor).converted(number.value);
        if si.is_finite() {
            return si;
        }
        self.error("this number is too large in SI units", number.span, "")
            .help
            .push("numbers go up to 1.7e308: choose a larger unit".into());
        1.0
    }
}
