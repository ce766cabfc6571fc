//! One step by either method: its stages, its error, its interpolant.

use crate::dense::Dense;
use crate::dopri;
use crate::flow::Flow;
use crate::radau::{self, Radau};

/// How a step is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Method {
    /// Dormand and Prince: see [`dopri`].
    Explicit,
    /// Radau IIA: see [`radau`].
    Implicit,
}

/// The memory of one step.
pub(crate) struct Step {
    /// Start of the step.
    pub(crate) t: f64,
    /// Length of the step.
    pub(crate) h: f64,
    /// State at the stages; the first is the start, the last in use the end.
    pub(crate) x: [Vec<f64>; dopri::STAGES],
    /// Rates at the stages, followed by the loads of the sticking contacts, which are not integrated but
    /// must be resolved too.
    pub(crate) k: [Vec<f64>; dopri::STAGES],
    method: Method,
    /// Made when it is first needed.
    radau: Option<Box<Radau>>,
    dense: Dense,
    interpolated: bool,
}

impl Step {
    pub(crate) fn new(n: usize, loads: usize) -> Self {
        let columns = |size: usize| std::array::from_fn(|_| vec![0.0; size]);
        let (x, k) = (columns(n), columns(n + loads));
        let dense = Dense::default();
        Step { t: 0.0, h: 0.0, x, k, method: Method::Explicit, radau: None, dense, interpolated: false }
    }

    /// Starts at a point whose rates are known.
    pub(crate) fn start(&mut self, t: f64, x: &[f64], rates: &[f64]) {
        self.t = t;
        self.x[0].copy_from_slice(x);
        self.k[0].copy_from_slice(rates);
        if let Some(radau) = &mut self.radau {
            radau.start();
        }
    }

    pub(crate) fn method(&self) -> Method {
        self.method
    }

    /// The next steps are made by this method.
    pub(crate) fn set_method(&mut self, method: Method) {
        self.method = method;
        if method == Method::Implicit {
            let (n, loads) = (self.x[0].len(), self.k[0].len() - self.x[0].len());
            self.radau.get_or_insert_with(|| Box::new(Radau::new(n, loads))).forget();
        }
    }

    /// Makes a step of length `h` from the start; `allowed` is the permitted error of each state. Returns
    /// whether the stages were found.
    pub(crate) fn advance(&mut self, h: f64, allowed: &[f64], flow: &mut impl Flow) -> bool {
        self.h = h;
        self.interpolated = false;
        match (self.method, &mut self.radau) {
            (Method::Implicit, Some(radau)) => {
                radau.advance((self.t, h), &mut self.x, &mut self.k, allowed, flow)
            }
            _ => {
                dopri::advance((self.t, h), &mut self.x, &mut self.k, flow);
                true
            }
        }
    }

    /// The fractions of the step at which its stages lie, in ascending order, from its start to its end.
    pub(crate) fn nodes(&self) -> &'static [f64] {
        match self.method {
            // The last two stages are both at the end of the step.
            Method::Explicit => &dopri::C[..dopri::STAGES - 1],
            Method::Implicit => &radau::C,
        }
    }

    fn last(&self) -> usize {
        match self.method {
            Method::Explicit => dopri::STAGES - 1,
            Method::Implicit => radau::C.len() - 1,
        }
    }

    /// The state at the end.
    pub(crate) fn end(&self) -> &[f64] {
        &self.x[self.last()]
    }

    /// The rates and loads at the end.
    pub(crate) fn end_rates(&self) -> &[f64] {
        &self.k[self.last()]
    }

    /// The estimated errors of the states, followed by those of the mean loads.
    pub(crate) fn errors(&self, out: &mut [f64]) {
        match (self.method, &self.radau) {
            (Method::Implicit, Some(radau)) => radau.errors(out),
            _ => dopri::errors(self.h, &self.k, self.x[0].len(), out),
        }
    }

    /// The estimated error of a step grows with this power of its length.
    pub(crate) fn order(&self) -> f64 {
        match self.method {
            Method::Explicit => dopri::ORDER,
            Method::Implicit => radau::ORDER,
        }
    }

    /// The interpolant of the step.
    pub(crate) fn dense(&mut self) -> &Dense {
        if let (Method::Implicit, Some(radau)) = (self.method, &self.radau) {
            return radau.dense();
        }
        if !self.interpolated {
            self.interpolated = true;
            let end = &self.x[dopri::STAGES - 1];
            dopri::interpolate(&mut self.dense, self.h, &self.x[0], end, &self.k);
        }
        &self.dense
    }

    /// The step is accepted: an implicit one tells where the next one may lead.
    pub(crate) fn accept(&mut self) {
        if let (Method::Implicit, Some(radau)) = (self.method, &mut self.radau) {
            radau.accept(self.t + self.h);
        }
    }

    /// `h |lambda|`, with the eigenvalue that governs whether an explicit step is stable; `None` where the
    /// step does not tell. `size` is the size of each state.
    pub(crate) fn stiffness(&mut self, size: &[f64]) -> Option<f64> {
        match (self.method, &mut self.radau) {
            (Method::Implicit, Some(radau)) => radau.eigenvalue(size).map(|value| self.h * value),
            _ => dopri::stiffness(self.h, &self.x, &self.k, size),
        }
    }

    /// How often a matrix was decomposed.
    pub(crate) fn factorisations(&self) -> usize {
        self.radau.as_ref().map_or(0, |radau| radau.factorisations)
    }
}
