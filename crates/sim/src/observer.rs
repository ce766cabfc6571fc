//! What follows a record while it is simulated: it sees each sample and may correct the state there, as a
//! Kalman filter does.

use crate::state::Run;

/// What a run shows at a sample.
#[derive(Clone, Copy, Debug)]
pub struct Shown<'a> {
    /// The states, then the outputs.
    pub values: &'a [f64],
    /// Their rates.
    pub rates: &'a [f64],
    /// Derivatives of these by the start, the free parameters and what is spare, row-major; empty without
    /// sensitivities.
    pub sensitivities: &'a [f64],
    /// Derivatives of the outputs by the states, row-major; empty without sensitivities.
    pub by_state: &'a [f64],
    /// Normals of the surfaces of sticking contacts, row-major: along these nothing moves.
    pub held: &'a [f64],
}

/// Follows a run from sample to sample.
pub trait Observer {
    /// Sees a sample; may correct the states `x` and their derivatives `s`, row-major. Returns whether it did.
    fn correct(&mut self, sample: usize, shown: &Shown<'_>, x: &mut [f64], s: &mut [f64]) -> bool;
}

impl Run<'_> {
    /// Lets the observer correct the state at the samples of the present point that it has not seen.
    pub(crate) fn let_correct(&mut self) {
        let Some(observer) = self.observer.take() else { return };
        let (width, m, own) = (self.out.n, self.out.m, self.own);
        let mut corrected = false;
        let mut s = vec![0.0; self.x.len() * m];
        while self.observed < self.next {
            let sample = self.observed;
            self.observed += 1;
            let held = self.held_normals();
            let row = |all: &[f64], of: usize| -> (usize, usize) { (all.len().min(sample * of), of) };
            let part = |(from, of): (usize, usize), all: &[f64]| from..(from + of).min(all.len());
            let values = part(row(&self.out.states, width), &self.out.states);
            let sensitivities = part(row(&self.out.sensitivities, width * m), &self.out.sensitivities);
            let shown = Shown {
                values: &self.out.states[values.clone()],
                rates: &self.out.rates[values],
                sensitivities: &self.out.sensitivities[sensitivities],
                by_state: &self.by_state,
                held: &held,
            };
            if let Some(of) = &self.sensitivity {
                of.read(&mut s);
            }
            if observer.correct(sample, &shown, &mut self.x[..own], &mut s[..own * m]) {
                corrected = true;
                if let Some(of) = &mut self.sensitivity {
                    of.set(&s);
                }
            }
        }
        self.observer = Some(observer);
        if corrected {
            self.field.keep_at_rest(self.t, &mut self.x);
            self.decide_again();
        }
    }

    /// The normals of the surfaces on which contacts stick.
    fn held_normals(&mut self) -> Vec<f64> {
        let stuck: Vec<usize> = (0..self.field.switches()).filter(|&c| self.field.stuck[c]).collect();
        if !stuck.is_empty() {
            self.field.surfaces(self.t, &self.x);
        }
        let n = self.own;
        stuck
            .iter()
            .flat_map(|&c| (0..n).map(move |j| (c, j)))
            .map(|(c, j)| self.field.normal(c, j))
            .collect()
    }
}
