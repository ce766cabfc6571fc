//! Comparison with the truth of synthetic cases: the truth as terms, the Cramer-Rao bound, one seed of a
//! sweep.

use crate::decisions::{NOISE_FLOOR, TRUTH_DAMPING, TRUTH_MISS, TRUTH_POINTS, TRUTH_SHARE};
use crate::identify::{LearnOptions, identify};
use crate::linear::{covariance, solve_damped, symmetric};
use crate::result::error::{LearnError, ModelError, TruthError};
use crate::result::identified::Identified;
use crate::trajectory::noise::{ColumnNoise, least_noise_of};
use crate::trajectory::problem::Problem;
use phisindy_expr::{Id, Scratch, Tape};
use phisindy_phys::spec::{NoiseSpec, Role};
use phisindy_phys::{Case, Origin, Record};
use phisindy_sim::Trajectory;
use std::ops::ControlFlow;

/// The truth in terms of the dictionary.
#[derive(Clone, Debug, PartialEq)]
pub struct Truth {
    /// Terms with a coefficient, in the order of the dictionary.
    pub terms: Vec<usize>,
    /// Their coefficients.
    pub coefficients: Vec<f64>,
}

/// Projects the truth of a synthetic case on factor times candidates at random points (record constants from
/// the first record).
///
/// # Errors
/// The case is not synthetic, or the truth lies outside the dictionary.
///
/// ```
/// use phisindy_learn::project;
/// use phisindy_phys::{Origin, SourceId, check, spec};
/// use phisindy_sim::synthesize;
/// let text = r#"(states: { "x": "m", "v": "m/s" }, constants: { "k": (1.0, "1/s^2") }, known: { "x": "v", "v": "-k*x" },
///     unknown: { "v": (factor: "-sgn(v)", candidates: ["1", "x"]) }, contacts: ["v"],
///     data: [ Synthetic(truth: { "v": "-0.3*sgn(v)" }, start: { "x": 2.0, "v": 0.0 }, duration: 10.0, step: 0.01, noise: Additive(0.01), seed: 1) ])"#;
/// let (spec, _) = spec::read(text, SourceId(0)).unwrap();
/// let (case, _) = check(&spec, SourceId(0)).unwrap();
/// let Origin::Synthetic(truth) = &case.records[0].origin else { panic!("a measured record") };
/// let (record, _) = synthesize(&case.records[0], truth, &case.system, None, &|_| Err("no files here".into())).unwrap();
/// let truth = project(&case, &[record]).unwrap();
/// assert!(truth.terms == [0] && (truth.coefficients[0] - 0.3).abs() < 1e-9);
/// ```
pub fn project(case: &Case, records: &[Record]) -> Result<Truth, TruthError> {
    let synthetic = case.records.iter().zip(records).find_map(|(plan, record)| match &plan.origin {
        Origin::Synthetic(s) => Some((s, record)),
        Origin::Csv(_) => None,
    });
    let (synthetic, record) = synthetic.ok_or(TruthError::NotSynthetic)?;
    let system = &case.system;
    // The truth lives in its own graph, which grew from the system's: the same handles mean the same.
    let graph = &synthetic.truth.graph;
    let inputs = system.arguments();
    let spread = 1 + system.states.len() + system.inputs.len();
    let fixed: Vec<f64> =
        system.parameters.iter().map(|p| p.start).chain(record.constants.iter().copied()).collect();
    let mut outputs: Vec<Id> = synthetic.extra.clone();
    outputs.extend(system.terms.iter().map(|t| t.value));
    let tape = Tape::compile(graph, &inputs, &outputs)
        .map_err(|e| TruthError::Unbound(e.message(&synthetic.truth.names)))?;
    let mut scratch = Scratch::<1>::new(&tape);
    let (n, p) = (system.states.len(), system.terms.len());
    // SplitMix64: the same points in every run.
    let point = |i: usize, d: usize| {
        let mut z = ((i * 64 + d + 1) as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        2.0 * ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64 - 1.0
    };
    let mut rows = Vec::with_capacity(TRUTH_POINTS);
    for i in 0..TRUTH_POINTS {
        for d in 0..spread {
            scratch.input(d)[0] =
                if d == 0 { record.time[record.len() - 1] * (0.5 + 0.5 * point(i, 0)) } else { point(i, d) };
        }
        fixed.iter().enumerate().for_each(|(k, v)| scratch.input(spread + k)[0] = *v);
        scratch.run();
        rows.push((0..outputs.len()).map(|k| scratch.output(k)[0]).collect::<Vec<f64>>());
    }
    let (mut terms, mut coefficients) = (Vec::new(), Vec::new());
    for state in 0..n {
        let here: Vec<usize> = (0..p).filter(|&k| system.terms[k].state == state).collect();
        let m = here.len();
        let triangle: Vec<f64> = (0..m)
            .flat_map(|a| (a..m).map(move |b| (a, b)))
            .map(|(a, b)| rows.iter().map(|r| r[n + here[a]] * r[n + here[b]]).sum())
            .collect();
        let right: Vec<f64> = here.iter().map(|&k| rows.iter().map(|r| r[n + k] * r[state]).sum()).collect();
        let found = if m > 0 {
            solve_damped(&symmetric(&triangle, m), &right, TRUTH_DAMPING).unwrap_or(vec![0.0; m])
        } else {
            vec![]
        };
        let size: f64 = rows.iter().map(|r| r[state] * r[state]).sum::<f64>().sqrt();
        let miss: f64 = rows
            .iter()
            .map(|r| (r[state] - here.iter().zip(&found).map(|(&k, c)| c * r[n + k]).sum::<f64>()).powi(2))
            .sum::<f64>()
            .sqrt();
        if miss > TRUTH_MISS * size && size > 0.0 {
            return Err(TruthError::OutsideDictionary { state: system.states[state].name.clone() });
        }
        for (&k, &c) in here.iter().zip(&found) {
            let share: f64 = rows.iter().map(|r| (c * r[n + k]).powi(2)).sum::<f64>().sqrt();
            if share > TRUTH_SHARE * size {
                terms.push(k);
                coefficients.push(c);
            }
        }
    }
    Ok(Truth { terms, coefficients })
}

/// The Cramer-Rao bound on the standard error of each coefficient of the truth, from the Fisher information
/// at the truth with the noise of the spec. Where relative noise vanishes with the state, the additive floor
/// of the noise model stands in (a thousandth of the column's standard deviation).
///
/// # Errors
/// The truth cannot be simulated.
pub fn bound(
    case: &Case,
    records: &[Record],
    runs: &[Option<Trajectory>],
    truth: &Truth,
) -> Result<Vec<f64>, ModelError> {
    let fitted: Vec<usize> = (0..records.len()).filter(|&r| records[r].role == Role::Fit).collect();
    let chosen: Vec<&Record> = fitted.iter().map(|&r| &records[r]).collect();
    let problem = Problem::new(&case.system, &truth.terms, &chosen, &vec![1; chosen.len()])?;
    let clean: Vec<Record> = chosen.iter().map(|r| (*r).clone()).collect();
    let mut x = problem.guess(&truth.coefficients, None, &clean);
    for (segment, &r) in problem.segments.iter().zip(&fitted) {
        if let Origin::Synthetic(s) = &case.records[r].origin {
            // A record whose window starts later starts where the truth was then.
            let first = records[r].time[0];
            let start = match &runs[r] {
                Some(run) if first > 0.0 => {
                    let row = (first / s.step).round() as usize;
                    run.state_at(row).to_vec()
                }
                _ => s.start.clone(),
            };
            x[segment.start..segment.start + start.len()].copy_from_slice(&start);
        }
    }
    let residuals = problem.residuals(&x)?;
    let noise = fitted
        .iter()
        .enumerate()
        .map(|(i, &r)| {
            (0..case.system.columns())
                .map(|k| {
                    let floor = least_noise_of(problem.records[i], k, NOISE_FLOOR);
                    let Origin::Synthetic(s) = &case.records[r].origin else {
                        return ColumnNoise { additive: floor, relative: 0.0 };
                    };
                    match &s.noise {
                        NoiseSpec::Relative(f) => ColumnNoise { additive: floor, relative: f.value },
                        NoiseSpec::Additive(f) => {
                            let additive = f.value * problem.deviations[i][k];
                            ColumnNoise { additive: additive.max(floor), relative: 0.0 }
                        }
                        _ => ColumnNoise::estimate(
                            &residuals[i][k].residual,
                            &residuals[i][k].prediction,
                            floor,
                        ),
                    }
                })
                .collect()
        })
        .collect();
    let weights = problem.weights(&noise, Some(&residuals));
    let normal = problem.normal(&x, &weights)?;
    let cov = covariance(&normal.matrix);
    Ok((0..truth.terms.len()).map(|k| cov[(k, k)].sqrt()).collect())
}

/// The result of one seed.
#[derive(Clone, Debug)]
pub struct SweepRun {
    /// Whether the terms are exactly the truth's.
    pub exact: bool,
    /// For each term of the truth its estimate, if it was found.
    pub found: Vec<Option<crate::Estimate>>,
    /// Terms that are not in the truth, as `STATE:candidate`.
    pub spurious: Vec<String>,
    /// What identification said, or why it failed.
    pub outcome: Result<Identified, LearnError>,
}

/// Identifies one seed's records and compares with the truth.
pub fn sweep_one(case: &Case, records: &[Record], truth: &Truth, options: &LearnOptions) -> SweepRun {
    let outcome = identify(case, records, options, &mut |_| ControlFlow::Continue(()));
    let empty = vec![];
    let terms = outcome.as_ref().map_or(&empty, |i| &i.terms);
    let found =
        truth.terms.iter().map(|t| terms.iter().find(|f| f.term == *t).map(|f| f.coefficient)).collect();
    let name = |t: usize| {
        format!("{}:{}", case.system.states[case.system.terms[t].state].name, case.system.terms[t].candidate)
    };
    let spurious = terms.iter().filter(|f| !truth.terms.contains(&f.term)).map(|f| name(f.term)).collect();
    let exact = outcome.is_ok() && terms.iter().map(|f| f.term).eq(truth.terms.iter().copied());
    SweepRun { exact, found, spurious, outcome }
}
