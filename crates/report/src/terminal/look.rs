//! What a terminal can show: colours, and lines of a width.

/// What a terminal can show.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    /// Whether it takes ANSI colours.
    pub colour: bool,
    /// Characters in a line.
    pub width: usize,
}

/// A way to set off words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ink {
    Good,
    Bad,
    Open,
    Strong,
    Faint,
    Model,
    Before,
}

impl Look {
    /// The words in colour, if the terminal has colours.
    pub(crate) fn ink(self, ink: Ink, words: &str) -> String {
        if !self.colour || words.is_empty() {
            return words.to_owned();
        }
        // Select Graphic Rendition, ECMA-48 section 8.3.117.
        let code = match ink {
            Ink::Good => "1;32",
            Ink::Bad => "1;31",
            Ink::Open => "1;33",
            Ink::Strong => "1",
            Ink::Faint => "2",
            Ink::Model => "36",
            Ink::Before => "33",
        };
        format!("\u{1b}[{code}m{words}\u{1b}[0m")
    }

    /// The text in lines that fit, each behind `indent` spaces.
    pub(crate) fn wrapped(self, text: &str, indent: usize) -> String {
        let room = self.width.clamp(40, 110).saturating_sub(indent);
        let mut lines = vec![String::new()];
        for word in text.split_whitespace() {
            let line = lines
                .last_mut()
                .filter(|line| line.is_empty() || line.chars().count() + 1 + word.chars().count() <= room);
            match line {
                Some(line) => {
                    if !line.is_empty() {
                        line.push(' ');
                    }
                    line.push_str(word);
                }
                None => lines.push(word.to_owned()),
            }
        }
        let indent = " ".repeat(indent);
        lines.iter().map(|line| format!("{indent}{line}")).collect::<Vec<_>>().join("\n")
    }
}
