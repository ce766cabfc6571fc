//! Where a mechanism with loops can be: places and speeds that its constraints allow.

use crate::decisions::LEAST_PIVOT;
use crate::elimination::solve_in_place;
use phisindy_expr::{Graph, Id, Scratch, Tape};

/// Steps of Newton's method; it converges within ten or goes astray.
const MOST_STEPS: usize = 50;

/// The constraints of a mechanism with their derivatives by the states.
pub struct Assembly {
    tape: Tape,
    constraints: usize,
    states: usize,
    /// For each state whether constraints hang on it as a coordinate.
    coordinates: Vec<bool>,
}

impl Assembly {
    /// Of constraints and their rates, with the arguments of [`Assembly::assemble`] in the order of the tape; `states`
    /// are among them. `None` without constraints.
    pub fn new(
        graph: &Graph,
        arguments: &[Id],
        states: &[Id],
        (values, rates): (&[Id], &[Id]),
    ) -> Option<Assembly> {
        if values.is_empty() {
            return None;
        }
        let mut graph = graph.clone();
        let mut outputs = Vec::new();
        for of in values.iter().chain(rates) {
            outputs.push(*of);
            outputs.extend(graph.gradient(*of, states));
        }
        let coordinates = states.iter().map(|&state| graph.uses(values, &[state])).collect();
        let tape = Tape::compile(&graph, arguments, &outputs).ok()?;
        Some(Assembly { tape, constraints: values.len(), states: states.len(), coordinates })
    }

    /// Moves the `free` of the states from `x` to the nearest that the constraints allow: first the places, then the
    /// speeds. `at` gives the arguments for states. Returns whether there is one; `x` is as it was if not.
    pub fn assemble(&self, x: &mut [f64], free: &[bool], at: &dyn Fn(&[f64]) -> Vec<f64>) -> bool {
        let mut moved = x.to_vec();
        let all = [true, false].into_iter().all(|places| {
            let own: Vec<usize> =
                (0..self.states).filter(|&k| free[k] && self.coordinates[k] == places).collect();
            self.newton(&mut moved, &own, usize::from(!places) * self.constraints, at)
        });
        if all {
            x.copy_from_slice(&moved);
        }
        all
    }

    /// Newton's method with the least change of the unknowns `own`, for the constraints from `first` on.
    fn newton(&self, x: &mut [f64], own: &[usize], first: usize, at: &dyn Fn(&[f64]) -> Vec<f64>) -> bool {
        let (m, width) = (self.constraints, self.states + 1);
        let mut scratch = Scratch::<1>::new(&self.tape);
        for _ in 0..MOST_STEPS {
            scratch.at(at(x));
            let row = |k: usize, j: usize| scratch.output((first + k) * width + j)[0];
            // `J J' l = -g`, and the change is `J' l`.
            let mut normal = vec![0.0; m * (m + 1)];
            for i in 0..m {
                for j in 0..m {
                    normal[i * (m + 1) + j] = own.iter().map(|&k| row(i, 1 + k) * row(j, 1 + k)).sum();
                }
                normal[i * (m + 1) + m] = -row(i, 0);
            }
            solve_in_place(&mut normal, m, 1);
            let mut change = 0.0_f64;
            for &k in own {
                let by: f64 = (0..m).map(|i| row(i, 1 + k) * normal[i * (m + 1) + m]).sum();
                x[k] += by;
                change = change.max(by.abs() / (1.0 + x[k].abs()));
            }
            if !change.is_finite() {
                return false;
            }
            if change < LEAST_PIVOT {
                // What is left is as small as numbers are, beside the terms that it is a sum of.
                return (0..m).all(|i| {
                    let size: f64 = (0..self.states).map(|k| (row(i, 1 + k) * x[k]).abs()).sum();
                    row(i, 0).abs() <= LEAST_PIVOT.sqrt() * (1.0 + size)
                });
            }
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use phisindy_phys::Model;

    /// A crank of length 1 with a rod of length 2 whose end stays on a line.
    #[test]
    fn a_crank_tells_where_its_rod_is() {
        let model =
            Model::build(&["a", "b", "x", "u", "w", "v"], &[], &[], &["u", "w", "v", "0", "0", "0"]).unwrap();
        let mut graph = model.graph.clone();
        let mut lowered = |text: &str| {
            graph.lower(&phisindy_expr::parse(text).unwrap(), |name| model.names.get(name)).unwrap()
        };
        let values = [lowered("cos(a) + 2*cos(b) - x"), lowered("sin(a) + 2*sin(b)")];
        let rates = [lowered("-sin(a)*u - 2*sin(b)*w - v"), lowered("cos(a)*u + 2*cos(b)*w")];
        let states = model.states.clone();
        let assembly = Assembly::new(&graph, &states, &states, (&values, &rates)).unwrap();
        let mut x = [0.7, 0.0, 0.0, 3.0, 0.0, 0.0];
        let free = [false, true, true, false, true, true];
        assert!(assembly.assemble(&mut x, &free, &|x| x.to_vec()));
        let b = -(0.7_f64.sin() / 2.0).asin();
        let w = -3.0 * 0.7_f64.cos() / (2.0 * b.cos());
        let expected =
            [0.7, b, 0.7_f64.cos() + 2.0 * b.cos(), 3.0, w, -3.0 * 0.7_f64.sin() - 2.0 * w * b.sin()];
        for (x, expected) in x.iter().zip(expected) {
            assert_relative_eq!(*x, expected, epsilon = 1e-12);
        }
        // A rod that is too short for its crank is nowhere.
        let mut apart = [0.7, 0.0, 9.0, 0.0, 0.0, 0.0];
        assert!(!assembly.assemble(&mut apart, &[false, true, false, false, true, true], &|x| x.to_vec()));
        assert_eq!(apart[2], 9.0);
    }
}
