//! The interpolant of a step.

/// A polynomial of the fifth degree at most for each component, in the form of Hairer, Norsett, Wanner,
/// Solving Ordinary Differential Equations I, II.6. It serves both methods, states and sensitivities alike.
#[derive(Clone, Default)]
pub(crate) struct Dense {
    /// Length of the step.
    pub(crate) h: f64,
    /// Six coefficients, each for all components: start, difference to the end, and what bends the line
    /// between.
    c: [Vec<f64>; 6],
}

impl Dense {
    /// Room for the coefficients of `n` components over a step of length `h`.
    pub(crate) fn set(&mut self, h: f64, n: usize) -> &mut [Vec<f64>; 6] {
        self.h = h;
        self.c.iter_mut().for_each(|c| c.resize(n, 0.0));
        &mut self.c
    }

    /// Writes the values at the fraction `theta` of the step to `out`, from a component on.
    #[inline(always)]
    pub(crate) fn values(&self, theta: f64, from: usize, out: &mut [f64]) {
        let [c0, c1, c2, c3, c4, c5] = &self.c;
        let end = from + out.len();
        let (c0, c1, c2) = (&c0[from..end], &c1[from..end], &c2[from..end]);
        let (c3, c4, c5) = (&c3[from..end], &c4[from..end], &c5[from..end]);
        let back = 1.0 - theta;
        for (i, out) in out.iter_mut().enumerate() {
            let bent = c2[i] + theta * (c3[i] + back * (c4[i] + theta * c5[i]));
            *out = c0[i] + theta * (c1[i] + back * bent);
        }
    }

    /// Writes all values at the fraction `theta` to `out`.
    pub(crate) fn value(&self, theta: f64, out: &mut [f64]) {
        self.values(theta, 0, out);
    }

    /// Writes the rates of change at the fraction `theta` to `out`.
    pub(crate) fn slope(&self, theta: f64, out: &mut [f64]) {
        let back = 1.0 - theta;
        let [_, difference, bend, fourth, fifth, sixth] = &self.c;
        for (i, out) in out.iter_mut().enumerate() {
            let last = fifth[i] + theta * sixth[i];
            let third = fourth[i] + back * last;
            let second = bend[i] + theta * third;
            let first = difference[i] + back * second;
            *out = (first + theta * (back * (third - theta * (last - back * sixth[i])) - second)) / self.h;
        }
    }
}
