//! The forms of a result, and the names of methods and roles in results.

use phisindy_phys::spec::Role;

/// The form in which a result is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Equations in LaTeX, all else as comments.
    Latex,
    /// Plain text.
    Text,
    /// One JSON object on one line.
    Json,
}

impl Format {
    /// Lines of text in this form: LaTeX has them as comments.
    pub(crate) fn lines(self, lines: Vec<String>) -> String {
        let mark = if self == Format::Latex { "% " } else { "" };
        lines.into_iter().map(|line| format!("{mark}{line}").trim_end().to_owned() + "\n").collect()
    }
}

/// The name of a role in results.
pub(crate) fn role_name(role: Role) -> &'static str {
    match role {
        Role::Fit => "fit",
        Role::Validate => "validate",
    }
}

/// The words with the first letter in upper case, as they begin a sentence. Names of laws are written as they
/// stand in the middle of one.
pub(crate) fn capital(words: &str) -> String {
    let mut letters = words.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}
