//! What the files hold that a spec names beside its records. This crate opens none: whoever reads a spec asks
//! [`named_files`] which they are, and hands their numbers over as [`Files`].

use crate::text::raw::{Node, Shape, content, parse};
use phisindy_expr::Span;
use std::sync::Arc;

/// A file that a spec names, and which of its arrays, if it has several.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedFile {
    /// As the spec spells it.
    pub path: String,
    /// An array, variable or sheet of it.
    pub array: Option<String>,
    /// Where the path stands in the spec.
    pub span: Span,
}

/// The numbers of a file, row by row, with the headings of its columns.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Numbers {
    /// Numbers in a row.
    pub columns: usize,
    /// All rows, one after the other.
    pub values: Vec<f64>,
    /// A name and a unit, where the file has headings.
    pub headings: Vec<(String, Option<String>)>,
}

impl Numbers {
    /// How many rows there are.
    pub fn rows(&self) -> usize {
        self.values.len().checked_div(self.columns).unwrap_or(0)
    }

    /// The number in a row and a column.
    ///
    /// # Panics
    /// If there is none.
    pub fn at(&self, row: usize, column: usize) -> f64 {
        self.values[row * self.columns + column]
    }
}

/// The files that a spec names, with their numbers: cheap to clone, so that every text that is made of the spec gets
/// the same.
///
/// ```
/// use phisindy_phys::{Files, Numbers, SourceId, named_files, spec};
/// let text = r#"(states: { "x": "m", "v": "m/s" }, known: { "x": "v", "v": "-table('spring.csv', x)" })"#;
/// assert!(spec::read_without_data(text, SourceId(0)).unwrap_err()[0].message.contains("is not given"));
/// let spring = Numbers { columns: 2, values: vec![-0.1, -30.0, 0.0, 0.0, 0.1, 50.0], headings: vec![] };
/// let files: Files = named_files(text).into_iter().map(|file| (file, spring.clone())).collect();
/// assert!(spec::read_in_memory(text, SourceId(0), &files).is_ok());
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Files(Arc<Vec<(NamedFile, Numbers)>>);

impl Files {
    /// The numbers of a file.
    pub fn numbers(&self, path: &str, array: Option<&str>) -> Option<&Numbers> {
        let own = |file: &NamedFile| file.path == path && file.array.as_deref() == array;
        self.0.iter().find(|(file, _)| own(file)).map(|(_, numbers)| numbers)
    }
}

impl FromIterator<(NamedFile, Numbers)> for Files {
    fn from_iter<I: IntoIterator<Item = (NamedFile, Numbers)>>(all: I) -> Files {
        Files(Arc::new(all.into_iter().collect()))
    }
}

/// The files that a text names beside its records, each once: those of `structure` and of `table(...)`. Nothing of a text
/// that is no spec.
pub fn named_files(text: &str) -> Vec<NamedFile> {
    parse(text).map_or_else(|_| vec![], |root| files_in(text, &root))
}

/// Those of a text that was parsed.
pub(crate) fn files_in(text: &str, root: &Node) -> Vec<NamedFile> {
    let mut all: Vec<NamedFile> = Vec::new();
    let mut add = |file: NamedFile| {
        if all.iter().all(|own| (&own.path, &own.array) != (&file.path, &file.array)) {
            all.push(file);
        }
    };
    let mut waiting = vec![root];
    while let Some(node) = waiting.pop() {
        if let (Shape::Text, Some((span, _))) = (node.shape, content(text, node.span)) {
            let words = &text[span.range()];
            let ast =
                words.contains(TABLE).then(|| phisindy_expr::parse_with(words, &["rate"]).ok()).flatten();
            for (path, at) in ast.iter().flat_map(|ast| ast.files()) {
                add(NamedFile { path: path.to_owned(), array: None, span: at.shifted(span.start) });
            }
        }
        for entry in &node.entries {
            if entry.key.as_ref().is_some_and(|key| &text[key.span.range()] == "structure") {
                of_structure(text, &entry.value).into_iter().for_each(&mut add);
            }
            waiting.extend(entry.key.iter().chain([&entry.value]));
        }
    }
    all.sort_by_key(|file| file.span.start);
    all
}

/// The function whose first argument is a file.
const TABLE: &str = "table";

/// The files of a `structure`: what stands in its fields of matrices, and in the `row` of a point.
fn of_structure(text: &str, node: &Node) -> Vec<NamedFile> {
    let mut all = Vec::new();
    for entry in &node.entries {
        let name = entry.key.as_ref().map_or("", |key| &text[key.span.range()]);
        match name {
            "mass" | "damping" | "stiffness" | "row" => all.extend(file(text, &entry.value)),
            "points" => entry.value.entries.iter().for_each(|e| all.extend(of_structure(text, &e.value))),
            _ => {}
        }
    }
    all
}

/// `"K.mtx"` or `("model.npz", "K")`.
fn file(text: &str, node: &Node) -> Option<NamedFile> {
    let words = |node: &Node| {
        let (span, _) = content(text, node.span).filter(|_| node.shape == Shape::Text)?;
        Some((text[span.range()].to_owned(), span))
    };
    let (path, array) = match node.entries.as_slice() {
        [path, array] if node.shape == Shape::Group => {
            (&path.value, words(&array.value).map(|(array, _)| array))
        }
        _ => (node, None),
    };
    let (path, span) = words(path)?;
    Some(NamedFile { path, array, span })
}
