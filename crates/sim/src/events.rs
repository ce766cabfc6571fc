//! Events of a run: where in a step a mode ends, a step that ends exactly there, and the transition to the
//! next mode.

use crate::decisions::{
    CHATTER_EVENTS, CHATTER_SPAN, LOCATION_CHANGE, LOCATION_ITERATIONS, MOST_STRIKES, OVERLOAD,
    PEAK_ITERATIONS, ROOT_ITERATIONS, ROOT_WIDTH, SHORTEST_RETURN,
};
use crate::state::Run;
use crate::trajectory::{Jump, SimError};

/// The result of the search for an event in a step.
pub(crate) enum Search {
    /// No event.
    None,
    /// The event of this switch at about this fraction of the step; 0 is its start.
    At(usize, f64),
    /// Only a shorter step can tell.
    Shorter,
}

impl Run<'_> {
    /// The guard of a switch at a point: positive while its mode lasts. The surfaces stay evaluated at this
    /// point.
    fn guard(&mut self, c: usize, t: f64, x: &[f64]) -> f64 {
        if self.field.stuck[c] {
            self.field.solve_stuck_modes(t, x);
            self.field.reserve(c) + OVERLOAD
        } else {
            self.field.stuck_surfaces(t, x);
            self.field.modes[c] * self.field.w(c)
        }
    }

    pub(crate) fn guard_inside(&mut self, c: usize, theta: f64) -> f64 {
        let mut x = std::mem::take(&mut self.buffer);
        let n = self.x.len();
        self.step.dense().value(theta, &mut x[..n]);
        let g = self.guard(c, self.t + theta * self.step.h, &x[..n]);
        self.buffer = x;
        g
    }

    fn guard_at_end(&mut self, c: usize) -> f64 {
        let mut x = std::mem::take(&mut self.buffer);
        let n = self.x.len();
        x[..n].copy_from_slice(self.step.end());
        let g = self.guard(c, self.t + self.step.h, &x[..n]);
        self.buffer = x;
        g
    }

    /// The first guard that becomes negative within the step just made.
    pub(crate) fn first_event(&mut self) -> Search {
        let mut first: Option<(usize, f64)> = None;
        for c in 0..self.field.switches() {
            let event = match self.field.stuck[c] {
                true => self.overload(c),
                false if c < self.field.frictions() => self.crossing(c),
                false => Search::None,
            };
            match event {
                Search::At(c, theta) if first.is_none_or(|(_, f)| theta < f) => first = Some((c, theta)),
                Search::Shorter => return Search::Shorter,
                _ => {}
            }
        }
        for k in 0..self.field.reactions() {
            match self.closing(k) {
                Search::At(c, theta) if first.is_none_or(|(_, f)| theta < f) => first = Some((c, theta)),
                Search::Shorter => return Search::Shorter,
                _ => {}
            }
        }
        // The earliest kink first, by a guess: the others need only be asked whether they come before it.
        let mut kinks: Vec<(usize, f64)> =
            (self.field.switches()..self.field.gap(0)).filter_map(|c| Some((c, self.may_turn(c)?))).collect();
        kinks.sort_by(|a, b| a.1.total_cmp(&b.1));
        for (c, _) in kinks {
            match self.kink(c, first.map_or(1.0, |(_, theta)| theta)) {
                Search::At(c, theta) if first.is_none_or(|(_, f)| theta < f) => first = Some((c, theta)),
                Search::Shorter => return Search::Shorter,
                _ => {}
            }
        }
        first.map_or(Search::None, |(c, theta)| Search::At(c, theta))
    }

    /// Where a kink may leave the side of its mode, at constant rate; `None` if the step shows no sign of it.
    fn may_turn(&self, c: usize) -> Option<f64> {
        let (here, mode) = (self.field.near(c), self.field.modes[c]);
        let (start, end) = (mode * self.here.w[c], mode * self.there.w[c]);
        let dips = start > here && mode * self.here.rate[c] < 0.0 && mode * self.there.rate[c] > 0.0;
        (end < -here || dips).then(|| start / (start - end).abs())
    }

    /// Where in the step a sticking contact is overloaded. The step contains its load at the stages.
    fn overload(&mut self, c: usize) -> Search {
        let load = self.x.len() + c;
        let nodes = self.step.nodes();
        let reserve = |i: usize| 1.0 - self.step.k[i][load] + OVERLOAD;
        let stages = 0..nodes.len();
        let mut bracket =
            stages.clone().skip(1).find(|&i| reserve(i) < 0.0).map(|i| (nodes[i - 1], nodes[i]));
        let least = stages.clone().min_by(|&i, &j| reserve(i).total_cmp(&reserve(j))).unwrap_or(0);
        if bracket.is_none() && least > 0 && least + 1 < stages.end {
            // The load may have a peak between the stages.
            let peak = golden(nodes[least - 1], nodes[least + 1], |theta| self.guard_inside(c, theta));
            if self.guard_inside(c, peak) < 0.0 {
                bracket = Some((nodes[least - 1], peak));
            }
        }
        match bracket {
            None => Search::None,
            Some((good, _)) if self.guard_inside(c, good) <= 0.0 => Search::At(c, good),
            Some((good, bad)) => Search::At(c, illinois(good, bad, |theta| self.guard_inside(c, theta))),
        }
    }

    /// Where in the step a slipping switch reaches its surface. A switch that starts on it (just released,
    /// or just crossed) must leave it first.
    pub(crate) fn crossing(&mut self, c: usize) -> Search {
        let here = self.field.near(c);
        let mode = self.field.modes[c];
        let (start, early) = (mode * self.here.w[c], mode * self.here.rate[c]);
        let (end, late) = (mode * self.there.w[c], mode * self.there.rate[c]);
        if start > here {
            if end < 0.0 {
                return Search::At(c, illinois(0.0, 1.0, |theta| self.guard_inside(c, theta)));
            }
            // It may become negative and return: then its rate changes sign from minus to plus.
            if early < 0.0 && late > 0.0 {
                let mut slope = |theta: f64| {
                    self.guard_inside(c, theta);
                    -mode * self.field.w_rate(c)
                };
                let lowest = illinois(0.0, 1.0, &mut slope);
                if self.guard_inside(c, lowest) < 0.0 {
                    return Search::At(c, illinois(0.0, lowest, |theta| self.guard_inside(c, theta)));
                }
            }
        } else if end < -here {
            let clear =
                [0.5, 0.25, 0.75, 0.125, 0.03, 0.005].into_iter().find(|&f| self.guard_inside(c, f) > here);
            return match clear {
                Some(good) => Search::At(c, illinois(good, 1.0, |theta| self.guard_inside(c, theta))),
                // It returns immediately.
                None if self.step.h > SHORTEST_RETURN * self.span => Search::Shorter,
                None => Search::At(c, 1.0),
            };
        }
        Search::None
    }

    /// Where in the part of the step up to `last` a kink leaves the side of its mode. One that starts on its
    /// surface, where either mode is right, may turn at once, and does so once.
    fn kink(&mut self, c: usize, last: f64) -> Search {
        let (here, mode) = (self.field.near(c), self.field.modes[c]);
        let (start, early) = (mode * self.here.w[c], mode * self.here.rate[c]);
        let end = mode * self.there.w[c];
        let inside = |run: &mut Self, theta: f64| run.guard_inside(c, theta);
        if start > here {
            let mut bad = 1.0;
            if end >= -here {
                bad = illinois(0.0, 1.0, |theta| {
                    inside(self, theta);
                    -mode * self.field.w_rate(c)
                });
                if inside(self, bad) >= -here {
                    return Search::None;
                }
            }
            if last < bad {
                bad = last;
                if inside(self, bad) >= 0.0 {
                    return Search::None;
                }
            }
            return Search::At(c, illinois(0.0, bad, |theta| inside(self, theta)));
        }
        let clear = [0.5, 0.25, 0.75, 0.125, 0.03, 0.005];
        let clear = clear.into_iter().find(|&theta| early > 0.0 && inside(self, theta) > here);
        match clear {
            Some(good) => Search::At(c, illinois(good, 1.0, |theta| inside(self, theta))),
            None if self.turned[c - self.field.switches()] < self.t => Search::At(c, 0.0),
            None if self.step.h > SHORTEST_RETURN * self.span => Search::Shorter,
            None => Search::None,
        }
    }

    /// Repeats the step so that it ends on the surface: Newton's method on the step length, starting at the
    /// root of the dense output. Returns whether every step could be made.
    pub(crate) fn locate(&mut self, c: usize, theta: f64) -> bool {
        let (h, stuck) = (self.step.h, self.field.stuck[c]);
        let size = if stuck { OVERLOAD } else { self.field.near(c) };
        let delta = 1e-4_f64.min(0.5 * theta);
        let mut slope = (self.guard_inside(c, theta) - self.guard_inside(c, theta - delta)) / (delta * h);
        let mut length = theta * h;
        for _ in 0..LOCATION_ITERATIONS {
            if !self.step.advance(length, &self.allowed, &mut self.field) {
                return false;
            }
            let g = self.guard_at_end(c);
            if !stuck {
                slope = self.field.modes[c] * self.field.w_rate(c);
            }
            let change = -g / slope;
            if g.abs() <= size
                || !change.is_finite()
                || change.abs() > LOCATION_CHANGE * h
                || length + change <= 0.0
            {
                break;
            }
            length = (length + change).min(h);
        }
        self.there.evaluate(&mut self.field, self.t + self.step.h, self.step.end());
        true
    }

    /// Processes the event at the present point, and all others that are due at the same instant: new
    /// modes, and the jump of the sensitivities.
    pub(crate) fn pass(&mut self, first: usize) -> Result<(), SimError> {
        if self.t - self.chatter.1 > CHATTER_SPAN * self.span {
            self.chatter = (0, self.t);
        }
        let mut due = Some(first);
        let mut done = Vec::new();
        let (gaps, mut strikes) = (self.field.gap(0), 0);
        while let Some(c) = due {
            if c >= gaps {
                strikes += 1;
                self.strike(c - gaps, true, strikes <= MOST_STRIKES);
            } else if c < self.field.switches() {
                self.chatter.0 += 1;
                if self.chatter.0 > CHATTER_EVENTS {
                    let switches = &self.field.automaton.switches;
                    let switch = switches.get(c).map_or_else(|| "an impact".to_owned(), |s| s.text.clone());
                    return Err(SimError::TooManyEvents { time: self.time(), switch });
                }
                self.change(c);
            } else {
                self.turn(c);
            }
            done.push(c);
            self.here.evaluate(&mut self.field, self.t, &self.x);
            due = (0..gaps).find(|&k| !done.contains(&k) && self.is_due(k)).or_else(|| self.next_closing());
            if strikes > 2 * MOST_STRIKES {
                due = None;
            }
        }
        Ok(())
    }

    /// States and outputs at the present point in the present modes; nothing where neither jumps.
    pub(crate) fn shown(&mut self) -> Vec<f64> {
        let automaton = self.field.automaton;
        if automaton.outputs == 0 && self.field.reactions() == 0 {
            return vec![];
        }
        self.field.evaluate_outputs(self.t, &self.x);
        let outputs = (0..automaton.outputs).map(|k| self.field.output_at(k));
        self.x[..self.own].iter().copied().chain(outputs).collect()
    }

    /// Notes by how much states and outputs have jumped from what they showed, and how the instant moves.
    pub(crate) fn note_jump(&mut self, shown: &[f64], moves: Vec<f64>) {
        let by: Vec<f64> = self.shown().iter().zip(shown).map(|(after, before)| after - before).collect();
        if by.iter().any(|jump| *jump != 0.0) {
            self.out.jumps.push(Jump { time: self.time(), by, moves });
        }
    }

    /// Whether a slipping switch is on its surface and about to cross it.
    fn is_due(&self, c: usize) -> bool {
        let (s, w, rate) = (self.field.modes[c], self.here.w[c], self.here.rate[c]);
        !self.field.stuck[c] && s * w <= self.field.near(c) && s * rate < 0.0
    }

    /// Changes the mode of a kink: the rates stay as they are, and so do their derivatives by a shift of the
    /// time of the event.
    fn turn(&mut self, c: usize) {
        self.field.modes[c] = -self.field.modes[c];
        self.turned[c - self.field.switches()] = self.t;
        self.field.rates(self.t, &self.x, &mut self.rates);
        if let Some(s) = &mut self.sensitivity {
            s.restart();
        }
    }

    /// Releases a contact whose friction falls as it lets go: the rates jump at the instant at which its load, the size of its
    /// mode, reaches 1.
    fn break_away(&mut self, c: usize) {
        let n = self.x.len();
        let (old, shown) = (self.rates.clone(), self.shown());
        let moves = self.sensitivity.as_ref().map(|s| {
            let by = self.field.mode_derivatives(c, (self.t, &self.x), &old[..n], &s.free);
            let (rate, by) = by.split_first().map_or((0.0, &[][..]), |(rate, by)| (*rate, by));
            let (by_state, by_parameter) = by.split_at(by.len().min(n));
            s.time_of_event(by_state, by_parameter, rate)
        });
        self.field.release(c, self.t, &self.x);
        self.field.rates(self.t, &self.x, &mut self.rates);
        let moves = moves.unwrap_or_default();
        if let Some(s) = &mut self.sensitivity {
            s.jump(&moves, &old[..n], &self.rates[..n]);
        }
        self.note_jump(&shown, moves);
    }

    /// A contact that holds at the start would stop one that begins a little faster, at once: the derivatives are those after
    /// that stop.
    pub(crate) fn begin_at_rest(&mut self) {
        let n = self.x.len();
        let mut slipping = self.rates.clone();
        for c in (0..self.field.frictions()).filter(|&c| self.field.stuck[c]).collect::<Vec<_>>() {
            let Some(sensitivity) = &mut self.sensitivity else { return };
            let by_parameter = sensitivity.by_parameter(&mut self.field, c, self.t, &self.x);
            let held = self.field.modes[c];
            (self.field.stuck[c], self.field.modes[c]) = (false, 1.0);
            self.field.rates(self.t, &self.x, &mut slipping);
            self.field.stuck_surfaces(self.t, &self.x);
            let normal: Vec<f64> = (0..n).map(|j| self.field.normal(c, j)).collect();
            let moves = sensitivity.time_of_event(&normal, &by_parameter, self.field.w_rate(c));
            (self.field.stuck[c], self.field.modes[c]) = (true, held);
            self.field.rates(self.t, &self.x, &mut self.rates);
            sensitivity.jump(&moves, &slipping[..n], &self.rates[..n]);
            let mut moving = (0..n).filter(|&j| normal[j] != 0.0);
            if let (Some(j), None, true) =
                (moving.next(), moving.next(), by_parameter.iter().all(|p| *p == 0.0))
            {
                sensitivity.rest(j);
            }
        }
    }

    fn change(&mut self, c: usize) {
        let n = self.x.len();
        let before = self.field.signs();
        if self.field.stuck[c] {
            if self.field.automaton.breaks_away {
                self.break_away(c);
            } else {
                self.field.release(c, self.t, &self.x);
                self.field.rates(self.t, &self.x, &mut self.rates);
                if let Some(s) = &mut self.sensitivity {
                    s.restart();
                }
            }
        } else {
            let by_parameter =
                self.sensitivity.as_ref().map(|s| s.by_parameter(&mut self.field, c, self.t, &self.x));
            self.field.stuck_surfaces(self.t, &self.x);
            let w_rate = self.field.w_rate(c);
            let normal: Vec<f64> = (0..n).map(|j| self.field.normal(c, j)).collect();
            let old = self.rates.clone();
            let mut shown = self.shown();
            // The state is within rounding of the surface: project it exactly.
            self.field.stuck_surfaces(self.t, &self.x);
            self.field.project(c, &mut self.x);
            shown.iter_mut().zip(&self.x[..self.own]).for_each(|(shown, x)| *shown = *x);
            self.field.resolve(&[c], self.t, &self.x);
            self.field.rates(self.t, &self.x, &mut self.rates);
            let mut moves = vec![];
            if let (Some(s), Some(by_parameter)) = (&mut self.sensitivity, by_parameter) {
                moves = s.time_of_event(&normal, &by_parameter, w_rate);
                s.jump(&moves, &old[..n], &self.rates[..n]);
            }
            self.note_jump(&shown, moves);
        }
        self.record(&before);
    }
}

/// The root of `g` between `good` (positive) and `bad` (negative), to 1e-10, by the Illinois variant of
/// false position. Returns `bad` if the bracket does not close.
pub(crate) fn illinois(mut good: f64, mut bad: f64, mut g: impl FnMut(f64) -> f64) -> f64 {
    let (mut high, mut low) = (g(good), g(bad));
    let mut side = 0;
    for _ in 0..ROOT_ITERATIONS {
        let mut middle = (good * low - bad * high) / (low - high);
        if !(middle > good.min(bad) && middle < good.max(bad)) {
            middle = 0.5 * (good + bad);
        }
        let value = g(middle);
        if value == 0.0 || (bad - good).abs() <= ROOT_WIDTH {
            return middle;
        }
        if value > 0.0 {
            (good, high) = (middle, value);
            if side == 1 {
                low *= 0.5;
            }
            side = 1;
        } else {
            (bad, low) = (middle, value);
            if side == -1 {
                high *= 0.5;
            }
            side = -1;
        }
    }
    bad
}

/// The minimiser of `g` between `a` and `b`, to 1e-5 of the interval, by golden section.
fn golden(mut a: f64, mut b: f64, mut g: impl FnMut(f64) -> f64) -> f64 {
    let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut left, mut right) = (b - ratio * (b - a), a + ratio * (b - a));
    let (mut low, mut high) = (g(left), g(right));
    for _ in 0..PEAK_ITERATIONS {
        if low < high {
            (b, right, high) = (right, left, low);
            left = b - ratio * (b - a);
            low = g(left);
        } else {
            (a, left, low) = (left, right, high);
            right = a + ratio * (b - a);
            high = g(right);
        }
    }
    if low < high { left } else { right }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Convergence from both sides, to the promised accuracy, and in fewer steps than bisection would take
    /// (33). The curvature of these functions slows plain false position down.
    #[test]
    fn the_root_is_found_in_few_steps() {
        type Case = (fn(f64) -> f64, f64);
        let cases: [Case; 4] = [
            (|x| x - 0.3, 0.3),
            (|x| (8.0 * x).exp() - 2.0, 2.0_f64.ln() / 8.0),
            (|x| 1.0 - (8.0 * (1.0 - x)).exp() / 2.0, 1.0 - 2.0_f64.ln() / 8.0),
            (|x| (20.0 * (x - 0.45)).tanh(), 0.45),
        ];
        for (k, (g, root)) in cases.into_iter().enumerate() {
            for sign in [1.0, -1.0] {
                let mut calls = 0;
                let (good, bad) = if sign * g(1.0) > 0.0 { (1.0, 0.0) } else { (0.0, 1.0) };
                let found = illinois(good, bad, |x| {
                    calls += 1;
                    sign * g(x)
                });
                assert!((found - root).abs() <= 1e-10, "{k}: {found} instead of {root}");
                assert!(calls <= 25, "{k}: {calls} evaluations");
            }
        }
    }

    #[test]
    fn the_least_value_is_found_where_it_is() {
        for at in [-1.3, -0.2, 0.4, 1.9] {
            let found = golden(-1.5, 2.0, |x: f64| (x - at).abs() + (x - at).powi(2));
            assert!((found - at).abs() <= 3.5e-5, "{found} instead of {at}");
        }
    }

    /// A guard that is zero at the good end is where the step began, not the event; bisection continues
    /// from there.
    #[test]
    fn a_root_at_the_good_end_is_not_the_one() {
        let found = illinois(0.0, 0.8, |x| x * (0.6 - x));
        assert!((found - 0.6).abs() <= 1e-10, "{found}");
        let found = illinois(0.8, 0.0, |x| (0.8 - x) * (x - 0.2));
        assert!((found - 0.2).abs() <= 1e-10, "{found}");
    }

    /// No value is zero, and the search still ends at the promised width of the bracket.
    #[test]
    fn a_jump_is_found_like_a_root() {
        let mut calls = 0;
        let found = illinois(0.0, 1.0, |x| {
            calls += 1;
            if x < 0.37 { 1.0 } else { -2.0 }
        });
        assert!((found - 0.37).abs() <= 1e-10, "{found}");
        assert!(calls < 70, "{calls} evaluations");
    }

    /// The bad end is so deep that false position hardly moves. The search ends at a point where the mode
    /// is certainly over.
    #[test]
    fn a_bracket_that_does_not_close_ends_where_the_mode_is_over() {
        let mut calls = 0;
        let guard = |x: f64| if x < 0.37 { 1.0 } else { -1e300 };
        let found = illinois(0.0, 1.0, |x| {
            calls += 1;
            guard(x)
        });
        assert!(guard(found) < 0.0, "{found}");
        assert_eq!(calls, 82);
    }
}
