//! Every sentence of this crate that a user reads.

use super::error::{DataError, LearnError, ModelError, NumericsError, TruthError};
use super::identified::NoiseModel;
use super::passivity_violation::PassivityViolation;
use super::quantity::{ParameterId, ParameterOf, Quantity, TermId};
use super::verdict::{Contradiction, FitFailure, Rejection, Unfulfilled};
use super::warning::Warning;
use crate::decisions::{FEWEST_SAMPLES, RIVAL};
use crate::result::warning::{Bias, Chaos};
use std::fmt::{Display, Formatter, Result};

/// `1 in v'`.
impl Display for TermId {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        write!(f, "{} in {}'", self.candidate, self.state)
    }
}

/// The label of a parameter: `k`, `k [run 1]`, `x.offset`, `x.offset [run 1]`.
impl Display for ParameterId {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        write!(f, "{}", self.of)?;
        self.shown_record().map_or(Ok(()), |record| write!(f, " [{record}]"))
    }
}

/// `k` or `x.offset`.
impl Display for ParameterOf {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            ParameterOf::Constant { name, .. } => f.write_str(name),
            ParameterOf::Sensor { name, part, .. } => write!(f, "{name}.{}", part.name()),
        }
    }
}

impl Display for Quantity {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            Quantity::Coefficient(term) => write!(f, "{term}"),
            Quantity::Parameter(id) => write!(f, "{id}"),
        }
    }
}

impl Display for Contradiction {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let Contradiction { number, records: [a, b], values: [of_a, of_b], errors } = self;
        write!(
            f,
            "the records contradict each other: {number} is {of_a:.4} from {a} alone and {of_b:.4} from {b} alone, {errors:.0} standard errors apart; are they of one machine?"
        )
    }
}

impl Display for Warning {
    // One arm for each sentence: the table is longer than 80 lines, and has no logic to divide.
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            Warning::DataNote { record, note } => write!(f, "{record}: {note}"),
            Warning::AtBound { number, value } => {
                match number {
                    Quantity::Coefficient(term) => write!(f, "{} of {}'", term.candidate, term.state)?,
                    Quantity::Parameter(id) => write!(f, "{id}")?,
                }
                write!(f, " ended at its bound {value}: the data would take it further")
            }
            Warning::BoundToBound { number } => write!(
                f,
                "the data do not determine {number}: its interval spans its bounds, and those bounds, not the data, limit the intervals of the numbers that trade off against it"
            ),
            Warning::MayBeZero { term } => write!(
                f,
                "{} of {}' could be zero: its interval contains zero",
                term.candidate, term.state
            ),
            Warning::ValidationWorse { fit, validate } => write!(
                f,
                "validation is {:.0} times worse than the fit (NRMSE {validate:.3} against {fit:.3}): the model does not carry over; the known part may \
                 be wrong",
                validate / fit
            ),
            Warning::Disagreement { number, record, alone, fitted, errors } => write!(
                f,
                "{number} is {alone:.4} from {record} alone and {fitted:.4} from the fitted records, {errors:.0} standard errors apart: the numbers do not \
                 carry over; the known part may be wrong, or a term is missing; the intervals are widened by the difference between the records"
            ),
            Warning::InputNoise { inputs, moved } => {
                let of = |b: &Bias| {
                    format!("{} by {:+.2} % ({:.1} standard errors)", b.number, 100.0 * b.part, b.errors.abs())
                };
                write!(
                    f,
                    "the noise of {} biases these numbers: {}; measure it with less noise",
                    inputs.join(", "),
                    moved.iter().map(of).collect::<Vec<_>>().join(", ")
                )
            }
            Warning::Alternative { swaps, worse } => {
                let swaps: Vec<String> =
                    swaps.iter().map(|(term, other)| format!("{} in place of {term}", other.candidate)).collect();
                let (them, one) = (swaps.join(" and "), swaps.len() == 1);
                write!(
                    f,
                    "{them} {} the data just as well ({} criterion is {worse:.1} higher; less than {RIVAL:.0} is no evidence): the intervals hold only \
                     if the terms are the right ones; a record at another amplitude or speed would tell",
                    if one { "describes" } else { "describe" },
                    if one { "its" } else { "their" },
                )
            }
            Warning::Further { term, worse } => write!(
                f,
                "with {term} added the data are described just as well (the criterion is {worse:.1} higher; less than {RIVAL:.0} is no evidence): it may be there, \
                 and the intervals hold only if it is not; a longer record or less noise would tell"
            ),
            Warning::SingularCandidate { term } => write!(
                f,
                "candidate {} of {}' is not finite everywhere along the data, so it had little chance",
                term.candidate, term.state
            ),
            Warning::Unfulfilled(law) => {
                write!(f, "{law}; ")?;
                if !law.certain {
                    f.write_str("the data do not tell it from a simpler law: ")?;
                }
                let simpler: Vec<String> = law.simpler.iter().map(|s| format!("`{s}`")).collect();
                match simpler.is_empty() {
                    true => f.write_str("`phisindy gap` looks for what describes the data"),
                    false => write!(f, "try {}, or let `phisindy gap` look for what describes the data", simpler.join(", ")),
                }
            }
            Warning::Feeds(feeding @ PassivityViolation::TurnedSign { constant, .. }) => {
                write!(f, "{feeding}: change the sign of the term with {constant} in `known`")
            }
            Warning::Feeds(feeding) => write!(
                f,
                "{feeding}; it probably stands for something else: drag, a damper or a drive that the known part has wrong, or a missing law, which `phisindy gap` looks for"
            ),
            Warning::Unseen { number } => {
                write!(f, "the data say nothing about {number}: give it a value, or leave it out")
            }
            Warning::Inseparable { numbers } => write!(
                f,
                "the data do not tell {} apart: whatever the value of one, the others make up for it, so the printed values are one choice of many; give one of them a value",
                listed(numbers)
            ),
            Warning::Correlated { first, second, correlation } => write!(
                f,
                "{first} and {second} trade off (correlation {correlation:.3}): their {} is known better than either; a record at another amplitude or \
                 speed would tell them apart",
                if *correlation < 0.0 { "sum" } else { "difference" }
            ),
            Warning::Differentiator { number, with, half_widths } => write!(
                f,
                "the result depends on how columns are differentiated: with {} {number} would move by {half_widths:.1} half-widths of its interval; \
                 measure the derivative, or choose by what is known of the motion (Spectral: smooth, SavitzkyGolay: with stops, Spline: any grid)",
                with.name()
            ),
            Warning::Copy { record, of } => write!(f, "{record} holds the same samples as {of}: they count once, and show nothing of how well the result repeats"),
            Warning::Late { column, by, delay, errors } => {
                let how = if *delay { "late" } else { "with a lag of first order" };
                write!(
                    f,
                    "{column} is read {how}, which the spec does not say: {by} was found beside the rest (a delay of it is \
                     {errors:.0} standard errors from none); if it is known, state it in `sensors`"
                )
            }
            Warning::Coloured { independent } => write!(
                f,
                "the residual is not white ({:.0} % of the samples are independent): something is still missing, the known part is wrong, or the sensor filters; the intervals allow for the correlation",
                100.0 * independent
            ),
            Warning::NotNoise => f.write_str(
                "the residual is not white: what is left is small, but it is not noise; something is still missing, or a number of the known part is a \
                 little wrong, and the intervals, which take it as exact, may miss",
            ),
            Warning::Chaotic(Chaos { pieces, exponent, nrmse, noise, mean, size }) => write!(
                f,
                "a small change of the start state grows e-fold in {:.3} s, so no run follows a record to its end: the verdict rests on up to {pieces} segments, each \
                 predicted from its start (NRMSE up to {nrmse:.3}, noise {noise:.3}), and on what such a motion keeps: the mean of a free run is within \
                 {mean:.1} standard errors of that of the data, its standard deviation within a factor of {size:.2}",
                1.0 / exponent
            ),
            Warning::Segmented { pieces } => write!(
                f,
                "a single run drifts away from the data, so each record was fitted in up to {pieces} segments with start states of their own"
            ),
            Warning::SensitiveStart { record, fitted, samples, own: true } => write!(
                f,
                "{record}: a part of it does not determine its start state and the numbers of its own; they were fitted on {:.0} % of it, and only the \
                 rest is prediction",
                100.0 * *fitted as f64 / (*samples).max(1) as f64
            ),
            Warning::SensitiveStart { record, fitted, samples, own: false } => write!(
                f,
                "{record}: nearby motions diverge so fast that its start state was fitted on {:.0} % of it, not on a tenth; everything else there is \
                 prediction",
                100.0 * *fitted as f64 / (*samples).max(1) as f64
            ),
            Warning::HeldConstants { optimiser, names } => write!(
                f,
                "method step with {optimiser:?} holds {} at the spec's value; learn: (optimiser: GaussNewton) moves it",
                names.join(", ")
            ),
            Warning::HeldSensors => {
                f.write_str("method step holds sensor offsets, gains and delays at their start values")
            }
        }
    }
}

fn listed(all: &[impl Display]) -> String {
    all.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}

impl Display for Rejection {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            Rejection::NoTerms { known } => write!(
                f,
                "no candidate of the dictionary explains anything, so none is kept (NRMSE of the known part alone: {})",
                known.iter().map(|(name, e)| format!("{name} {e:.3}")).collect::<Vec<_>>().join(", ")
            ),
            Rejection::FitFailed(failure) => write!(f, "{failure}"),
            Rejection::RunFails { record, failure } => {
                write!(f, "the free run of {record} fails: {failure}")
            }
            Rejection::RunMisses { record, nrmse } => {
                write!(f, "the free run of {record} misses the data by {:.0} % of their standard deviation (NRMSE {nrmse:.2})", 100.0 * nrmse)
            }
            Rejection::Unfulfilled(law) => write!(f, "{law}"),
            Rejection::Feeds(feeding) => write!(f, "{feeding}"),
            Rejection::LawMissing { record, of, output, share } => {
                let share = 100.0 * share;
                match output {
                    true => write!(f, "what is left of {of} in {record} follows the motion, with {share:.0} % of its size: a law is missing"),
                    false => write!(
                        f,
                        "the force that is left on {of} in {record} follows the motion, with {share:.0} % of the size of its rate: a law is missing"
                    ),
                }
            }
            Rejection::NoBetter => {
                f.write_str("the model does no better with the identified part than without it")
            }
            Rejection::NothingMissing => f.write_str(
                "the known part is complete: by itself it describes the records just as well, and what the laws add only fits the noise",
            ),
            Rejection::LawAtBound { number, value, unit } => {
                let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
                write!(
                    f,
                    "{number} ended at {value}{unit}, the limit of its law, and what is left is not noise: the data call for a law that goes further"
                )
            }
        }
    }
}

impl Display for Unfulfilled {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let Unfulfilled { law, because, .. } = self;
        write!(f, "the numbers found for the law {law} are not those of such a law: {because}")
    }
}

impl Display for FitFailure {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        f.write_str("the fit failed, and every value is where it started: ")?;
        match self {
            FitFailure::Singular { expression, state, value } => write!(
                f,
                "{expression} has no finite slope at {state} = {value}, where the motion starts; state a `start` of {state} away from it"
            ),
            FitFailure::Stuck => f.write_str(
                "no step from there lowers the misfit; start from other values, or let fewer of them move at first",
            ),
        }
    }
}

impl Display for PassivityViolation {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let within = |(low, high): &(f64, f64)| {
            if low == high { String::new() } else { format!(" [{low:.4}, {high:.4}]") }
        };
        let unit =
            |unit: &str| if unit.is_empty() || unit == "1" { String::new() } else { format!(" {unit}") };
        match self {
            PassivityViolation::DryFriction { velocity, level, ci95, near_rest, unit: u } => write!(
                f,
                "the dry friction of {velocity} is negative: {level:.4}{}{} {}; friction can only take energy out",
                within(ci95),
                unit(u),
                if *near_rest {
                    "near rest, where it feeds the motion"
                } else {
                    "on average along the motion, so that it feeds the motion"
                }
            ),
            PassivityViolation::Damping { state, slope, ci95 } => write!(
                f,
                "the damping of {state} is negative: {:.4}{} 1/s, and feeds every motion without end; a dashpot can only take energy out",
                -slope,
                within(&(-ci95.1, -ci95.0))
            ),
            PassivityViolation::TurnedSign { state, constant, value, ci95, unit: u } => write!(
                f,
                "{constant} is negative: {value:.4}{}{}; as `known` is written, it damps {state} only so, and a damper is positive",
                within(ci95),
                unit(u)
            ),
        }
    }
}

impl Display for ModelError {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            ModelError::Unbound(text) => f.write_str(text),
            ModelError::Simulation(error) => write!(f, "{error}"),
            ModelError::Stopped => f.write_str("the work was stopped"),
            ModelError::Beaten => f.write_str("over short segments it leaves more than another model"),
        }
    }
}

impl Display for LearnError {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            LearnError::Data(error) => write!(f, "{error}"),
            LearnError::Numerics(error) => write!(f, "{error}"),
        }
    }
}

impl Display for DataError {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            DataError::NothingToFit => f.write_str(
                "no record has the role Fit, so there is nothing to identify from: take `role: Validate` off one of them",
            ),
            DataError::TooFewSamples { record, samples } => write!(
                f,
                "{record}: {samples} samples are too few to learn from ({FEWEST_SAMPLES} at least): take a longer window, or decimate less"
            ),
            DataError::ConstantColumn { record, column } => write!(
                f,
                "{record}: the column of {column} is constant: nothing moved, or the sensor is dead; leave the column out, or take a window in which it \
                 moves"
            ),
            DataError::OutOfRange { record, column } => write!(
                f,
                "{record}: the numbers of the column of {column} are too large or too small to compute with (their squares overflow): state its unit, or repair the file"
            ),
            DataError::Jumps => write!(
                f,
                "method step knows no states that jump (`impacts`, `hold`): leave `method` out, and the trajectory is fitted"
            ),
            DataError::NotANumber { record, column, time } => write!(
                f,
                "{record}: {column} is not a number at t = {time:.6}: a root, power or logarithm of something negative, or a division by zero?"
            ),
            DataError::DelayBeyondRecord { record, column, delay, duration } => write!(
                f,
                "{record}: the delay of {column} is {delay} s, and the record lasts {duration:.6} s: nothing of it is seen; is the delay in seconds?"
            ),
            DataError::FilterBetweenSamples { record, column, cutoff, rate } => write!(
                f,
                "{record}: the lowpass of {column} at {cutoff} Hz settles within a tenth of a sample at {rate:.6} Hz, so no sample shows it: leave it out"
            ),
            DataError::MissingStates { record, states } => write!(
                f,
                "{record}: method step needs samples of every state, and {} cannot be derived from a column; use --method trajectory",
                states.join(", ")
            ),
        }
    }
}

impl Display for NumericsError {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            NumericsError::Model(ModelError::Unbound(text)) => f.write_str(text),
            NumericsError::Model(error) => write!(f, "the model cannot be simulated: {error}"),
            NumericsError::Diverged => f.write_str("the fit diverges from every start"),
            NumericsError::LossNotFinite => {
                f.write_str("the one-step loss is not finite: a candidate is singular on the data")
            }
        }
    }
}

impl Display for TruthError {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            TruthError::NotSynthetic => {
                f.write_str("no record of this case is synthetic, so there is no truth to compare with")
            }
            TruthError::Unbound(text) => f.write_str(text),
            TruthError::OutsideDictionary { state } => {
                write!(f, "the truth of {state}' lies outside the dictionary")
            }
        }
    }
}

impl Display for NoiseModel {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        f.write_str(match self {
            NoiseModel::Additive => "additive",
            NoiseModel::Relative => "relative",
            NoiseModel::Mixed => "mixed",
            NoiseModel::Unweighted => "not used: every sample weighs the same",
        })
    }
}

impl std::error::Error for ModelError {}
impl std::error::Error for LearnError {}
impl std::error::Error for DataError {}
impl std::error::Error for NumericsError {}
impl std::error::Error for TruthError {}

#[cfg(test)]
mod tests;
