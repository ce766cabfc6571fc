//! Values without brackets: numbers, texts, characters.

use super::reader::Reader;
use super::{Number, Spanned, Text};
use crate::text::raw::{Node, Shape, content};
use phisindy_expr::Span;

impl Reader<'_> {
    /// A finite number.
    pub(crate) fn number(&mut self, node: &Node) -> Option<Number> {
        let slice = self.slice(node.span);
        if node.shape != Shape::Number {
            return self.expected(
                node,
                "a number",
                "write it plainly, without quotes and with a decimal point: 10.0",
            );
        }
        match ron::from_str::<f64>(slice) {
            Ok(value) if value.is_finite() => Some(Spanned { value, span: node.span }),
            Ok(_) => {
                let help = "infinite numbers and NaN are refused everywhere";
                self.wrong(node.span, format!("`{slice}` is not a finite number"), "not finite", help)
            }
            Err(error) => self.wrong(
                node.span,
                format!("`{slice}` is not a number: {}", error.code),
                "not a number",
                "",
            ),
        }
    }

    /// A number greater than zero.
    pub(crate) fn positive(&mut self, node: &Node) -> Option<Number> {
        let number = self.number(node)?;
        if number.value > 0.0 {
            return Some(number);
        }
        let message = format!("expected a number greater than zero, found {}", self.slice(node.span));
        self.wrong(node.span, message, "must be greater than zero", "")
    }

    /// A number that is zero or more.
    pub(crate) fn not_negative(&mut self, node: &Node) -> Option<Number> {
        let number = self.number(node)?;
        if number.value >= 0.0 {
            return Some(number);
        }
        let message = format!("expected zero or more, found {}", self.slice(node.span));
        self.wrong(node.span, message, "must not be negative", "")
    }

    /// A whole number that fits 64 bits.
    pub(crate) fn whole(&mut self, node: &Node) -> Option<Spanned<u64>> {
        if node.shape != Shape::Number {
            return self.expected(node, "a whole number", "");
        }
        let slice = self.slice(node.span);
        match ron::from_str(slice) {
            Ok(value) => Some(Spanned { value, span: node.span }),
            Err(_) => {
                let message = format!("expected a whole number, found {slice}");
                let help = "write a number from 0 to 1.8e19, without a decimal point";
                self.wrong(node.span, message, "not such a number", help)
            }
        }
    }

    /// A whole number from 1 to what 32 bits hold.
    pub(crate) fn count(&mut self, node: &Node) -> Option<Spanned<u32>> {
        let whole = self.whole(node)?;
        match u32::try_from(whole.value) {
            Ok(value) if value > 0 => Some(Spanned { value, span: whole.span }),
            _ => {
                let message = format!("expected a whole number greater than zero, found {}", whole.value);
                self.wrong(node.span, message, "out of range", "write a number from 1 to 4.29e9")
            }
        }
    }

    /// `true` or `false`.
    pub(crate) fn truth(&mut self, node: &Node) -> Option<bool> {
        match self.slice(node.span) {
            "true" => Some(true),
            "false" => Some(false),
            _ => self.expected(node, "`true` or `false`", ""),
        }
    }

    /// A text that is read further, so that its bytes must be those of the spec: a name, an expression, a
    /// file.
    pub(crate) fn words(&mut self, node: &Node) -> Option<Text> {
        let text = self.unit(node)?;
        if text.value.trim().is_empty() {
            return self.wrong(
                node.span,
                "the text is empty",
                "something must stand here",
                "write a name or an expression, such as \"0\" for nothing at all, or leave the entry out",
            );
        }
        Some(text)
    }

    /// A text as [`Reader::words`], but it may be empty.
    pub(crate) fn unit(&mut self, node: &Node) -> Option<Text> {
        let (span, raw) = self.literal(node)?;
        let value = self.slice(span);
        if let (false, Some(at)) = (raw, value.find('\\')) {
            let span = Span::new(span.start + at, span.start + at + 1);
            let message = "escapes like `\\n` or `\\\"` are not allowed in this text";
            let help = "write the character itself, or a raw text: r\"...\" or r#\"...\"#";
            return self.wrong(span, message, "this starts an escape", help);
        }
        Some(Spanned { value: value.into(), span })
    }

    /// A text for people to read: it may hold escapes.
    pub(crate) fn prose(&mut self, node: &Node) -> Option<Text> {
        let (span, _) = self.literal(node)?;
        match ron::from_str::<String>(self.slice(node.span)) {
            Ok(value) => Some(Spanned { value, span }),
            Err(error) => self.wrong(node.span, format!("this is not a text: {}", error.code), "", ""),
        }
    }

    fn literal(&mut self, node: &Node) -> Option<(Span, bool)> {
        let literal = if node.shape == Shape::Text { content(self.text, node.span) } else { None };
        if literal.is_some() {
            return literal;
        }
        let help = match node.shape {
            Shape::Name => format!("put it in quotes: \"{}\"", self.slice(node.span)),
            _ => String::new(),
        };
        self.expected(node, "a text in quotes", &help)
    }

    /// One character: `';'` or `";"`.
    pub(crate) fn character(&mut self, node: &Node) -> Option<Spanned<char>> {
        let slice = self.slice(node.span);
        let value = match node.shape {
            Shape::Char => ron::from_str::<char>(slice).ok(),
            Shape::Text => ron::from_str::<String>(slice).ok().and_then(|text| {
                let mut letters = text.chars();
                letters.next().filter(|_| letters.next().is_none())
            }),
            _ => None,
        };
        match value {
            Some(value) => Some(Spanned { value, span: node.span }),
            None => self.expected(node, "one character in quotes", "for example ';' or '\\t'"),
        }
    }
}
