//! Classes of MJCF: what an element does not say its class says.

use super::DEEPEST;
use crate::robot::xml::{Element, Read};

/// An element with the defaults of its class: an attribute that it does not say is said there.
pub(in crate::robot) struct Chain<'a>(Vec<Element<'a>>);

impl<'a> Chain<'a> {
    /// An element that has no class.
    pub(super) fn alone(element: Element<'a>) -> Chain<'a> {
        Chain(vec![element])
    }

    pub(in crate::robot) fn own(&self) -> Element<'a> {
        self.0[0]
    }

    /// The element that says an attribute.
    fn says(&self, attribute: &str) -> Element<'a> {
        self.0.iter().find(|e| e.text(attribute).is_some()).copied().unwrap_or(self.0[0])
    }

    pub(in crate::robot) fn text(&self, attribute: &str) -> Option<&'a str> {
        self.says(attribute).text(attribute)
    }

    pub(in crate::robot) fn numbers(&self, attribute: &str) -> Read<Option<Vec<f64>>> {
        self.says(attribute).numbers(attribute)
    }

    pub(in crate::robot) fn exactly<const N: usize>(&self, attribute: &str) -> Read<Option<[f64; N]>> {
        self.says(attribute).exactly(attribute)
    }

    pub(in crate::robot) fn number(&self, attribute: &str) -> Read<Option<f64>> {
        self.says(attribute).number(attribute)
    }

    pub(super) fn size(&self, attribute: &str) -> Read<f64> {
        self.says(attribute).size(attribute)
    }
}

/// The classes of `<default>`: each with the class around it.
pub(super) struct Defaults<'a>(Vec<(&'a str, Option<usize>, Vec<Element<'a>>)>);

/// The class of what has none.
const MAIN: &str = "main";

impl<'a> Defaults<'a> {
    pub(super) fn of(root: Element<'a>) -> Read<Defaults<'a>> {
        let mut all = Defaults(vec![(MAIN, None, vec![])]);
        for own in root.children().filter(|e| e.is("default")) {
            all.read(own, 0, 0)?;
        }
        Ok(all)
    }

    /// What a class says.
    fn read(&mut self, element: Element<'a>, class: usize, depth: usize) -> Read<()> {
        for child in element.children() {
            if !child.is("default") {
                self.0[class].2.push(child);
                continue;
            }
            if depth > DEEPEST {
                return Err(child.wrong("classes are nested too deep", "no model needs that"));
            }
            self.0.push((child.needed("class")?, Some(class), vec![]));
            self.read(child, self.0.len() - 1, depth + 1)?;
        }
        Ok(())
    }

    /// An element with the defaults of its class, or of the one that holds here.
    pub(super) fn chain(&self, element: Element<'a>, around: Option<&str>) -> Read<Chain<'a>> {
        let name = element.text("class").or(around).unwrap_or(MAIN);
        let named = |own: &(&str, Option<usize>, Vec<Element<'a>>)| own.0 == name;
        // What is in no class of its own may name the outermost one as the file does.
        let mut class = self.0.iter().position(named);
        if class.is_none() {
            return Err(element.wrong(
                format!("there is no class `{name}` in `<default>`"),
                "look how it is spelled there",
            ));
        }
        let mut chain = vec![element];
        while let Some(k) = class {
            let (_, parent, elements) = &self.0[k];
            // The last of several holds.
            chain.extend(elements.iter().rev().filter(|e| e.is(element.node.tag_name().name())));
            class = *parent;
        }
        Ok(Chain(chain))
    }
}
