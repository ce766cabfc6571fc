//! The catalogue of laws.

use phisindy_phys::{BUILT_IN, LawEntry};
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
        let law =
            LawEntry::read(id, text).map_err(|e| LawError { id: id.to_owned(), reason: e.to_string() })?;
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
    /// What is wrong.
    pub reason: String,
}

impl fmt::Display for LawError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the law `{}` cannot be read: {}", self.id, self.reason)
    }
}

impl std::error::Error for LawError {}
