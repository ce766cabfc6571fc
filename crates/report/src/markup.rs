//! Elements of HTML and SVG. Their text is well formed: every tag is closed, every text escaped.

use std::fmt::{self, Display, Write};

/// An element with its attributes and its content.
#[derive(Clone, Debug)]
pub(crate) struct Element {
    name: &'static str,
    attributes: Vec<(&'static str, String)>,
    content: Vec<Content>,
}

#[derive(Clone, Debug)]
enum Content {
    Element(Element),
    Text(String),
    /// Well-formed markup from another writer.
    Raw(String),
}

/// Elements that close in their own tag if they are empty; HTML requires an end tag of all others.
const VOID: &[&str] = &["meta", "br", "path", "line", "rect", "circle"];

/// An empty element.
pub(crate) fn element(name: &'static str) -> Element {
    Element { name, attributes: vec![], content: vec![] }
}

impl Element {
    /// Adds an attribute.
    pub(crate) fn with(mut self, name: &'static str, value: impl Display) -> Element {
        self.attributes.push((name, value.to_string()));
        self
    }

    /// Sets the class.
    pub(crate) fn class(self, class: impl Display) -> Element {
        self.with("class", class)
    }

    /// Appends text.
    pub(crate) fn text(mut self, text: impl Display) -> Element {
        self.content.push(Content::Text(text.to_string()));
        self
    }

    /// Appends an element.
    pub(crate) fn add(mut self, child: Element) -> Element {
        self.content.push(Content::Element(child));
        self
    }

    /// Appends elements.
    pub(crate) fn all(self, children: impl IntoIterator<Item = Element>) -> Element {
        children.into_iter().fold(self, Element::add)
    }

    /// Appends markup that is already well formed.
    pub(crate) fn raw(mut self, markup: impl Into<String>) -> Element {
        self.content.push(Content::Raw(markup.into()));
        self
    }
}

impl Display for Element {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "<{}", self.name)?;
        for (name, value) in &self.attributes {
            write!(f, " {name}=\"{}\"", Escaped(value))?;
        }
        if self.content.is_empty() && VOID.contains(&self.name) {
            return f.write_str("/>");
        }
        f.write_char('>')?;
        for content in &self.content {
            match content {
                Content::Element(element) => write!(f, "{element}")?,
                Content::Text(text) => write!(f, "{}", Escaped(text))?,
                Content::Raw(markup) => f.write_str(markup)?,
            }
        }
        write!(f, "</{}>", self.name)
    }
}

/// The text with all special characters escaped.
pub(crate) fn escaped(text: &str) -> String {
    Escaped(text).to_string()
}

/// Displays a text with all special characters escaped.
struct Escaped<'a>(&'a str);

impl Display for Escaped<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for c in self.0.chars() {
            match c {
                '&' => f.write_str("&amp;")?,
                '<' => f.write_str("&lt;")?,
                '>' => f.write_str("&gt;")?,
                '"' => f.write_str("&quot;")?,
                // Control characters are not allowed in markup, escaped or not.
                c if c.is_control() && !matches!(c, '\n' | '\t') => f.write_char('\u{fffd}')?,
                c => f.write_char(c)?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_cannot_break_out() {
        let made = element("p").with("title", "a \"b\" <c>").text("1 < 2 & 3 > 2\u{0}").add(element("br"));
        assert_eq!(
            made.to_string(),
            "<p title=\"a &quot;b&quot; &lt;c&gt;\">1 &lt; 2 &amp; 3 &gt; 2\u{fffd}<br/></p>"
        );
    }
}
