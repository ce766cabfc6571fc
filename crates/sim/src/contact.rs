//! The contact rule: what happens on a surface.
//!
//! `r+` and `r-` are the rates of `w` for mode +1 and -1, with all other modes as they are and the sticking
//! contacts solved together. The contact sticks while `r+ <= 0 <= r-`. If one inequality fails, the contact
//! slips in that direction. If both fail (friction would be negative), it keeps its direction of motion.
//! The rates are linear in the mode on the surface, so the contact sticks exactly if the mode that keeps it
//! at rest lies within [-1, 1].

use crate::decisions::{DETACHED, MARGIN, ON_SURFACE, STICK_SLACK};
use crate::field::Field;

impl Field<'_> {
    /// Sets the modes at the start: the sign of `w`, or the contact rule where `w` is zero. `scale` is the
    /// smallest size of each state that matters.
    pub(crate) fn begin(&mut self, t: f64, x: &[f64], scale: &[f64]) {
        self.surfaces(t, x);
        if self.all_surfaces() > self.switches() {
            self.measure_kinks(t, x, scale);
            self.place_kinks(t, x);
        }
        let mut on = Vec::new();
        for c in 0..self.switches() {
            let size: f64 = scale.iter().enumerate().map(|(j, s)| (self.normal(c, j) * s).abs()).sum();
            self.scale[c] = if size > 0.0 { size } else { 1.0 };
            self.margins[c] = MARGIN * self.scale[c];
            self.speed[c] = self.scale[c].max(self.w(c).abs());
            if c >= self.frictions() {
                continue;
            }
            // A difference of two equal speeds may be off by rounding.
            match self.w(c) {
                w if w.abs() <= ON_SURFACE * self.scale[c] => on.push(c),
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

    /// Decides the modes of the switches `on` their surfaces and of every sticking contact. The previous
    /// modes of `on` give their direction of motion (0 for a start at rest).
    pub(crate) fn resolve(&mut self, on: &[usize], t: f64, x: &[f64]) {
        let mut at_rest: Vec<usize> = (0..self.switches()).filter(|&c| self.stuck[c]).collect();
        for &c in on {
            let incoming = std::mem::replace(&mut self.modes[c], 0.0);
            self.stuck[c] = false;
            self.choose_floor(c, t, x);
            self.surfaces(t, x);
            let (push, friction) = (self.w_rate(c), -self.influence(c, c));
            if self.automaton.switches[c].can_stick && friction > 0.0 {
                at_rest.push(c);
                continue;
            }
            // A switch that cannot stick (no friction, or friction of the wrong sign) follows its rates.
            self.modes[c] = match (push - friction > 0.0, push + friction < 0.0) {
                (true, false) => 1.0,
                (false, true) => -1.0,
                // Both directions are possible: keep the direction of motion, or follow the stronger push
                // from rest.
                _ if incoming != 0.0 => -incoming,
                _ if push >= 0.0 => 1.0,
                _ => -1.0,
            };
        }
        self.find_sticking(&at_rest, t, x);
    }

    /// Finds which of the contacts at rest stick. At first all of them do. While one is overloaded, the
    /// worst one slips in the direction of its load. A slipping contact that would not move in its
    /// direction sticks again: the others have relieved it.
    fn find_sticking(&mut self, at_rest: &[usize], t: f64, x: &[f64]) {
        at_rest.iter().for_each(|&c| self.stuck[c] = true);
        // Friction dissipates, so the search ends after a few rounds. The limit is for rates that are no
        // friction at all.
        for _ in 0..4 * at_rest.len() + 4 {
            self.solve_stuck_modes(t, x);
            let load = |f: &Self, c: usize| if f.modes[c].is_nan() { f64::INFINITY } else { f.load(c) };
            let sticking = at_rest.iter().copied().filter(|&c| self.stuck[c]);
            let worst = sticking.max_by(|&a, &b| load(self, a).total_cmp(&load(self, b)));
            if let Some(c) = worst.filter(|&c| load(self, c) > 1.0 + STICK_SLACK) {
                self.let_go(c);
                continue;
            }
            self.surfaces(t, x);
            let relieved = |c: usize| {
                let direction = if c < self.frictions() { self.modes[c] } else { 1.0 };
                direction * self.w_rate(c) < -STICK_SLACK * self.influence(c, c).abs()
            };
            match at_rest.iter().copied().find(|&c| !self.stuck[c] && relieved(c)) {
                Some(c) => self.stuck[c] = true,
                None => break,
            }
        }
    }

    /// Releases a sticking contact in the direction of its load and decides the other sticking contacts
    /// again.
    pub(crate) fn release(&mut self, c: usize, t: f64, x: &[f64]) {
        self.solve_stuck_modes(t, x);
        self.let_go(c);
        self.resolve(&[], t, x);
    }

    /// A contact that slips in the direction of its load; a gap that is held no more.
    fn let_go(&mut self, c: usize) {
        let direction = if self.modes[c] < 0.0 { -1.0 } else { 1.0 };
        self.modes[c] = if c < self.frictions() { direction } else { 0.0 };
        self.stuck[c] = false;
    }

    /// Decides the modes again after a jump of an input. A contact that the jump moved off or across its
    /// surface slips; a sticking one may be overloaded.
    pub(crate) fn reconsider(&mut self, t: f64, x: &[f64]) {
        self.reconsider_beside(&[], t, x);
    }

    /// As [`Field::reconsider`], with contacts that have come to rest.
    pub(crate) fn reconsider_beside(&mut self, at_rest: &[usize], t: f64, x: &[f64]) {
        self.place_kinks(t, x);
        for c in 0..self.switches() {
            let (w, far) = (self.w(c), DETACHED * self.speed[c]);
            if self.stuck[c] && w.abs() > far || !self.stuck[c] && w * self.modes[c] < -far {
                self.stuck[c] = false;
                self.modes[c] = if c < self.frictions() { w.signum() } else { 0.0 };
            }
        }
        self.resolve(at_rest, t, x);
    }

    /// The part of the friction limit that a sticking contact does not use, after
    /// [`Field::solve_stuck_modes`]. The contact slips where it becomes negative.
    pub(crate) fn reserve(&self, c: usize) -> f64 {
        1.0 - self.load(c)
    }
}
