//! Evaluating the automaton at a point, in the present modes: rates, surfaces, and what a sticking contact needs to stay.

use crate::automaton::Automaton;
use crate::run::Drive;
use phisindy_expr::Scratch;

/// How far off the surface, in units of the speed scale, friction is looked at when its value at zero speed is singular.
const OFF_SURFACE: f64 = 1e-6;

/// The automaton with its scratch memory, the drive, and the present modes.
pub(crate) struct Field<'a> {
    pub(crate) automaton: &'a Automaton,
    drive: &'a Drive<'a>,
    flow: Scratch<1>,
    surface: Scratch<1>,
    jacobian: Option<Scratch<1>>,
    hints: Vec<usize>,
    /// Present mode of each switch: +1, -1, or, while sticking, the fraction of friction that is in use.
    pub(crate) modes: Vec<f64>,
    /// Whether a switch sticks.
    pub(crate) stuck: Vec<bool>,
    /// Floor under `|w|` at which a stuck contact's friction is largest.
    floors: Vec<f64>,
    /// Largest `|w|` seen: the scale of speed.
    pub(crate) speed: Vec<f64>,
    /// Evaluations of the rates so far.
    pub(crate) evaluations: usize,
}

impl<'a> Field<'a> {
    pub(crate) fn new(automaton: &'a Automaton, drive: &'a Drive<'a>, sensitivities: bool) -> Self {
        let c = automaton.switches.len();
        Field {
            automaton,
            drive,
            flow: Scratch::new(&automaton.flow),
            surface: Scratch::new(&automaton.surface),
            jacobian: sensitivities.then(|| Scratch::new(&automaton.jacobian)),
            hints: vec![0; automaton.inputs],
            modes: vec![0.0; c],
            stuck: vec![false; c],
            floors: vec![0.0; c],
            speed: vec![0.0; c],
            evaluations: 0,
        }
    }

    pub(crate) fn switches(&self) -> usize {
        self.modes.len()
    }

    fn write(&mut self, which: Which, t: f64, x: &[f64]) {
        let scratch = match which {
            Which::Flow => &mut self.flow,
            Which::Surface => &mut self.surface,
            Which::Jacobian => self.jacobian.as_mut().expect("made for a run with sensitivities"),
        };
        let (n, u) = (x.len(), self.automaton.inputs);
        scratch.input(0)[0] = t;
        for (k, &value) in x.iter().enumerate() {
            scratch.input(1 + k)[0] = value;
        }
        for (k, signal) in self.drive.inputs.iter().enumerate() {
            let (value, slope) = signal.value_and_slope(t, &mut self.hints[k]);
            scratch.input(1 + n + k)[0] = value;
            scratch.input(1 + n + u + k)[0] = slope;
        }
        let rest = self.drive.parameters.iter().chain(&self.modes).chain(&self.floors);
        for (k, &value) in rest.enumerate() {
            scratch.input(1 + n + 2 * u + k)[0] = value;
        }
    }

    /// `dx/dt`. Contacts that stick use the fraction of their friction that holds them.
    pub(crate) fn rates(&mut self, t: f64, x: &[f64], out: &mut [f64]) {
        if self.stuck.contains(&true) {
            self.hold(t, x);
        }
        self.write(Which::Flow, t, x);
        self.flow.run();
        self.evaluations += 1;
        for (k, rate) in out.iter_mut().enumerate() {
            *rate = self.flow.output(k)[0];
        }
    }

    /// Evaluates the surfaces at a point; read them with [`Field::w`], [`Field::w_rate`], [`Field::influence`].
    pub(crate) fn surfaces(&mut self, t: f64, x: &[f64]) {
        self.write(Which::Surface, t, x);
        self.surface.run();
    }

    pub(crate) fn w(&self, c: usize) -> f64 {
        self.surface.output(c)[0]
    }

    pub(crate) fn w_rate(&self, c: usize) -> f64 {
        self.surface.output(self.switches() + c)[0]
    }

    /// How the rate of `w_c` changes with the mode of switch `k`; negative on the diagonal for friction.
    pub(crate) fn influence(&self, c: usize, k: usize) -> f64 {
        let n = self.switches();
        self.surface.output(2 * n + c * n + k)[0]
    }

    /// `dw_c/dx_j`: the normal of the surface.
    pub(crate) fn normal(&self, c: usize, j: usize) -> f64 {
        let (m, n) = (self.switches(), self.automaton.states.len());
        self.surface.output(2 * m + m * m + c * n + j)[0]
    }

    /// Sets the modes of all stuck contacts to the fractions that keep them at rest: `dw/dt = 0`, all together.
    ///
    /// The rates are linear in the modes on the surface (friction is `s F`), so this is one linear system.
    pub(crate) fn hold(&mut self, t: f64, x: &[f64]) {
        let set: Vec<usize> = (0..self.switches()).filter(|&c| self.stuck[c]).collect();
        set.iter().for_each(|&c| self.modes[c] = 0.0);
        self.surfaces(t, x);
        let m = set.len();
        let mut a: Vec<f64> = Vec::with_capacity(m * (m + 1));
        for &c in &set {
            a.extend(set.iter().map(|&k| self.influence(c, k)));
            a.push(-self.w_rate(c));
        }
        solve_in_place(&mut a, m, 1);
        set.iter().enumerate().for_each(|(i, &c)| self.modes[c] = a[i * (m + 1) + m]);
    }

    /// Chooses, for contact `c` on its surface, the floor under `|w|` at which its friction is largest and finite: zero for ordinary friction, a
    /// little off the surface for friction that is singular there.
    pub(crate) fn choose_floor(&mut self, c: usize, t: f64, x: &[f64]) {
        self.floors[c] = 0.0;
        if !self.automaton.switches[c].shaped {
            return;
        }
        let scale = if self.speed[c] > 0.0 { self.speed[c] } else { 1.0 };
        let mut best = (f64::NEG_INFINITY, 0.0);
        for floor in [0.0, 0.1 * OFF_SURFACE * scale, OFF_SURFACE * scale] {
            self.floors[c] = floor;
            self.surfaces(t, x);
            let friction = -self.influence(c, c);
            if friction.is_finite() && friction > best.0 {
                best = (friction, floor);
            }
        }
        self.floors[c] = best.1;
    }

    pub(crate) fn clear_floor(&mut self, c: usize) {
        self.floors[c] = 0.0;
    }

    /// All derivatives at a point, in the present modes (call [`Field::hold`] or [`Field::rates`] there before).
    pub(crate) fn derivatives(&mut self, t: f64, x: &[f64]) -> Derivatives<'_> {
        self.write(Which::Jacobian, t, x);
        let scratch = self.jacobian.as_mut().expect("made for a run with sensitivities");
        scratch.run();
        Derivatives { scratch, n: x.len(), p: self.automaton.parameters, c: self.modes.len() }
    }
}

enum Which {
    Flow,
    Surface,
    Jacobian,
}

/// Read access to the outputs of the jacobian tape.
pub(crate) struct Derivatives<'a> {
    scratch: &'a Scratch<1>,
    n: usize,
    p: usize,
    c: usize,
}

impl Derivatives<'_> {
    fn at(&self, k: usize) -> f64 {
        self.scratch.output(k)[0]
    }
    /// d rate_i / d x_j
    pub(crate) fn rate_x(&self, i: usize, j: usize) -> f64 {
        self.at(i * self.n + j)
    }
    /// d rate_i / d p_j
    pub(crate) fn rate_p(&self, i: usize, j: usize) -> f64 {
        self.at(self.n * self.n + i * self.p + j)
    }
    /// d rate_i / d s_c
    pub(crate) fn rate_s(&self, i: usize, c: usize) -> f64 {
        self.at(self.n * (self.n + self.p) + i * self.c + c)
    }
    fn surface_base(&self) -> usize {
        self.n * (self.n + self.p + self.c)
    }
    /// d (dw_c/dt) / d x_j
    pub(crate) fn w_rate_x(&self, c: usize, j: usize) -> f64 {
        self.at(self.surface_base() + c * self.n + j)
    }
    /// d (dw_c/dt) / d p_j
    pub(crate) fn w_rate_p(&self, c: usize, j: usize) -> f64 {
        self.at(self.surface_base() + self.c * self.n + c * self.p + j)
    }
    /// d w_c / d p_j
    pub(crate) fn w_p(&self, c: usize, j: usize) -> f64 {
        self.at(self.surface_base() + self.c * (self.n + self.p) + c * self.p + j)
    }
}

/// Gauss-Jordan elimination with row pivoting on `m` rows of `m + k` numbers; the right-hand sides become the solutions. A singular matrix
/// leaves infinities, which the caller sees as a contact that cannot hold.
pub(crate) fn solve_in_place(a: &mut [f64], m: usize, k: usize) {
    let width = m + k;
    for col in 0..m {
        let pivot = (col..m).max_by(|&i, &j| a[i * width + col].abs().total_cmp(&a[j * width + col].abs())).unwrap_or(col);
        if pivot != col {
            (0..width).for_each(|j| a.swap(pivot * width + j, col * width + j));
        }
        let inverse = 1.0 / a[col * width + col];
        (0..width).for_each(|j| a[col * width + j] *= inverse);
        for row in (0..m).filter(|&r| r != col) {
            let factor = a[row * width + col];
            if factor != 0.0 {
                (0..width).for_each(|j| a[row * width + j] -= factor * a[col * width + j]);
            }
        }
    }
}
