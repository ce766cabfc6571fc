//! Whether a law is the same in both directions of the motion.

use super::Law;
use phisindy_expr::{Id, Parity};

impl Law {
    /// What becomes of the force of a law when the motion turns its sign: displacement, velocity, and the
    /// states of the law together. `None` where the structure of its expressions does not tell, for an
    /// asymmetric law, for a law that the motion does not enter, and for what acts on sensors or inputs.
    ///
    /// ```
    /// use phisindy_expr::Parity;
    /// use phisindy_phys::Law;
    /// let law = |force: &str| {
    ///     let text = format!(r#"(name: "A", roles: {{ "v": "m/s" }}, parameters: {{ "c": (unit: "", within: (0.0, 1.0)) }}, force: "{force}")"#);
    ///     Law::read(&text).unwrap()
    /// };
    /// assert_eq!(law("c*sgn(v)").parity(), Some(Parity::Odd));
    /// assert_eq!(law("c*v^2").parity(), Some(Parity::Even));
    /// assert_eq!(law("c*pos(v)").parity(), None);
    /// ```
    pub fn parity(&self) -> Option<Parity> {
        let of = self.nodes();
        let force = of.force?;
        let motion: Vec<Id> =
            of.displacement.into_iter().chain(of.velocity).chain(of.internal.clone()).collect();
        if !of.graph.uses(&[force], &motion) {
            return None;
        }
        // With memory there is one symmetry: the states of the law turn with the motion.
        let rates_turn = of.rates.iter().all(|&rate| of.graph.parity(rate, &motion) == Some(Parity::Odd));
        of.graph.parity(force, &motion).filter(|p| of.rates.is_empty() || (rates_turn && *p == Parity::Odd))
    }
}
