//! What identification returns.

pub(crate) mod contribution;
pub(crate) mod identified;
pub(crate) mod unknown_part;
