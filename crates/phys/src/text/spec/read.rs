//! The whole spec.

use super::energy::per_second;
use super::reader::Reader;
use super::structure::StructureSpec;
use super::{DataSpec, ImpactSpec, OutputSpec, PlaceSpec, Spec, Text, UnknownSpec};
use crate::text::diagnostic::{Diagnostic, SourceId};
use crate::text::fields;
use crate::text::files::{Files, NamedFile, files_in};
use crate::text::raw::{Node, Shape, parse};

/// Reads the text of a spec. With the spec come warnings; spans point into `text`.
///
/// # Errors
/// All mistakes of form that were found: the first one only if the text is not RON at all.
///
/// ```
/// use phisindy_phys::{SourceId, spec::read};
/// let text = r#"(states: { "x": "m" }, known: { "x": "1" }, data: [Csv(path: "a.csv", time: "t", columns: {})])"#;
/// let (spec, _) = read(text, SourceId(0)).expect("a good spec");
/// assert_eq!(spec.states[0].0.value, "x");
/// assert_eq!(&text[spec.states[0].1.span.range()], "m");
/// let mistakes = read("(state: {}, titel: 1)", SourceId(0)).unwrap_err();
/// assert_eq!(mistakes.len(), 5); // two unknown fields, three missing ones
/// ```
pub fn read(text: &str, source: SourceId) -> Result<(Spec, Vec<Diagnostic>), Vec<Diagnostic>> {
    read_with(text, source, Data::Required, Some(&Files::default()))
}

/// As [`read`], but for a program that holds the records in memory: the text need not have `data`, and
/// [`Spec::data`] may be empty.
///
/// # Errors
/// As [`read`].
///
/// ```
/// use phisindy_phys::{SourceId, spec};
/// let text = r#"(states: { "x": "m" }, known: { "x": "1" })"#;
/// assert!(spec::read(text, SourceId(0)).is_err());
/// assert!(spec::read_without_data(text, SourceId(0)).is_ok());
/// ```
pub fn read_without_data(text: &str, source: SourceId) -> Result<(Spec, Vec<Diagnostic>), Vec<Diagnostic>> {
    read_with(text, source, Data::Optional, Some(&Files::default()))
}

/// As [`read`], with the files that the text names beside its records ([`crate::named_files`]).
///
/// # Errors
/// As [`read`], and a file that is named and not given.
pub fn read_with_files(
    text: &str,
    source: SourceId,
    files: &Files,
) -> Result<(Spec, Vec<Diagnostic>), Vec<Diagnostic>> {
    read_with(text, source, Data::Required, Some(files))
}

/// As [`read_without_data`], with the files that the text names.
///
/// # Errors
/// As [`read_with_files`].
pub fn read_in_memory(
    text: &str,
    source: SourceId,
    files: &Files,
) -> Result<(Spec, Vec<Diagnostic>), Vec<Diagnostic>> {
    read_with(text, source, Data::Optional, Some(files))
}

/// As [`read`], of whatever the text says itself: files that it names are not looked at, and of `structure` nothing is
/// read. For programs that change the text, or look at its constants and records.
///
/// # Errors
/// As [`read`].
pub fn read_without_files(text: &str, source: SourceId) -> Result<(Spec, Vec<Diagnostic>), Vec<Diagnostic>> {
    read_with(text, source, Data::Required, None)
}

/// Whether the list of records must be there.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Data {
    Required,
    Optional,
}

fn read_with(
    text: &str,
    source: SourceId,
    data: Data,
    files: Option<&Files>,
) -> Result<(Spec, Vec<Diagnostic>), Vec<Diagnostic>> {
    let root = parse(text).map_err(|mistake| vec![mistake.diagnostic(source)])?;
    let given = |file: &NamedFile| {
        files.is_none_or(|files| files.numbers(&file.path, file.array.as_deref()).is_some())
    };
    let missing = files_in(text, &root).into_iter().filter(|file| !given(file));
    let missing: Vec<Diagnostic> = missing
        .map(|file| {
            Diagnostic::error(format!("the file `{}` is not given", file.path))
                .at(source, file.span, "its numbers are needed")
                .help("open the spec as a file, or hand the numbers over with its text")
        })
        .collect();
    if !missing.is_empty() {
        return Err(missing);
    }
    let mut reader = Reader::new(text, source, files);
    match reader.spec(&root, data) {
        Some(spec) if !reader.found.iter().any(Diagnostic::is_error) => Ok((spec, reader.found)),
        _ => Err(reader.found),
    }
}

/// What the list of records asks for.
const RECORD: &str = "add a record: `Csv(path: \"run.csv\", ...)` or `Synthetic(...)`";

impl Reader<'_> {
    fn spec(&mut self, node: &Node, data: Data) -> Option<Spec> {
        if node.name.is_some() {
            return self.expected(node, "the spec's fields in round brackets, without a name", "");
        }
        let fields = self.fields(node, &fields::SPEC)?;
        let title = self.optional(&fields, "title", Self::prose);
        let constants = self.pairs(&fields, "constants", Self::constant);
        let energy = self.optional(&fields, "energy", Self::energy);
        let structure = match self.files {
            Some(_) => self.optional(&fields, "structure", Self::structure),
            None => None,
        };
        let moves = fields.get("energy").or(fields.get("structure")).is_some();
        let states = match moves {
            true => Some(self.pairs(&fields, "states", Self::unit)),
            false => self.required(&fields, "states", |r, n| r.map(n, Self::unit)),
        };
        let inputs = self.pairs(&fields, "inputs", Self::unit);
        let outputs = self.pairs(&fields, "outputs", Self::output);
        let definitions = self.pairs(&fields, "let", Self::words);
        let known = match moves {
            true => Some(self.pairs(&fields, "known", Self::words)),
            false => self.required(&fields, "known", |r, n| r.map(n, Self::words)),
        };
        let (mut inertia, mut between) = (Vec::new(), Vec::new());
        for (name, row) in self.pairs(&fields, "inertia", Self::inertia) {
            for (other, text) in row {
                match other.filter(|other| other.value != name.value) {
                    None => inertia.push((name.clone(), text)),
                    Some(other) => between.push((name.clone(), other, text)),
                }
            }
        }
        let unknown = self.pairs(&fields, "unknown", Self::unknown);
        let contacts = self.optional(&fields, "contacts", |r, n| r.list(n, Self::words));
        let places = self.pairs(&fields, "places", Self::place);
        let impacts = self.pairs(&fields, "impacts", Self::impact);
        let limits = self.optional(&fields, "limits", Self::limits);
        let data = match data {
            Data::Required => self.required(&fields, "data", |r, n| r.filled(n, RECORD, Self::record)),
            Data::Optional => {
                let records = self.optional(&fields, "data", |r, n| r.list(n, Self::record));
                Some(records.unwrap_or_default())
            }
        };
        let learn = self.optional(&fields, "learn", Self::learn);
        let (mut states, mut known) = (states?, known?);
        if let Some(energy) = &energy {
            states.extend(energy.states());
            known.extend(energy.rates());
        }
        for (displacement, speed, unit) in structure.iter().flat_map(StructureSpec::pairs) {
            states.push((displacement.clone(), unit.clone()));
            states.push((speed.clone(), per_second(&unit)));
            known.push((displacement, speed));
        }
        let spec = Spec {
            title,
            constants,
            states,
            inputs,
            outputs,
            definitions,
            energy,
            structure,
            known,
            inertia,
            between,
            unknown,
            contacts: contacts.unwrap_or_default(),
            places,
            impacts,
            limits,
            data: data?,
            learn: learn.unwrap_or_default(),
            files: self.files.clone().unwrap_or_default(),
        };
        self.within_size(&spec);
        Some(spec)
    }

    /// `"m"`, or a row of a matrix: `{ "v": "M+m", "w": "m*l*cos(th)" }`
    fn inertia(&mut self, node: &Node) -> Option<Vec<(Option<Text>, Text)>> {
        if !matches!(node.shape, Shape::Map) {
            return self.words(node).map(|text| vec![(None, text)]);
        }
        let row = self.map(node, Self::words)?;
        Some(row.into_iter().map(|(name, text)| (Some(name), text)).collect())
    }

    /// `"r*w - v"`, or `(of: "p1 - p2", enters: { "p1": "-B/V" })`, or `(of: "u", replaces: "u")`
    fn place(&mut self, node: &Node) -> Option<PlaceSpec> {
        if !matches!(node.shape, Shape::Group) {
            return self.words(node).map(|of| PlaceSpec { of, enters: vec![], replaces: None });
        }
        let fields = self.fields(node, &fields::PLACE)?;
        let of = self.required(&fields, "of", Self::words);
        let enters = self.pairs(&fields, "enters", Self::words);
        let replaces = self.optional(&fields, "replaces", Self::words);
        Some(PlaceSpec { of: of?, enters, replaces })
    }

    /// `(when: "z", restitution: 0.8)`
    fn impact(&mut self, node: &Node) -> Option<ImpactSpec> {
        let fields = self.fields(node, &fields::IMPACT)?;
        let when = self.required(&fields, "when", Self::words);
        let restitution = self.required(&fields, "restitution", Self::sensor_value);
        Some(ImpactSpec { when: when?, restitution: restitution? })
    }

    /// `(unit: "m/s^2", reads: "rate(v)")`
    fn output(&mut self, node: &Node) -> Option<OutputSpec> {
        let fields = self.fields(node, &fields::OUTPUT)?;
        let unit = self.required(&fields, "unit", Self::unit);
        let reads = self.required(&fields, "reads", Self::words);
        Some(OutputSpec { unit: unit?, reads: reads? })
    }

    fn unknown(&mut self, node: &Node) -> Option<UnknownSpec> {
        let fields = self.fields(node, &fields::UNKNOWN)?;
        let factor = self.optional(&fields, "factor", Self::words);
        let mut texts = |name| self.optional(&fields, name, |r: &mut Self, n| r.list(n, Self::words));
        let (candidates, laws, search) = (texts("candidates"), texts("laws"), texts("search"));
        let within = self.pairs(&fields, "within", Self::coefficient_bounds);
        let nothing = |name| fields.get(name).is_none_or(|list: &Node| list.entries.is_empty());
        if nothing("candidates") && nothing("laws") && nothing("search") {
            let span = fields.get("candidates").map_or(node.span, |list| list.span);
            let help = "list what might be missing: candidates: [\"1\", ...]";
            return self.wrong(
                span,
                "the unknown part has neither candidates, nor laws, nor a search",
                "nothing to find",
                help,
            );
        }
        let (candidates, laws) = (candidates.unwrap_or_default(), laws.unwrap_or_default());
        Some(UnknownSpec {
            factor,
            candidates,
            within,
            laws,
            search: search.unwrap_or_default(),
            span: node.span,
        })
    }

    /// `Positive`, `Negative` or `(0.0, 5.0)`.
    fn coefficient_bounds(&mut self, node: &Node) -> Option<(f64, f64)> {
        let signs = [("Positive", (0.0, f64::INFINITY)), ("Negative", (f64::NEG_INFINITY, 0.0))];
        match node.shape {
            Shape::Name => self.choice(node, "sign", &signs),
            Shape::Group => self.bounds(node).map(|(low, high)| (low.value, high.value)),
            _ => self.expected(
                node,
                "bounds of a coefficient",
                "Positive, Negative or two numbers like (0.0, 5.0)",
            ),
        }
    }

    fn record(&mut self, node: &Node) -> Option<DataSpec> {
        match (self.variant(node), node.name) {
            (Some("Csv"), Some(_)) => self.csv(node, false).map(|r| DataSpec::Csv(Box::new(r))),
            (Some("Table"), Some(_)) => self.csv(node, true).map(|r| DataSpec::Csv(Box::new(r))),
            (Some("Synthetic"), Some(_)) => self.synthetic(node).map(|r| DataSpec::Synthetic(Box::new(r))),
            (Some("Arrays"), Some(_)) => self.arrays(node).map(|r| DataSpec::Csv(Box::new(r))),
            (Some(_), Some(name)) => {
                self.unknown_name("kind of record", name, &["Csv", "Table", "Synthetic"])
            }
            _ => self.expected(node, "a record, `Csv(...)` or `Synthetic(...)`", ""),
        }
    }
}
