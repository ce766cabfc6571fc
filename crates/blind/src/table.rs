//! A table of the documents.

/// A table, and the list of failures below it.
pub(crate) struct Table {
    /// The name of its marks in documents.
    pub(crate) name: &'static str,
    pub(crate) table: String,
    pub(crate) failures: String,
}

impl Table {
    pub(crate) fn new(name: &'static str, table: String) -> Table {
        Table { name, table, failures: String::new() }
    }
}
