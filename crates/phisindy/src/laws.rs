//! The catalogue of laws.

use phisindy_phys::{BUILT_IN, Diagnostic, LawEntry, SourceId, Sources};
use std::fmt;

/// Laws by their ids, in alphabetical order.
#[derive(Clone, Debug)]
pub struct Catalogue {
    laws: Vec<LawEntry>,
}

impl Catalogue {
    /// The laws that come with the program.
    ///
    /// # Panics
    /// If one of them cannot be read, which a test excludes.
    pub fn built_in() -> Catalogue {
        let empty = Catalogue { laws: vec![] };
        let with = |all: Catalogue, (id, text): &(&str, &str)| all.with(id, text);
        match BUILT_IN.iter().try_fold(empty, with) {
            Ok(all) => all,
            Err(error) => panic!("built-in laws: {error}"),
        }
    }

    /// The catalogue without the laws of these ids.
    pub fn without(mut self, ids: &[String]) -> Catalogue {
        self.laws.retain(|law| !ids.contains(&law.id));
        self
    }

    /// The catalogue with a further law, in place of one with the same id.
    ///
    /// ```
    /// use phisindy::Catalogue;
    /// let text = Catalogue::built_in().laws().iter().find(|law| law.id == "viscous").unwrap().text.clone();
    /// let laws = Catalogue::built_in().with("my-damper", &text)?;
    /// assert!(laws.laws().iter().any(|law| law.id == "my-damper"));
    /// # Ok::<(), phisindy::LawError>(())
    /// ```
    ///
    /// # Errors
    /// The text is no law.
    pub fn with(mut self, id: &str, text: &str) -> Result<Catalogue, LawError> {
        let law = LawEntry::checked(id, text, SourceId(0)).map_err(|mistakes| LawError {
            id: id.to_owned(),
            text: text.to_owned(),
            mistakes,
        })?;
        self.laws.retain(|other| other.id != id);
        self.laws.push(law);
        self.laws.sort_by(|a, b| a.id.cmp(&b.id));
        Ok(self)
    }

    /// The laws with their ids and texts.
    pub fn laws(&self) -> &[LawEntry] {
        &self.laws
    }
}

/// Why a law cannot be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LawError {
    /// Its id.
    pub id: String,
    /// Its text.
    pub text: String,
    /// What is wrong; the places are in the text, whose source is number 0.
    pub mistakes: Vec<Diagnostic>,
}

impl LawError {
    /// The mistakes with their places in a text that is added to `sources` under this name.
    pub fn shown(&self, name: &str, sources: &mut Sources) -> Vec<Diagnostic> {
        let source = sources.add(name, self.text.clone());
        let moved = |d: &Diagnostic| {
            let mut d = d.clone();
            d.labels.iter_mut().for_each(|label| label.source = source);
            d
        };
        self.mistakes.iter().map(moved).collect()
    }
}

impl fmt::Display for LawError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let said: Vec<&str> = self.mistakes.iter().map(|d| d.message.as_str()).collect();
        write!(f, "the law `{}` cannot be read: {}", self.id, said.join("; "))
    }
}

impl std::error::Error for LawError {}
