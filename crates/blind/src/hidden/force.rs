//! Forces as text: their values along a motion, and whether two have the same form.

use super::effect::{Action, Effect};
use super::motion::{Experiment, Motion};
use super::place::Place;
use super::rig::Rig;
use faer::Mat;
use faer::linalg::solvers::Solve;
use phisindy_expr::{Graph, Names, Scratch, Symbol, Tape, parse};

/// Points at which forms are compared.
const POINTS: usize = 400;
/// Two expressions are one where the numbers of one make it the other to this part of its size.
const SAME: f64 = 1e-4;
/// An exponent within this is the same.
const EXPONENT: f64 = 0.03;
/// Any other number may differ by this part and still be that of the same term.
const NUMBER: f64 = 0.5;
/// Steps of the fit of the numbers.
const STEPS: usize = 100;

/// Texts over variables, ready to be evaluated.
pub(super) struct Force {
    scratch: Scratch<1>,
}

impl Force {
    /// A text over these names, in this order; `None` if it is no expression of them.
    pub(super) fn new(text: &str, variables: &[&str]) -> Option<Force> {
        Force::several(&[text], variables)
    }

    /// Texts over these names; `None` if one is no expression of them.
    pub(super) fn several(texts: &[&str], variables: &[&str]) -> Option<Force> {
        let (mut graph, mut names) = (Graph::default(), Names::default());
        let symbols: Vec<Symbol> = variables.iter().map(|name| names.intern(name)).collect();
        let inputs: Vec<_> = symbols.into_iter().map(|symbol| graph.symbol(symbol)).collect();
        let mut root = |text: &&str| graph.lower(&parse(text).ok()?, |name| names.get(name)).ok();
        let roots: Vec<_> = texts.iter().map(&mut root).collect::<Option<_>>()?;
        let tape = Tape::compile(&graph, &inputs, &roots).ok()?;
        Some(Force { scratch: Scratch::new(&tape) })
    }

    /// The value of the first at these values of the variables.
    pub(super) fn at(&mut self, values: impl IntoIterator<Item = f64>) -> f64 {
        self.scratch.at(values).output(0)[0]
    }

    /// The value of text `k` at the variables of the last call of `at`.
    pub(super) fn output(&self, k: usize) -> f64 {
        self.scratch.output(k)[0]
    }
}

/// The sum of forces on each mass along a motion; `None` if a text is no expression of the states, the moved wall and the time.
pub(super) fn on_masses(
    rig: &Rig,
    forces: &[Effect],
    motion: &Motion,
    experiment: &Experiment,
) -> Option<Vec<Vec<f64>>> {
    let times = &experiment.times;
    let mut out = vec![vec![0.0; times.len()]; rig.count()];
    let names: Vec<&str> = rig.x.iter().chain(&rig.v).map(String::as_str).chain(["u", "du", "t"]).collect();
    for effect in forces {
        let Action::Force { place, force, .. } = &effect.action else { return None };
        let mut force = Force::new(&effect.written(force, false), &names)?;
        for (i, &t) in times.iter().enumerate() {
            let states = (0..2 * rig.count()).map(|k| motion.states[k][i]);
            let (u, du) = Rig::drive_at(&experiment.lines, t);
            let value = force.at(states.chain([u, du, t]));
            place.parts.iter().for_each(|&(mass, sign)| out[mass][i] += sign * value);
        }
    }
    Some(out)
}

/// The force on each mass that the known part lacks along a motion: what it subtracts.
pub(super) fn missing(rig: &Rig, motion: &Motion, experiment: &Experiment) -> Vec<Vec<f64>> {
    let masses = rig.count();
    let mut out = vec![Vec::new(); masses];
    for (i, &t) in experiment.times.iter().enumerate() {
        let known = rig.acceleration(&|k| motion.states[k][i], Rig::drive_at(&experiment.lines, t));
        (0..masses).for_each(|m| out[m].push((known[m] - motion.rates[masses + m][i]) * rig.mass[m]));
    }
    out
}

/// The error of forces against others along a motion, rms over rms, without the samples at which something
/// sticks: there friction is what holds.
pub(super) fn error(found: &[Vec<f64>], due: &[Vec<f64>], stuck: &[bool]) -> f64 {
    let (mut miss, mut size) = (0.0, 0.0);
    for (found, due) in found.iter().zip(due) {
        for ((f, d), _) in found.iter().zip(due).zip(stuck).filter(|(_, stuck)| !**stuck) {
            miss += (f - d) * (f - d);
            size += d * d;
        }
    }
    (miss / size).sqrt()
}

/// Whether numbers can be put into the true law so that it is the found text: the same form, however it is
/// written. `states`: displacement and velocity of the place.
pub(super) fn same_form(truth: &Effect, place: &Place, found: &str, states: &[(f64, f64)]) -> bool {
    let Action::Force { force: text, .. } = &truth.action else { return false };
    // At the place, displacement and velocity are the variables of both.
    let found = found.replace(' ', "");
    let bare = |name: &str| name.trim_matches(|c| c == '(' || c == ')').to_owned();
    let at_place = found
        .replace(&format!("({})", bare(&place.x)), "(X)")
        .replace(&format!("({})", bare(&place.v)), "(Y)");
    let at_place = crate::names::substitute(&at_place, |name| {
        if name == place.x {
            Some("X")
        } else if name == place.v {
            Some("Y")
        } else {
            None
        }
    });
    let variables: Vec<&str> =
        ["X", "Y"].into_iter().chain(truth.parameters.iter().map(|(name, _)| *name)).collect();
    let Some(mut template) = Force::new(text, &variables) else { return false };
    let top = states.iter().fold(0.0_f64, |m, (_, v)| m.max(v.abs()));
    let every = (states.len() / POINTS).max(1);
    let points: Vec<(f64, f64)> =
        states.iter().copied().filter(|(_, v)| v.abs() > 1e-6 * top).step_by(every).collect();
    let exponent = |name: &str| text.contains(&format!("^{name}"));
    [at_place.clone(), with_plain_exponents(&at_place)].iter().any(|text| {
        let Some(mut found) = Force::new(text, &["X", "Y"]) else { return false };
        let due: Vec<f64> = points.iter().map(|&(x, v)| found.at([x, v])).collect();
        let start: Vec<f64> = truth.parameters.iter().map(|(_, value)| *value).collect();
        let Some(numbers) = fitted(&mut template, &points, &due, &start) else { return false };
        let near = |k: usize| {
            let most = if exponent(truth.parameters[k].0) { EXPONENT } else { NUMBER };
            (numbers[k] - start[k]).abs() <= most * start[k].abs()
        };
        (0..start.len()).all(near)
    })
}

/// The numbers with which a template is the given values, by damped least squares (Marquardt 1963, doi
/// 10.1137/0111030); `None` if there are none.
fn fitted(template: &mut Force, points: &[(f64, f64)], due: &[f64], start: &[f64]) -> Option<Vec<f64>> {
    let size = due.iter().map(|d| d * d).sum::<f64>().sqrt();
    let mut misses = |numbers: &[f64]| -> Vec<f64> {
        let value = |(&(x, v), d): (&(f64, f64), &f64)| {
            (template.at([x, v].into_iter().chain(numbers.iter().copied())) - d) / size
        };
        points.iter().zip(due).map(value).collect()
    };
    let cost = |misses: &[f64]| misses.iter().map(|m| m * m).sum::<f64>();
    let (mut numbers, mut damping) = (start.to_vec(), 1e-3);
    let mut now = misses(&numbers);
    for _ in 0..STEPS {
        if cost(&now).sqrt() < SAME {
            return Some(numbers);
        }
        let columns: Vec<Vec<f64>> = (0..numbers.len())
            .map(|k| {
                let mut off = numbers.clone();
                let by = 1e-6 * off[k].abs().max(1e-9 * start[k].abs());
                off[k] += by;
                // In units of the number itself.
                misses(&off).iter().zip(&now).map(|(a, b)| (a - b) / by * start[k]).collect()
            })
            .collect();
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let n = numbers.len();
        let normal = Mat::from_fn(n, n, |i, j| {
            product(&columns[i], &columns[j]) * if i == j { 1.0 + damping } else { 1.0 }
        });
        let right = Mat::from_fn(n, 1, |i, _| -product(&columns[i], &now));
        let step = normal.llt(faer::Side::Lower).ok()?.solve(&right);
        let next: Vec<f64> = (0..n).map(|k| numbers[k] + step[(k, 0)] * start[k]).collect();
        let there = misses(&next);
        if cost(&there) < cost(&now) {
            (numbers, now, damping) = (next, there, damping * 0.1);
        } else {
            damping *= 10.0;
        }
    }
    (cost(&now).sqrt() < SAME).then_some(numbers)
}

/// A text whose exponents within [`EXPONENT`] of a half are that half.
fn with_plain_exponents(text: &str) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some(at) = rest.find('^') {
        out += &rest[..=at];
        rest = &rest[at + 1..];
        let end = rest.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(rest.len());
        let plain = rest[..end].parse::<f64>().ok().map(|p| (p, (2.0 * p).round() / 2.0));
        match plain {
            Some((p, half)) if (p - half).abs() <= EXPONENT * half => out += &half.to_string(),
            _ => out += &rest[..end],
        }
        rest = &rest[end..];
    }
    out + rest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dice::Dice;
    use crate::hidden::{effect::Scales, never, place::places};

    /// A law of the table against texts of the program.
    fn same(name: &str, found: &str) -> bool {
        let mut dice = Dice::new(1, "form");
        let rig = Rig::draw(&mut dice, false, false);
        let mut place = places(&rig).swap_remove(0);
        (place.x, place.v) = ("x".to_owned(), "v".to_owned());
        let scales = Scales { x: 1.0, v: 1.0, force: 1.0, time: 10.0 };
        let effect = never::draw(name, &place, scales, &mut dice).expect("a law");
        let states: Vec<(f64, f64)> = (0..500)
            .map(|k| (f64::from(k) * 0.13).sin())
            .zip((0..500).map(|k| (f64::from(k) * 0.31).cos()))
            .collect();
        // Its first number is a coefficient.
        let found = found.replace("A*", &format!("{:e}*", effect.parameters[0].1));
        let text = found.replace(
            "TRUTH",
            &effect.written(
                match &effect.action {
                    Action::Force { force, .. } => force,
                    _ => "0",
                },
                false,
            ),
        );
        same_form(&effect, &place, &text, &states)
    }

    #[test]
    fn forms_are_compared_whatever_way_they_are_written() {
        assert!(same("hertzian-spring", "1.1*(TRUTH)"));
        assert!(same("hertzian-spring", "A*sgn(x)*abs(x)^1.48"));
        assert!(!same("hertzian-spring", "A*sgn(x)*abs(x)^1.7"));
        assert!(!same("tanh-damper", "0.2*atan(v/0.2)"));
        assert!(same("tanh-damper", "1.02*(TRUTH)"));
        assert!(!same("tanh-damper", "TRUTH + 0.001*x^3"));
        assert!(same("abs-displacement-damper", "A*abs(x)*v"));
        assert!(!same("abs-displacement-damper", "0.7*x^2*v"));
    }

    #[test]
    fn exponents_near_a_half_are_that_half() {
        assert_eq!(with_plain_exponents("2*abs(v)^1.4971*sgn(v) + x^3"), "2*abs(v)^1.5*sgn(v) + x^3");
        assert_eq!(with_plain_exponents("abs(v)^1.7"), "abs(v)^1.7");
    }
}
