//! The catalogue of laws.

mod built_in;

pub use built_in::LAWS;

use phisindy_gap::Entry;
use phisindy_phys::Law;
use std::fmt;
use std::sync::Arc;

/// Laws by their ids, in alphabetical order.
#[derive(Clone, Debug)]
pub struct Catalogue {
    pub(crate) entries: Vec<Entry>,
}

impl Catalogue {
    /// The laws that come with the program.
    ///
    /// # Panics
    /// If one of them cannot be read, which a test excludes.
    pub fn built_in() -> Catalogue {
        let read = |(id, text): &(&str, &str)| match Law::read(text) {
            Ok(law) => Entry { id: (*id).to_owned(), law: Arc::new(law) },
            Err(error) => panic!("the built-in law `{id}`: {error}"),
        };
        Catalogue { entries: LAWS.iter().map(read).collect() }
    }

    /// The catalogue with a further law, in place of one with the same id.
    ///
    /// ```
    /// use phisindy::Catalogue;
    /// let text = include_str!("../../../specs/laws/viscous.ron");
    /// let laws = Catalogue::built_in().with("my-damper", text)?;
    /// assert!(laws.ids().any(|id| id == "my-damper"));
    /// # Ok::<(), phisindy::LawError>(())
    /// ```
    ///
    /// # Errors
    /// The text is no law.
    pub fn with(mut self, id: &str, text: &str) -> Result<Catalogue, LawError> {
        let law = Law::read(text).map_err(|e| LawError { id: id.to_owned(), reason: e.to_string() })?;
        self.entries.retain(|entry| entry.id != id);
        self.entries.push(Entry { id: id.to_owned(), law: Arc::new(law) });
        self.entries.sort_by(|a, b| a.id.cmp(&b.id));
        Ok(self)
    }

    /// The ids of the laws.
    pub fn ids(&self) -> impl Iterator<Item = &str> {
        self.entries.iter().map(|entry| entry.id.as_str())
    }

    /// What a law says.
    pub fn get(&self, id: &str) -> Option<&Law> {
        self.entries.iter().find(|entry| entry.id == id).map(|entry| &*entry.law)
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
