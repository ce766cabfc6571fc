//! Every number of this crate that decides something, in the order of the pipeline: what it decides, in which
//! unit, and why it is what it is. Where the history tells of no data that a number was set on, its basis is
//! a judgement.
//!
//! What is not here decides nothing: block lengths of sums, points of a drawn curve, the stages of a
//! published formula.

use phisindy_phys::{Basis, Decision, decisions};

/// Data that several numbers were set on.
const PAPER: Basis =
    Basis::SetOn("the cases of the paper: right terms in 100 seeds of each (`phisindy table paper`)");
/// Where results are shown unless a test says otherwise.
const BLIND: Basis = Basis::SetOn("blind sets of the gap workflow (`phisindy table hidden`)");
/// The quantile of an interval.
const NORMAL: Basis = Basis::Derived("quantile of the normal distribution");
/// What stops an iteration.
const NUMERICS: Basis = Basis::Judgement("far below what the noise lets a result show, far above rounding");

/// What the step method is compared with.
const TABLE_4: Basis = Basis::Convention("the paper, Table 4");
/// The optimiser of the step method.
const RADAM: Basis =
    Basis::Convention("Liu et al., On the Variance of the Adaptive Learning Rate and Beyond, ICLR 2020");

/// Every decision of this crate as data: name, value, unit, meaning, basis.
pub fn decisions() -> &'static [Decision] {
    DECISIONS
}

decisions! {
    // Records.

    /// A record with fewer samples cannot be learned from.
    FEWEST_SAMPLES: usize = 20, "samples", Basis::Judgement("a start state, a noise level and a few coefficients need some samples each");
    /// A filter that settles in a smaller part of the time between two samples shows in none of them.
    FILTER_SEEN: f64 = 0.1, "of a sample", Basis::Judgement("a tenth of a sample late moves a reading by less than the noise of most sensors");

    // Least squares.

    /// Damping of the first Levenberg-Marquardt step, as part of the diagonal.
    FIRST_DAMPING: f64 = 1e-6, "part of the diagonal", Basis::Convention("nearly the Gauss-Newton step (Marquardt 1963 starts at 1e-2)");
    /// Damping is multiplied by this when a step fails ...
    DAMPING_RISE: f64 = 10.0, "factor", Basis::Convention("Marquardt, SIAM J. Appl. Math. 11 (1963) 431-441");
    /// ... and by this when one is accepted.
    DAMPING_FALL: f64 = 0.1, "factor", Basis::Convention("Marquardt, SIAM J. Appl. Math. 11 (1963) 431-441");
    /// Damping never falls below this.
    LEAST_DAMPING: f64 = 1e-12, "part of the diagonal", NUMERICS;
    /// After a failed step damping is at least this.
    DAMPING_AFTER_FAILURE: f64 = 1e-5, "part of the diagonal", NUMERICS;
    /// A step that needs more damping than this does not exist.
    MOST_DAMPING: f64 = 1e8, "part of the diagonal", NUMERICS;
    /// Tries of a step, failures included, for each accepted step that is allowed.
    TRIES_PER_STEP: usize = 3, "tries", Basis::Judgement("a step that keeps failing is on a cliff, and costs more than it brings");
    /// Steps after which a cost that is far too high is hopeless; twice as many failures are.
    CHANCES: usize = 3, "steps", Basis::Derived("from nearby convergence is quadratic");
    /// A sample that is earlier than the start of a run by less shows the start.
    SAME_TIME: f64 = 1e-6, "sampling steps", Basis::Derived("rounding of times: 1e-10 of a step in a record of a million samples, and of stamps with a few digits");
    /// Costs within this factor are the same number but for rounding.
    ROUNDING: f64 = 1.000_000_000_000_01, "factor", Basis::Derived("45 units in the last place");
    /// With more unknowns than this the structure of segments is used: each has its own start state.
    DENSE: usize = 128, "unknowns", Basis::Judgement("cost: below it a dense solution takes no time");
    /// An eigenvalue of the normal matrix below this, of unit diagonal, is a direction that the data do not
    /// see.
    BLIND_EIGENVALUE: f64 = 1e-13, "of unit diagonal", Basis::Derived("rounding of a matrix with some hundred rows");
    /// An unknown with a larger part of a blind direction is not seen.
    BLIND_PART: f64 = 1e-6, "part of a unit vector", NUMERICS;

    /// Damping of the step to the minimum with another differentiator.
    DIFFERENTIATOR_DAMPING: f64 = 1e-12, "part of the diagonal", NUMERICS;

    // Method step.

    /// Epochs of each stage.
    EPOCHS: [u32; 3] = [1000, 1000, 1000], "epochs", TABLE_4;
    /// Learning rate of each stage.
    LEARNING_RATES: [f64; 3] = [0.1, 0.01, 0.001], "1", TABLE_4;
    /// Coefficients smaller than this are cut after each stage.
    CUTOFF: f64 = 0.05, "SI", TABLE_4;
    /// Speed below which a contact counts as stuck.
    STUCK_SPEED: f64 = 1e-3, "m/s", TABLE_4;
    /// Memory of the mean of the gradient.
    RADAM_BETA1: f64 = 0.9, "1", RADAM;
    /// Memory of the mean square of the gradient.
    RADAM_BETA2: f64 = 0.999, "1", RADAM;
    /// What keeps the division by the root of that from failing.
    RADAM_EPSILON: f64 = 1e-8, "1", RADAM;
    /// Steps whose lengths differ by less than this part have one length.
    UNIFORM_STEP: f64 = 1e-9, "part of the step", Basis::Judgement("clocks are not better");
    /// Iterations of the Gauss-Newton solution of the one-step loss.
    STEP_ITERATIONS: usize = 60, "iterations", NUMERICS;
    /// It ends when an iteration lowers the loss by less than this part.
    STEP_GAIN: f64 = 1e-14, "part of the loss", NUMERICS;
    /// Epochs between two calls of the observer.
    OBSERVED_EPOCHS: u32 = 16, "epochs", Basis::Judgement("a stop is felt at once, and calls cost nothing beside the work");

    // Method trajectory: simulation.

    /// Local error of the simulations inside a fit, relative to the size of each state.
    TOLERANCE: f64 = 1e-7, "part of the state's size", Basis::Derived("far below the noise of any sensor");
    /// A state beyond this many times its size has diverged.
    DIVERGED_SIZE: f64 = 1e4, "sizes of the state", Basis::Judgement("no record shows motions of such different sizes");
    /// Steps that a segment may take beside those for its samples.
    BASE_STEPS: usize = 2_000, "steps", Basis::Judgement("transients and events at the start");
    /// Steps that a segment may take for each of its samples.
    STEPS_PER_SAMPLE: usize = 16, "steps", Basis::Judgement("a model that needs more is on its way to nowhere");
    /// A segment has at least this many samples.
    SEGMENT_SAMPLES: usize = 4, "samples", Basis::Derived("a start state and something that checks it");
    /// Local error of a run that only tells how large the states become.
    SIZE_TOLERANCE: f64 = 1e-3, "of a state", Basis::Judgement("three digits of a size are more than a scale needs");
    /// The size that such a run takes for a state of which nothing is known.
    SMALLEST_SIZE: f64 = 1e-9, "SI", Basis::Judgement("below the size of any state of a rig");
    /// The size of a velocity without a column is that of slopes over this part of the record.
    SLOPE_STRETCHES: usize = 100, "stretches of a record", Basis::Judgement("long enough that noise does not make the slope large");

    // Method trajectory: start.

    /// Samples of a stretch of the regression at most.
    LONGEST_STRETCH: usize = 25, "samples", PAPER;
    /// Samples of a stretch of the regression at least.
    SHORTEST_STRETCH: usize = 5, "samples", PAPER;
    /// Damping of the regression: collinear candidates share what none can claim.
    RIDGE: f64 = 1e-6, "part of the diagonal", PAPER;
    /// A contact slower than this part of its root mean square speed may stick or turn: the regression leaves
    /// such stretches out.
    SLOW_CONTACT: f64 = 0.05, "part of the rms speed", PAPER;
    /// Ranks of single terms that are tried as the first term of each equation.
    LEADING_RANKS: usize = 3, "terms", PAPER;
    /// A start that lowers the misfit by less than this part was not worth trying: neither will the next one
    /// be.
    START_GAIN: f64 = 0.02, "part of the misfit", PAPER;

    // Method trajectory: fit.

    /// Segments of the stages that a fit goes through.
    STAGES: [usize; 3] = [20, 5, 1], "segments of each record", PAPER;
    /// Before anything is fitted the noise of a column is this part of its standard deviation.
    FIRST_NOISE: f64 = 0.1, "part of the standard deviation", Basis::Judgement("every column weighs by its own size");
    /// A known model is run from where the spec starts, if that misses by less than this many times what the
    /// fit misses by.
    STRAIGHT_PROMISE: f64 = 3.0, "times the misfit", BLIND;
    /// A single run whose residual is this many times that of five segments drifts away from the data.
    DRIFT: f64 = 3.0, "times the misfit", PAPER;
    /// A fit whose residual is this many times that of the shortest segments may sit in a side minimum.
    SPOILED: f64 = 1.2, "times the misfit", PAPER;
    /// What the coefficients are multiplied by to look for a better minimum of a motion that comes to rest.
    HOPS: [f64; 8] = [0.7, 0.85, 0.93, 0.97, 1.04, 1.08, 1.17, 1.4], "factors", Basis::SetOn("a released mass with a swing more or less (`crates/learn/tests/honesty.rs`)");
    /// Such a minimum must lower the cost to this part.
    HOP_GAIN: f64 = 0.95, "part of the cost", Basis::SetOn("a released mass with a swing more or less (`crates/learn/tests/honesty.rs`)");
    /// By how much the joints of a chain of segments are tightened, in turn.
    TIGHTENING: [f64; 3] = [0.3, 0.03, 0.003], "free jumps", PAPER;
    /// A description whose cost after a few steps is this many times that of another one will not come near
    /// it.
    HOPELESS: f64 = 10.0, "times the cost", PAPER;
    /// Steps that a simulation may take beside those of the fit before.
    BUDGET_BASE: usize = 1_000, "steps", Basis::Judgement("transients and events at the start");
    /// Steps that a simulation may take for each step of the fit before.
    BUDGET_FACTOR: usize = 4, "steps", Basis::Judgement("what takes many times the steps of a good model is a bad one, and slow to find out about");
    /// Iterations and gain of the first minimisation of a stage.
    ROUGH_MINIMUM: [f64; 2] = [12.0, 1e-4], "iterations, part of the cost", NUMERICS;
    /// A fit of outputs that jump begins with means over this part of a segment ...
    LARGEST_WINDOW: usize = 32, "windows in a segment", Basis::Judgement("an event half a window off is still seen, and a sweep of thirty means tells some ten numbers");
    /// ... and goes on with windows shorter by this factor.
    WINDOW_FALL: usize = 2, "times", Basis::Judgement("the end of one stage is well within the window of the next");
    /// A record of which no state is measured is fitted to these parts of its length, one after the other.
    GROWTH: [usize; 6] = [32, 16, 8, 4, 2, 1], "th part", Basis::Judgement("doubled, the rest is new, and the start of it is known from the part before");
    /// After so many of these parts first terms are compared.
    FIRST_PARTS: usize = 4, "parts", Basis::Judgement("a quarter of a record has some of its events");
    /// Rounds in which a fit of outputs that jump looks for a lower minimum beside its own.
    SIDE_ROUNDS: usize = 5, "rounds", Basis::Judgement("each takes the lowest of all; the second mostly finds none");
    /// Where it looks for one: so many half-widths of a coefficient's interval away.
    SIDE_REACH: [f64; 4] = [-10.0, -1.0, 1.0, 10.0], "half-widths", Basis::SetOn("case 2b by an accelerometer: an event that is one sample off moves a coefficient by up to 18 standard errors");
    /// A coefficient of which this part is not known may lie in a side minimum.
    BLURRED: f64 = 0.1, "part of the coefficient", Basis::Judgement("its interval reaches over two fifths of it, and a cost with events bends within that");
    /// Iterations and gain of a minimisation at the end of a fit.
    FINE_MINIMUM: [f64; 2] = [20.0, 1e-7], "iterations, part of the cost", NUMERICS;
    /// Iterations and gain of a trial that is only compared.
    TRIAL_MINIMUM: [f64; 2] = [8.0, 1e-3], "iterations, part of the cost", NUMERICS;
    /// Iterations and gain of each tightening of a chain.
    CHAIN_MINIMUM: [f64; 2] = [12.0, 1e-4], "iterations, part of the cost", NUMERICS;
    /// Iterations of a refit with other terms.
    REFIT_ITERATIONS: usize = 20, "iterations", NUMERICS;
    /// A minimisation ends when it gains less than this in the logarithm of the likelihood.
    LIKELIHOOD_GAIN: f64 = 0.01, "nats", Basis::Derived("far below any difference that decides");

    /// Samples of a segment of a chain.
    CHAIN_SAMPLES: usize = 10, "samples", Basis::Judgement("a few for each number of a start state");
    /// Standard deviations of the jumps at the joints of a chain with all terms, in turn ...
    LOOSE_JOINTS: [f64; 2] = [1.0, 0.1], "of the noise", Basis::Derived("from where a joint holds as well as a reading to where a jump cannot be read");
    /// ... and of one that stands for a single run.
    TIGHT_JOINTS: [f64; 4] = [1e-2, 1e-3, 1e-4, 1e-5], "of the noise", Basis::Derived("decades, down to the accuracy of the simulations");
    /// A disturbance of the start that grows more than this over a record leaves a fit of single runs in
    /// doubt.
    FORGOTTEN: f64 = 30.0, "times", Basis::Judgement("such a run leaves its linear neighbourhood with a start that is wrong by a thirtieth of the motion");
    /// ... and where it grows more than this no single run stands for a chain.
    LOST: f64 = 1e6, "times", Basis::Derived("its square, the condition of the normal equations of such a run, leaves four digits of sixteen");
    /// A free run of a chaotic motion whose mean is this far from that of the data is of another motion ...
    CHAOTIC_MEAN: f64 = 6.0, "standard errors", Basis::Judgement("the standard error of a mean of a few turns is itself uncertain by half");
    /// ... and so is one of another size.
    CHAOTIC_SIZE: f64 = 2.0, "times the standard deviation", Basis::Judgement("a motion of twice the size is another one");
    /// Stretches of the regression for each term that it starts a chain with, where there are fewer stretches
    /// than candidates.
    STRETCHES_PER_TERM: usize = 4, "stretches", Basis::Judgement("a regression with fewer follows the noise");
    /// Refits of a selection on a chain at most.
    CHAIN_REFITS: usize = 30, "refits", NUMERICS;
    /// Choices of terms by exchange of pairs that a selection on a chain looks at.
    CHAIN_PAIRS: usize = 100_000, "choices", Basis::Judgement("cost: a second of one core");

    // Method trajectory: the force that is left.

    /// Intensities of a random force that are compared first, as powers of ten of that which explains the whole
    /// acceleration from sample to sample.
    FORCE_DECADES: [i32; 9] = [-8, -7, -6, -5, -4, -3, -2, -1, 0], "power of ten", Basis::Derived("from a ten-thousandth of the force to all of it; the likelihood chooses");
    /// A fit with a force ends when a round gains less than this.
    FORCE_GAIN: f64 = 0.1, "twice the nats", Basis::Derived("far below any difference that decides");
    /// Rounds of intensities, then numbers, at most.
    FORCE_ROUNDS: usize = 12, "rounds", NUMERICS;
    /// How far from their last values intensities and noises are looked for, in turn.
    FORCE_SEARCH: [f64; 4] = [4.0, 2.0, 1.0, 0.5], "nats of the variance", NUMERICS;
    /// A sensor shows at most so many digits of a motion.
    SHARPEST_SENSOR: f64 = 1e-6, "part of the standard deviation", Basis::Convention("the dynamic range of the best converters, 120 dB");
    /// Above so many states all forces share one intensity.
    FORCE_GROUPED: usize = 12, "states", Basis::Judgement("cost: the filter multiplies matrices of that size for each force");

    /// Stretches of a record of which the one with the strongest force is told.
    REMAINDER_STRETCHES: usize = 20, "stretches", Basis::Judgement("a twentieth of a record is a place that one can look at");
    /// Starts of the predictions by which an error is told against the time ahead ...
    HORIZON_STARTS: usize = 12, "starts", Basis::Judgement("their mean is known to a third");
    /// ... in steps of this ratio ...
    HORIZON_STEPS: usize = 10, "times", Basis::Convention("decades");
    /// ... beside a linear model, where no step of the time differs by more than this.
    EVEN: f64 = 0.05, "part of a step", Basis::Judgement("an autoregression knows no times");
    /// Analogues of a moment ...
    ANALOGUES: usize = 2, "moments", Basis::Judgement("a record of three cycles has two more of each moment");
    /// ... each a history of as many quarters of a period ...
    ANALOGUE_LAGS: usize = 4, "quarters", Basis::Derived("a whole period");
    /// ... among at most so many moments.
    ANALOGUE_POINTS: usize = 2000, "moments", Basis::Judgement("cost: all pairs are looked at");
    /// A force that is left and follows the motion with more than this part of the whole rate is a law.
    LAW_MISSING: f64 = 0.1, "part of the rate", Basis::Judgement("a tenth of the force is more than laws of friction differ by from rig to rig");
    /// Records whose numbers are further apart than this are not of one machine.
    OTHER_MACHINE: f64 = 0.1, "part of the number", Basis::Judgement("friction of one joint repeats to some per cent from run to run");

    // Method trajectory: noise and whiteness.

    /// The floor of the additive noise.
    NOISE_FLOOR: f64 = 1e-3, "part of the standard deviation", Basis::Judgement("relative noise vanishes with the state, and with it the bound on what can be known");
    /// Iterations of the noise estimate.
    NOISE_ITERATIONS: usize = 50, "iterations", NUMERICS;
    /// The noise estimate ends when both variances move by less than this part.
    NOISE_GAIN: f64 = 1e-6, "part of the variance", NUMERICS;
    /// Where the signal has one size, to this part, additive and relative noise are the same.
    NOISE_RANK: f64 = 1e-12, "part of the determinant", NUMERICS;
    /// Below this part of each other one of two parts of the noise gives it its name.
    MIXED_NOISE: f64 = 0.3, "part of the other", Basis::Derived("a tenth of the variance");
    /// A residual is white if at least this part of its samples count as independent ...
    WHITE_PART: f64 = 0.6, "part of the samples", PAPER;
    /// ... or if its power is within this factor of its white part.
    WHITE_EXCESS: f64 = 1.1, "times the power", Basis::Judgement("what else there is, is too small to look for");
    /// Samples over effective samples below this are no correlation.
    INFLATED: f64 = 1.3, "samples per effective sample", Basis::Derived("the estimate itself scatters round 1");
    /// A warning names a column with fewer independent samples than this part of all.
    COLOURED_PART: f64 = 0.5, "part of the samples", PAPER;
    /// What noise looks like less often than this is no noise.
    CHANCE_OF_NOISE: f64 = 1e-4, "chance", Basis::Derived("once in ten thousand right models");

    // Method trajectory: terms.

    /// Rounds of dropping and adding at most.
    SELECTION_ROUNDS: usize = 8, "rounds", PAPER;
    /// Changes that are tried in a round at most.
    TRIED_CHANGES: usize = 3, "changes", PAPER;
    /// Selections, each on the noise of the one before, at most.
    SELECTIONS: usize = 4, "selections", PAPER;
    /// A term whose share of the unknown rate is below this does not matter ...
    PRACTICAL_SHARE: f64 = 0.01, "part of the unknown rate", Basis::Judgement("a hundredth of a force is not worth a term");
    /// ... unless without it the cost would rise by more than this.
    INSISTENT_RISE: f64 = 60.0, "chi square", Basis::SetOn("the cases of the paper: chance lifts a term over the criterion now and then, true terms have hundreds");
    /// A difference of the criterion below this tells two choices of terms not apart.
    RIVAL: f64 = 6.0, "criterion", Basis::Derived("odds of twenty to one");
    /// Rivals are refitted if the quadratic model puts them within this many times that.
    RIVAL_REACH: f64 = 4.0, "times the difference", Basis::Judgement("the quadratic model may promise too little");
    /// How many rivals are refitted.
    RIVALS: usize = 2, "rivals", Basis::Judgement("the result names one");
    /// A new term of which less than this part is left beside the terms of the model is none.
    NEW_PART: f64 = 1e-12, "part of the curvature", NUMERICS;
    /// A new pair whose determinant is a smaller part of the product of its diagonal is one term.
    NEW_PAIR: f64 = 1e-10, "part of the determinant", NUMERICS;

    // Method trajectory: error bars.

    /// The coefficients of more terms than this keep the quadratic interval.
    PROFILED_TERMS: usize = 12, "terms", Basis::Judgement("each end of a profile costs some evaluations of the whole fit, and a model with so many terms was asked for, not selected");
    /// A fit may find this many times the delay that the residuals show.
    LATE_REACH: f64 = 30.0, "times", Basis::Judgement("the residuals show the delay to first order: the motion may have turned round within it");
    /// The probability from which a result says that something is so.
    SURE: f64 = 0.95, "probability", Basis::Convention("what intervals hold");
    /// Half of a 95 % interval.
    HALF_WIDTH_95: f64 = 1.959_963_984_540_054, "standard errors", NORMAL;
    /// The rise of the cost at the ends of a 95 % interval.
    RISE_95: f64 = 3.841_458_820_694_124, "chi square", Basis::Derived("quantile of chi square with one degree of freedom");
    /// The quadratic interval stands if the rise at its end is within this part of what it should be.
    PROFILE_QUADRATIC: f64 = 0.2, "part of the rise", Basis::Derived("a tenth of the interval");
    /// The search for an end of a profile ends within this part of the rise.
    PROFILE_END: f64 = 0.02, "part of the rise", Basis::Derived("a hundredth of the interval");
    /// Steps of that search.
    PROFILE_STEPS: usize = 5, "steps", NUMERICS;
    /// How far a step of that search may stretch or shrink the interval.
    PROFILE_STRETCH: [f64; 2] = [0.3, 3.0], "factors", NUMERICS;
    /// Damping of the step that all others make with it.
    PROFILE_DAMPING: f64 = 1e-9, "part of the diagonal", NUMERICS;
    /// Iterations and gain of the fit of all others at a point of a profile.
    PROFILE_MINIMUM: [f64; 2] = [5.0, 1e-6], "iterations, part of the cost", NUMERICS;
    /// How often that fit goes on while the others have yet to arrive.
    PROFILE_FITS: usize = 4, "fits", NUMERICS;
    /// A warning names correlations beyond this ...
    CORRELATED: f64 = 0.95, "1", Basis::Derived("the error of the sum or difference is a sixth of theirs");
    /// ... if one of the two is known worse than to this part of itself.
    VAGUE: f64 = 0.02, "part of the value", Basis::Judgement("who knows both to two per cent does not ask");

    // Free runs and verdict.

    /// The start state of a Validate record is fitted on this part of it.
    START_PART: usize = 10, "one in so many samples", Basis::Judgement("short beside what is predicted, long beside the noise");
    /// The start state and numbers of its own are fitted on this part.
    OWN_PART: usize = 2, "one in so many samples", Basis::Judgement("a phase needs more of the record than a start does");
    /// The start state is fitted on at least this many samples.
    START_SAMPLES: usize = 10, "samples", Basis::Judgement("a few for each state");
    /// Iterations and gain of the fit of a start state.
    START_MINIMUM: [f64; 2] = [20.0, 1e-9], "iterations, part of the cost", NUMERICS;
    /// What a start that is not known better may add to the power of the residual; where it adds more, the
    /// start state takes twice as much of the record.
    START_BLUR: f64 = 0.1, "power of the noise", BLIND;
    /// A free run worse than this is no model.
    WORST_NRMSE: f64 = 0.5, "NRMSE", Basis::Judgement("a quarter of the motion's power is missed");
    /// A known part that misses by less than this is complete, also where what it leaves is not quite noise.
    COMPLETE: f64 = 0.01, "NRMSE", Basis::Judgement("a hundredth of a motion is not worth a term");
    /// A column of which this part is noise shows no motion.
    NOISE_ONLY: f64 = 0.8, "part of the standard deviation", Basis::Judgement("two thirds of its power");
    /// A warning says that validation is this many times worse than the fit ...
    WORSE: f64 = 3.0, "times the NRMSE", PAPER;
    /// ... unless it is still below this.
    FINE_NRMSE: f64 = 0.05, "NRMSE", PAPER;
    /// A Validate record whose coefficients chance puts so far from the fit less often than once in a hundred
    /// thousand disagrees.
    RARE: f64 = 4.265, "standard deviations", NORMAL;
    /// Iterations and gain of the fit of the coefficients to a Validate record.
    AGREEMENT_MINIMUM: [f64; 2] = [20.0, 1e-6], "iterations, part of the cost", NUMERICS;
    /// Damping of the distance between the two.
    AGREEMENT_DAMPING: f64 = 1e-9, "part of the diagonal", NUMERICS;
    /// A motion goes in cycles of which this part lies in one line of its spectrum; what is left is a force of the motion
    /// if this part follows it.
    MOSTLY: f64 = 0.5, "part of the power", Basis::Judgement("more than all else together");

    // Calibration, for the gap workflow.

    /// A misfit above this is worth another start.
    MISFIT: f64 = 1.01, "chi square per sample", BLIND;
    /// Of a misfit above this the model is wrong, and other starts do not help.
    WRONG_MODEL: f64 = 30.0, "chi square per sample", BLIND;
    /// Starts round an end that misses.
    RESTARTS: u32 = 4, "starts", BLIND;
    /// Another start whose cost is more than this many times the present one is skipped.
    RESTART_PROMISE: f64 = 30.0, "times the cost", BLIND;
    /// How far such starts lie from the end.
    RESTART_REACH: f64 = 2.0, "standard errors of the misfit", BLIND;
    /// A fitted start this far from the smoothed motion is another run than the measured one.
    ASTRAY: f64 = 4.0, "standard deviations of the noise", BLIND;
    /// From segments to one run in smaller steps.
    STEPS_TO_ONE: [usize; 3] = [3, 2, 1], "segments of each record", BLIND;
    /// Iterations of a single run.
    SINGLE_ITERATIONS: usize = 40, "iterations", NUMERICS;
    /// Iterations and gain of a stage in segments.
    SEGMENTS_MINIMUM: [f64; 2] = [10.0, 1e-3], "iterations, part of the cost", NUMERICS;
    /// Iterations and gain from another start.
    RESTART_MINIMUM: [f64; 2] = [25.0, 1e-5], "iterations, part of the cost", NUMERICS;
    /// Far from the noise a gain below this part is none.
    FAR_GAIN: f64 = 1e-3, "part of the cost", Basis::Judgement("what is missing there is no digit");
    /// Steps of a trial model beside those for its samples.
    TRIAL_BASE_STEPS: usize = 1_000, "steps", BLIND;
    /// Steps for each sample of a trial model.
    TRIAL_STEPS: usize = 12, "steps", BLIND;
    /// Steps for each sample of a trial model with memory: one that fades within a part of a sample looks
    /// like none.
    MEMORY_STEPS: usize = 4, "steps", BLIND;
    /// Local error where trials are compared by a factor of their costs, or led to the start of a single run, and its
    /// upper limit; the part of the noise is for all samples of a segment together.
    ROUGH_TOLERANCE: [f64; 2] = [0.5, 1e-3], "part of the noise, part of the state's size", Basis::Derived("a quarter of the noise's power at the end of a segment, where costs are compared within a factor of three");
    /// Iterations and gain of a quick score in segments.
    QUICK_SEGMENTS: [f64; 2] = [4.0, 1e-2], "iterations, part of the cost", BLIND;
    /// Iterations and gain of a quick score in single runs.
    QUICK_SINGLE: [f64; 2] = [4.0, 1e-3], "iterations, part of the cost", BLIND;

    // States that only outputs tell.

    /// Powers of ten of the power of an unknown force (SI), least and largest ...
    WALK_DECADES: [i32; 2] = [-12, 12], "power of ten per second", Basis::Derived("from a rig of micrometres to one of tonnes; the likelihood chooses");
    /// ... and parts of the record that it remembers.
    WALK_MEMORIES: [f64; 3] = [0.3, 0.03, 0.003], "of the record", Basis::Judgement("a decade apart; the likelihood chooses");
    /// Samples whose likelihood chooses them.
    LIKELIHOOD_SAMPLES: usize = 2_000, "samples", Basis::Derived("enough to tell a decade of a variance");
    /// Standard deviation of a state at its start.
    DIFFUSE: f64 = 1e3, "SI", Basis::Derived("far above the motion of any rig");
    /// The largest and the smallest part of a covariance that keeps it from being singular.
    COVARIANCE_RIDGE: [f64; 2] = [1e-14, 1e-6], "of the largest variance, of its own", NUMERICS;

    // Noise of inputs.

    /// An input with larger changes from sample to sample is rough by itself.
    ROUGH_INPUT: f64 = 0.2, "of a standard deviation", BLIND;
    /// An input with less noise is exact.
    EXACT_INPUT: f64 = 1e-5, "of a standard deviation", Basis::Convention("the rounding of a converter of 16 bits over the range of a signal");
    /// Draws of as much noise once more: their mean tells a bias of a standard error from its scatter.
    BIAS_DRAWS: usize = 16, "draws", Basis::Judgement("cost; a standard deviation is then known to a sixth");

    // Truth of synthetic cases.

    /// Random points at which the truth is projected on the dictionary.
    TRUTH_POINTS: usize = 400, "points", Basis::Derived("many for each candidate");
    /// Damping of that projection.
    TRUTH_DAMPING: f64 = 1e-15, "part of the diagonal", NUMERICS;
    /// A truth that misses by more than this part of itself lies outside the dictionary.
    TRUTH_MISS: f64 = 1e-6, "part of the rate", NUMERICS;
    /// A term that is a smaller part of the truth is none of it.
    TRUTH_SHARE: f64 = 1e-5, "part of the rate", NUMERICS;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_decision_says_what_it_is() {
        for (k, d) in decisions().iter().enumerate() {
            assert!(!d.value.is_empty() && d.value.iter().all(|v| v.is_finite()), "{d:?}");
            assert!(!d.unit.is_empty() && d.meaning.len() > 10, "{d:?}");
            assert!(decisions()[..k].iter().all(|other| other.name != d.name), "{} stands twice", d.name);
        }
    }
}
