//! What is known of a machine, and of two of them.

use crate::changes::Changes;
use crate::estimates::Estimates;
use crate::force_curve::ForceCurve;
use crate::population::Population;
use serde::{Deserialize, Serialize};

/// A law or a changed constant that a model lacks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cause {
    /// Name of the law.
    pub law: String,
    /// Where it acts; of a constant, its name.
    pub at: String,
    /// The value that the spec states, of a constant that has another one.
    pub stated: Option<f64>,
    /// Its numbers: name, value, 95 % interval, unit.
    #[serde(with = "crate::json_numbers::intervals")]
    pub numbers: Vec<(String, f64, (f64, f64), String)>,
}

impl Cause {
    /// Whether both are the same law at the same place.
    pub fn is(&self, other: &Cause) -> bool {
        self.law == other.law && self.at == other.at
    }
}

/// What a record says of a machine.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Unit {
    /// What it is called: the path of its spec or result.
    pub name: String,
    /// The verdict or status in a word.
    pub status: String,
    /// Whether its model can be used.
    pub holds: bool,
    /// What its model lacked.
    pub causes: Vec<Cause>,
    /// The numbers of its completed model.
    pub estimates: Estimates,
    /// Its forces over what they depend on; of the newer of two, with the numbers of the older but for what is told.
    pub curves: Vec<ForceCurve>,
}

/// Two records of one machine, the newer beside the model of the older.
#[derive(Clone, Debug, Default)]
pub struct Comparison {
    /// The older, with its own model completed. Its estimates hold each number of that model as it was known, and what
    /// is held constant without an error.
    pub old: Unit,
    /// The newer, with the model of the older; its causes are what that lacks.
    pub new: Unit,
    /// Numbers that changed.
    pub changes: Changes,
}

impl Comparison {
    /// In a word: `unchanged`, `changed`, or `unexplained` where neither numbers nor laws make the model of the older
    /// record one of the newer.
    pub fn verdict(&self) -> &'static str {
        match (self.new.holds, self.changes.changed().next().is_none() && self.new.causes.is_empty()) {
            (false, _) => "unexplained",
            (true, true) => "unchanged",
            (true, false) => "changed",
        }
    }
}

/// Many machines of one kind.
#[derive(Clone, Debug, Default)]
pub struct Fleet {
    /// In the order in which they were named.
    pub units: Vec<Unit>,
    /// Their numbers beside each other.
    pub population: Population,
}

impl Fleet {
    /// What a machine lacks or has that most others do not.
    pub fn odd_causes(&self, unit: usize) -> impl Iterator<Item = &Cause> {
        let with = |cause: &Cause| self.units.iter().filter(|u| u.causes.iter().any(|c| c.is(cause))).count();
        self.units[unit].causes.iter().filter(move |cause| 2 * with(cause) <= self.units.len())
    }

    /// Whether a machine needs care: its model does not hold, a number stands out, or it has a cause of its own.
    pub fn needs_care(&self, unit: usize) -> bool {
        !self.units[unit].holds
            || self.population.members[unit].stands_out()
            || self.odd_causes(unit).next().is_some()
    }

    /// The machines, those that need care first, then by their largest deviation.
    pub fn by_care(&self) -> Vec<usize> {
        let mut all = self.population.by_deviation();
        all.sort_by_cached_key(|&unit| !self.needs_care(unit));
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::population;

    #[test]
    fn a_machine_with_a_cause_of_its_own_needs_care() {
        let cause = |law: &str| Cause { law: law.into(), at: "v".into(), stated: None, numbers: vec![] };
        let unit = |causes: Vec<Cause>| Unit { holds: true, causes, ..Unit::default() };
        let mut units: Vec<Unit> = (0..5).map(|_| unit(vec![cause("coulomb")])).collect();
        units[3].causes.push(cause("backlash"));
        let fleet = Fleet { population: population(&vec![Estimates::default(); 5]), units };
        assert_eq!(fleet.by_care(), [3, 0, 1, 2, 4]);
        assert_eq!((0..5).filter(|&k| fleet.needs_care(k)).collect::<Vec<_>>(), [3]);
    }
}
