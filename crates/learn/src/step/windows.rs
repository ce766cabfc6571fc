//! The samples of the records as data of steps: one row for each step, and which steps are used.

use crate::decisions::UNIFORM_STEP;
use crate::step::onestep::OneStep;
use crate::step::options::StepOptions;
use phisindy_expr::Scratch;
use phisindy_phys::spec::Crossings;
use phisindy_phys::{Record, System};
use phisindy_signal::standard_deviation;

/// Standard deviation of each state over all records: the unit of its error.
pub(crate) fn deviations(system: &System, records: &[&Record]) -> Vec<f64> {
    (0..system.states.len())
        .map(|k| {
            let all: Vec<f64> =
                records.iter().filter_map(|r| r.columns[k].as_ref()).flatten().copied().collect();
            let deviation = standard_deviation(&all);
            if deviation > 0.0 { deviation } else { 1.0 }
        })
        .collect()
}

/// The length of a record's steps, if it is one.
pub(crate) fn step_length(record: &Record) -> Option<f64> {
    let n = record.len();
    let mean = (record.time[n - 1] - record.time[0]) / (n.max(2) - 1) as f64;
    record.time.windows(2).all(|t| (t[1] - t[0] - mean).abs() < UNIFORM_STEP * mean).then_some(mean)
}

/// One row of data for a step: time, length, its half, third and sixth, states, inputs at start, middle, end.
/// `from` and `to` are neighbouring samples; going backward the length is negative. Between samples an input
/// is what its interpolation says (`Linear` is the paper's average of the two).
pub(crate) fn step_row(record: &Record, from: usize, to: usize, length: Option<f64>) -> Vec<f64> {
    let exact = record.time[to] - record.time[from];
    let h = length.map_or(exact, |length| length.copysign(exact));
    let mut row = vec![record.time[from], h, 0.5 * h, h / 3.0, h / 6.0];
    row.extend(record.columns.iter().map(|c| c.as_ref().map_or(0.0, |c| c[from])));
    row.extend((0..record.inputs.len()).map(|k| record.input_at(k, from)));
    let middle = 0.5 * (record.time[from] + record.time[to]);
    row.extend(record.inputs.iter().map(|u| u.value(middle)));
    row.extend((0..record.inputs.len()).map(|k| record.input_at(k, to)));
    row
}

/// The velocity of every contact at every sample. Constants that move must be numbers in `step.contacts`
/// already; those of the record are the parameters beyond the `free` ones.
pub(crate) fn step_contacts(step: &OneStep, free: usize, record: &Record) -> Vec<Vec<f64>> {
    let mut inputs = step.data.clone();
    inputs.extend(&step.parameters[free..]);
    let tape = step.compile(&inputs, &step.contacts);
    let mut scratch = Scratch::<1>::new(&tape);
    let mut out = vec![Vec::with_capacity(record.len()); step.contacts.len()];
    for k in 0..record.len() {
        let row = step_row(record, k, k, None);
        scratch.at(row.into_iter().chain(record.constants.iter().copied()));
        out.iter_mut().enumerate().for_each(|(c, column)| column.push(scratch.output(c)[0]));
    }
    out
}

/// First samples of the windows that are used: all, or those in which no contact changes its direction.
pub(crate) fn window_starts(contacts: &[Vec<f64>], samples: usize, options: &StepOptions) -> Vec<usize> {
    let crosses = |k: usize| contacts.iter().any(|w| w[k] * w[k + 1] < 0.0);
    let keep = options.crossings == Crossings::Keep;
    (0..samples.saturating_sub(options.horizon))
        .filter(|&start| keep || !(start..start + options.horizon).any(crosses))
        .collect()
}
