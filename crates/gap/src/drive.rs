//! What drives a record: the part of the known rates that is there while everything stands still.

use crate::whiteness::lines;
use phisindy_expr::{Scratch, Tape};
use phisindy_phys::{Record, System};

/// Frequencies that are looked for in each rate.
const LINES: usize = 6;
/// Two frequencies whose phases drift apart by less than this along a record (rad) are one.
const ONE: f64 = 1.0;
/// Up to this multiple of a frequency of the drive the motion has lines of its own.
const MULTIPLES: u32 = 3;

/// The known rates at rest as functions of time.
pub(crate) struct Drive<'a> {
    system: &'a System,
    record: &'a Record,
    scratch: Scratch<1>,
}

impl<'a> Drive<'a> {
    /// `None` where the known rates need something that is no argument of theirs.
    pub(crate) fn new(system: &'a System, record: &'a Record) -> Option<Drive<'a>> {
        let tape = Tape::compile(&system.graph, &system.arguments(), &system.known).ok()?;
        Some(Drive { system, record, scratch: Scratch::new(&tape) })
    }

    /// The rate of each state at a time.
    pub(crate) fn at(&mut self, t: f64) -> Vec<f64> {
        let inputs = self.record.inputs.iter().map(|u| u.value(t));
        let still = self.system.states.iter().map(|_| 0.0);
        let numbers = self.system.parameters.iter().map(|p| p.start);
        let numbers = numbers.chain(self.record.constants.iter().copied());
        self.scratch.at([t].into_iter().chain(still).chain(inputs).chain(numbers));
        (0..self.system.known.len()).map(|k| self.scratch.output(k)[0]).collect()
    }

    /// The line of the drive (rad/s) that stands at `frequency`, or of which it is a small multiple, if there is one.
    pub(crate) fn line_at(&mut self, frequency: f64) -> Option<f64> {
        let (n, first) = (self.record.len(), self.record.time[0]);
        let span = self.record.time[n - 1] - first;
        let step = span / (n - 1) as f64;
        let rates: Vec<Vec<f64>> = (0..n).map(|i| self.at(first + i as f64 * step)).collect();
        (0..self.system.known.len()).find_map(|k| {
            let rate: Vec<f64> = rates.iter().map(|r| r[k]).collect();
            let moves = rate.iter().all(|r| r.is_finite()) && rate.iter().any(|r| *r != rate[0]);
            let found = if moves { lines(&rate, step, LINES, 0) } else { vec![] };
            found.into_iter().find(|line| {
                (1..=MULTIPLES).any(|m| (frequency - f64::from(m) * line).abs() * span < ONE * f64::from(m))
            })
        })
    }
}
