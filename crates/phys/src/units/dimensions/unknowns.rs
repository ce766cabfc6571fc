//! Unknown dimensions, and what is known about them so far: linear equations between powers, solved one by
//! one as they come.

use super::form::{Form, SAME};

/// Every unknown is free, or given by others that came before it was solved for.
#[derive(Clone, Debug, Default)]
pub(super) struct Unknowns {
    solved: Vec<Option<Form>>,
}

impl Unknowns {
    /// A new one, free.
    pub(super) fn add(&mut self) -> Form {
        self.solved.push(None);
        Form { base: [0.0; 5], unknown: vec![(self.solved.len() - 1, 1.0)] }
    }

    /// The form with everything that is known put in.
    pub(super) fn resolved(&self, form: &Form) -> Form {
        let mut form = form.clone();
        // An unknown is given by such as were free when it was solved for, so this ends: later equations only
        // solve for those.
        while let Some(&(k, power)) = form.unknown.iter().find(|(k, _)| self.solved[*k].is_some()) {
            let Some(value) = &self.solved[k] else { break };
            form.unknown.retain(|&(j, _)| j != k);
            form = form.times(value, power);
        }
        form
    }

    /// Demands that both be the same; false if they cannot.
    pub(super) fn equate(&mut self, a: &Form, b: &Form) -> bool {
        let difference = self.resolved(&a.over(b));
        let pivot = difference.unknown.iter().copied().filter(|(_, p)| p.is_finite() && p.abs() > SAME);
        // The largest power divides best; of equal ones the youngest goes, so that chains stay short.
        let Some((k, power)) = pivot.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()).then(a.0.cmp(&b.0)))
        else {
            return difference.is_none();
        };
        let mut rest = difference;
        rest.unknown.retain(|&(j, _)| j != k);
        self.solved[k] = Some(rest.pow(-1.0 / power));
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::unit::Unit;
    use proptest::prelude::*;

    fn form(unit: &str) -> Form {
        Form::known(Unit::parse(unit).expect("a unit").dimension)
    }

    #[test]
    fn equations_determine_unknowns() {
        let mut unknowns = Unknowns::default();
        let (k, m, x) = (unknowns.add(), unknowns.add(), form("m"));
        // k*x/m is an acceleration, k*x a force.
        assert!(unknowns.equate(&k.times(&x, 1.0).over(&m), &form("m/s^2")));
        assert!(unknowns.resolved(&k).dimension().is_none(), "one equation for two");
        assert_eq!(unknowns.resolved(&k.over(&m)).to_string(), "1/s^2");
        assert!(unknowns.equate(&form("N"), &x.times(&k, 1.0)));
        assert_eq!(unknowns.resolved(&m).to_string(), "kg");
        assert!(unknowns.equate(&m, &form("kg")));
        assert!(!unknowns.equate(&m, &form("m")));
        assert!(unknowns.equate(&k.pow(0.5), &form("N/m").pow(0.5)));
    }

    proptest! {
        /// Equations made from a solution never contradict each other, and as many independent ones as
        /// unknowns give it back.
        #[test]
        fn a_solution_is_found_again(
            truth in proptest::collection::vec(proptest::array::uniform5(-3_i8..=3), 4),
            rows in proptest::collection::vec(proptest::collection::vec(-2_i8..=2, 4), 1..9),
        ) {
            let mut unknowns = Unknowns::default();
            let free: Vec<Form> = truth.iter().map(|_| unknowns.add()).collect();
            let value = |row: &[i8], of: &[Form]| {
                row.iter().zip(of).fold(Form::none(), |all, (p, form)| all.times(form, f64::from(*p)))
            };
            let truth: Vec<Form> =
                truth.iter().map(|p| Form { base: p.map(f64::from), unknown: vec![] }).collect();
            for row in &rows {
                prop_assert!(unknowns.equate(&value(row, &free), &value(row, &truth)));
            }
            for (form, truth) in free.iter().zip(&truth) {
                let found = unknowns.resolved(form);
                prop_assert!(!found.unknown.is_empty() || found.over(truth).is_none(), "{found:?} {truth:?}");
            }
            // A row that follows from the others can be violated by them alone.
            let row = &rows[0];
            let wrong = value(row, &truth).times(&truth[0], 0.0).times(&Form { base: [1.0; 5], unknown: vec![] }, 1.0);
            prop_assert!(!unknowns.equate(&value(row, &free), &wrong));
        }
    }
}
