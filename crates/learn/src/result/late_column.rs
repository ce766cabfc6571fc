//! A column that looks late.

/// A column whose sensor looks late, by the residuals of a fit that has no delay for it: with a delay as one more
/// unknown the records are more probable, by odds that convince ([`LateColumn::needed`]). Whether it is a delay or a
/// lag, and how much, only another fit tells.
#[derive(Clone, Debug, PartialEq)]
pub struct LateColumn {
    /// Its place among the states, then the outputs.
    pub column: usize,
    /// Its name.
    pub name: String,
    /// By about how much, in seconds; negative where all others are late.
    pub delay: f64,
    /// How many times as large a fit may find it.
    pub reach: f64,
    /// The square of a delay in its standard errors from which a fit convinces: the price of one number of those
    /// that were looked at (as of a term), and the odds of 19 to 1 against chance.
    pub needed: f64,
}
