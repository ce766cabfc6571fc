//! How far a model predicts.

/// The error of predictions of one column, so long after the state was known.
#[derive(Clone, Debug, PartialEq)]
pub struct Horizon {
    /// Name of the record.
    pub record: String,
    /// Name of the column.
    pub column: String,
    /// Predicted at most so far ahead (s), and farther than the horizon before.
    pub seconds: f64,
    /// Root mean square of what is missed over the standard deviation of the column.
    pub nrmse: f64,
    /// The same of a linear model, as it stands beside every result; `None` where it has no data.
    pub baseline: Option<f64>,
}
