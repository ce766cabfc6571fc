//! The front of misfit against length: sums of shapes by a forward selection in the linear response.
//!
//! Description length (Rissanen 1978, doi 10.1016/0005-1098(78)90005-5), in units of twice the natural
//! logarithm as BIC has it: the misfit of the response, `ln n` for each number, and for the expression itself
//! the logarithm of the number of expressions with as many symbols: `2 ln S` for each symbol of an alphabet
//! of `S`. That is also the price of the search, for no more expressions of a length than these were tried.

use super::atom::Inner;
use super::scale::Scale;
use super::scope::Scope;
use super::shape::{Program, Shape, Term, shapes};
use crate::decisions::{FORMULA_ALPHABET, FORMULA_BEAM, FORMULA_REFINED, FORMULA_SINGLES, FORMULA_TERMS};
use crate::model::TrialModel;
use crate::screen::{Kinematics, PartialRegression, Response, dot, norm, subtract};
use phisindy_sim::Stop;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// A sum of terms at a place, with its numbers from the response.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    pub(super) terms: Vec<Term>,
    pub(super) coefficients: Vec<f64>,
    /// Description length less that of nothing.
    pub(super) length: f64,
    /// The misfit beyond that of the noise, in the same units.
    pub(super) excess: f64,
    /// The movable constants beside it.
    pub(super) beside: Vec<(String, f64)>,
}

/// The shapes of a place, compiled, and the scales of its motion.
pub(super) struct Grammar {
    pub(super) shapes: Vec<Shape>,
    programs: Vec<Program>,
    pub(super) scales: [Scale; 2],
    /// Most terms of a sum.
    terms: usize,
}

impl Grammar {
    pub(super) fn new(at: &Kinematics, scope: &Scope) -> Grammar {
        let scales = [Scale::new(&at.displacement), Scale::new(&at.velocity)];
        let all = shapes(at.has_displacement() && scope.displacement).into_iter();
        let all = all.filter(|s| s.velocity.is_none() || scope.velocity);
        let all = all.filter(|s| s.is_linear() || !scope.linear);
        let (shapes, programs) = all.filter_map(|s| Some((s, Program::new(s, &scales)?))).unzip();
        Grammar { shapes, programs, scales, terms: if scope.linear { 1 } else { FORMULA_TERMS } }
    }

    fn force(&self, at: &Kinematics, shape: usize, inner: &[f64]) -> Vec<Vec<f64>> {
        let of = |(x, v): (&Vec<f64>, &Vec<f64>)| self.programs[shape].evaluate(x, v, inner);
        at.displacement.iter().zip(&at.velocity).map(of).collect()
    }
}

/// A column of the selection.
struct Column {
    shape: usize,
    inner: Vec<f64>,
    /// Of unit size.
    rows: Vec<f64>,
}

/// A selection at a place. Where the place rests there are two: with friction that holds it, and without.
pub(super) struct Selection<'a> {
    regression: &'a PartialRegression,
    at: &'a Kinematics,
    grammar: &'a Grammar,
    stop: &'a Stop,
    sticks: bool,
    /// The response to the holding force, of unit size, projected out.
    holding: Option<Vec<f64>>,
    target: Vec<f64>,
    /// Rows that count.
    rows: f64,
}

/// Columns chosen, and what they gain with their numbers.
#[derive(Clone)]
struct Set {
    at: Vec<usize>,
    gain: f64,
    length: f64,
}

impl<'a> Selection<'a> {
    pub(super) fn new(
        regression: &'a PartialRegression,
        at: &'a Kinematics,
        grammar: &'a Grammar,
        model: &'a TrialModel,
        sticks: bool,
    ) -> Option<Selection<'a>> {
        let mut target = regression.target().to_vec();
        let holding = if sticks {
            let rows = regression.holding(at, &model.system)?.rows;
            let size = norm(&rows);
            Some(rows.iter().map(|v| v / size).collect::<Vec<f64>>())
        } else {
            None
        };
        let rows = target.len() as f64;
        if let Some(h) = &holding {
            project(&mut target, h);
        }
        Some(Selection { regression, at, grammar, stop: &model.stop, sticks, holding, target, rows })
    }

    /// The best sums, shortest description first, with refined numbers.
    pub(super) fn best(&self) -> Vec<Entry> {
        let columns = self.columns();
        if columns.is_empty() {
            return vec![];
        }
        let right: Vec<f64> = columns.iter().map(|c| dot(&c.rows, &self.target)).collect();
        let mut gram = Gram { rows: vec![None; columns.len()] };
        let mut kept: BTreeMap<Vec<usize>, Set> = BTreeMap::new();
        // The best columns of each shape, then each with any other column, then the best of these with one
        // more.
        let mut beam = self.singles(&columns, &right);
        kept.extend(self.by_shapes(&beam, &columns));
        for _ in 1..self.grammar.terms {
            if self.stop.requested() {
                return vec![];
            }
            gram.fill(&beam, &columns);
            let grown: Vec<Vec<Set>> =
                beam.par_iter().map(|set| self.grown(set, &columns, &gram, &right)).collect();
            let grown: Vec<Set> = grown.into_iter().flatten().collect();
            let next = self.by_shapes(&grown, &columns);
            beam = next.iter().map(|(_, set)| set.clone()).collect();
            kept.extend(next);
        }
        let mut all: Vec<Set> = kept.into_values().collect();
        if self.sticks {
            all.retain(|set| set.at.iter().any(|&k| self.grammar.programs[columns[k].shape].sticks));
        }
        let mut found: Vec<Entry> = shortest(all, FORMULA_REFINED, |set| set.at.len(), |set| set.length)
            .par_iter()
            .filter_map(|set| if self.stop.requested() { None } else { self.refined(set, &columns) })
            .collect();
        found.sort_by(|a, b| a.length.total_cmp(&b.length));
        found
    }

    /// The columns that gain most of each shape, as sets of one.
    fn singles(&self, columns: &[Column], right: &[f64]) -> Vec<Set> {
        let mut by: Vec<usize> = (0..columns.len()).collect();
        by.sort_by(|&a, &b| {
            columns[a].shape.cmp(&columns[b].shape).then(right[b].abs().total_cmp(&right[a].abs()))
        });
        let of = |own: &[usize]| -> Vec<Set> {
            let one = |&k: &usize| {
                let gain = right[k].powi(2);
                Set { at: vec![k], gain, length: self.length(gain, [columns[k].shape].into_iter()) }
            };
            own.iter().take(FORMULA_SINGLES).map(one).collect()
        };
        by.chunk_by(|&a, &b| columns[a].shape == columns[b].shape).flat_map(of).collect()
    }

    /// The best sets of different shapes, by these: of the same shapes with other inner numbers the best one
    /// counts.
    fn by_shapes(&self, sets: &[Set], columns: &[Column]) -> Vec<(Vec<usize>, Set)> {
        let mut best: BTreeMap<Vec<usize>, &Set> = BTreeMap::new();
        for set in sets {
            let mut key: Vec<usize> = set.at.iter().map(|&k| columns[k].shape).collect();
            key.sort_unstable();
            if best.get(&key).is_none_or(|other| set.length < other.length) {
                best.insert(key, set);
            }
        }
        let mut next: Vec<(Vec<usize>, Set)> = best.into_iter().map(|(k, s)| (k, s.clone())).collect();
        next.sort_by(|a, b| a.1.length.total_cmp(&b.1.length));
        next.truncate(FORMULA_BEAM);
        next
    }

    /// The columns of all shapes over their grids.
    fn columns(&self) -> Vec<Column> {
        let grammar = self.grammar;
        // Friction that holds is in the selection with friction alone.
        let rests = self.at.rested();
        let own = |shape: &usize| self.sticks || !rests || !grammar.programs[*shape].sticks;
        let all: Vec<(usize, Vec<f64>)> = (0..grammar.shapes.len())
            .filter(own)
            .flat_map(|k| grammar.shapes[k].grid(&grammar.scales).into_iter().map(move |g| (k, g)))
            .collect();
        let of = |(shape, inner): &(usize, Vec<f64>)| {
            let rows = self.response(*shape, inner)?.rows;
            let size = norm(&rows);
            let rows = rows.iter().map(|v| v / size).collect();
            (size > 0.0).then(|| Column { shape: *shape, inner: inner.clone(), rows })
        };
        all.par_iter().map(of).collect::<Vec<_>>().into_iter().flatten().collect()
    }

    fn response(&self, shape: usize, inner: &[f64]) -> Option<Response> {
        let force = self.grammar.force(self.at, shape, inner);
        let mut out = self.regression.response(self.at, &force, self.sticks)?;
        if let Some(h) = &self.holding {
            project(&mut out.rows, h);
        }
        Some(out)
    }

    /// A set with one more column of each shape, the one that gains most.
    fn grown(&self, set: &Set, columns: &[Column], gram: &Gram, right: &[f64]) -> Vec<Set> {
        // Cholesky of the set's Gram matrix, then one more row for each column.
        let m = set.at.len();
        let mut l = vec![vec![0.0; m]; m];
        for i in 0..m {
            for j in 0..=i {
                let sum: f64 = (0..j).map(|k| l[i][k] * l[j][k]).sum();
                let g = gram.entry(set.at[i], set.at[j]) - sum;
                l[i][j] = if i == j { g.max(1e-12).sqrt() } else { g / l[j][j] };
            }
        }
        let solved = |of: &dyn Fn(usize) -> f64| -> Vec<f64> {
            let mut y = vec![0.0; m];
            for i in 0..m {
                y[i] = (of(i) - (0..i).map(|k| l[i][k] * y[k]).sum::<f64>()) / l[i][i];
            }
            y
        };
        let y = solved(&|i| right[set.at[i]]);
        let own = dot(&y, &y);
        let mut out: BTreeMap<usize, Set> = BTreeMap::new();
        for j in 0..columns.len() {
            let shape = columns[j].shape;
            // A shape without inner numbers enters once.
            let twice = set.at.iter().any(|&k| columns[k].shape == shape) && columns[j].inner.is_empty();
            if twice {
                continue;
            }
            let w = solved(&|i| gram.entry(set.at[i], j));
            let rest = 1.0 - dot(&w, &w);
            if rest < COLLINEAR {
                continue;
            }
            let gain = own + (right[j] - dot(&w, &y)).powi(2) / rest;
            if out.get(&shape).is_none_or(|other| gain > other.gain) {
                let at: Vec<usize> = set.at.iter().copied().chain([j]).collect();
                let length = self.length(gain, at.iter().map(|&k| columns[k].shape));
                out.insert(shape, Set { at, gain, length });
            }
        }
        out.into_values().collect()
    }

    /// The misfit that is left where this is gained.
    fn left(&self, gain: f64) -> f64 {
        self.cost((dot(&self.target, &self.target) - gain).max(0.0))
    }

    /// The misfit of a chi square: beyond the noise it sets the scatter itself.
    fn cost(&self, chi2: f64) -> f64 {
        let ratio = chi2 / self.rows;
        if ratio > 1.0 { self.rows * (1.0 + ratio.ln()) } else { chi2 }
    }

    /// The description length of a sum of shapes that gains this, less that of nothing.
    fn length(&self, gain: f64, of: impl Iterator<Item = usize>) -> f64 {
        let before = dot(self.regression.target(), self.regression.target());
        let (mut numbers, mut symbols, mut terms) = (0, 0, 0);
        for shape in of {
            numbers += 1 + self.grammar.shapes[shape].inner().len();
            symbols += self.grammar.programs[shape].symbols;
            terms += 1;
        }
        let symbols = symbols + terms.max(1) - 1;
        self.left(gain) - self.cost(before) + numbers as f64 * self.rows.ln() + structure(symbols)
    }

    /// A set with its inner numbers refined, each between its neighbours on the grid: the outer numbers are
    /// solved for (variable projection, Golub and Pereyra 1973, doi 10.1137/0710036).
    fn refined(&self, set: &Set, columns: &[Column]) -> Option<Entry> {
        let mut own = set.at.clone();
        own.sort_by_key(|&k| columns[k].shape);
        let mut shapes: Vec<usize> = own.iter().map(|&k| columns[k].shape).collect();
        let mut inner: Vec<Vec<f64>> = own.iter().map(|&k| columns[k].inner.clone()).collect();
        let mut responses: Vec<Response> =
            shapes.iter().zip(&inner).map(|(&s, g)| self.response(s, g)).collect::<Option<_>>()?;
        let (mut gain, _) = self.solved(&responses)?;
        for sweep in 0..SWEEPS {
            for k in 0..shapes.len() {
                let shape = self.grammar.shapes[shapes[k]];
                let coarse = shape.displacement.is_some() && shape.velocity.is_some();
                for (j, (quantity, kind)) in shape.inner().into_iter().enumerate() {
                    let scale = &self.grammar.scales[quantity];
                    let reach = scale.step(kind, inner[k][j], coarse) / 4f64.powi(sweep);
                    let within = scale.within(kind);
                    let mut trial = |value: f64| -> Option<(f64, Response)> {
                        let mut own = inner[k].clone();
                        own[j] = value.clamp(within.0, within.1);
                        let response = self.response(shapes[k], &own)?;
                        let before = std::mem::replace(&mut responses[k], response);
                        let gain = self.solved(&responses).map(|(gain, _)| gain);
                        let response = std::mem::replace(&mut responses[k], before);
                        Some((gain?, response))
                    };
                    let best = golden(inner[k][j], reach, gain, kind, &mut trial);
                    if let Some((value, better, response)) = best {
                        inner[k][j] = value.clamp(within.0, within.1);
                        gain = better;
                        responses[k] = response;
                    }
                }
            }
        }
        let (gain, coefficients) = self.solved(&responses)?;
        let length = self.length(gain, shapes.iter().copied());
        let forces: Vec<(f64, &Response)> = coefficients.iter().copied().zip(&responses).collect();
        let beside = self.regression.beside(&forces);
        let terms = shapes
            .drain(..)
            .zip(inner)
            .map(|(s, inner)| Term { shape: self.grammar.shapes[s], inner })
            .collect();
        let excess = (self.left(gain) - self.rows).max(0.0);
        Some(Entry { terms, coefficients, length, excess, beside })
    }

    /// Gain and coefficients of a least-squares fit of the target.
    fn solved(&self, responses: &[Response]) -> Option<(f64, Vec<f64>)> {
        let m = responses.len();
        let sizes: Vec<f64> = responses.iter().map(|r| norm(&r.rows)).collect();
        let mut l = vec![vec![0.0; m]; m];
        let mut y = vec![0.0; m];
        for i in 0..m {
            for j in 0..=i {
                let g = dot(&responses[i].rows, &responses[j].rows) / (sizes[i] * sizes[j]);
                let g = g - (0..j).map(|k| l[i][k] * l[j][k]).sum::<f64>();
                if i == j && g < COLLINEAR {
                    return None;
                }
                l[i][j] = if i == j { g.sqrt() } else { g / l[j][j] };
            }
            let b = dot(&responses[i].rows, &self.target) / sizes[i];
            y[i] = (b - (0..i).map(|k| l[i][k] * y[k]).sum::<f64>()) / l[i][i];
        }
        let gain = dot(&y, &y);
        let mut c = vec![0.0; m];
        for i in (0..m).rev() {
            c[i] = (y[i] - (i + 1..m).map(|k| l[k][i] * c[k]).sum::<f64>()) / l[i][i];
        }
        c.iter_mut().zip(&sizes).for_each(|(c, s)| *c /= s);
        (gain.is_finite() && c.iter().all(|c| c.is_finite())).then_some((gain, c))
    }
}

/// What is left of a column beside others, below which it is one of them.
const COLLINEAR: f64 = 1e-7;
/// Sweeps over the inner numbers.
const SWEEPS: i32 = 2;
/// Evaluations of one number in a sweep.
const EVALUATIONS: usize = 7;

/// The price of an expression with this many symbols.
pub(super) fn structure(symbols: usize) -> f64 {
    2.0 * symbols as f64 * (FORMULA_ALPHABET as f64).ln()
}

/// The largest gain within `reach` of a value by golden section; `None` if none is larger than `gain`.
fn golden(
    value: f64,
    reach: f64,
    gain: f64,
    kind: Inner,
    trial: &mut dyn FnMut(f64) -> Option<(f64, Response)>,
) -> Option<(f64, f64, Response)> {
    let part = 0.5 * (5f64.sqrt() - 1.0);
    // Sizes and rates on a scale of logarithms: they keep their sign.
    let log = matches!(kind, Inner::Size | Inner::Rate) && value != 0.0;
    let (from, to) = if log {
        let reach = (1.0 + reach / value.abs()).ln();
        (value.abs().ln() - reach, value.abs().ln() + reach)
    } else {
        (value - reach, value + reach)
    };
    let back = |u: f64| if log { u.exp().copysign(value) } else { u };
    let (mut low, mut high) = (from, to);
    let mut best: Option<(f64, f64, Response)> = None;
    let mut at = |u: f64, best: &mut Option<(f64, f64, Response)>| -> f64 {
        let Some((found, response)) = trial(back(u)) else { return f64::NEG_INFINITY };
        if found > best.as_ref().map_or(gain, |b| b.1) {
            *best = Some((back(u), found, response));
        }
        found
    };
    let (mut a, mut b) = (high - part * (high - low), low + part * (high - low));
    let (mut at_a, mut at_b) = (at(a, &mut best), at(b, &mut best));
    for _ in 2..EVALUATIONS {
        if at_a > at_b {
            (high, b, at_b) = (b, a, at_a);
            a = high - part * (high - low);
            at_a = at(a, &mut best);
        } else {
            (low, a, at_a) = (a, b, at_b);
            b = low + part * (high - low);
            at_b = at(b, &mut best);
        }
    }
    best
}

/// Rows of the Gram matrix, as they are needed.
struct Gram {
    rows: Vec<Option<Vec<f64>>>,
}

impl Gram {
    /// Fills the rows of the columns of these sets.
    fn fill(&mut self, sets: &[Set], columns: &[Column]) {
        let mut wanted: Vec<usize> = sets.iter().flat_map(|set| set.at.iter().copied()).collect();
        wanted.sort_unstable();
        wanted.dedup();
        wanted.retain(|&k| self.rows[k].is_none());
        let row =
            |&k: &usize| -> Vec<f64> { columns.iter().map(|c| dot(&columns[k].rows, &c.rows)).collect() };
        let found: Vec<Vec<f64>> = wanted.par_iter().map(row).collect();
        wanted.into_iter().zip(found).for_each(|(k, row)| self.rows[k] = Some(row));
    }

    /// Of a column whose row is filled, and any other.
    fn entry(&self, i: usize, j: usize) -> f64 {
        self.rows[i].as_ref().map_or(0.0, |row| row[j])
    }
}

/// The shortest of each number of terms in turn, so that no number of terms crowds out the others.
pub(super) fn shortest<T>(
    mut all: Vec<T>,
    count: usize,
    terms: impl Fn(&T) -> usize,
    length: impl Fn(&T) -> f64,
) -> Vec<T> {
    all.sort_by(|a, b| length(a).total_cmp(&length(b)));
    let mut ranked: Vec<(usize, usize, T)> = Vec::with_capacity(all.len());
    let mut seen: BTreeMap<usize, usize> = BTreeMap::new();
    for (k, one) in all.into_iter().enumerate() {
        let rank = seen.entry(terms(&one)).or_insert(0);
        ranked.push((*rank, k, one));
        *rank += 1;
    }
    ranked.sort_by_key(|(rank, k, _)| (*rank, *k));
    ranked.into_iter().take(count).map(|(_, _, one)| one).collect()
}

/// Takes out of rows their part along a column of unit size.
pub(super) fn project(rows: &mut [f64], along: &[f64]) {
    let part = dot(along, rows);
    subtract(rows, part, along);
}
