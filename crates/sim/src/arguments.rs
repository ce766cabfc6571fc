//! What the tapes of an automaton take: time, states, inputs, parameters, and the present modes.

use crate::automaton::Automaton;
use crate::trajectory::Drive;
use phisindy_expr::Scratch;

/// What the inputs of the tapes are made of beside the point.
pub(crate) struct Arguments<'f> {
    pub(crate) automaton: &'f Automaton,
    pub(crate) drive: &'f Drive<'f>,
    pub(crate) origin: f64,
    pub(crate) left_of: Option<f64>,
    pub(crate) right_of: f64,
    pub(crate) stepped: &'f [bool],
    pub(crate) modes: &'f [f64],
    pub(crate) stuck: &'f [bool],
    pub(crate) floors: &'f [f64],
    pub(crate) margins: &'f [f64],
}

impl Arguments<'_> {
    /// Writes them to a lane, for the point `(t, x)`.
    pub(crate) fn write<const N: usize>(
        &self,
        scratch: &mut Scratch<N>,
        lane: usize,
        (t, x): (f64, &[f64]),
        hints: &mut [usize],
    ) {
        let (n, u, p) = (x.len(), self.automaton.inputs, self.automaton.parameters);
        let t = self.origin + t;
        scratch.input(0)[lane] = t;
        for (k, &value) in x.iter().enumerate() {
            scratch.input(1 + k)[lane] = value;
        }
        if u > 0 {
            let t = t.max(self.right_of);
            let left = self.left_of.map_or(t, |edge| t.min(edge.next_down()));
            for (k, signal) in self.drive.inputs.iter().enumerate() {
                let t = if self.stepped[k] { t } else { left };
                let (value, slope) = signal.value_and_slope(t, &mut hints[k]);
                scratch.input(1 + n + k)[lane] = value;
                scratch.input(1 + n + u + k)[lane] = slope;
            }
        }
        // The parameters do not change during a run.
        let (first, c) = (1 + n + 2 * u + p, self.floors.len());
        for k in 0..c {
            scratch.input(first + k)[lane] = self.modes[k];
            scratch.input(first + c + k)[lane] = if self.stuck[k] { 0.0 } else { self.modes[k] };
            scratch.input(first + 2 * c + k)[lane] = self.floors[k];
            scratch.input(first + 3 * c + k)[lane] = self.margins[k];
        }
        for (k, &mode) in self.modes[c..c + self.automaton.kinks].iter().enumerate() {
            scratch.input(first + 4 * c + k)[lane] = mode;
        }
        let first = first + 4 * c + self.automaton.kinks;
        for (k, signal) in self.drive.inputs.iter().enumerate().take(self.automaton.arguments - first) {
            let left = self.left_of.map_or(t, |edge| t.min(edge.next_down()));
            scratch.input(first + k)[lane] = signal.bend(left.max(self.right_of), &mut hints[k]);
        }
    }
}
