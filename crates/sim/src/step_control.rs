//! Step control: the first step length, the longest permitted one, the error of a trial step, and the method
//! of the next one.

use crate::decisions::{
    LOAD_RESOLUTION, SHAPE_MATTERS, SHAPE_RESOLUTION, SHAPE_SHORTENING, SPEED_RATIO, SPEED_RATIO_SLACK,
    STEP_SAFETY,
};
use crate::state::Run;
use crate::step::Method;

impl Run<'_> {
    /// Estimates a first step length from the size and the change of the rates (Hairer, Norsett, Wanner,
    /// Solving Ordinary Differential Equations I, II.4).
    pub(crate) fn first_step(&mut self) -> f64 {
        let norm =
            |v: &[f64], scale: &[f64]| v.iter().zip(scale).map(|(v, s)| (v / s).abs()).fold(0.0, f64::max);
        let span = self.longest;
        let d1 = norm(&self.rates, &self.scale);
        let h0 = if d1 > 1e-10 { (1e-3 / d1).min(span) } else { 1e-3 * span };
        let moved: Vec<f64> = self.x.iter().zip(&self.rates).map(|(x, f)| x + h0 * f).collect();
        self.field.rates(self.t + h0, &moved, &mut self.buffer);
        let change: Vec<f64> = self.buffer.iter().zip(&self.rates).map(|(a, b)| (a - b) / h0).collect();
        let d2 = norm(&change, &self.scale);
        let largest = d1.max(d2);
        let h1 = if largest > 1e-15 { (0.1 * self.options.tolerance.powf(0.2) / largest).sqrt() } else { h0 };
        h1.min(100.0 * h0).min(span)
    }

    /// The length of a shorter step, if the trial step passes too much of the shape of some friction near
    /// rest.
    pub(crate) fn shape_limit(&mut self) -> Option<f64> {
        let h = self.step.h;
        let mut shorter: Option<f64> = None;
        for c in (0..self.field.frictions()).filter(|&c| self.field.is_shaped(c)) {
            if self.field.stuck[c] {
                continue;
            }
            let (mode, least) = (self.field.modes[c], self.field.least_speed(c));
            let (start, end) = (mode * self.here.w[c], mode * self.there.w[c]);
            let (from, to) = (start.max(least), end.max(least));
            let change = (self.here.influence[c] - self.there.influence[c]).abs();
            let significant = change > SHAPE_MATTERS * self.here.rate[c].abs().min(self.there.rate[c].abs());
            self.speed_limited[c] = significant;
            let ratio = if to < from { from / to } else { to / from };
            if !significant || ratio <= SPEED_RATIO_SLACK * SPEED_RATIO {
                continue;
            }
            let reach = if to < from { from / SPEED_RATIO - start } else { SPEED_RATIO * from - start };
            let length = (h * reach / (end - start)).clamp(SHAPE_SHORTENING[0] * h, SHAPE_SHORTENING[1] * h);
            shorter = Some(shorter.map_or(length, |s| s.min(length)));
        }
        shorter
    }

    /// The longest step that keeps the speeds of contacts with a significant shape within the permitted
    /// ratio.
    pub(crate) fn speed_limit(&self) -> f64 {
        (0..self.field.switches())
            .filter(|&c| self.speed_limited[c] && !self.field.stuck[c])
            .map(|c| {
                let (mode, least) = (self.field.modes[c], self.field.least_speed(c));
                let (speed, rate) = (mode * self.here.w[c], mode * self.here.rate[c]);
                let from = speed.max(least);
                if rate < 0.0 {
                    // Below the smallest speed nothing changes: the step may reach the surface.
                    if speed <= SPEED_RATIO * least {
                        f64::INFINITY
                    } else {
                        (from / SPEED_RATIO - speed) / rate
                    }
                } else if rate > 0.0 {
                    (SPEED_RATIO * from - speed) / rate
                } else {
                    // The contact has just been released, exactly at its limit.
                    f64::INFINITY
                }
            })
            .fold(f64::INFINITY, f64::min)
    }

    /// Sets the size of each state and the error that the next step may make.
    pub(crate) fn measure(&mut self) {
        for (i, (size, allowed)) in self.size.iter_mut().zip(&mut self.allowed).enumerate() {
            *size = self.scale[i].max(self.x[i].abs());
            *allowed = self.options.tolerance * *size;
        }
    }

    /// The factor by which this error changes the step length, within limits.
    pub(crate) fn rescale(&self, error: f64, within: [f64; 2]) -> f64 {
        (STEP_SAFETY * error.powf(-1.0 / self.step.order())).clamp(within[0], within[1])
    }

    /// The largest scaled error of the trial step; the step is good if it is at most 1.
    pub(crate) fn error(&mut self) -> f64 {
        let n = self.x.len();
        self.step.errors(&mut self.buffer);
        let (states, loads) = self.buffer.split_at(n);
        let tolerance = self.options.tolerance;
        let mut worst = 0.0_f64;
        let mut weigh = |error: f64, size: f64| {
            let scaled = error.abs() / size;
            worst = if scaled.is_nan() { f64::INFINITY } else { worst.max(scaled) };
        };
        for (i, &e) in states.iter().enumerate() {
            weigh(e, tolerance * self.scale[i].max(self.x[i].abs()).max(self.step.end()[i].abs()));
        }
        for (c, &load) in loads.iter().enumerate().take(self.field.switches()) {
            if self.field.stuck[c] {
                weigh(load, LOAD_RESOLUTION);
            } else if self.field.is_shaped(c) {
                let e: f64 = states.iter().enumerate().map(|(j, e)| self.field.normal(c, j) * e).sum();
                let speed = self.here.w[c].abs().max(self.there.w[c].abs()).max(self.field.least_speed(c));
                weigh(e, SHAPE_RESOLUTION * tolerance * speed);
            }
        }
        worst
    }

    /// The time to the surface at constant rate, if the rejected step ends beyond the surface of a slipping
    /// contact.
    pub(crate) fn time_to_surface(&self) -> Option<f64> {
        let crossed = |&c: &usize| !self.field.stuck[c] && self.field.modes[c] * self.there.w[c] < 0.0;
        let reach = |c: usize| -self.here.w[c] / self.here.rate[c];
        (0..self.field.switches()).filter(crossed).map(reach).filter(|r| *r > 0.0).reduce(f64::min)
    }

    /// Chooses the method of the next step, after an accepted one (E. Hairer, G. Wanner, Solving Ordinary
    /// Differential Equations II, IV.2).
    pub(crate) fn choose_method(&mut self) {
        let method = self.step.method();
        let Some(stiffness) = self.step.stiffness(&self.size) else { return };
        if self.watch.note(method, stiffness) {
            self.watch.change(method);
            self.step.set_method(match method {
                Method::Explicit => Method::Implicit,
                Method::Implicit => Method::Explicit,
            });
        }
    }
}
