//! What an integrator asks of a system.

/// The rates to integrate.
pub(crate) trait Flow {
    /// Writes `dx/dt`, followed by the loads of the sticking contacts.
    fn rates(&mut self, t: f64, x: &[f64], out: &mut [f64]);
    /// Writes the derivatives of `dx/dt` by `x`, row by row.
    fn by_state(&mut self, t: f64, x: &[f64], out: &mut [f64]);
}
