//! Models of the tests and short words to run them.
#![allow(dead_code, unreachable_pub, missing_docs)]

use phisindy_phys::Model;
use phisindy_signal::Signal;
use phisindy_sim::{Automaton, Drive, Options, SimError, Trajectory, simulate};

/// A model with numbers: what a test runs.
#[derive(Clone)]
pub struct Case {
    pub automaton: Automaton,
    pub parameters: Vec<f64>,
    pub inputs: Vec<Signal>,
    pub start: Vec<f64>,
    pub options: Options,
}

impl Case {
    /// States with their start values and rates, parameters with their values.
    pub fn new(states: &[(&str, f64, &str)], parameters: &[(&str, f64)]) -> Case {
        Case::driven(states, parameters, vec![])
    }

    /// The same with inputs.
    pub fn driven(
        states: &[(&str, f64, &str)],
        parameters: &[(&str, f64)],
        inputs: Vec<(&str, Signal)>,
    ) -> Case {
        let names: Vec<&str> = states.iter().map(|s| s.0).collect();
        let rates: Vec<&str> = states.iter().map(|s| s.2).collect();
        let input_names: Vec<&str> = inputs.iter().map(|i| i.0).collect();
        let parameter_names: Vec<&str> = parameters.iter().map(|p| p.0).collect();
        let model = Model::build(&names, &input_names, &parameter_names, &rates).unwrap();
        Case {
            automaton: Automaton::new(&model).unwrap(),
            parameters: parameters.iter().map(|p| p.1).collect(),
            inputs: inputs.into_iter().map(|i| i.1).collect(),
            start: states.iter().map(|s| s.1).collect(),
            options: Options { tolerance: 1e-11, ..Options::default() },
        }
    }

    pub fn tolerance(mut self, tolerance: f64) -> Case {
        self.options.tolerance = tolerance;
        self
    }

    pub fn try_run(&self, times: &[f64]) -> Result<Trajectory, SimError> {
        let drive = Drive { inputs: &self.inputs, parameters: &self.parameters };
        simulate(&self.automaton, &drive, 0.0, &self.start, times, &self.options)
    }

    #[track_caller]
    pub fn run(&self, times: &[f64]) -> Trajectory {
        self.try_run(times).unwrap()
    }

    /// All derivatives: by the start state and by every parameter.
    #[track_caller]
    pub fn run_with_sensitivities(&self, times: &[f64]) -> Trajectory {
        let mut case = self.clone();
        case.options.sensitivities = Some((0..self.parameters.len()).collect());
        case.run(times)
    }
}

/// `count` equal intervals from 0 to `end`, both ends included.
pub fn grid(end: f64, count: usize) -> Vec<f64> {
    (0..=count).map(|k| end * k as f64 / count as f64).collect()
}

/// `(time, switch, from, to)` of all events, times rounded for messages.
pub fn story(run: &Trajectory) -> Vec<(usize, i8, i8)> {
    run.events.iter().map(|e| (e.switch, e.from, e.to)).collect()
}

/// Mass on a spring with Coulomb friction, driven: case 1a of the paper.
pub fn case_1a() -> Case {
    one_mass("mu*sgn(y)", &[("mu", 0.5)])
}

/// The same with Dieterich-Ruina friction: case 1b.
pub fn case_1b() -> Case {
    let law = "(mu + a*ln((|y|+eps)/V) + b*ln(c0 + V/(|y|+eps)))*sgn(y)";
    one_mass(law, &[("mu", 0.5), ("a", 0.07), ("b", 0.09), ("V", 0.003), ("c0", 0.022), ("eps", 1e-6)])
}

fn one_mass(friction: &str, law: &[(&str, f64)]) -> Case {
    let rate = format!("(-c*y - k*x + F0*cos(W*t) - {friction})/m");
    let parameters = [&[("m", 1.0), ("c", 0.1), ("k", 1.0), ("F0", 1.0), ("W", 0.3)], law].concat();
    Case::new(&[("x", 0.1, "y"), ("y", 0.1, &rate)], &parameters)
}

/// Two masses, Coulomb on the first, Dieterich-Ruina on the second: case 7.
pub fn case_7() -> Case {
    let parameters = [
        ("m1", 1.0),
        ("m2", 1.0),
        ("c1", 0.1),
        ("c2", 0.1),
        ("k1", 1.0),
        ("k2", 1.0),
        ("F0", 1.0),
        ("W", 0.6),
        ("mu1", 0.3),
        ("mu2", 0.3),
        ("a", 0.07),
        ("b", 0.09),
        ("V", 0.003),
        ("c0", 0.022),
        ("eps", 1e-6),
    ];
    let first = "(-(c1+c2)*y1 + c2*y2 - (k1+k2)*x1 + k2*x2 + F0*cos(W*t) - mu1*sgn(y1))/m1";
    let second =
        "(c2*(y1-y2) + k2*(x1-x2) - (mu2 + a*ln((|y2|+eps)/V) + b*ln(c0 + V/(|y2|+eps)))*sgn(y2))/m2";
    Case::new(&[("x1", 0.0, "y1"), ("x2", 0.0, "y2"), ("y1", 0.0, first), ("y2", 0.0, second)], &parameters)
}
