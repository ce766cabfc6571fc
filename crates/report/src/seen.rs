//! Records and the free runs of models: the data of the figures.

use crate::input::Input;
use phisindy_learn::RecordFit;
use phisindy_phys::spec::Role;
use phisindy_phys::{Record, System};
use phisindy_sim::Automaton;
use std::borrow::Cow;

/// A model with its free run of each record.
pub(crate) struct Model<'a> {
    /// Its states are in the order of the runs.
    pub(crate) system: &'a System,
    /// In the order of the records.
    pub(crate) fits: &'a [RecordFit],
    /// Name of each contact, by switch; `None` for a switch that cannot stick.
    pub(crate) contacts: Vec<Option<String>>,
}

impl<'a> Model<'a> {
    /// A model with these terms of its candidates.
    pub(crate) fn new(system: &'a System, terms: &[usize], fits: &'a [RecordFit]) -> Model<'a> {
        // The fits come from this model, so it compiles; if not, there are no regimes to show.
        let automaton = Automaton::new(&system.model(terms));
        let contact = |s: &phisindy_sim::Switch| s.can_stick.then(|| s.text.clone());
        let contacts = automaton.map_or(vec![], |a| a.switches.iter().map(contact).collect());
        Model { system, fits, contacts }
    }

    /// Measured minus simulated values of a column in its unit; none without samples or a run.
    pub(crate) fn residual(&self, record: usize, column: &str) -> Option<Vec<f64>> {
        let k = self.system.column(column)?;
        let fit = &self.fits[record];
        fit.residuals.get(k).filter(|r| !r.is_empty())?;
        Some(fit.own_residual(k).iter().map(|e| e / self.system.factor(k)).collect())
    }

    /// NRMSE of a record's column.
    pub(crate) fn nrmse(&self, record: usize, state: &str) -> Option<f64> {
        self.fits[record].nrmse.iter().find(|(name, _)| name == state).map(|(_, e)| *e)
    }
}

/// Records, and up to two models of them.
pub(crate) struct Seen<'a> {
    /// The checked system of the spec.
    pub(crate) system: &'a System,
    /// In the order of the spec.
    pub(crate) records: &'a [Record],
    /// The model before effects were added, if there is one.
    pub(crate) was: Option<Model<'a>>,
    /// The final model.
    pub(crate) model: Option<Model<'a>>,
}

/// Index of a record and one number for each sample that it has of a column.
pub(crate) type Part = (usize, Vec<f64>);

/// A measured column of a chain of records.
pub(crate) struct Column<'a> {
    /// Name of the state.
    pub(crate) name: &'a str,
    /// Unit of the values.
    pub(crate) unit: &'a str,
    /// Samples of each record of the chain.
    pub(crate) parts: Vec<Part>,
}

/// A measured column beside what the model says of it, in the unit of the spec.
#[derive(Clone, Debug, PartialEq)]
pub struct Shown {
    /// Name of the record.
    pub record: String,
    /// Name of the column.
    pub column: String,
    /// Its unit.
    pub unit: String,
    /// In seconds.
    pub time: Vec<f64>,
    /// What was measured.
    pub measured: Vec<f64>,
    /// The free run of the model; empty where it has none.
    pub model: Vec<f64>,
}

impl Seen<'_> {
    /// All measured columns of all records.
    pub(crate) fn shown(&self) -> Vec<Shown> {
        let of = |r: usize| {
            let one = move |c: Column<'_>| {
                let (_, measured) = c.parts.into_iter().next()?;
                let residual = self.model.as_ref().and_then(|m| m.residual(r, c.name));
                let left = |residual: Vec<f64>| measured.iter().zip(residual).map(|(x, e)| x - e).collect();
                let model: Vec<f64> = residual.map_or(vec![], left);
                Some(Shown {
                    record: self.records[r].name.clone(),
                    column: c.name.to_owned(),
                    unit: c.unit.to_owned(),
                    time: self.times(r, c.name).into_owned(),
                    measured,
                    model,
                })
            };
            self.columns(&[r]).into_iter().filter_map(one).collect::<Vec<_>>()
        };
        (0..self.records.len()).flat_map(of).collect()
    }

    /// Chains of records: those that continue one another on one time axis.
    pub(crate) fn chains(&self) -> Vec<Vec<usize>> {
        let mut chains: Vec<Vec<usize>> = Vec::new();
        for (r, record) in self.records.iter().enumerate() {
            match chains.iter_mut().find(|c| record.continues.is_some_and(|before| c.contains(&before))) {
                Some(chain) => chain.push(r),
                None => chains.push(vec![r]),
            }
        }
        chains
    }

    /// The measured columns of a chain.
    pub(crate) fn columns(&self, chain: &[usize]) -> Vec<Column<'_>> {
        let quantities = self.system.quantities().take(self.system.columns()).enumerate();
        let columns = quantities.map(|(k, (name, unit))| {
            let factor = self.system.factor(k);
            let part = |&r: &usize| {
                let (_, column) = self.records[r].own_column(k)?;
                Some((r, column.iter().map(|v| v / factor).collect()))
            };
            Column { name, unit, parts: chain.iter().filter_map(part).collect() }
        });
        columns.filter(|c| !c.parts.is_empty()).collect()
    }

    /// When a record sampled a column.
    pub(crate) fn times(&self, record: usize, column: &str) -> Cow<'_, [f64]> {
        let record = &self.records[record];
        self.system
            .column(column)
            .map_or(Cow::Borrowed(&*record.time), |k| record.own_times.of(k, &record.time))
    }

    /// First and last time of a chain.
    pub(crate) fn span(&self, chain: &[usize]) -> (f64, f64) {
        let times = chain.iter().flat_map(|&r| {
            let time = &self.records[r].time;
            [time[0], time[time.len() - 1]]
        });
        times.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), t| (a.min(t), b.max(t)))
    }

    /// The names of a chain's records.
    pub(crate) fn names(&self, chain: &[usize]) -> String {
        chain.iter().map(|&r| self.records[r].name.as_str()).collect::<Vec<_>>().join("; ")
    }

    /// Time intervals of a chain that were not fitted: of a Validate record what follows the part that its
    /// start state and numbers of its own were adapted on.
    pub(crate) fn unfitted(&self, chain: &[usize]) -> Vec<(f64, f64)> {
        let validate = chain.iter().filter(|&&r| self.records[r].role == Role::Validate);
        let adapted = |r: usize| self.model.as_ref()?.fits[r].adapted.as_ref().map(|a| a.span.1);
        let span = |&r: &usize| {
            let (from, to) = self.span(&[r]);
            (adapted(r).unwrap_or(from), to)
        };
        validate.map(span).filter(|(from, to)| from < to).collect()
    }
}

/// The records without a model.
pub(crate) fn measured(input: Input<'_>) -> Seen<'_> {
    Seen { system: &input.case.system, records: input.records, was: None, model: None }
}

/// How the data were processed, in words.
pub(crate) fn notes(input: Input<'_>) -> Vec<String> {
    let of = |r: &Record| r.notes.iter().map(|note| format!("{}: {note}", r.name)).collect::<Vec<_>>();
    input.records.iter().flat_map(of).collect()
}
