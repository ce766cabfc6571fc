//! The contact rule: what happens on a surface.
//!
//! With `r+` and `r-` the rate of `w` for mode +1 and -1 (others held as they are, stuck ones solved together): it sticks while `r+ <= 0 <= r-`, leaves
//! in the direction of the one that fails, and where both fail (friction would be negative) it goes on as it came. The rates are linear in the
//! mode on the surface, so "sticks" is the same as: the fraction of friction that holds it lies within [-1, 1].

use crate::decisions::{DETACHED, MARGIN, STICK_SLACK};
use crate::field::Field;

impl Field<'_> {
    /// Modes at the start: the sign of `w`, or the contact rule where it is zero. `scale` is the smallest size of each state that matters.
    pub(crate) fn begin(&mut self, t: f64, x: &[f64], scale: &[f64]) {
        self.surfaces(t, x);
        let mut on = Vec::new();
        for c in 0..self.switches() {
            let size: f64 = scale.iter().enumerate().map(|(j, s)| (self.normal(c, j) * s).abs()).sum();
            self.scale[c] = if size > 0.0 { size } else { 1.0 };
            self.margins[c] = MARGIN * self.scale[c];
            self.speed[c] = self.scale[c].max(self.w(c).abs());
            match self.w(c) {
                0.0 => on.push(c),
                w => self.modes[c] = w.signum(),
            }
        }
        for c in 0..self.switches() {
            self.choose_floor(c, t, x);
        }
        if !on.is_empty() {
            self.resolve(&on, t, x);
        }
    }

    /// Decides the modes of the switches `on` their surfaces now and of every contact that sticks. Their modes so far say from where they came (0 if
    /// they start there).
    pub(crate) fn resolve(&mut self, on: &[usize], t: f64, x: &[f64]) {
        let mut grips: Vec<usize> = (0..self.switches()).filter(|&c| self.stuck[c]).collect();
        for &c in on {
            let came = std::mem::replace(&mut self.modes[c], 0.0);
            self.stuck[c] = false;
            self.choose_floor(c, t, x);
            self.surfaces(t, x);
            let (push, grip) = (self.w_rate(c), -self.influence(c, c));
            if self.automaton.switches[c].can_stick && grip > 0.0 {
                grips.push(c);
                continue;
            }
            // A switch that cannot hold (no friction, or friction of the wrong sign) goes where the rates push it.
            self.modes[c] = match (push - grip > 0.0, push + grip < 0.0) {
                (true, false) => 1.0,
                (false, true) => -1.0,
                // Both ways are open: on as it came, or the stronger push from rest.
                _ if came != 0.0 => -came,
                _ if push >= 0.0 => 1.0,
                _ => -1.0,
            };
        }
        self.share(&grips, t, x);
    }

    /// Finds which of the contacts at rest stay at rest: all together at first; while one is overloaded, the worst one slips the way it is pushed; one
    /// that then would not move that way was relieved by the others and sticks again.
    fn share(&mut self, grips: &[usize], t: f64, x: &[f64]) {
        grips.iter().for_each(|&c| self.stuck[c] = true);
        // Friction dissipates, so this ends after a few rounds; the limit is for rates that are no friction at all.
        for _ in 0..4 * grips.len() + 4 {
            self.hold(t, x);
            let load =
                |f: &Self, c: usize| if f.modes[c].is_nan() { f64::INFINITY } else { f.modes[c].abs() };
            let sticking = grips.iter().copied().filter(|&c| self.stuck[c]);
            let worst = sticking.max_by(|&a, &b| load(self, a).total_cmp(&load(self, b)));
            if let Some(c) = worst.filter(|&c| load(self, c) > 1.0 + STICK_SLACK) {
                self.stuck[c] = false;
                self.modes[c] = if self.modes[c] < 0.0 { -1.0 } else { 1.0 };
                continue;
            }
            self.surfaces(t, x);
            let relieved =
                |c: usize| self.modes[c] * self.w_rate(c) < -STICK_SLACK * self.influence(c, c).abs();
            match grips.iter().copied().find(|&c| !self.stuck[c] && relieved(c)) {
                Some(c) => self.stuck[c] = true,
                None => break,
            }
        }
    }

    /// Lets a stuck contact go the way it is pushed; the others that stick are decided anew.
    pub(crate) fn release(&mut self, c: usize, t: f64, x: &[f64]) {
        self.hold(t, x);
        self.modes[c] = if self.modes[c] < 0.0 { -1.0 } else { 1.0 };
        self.stuck[c] = false;
        self.resolve(&[], t, x);
    }

    /// Decides the modes anew after a jump of an input: what it tore off or carried across its surface slips, what sticks may be overloaded.
    pub(crate) fn reconsider(&mut self, t: f64, x: &[f64]) {
        self.surfaces(t, x);
        for c in 0..self.switches() {
            let (w, far) = (self.w(c), DETACHED * self.speed[c]);
            if self.stuck[c] && w.abs() > far || !self.stuck[c] && w * self.modes[c] < -far {
                self.stuck[c] = false;
                self.modes[c] = w.signum();
            }
        }
        self.resolve(&[], t, x);
    }

    /// The fraction of its friction that a stuck contact has left, after [`Field::hold`]: it lets go where this becomes negative.
    pub(crate) fn reserve(&self, c: usize) -> f64 {
        1.0 - self.modes[c].abs()
    }
}
