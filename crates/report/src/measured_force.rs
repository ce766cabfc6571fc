//! The force balance of a measured motion: inertia times measured acceleration less the forces that a model
//! has.

mod local_cubic;

pub(crate) use local_cubic::LocalCubic;
use phisindy_learn::RecordFit;
use phisindy_phys::{Record, System};

/// Most samples of a record that are looked at.
pub(crate) const SAMPLES: usize = 600;

/// How the acceleration of a body is known.
pub(crate) enum Acceleration {
    /// The displacement state, whose column is measured.
    OfDisplacement(usize),
    /// The velocity state, whose column is measured.
    OfVelocity(usize),
    /// The column of an output that reads it, or the force itself.
    Read(usize),
    /// Not at all.
    Unknown,
}

/// What the points of a force balance are made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Parts {
    /// Inertia times acceleration, less the forces that the model knows.
    Forces,
    /// The acceleration, less what the model knows of it: the spec has no inertia.
    Rates,
    /// What a force cell reads, less the part that the model knows: there is no body.
    Reading,
}

impl Parts {
    /// For the legend of a figure.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Parts::Forces => "measured force balance",
            Parts::Rates => "measured balance",
            Parts::Reading => "measured, less the known part",
        }
    }

    /// For its caption.
    pub(crate) fn words(self) -> &'static str {
        match self {
            Parts::Forces => "the measured force balance, inertia times acceleration less the known forces",
            Parts::Rates => "the measured acceleration less the known part of it",
            Parts::Reading => "the measured force less the known part of it",
        }
    }
}

/// The body that a force acts on.
pub(crate) struct Body<'a> {
    pub(crate) system: &'a System,
    /// The velocity state, if there is one.
    pub(crate) state: Option<usize>,
    pub(crate) acceleration: Acceleration,
    /// The sign with which the force enters the rate: -1 for a resistance.
    pub(crate) sign: f64,
}

/// What the graph of a model gives at a sample, for its states and numbers: abscissa, force, velocity, rate,
/// inertia (SI).
pub(crate) type Evaluated<'e> = dyn FnMut(usize, &[f64], &[f64]) -> [f64; 5] + 'e;

impl Body<'_> {
    /// The force balance of the measured motion (SI), and over which time (s) the acceleration was smoothed.
    /// With `m a = K - F` it is `F = F(model) + m (a(model) - a(measured))`, both at the measured state, so
    /// that the law itself cancels. `typical` is the largest force of the law; `noise` is that of each
    /// column.
    pub(crate) fn measured(
        &self,
        record: &Record,
        fit: &RecordFit,
        noise: &[(String, f64)],
        typical: f64,
        numbers: &[f64],
        evaluated: &mut Evaluated<'_>,
    ) -> (Vec<(f64, f64)>, f64) {
        let Some(run) = &fit.run else { return (vec![], 0.0) };
        let residual = |k: usize| fit.residuals.get(k).filter(|e| !e.is_empty());
        let own = |column: usize| -> Vec<usize> {
            (0..record.len()).filter(|&i| record.own_times.has(column, i)).collect()
        };
        let mut out = Vec::new();
        let mut keep = |place: f64, force: f64| {
            if place.is_finite() && force.is_finite() {
                out.push((place, force));
            }
        };
        let (column, displacement) = match self.acceleration {
            Acceleration::Read(k) => {
                let Some(left) = residual(k) else { return (vec![], 0.0) };
                let own = own(k);
                for &i in own.iter().step_by(own.len().div_ceil(SAMPLES).max(1)) {
                    let [place, force, _, _, inertia] = evaluated(i, run.state_at(i), numbers);
                    let inertia = if self.state.is_some() { self.inertia(inertia) } else { 1.0 };
                    keep(place, force + self.sign * inertia * left[i]);
                }
                return (out, 0.0);
            }
            Acceleration::OfDisplacement(x) => (x, Some(x)),
            Acceleration::OfVelocity(v) => (v, None),
            Acceleration::Unknown => return (vec![], 0.0),
        };
        let (Some(left), Some(v)) = (residual(column), self.state) else { return (vec![], 0.0) };
        let own = own(column);
        let time: Vec<f64> = own.iter().map(|&i| record.time[i]).collect();
        let values: Vec<f64> = own.iter().map(|&i| run.state_at(i)[column] + left[i]).collect();
        let name = self.system.states[column].name.as_str();
        let noise = noise.iter().find(|(column, _)| column == name).map_or(0.0, |n| n.1);
        let inertia = self.inertia(evaluated(0, run.state_at(0), numbers)[4]);
        let Some(smooth) =
            LocalCubic::new(&time, &values, noise * inertia.abs() / typical, displacement.is_some())
        else {
            return (vec![], 0.0);
        };
        let half = smooth.half_width();
        for (k, &i) in own.iter().enumerate().step_by(own.len().div_ceil(SAMPLES).max(1)) {
            let t = record.time[i];
            // Over a change of mode the smoothed acceleration is a mean of two.
            let changes = run.changes_near(t, half);
            let switches = run.modes.len() / record.len().max(1);
            let held = run.modes[i * switches..(i + 1) * switches].contains(&0);
            let Some([value, slope, curvature]) = smooth.at(k) else { continue };
            let mut states = run.state_at(i).to_vec();
            if changes || held {
                continue;
            }
            states[column] = value;
            let mut acceleration = slope;
            if displacement.is_some() {
                (states[v], acceleration) = (slope, curvature);
            }
            let [place, force, _, rate, inertia] = evaluated(i, &states, numbers);
            keep(place, force - self.sign * self.inertia(inertia) * (rate - acceleration));
        }
        (out, 2.0 * half)
    }

    /// What the points of the balance are made of.
    pub(crate) fn parts(&self) -> Parts {
        match self.state {
            None => Parts::Reading,
            Some(s) if self.system.inertia[s].is_some() => Parts::Forces,
            Some(_) => Parts::Rates,
        }
    }

    /// The inertia of the body; 1 where the spec has none, so that forces are rates.
    fn inertia(&self, value: f64) -> f64 {
        self.state.and_then(|s| self.system.inertia[s]).map_or(1.0, |_| value)
    }
}

impl Acceleration {
    /// How the rate of a velocity is known.
    pub(crate) fn of(system: &System, state: usize) -> Acceleration {
        let read = system.rate_symbols.iter().find(|(s, _)| *s == state).map(|(_, symbol)| *symbol);
        if let Some(k) = system.outputs.iter().position(|o| Some(o.node) == read) {
            return Acceleration::Read(system.states.len() + k);
        }
        let of = system.states.iter().position(|s| s.velocity == Some(state));
        of.map_or(Acceleration::OfVelocity(state), Acceleration::OfDisplacement)
    }
}

/// The five outputs of a tape at sample `i` of a record, with these states and parameters of the record (SI).
pub(crate) fn outputs_at(
    scratch: &mut phisindy_expr::Scratch<1>,
    record: &Record,
    i: usize,
    states: &[f64],
    numbers: &[f64],
) -> [f64; 5] {
    let t = record.time[i];
    let inputs = record.inputs.iter().map(|u| u.value(t));
    let rest = numbers.iter().chain(&record.constants).copied();
    scratch.at([t].into_iter().chain(states.iter().copied()).chain(inputs).chain(rest));
    std::array::from_fn(|k| scratch.output(k)[0])
}
