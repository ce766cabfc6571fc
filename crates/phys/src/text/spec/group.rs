//! Values in brackets: tuples, lists, maps, and fields with their names.

use super::reader::Reader;
use super::{Number, Text};
use crate::text::diagnostic::Diagnostic;
use crate::text::fields::Group;
use crate::text::raw::{Node, Shape};
use phisindy_expr::Span;
use std::collections::HashMap;

/// The fields of a group: their names are allowed and stand once.
pub(crate) struct Fields<'n, 't> {
    group: &'static Group,
    span: Span,
    list: Vec<(&'t str, &'n Node)>,
}

impl<'n> Fields<'n, '_> {
    pub(crate) fn get(&self, name: &str) -> Option<&'n Node> {
        debug_assert!(self.group.field(name).is_some(), "{name} is no field of {}", self.group.owner);
        self.list.iter().find(|(n, _)| *n == name).map(|(_, node)| *node)
    }
}

impl<'t> Reader<'t> {
    /// Two numbers in round brackets, the smaller one first.
    pub(crate) fn bounds(&mut self, node: &Node) -> Option<(Number, Number)> {
        let [low, high] = self.tuple(node, "two numbers like (0.0, 1.0)")?;
        let (low, high) = (self.number(low), self.number(high));
        let (low, high) = (low?, high?);
        if low.value < high.value {
            return Some((low, high));
        }
        let message = format!("{} is not less than {}", self.slice(low.span), self.slice(high.span));
        self.wrong(node.span, message, "must go from low to high", "write the smaller number first")
    }

    /// That many values without keys in round brackets.
    pub(crate) fn tuple<'n, const N: usize>(&mut self, node: &'n Node, what: &str) -> Option<[&'n Node; N]> {
        let plain = node.shape == Shape::Group && node.name.is_none();
        let values: Vec<&Node> = node.entries.iter().filter(|e| e.key.is_none()).map(|e| &e.value).collect();
        match values.try_into() {
            Ok(values) if plain && node.entries.len() == N => Some(values),
            _ => self.expected(node, what, ""),
        }
    }

    /// The values of a list; those that are wrong are noted and left out.
    pub(crate) fn list<T>(
        &mut self,
        node: &Node,
        mut item: impl FnMut(&mut Self, &Node) -> Option<T>,
    ) -> Option<Vec<T>> {
        if node.shape != Shape::List {
            return self.expected(node, "a list `[...]`", "");
        }
        Some(node.entries.iter().filter_map(|entry| item(self, &entry.value)).collect())
    }

    /// A list with something in it.
    pub(crate) fn filled<T>(
        &mut self,
        node: &Node,
        help: &str,
        item: impl FnMut(&mut Self, &Node) -> Option<T>,
    ) -> Option<Vec<T>> {
        if node.shape == Shape::List && node.entries.is_empty() {
            return self.wrong(node.span, "the list is empty", "at least one entry is needed", help);
        }
        self.list(node, item)
    }

    /// The pairs of a map in their order; no key stands twice.
    pub(crate) fn map<T>(
        &mut self,
        node: &Node,
        mut item: impl FnMut(&mut Self, &Node) -> Option<T>,
    ) -> Option<Vec<(Text, T)>> {
        if node.shape != Shape::Map {
            return self.expected(node, "a map `{...}`", "a map looks like { \"x\": ..., \"y\": ... }");
        }
        let mut seen: HashMap<String, Span> = HashMap::new();
        let mut pairs = Vec::new();
        for entry in &node.entries {
            let key = entry.key.as_ref().and_then(|key| self.words(key));
            let value = item(self, &entry.value);
            let Some(key) = key else { continue };
            match seen.get(&key.value) {
                Some(&first) => self.repeated("key", &key.value, key.span, first),
                None => {
                    seen.insert(key.value.clone(), key.span);
                    pairs.extend(value.map(|value| (key, value)));
                }
            }
        }
        Some(pairs)
    }

    fn repeated(&mut self, what: &str, name: &str, again: Span, first: Span) {
        let diagnostic = Diagnostic::error(format!("the {what} `{name}` stands here twice"))
            .at(self.source, again, "again here")
            .also(self.source, first, "first here")
            .help("delete one of the two");
        self.note(diagnostic);
    }

    /// The fields of `(...)` or `Name(...)`; what is wrong with their names is noted.
    pub(crate) fn fields<'n>(&mut self, node: &'n Node, group: &'static Group) -> Option<Fields<'n, 't>> {
        let (owner, allowed) = (group.owner, group.names());
        if node.shape != Shape::Group {
            let help = format!("write the fields in round brackets: ({}: ...)", allowed[0]);
            return self.expected(node, "fields in round brackets", &help);
        }
        let mut list: Vec<(&'t str, &'n Node)> = Vec::new();
        let mut places: HashMap<&'t str, Span> = HashMap::new();
        for entry in &node.entries {
            let Some(key) = &entry.key else {
                self.expected::<()>(
                    &entry.value,
                    "a field with its name",
                    &format!("fields of {owner}: {}", allowed.join(", ")),
                );
                continue;
            };
            let name = self.slice(key.span);
            if !allowed.contains(&name) {
                self.unknown_name::<()>(&format!("field of {owner}"), key.span, &allowed);
            } else if let Some(&first) = places.get(name) {
                self.repeated("field", name, key.span, first);
            } else {
                places.insert(name, key.span);
                // `None` says the same as nothing; `Some(x)` the same as x.
                match self.variant(&entry.value) {
                    Some("None") => {}
                    Some("Some") => {
                        list.extend(self.argument(&entry.value, "one value").map(|value| (name, value)))
                    }
                    _ => list.push((name, &entry.value)),
                }
            }
        }
        Some(Fields { group, span: node.name.unwrap_or(Span::new(node.span.start, node.inside)), list })
    }

    /// A field that must be there.
    pub(crate) fn required<T>(
        &mut self,
        fields: &Fields<'_, '_>,
        name: &str,
        read: impl FnOnce(&mut Self, &Node) -> Option<T>,
    ) -> Option<T> {
        match fields.get(name) {
            Some(node) => read(self, node),
            None => {
                let message = format!("the field `{name}` of {} is missing", fields.group.owner);
                self.wrong(fields.span, message, &format!("has no `{name}`"), &format!("add `{name}: ...`"))
            }
        }
    }

    /// A field that need not be there.
    pub(crate) fn optional<T>(
        &mut self,
        fields: &Fields<'_, '_>,
        name: &str,
        read: impl FnOnce(&mut Self, &Node) -> Option<T>,
    ) -> Option<T> {
        fields.get(name).and_then(|node| read(self, node))
    }

    /// A map that may be left out.
    pub(crate) fn pairs<T>(
        &mut self,
        fields: &Fields<'_, '_>,
        name: &str,
        item: impl FnMut(&mut Self, &Node) -> Option<T>,
    ) -> Vec<(Text, T)> {
        self.optional(fields, name, |r, node| r.map(node, item)).unwrap_or_default()
    }
}
