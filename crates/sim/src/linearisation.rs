//! The rates to first order at a point: `df/dx` and `df/dp` in the present modes, without their zeros.

use crate::elimination::solve_in_place;
use crate::jacobian::Jacobian;

/// Points that are evaluated together: more than an explicit step has stages.
pub(crate) const LANES: usize = 8;

/// Where the parameters stand that a run is differentiated by.
#[derive(Clone, Default)]
pub(crate) struct Free {
    /// For each parameter, its place among the free ones.
    places: Vec<Option<usize>>,
    pub(crate) count: usize,
    /// How many states, the last ones, have no column of their own.
    held: usize,
}

impl Free {
    /// Of a model with so many parameters, and so many states whose start is no number of its own.
    pub(crate) fn new(parameters: usize, free: &[usize], held: usize) -> Free {
        let mut places = vec![None; parameters];
        free.iter().enumerate().for_each(|(place, &p)| places[p] = Some(place));
        Free { places, count: free.len(), held }
    }

    pub(crate) fn place(&self, parameter: usize) -> Option<usize> {
        self.places.get(parameter).copied().flatten()
    }
}

/// `df/dx`, and beside it `df/dp` for the free parameters: the entries that are not zero, row by row.
#[derive(Clone, Default)]
pub(crate) struct Linearisation {
    /// Columns and values of `df/dx`, and where each row ends.
    states: Vec<(usize, f64)>,
    state_ends: Vec<usize>,
    /// The same of `df/dp`; the columns follow those of the states that have one.
    parameters: Vec<(usize, f64)>,
    parameter_ends: Vec<usize>,
    /// The contacts that stick, and what their modes do to their `dw/dt`, row by row.
    stuck: Vec<usize>,
    influence: Vec<f64>,
    /// Memory: the linear system of their modes, and one row.
    system: Vec<f64>,
    row: Vec<f64>,
}

impl Linearisation {
    /// Notes the contacts that stick at the point, and what their modes do to their `dw/dt`.
    pub(crate) fn hold(
        &mut self,
        stuck: impl Iterator<Item = usize>,
        influence: impl Fn(usize, usize) -> f64,
    ) {
        self.stuck.clear();
        self.stuck.extend(stuck);
        let Linearisation { stuck, influence: entries, .. } = self;
        entries.clear();
        stuck.iter().for_each(|&c| entries.extend(stuck.iter().map(|&k| influence(c, k))));
    }

    /// The entries of row `i` of `df/dx`.
    #[inline(always)]
    pub(crate) fn by_state(&self, i: usize) -> &[(usize, f64)] {
        &self.states[if i == 0 { 0 } else { self.state_ends[i - 1] }..self.state_ends[i]]
    }

    /// The entries of row `i` of `df/dp`, their columns counted from the first state on.
    #[inline(always)]
    pub(crate) fn by_parameter(&self, i: usize) -> &[(usize, f64)] {
        &self.parameters[if i == 0 { 0 } else { self.parameter_ends[i - 1] }..self.parameter_ends[i]]
    }

    /// Writes `df/dx` with its zeros, row by row.
    pub(crate) fn write_by_state(&self, out: &mut [f64]) {
        let n = self.state_ends.len();
        out.fill(0.0);
        (0..n).for_each(|i| self.by_state(i).iter().for_each(|&(j, a)| out[i * n + j] = a));
    }

    /// Reads the entries of a model with `n` states from the outputs of its Jacobian, after
    /// [`Linearisation::hold`].
    pub(crate) fn read(&mut self, of: &Jacobian, n: usize, free: &Free, slope: impl Fn(usize) -> f64) {
        self.states.clear();
        self.state_ends.clear();
        self.parameters.clear();
        self.parameter_ends.clear();
        self.solve_modes(of, n, free, &slope);
        let (m, width) = (self.stuck.len(), self.stuck.len() + n + free.count);
        for i in 0..n {
            let by_state = of.rates_by_state.row(i).map(|(j, k)| (j, slope(k)));
            let by_parameter = of.rates_by_parameter.row(i);
            let by_parameter = by_parameter.filter_map(|(p, k)| Some((n + free.place(p)?, slope(k))));
            let by_mode = of.rates_by_mode.row(i).filter_map(|(c, k)| {
                let value = slope(k);
                Some((self.stuck.binary_search(&c).ok()?, value)).filter(|_| value != 0.0)
            });
            let mut by_mode = by_mode.peekable();
            let present = |(_, a): &(usize, f64)| *a != 0.0;
            if by_mode.peek().is_none() {
                self.states.extend(by_state.filter(present));
                self.parameters.extend(by_parameter.filter(present).map(|(j, a)| (j - free.held, a)));
            } else {
                self.row.clear();
                self.row.resize(n + free.count, 0.0);
                by_state.chain(by_parameter).for_each(|(j, a)| self.row[j] = a);
                for (r, value) in by_mode {
                    let moved = &self.system[r * width + m..(r + 1) * width];
                    self.row.iter_mut().zip(moved).for_each(|(a, y)| *a -= value * y);
                }
                let entries = self.row.iter().copied().enumerate().filter(present);
                let (states, parameters): (Vec<_>, Vec<_>) = entries.partition(|(j, _)| *j < n);
                self.states.extend(states);
                self.parameters.extend(parameters.into_iter().map(|(j, a)| (j - free.held, a)));
            }
            self.state_ends.push(self.states.len());
            self.parameter_ends.push(self.parameters.len());
        }
    }

    /// The modes of sticking contacts depend on the state: `ds = -M^-1 (d(dw/dt)/dx dx + d(dw/dt)/dp dp)`.
    /// The system holds its negative after `m` numbers in each row.
    fn solve_modes(&mut self, of: &Jacobian, n: usize, free: &Free, slope: &impl Fn(usize) -> f64) {
        let m = self.stuck.len();
        self.system.clear();
        if m == 0 {
            return;
        }
        let width = m + n + free.count;
        self.system.resize(m * width, 0.0);
        let rows = self.system.chunks_exact_mut(width).zip(self.influence.chunks_exact(m));
        for (&c, (row, influence)) in self.stuck.iter().zip(rows) {
            row[..m].copy_from_slice(influence);
            of.surface_rates_by_state.row(c).for_each(|(j, k)| row[m + j] = slope(k));
            for (p, k) in of.surface_rates_by_parameter.row(c) {
                if let Some(place) = free.place(p) {
                    row[m + n + place] = slope(k);
                }
            }
        }
        solve_in_place(&mut self.system, m, n + free.count);
    }
}
