//! Every sentence as users know it: programs outside search them.

use super::*;
use crate::result::quantity::RecordId;
use phisindy_phys::Note;
use phisindy_phys::SensorPart;
use phisindy_phys::spec::Optimiser;
use phisindy_signal::{Differentiator, Smoothing};
use phisindy_sim::SimError;

fn term(candidate: &str) -> TermId {
    TermId { index: 0, candidate: candidate.into(), state: "v".into() }
}

fn coefficient(candidate: &str) -> Quantity {
    Quantity::Coefficient(term(candidate))
}

fn owner(only: bool) -> Option<RecordId> {
    Some(RecordId { index: 1, name: "run 1".into(), only })
}

fn constant(owner: Option<RecordId>) -> ParameterId {
    ParameterId { of: ParameterOf::Constant { index: 0, name: "k".into() }, owner }
}

fn sensor(part: SensorPart, owner: Option<RecordId>) -> ParameterId {
    ParameterId { of: ParameterOf::Sensor { column: 0, name: "x".into(), part }, owner }
}

#[test]
fn a_label_names_the_record_where_there_are_several() {
    assert_eq!(constant(None).to_string(), "k");
    assert_eq!([true, false].map(|only| constant(owner(only)).to_string()), ["k [run 1]", "k [run 1]"]);
    assert_eq!(sensor(SensorPart::Delay, owner(true)).to_string(), "x.delay");
    assert_eq!(sensor(SensorPart::Offset, owner(false)).to_string(), "x.offset [run 1]");
    assert_eq!(sensor(SensorPart::Gain, owner(false)).shown_record(), Some("run 1"));
}

#[test]
fn warnings() {
    let k = || Quantity::Parameter(constant(None));
    let all = [
        (
            Warning::DataNote {
                record: "r".into(),
                note: Note::DerivedVelocity {
                    velocity: "v".into(),
                    displacement: "x".into(),
                    smoothing: Smoothing::Spline { length: 2.5, noise: 1e-3 },
                },
            },
            "r: v is the derivative of x (smoothing spline, length 2.5000 samples, noise 1.000e-3)",
        ),
        (
            Warning::AtBound { number: coefficient("1"), value: 0.0 },
            "1 of v' ended at its bound 0: the data would take it further",
        ),
        (
            Warning::AtBound { number: k(), value: 1.3 },
            "k ended at its bound 1.3: the data would take it further",
        ),
        (
            Warning::BoundToBound { number: k() },
            "the data do not determine k: its interval spans its bounds, and those bounds, not the data, limit the intervals of the numbers that trade off against it",
        ),
        (Warning::MayBeZero { term: term("x^2") }, "x^2 of v' could be zero: its interval contains zero"),
        (
            Warning::ValidationWorse { fit: 0.01, validate: 0.06 },
            "validation is 6 times worse than the fit (NRMSE 0.060 against 0.010): the model does not carry over; the known part may be wrong",
        ),
        (
            Warning::Disagreement {
                number: coefficient("1"),
                record: "r2".into(),
                alone: 0.3,
                fitted: 0.25,
                errors: 5.6,
            },
            "1 in v' is 0.3000 from r2 alone and 0.2500 from the fitted records, 6 standard errors apart: the numbers do not carry over; the known part may be wrong, or a term is missing; the intervals are widened by the difference between the records",
        ),
        (
            Warning::Alternative { swaps: vec![(term("1"), term("x"))], worse: 1.26 },
            "x in place of 1 in v' describes the data just as well (its criterion is 1.3 higher; less than 6 is no evidence): the intervals hold only if the terms are the right ones; a record at another amplitude or speed would tell",
        ),
        (
            Warning::Further { term: term("x"), worse: 1.26 },
            "with x in v' added the data are described just as well (the criterion is 1.3 higher; less than 6 is no evidence): it may be there, and the intervals hold only if it is not; a longer record or less noise would tell",
        ),
        (
            Warning::SingularCandidate { term: term("ln(x)") },
            "candidate ln(x) of v' is not finite everywhere along the data, so it had little chance",
        ),
        (Warning::Unseen { number: k() }, "the data say nothing about k: give it a value, or leave it out"),
        (
            Warning::Inseparable { numbers: vec![coefficient("1"), k()] },
            "the data do not tell 1 in v', k apart: whatever the value of one, the others make up for it, so the printed values are one choice of many; give one of them a value",
        ),
        (
            Warning::Correlated { first: coefficient("1"), second: k(), correlation: -0.97 },
            "1 in v' and k trade off (correlation -0.970): their sum is known better than either; a record at another amplitude or speed would tell them apart",
        ),
        (
            Warning::Correlated { first: coefficient("1"), second: k(), correlation: 0.97 },
            "1 in v' and k trade off (correlation 0.970): their difference is known better than either; a record at another amplitude or speed would tell them apart",
        ),
        (
            Warning::Differentiator { number: k(), with: Differentiator::Spline, half_widths: 2.55 },
            "the result depends on how columns are differentiated: with Spline k would move by 2.5 half-widths of its interval; measure the derivative, or choose by what is known of the motion (Spectral: smooth, SavitzkyGolay: with stops, Spline: any grid)",
        ),
        (
            Warning::Late { column: "x".to_owned(), by: "x_delay".to_owned(), delay: true, errors: 77.8 },
            "x is read late, which the spec does not say: x_delay was found beside the rest (a delay of it is 78 standard errors from none); if it is known, state it in `sensors`",
        ),
        (
            Warning::Late { column: "x".to_owned(), by: "x_lag".to_owned(), delay: false, errors: 7.8 },
            "x is read with a lag of first order, which the spec does not say: x_lag was found beside the rest (a delay of it is 8 standard errors from none); if it is known, state it in `sensors`",
        ),
        (
            Warning::Coloured { independent: 0.123 },
            "the residual is not white (12 % of the samples are independent): something is still missing, the known part is wrong, or the sensor filters; the intervals allow for the correlation",
        ),
        (
            Warning::NotNoise,
            "the residual is not white: what is left is small, but it is not noise; something is still missing, or a number of the known part is a little wrong, and the intervals, which take it as exact, may miss",
        ),
        (
            Warning::Segmented { pieces: 20 },
            "a single run drifts away from the data, so each record was fitted in up to 20 segments with start states of their own",
        ),
        (
            Warning::Chaotic(Chaos {
                pieces: 300,
                exponent: 0.8,
                nrmse: 0.1512,
                noise: 0.15,
                mean: 1.23,
                size: 1.054,
            }),
            "a small change of the start state grows e-fold in 1.250 s, so no run follows a record to its end: the verdict rests on up to 300 segments, each predicted from its start (NRMSE up to 0.151, noise 0.150), and on what such a motion keeps: the mean of a free run is within 1.2 standard errors of that of the data, its standard deviation within a factor of 1.05",
        ),
        (
            Warning::SensitiveStart { record: "r".into(), fitted: 200, samples: 400, own: false },
            "r: nearby motions diverge so fast that its start state was fitted on 50 % of it, not on a tenth; everything else there is prediction",
        ),
        (
            Warning::HeldConstants { optimiser: Optimiser::RAdam, names: vec!["k".into(), "c".into()] },
            "method step with RAdam holds k, c at the spec's value; learn: (optimiser: GaussNewton) moves it",
        ),
        (Warning::HeldSensors, "method step holds sensor offsets, gains and delays at their start values"),
    ];
    for (warning, due) in all {
        assert_eq!(warning.to_string(), due);
    }
}

#[test]
fn rejections_and_errors() {
    let diverged = || ModelError::Simulation(SimError::Diverged { time: 1.5, state: "x".into() });
    let all: [(&dyn Display, &str); 20] = [
        (
            &Rejection::NoTerms { known: vec![("a".into(), 0.25), ("b".into(), 1.0)] },
            "no candidate of the dictionary explains anything, so none is kept (NRMSE of the known part alone: a 0.250, b 1.000)",
        ),
        (
            &Rejection::RunFails { record: "a".into(), failure: diverged() },
            "the free run of a fails: `x` grows without bound at t = 1.500000",
        ),
        (
            &Rejection::RunMisses { record: "a".into(), nrmse: 0.514 },
            "the free run of a misses the data by 51 % of their standard deviation (NRMSE 0.51)",
        ),
        (&Rejection::NoBetter, "the model does no better with the identified part than without it"),
        (
            &Rejection::NothingMissing,
            "the known part is complete: by itself it describes the records just as well, and what the laws add only fits the noise",
        ),
        (
            &Rejection::LawAtBound { number: constant(None), value: 0.0, unit: "N".into() },
            "k ended at 0 N, the limit of its law, and what is left is not noise: the data call for a law that goes further",
        ),
        (
            &LearnError::Data(DataError::NothingToFit),
            "no record has the role Fit, so there is nothing to identify from: take `role: Validate` off one of them",
        ),
        (
            &DataError::TooFewSamples { record: "a".into(), samples: 12 },
            "a: 12 samples are too few to learn from (20 at least): take a longer window, or decimate less",
        ),
        (
            &DataError::ConstantColumn { record: "a".into(), column: "x".into() },
            "a: the column of x is constant: nothing moved, or the sensor is dead; leave the column out, or take a window in which it moves",
        ),
        (
            &DataError::NotANumber { record: "a".into(), column: "x".into(), time: 0.5 },
            "a: x is not a number at t = 0.500000: a root, power or logarithm of something negative, or a division by zero?",
        ),
        (
            &DataError::DelayBeyondRecord {
                record: "a".into(),
                column: "x".into(),
                delay: 50.0,
                duration: 6.0,
            },
            "a: the delay of x is 50 s, and the record lasts 6.000000 s: nothing of it is seen; is the delay in seconds?",
        ),
        (
            &DataError::FilterBetweenSamples {
                record: "a".into(),
                column: "x".into(),
                cutoff: 1e3,
                rate: 250.0,
            },
            "a: the lowpass of x at 1000 Hz settles within a tenth of a sample at 250.000000 Hz, so no sample shows it: leave it out",
        ),
        (
            &DataError::MissingStates { record: "a".into(), states: vec!["x".into(), "y".into()] },
            "a: method step needs samples of every state, and x, y cannot be derived from a column; use --method trajectory",
        ),
        (
            &LearnError::Numerics(NumericsError::Model(diverged())),
            "the model cannot be simulated: `x` grows without bound at t = 1.500000",
        ),
        (&NumericsError::Model(ModelError::Unbound("`w` has no value here".into())), "`w` has no value here"),
        (&NumericsError::Diverged, "the fit diverges from every start"),
        (
            &NumericsError::LossNotFinite,
            "the one-step loss is not finite: a candidate is singular on the data",
        ),
        (
            &TruthError::NotSynthetic,
            "no record of this case is synthetic, so there is no truth to compare with",
        ),
        (&TruthError::OutsideDictionary { state: "v".into() }, "the truth of v' lies outside the dictionary"),
        (&NoiseModel::Unweighted, "not used: every sample weighs the same"),
    ];
    for (what, due) in all {
        assert_eq!(what.to_string(), due);
    }
    assert!(LearnError::Numerics(NumericsError::Model(diverged())).diverged());
    assert!(!LearnError::Numerics(NumericsError::Diverged).diverged());
}
