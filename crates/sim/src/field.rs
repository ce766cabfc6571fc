//! Evaluates the automaton at a point in the present modes: rates, surfaces, and the loads of sticking
//! contacts.

use crate::arguments::Arguments;
use crate::automaton::Automaton;
use crate::decisions::{AT_KINK, LEAST_SPEED, OFF_SURFACE, ON_SURFACE};
use crate::elimination::solve_in_place;
use crate::flow::Flow;
use crate::linearisation::{Free, LANES, Linearisation};
use crate::trajectory::Drive;
use phisindy_expr::{Scratch, Tape};

/// The automaton with its scratch memory, the drive, and the present modes.
pub(crate) struct Field<'a> {
    pub(crate) automaton: &'a Automaton,
    pub(crate) drive: &'a Drive<'a>,
    flow: Scratch<1>,
    surface: Scratch<1>,
    kink_normals: Scratch<1>,
    rest: Scratch<1>,
    output: Scratch<1>,
    reset: Scratch<1>,
    jacobian: Option<Scratch<LANES>>,
    hints: Vec<usize>,
    /// The time of the record at which the run starts: what is evaluated here is at times since then.
    pub(crate) origin: f64,
    /// Inputs are read just before this time of the record at the latest: a step that ends where an input jumps must not
    /// see the jump.
    pub(crate) left_of: Option<f64>,
    /// ... and at this one at the earliest: a step that begins there must see it.
    pub(crate) right_of: f64,
    /// Inputs that are read at the present time all the same: what jumps there has done so.
    pub(crate) stepped: Vec<bool>,
    /// Present mode of each switch: +1, -1, or, while it sticks, the fraction of the friction limit in use;
    /// then that of each kink: +1 or -1; then +1 for each gap: it is open.
    pub(crate) modes: Vec<f64>,
    /// Whether a switch sticks; a kink never does.
    pub(crate) stuck: Vec<bool>,
    /// The number added to `|w|`, so that friction is finite and largest at rest.
    floors: Vec<f64>,
    /// The distance beyond the surface over which friction is continued smoothly.
    pub(crate) margins: Vec<f64>,
    /// For each impact, how hard it was pressed when its gap came to rest: the acceleration that the reaction balanced.
    pub(crate) pressed: Vec<f64>,
    /// The smallest `|w|` of switches and kinks that matters, from the scale of the states.
    pub(crate) scale: Vec<f64>,
    /// The local error of a step, relative to the size of each state.
    tolerance: f64,
    /// Largest `|w|` so far, at least its scale: the reference of rounding errors.
    pub(crate) speed: Vec<f64>,
    /// Evaluations of the rates so far.
    pub(crate) evaluations: usize,
    /// Which contacts stick, and the linear system for their loads: memory of [`Field::solve_stuck_modes`].
    stuck_set: Vec<usize>,
    system: Vec<f64>,
    /// Memory of [`Flow::by_state`].
    linear: Linearisation,
}

impl<'a> Field<'a> {
    pub(crate) fn new(automaton: &'a Automaton, drive: &'a Drive<'a>, origin: f64, tolerance: f64) -> Self {
        let reactions = automaton.twins.len();
        let c = automaton.switches.len() + reactions;
        let all = c + automaton.kinks + reactions;
        let scratch = |tape| prepared(automaton, drive, tape);
        Field {
            automaton,
            drive,
            flow: scratch(&automaton.flow),
            surface: scratch(&automaton.surface),
            kink_normals: scratch(&automaton.kink_normals),
            rest: scratch(&automaton.rest),
            output: scratch(&automaton.output),
            reset: scratch(&automaton.resets.tape),
            jacobian: None,
            hints: vec![0; automaton.inputs],
            origin,
            left_of: None,
            right_of: f64::NEG_INFINITY,
            stepped: vec![false; automaton.inputs],
            modes: (0..all).map(|k| f64::from(u8::from(k >= all - reactions))).collect(),
            stuck: vec![false; all],
            floors: vec![0.0; c],
            margins: vec![0.0; c],
            pressed: vec![1.0; reactions],
            scale: vec![1.0; all],
            tolerance,
            speed: vec![1.0; all],
            evaluations: 0,
            stuck_set: Vec::with_capacity(c),
            system: Vec::with_capacity(c * (c + 1)),
            linear: Linearisation::default(),
        }
    }

    /// Contacts and, after them, the rates of the gaps of impacts.
    pub(crate) fn switches(&self) -> usize {
        self.frictions() + self.reactions()
    }

    pub(crate) fn frictions(&self) -> usize {
        self.automaton.switches.len()
    }

    pub(crate) fn reactions(&self) -> usize {
        self.automaton.twins.len()
    }

    /// The switch that holds the gap of an impact closed.
    pub(crate) fn reaction(&self, impact: usize) -> usize {
        self.frictions() + impact
    }

    /// The surface of the gap of an impact.
    pub(crate) fn gap(&self, impact: usize) -> usize {
        self.switches() + self.automaton.kinks + impact
    }

    /// Switches, kinks, and gaps.
    pub(crate) fn all_surfaces(&self) -> usize {
        self.modes.len()
    }

    /// Within this distance a switch has not left its surface; on which side of it a kink is does not matter. A gap is put
    /// exactly on its surface.
    pub(crate) fn near(&self, c: usize) -> f64 {
        if c >= self.gap(0) {
            return 4.0 * f64::EPSILON * self.speed[c];
        }
        let rounding = ON_SURFACE * self.speed[c];
        if c < self.switches() { rounding } else { rounding.max(AT_KINK * self.tolerance * self.scale[c]) }
    }

    /// Within this distance a gap is closed.
    pub(crate) fn closed(&self, c: usize) -> f64 {
        ON_SURFACE * self.speed[c]
    }

    /// Measures kinks and gaps: the smallest `|w|` that matters, for this smallest size of each state.
    pub(crate) fn measure_kinks(&mut self, t: f64, x: &[f64], scale: &[f64]) {
        self.evaluate_located_normals(t, x);
        for c in self.switches()..self.all_surfaces() {
            let normal = |j| self.located_normal(c, j);
            let size: f64 = scale.iter().enumerate().map(|(j, s)| (normal(j) * s).abs()).sum();
            self.scale[c] = if size > 0.0 { size } else { 1.0 };
            self.speed[c] = self.w(c).abs();
            if c >= self.gap(0) {
                self.speed[c] = self.speed[c].max(self.scale[c]);
            }
        }
    }

    /// Evaluates the normals of kinks and gaps; read them with [`Field::located_normal`].
    pub(crate) fn evaluate_located_normals(&mut self, t: f64, x: &[f64]) {
        self.write(Which::KinkNormals, t, x);
        self.kink_normals.run();
    }

    pub(crate) fn located_normal(&self, c: usize, j: usize) -> f64 {
        self.kink_normals.output((c - self.switches()) * self.automaton.width + j)[0]
    }

    /// Evaluates what states become where they jump, and its derivatives; read them with [`Field::reset_at`]. `rebounds`
    /// is 0 for an impact that ends at rest.
    pub(crate) fn evaluate_resets(&mut self, t: f64, x: &[f64], rebounds: f64) {
        self.write(Which::Reset, t, x);
        let last = self.automaton.arguments;
        self.reset.input(last)[0] = rebounds;
        self.reset.run();
    }

    pub(crate) fn reset_at(&self, k: usize) -> f64 {
        self.reset.output(k)[0]
    }

    /// Evaluates the surfaces after setting the modes of the kinks by the side of their surface; on it by the
    /// rate, unless there is a mode.
    pub(crate) fn place_kinks(&mut self, t: f64, x: &[f64]) {
        self.surfaces(t, x);
        if self.automaton.kinks == 0 {
            return;
        }
        for c in self.switches()..self.gap(0) {
            let w = self.w(c);
            // A NaN shows in the rates.
            if w.abs() > self.near(c) || w.is_nan() {
                self.modes[c] = w.signum();
            } else if self.modes[c] == 0.0 {
                self.modes[c] = if self.w_rate(c) < 0.0 { -1.0 } else { 1.0 };
            }
        }
        self.surfaces(t, x);
    }

    fn write(&mut self, which: Which, t: f64, x: &[f64]) {
        let arguments = Arguments {
            automaton: self.automaton,
            drive: self.drive,
            origin: self.origin,
            left_of: self.left_of,
            right_of: self.right_of,
            stepped: &self.stepped,
            modes: &self.modes,
            stuck: &self.stuck,
            floors: &self.floors,
            margins: &self.margins,
        };
        let scratch = match which {
            Which::Flow => &mut self.flow,
            Which::Surface => &mut self.surface,
            Which::KinkNormals => &mut self.kink_normals,
            Which::Rest => &mut self.rest,
            Which::Output => &mut self.output,
            Which::Reset => &mut self.reset,
            Which::Jacobian(lane) => {
                let jacobian = lanes(&mut self.jacobian, self.automaton, self.drive);
                return arguments.write(jacobian, lane, (t, x), &mut self.hints);
            }
        };
        arguments.write(scratch, 0, (t, x), &mut self.hints);
    }

    /// Writes `dx/dt`, followed by the load of each sticking contact: the fraction of the friction limit
    /// that it uses.
    pub(crate) fn rates(&mut self, t: f64, x: &[f64], out: &mut [f64]) {
        if self.stuck.contains(&true) {
            self.solve_stuck_modes(t, x);
        }
        self.write(Which::Flow, t, x);
        self.flow.run();
        self.evaluations += 1;
        let n = x.len();
        for (k, rate) in out[..n].iter_mut().enumerate() {
            *rate = self.flow.output(k)[0];
        }
        for (c, load) in out[n..n + self.switches()].iter_mut().enumerate() {
            *load = if self.stuck[c] { self.load(c) } else { 0.0 };
        }
    }

    /// How much of what holds a sticking contact is in use: it lets go beyond 1. A reaction may be as large as it likes,
    /// and lets go where it would pull.
    pub(crate) fn load(&self, c: usize) -> f64 {
        let Some(k) = c.checked_sub(self.frictions()) else { return self.modes[c].abs() };
        let push = self.modes[c] / self.pressed[k];
        if push > 0.0 { 1.0 / (1.0 + push) } else { 1.0 - push }
    }

    /// Evaluates the surfaces at a point; read them with [`Field::w`], [`Field::w_rate`],
    /// [`Field::influence`].
    pub(crate) fn surfaces(&mut self, t: f64, x: &[f64]) {
        self.write(Which::Surface, t, x);
        self.surface.run();
    }

    /// Evaluates the surfaces with the sticking contacts at rest, for the rates of the others.
    pub(crate) fn stuck_surfaces(&mut self, t: f64, x: &[f64]) {
        if self.stuck.contains(&true) {
            self.solve_stuck_modes(t, x);
        }
        self.surfaces(t, x);
    }

    pub(crate) fn w(&self, c: usize) -> f64 {
        let (m, n) = (self.switches(), self.automaton.width);
        let at = if c < m { c } else { m * (2 + m + n) + c - m };
        self.surface.output(at)[0]
    }

    pub(crate) fn w_rate(&self, c: usize) -> f64 {
        let (m, n) = (self.switches(), self.automaton.width);
        let located = self.automaton.kinks + self.reactions();
        let at = if c < m { m + c } else { m * (2 + m + n) + located + c - m };
        self.surface.output(at)[0]
    }

    /// The derivative of the rate of `w_c` by the mode of switch `k`; negative on the diagonal for
    /// friction.
    pub(crate) fn influence(&self, c: usize, k: usize) -> f64 {
        let n = self.switches();
        self.surface.output(2 * n + c * n + k)[0]
    }

    /// `dw_c/dx_j`: the normal of the surface.
    pub(crate) fn normal(&self, c: usize, j: usize) -> f64 {
        let (m, n) = (self.switches(), self.automaton.width);
        self.surface.output(2 * m + m * m + c * n + j)[0]
    }

    /// Sets the modes of all sticking contacts to the fractions that keep them at rest: `dw/dt = 0` for all
    /// together.
    ///
    /// The rates are linear in the modes on the surface (friction is `s F`), so this is one linear system.
    pub(crate) fn solve_stuck_modes(&mut self, t: f64, x: &[f64]) {
        let (mut stuck_set, mut system) =
            (std::mem::take(&mut self.stuck_set), std::mem::take(&mut self.system));
        stuck_set.clear();
        stuck_set.extend((0..self.switches()).filter(|&c| self.stuck[c]));
        stuck_set.iter().for_each(|&c| self.modes[c] = 0.0);
        self.surfaces(t, x);
        system.clear();
        for &c in &stuck_set {
            system.extend(stuck_set.iter().map(|&k| self.influence(c, k)));
            system.push(-self.w_rate(c));
        }
        let m = stuck_set.len();
        solve_in_place(&mut system, m, 1);
        stuck_set.iter().enumerate().for_each(|(i, &c)| self.modes[c] = system[i * (m + 1) + m]);
        (self.stuck_set, self.system) = (stuck_set, system);
    }

    /// Chooses the floor of `|w|` at which the friction of contact `c` is largest and finite: zero for
    /// ordinary friction, small for friction that is singular at rest or rises steeply from zero. The floor
    /// stays until the contact returns to its surface, so that slip, stop and release use the same
    /// friction.
    pub(crate) fn choose_floor(&mut self, c: usize, t: f64, x: &[f64]) {
        if !self.is_shaped(c) {
            return;
        }
        let mode = std::mem::replace(&mut self.modes[c], 0.0);
        let (margin, little) = (self.margins[c], OFF_SURFACE * self.scale[c]);
        let mut friction = |floor: f64| {
            self.floors[c] = floor;
            self.surfaces(t, x);
            -self.influence(c, c)
        };
        let mut best = (f64::NEG_INFINITY, little);
        for floor in [0.0, margin, 0.1 * little, little] {
            let size = friction(floor);
            if size > best.0 && size.is_finite() && friction(floor - margin).is_finite() {
                best = (size, floor);
            }
        }
        self.floors[c] = best.1;
        self.modes[c] = mode;
    }

    /// Whether the friction of a switch has a shape near rest.
    pub(crate) fn is_shaped(&self, c: usize) -> bool {
        self.automaton.switches.get(c).is_some_and(|switch| switch.shaped)
    }

    /// The smallest speed that the shape of friction distinguishes from rest.
    pub(crate) fn least_speed(&self, c: usize) -> f64 {
        self.floors[c].max(LEAST_SPEED * self.scale[c])
    }

    /// Updates the largest speeds from those at a point.
    pub(crate) fn note_speeds(&mut self, w: &[f64]) {
        self.speed.iter_mut().zip(w).for_each(|(speed, w)| *speed = speed.max(w.abs()));
    }

    /// Keeps sticking contacts exactly at rest, against rounding and the interpolation error of a belt's
    /// speed. It corrects one after the other: contacts that share a body move each other, and simultaneous
    /// corrections would overshoot and grow from step to step.
    pub(crate) fn keep_at_rest(&mut self, t: f64, x: &mut [f64]) {
        if !self.stuck.contains(&true) {
            return;
        }
        let (m, n) = (self.switches(), x.len());
        self.write(Which::Rest, t, x);
        self.rest.run();
        for c in 0..m {
            let w = self.rest.output(c)[0];
            if self.stuck[c] && w != 0.0 {
                onto_surface(w, |j| self.rest.output(m + c * n + j)[0], x);
                self.write(Which::Rest, t, x);
                self.rest.run();
            }
        }
    }

    /// Moves a point onto the surface of `c`, after [`Field::surfaces`] at this point.
    pub(crate) fn project(&self, c: usize, x: &mut [f64]) {
        onto_surface(self.w(c), |j| self.normal(c, j), x);
    }

    /// The mode of a contact as an integer; 0 is sticking.
    pub(crate) fn sign(&self, c: usize) -> i8 {
        if self.stuck[c] { 0 } else { self.modes[c] as i8 }
    }

    pub(crate) fn signs(&self) -> Vec<i8> {
        (0..self.frictions()).map(|c| self.sign(c)).collect()
    }

    /// Evaluates the outputs and their derivatives at a point; returns the contacts that stick there.
    pub(crate) fn evaluate_outputs(&mut self, t: f64, x: &[f64]) -> Vec<usize> {
        let set: Vec<usize> = (0..self.switches()).filter(|&c| self.stuck[c]).collect();
        if !set.is_empty() {
            self.solve_stuck_modes(t, x);
        }
        self.write(Which::Output, t, x);
        self.output.run();
        set
    }

    /// Entry of the output tape, after [`Field::evaluate_outputs`]; the first ones are `y`.
    pub(crate) fn output_at(&self, k: usize) -> f64 {
        self.output.output(k)[0]
    }

    /// Numbers of outputs, states, switches and parameters.
    fn sizes(&self) -> (usize, usize, usize, usize) {
        let a = self.automaton;
        (a.outputs, a.width, self.switches(), a.parameters)
    }

    /// The change of `y_k` with time, states and modes at rest.
    pub(crate) fn output_by_time(&self, k: usize) -> f64 {
        self.output_at(self.automaton.outputs + k)
    }

    /// d y_k / d x_j
    pub(crate) fn output_by_state(&self, k: usize, j: usize) -> f64 {
        let (q, n, ..) = self.sizes();
        self.output_at(2 * q + k * n + j)
    }

    /// d y_k / d s_c
    pub(crate) fn output_by_mode(&self, k: usize, c: usize) -> f64 {
        let (q, n, m, _) = self.sizes();
        self.output_at(q * (2 + n) + k * m + c)
    }

    /// d y_k / d p_j
    pub(crate) fn output_by_parameter(&self, k: usize, j: usize) -> f64 {
        let (q, n, m, p) = self.sizes();
        self.output_at(q * (2 + n + m) + k * p + j)
    }

    /// The change of `dw_c/dt` with time, states and modes at rest.
    pub(crate) fn rate_by_time(&self, c: usize) -> f64 {
        let (q, n, m, p) = self.sizes();
        self.output_at(q * (2 + n + m + p) + c)
    }

    /// d (dw_c/dt) / d x_j
    pub(crate) fn rate_by_state(&self, c: usize, j: usize) -> f64 {
        let (q, n, m, p) = self.sizes();
        self.output_at(q * (2 + n + m + p) + m + c * n + j)
    }

    /// d (dw_c/dt) / d p_j
    pub(crate) fn rate_by_parameter(&self, c: usize, j: usize) -> f64 {
        let (q, n, m, p) = self.sizes();
        self.output_at(q * (2 + n + m + p) + m * (1 + n) + c * p + j)
    }

    /// All derivatives at one point, the first lane, in the present modes.
    pub(crate) fn jacobian_at(&mut self, t: f64, x: &[f64]) -> &Scratch<LANES> {
        self.write(Which::Jacobian(0), t, x);
        let jacobian = lanes(&mut self.jacobian, self.automaton, self.drive);
        jacobian.run();
        jacobian
    }

    /// Evaluates `lines`, the rates to first order in the present modes, at as many points, [`LANES`] at
    /// most.
    pub(crate) fn linearise(&mut self, lines: &mut [Linearisation], free: &Free, points: &[(f64, &[f64])]) {
        assert!(lines.len() == points.len() && points.len() <= LANES, "a lane for each point");
        for (lane, (line, &(t, x))) in lines.iter_mut().zip(points).enumerate() {
            if self.stuck.contains(&true) {
                self.solve_stuck_modes(t, x);
            }
            line.hold((0..self.switches()).filter(|&c| self.stuck[c]), |c, k| self.influence(c, k));
            self.write(Which::Jacobian(lane), t, x);
        }
        let jacobian = lanes(&mut self.jacobian, self.automaton, self.drive);
        jacobian.run();
        let (of, n) = (&self.automaton.jacobian, self.automaton.width);
        for (lane, line) in lines.iter_mut().enumerate() {
            line.read(of, n, free, |k| jacobian.output(k)[lane]);
        }
    }
}

impl Flow for Field<'_> {
    fn rates(&mut self, t: f64, x: &[f64], out: &mut [f64]) {
        Field::rates(self, t, x, out);
    }

    fn by_state(&mut self, t: f64, x: &[f64], out: &mut [f64]) {
        let mut linear = std::mem::take(&mut self.linear);
        self.linearise(std::slice::from_mut(&mut linear), &Free::default(), &[(t, x)]);
        linear.write_by_state(out);
        self.linear = linear;
    }
}

/// Memory for a tape of the automaton. The parameters do not change during a run.
fn prepared<const N: usize>(automaton: &Automaton, drive: &Drive<'_>, tape: &Tape) -> Scratch<N> {
    let mut scratch = Scratch::new(tape);
    let first = 1 + automaton.width + 2 * automaton.inputs;
    drive.parameters.iter().enumerate().for_each(|(k, &p)| *scratch.input(first + k) = [p; N]);
    scratch
}

/// Memory for the derivatives, made when they are first wanted.
fn lanes<'m>(
    memory: &'m mut Option<Scratch<LANES>>,
    automaton: &Automaton,
    drive: &Drive<'_>,
) -> &'m mut Scratch<LANES> {
    memory.get_or_insert_with(|| prepared(automaton, drive, &automaton.jacobian.tape))
}

/// Moves a point with this `w` onto the surface along the normal.
fn onto_surface(w: f64, normal: impl Fn(usize) -> f64, x: &mut [f64]) {
    let length: f64 = (0..x.len()).map(|j| normal(j).powi(2)).sum();
    if length > 0.0 {
        x.iter_mut().enumerate().for_each(|(j, x)| *x -= normal(j) * w / length);
    }
}

enum Which {
    Flow,
    Surface,
    KinkNormals,
    Rest,
    Output,
    Reset,
    /// The derivatives at the point of a lane.
    Jacobian(usize),
}
