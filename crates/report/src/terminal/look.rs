//! What a terminal can show: colours, and lines of a width.

use crate::tied::tied;

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
        let tied = tied(text);
        for word in tied.split_ascii_whitespace() {
            let line = lines.last_mut().filter(|line| line.is_empty() || seen(line) + 1 + seen(word) <= room);
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
        // Who copies a line gets plain spaces.
        let lines = lines.iter().map(|line| format!("{indent}{}", line.replace('\u{a0}', " ")));
        lines.collect::<Vec<_>>().join("\n")
    }
}

/// Number of characters that are seen: colours are not.
fn seen(text: &str) -> usize {
    let mut parts = text.split('\u{1b}');
    let first = parts.next().map_or(0, |part| part.chars().count());
    first + parts.map(|part| part.split_once('m').map_or("", |(_, rest)| rest).chars().count()).sum::<usize>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_fit_with_their_colours_and_no_value_is_torn() {
        let look = Look { colour: true, width: 40 };
        let words =
            format!("{}  A title of twelve letters, 0.298 ± 0.008 N of it", look.ink(Ink::Good, "found"));
        let text = look.wrapped(&words, 2);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "  \u{1b}[1;32mfound\u{1b}[0m A title of twelve letters,");
        assert_eq!(lines[1..], ["  0.298 ± 0.008 N of it"]);
    }
}
