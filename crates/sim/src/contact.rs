//! The contact rule: what happens on a surface.
//!
//! With `r+` and `r-` the rate of `w` for mode +1 and -1 (others held as they are, stuck ones solved together): it sticks while `r+ <= 0 <= r-`, leaves
//! in the direction of the one that fails, and where both fail (friction would be negative) it goes on as it came. The rates are linear in the
//! mode on the surface, so "sticks" is the same as: the fraction of friction that holds it lies within [-1, 1].

use crate::field::Field;

/// Slack of the stick test, in units of friction: rounding must not shake a contact loose at the very instant it comes to rest.
const SLACK: f64 = 1e-12;

impl Field<'_> {
    /// Decides the modes of switch `on` (if any), which is at its surface now, and of every contact that sticks. `came` is the side from which
    /// `on` reached the surface (its mode so far; 0 if it starts there).
    ///
    /// Returns the switches whose mode changed.
    pub(crate) fn resolve(&mut self, on: &[usize], came: f64, t: f64, x: &[f64]) -> Vec<usize> {
        let before: Vec<(bool, f64)> = self.stuck.iter().copied().zip(self.modes.iter().copied()).collect();
        let mut candidates: Vec<usize> = (0..self.switches()).filter(|c| self.stuck[*c] || on.contains(c)).collect();
        for &c in on {
            self.stuck[c] = false;
            if self.automaton.switches[c].can_stick {
                self.choose_floor(c, t, x);
            }
        }
        // Switches that cannot hold (no friction, or friction of the wrong sign) go where the rates push them.
        for c in candidates.clone() {
            self.modes[c] = 0.0;
            self.surfaces(t, x);
            let (push, grip) = (self.w_rate(c), -self.influence(c, c));
            if !(self.automaton.switches[c].can_stick && grip > 0.0) {
                let (plus, minus) = (push - grip, push + grip);
                self.modes[c] = match (plus > 0.0, minus < 0.0) {
                    (true, false) => 1.0,
                    (false, true) => -1.0,
                    // Both ways are open: on as it came, or the stronger push from rest.
                    _ if came != 0.0 => -came,
                    _ => if push >= 0.0 { 1.0 } else { -1.0 },
                };
                self.stuck[c] = false;
                self.clear_floor(c);
                candidates.retain(|&k| k != c);
            }
        }
        // All others stick together; while one is overloaded, the worst one slips the way it is pushed.
        loop {
            candidates.iter().for_each(|&c| self.stuck[c] = true);
            if candidates.is_empty() {
                break;
            }
            self.hold(t, x);
            let load = |c: usize| if self.modes[c].is_nan() { f64::INFINITY } else { self.modes[c].abs() };
            let worst = candidates.iter().copied().max_by(|&a, &b| load(a).total_cmp(&load(b))).filter(|&c| load(c) > 1.0 + SLACK);
            let Some(worst) = worst else { break };
            let way = self.modes[worst].signum();
            self.stuck[worst] = false;
            self.modes[worst] = if way.is_nan() { if came != 0.0 { -came } else { 1.0 } } else { way };
            self.clear_floor(worst);
            candidates.retain(|&k| k != worst);
        }
        let changed = |c: &usize| before[*c].0 != self.stuck[*c] || (!self.stuck[*c] && before[*c].1 != self.modes[*c]);
        (0..self.switches()).filter(changed).collect()
    }

    /// Lets a stuck contact go the way it is pushed (call [`Field::hold`] before); the others that stick are decided anew.
    pub(crate) fn release(&mut self, c: usize, t: f64, x: &[f64]) {
        self.modes[c] = if self.modes[c] < 0.0 { -1.0 } else { 1.0 };
        self.stuck[c] = false;
        self.clear_floor(c);
        if self.stuck.contains(&true) {
            self.resolve(&[], 0.0, t, x);
        }
    }

    /// The fraction of its friction that a stuck contact has left, after [`Field::hold`]: it lets go where this becomes negative.
    pub(crate) fn reserve(&self, c: usize) -> f64 {
        1.0 - self.modes[c].abs()
    }
}
