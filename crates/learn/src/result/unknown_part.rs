//! The identified part of each rate as a resistance: against the velocity that it depends on where there is
//! one such velocity, else along the motion.

use super::estimate::Estimate;
use super::identified::Identified;
use phisindy_expr::{Graph, Id, Scratch, Tape};
use phisindy_phys::{Case, Origin, Record, System};
use phisindy_sim::Trajectory;

/// Points of a curve.
const POINTS: usize = 401;
/// Rows of a run that are evaluated, about: more would not show in a picture.
const ROWS: usize = 10_000;

/// The identified part of the rate of a state, taken with a minus: friction is positive where the velocity
/// is.
#[derive(Clone, Debug)]
pub struct UnknownPart {
    /// Index of the state.
    pub state: usize,
    /// The velocity against which it is described, as a node of the system's graph.
    pub velocity: Id,
    /// Whether it was multiplied by the inertia of the state.
    pub force: bool,
    /// Its values.
    pub values: PartValues,
}

/// Values of an unknown part.
#[derive(Clone, Debug)]
pub enum PartValues {
    /// A function of one velocity, over those visited: one for all records, or one for each with its name.
    Curves(Vec<(Option<String>, Curve)>),
    /// It depends on more: velocity and value along each record's run.
    Cloud(Vec<(String, Vec<(f64, f64)>)>),
}

/// A function of a velocity (SI).
#[derive(Clone, Debug, Default)]
pub struct Curve {
    /// Velocities, rising.
    pub velocity: Vec<f64>,
    /// What was identified.
    pub value: Vec<f64>,
    /// Its 95 % band; none without a covariance.
    pub band: Option<Vec<(f64, f64)>>,
    /// The truth of a synthetic record.
    pub truth: Option<Vec<f64>>,
}

/// The unknown parts of all states that have one. `scale` says whether a part is multiplied by the inertia of
/// its state, where the spec has one.
pub fn unknown_parts(case: &Case, records: &[Record], found: &Identified, scale: bool) -> Vec<UnknownPart> {
    let states = 0..case.system.states.len();
    states.filter_map(|state| Part::new(case, found, state, scale)?.described(case, records, found)).collect()
}

/// What is needed to evaluate the unknown part of one state.
struct Part<'a> {
    system: &'a System,
    graph: Graph,
    state: usize,
    /// The velocity.
    velocity: Id,
    inertia: Option<Id>,
    /// The surviving terms of this state: place among the found terms, and value per coefficient (with the
    /// inertia).
    terms: Vec<(usize, Id)>,
    /// Whether it depends on nothing but the velocity and numbers.
    alone: bool,
    /// Whether the numbers differ from record to record.
    each: bool,
}

impl<'a> Part<'a> {
    fn new(case: &'a Case, found: &Identified, state: usize, scale: bool) -> Option<Part<'a>> {
        let system = &case.system;
        let mut graph = system.graph.clone();
        let inertia = system.inertia[state].filter(|_| scale);
        let here = found.terms.iter().enumerate().filter(|(_, f)| system.terms[f.term].state == state);
        let mut terms = Vec::new();
        for (k, f) in here {
            let value = system.terms[f.term].value;
            terms.push((k, inertia.map_or(value, |m| graph.mul(m, value))));
        }
        let roots: Vec<Id> = terms.iter().map(|t| t.1).collect();
        let contacts = system.contacts.iter().map(|c| c.node);
        let own = [system.states[state].node].into_iter();
        let velocity = contacts.chain(own).find(|v| graph.reachable_above(&roots, &[*v]).contains(v))?;
        let rest = graph.reachable_above(&roots, &[velocity]);
        let moving = system.states.iter().map(|s| s.node).chain(system.inputs.iter().map(|u| u.node));
        let alone = moving.chain([system.time]).all(|id| id == velocity || !rest.contains(&id));
        let of_records = system.record_constants.iter().map(|(_, id)| *id);
        let mut own = system.parameters.iter().filter(|p| p.each).map(|p| p.node).chain(of_records);
        let each = own.any(|id| rest.contains(&id));
        Some(Part { system, graph, state, velocity, inertia, terms, alone, each })
    }

    fn described(mut self, case: &Case, records: &[Record], found: &Identified) -> Option<UnknownPart> {
        let runs: Vec<(usize, Vec<Vec<f64>>)> = (0..records.len())
            .filter_map(|r| Some((r, self.arguments(&records[r], found, r, found.records[r].run.as_ref()?))))
            .collect();
        let velocities: Vec<Vec<f64>> =
            runs.iter().map(|(_, rows)| self.evaluate(rows, self.velocity)).collect::<Option<_>>()?;
        let values = if self.alone {
            // Records with the same numbers share a curve.
            let mut groups: Vec<(Vec<f64>, Vec<usize>)> = Vec::new();
            for (k, &(r, _)) in runs.iter().enumerate() {
                let numbers = if self.each { self.numbers(&records[r], found, r) } else { vec![] };
                match groups.iter_mut().find(|(other, _)| *other == numbers) {
                    Some((_, group)) => group.push(k),
                    None => groups.push((numbers, vec![k])),
                }
            }
            let mut curves = Vec::new();
            for (_, group) in &groups {
                let grid = grid(group.iter().flat_map(|&k| &velocities[k]))?;
                let r = runs[group[0]].0;
                let name = self.each.then(|| records[r].name.clone());
                curves.push((name, self.curve(case, &records[r], found, r, grid)?));
            }
            PartValues::Curves(curves)
        } else {
            let cloud = runs.iter().zip(&velocities).map(|((r, rows), w)| {
                let mut values = vec![0.0; w.len()];
                for &(k, node) in &self.terms {
                    let value = self.evaluate(rows, node)?;
                    let c = found.terms[k].coefficient.value;
                    values.iter_mut().zip(value).for_each(|(sum, v)| *sum -= c * v);
                }
                Some((records[*r].name.clone(), w.iter().copied().zip(values).collect()))
            });
            PartValues::Cloud(cloud.collect::<Option<_>>()?)
        };
        let (velocity, force) = (self.velocity, self.inertia.is_some());
        Some(UnknownPart { state: self.state, velocity, force, values })
    }

    /// Numbers of the parameters in a record, then its constants.
    fn numbers(&self, record: &Record, found: &Identified, r: usize) -> Vec<f64> {
        let mut values = found.parameters_of(self.system, record.continues.unwrap_or(r));
        values.extend(&record.constants);
        values
    }

    /// The arguments of the system at the samples of a run.
    fn arguments(&self, record: &Record, found: &Identified, r: usize, run: &Trajectory) -> Vec<Vec<f64>> {
        let numbers = self.numbers(record, found, r);
        let row = |(i, states): (usize, &[f64])| {
            let t = record.time[i];
            let inputs = record.inputs.iter().map(|u| u.value(t));
            [t].into_iter().chain(states.iter().copied()).chain(inputs).chain(numbers.clone()).collect()
        };
        let every = record.len().div_ceil(ROWS).max(1);
        (0..record.len()).step_by(every).map(|i| row((i, run.state_at(i)))).collect()
    }

    /// The values of a node for such rows of arguments.
    fn evaluate(&self, rows: &[Vec<f64>], node: Id) -> Option<Vec<f64>> {
        let tape = Tape::compile(&self.graph, &self.system.arguments(), &[node]).ok()?;
        let mut scratch = Scratch::<1>::new(&tape);
        let values = rows.iter().map(|row| {
            scratch.at(row.iter().copied());
            scratch.output(0)[0]
        });
        Some(values.collect())
    }

    fn curve(
        &mut self,
        case: &Case,
        record: &Record,
        found: &Identified,
        r: usize,
        velocity: Vec<f64>,
    ) -> Option<Curve> {
        let numbers = self.numbers(record, found, r);
        // The part itself, and its derivatives by everything that was estimated, in the order of the
        // covariance.
        let zero = self.graph.constant(0.0);
        let mut sum = zero;
        let mut slopes = vec![zero; found.terms.len() + found.parameters.len()];
        for &(k, node) in &self.terms {
            let c = self.graph.constant(-found.terms[k].coefficient.value);
            let share = self.graph.mul(c, node);
            sum = self.graph.add(sum, share);
            slopes[k] = self.graph.neg(node);
        }
        let nodes: Vec<Id> = self.system.parameters.iter().map(|p| p.node).collect();
        let gradient = self.graph.gradient(sum, &nodes);
        let owner = record.continues.unwrap_or(r);
        for (k, p) in found.parameters.iter().enumerate() {
            if let (Some(index), true) = (p.id.constant(), p.id.holds_in(owner)) {
                slopes[found.terms.len() + k] = gradient[index];
            }
        }
        let outputs: Vec<Id> = [sum].into_iter().chain(slopes).collect();
        let rows = self.at(&self.graph, &velocity, &numbers, &outputs)?;
        let value: Vec<f64> = rows.iter().map(|row| row[0]).collect();
        let estimates: Vec<Estimate> = found
            .terms
            .iter()
            .map(|t| t.coefficient)
            .chain(found.parameters.iter().map(|p| p.estimate))
            .collect();
        let band = |row: &Vec<f64>| {
            let (below, above) = reach(&found.covariance, &estimates, &row[1..]);
            (row[0] - below, row[0] + above)
        };
        let band = (!found.covariance.is_empty()).then(|| rows.iter().map(band).collect());
        let truth = self.truth(case, r, &velocity, &numbers);
        Some(Curve { velocity, value, band, truth })
    }

    /// What the data were made of, if it depends on the same velocity alone.
    fn truth(&self, case: &Case, r: usize, velocity: &[f64], numbers: &[f64]) -> Option<Vec<f64>> {
        let Origin::Synthetic(made) = &case.records[r].origin else { return None };
        // The graph of the truth has grown from that of the system: the nodes of the system are nodes of it.
        let mut graph = made.truth.graph.clone();
        let extra = made.extra[self.state];
        let root = self.inertia.map_or(extra, |m| graph.mul(m, extra));
        let rows = self.at(&graph, velocity, numbers, &[root])?;
        Some(rows.iter().map(|row| -row[0]).collect())
    }

    /// Functions of the velocity, for numbers of one record.
    fn at(&self, graph: &Graph, velocity: &[f64], numbers: &[f64], roots: &[Id]) -> Option<Vec<Vec<f64>>> {
        let parameters = self.system.parameters.iter().map(|p| p.node);
        let constants = self.system.record_constants.iter().map(|&(_, node)| node);
        let inputs: Vec<Id> = [self.velocity].into_iter().chain(parameters).chain(constants).collect();
        let tape = Tape::compile(graph, &inputs, roots).ok()?;
        let mut scratch = Scratch::<1>::new(&tape);
        let rows = velocity.iter().map(|&w| {
            scratch.at([w].into_iter().chain(numbers.iter().copied()));
            (0..roots.len()).map(|k| scratch.output(k)[0]).collect()
        });
        Some(rows.collect())
    }
}

/// Velocities over those visited, close to each other near zero, where friction has its shape.
fn grid<'v>(visited: impl Iterator<Item = &'v f64>) -> Option<Vec<f64>> {
    let finite = visited.filter(|v| v.is_finite());
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
    let largest = low.abs().max(high.abs());
    if low >= high {
        return None;
    }
    let place = |k: usize| largest * (2.0 * k as f64 / (POINTS - 1) as f64 - 1.0).powi(3);
    let inside = (0..POINTS).map(place).filter(|v| *v > low && *v < high);
    Some([low].into_iter().chain(inside).chain([high]).collect())
}

/// How far a 95 % band reaches below and above a number with these derivatives by what was estimated: each of
/// `numbers` moves as far as its own interval goes, and they move together as their covariance says. So the
/// band of a single number is its interval. What the data do not determine does not enter if the number does
/// not depend on it.
fn reach(covariance: &[Vec<f64>], numbers: &[Estimate], slopes: &[f64]) -> (f64, f64) {
    let used: Vec<usize> = (0..slopes.len()).filter(|&k| slopes[k] != 0.0).collect();
    let correlation = |i: usize, j: usize| {
        if i == j { 1.0 } else { covariance[i][j] / (covariance[i][i] * covariance[j][j]).sqrt() }
    };
    let side = |upwards: bool| {
        let move_of = |&k: &usize| {
            let Estimate { value, ci95: (low, high), .. } = numbers[k];
            slopes[k] * if (slopes[k] > 0.0) == upwards { high - value } else { value - low }
        };
        let moves: Vec<f64> = used.iter().map(move_of).collect();
        let row = |(a, &i): (usize, &usize)| {
            used.iter().enumerate().map(|(b, &j)| moves[a] * correlation(i, j) * moves[b]).sum::<f64>()
        };
        used.iter().enumerate().map(row).sum::<f64>().max(0.0).sqrt()
    };
    (side(false), side(true))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A profile interval need not be symmetric, and is wider than the covariance alone says: the band of a
    /// coefficient is its interval, and that of its negative the same turned round.
    #[test]
    fn the_band_of_one_coefficient_is_its_interval() {
        let wide = Estimate { value: 2.0, std_error: 0.1, ci95: (1.7, 2.5) };
        let blind =
            Estimate { value: 0.0, std_error: f64::INFINITY, ci95: (f64::NEG_INFINITY, f64::INFINITY) };
        let covariance = vec![vec![0.01, 0.0], vec![0.0, f64::INFINITY]];
        let of = |slopes: [f64; 2]| reach(&covariance, &[wide, blind], &slopes);
        let (below, above) = of([1.0, 0.0]);
        assert!((below - 0.3).abs() < 1e-12 && (above - 0.5).abs() < 1e-12, "{below} {above}");
        let (below, above) = of([-2.0, 0.0]);
        assert!((below - 1.0).abs() < 1e-12 && (above - 0.6).abs() < 1e-12, "{below} {above}");
    }

    /// Two equal numbers that move against each other: their sum is known, their difference is not.
    #[test]
    fn what_trades_off_cancels_in_the_band() {
        let number = Estimate::normal(1.0, 0.1);
        let covariance = vec![vec![0.01, -0.01], vec![-0.01, 0.01]];
        let of = |slopes: [f64; 2]| reach(&covariance, &[number; 2], &slopes).1;
        assert!(of([1.0, 1.0]) < 1e-9);
        assert!((of([1.0, -1.0]) - 2.0 * (number.ci95.1 - 1.0)).abs() < 1e-12);
    }
}
