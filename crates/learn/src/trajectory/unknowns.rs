//! Meaning of the unknowns of a fit: parameters for the result, and the numbers of each record for its free
//! run.

use crate::result::estimate::Estimate;
use crate::result::parameter::FoundParameter;
use crate::result::quantity::{ParameterId, ParameterOf, RecordId};
use crate::trajectory::fit::Fit;
use crate::trajectory::free_run::Solution;
use crate::trajectory::problem::Meaning;
use phisindy_phys::spec::Role;
use phisindy_phys::unit::Unit;
use phisindy_phys::{Parameter, Record, SensorPart, System};

/// The unknowns of a fit to the Fit records among some records.
pub(crate) struct Unknowns<'a> {
    system: &'a System,
    records: &'a [Record],
    fit: &'a Fit<'a>,
    /// Indices of the Fit records among all.
    pub(crate) fitted: Vec<usize>,
}

impl<'a> Unknowns<'a> {
    /// Of a fit to the Fit records of `records`.
    pub(crate) fn new(system: &'a System, records: &'a [Record], fit: &'a Fit<'a>) -> Unknowns<'a> {
        let fitted = (0..records.len()).filter(|&r| records[r].role == Role::Fit).collect();
        Unknowns { system, records, fit, fitted }
    }

    /// Everything that moved beside coefficients and start states, each with its index among the unknowns.
    pub(crate) fn parameters(&self, estimate: impl Fn(usize) -> Estimate) -> Vec<(usize, FoundParameter)> {
        let meanings = self.fit.problem.meanings().into_iter().enumerate();
        meanings.filter_map(|(k, meaning)| Some((k, self.parameter(k, meaning, &estimate)?))).collect()
    }

    fn parameter(
        &self,
        k: usize,
        meaning: Meaning,
        estimate: impl Fn(usize) -> Estimate,
    ) -> Option<FoundParameter> {
        let (id, unit) = self.identity(meaning)?;
        let (value, bounds) = (self.fit.x[k], self.fit.problem.bounds[k]);
        Some(FoundParameter {
            id,
            factor: Unit::parse(&unit).map_or(1.0, |u| u.factor),
            unit,
            estimate: estimate(k),
            bounds,
            at_bound: value <= bounds.0 || value >= bounds.1,
        })
    }

    /// Which parameter an unknown is, and its unit; `None` for coefficients and start states.
    fn identity(&self, meaning: Meaning) -> Option<(ParameterId, String)> {
        let owner = |r: usize| {
            let index = self.fitted[r];
            RecordId { index, name: self.records[index].name.clone(), only: self.fitted.len() == 1 }
        };
        match meaning {
            Meaning::Parameter(index, record) => {
                let Parameter { name, unit, .. } = &self.system.parameters[index];
                let of = ParameterOf::Constant { index, name: name.clone() };
                Some((ParameterId { of, owner: record.map(owner) }, unit.clone()))
            }
            Meaning::Sensor(r, column, which) => {
                let (name, own) = self.system.measured(column);
                let part = SensorPart::ALL[which];
                let of = ParameterOf::Sensor { column, name: name.to_owned(), part };
                Some((ParameterId { of, owner: Some(owner(r)) }, part.unit(own).to_owned()))
            }
            Meaning::Coefficient(_) | Meaning::Start => None,
        }
    }

    /// The numbers of the fit, by record; Validate records take those of the record that they continue, or of
    /// the first fitted one.
    pub(crate) fn solution(&self) -> Solution {
        let (system, fit) = (self.system, self.fit);
        let problem = &fit.problem;
        let t = problem.terms.len();
        let base: Vec<f64> = system.parameters.iter().map(|p| p.start).collect();
        let mut out = Solution::new(problem.terms.clone(), fit.x[..t].to_vec(), &base, self.records);
        let numbers = |i: usize| problem.model_parameters(i, &fit.x)[t..t + system.parameters.len()].to_vec();
        for (r, record) in self.records.iter().enumerate() {
            let owner = self.fitted.iter().position(|&f| f == r || record.continues == Some(f));
            out.parameters[r] = numbers(owner.unwrap_or(0));
        }
        for (k, meaning) in problem.meanings().into_iter().enumerate() {
            if let Meaning::Sensor(i, state, which) = meaning {
                out.sensors[self.fitted[i]][state][which] = fit.x[k];
            }
        }
        for (i, &r) in self.fitted.iter().enumerate() {
            if let Some(first) = problem.segments.iter().find(|s| s.record == i) {
                out.starts[r] = Some(fit.x[first.start..first.start + system.states.len()].to_vec());
            }
        }
        out
    }
}
