//! Impacts: gaps that close, rebound, and stay closed.
//!
//! An impact has two surfaces. The gap `h` is located as it closes. Its rate `w` is a switch that never slips: while the
//! gap stays closed the switch sticks, and its mode is the acceleration of the gap that the reaction makes, which lets go
//! where it would have to pull. Rebounds that have become smaller than anything that a run shows end at rest: what is left
//! of their accumulation (Zeno) takes no more time than that.

use crate::decisions::{DETACHED, SHORTEST_RETURN};
use crate::events::{Search, illinois};
use crate::state::Run;
use crate::trajectory::Hit;

impl Run<'_> {
    /// Looks at the gaps that are closed where the run begins: a body that moves on into the other one rebounds at once,
    /// one that does not is held if something presses.
    pub(crate) fn begin_gaps(&mut self) {
        for k in 0..self.field.reactions() {
            self.here.evaluate(&mut self.field, self.t, &self.x);
            let (gap, slow) = (self.field.gap(k), DETACHED * self.field.scale[self.field.reaction(k)]);
            if self.here.w[gap] <= self.field.closed(gap) && self.here.rate[gap] <= slow {
                self.strike(k, false, self.here.rate[gap] < -slow);
            }
        }
    }

    /// Where in the step just made the gap of an impact closes. One that starts closed (just rebounded, or just released)
    /// must open first; one that a run has begun beyond its surface comes to rest where it turns back.
    pub(crate) fn closing(&mut self, k: usize) -> Search {
        let c = self.field.gap(k);
        let here = self.field.near(c);
        let (start, end) = (self.here.w[c], self.there.w[c]);
        if self.field.stuck[self.field.reaction(k)] || (start <= here && end >= -here) {
            return Search::None;
        }
        if start >= -here {
            return self.crossing(c);
        }
        if self.here.rate[c] < 0.0 || self.there.rate[c] >= 0.0 {
            return Search::None;
        }
        let turns = illinois(0.0, 1.0, |theta| {
            self.guard_inside(c, theta);
            self.field.w_rate(c)
        });
        Search::At(c, turns)
    }

    /// The next closed gap that goes on closing.
    pub(crate) fn next_closing(&self) -> Option<usize> {
        let closes = |&k: &usize| {
            let (gap, reaction) = (self.field.gap(k), self.field.reaction(k));
            !self.field.stuck[reaction]
                && self.here.w[gap] <= self.field.closed(gap)
                && self.here.rate[gap] < -DETACHED * self.field.scale[reaction]
        };
        (0..self.field.reactions()).find(closes).map(|k| self.field.gap(k))
    }

    /// Passes the impacts of gaps that a jump of something else has made close.
    pub(crate) fn strike_closing(&mut self) {
        for _ in 0..self.field.reactions() {
            let Some(gap) = self.next_closing() else { return };
            self.strike(gap - self.field.gap(0), false, true);
        }
    }

    /// Passes an impact at the present point: reverses the closing speed, or holds the gap closed. `located` says that the
    /// instant moves with the gap; without `rebounds` nothing is left of the speed.
    pub(crate) fn strike(&mut self, k: usize, located: bool, rebounds: bool) {
        let (gap, reaction) = (self.field.gap(k), self.field.reaction(k));
        let before = self.field.signs();
        let surface = self.field.switches() + k;
        let by_parameter = match &self.sensitivity {
            Some(s) if located => s.by_parameter(&mut self.field, surface, self.t, &self.x),
            _ => vec![],
        };
        self.field.stuck_surfaces(self.t, &self.x);
        let (h, closing) = (self.field.w(gap), self.field.w_rate(gap));
        let mut moves = vec![];
        if located {
            self.field.evaluate_located_normals(self.t, &self.x);
            let normal: Vec<f64> = (0..self.x.len()).map(|j| self.field.located_normal(gap, j)).collect();
            // The state is within rounding of the surface, unless the run began beyond it.
            if h.abs() <= self.options.tolerance * self.field.scale[gap] {
                let length: f64 = normal.iter().map(|n| n * n).sum();
                self.x.iter_mut().zip(&normal).for_each(|(x, n)| *x -= n * h / length);
                if let Some(s) = &self.sensitivity {
                    moves = s.time_of_event(&normal, &by_parameter, closing);
                }
            }
        }
        let shown = self.shown();
        let speeds: Vec<f64> = (0..self.field.frictions()).map(|c| self.here.w[c]).collect();
        let rests = self.rests_after(k, closing, rebounds);
        self.apply(&[self.field.automaton.resets_of_held() + k], &moves, f64::from(u8::from(!rests)));
        // Contacts that the impulse has brought to rest; the reaction stands for the one at the same surface.
        self.field.surfaces(self.t, &self.x);
        let twin = self.field.automaton.twins[k];
        let stopped = |c: &usize| {
            let near = self.field.near(*c);
            !self.field.stuck[*c]
                && self.field.w(*c).abs() <= near
                && speeds[*c].abs() > near
                && !(rests && twin == Some(*c))
        };
        let stopped: Vec<usize> = (0..self.field.frictions()).filter(stopped).collect();
        self.field.stuck[reaction] = rests && !twin.is_some_and(|c| self.field.stuck[c]);
        self.field.reconsider_beside(&stopped, self.t, &self.x);
        self.field.rates(self.t, &self.x, &mut self.rates);
        let n = self.x.len();
        if let Some(s) = &mut self.sensitivity {
            if moves.is_empty() {
                s.restart();
            } else {
                s.jump(&moves, &vec![0.0; n], &self.rates[..n]);
            }
        }
        self.note_jump(&shown, moves);
        self.record(&before);
        self.here.evaluate(&mut self.field, self.t, &self.x);
        let rests = self.field.stuck[reaction];
        self.out.hits.push(Hit { time: self.time(), impact: k, speed: -closing, rests });
    }

    /// Whether an impact at this rate of the gap is the last one: whether something presses, and the next rebound is
    /// smaller than anything that the run shows. Then the pressure is noted.
    fn rests_after(&mut self, k: usize, closing: f64, rebounds: bool) -> bool {
        let (gap, reaction) = (self.field.gap(k), self.field.reaction(k));
        self.field.stuck[reaction] = false;
        self.field.modes[reaction] = 0.0;
        self.field.evaluate_resets(self.t, &self.x, 0.0);
        let resets = &self.field.automaton.resets;
        let restitution = self.field.reset_at(resets.restitutions + k);
        let mut at_rest = self.x.clone();
        let map = &resets.all[self.field.automaton.resets_of_held() + k];
        map.targets().for_each(|(target, value)| at_rest[target] = self.field.reset_at(value));
        self.field.stuck_surfaces(self.t, &at_rest);
        let press = -self.field.w_rate(reaction);
        if press <= 0.0 || !press.is_finite() {
            return false;
        }
        let speed = if rebounds { -restitution * closing } else { 0.0 };
        let (height, flight) = (0.5 * speed * speed / press, 2.0 * speed / press);
        let tolerance = self.options.tolerance;
        let unseen =
            speed <= tolerance * self.field.scale[reaction] && height <= tolerance * self.field.scale[gap];
        let unlocated = height <= 4.0 * self.field.near(gap) || flight <= 2.0 * SHORTEST_RETURN * self.span;
        let rests = unseen || unlocated;
        if rests {
            self.field.pressed[k] = press;
        }
        rests
    }
}
