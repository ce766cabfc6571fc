//! Why a value cannot be set.

use phisindy_expr::nearest;
use std::fmt;

/// Why a value cannot be set.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SetError {
    /// The part of the path (or the value) that does not fit.
    pub part: String,
    /// What is wrong, in one sentence.
    pub message: String,
    /// What stands there instead and could be meant.
    pub available: Vec<String>,
}

impl SetError {
    pub(super) fn new(part: &str, message: impl Into<String>) -> Self {
        SetError { part: part.into(), message: message.into(), available: Vec::new() }
    }
}

impl fmt::Display for SetError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)?;
        if let Some(near) = nearest(&self.part, self.available.iter().map(String::as_str)) {
            write!(f, "; did you mean `{near}`?")?;
        }
        if !self.available.is_empty() {
            write!(f, "; there is: {}", self.available.join(", "))?;
        }
        Ok(())
    }
}

impl std::error::Error for SetError {}
