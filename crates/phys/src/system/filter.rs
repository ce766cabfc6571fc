//! Filters between an output and its column.

use phisindy_expr::Id;

/// What a filter takes off a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FilterKind {
    /// What is slower than the cutoff, and what is constant.
    Highpass,
    /// What is faster than the cutoff.
    Lowpass,
}

impl FilterKind {
    /// As the spec writes it.
    pub fn name(self) -> &'static str {
        match self {
            FilterKind::Highpass => "highpass",
            FilterKind::Lowpass => "lowpass",
        }
    }
}

/// A filter of an output.
#[derive(Clone, Debug)]
pub struct Filter {
    /// Index into [`crate::System::outputs`].
    pub output: usize,
    /// What it takes off.
    pub kind: FilterKind,
    /// Number of its poles and of its states.
    pub order: usize,
    /// The node of the frequency in Hz at which it halves the power.
    pub cutoff: Id,
    /// Index into [`crate::System::parameters`] of a cutoff that each record finds for itself.
    pub own_parameter: Option<usize>,
    /// Index of the first of its states.
    pub first: usize,
    /// Its states when what it reads has not changed for long; they may hold [`crate::System::rate_symbols`].
    pub settled: Vec<Id>,
}

/// Why an output cannot be filtered: its reading is not linear in the rates of states, with factors that do
/// not move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotLinear;
