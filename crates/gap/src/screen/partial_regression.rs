//! The linear regression in which any force can be tried: the motion at a place, the linear response to a
//! force there, and the free columns that are projected out of it (Frisch, Waugh and Lovell).

use super::free_columns::{FreeColumns, Movable};
use super::regression_data::{Base, RegressionData};
use super::target::Target;
use super::trial::holding_rates;
use crate::decisions::FORMULA_ROWS;
use crate::evaluate::evaluated;
use crate::model::TrialModel;
use crate::place::{Place, Site, entered_nodes};
use phisindy_expr::{Tape, wide};
use phisindy_learn::Calibration;
use phisindy_phys::System;
use phisindy_phys::spec::Role;

/// What is left of a column, as a fraction of it, below which the free columns explain it.
const EXPLAINED_BY_FREE: f64 = 1e-4;

/// The records of a model, ready for the responses to forces.
pub(crate) struct PartialRegression {
    data: Vec<RegressionData>,
    /// Rows of a record and column that are averaged to one.
    block: usize,
    /// Orthonormal columns that span what is projected out, and what makes the free columns of them.
    basis: Vec<Vec<f64>>,
    triangle: Vec<Vec<f64>>,
    movable: Vec<Movable>,
    /// What the known part leaves, in units of the noise, without its projection; and its part along the
    /// basis.
    target: Vec<f64>,
    along: Vec<f64>,
}

/// The motion at a place, in each record.
pub(crate) struct Kinematics {
    /// The states whose rates a force there changes, each with what it is of the speed of the place.
    acts: Vec<(usize, f64)>,
    shows: Vec<(usize, f64)>,
    place: Place,
    /// Displacement (empty where there is none) and velocity at each sample, by record.
    pub(crate) displacement: Vec<Vec<f64>>,
    pub(crate) velocity: Vec<Vec<f64>>,
    /// The rate that unit force gives each body, by record.
    unit: Vec<Vec<Vec<f64>>>,
    /// Where the place rests, by record.
    rests: Vec<Vec<bool>>,
}

impl Kinematics {
    /// Whether it comes to rest.
    pub(crate) fn rested(&self) -> bool {
        self.rests.iter().flatten().any(|r| *r)
    }

    /// The rate that unit force gives the first body, by record and sample.
    pub(crate) fn units(&self) -> impl Iterator<Item = &[f64]> {
        self.unit.iter().filter_map(|of| of.first().map(Vec::as_slice))
    }

    pub(crate) fn has_displacement(&self) -> bool {
        self.displacement.iter().all(|x| !x.is_empty())
    }
}

/// A response without what the free columns explain of it.
pub(crate) struct Response {
    /// What is left.
    pub(crate) rows: Vec<f64>,
    /// Its parts along the basis of the free columns.
    along: Vec<f64>,
}

impl PartialRegression {
    /// For the Fit records of a model fitted to `fitted`. `along_runs`: the motion is that of the runs of
    /// `fitted` rather than the measured one. `None` if the known rates cannot be evaluated along the data.
    pub(crate) fn new(
        model: &TrialModel,
        fitted: &Calibration,
        runs: Option<&Calibration>,
        noise: &[Vec<f64>],
        target: Target<'_>,
    ) -> Option<PartialRegression> {
        let of: Vec<usize> =
            (0..model.records.len()).filter(|&r| model.records[r].role == Role::Fit).collect();
        let base = Base::new(&model.system)?;
        let data: Vec<RegressionData> = of
            .iter()
            .map(|&r| {
                let run = match runs {
                    Some(cal) => Some(cal.records.get(r)?.run.as_ref()?),
                    None => None,
                };
                base.data_along(model, r, fitted, noise, 1, run)
            })
            .collect::<Option<_>>()?;
        let total: usize = data.iter().map(RegressionData::height).sum();
        let block = total.div_ceil(FORMULA_ROWS).max(1);
        let FreeColumns { all, movable, .. } = FreeColumns::new(&base, model, &of, &data, target);
        let mut regression = PartialRegression {
            data,
            block,
            basis: vec![],
            triangle: vec![],
            movable,
            target: vec![],
            along: vec![],
        };
        let mut all = all.into_iter();
        let target = regression.averaged(&all.next()?);
        for column in all {
            regression.add_free(&column);
        }
        let Response { rows, along } = regression.projected(target);
        (regression.target, regression.along) = (rows, along);
        Some(regression)
    }

    /// Takes out of the target what lies along changes of the residuals, by Fit record and column.
    pub(crate) fn set_aside(&mut self, changes: &[Vec<Vec<f64>>]) {
        let rows: Vec<f64> = self.data.iter().zip(changes).flat_map(|(data, of)| data.weighted(of)).collect();
        self.add_free(&rows);
        let target = std::mem::take(&mut self.target);
        self.target = self.projected(target).rows;
    }

    /// Adds a free column to the basis.
    fn add_free(&mut self, column: &[f64]) {
        let column = self.averaged(column);
        let size = norm(&column);
        let Response { rows, mut along } = self.projected(column);
        let left = norm(&rows);
        // What the others explain leaves a zero, so that its coefficient stays as it is.
        if left > 1e-9 * size && left > 0.0 {
            along.push(left);
            self.basis.push(rows.iter().map(|v| v / left).collect());
        } else {
            along.push(0.0);
            self.basis.push(vec![0.0; rows.len()]);
        }
        self.triangle.push(along);
    }

    /// What the known part leaves, projected.
    pub(crate) fn target(&self) -> &[f64] {
        &self.target
    }

    /// The motion at a place.
    pub(crate) fn kinematics(&self, system: &System, place: &Place) -> Option<Kinematics> {
        let Site::Force { displacement, velocity, shows, .. } = &place.site else { return None };
        let mut graph = system.graph.clone();
        let mut roots = vec![velocity.node];
        let entered = entered_nodes(system, &mut graph, &place.site);
        roots.extend(entered.iter().map(|e| e.rate));
        roots.extend(displacement.as_ref().map(|d| d.node));
        let tape = Tape::compile(&graph, &system.arguments(), &roots).ok()?;
        let mut out = Kinematics {
            acts: entered.iter().map(|e| (e.state, e.part)).collect(),
            shows: shows.clone(),
            place: place.clone(),
            displacement: vec![],
            velocity: vec![],
            unit: vec![],
            rests: vec![],
        };
        for data in &self.data {
            let mut values = evaluated(&tape, &data.motion, &[], &[]);
            out.displacement.push(displacement.as_ref().and_then(|_| values.pop()).unwrap_or_default());
            out.unit.push(values.split_off(1));
            out.velocity.append(&mut values);
            let still = data.still.iter().find(|s| s.at == place.at);
            out.rests.push(still.map_or(vec![false; data.motion.samples()], |s| s.rests.clone()));
        }
        let all = out.displacement.iter().chain(&out.velocity).flatten();
        all.into_iter().all(|v| v.is_finite()).then_some(out)
    }

    /// The response to a force (by record and sample). `sticks`: friction there holds what rests, so that
    /// other forces act on what moves only.
    pub(crate) fn response(&self, at: &Kinematics, force: &[Vec<f64>], sticks: bool) -> Option<Response> {
        let mut column = Vec::new();
        for (r, data) in self.data.iter().enumerate() {
            let samples = data.motion.samples();
            let n = data.bracket.len() / samples;
            let force = &force[r];
            if force.iter().any(|f| !f.is_finite()) {
                return None;
            }
            let mut g = vec![0.0; samples * n];
            for (j, &(state, _)) in at.acts.iter().enumerate() {
                for i in (0..samples).filter(|&i| !(sticks && at.rests[r][i])) {
                    g[i * n + state] = force[i] * at.unit[r][j][i];
                }
            }
            data.zero_at_rest(&mut g);
            let mut rows = data.response(&g, &vec![0.0; n]);
            let signed: Vec<(usize, Vec<f64>)> =
                at.shows.iter().map(|&(o, sign)| (o, force.iter().map(|f| sign * f).collect())).collect();
            let shown = |output: usize| signed.iter().find(|(o, _)| *o == output).map(|(_, f)| f.as_slice());
            data.add_to_outputs(&mut rows, &shown);
            column.extend(rows);
        }
        self.kept(&column)
    }

    /// The response to the force that holds a place at rest.
    pub(crate) fn holding(&self, at: &Kinematics, system: &System) -> Option<Response> {
        let mut column = Vec::new();
        for (r, data) in self.data.iter().enumerate() {
            let samples = data.motion.samples();
            let n = data.bracket.len() / samples;
            let at_rest: Vec<usize> = (0..samples).filter(|&i| at.rests[r][i]).collect();
            let g = holding_rates(&at_rest, &at.unit[r], &at.acts, system, &at.place, data);
            column.extend(data.response(&g, &vec![0.0; n]));
        }
        self.kept(&column)
    }

    /// A column averaged and projected; `None` where nothing of it is left.
    fn kept(&self, column: &[f64]) -> Option<Response> {
        if column.iter().any(|v| !v.is_finite()) {
            return None;
        }
        let column = self.averaged(column);
        let size = norm(&column);
        let out = self.projected(column);
        (norm(&out.rows) > EXPLAINED_BY_FREE * size && size > 0.0).then_some(out)
    }

    /// Means of neighbouring rows, weighted to unit noise.
    fn averaged(&self, column: &[f64]) -> Vec<f64> {
        let (block, mut first) = (self.block, 0);
        let mut out = Vec::with_capacity(column.len() / block + 1);
        for data in &self.data {
            let samples = data.motion.samples();
            for _ in 0..data.height() / samples {
                let rows = &column[first..first + samples];
                out.extend(rows.chunks(block).map(|c| c.iter().sum::<f64>() / (c.len() as f64).sqrt()));
                first += samples;
            }
        }
        out
    }

    fn projected(&self, mut rows: Vec<f64>) -> Response {
        let mut along = vec![0.0; self.basis.len()];
        // Twice, for rounding.
        for _ in 0..2 {
            for (basis, sum) in self.basis.iter().zip(&mut along) {
                let part = dot(basis, &rows);
                *sum += part;
                subtract(&mut rows, part, basis);
            }
        }
        Response { rows, along }
    }

    /// Values of the movable constants beside forces with these coefficients.
    pub(crate) fn beside(&self, forces: &[(f64, &Response)]) -> Vec<(String, f64)> {
        let mut right = self.along.clone();
        for (c, response) in forces {
            right.iter_mut().zip(&response.along).for_each(|(r, a)| *r -= c * a);
        }
        // Back substitution: free column k is the sum of triangle[k][j] basis[j].
        let mut moves = vec![0.0; right.len()];
        for k in (0..right.len()).rev() {
            let diagonal = self.triangle[k][k];
            let rest: f64 = (k + 1..right.len()).map(|j| self.triangle[j][k] * moves[j]).sum();
            moves[k] = if diagonal > 0.0 { (right[k] - rest) / diagonal } else { 0.0 };
        }
        let of = |m: &Movable| (m.name.clone(), m.now + moves[m.row]);
        self.movable.iter().map(of).filter(|(_, value)| value.is_finite()).collect()
    }
}

/// The inner product, in eight sums that run side by side.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    // The choice of the vectors costs as much as some tens of products.
    if a.len() < SHORT {
        return sum_of_products(a, b);
    }
    wide(
        #[inline(always)]
        || sum_of_products(a, b),
    )
}

/// A shorter column is multiplied with the vectors that every machine has.
const SHORT: usize = 64;

/// Takes a multiple of a column out of rows.
pub(crate) fn subtract(rows: &mut [f64], part: f64, column: &[f64]) {
    wide(
        #[inline(always)]
        || rows.iter_mut().zip(column).for_each(|(r, c)| *r -= part * c),
    );
}

#[inline(always)]
fn sum_of_products(a: &[f64], b: &[f64]) -> f64 {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<8>(), b.as_chunks::<8>());
    let mut sums = [0.0; 8];
    for (a, b) in a.iter().zip(b) {
        (0..8).for_each(|k| sums[k] += a[k] * b[k]);
    }
    a_rest.iter().zip(b_rest).enumerate().for_each(|(k, (a, b))| sums[k] += a * b);
    sums.iter().sum()
}

pub(crate) fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}
