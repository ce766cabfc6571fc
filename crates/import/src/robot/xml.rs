//! Elements of an XML file with their places, and numbers in their attributes.

use phisindy_expr::Span;
use phisindy_phys::{Diagnostic, SourceId};
use roxmltree::Node;
use std::f64::consts::FRAC_PI_2;

/// What a reader returns: a value, or the first mistake with its place.
pub(super) type Read<T> = Result<T, Box<Diagnostic>>;

/// An element of a file.
#[derive(Clone, Copy)]
pub(super) struct Element<'a> {
    pub(super) node: Node<'a, 'a>,
    source: SourceId,
}

impl<'a> Element<'a> {
    pub(super) fn new(node: Node<'a, 'a>, source: SourceId) -> Element<'a> {
        Element { node, source }
    }

    pub(super) fn is(&self, name: &str) -> bool {
        self.node.has_tag_name(name)
    }

    pub(super) fn children(self) -> impl Iterator<Item = Element<'a>> {
        self.node.children().filter(Node::is_element).map(move |node| Element { node, ..self })
    }

    /// The element itself and all that it holds.
    pub(super) fn descendants(self) -> impl Iterator<Item = Element<'a>> {
        self.node.descendants().filter(Node::is_element).map(move |node| Element { node, ..self })
    }

    /// The first child of this name.
    pub(super) fn child(self, name: &'static str) -> Option<Element<'a>> {
        self.children().find(|child| child.is(name))
    }

    pub(super) fn text(&self, attribute: &str) -> Option<&'a str> {
        self.node.attribute(attribute)
    }

    /// The tag that opens the element.
    fn span(&self) -> Span {
        let range = self.node.range();
        let text = &self.node.document().input_text()[range.clone()];
        Span::new(range.start, range.start + text.find('>').map_or(text.len(), |end| end + 1))
    }

    /// A mistake at the element.
    pub(super) fn wrong(&self, message: impl Into<String>, help: impl Into<String>) -> Box<Diagnostic> {
        Box::new(Diagnostic::error(message).at(self.source, self.span(), "").help(help))
    }

    /// A mistake at an attribute.
    fn wrong_value(&self, attribute: &str, message: String, help: &str) -> Box<Diagnostic> {
        let range = self.node.attribute_node(attribute).map(|a| a.range_value());
        let span = range.map_or(self.span(), |range| Span::new(range.start, range.end));
        Box::new(Diagnostic::error(message).at(self.source, span, "").help(help))
    }

    /// What an attribute must say.
    pub(super) fn needed(&self, attribute: &str) -> Read<&'a str> {
        self.text(attribute).ok_or_else(|| {
            let tag = self.node.tag_name().name();
            self.wrong(format!("`<{tag}>` has no `{attribute}`"), format!("add `{attribute}=\"...\"`"))
        })
    }

    /// The numbers of an attribute, if it is there.
    pub(super) fn numbers(&self, attribute: &str) -> Read<Option<Vec<f64>>> {
        let Some(text) = self.text(attribute) else { return Ok(None) };
        let number = |word: &str| word.parse::<f64>().ok().filter(|x| x.is_finite());
        let all: Option<Vec<f64>> = text.split_ascii_whitespace().map(number).collect();
        all.map(Some).ok_or_else(|| {
            let message = format!("`{attribute}` holds no numbers: \"{}\"", shortened(text));
            self.wrong_value(
                attribute,
                message,
                "write finite numbers with blanks between, as in \"0 0 0.5\"",
            )
        })
    }

    /// So many numbers of an attribute, if it is there.
    pub(super) fn exactly<const N: usize>(&self, attribute: &str) -> Read<Option<[f64; N]>> {
        let Some(numbers) = self.numbers(attribute)? else { return Ok(None) };
        let count = numbers.len();
        numbers.try_into().map(Some).map_err(|_| {
            let plural = if N == 1 { "" } else { "s" };
            let message = format!("`{attribute}` has {N} number{plural}, and here are {count}");
            self.wrong_value(attribute, message, "write as many as the format asks for")
        })
    }

    /// One number of an attribute, if it is there.
    pub(super) fn number(&self, attribute: &str) -> Read<Option<f64>> {
        Ok(self.exactly::<1>(attribute)?.map(|[x]| x))
    }

    /// One number of an attribute that is not negative; zero where it is not there.
    pub(super) fn size(&self, attribute: &str) -> Read<f64> {
        let x = self.number(attribute)?.unwrap_or(0.0);
        if x >= 0.0 {
            return Ok(x);
        }
        Err(self.wrong_value(
            attribute,
            format!("`{attribute}` is not negative, and {x} is"),
            "look at its sign",
        ))
    }
}

/// Fewest decimals that say of an angle that it is a right one.
const DECIMALS: usize = 4;

/// An angle that is written as right ones to its last digit is so: `1.5708` is pi/2.
pub(super) fn right_angle(angle: f64) -> f64 {
    let text = angle.to_string();
    let decimals = text.split_once('.').map_or(0, |(_, decimals)| decimals.len());
    let right = (angle / FRAC_PI_2).round() * FRAC_PI_2;
    let last_digit = 0.1_f64.powi(decimals.min(300) as i32);
    if decimals >= DECIMALS && (angle - right).abs() <= 0.5 * last_digit + f64::EPSILON {
        right
    } else {
        angle
    }
}

/// The begin of a text, for a message.
pub(super) fn shortened(text: &str) -> String {
    const SHOWN: usize = 40;
    let mut begin: String = text.chars().take(SHOWN).collect();
    if begin.len() < text.len() {
        begin.push_str("...");
    }
    begin
}
