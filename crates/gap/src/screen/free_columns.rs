//! The columns of all free quantities, projected out of every regression: start states, movable constants,
//! sensor parameters.

use super::regression_data::{Base, RegressionData};
use super::target::Target;
use crate::evaluate::evaluated;
use crate::model::TrialModel;
use phisindy_phys::SensorPart;
use rayon::prelude::*;

/// A movable constant of the model, whose column is projected out.
pub(super) struct Movable {
    pub(super) name: String,
    /// Its current value (SI).
    pub(super) now: f64,
    /// Its row in [`super::Screening::follow`].
    pub(super) row: usize,
}

/// The target of the regression and the columns to project out, over the rows of all records.
pub(super) struct FreeColumns {
    /// The target, followed by the columns.
    pub(super) all: Vec<Vec<f64>>,
    pub(super) movable: Vec<Movable>,
    total: usize,
}

impl FreeColumns {
    /// For the Fit records `of` of a model, each with its regression data.
    pub(super) fn new(
        base: &Base,
        model: &TrialModel,
        of: &[usize],
        data: &[RegressionData],
        target: Target<'_>,
    ) -> FreeColumns {
        let total: usize = data.iter().map(RegressionData::height).sum();
        let target = data.iter().zip(of).flat_map(|(data, &r)| match target {
            Target::AlongData => data.missed(),
            Target::OfFit(fit) => data.weighted(&fit.records[r].residuals),
        });
        let target: Vec<f64> = target.collect();
        let mut columns = FreeColumns { all: vec![target], movable: vec![], total };
        columns.start_states(base.n, data);
        columns.parameters(base, model, of, data);
        columns.sensors(model, of, data);
        columns
    }

    /// Adds a column that is zero outside the rows of one record, which start at index `before`.
    fn push(&mut self, before: usize, rows: &[f64]) {
        let mut column = vec![0.0; self.total];
        column[before..before + rows.len()].copy_from_slice(rows);
        self.all.push(column);
    }

    /// Adds one column per start state and record.
    fn start_states(&mut self, n: usize, data: &[RegressionData]) {
        let mut before = 0;
        for data in data {
            let zero = vec![0.0; data.bracket.len()];
            for k in 0..n {
                let mut start = vec![0.0; n];
                start[k] = 1.0;
                self.push(before, &data.response(&zero, &start));
            }
            before += data.height();
        }
    }

    /// Adds movable constants: one column for a shared constant, one per record for the others.
    fn parameters(&mut self, base: &Base, model: &TrialModel, of: &[usize], data: &[RegressionData]) {
        let responses: Vec<Vec<Vec<f64>>> = data.par_iter().map(|data| responses(base, data)).collect();
        for (p, parameter) in model.system.parameters.iter().enumerate() {
            let mut before = 0;
            let mut joint = vec![0.0; self.total];
            for (r, data) in data.iter().enumerate() {
                let mut rows = responses[r][p].clone();
                let sensors = &model.records[of[r]].sensors;
                for part in SensorPart::ALL {
                    let read = |k: &usize| sensors[*k].parameters()[part as usize].shared == Some(p);
                    let columns: Vec<usize> = (0..model.system.columns()).filter(read).collect();
                    if !columns.is_empty() {
                        let own = data.sensor(&columns, part);
                        rows.iter_mut().zip(own).for_each(|(a, b)| *a += b);
                    }
                }
                if parameter.each {
                    self.push(before, &rows);
                } else {
                    joint[before..before + rows.len()].copy_from_slice(&rows);
                }
                before += data.height();
            }
            if !parameter.each {
                // Column 0 is the target.
                let row = self.all.len() - 1;
                self.movable.push(Movable { name: parameter.name.clone(), now: parameter.start, row });
                self.all.push(joint);
            }
        }
    }

    /// Adds the free sensor parameters of each record.
    fn sensors(&mut self, model: &TrialModel, of: &[usize], data: &[RegressionData]) {
        let mut before = 0;
        for (r, data) in data.iter().enumerate() {
            for k in 0..model.system.columns() {
                let measured = data.rows.iter().any(|row| row.column == k);
                let parameters = model.records[of[r]].sensors[k].parameters();
                for (part, p) in SensorPart::ALL.into_iter().zip(parameters) {
                    if p.within.is_some() && p.shared.is_none() && measured {
                        self.push(before, &data.sensor(&[k], part));
                    }
                }
            }
            before += data.height();
        }
    }
}

/// The response of a record to each movable constant.
fn responses(base: &Base, data: &RegressionData) -> Vec<Vec<f64>> {
    let n = base.n;
    let values = evaluated(&base.tape, &data.motion, &[], &[]);
    let samples = data.motion.samples();
    (0..base.parameters)
        .map(|p| {
            let mut g = vec![0.0; samples * n];
            for row in 0..n {
                let column = &values[n + n * n + row * base.parameters + p];
                (0..samples).for_each(|i| g[i * n + row] = column[i]);
            }
            data.zero_at_rest(&mut g);
            let mut rows = data.response(&g, &vec![0.0; n]);
            data.add_to_outputs(&mut rows, &|output| data.by_parameter(output, p));
            rows
        })
        .collect()
}
