//! What a model cannot know of its inputs: how they go between their samples. The error of the rule that
//! draws them is how far a rule of higher order is from it (`Signal::finer`), carried through the model to
//! the columns. A residual within it is no lack of the model.

use super::trial_model::TrialModel;
use crate::decisions::{NOT_WHITE, REPEATS};
use crate::whiteness::score;
use phisindy_learn::{RecordFit, predicted};
use phisindy_phys::Record;
use phisindy_phys::spec::Role;
use phisindy_signal::Signal;

/// A column of a Validate record whose residual is no larger than the error of the inputs between their
/// samples.
#[derive(Clone, Debug)]
pub(crate) struct ColumnError {
    /// Index of the record.
    pub(crate) record: usize,
    /// Index of the column.
    pub(crate) column: usize,
    /// The rms of the residual (SI).
    pub(crate) left: f64,
    /// The rms of what the drawing of the inputs leaves open (SI).
    pub(crate) open: f64,
}

/// The columns of Validate records that leave more than noise in these runs of a model, where each of them
/// leaves no more than the error of the inputs; `None` where one leaves more, or no input is drawn between
/// its samples. `model` starts at the numbers of the runs.
pub(crate) fn input_errors(model: &TrialModel, runs: &[RecordFit]) -> Option<Vec<ColumnError>> {
    let mut all = Vec::new();
    for (r, (record, own)) in model.records.iter().zip(runs).enumerate() {
        let coloured = |&k: &usize| {
            let column = record.own_column(k).filter(|_| !own.residuals[k].is_empty());
            column.is_some_and(|(_, column)| score(&own.own_residual(k), &column) >= NOT_WHITE)
        };
        let coloured: Vec<usize> = (0..own.residuals.len()).filter(coloured).collect();
        if record.role != Role::Validate || coloured.is_empty() {
            continue;
        }
        let finer = with_finer_inputs(record)?;
        let run = |record: &Record| predicted(&model.system, record, &own.start, &[]).ok();
        let (drawn, finer) = (run(record)?, run(&finer)?);
        for column in coloured {
            let between = drawn[column].iter().zip(&finer[column]).map(|(a, b)| a - b);
            let (left, open) = (rms(own.own_residual(column).iter().copied()), rms(between));
            // A rule of higher order has an error, too; the factor allows for it.
            if left > REPEATS * open {
                return None;
            }
            all.push(ColumnError { record: r, column, left, open });
        }
    }
    Some(all)
}

/// The record with its inputs drawn by a rule of higher order; `None` where no input has one, or where one is
/// derived from another.
fn with_finer_inputs(record: &Record) -> Option<Record> {
    let finer: Vec<Option<Signal>> = record.inputs.iter().map(Signal::finer).collect();
    if !record.derivations.is_empty() || finer.iter().all(Option::is_none) {
        return None;
    }
    let inputs =
        finer.into_iter().zip(&record.inputs).map(|(finer, own)| finer.unwrap_or_else(|| own.clone()));
    Some(Record { inputs: inputs.collect(), ..record.clone() })
}

pub(super) fn rms(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let n = values.len().max(1) as f64;
    (values.map(|v| v * v).sum::<f64>() / n).sqrt()
}

#[cfg(test)]
mod tests {
    use crate::test_models::{fitted, model};

    /// An oscillator whose force has five samples in its shortest period. `test` has other phases and no
    /// noise; `more` is what acts on it there and the model lacks.
    fn rig(more: &str) -> String {
        let record = |name: &str, seed: usize, rest: &str| {
            format!(
                r#"Synthetic(name: "{name}", start: {{ "x": 0.0, "v": 0.0 }}, duration: 150.0, step: 0.2,
                    inputs: {{ "u": Multisine(amplitude: 1.0, band: (0.05, 1.0), count: 60) }}, interpolate: {{ "u": Cubic }},
                    measure: ["x"], seed: {seed}, {rest})"#
            )
        };
        format!(
            r#"(states: {{ "x": "m", "v": "m/s" }}, inputs: {{ "u": "m/s^2" }},
                constants: {{ "c": Find(start: 0.35, unit: "1/s", within: (0.0, 2.0)), "k": Find(start: 4.1, unit: "1/s^2", within: (1.0, 9.0)) }},
                known: {{ "x": "v", "v": "u - c*v - k*x" }}, unknown: {{}},
                data: [{}, {}])"#,
            record("fit", 1, r#"truth: {}, noise: Sensor({ "x": (0.01, "m") })"#),
            record("test", 2, &format!("truth: {more}, noise: None, role: Validate"))
        )
    }

    #[test]
    fn a_model_knows_its_inputs_no_better_than_their_samples() {
        let (base, noise) = model(&rig("{}"));
        let complete = fitted(base, &noise);
        assert!(complete.score.explains(), "{:?}", complete.score);
        let [error] = &complete.input_errors[..] else { panic!("{:?}", complete.input_errors) };
        assert!(error.record == 1 && error.column == 0 && error.left < 1.1 * error.open, "{error:?}");
        // A cube of a thousandth is more than the drawing leaves open.
        let (base, noise) = model(&rig(r#"{ "v": "-0.2*x^3" }"#));
        let lacks = fitted(base, &noise);
        assert!(!lacks.score.explains() && lacks.input_errors.is_empty(), "{:?}", lacks.score);
    }
}
