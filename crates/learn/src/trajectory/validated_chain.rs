//! A Validate record of motion that forgets its start, as a chain of short runs.
//!
//! No run from a start that was fitted to its first part follows such a record, however right the model is.
//! What it can be asked: whether a run of the model exists that stays beside the record within the noise,
//! which a chain with tight joints is (a shadowing orbit: Hammel, Yorke and Grebogi, J. Complexity 3 (1987)
//! 136-145).

use crate::decisions::{CHAIN_MINIMUM, CHAIN_SAMPLES, FORGOTTEN, LOOSE_JOINTS, TIGHT_JOINTS};
use crate::least_squares::Limits;
use crate::result::record_fit::RecordFit;
use crate::trajectory::chain::{growth, jumps};
use crate::trajectory::fit::Fit;
use crate::trajectory::free_run::Solution;
use crate::trajectory::problem::{Meaning, Noise, Problem};
use phisindy_phys::spec::Role;
use phisindy_phys::{Record, System};

/// The chain with the numbers of a fit, its start states at their minimum.
pub(crate) struct ValidatedChain<'a> {
    /// Of the record alone, its joints tight.
    pub(crate) problem: Problem<'a>,
    pub(crate) x: Vec<f64>,
    pub(crate) noise: Noise,
    pub(crate) weights: Vec<Vec<Vec<f64>>>,
}

impl<'a> ValidatedChain<'a> {
    /// For each record its chain; `None` for Fit records, and where a run keeps its start.
    pub(crate) fn all(
        system: &'a System,
        fit: &Fit<'_>,
        solution: &Solution,
        records: &'a [Record],
        filled: &[Record],
        runs: &[RecordFit],
    ) -> Vec<Option<ValidatedChain<'a>>> {
        let one = |r: usize| {
            forgets_its_start(system, solution, &records[r], &filled[r..=r], (r, &runs[r]))
                .then(|| ValidatedChain::new(system, fit, solution, (r, &records[r]), &filled[r..=r]))?
        };
        (0..records.len()).map(one).collect()
    }

    fn new(
        system: &'a System,
        fit: &Fit<'_>,
        solution: &Solution,
        (r, record): (usize, &'a Record),
        filled: &[Record],
    ) -> Option<ValidatedChain<'a>> {
        let pieces = (record.len() / CHAIN_SAMPLES).max(1);
        let mut problem = Problem::new(system, &solution.terms, &[record], &[pieces]).ok()?;
        problem.chained = true;
        let mut x = solution.guess(&problem, r, filled);
        let noise = vec![fit.noise.first()?.clone()];
        let weights = problem.weights(&noise, problem.residuals(&x).ok().as_deref());
        let mut bounds = problem.bounds.clone();
        for (k, meaning) in problem.meanings().into_iter().enumerate() {
            if meaning != Meaning::Start {
                bounds[k] = (x[k], x[k]);
            }
        }
        for tight in LOOSE_JOINTS.into_iter().chain(TIGHT_JOINTS) {
            problem.continuity = Some(jumps(&problem, &noise, tight));
            problem.minimise_within(&bounds, &mut x, &weights, Limits::of(CHAIN_MINIMUM)).ok()?;
        }
        Some(ValidatedChain { problem, x, noise, weights })
    }
}

/// Whether a disturbance of the start of a Validate record grows so much along it that a run from a fitted
/// start does not tell whether the model is right; asked of motion without contacts of which every state is
/// measured.
fn forgets_its_start(
    system: &System,
    solution: &Solution,
    record: &Record,
    filled: &[Record],
    (r, run): (usize, &RecordFit),
) -> bool {
    let n = system.states.len();
    if record.role != Role::Validate
        || record.continues.is_some()
        || run.start.len() != n
        || !system.contacts.is_empty()
        || !record.columns[..n].iter().all(Option::is_some)
    {
        return false;
    }
    let Ok(problem) = Problem::new(system, &solution.terms, &[record], &[1]) else { return false };
    let mut x = solution.guess(&problem, r, filled);
    let start = problem.segments[0].start;
    x[start..start + n].copy_from_slice(&run.start);
    growth(&problem, &x) > FORGOTTEN
}
