//! Noise of measured inputs. A fit takes an input for exact. Noise in it passes through the plant like a
//! force, so it scatters the numbers, and it may pull them to one side, as in any regression on a noisy
//! column.
//!
//! By how much is told by doing it again: as much noise once more moves the numbers about as far again
//! (simulation and extrapolation, Cook and Stefanski, J. Am. Stat. Assoc. 89 (1994) 1314-1328). One
//! Gauss-Newton step for each draw gives the motion. Its scatter enters the error bars; its mean is told
//! where it is larger than they.

use crate::decisions::{BIAS_DRAWS, EXACT_INPUT, HALF_WIDTH_95, ROUGH_INPUT};
use crate::differentiator_dependence::{Number, step};
use crate::result::warning::{Bias, Warning};
use crate::trajectory::fit::Fit;
use phisindy_phys::Record;
use phisindy_signal::{Differentiator, Interpolation, Signal, noise_level_at, standard_deviation};
use phisindy_sim::{Noise, Streams, add_noise};
use rayon::prelude::*;

/// A record with as much noise once more on its measured inputs, and their indices. Inputs derived from them
/// are derived again, as `how` says for each input. `None` where that fails.
pub fn noisier(record: &Record, how: &[Differentiator], draw: usize) -> Option<(Record, Vec<usize>)> {
    let (mut out, mut of) = (record.clone(), Vec::new());
    let mut disturb = |k: usize, values: &mut Vec<f64>| {
        let sigma = noise_level_at(&record.time, values);
        // Digits of a computed input are no noise: along a chaotic motion even they would move the numbers.
        let size = standard_deviation(values);
        if sigma > EXACT_INPUT * size && sigma < ROUGH_INPUT * size {
            let mut stream = Streams(draw as u64).stream(&format!("noise of input {k} in {}", record.name));
            add_noise(values, Noise::Sensor(sigma), &mut stream);
            of.push(k);
        }
    };
    for derivation in &mut out.derivations {
        disturb(derivation.of, &mut derivation.column);
    }
    if let Some(derivation) = out.derivations.first() {
        out = out.rederived(how.get(derivation.input).copied().unwrap_or_default())?;
    }
    let derived = |k: usize| out.derivations.iter().any(|d| d.of == k || d.input == k);
    let measured = |k: &usize| !derived(*k) && out.inputs[*k].kind() != Interpolation::Hold;
    let own: Vec<usize> = (0..out.inputs.len()).filter(measured).collect();
    for k in own {
        let mut values = out.inputs[k].values().to_vec();
        disturb(k, &mut values);
        out.inputs[k] = Signal::new(out.inputs[k].time().clone(), values, out.inputs[k].kind()).ok()?;
    }
    Some((out, of))
}

/// What noise of inputs does to a fit.
#[derive(Default)]
pub(crate) struct InputNoiseEffect {
    /// The variance that it adds to each unknown; empty where no input has noise.
    pub(crate) variance: Vec<f64>,
    /// The warning of numbers that it moves by more than their error bars.
    pub(crate) warning: Option<Warning>,
}

/// What noise of its inputs does to the numbers of a fit.
pub(crate) fn effect(fit: &Fit<'_>, numbers: &[Number]) -> InputNoiseEffect {
    let Some(inputs) = inputs(fit) else { return InputNoiseEffect::default() };
    let Some(Steps { mean, variance, count }) = Steps::new(fit) else { return InputNoiseEffect::default() };
    let told = |(k, number, error): &Number| {
        let (mean, scatter) = (mean[*k], variance[*k]);
        let error = error.hypot(scatter.sqrt());
        // What the draws differ by is no bias.
        let clear = mean.abs() > HALF_WIDTH_95 * (scatter / count).sqrt();
        let moved = mean.abs() > error && clear && error.is_finite();
        moved.then(|| Bias { number: number.clone(), part: mean / fit.x[*k], errors: mean / error })
    };
    let moved: Vec<Bias> = numbers.iter().filter_map(told).collect();
    let warning = (!moved.is_empty()).then_some(Warning::InputNoise { inputs, moved });
    InputNoiseEffect { variance, warning }
}

/// The variance that noise of inputs adds to each unknown of a fit; `None` where no input has noise.
pub(crate) fn variance(fit: &Fit<'_>) -> Option<Vec<f64>> {
    inputs(fit)?;
    Steps::new(fit).map(|steps| steps.variance)
}

/// How as much noise once more moves the unknowns: over all draws.
struct Steps {
    mean: Vec<f64>,
    variance: Vec<f64>,
    /// Number of draws.
    count: f64,
}

impl Steps {
    /// `None` with less than two draws.
    fn new(fit: &Fit<'_>) -> Option<Steps> {
        let all = steps(fit).filter(|steps| steps.len() > 1)?;
        let count = all.len() as f64;
        let mean: Vec<f64> =
            (0..fit.x.len()).map(|k| all.iter().map(|s| s[k]).sum::<f64>() / count).collect();
        let of = |k: usize| all.iter().map(|s| (s[k] - mean[k]).powi(2)).sum::<f64>() / (count - 1.0);
        let variance = (0..fit.x.len()).map(of).collect();
        Some(Steps { mean, variance, count })
    }
}

/// How each draw of as much noise once more moves the unknowns.
fn steps(fit: &Fit<'_>) -> Option<Vec<Vec<f64>>> {
    let of = |r: &&Record, draw: Option<usize>| match draw {
        Some(draw) => noisier(r, &[], draw).map(|(record, _)| record),
        // Derived in the same way, so that nothing but the noise differs.
        None => r.rederived(Differentiator::default()),
    };
    let at = |draw: Option<usize>| {
        let records: Option<Vec<Record>> = fit.problem.records.iter().map(|r| of(r, draw)).collect();
        fit.normal_of(&records?)
    };
    let here = at(None)?;
    Some((0..BIAS_DRAWS).into_par_iter().filter_map(|draw| step(&here, &at(Some(draw))?)).collect())
}

/// Names of the measured inputs with noise; `None` if there are none.
fn inputs(fit: &Fit<'_>) -> Option<Vec<String>> {
    let problem = &fit.problem;
    let mut all: Vec<usize> =
        problem.records.iter().filter_map(|r| noisier(r, &[], 0)).flat_map(|(_, of)| of).collect();
    all.sort_unstable();
    all.dedup();
    let names: Vec<String> = all.iter().map(|&k| problem.system.inputs[k].name.clone()).collect();
    (!names.is_empty()).then_some(names)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::line_models::{records, scatter};
    use phisindy_phys::spec::Role;

    /// Noise of a sensor is doubled; the last digits of a computed input are not.
    #[test]
    fn what_is_exact_is_left_alone() {
        let still = r#"states: {"x": ""}, known: {"x": "0"}, unknown: {}"#;
        let (_, records) = records(still, &[(Role::Fit, vec![0.0; 200])]);
        let time = records[0].time.clone();
        for (sigma, noisy) in [(1e-2, vec![0]), (1e-4, vec![0]), (1e-7, vec![]), (0.0, vec![])] {
            let values =
                scatter(200).iter().enumerate().map(|(i, e)| (0.05 * i as f64).sin() + sigma * e).collect();
            let input = Signal::new(time.clone(), values, Interpolation::Linear).unwrap();
            let record = Record { inputs: vec![input], ..records[0].clone() };
            let (_, of) = noisier(&record, &[], 0).unwrap();
            assert_eq!(of, noisy, "{sigma}");
        }
    }
}
