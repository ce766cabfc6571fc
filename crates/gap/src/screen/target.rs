//! What a screening explains.

use phisindy_learn::Calibration;

/// What the regression explains.
#[derive(Clone, Copy)]
pub(crate) enum Target<'a> {
    /// What the known rates miss along the measured motion: exact however far the model is from the data, up
    /// to the errors of the smoothed motion and of the inputs between their samples.
    AlongData,
    /// The residuals of a fit that leaves only noise. Free of those errors; the mean linear response ranks
    /// laws less well.
    OfFit(&'a Calibration),
}
