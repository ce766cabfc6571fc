//! A text in an editor: what it is, what may stand at each of its places, and what its names are.

use phisindy_expr::Span;
use phisindy_phys::fields::{Form, Group, Kind, LAW, SPEC};
use phisindy_phys::outline::{Node, Shape, read};
use std::path::Path;

static A_SPEC: Form = Form::Group(&SPEC);
static A_LAW: Form = Form::Group(&LAW);

/// A text that may be half typed.
///
/// ```
/// use phisindy_editor::Document;
/// let text = "(states: { \"x\": \"m\" }, constants: { \"k\": (4.0, \"N/m\") }, kno";
/// let document = Document::new(text, std::path::Path::new("rig.ron"));
/// let names: Vec<_> = document.declared().iter().map(|d| (d.name, d.unit)).collect();
/// assert_eq!(names, [("x", Some("m")), ("k", Some("N/m"))]);
/// assert_eq!(document.place(text.len()).wants.groups[0].owner, "the spec");
/// ```
#[derive(Debug)]
pub struct Document<'t> {
    /// The text.
    pub text: &'t str,
    /// Its outline.
    pub root: Node,
    form: &'static Form,
}

/// What may stand at a place: a field of one of the groups, or one of the forms.
#[derive(Clone, Debug, Default)]
pub struct Wants {
    /// Whose fields.
    pub groups: Vec<&'static Group>,
    /// Values, or keys of a map.
    pub forms: Vec<&'static Form>,
}

/// A place of a text.
#[derive(Clone, Debug)]
pub struct Place<'d> {
    /// What may stand there.
    pub wants: Wants,
    /// The bracket around it.
    pub around: &'d Node,
    /// What stands there, without quotes; nothing between two values.
    pub word: Span,
    /// Whether it stands in quotes.
    pub quoted: bool,
}

/// A name that a text declares.
#[derive(Clone, Copy, Debug)]
pub struct Declared<'t> {
    /// The name.
    pub name: &'t str,
    /// What it stands for.
    pub kind: Kind,
    /// The unit that is written beside it.
    pub unit: Option<&'t str>,
}

impl<'t> Document<'t> {
    /// Reads a text. A law is told by its fields, or else by its folder.
    pub fn new(text: &'t str, path: &Path) -> Document<'t> {
        let root = read(text);
        let keys: Vec<&str> =
            root.entries.iter().filter_map(|e| Some(&text[e.key.as_ref()?.span.range()])).collect();
        let known = |group: &Group| keys.iter().filter(|key| group.field(key).is_some()).count();
        let folder = path.parent().and_then(Path::file_name).is_some_and(|name| name == "laws");
        let law = known(&LAW) > known(&SPEC) || known(&LAW) == known(&SPEC) && folder;
        Document { text, root, form: if law { &A_LAW } else { &A_SPEC } }
    }

    /// Whether it is a law and no spec.
    pub fn is_law(&self) -> bool {
        std::ptr::eq(self.form, &raw const A_LAW)
    }

    /// What stands in a text with quotes, or in another value.
    pub fn content(&self, node: &Node) -> Span {
        let (slice, Span { start, end }) = (&self.text[node.span.range()], node.span);
        match (slice.find('"'), slice.rfind('"')) {
            (Some(open), Some(close)) if node.shape == Shape::Text => {
                let close = if close > open { start + close } else { end };
                Span::new(start + open + 1, close)
            }
            _ => node.span,
        }
    }

    /// What an entry of a bracket may be: its key, where there is one, and its value.
    fn entry(&self, node: &Node, forms: &[&'static Form], k: usize, key: Option<&Node>) -> (Wants, Wants) {
        let (mut of_key, mut value) = (Wants::default(), Wants::default());
        let name = key.map(|key| &self.text[self.content(key).range()]);
        let field =
            |group: &Group| name.and_then(|name| group.field(name)).map_or(&[][..], |f| f.form().each());
        for form in forms.iter().filter(|form| self.fits(node, form)) {
            let to = if name.is_some() { &mut of_key } else { &mut value };
            match form {
                Form::Group(group) => {
                    to.groups.push(group);
                    value.forms.extend(field(group));
                }
                Form::Map(keys, values) => {
                    to.forms.extend(keys.each());
                    value.forms.extend(name.iter().flat_map(|_| values.each()));
                }
                Form::Mixed(group, keys, values) => {
                    to.groups.push(group);
                    to.forms.extend(keys.each());
                    let bare = key.is_some_and(|key| key.shape == Shape::Name);
                    value
                        .forms
                        .extend(name.iter().flat_map(|_| if bare { field(group) } else { values.each() }));
                }
                Form::List(item) => value.forms.extend(item.each()),
                Form::Tuple(parts) | Form::Call(_, parts) => {
                    value.forms.extend(parts.get(k).iter().flat_map(|form| form.each()));
                }
                _ => {}
            }
        }
        (of_key, value)
    }

    /// Whether a bracket may be of this form.
    fn fits(&self, node: &Node, form: &Form) -> bool {
        let name = node.name.map(|span| &self.text[span.range()]);
        let keys = node.entries.iter().any(|entry| entry.key.is_some());
        // A field that is being typed has no colon yet.
        let words = node.entries.iter().all(|entry| entry.key.is_some() || entry.value.shape == Shape::Name);
        match form {
            Form::Group(group) => node.shape == Shape::Group && group.variant == name && words,
            Form::Call(variant, _) => node.shape == Shape::Group && name == Some(variant),
            Form::Tuple(_) => node.shape == Shape::Group && name.is_none() && !keys,
            Form::List(_) => node.shape == Shape::List,
            Form::Map(..) | Form::Mixed(..) => node.shape == Shape::Map,
            _ => false,
        }
    }

    /// Whether a byte is in a comment, as far as the text in front of it tells.
    pub fn in_comment(&self, at: usize) -> bool {
        let before = &self.text[..at];
        let line = &before[before.rfind('\n').map_or(0, |end| end + 1)..];
        let mut slashes = line.match_indices("//");
        let block =
            before.rfind("/*").is_some_and(|open| before.rfind("*/").is_none_or(|close| close < open));
        block || slashes.any(|(start, _)| line[..start].matches('"').count().is_multiple_of(2))
    }

    /// What stands at a byte, or may stand there.
    pub fn place(&self, at: usize) -> Place<'_> {
        let (mut node, mut forms) = (&self.root, vec![self.form]);
        loop {
            let here = |span: Span| span.start <= at && at <= span.end;
            let blank =
                Place { wants: Wants::default(), around: node, word: Span::new(at, at), quoted: false };
            let leaf = |node: &Node, wants| {
                let word = self.content(node);
                let quoted = node.shape == Shape::Text && here(word);
                Place { wants, word: if here(word) { word } else { node.span }, quoted, ..blank.clone() }
            };
            let after = |from: usize| {
                node.entries
                    .get(from)
                    .map_or(node.span.end, |e| e.key.as_ref().unwrap_or(&e.value).span.start)
            };
            let mut next = None;
            for (k, entry) in node.entries.iter().enumerate() {
                let (of_key, wants) = self.entry(node, &forms, k, entry.key.as_ref());
                match &entry.key {
                    Some(key) if here(key.span) => return leaf(key, of_key),
                    _ => {}
                }
                let value = &entry.value;
                if value.span.range().is_empty()
                    && value.span.start <= at
                    && at < after(k + 1).max(value.span.end + 1)
                {
                    return Place { wants, ..blank };
                }
                if here(value.span) {
                    next = Some((value, wants));
                    break;
                }
            }
            match next {
                Some((value, wants)) if self.is_inside(value, at) => (node, forms) = (value, wants.forms),
                Some((value, wants)) => {
                    let name =
                        value.name.map(|span| Place { wants: wants.clone(), word: span, ..blank.clone() });
                    return name.unwrap_or_else(|| leaf(value, wants));
                }
                None => {
                    let before = node.entries.iter().filter(|e| e.value.span.end < at).count();
                    let wants = if self.is_inside(node, at) {
                        self.entry(node, &forms, before, None).1
                    } else {
                        Wants::default()
                    };
                    return Place { wants, ..blank };
                }
            }
        }
    }

    /// Whether a place is between the brackets of a value.
    fn is_inside(&self, node: &Node, at: usize) -> bool {
        let bracket = matches!(node.shape, Shape::List | Shape::Map | Shape::Group);
        let closed = self.text[..node.span.end].ends_with([')', ']', '}']);
        bracket && node.inside <= at && (at < node.span.end || !closed && at == node.span.end)
    }

    /// The names that it declares.
    pub fn declared(&self) -> Vec<Declared<'_>> {
        let mut all = Vec::new();
        self.declare(&self.root, &[self.form], &mut all);
        all
    }

    /// Adds the names that are declared in a bracket, and below.
    fn declare<'d>(&'d self, node: &'d Node, forms: &[&'static Form], all: &mut Vec<Declared<'d>>) {
        let kind = |wants: &Wants| {
            wants
                .forms
                .iter()
                .find_map(|form| if let Form::Declares(kind) = form { Some(*kind) } else { None })
        };
        let name = |node: &Node| &self.text[self.content(node).range()];
        for (k, entry) in node.entries.iter().enumerate() {
            let (of_key, wants) = self.entry(node, forms, k, entry.key.as_ref());
            let (key, value) = (entry.key.as_ref().zip(kind(&of_key)), &entry.value);
            all.extend(key.map(|(key, kind)| Declared {
                name: name(key),
                kind,
                unit: self.unit(value, &wants.forms),
            }));
            // The speed beside a coordinate.
            all.extend(kind(&wants).map(|kind| Declared { name: name(value), kind, unit: None }));
            self.declare(value, &wants.forms, all);
        }
    }

    /// The unit in a value.
    fn unit(&self, node: &Node, forms: &[&'static Form]) -> Option<&str> {
        if node.shape == Shape::Text {
            let is = forms.iter().any(|form| matches!(form, Form::Unit));
            return is.then(|| &self.text[self.content(node).range()]);
        }
        let mut units = node.entries.iter().enumerate();
        units.find_map(|(k, e)| self.unit(&e.value, &self.entry(node, forms, k, e.key.as_ref()).1.forms))
    }
}
