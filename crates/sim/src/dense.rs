//! The interpolant of a step.

/// A polynomial of the fifth degree at most for each component, in the form of Hairer, Norsett, Wanner, Solving
/// Ordinary Differential Equations I, II.6. It serves both methods, states and sensitivities alike.
#[derive(Clone, Default)]
pub(crate) struct Dense {
    /// Length of the step.
    pub(crate) h: f64,
    /// Six coefficients for each component: start, difference to the end, and what bends the line between.
    pub(crate) c: Vec<[f64; 6]>,
}

impl Dense {
    /// The values at the fraction `theta` of the step.
    pub(crate) fn values(&self, theta: f64) -> impl Iterator<Item = f64> {
        let back = 1.0 - theta;
        self.c.iter().map(move |[start, difference, bend, fourth, fifth, sixth]| {
            let bent = bend + theta * (fourth + back * (fifth + theta * sixth));
            start + theta * (difference + back * bent)
        })
    }

    /// Writes the values at the fraction `theta` to `out`.
    pub(crate) fn value(&self, theta: f64, out: &mut [f64]) {
        out.iter_mut().zip(self.values(theta)).for_each(|(out, value)| *out = value);
    }

    /// Writes the rates of change at the fraction `theta` to `out`.
    pub(crate) fn slope(&self, theta: f64, out: &mut [f64]) {
        let back = 1.0 - theta;
        for (out, [_, difference, bend, fourth, fifth, sixth]) in out.iter_mut().zip(&self.c) {
            let last = fifth + theta * sixth;
            let third = fourth + back * last;
            let second = bend + theta * third;
            let first = difference + back * second;
            *out = (first + theta * (back * (third - theta * (last - back * sixth)) - second)) / self.h;
        }
    }
}
