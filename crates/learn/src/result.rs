//! What identification returns, as data. Sentences are in [`words`].

pub(crate) mod contribution;
pub(crate) mod error;
pub(crate) mod estimate;
pub(crate) mod held;
pub(crate) mod horizon;
pub(crate) mod identified;
pub(crate) mod late_column;
pub(crate) mod parameter;
pub(crate) mod passivity;
pub(crate) mod passivity_violation;
pub(crate) mod quantity;
pub(crate) mod record_fit;
pub(crate) mod remainder;
pub(crate) mod requirements;
pub(crate) mod term;
pub(crate) mod unknown_part;
pub(crate) mod verdict;
pub(crate) mod warning;
pub(crate) mod words;
