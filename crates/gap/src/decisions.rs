//! Every number of this crate that decides something, in the order of the pipeline: what it decides, in which unit, and why it is what it is.
//! Where the history tells of no data that a number was set on, its basis is a judgement.

use phisindy_phys::{Basis, Decision, decisions};

/// The blind sets of the README: hidden effects, and nothing hidden.
const BLIND: Basis =
    Basis::SetOn("blind sets with and without hidden effects (`phisindy-blind hidden`, seeds before 1907)");

/// Every decision of this crate as data: name, value, unit, meaning, basis.
pub fn decisions() -> &'static [Decision] {
    DECISIONS
}

decisions! {
    // Noise and whiteness.

    /// A clean column counts as known to this part of its standard deviation.
    CLEAN_COLUMN: f64 = 1e-5, "of a standard deviation", Basis::Derived("the local error of the simulation, added up along a record");
    /// A larger whiteness score is more than noise.
    NOT_WHITE: f64 = 6.0, "standard deviations", Basis::Convention("six sigma; white residuals stay below 4 in simulation");
    /// A column with a larger part of noise shows no motion to explain.
    MOSTLY_NOISE: f64 = 0.8, "of a standard deviation", Basis::Judgement("the motion is then below three quarters of the noise");
    /// A shorter record cannot tell noise from motion.
    FEWEST_SAMPLES: usize = 64, "samples", Basis::Derived("the spectrum above the motion needs some tens of lines");
    /// Samples of all Fit records that a search uses; the numbers come from all samples.
    SEARCHED_SAMPLES: usize = 6_000, "samples", Basis::Judgement("time of a search; more samples change no choice on the blind sets");
    // Repeatability.

    /// A motion is periodic if its best periodic prediction misses less than this part of it.
    PERIODIC: f64 = 0.1, "of a standard deviation", BLIND;
    /// Scatter in one half of a record beyond this many times that in the other half is a transient.
    STEADY: f64 = 3.0, "factor", BLIND;
    /// Successive differences of cycles that are more alike are a trend.
    TREND: f64 = 0.4, "correlation", Basis::Derived("those of independent cycles have the correlation -1/2, those of a transient point one way");
    /// A motion that is followed to this many times what it repeats to is explained.
    REPEATS: f64 = 1.25, "of the repeatability", Basis::SetOn("the frame with stick-slip (specs/frame_gap.ron)");
    /// A motion whose cycles differ by more has a scatter of its own.
    SCATTERS: f64 = 5.0, "of the noise", Basis::SetOn("the frame with stick-slip (specs/frame_gap.ron)");
    // Drive.

    /// Frequencies that are looked for in each rate.
    DRIVE_LINES: usize = 6, "lines", Basis::Judgement("a multisine of more tones is broadband, and no tone stands for it");
    /// Two frequencies whose phases drift apart by less along a record are one.
    SAME_LINE: f64 = 1.0, "rad", Basis::Derived("the resolution of a record");
    /// Times at which a drive is compared with itself one period later.
    DRIVE_TIMES: usize = 400, "times", Basis::Judgement("cost");
    /// A drive that differs by less after a period repeats.
    DRIVE_REPEATS: f64 = 0.05, "of its swing", BLIND;
    /// A line of the drive holds at least this part of the power of a rate.
    DRIVE_LINE: f64 = 0.05, "of the power", Basis::Judgement("noise has peaks too");
    // Motion and rest.

    /// A smoothed velocity below this many standard errors rests ...
    REST_NOISE: f64 = 3.0, "standard errors", Basis::Convention("three sigma");
    /// ... or below this part of its usual size.
    REST_PART: f64 = 0.02, "of the rms velocity", BLIND;
    /// A stop that is shorter does not count in the screen ...
    SHORT_REST: f64 = 0.04, "of a period", BLIND;
    /// ... nor in the evidence of stops.
    SHORT_STOP: f64 = 0.06, "of a period", BLIND;
    /// A run of which more than one part in so many stands still comes to rest.
    RESTS: usize = 50, "1/part", Basis::Judgement("two per cent of a record");
    // Screen.

    /// Most rows of the regression.
    REGRESSION_ROWS: usize = 20_000, "rows", Basis::Judgement("cost; more rows change no order on the blind sets");
    /// Other starts that are kept for a law with numbers on a grid.
    GRID_STARTS: usize = 3, "starts", BLIND;
    /// The same for laws that oscillate.
    TONE_STARTS: usize = 8, "starts", BLIND;
    /// Values of a grid beyond these are not tried.
    GRID_VALUES: usize = 200, "values", Basis::Judgement("cost");
    /// A column of which less is left after projecting out what may move is no candidate.
    DEGENERATE: f64 = 1e-7, "of a column", Basis::Derived("rounding of a Gram matrix of some thousand rows");
    /// Decay of the linear response of a body that comes to rest.
    FORGETS_PER_PERIOD: f64 = 4.0, "1/period", BLIND;
    /// A start from the force of a sibling that explains this part of what the best one does is fitted too.
    NEARLY_BEST: f64 = 0.9, "of the gain", BLIND;
    /// Below it the motion counts as resting for such a start.
    SLOW: f64 = 2e-3, "of the highest speed", Basis::Judgement("three decades below the motion");
    /// A contact that has just begun to slip.
    JUST_SLIPS: f64 = 1e-5, "of the highest speed", Basis::Judgement("far below any speed that a law resolves");
    /// A start fulfils the condition of its law by this part of the level.
    INSIDE: f64 = 0.25, "of the level", Basis::Judgement("on the border the numbers that shape the law have no say");
    // Search.

    /// Pairs with the plain law of a family whose richer law gains this much are fitted too.
    PLAIN_GAIN: f64 = 0.5, "of the best gain", BLIND;
    /// Leading laws whose whole family is fitted.
    LEADERS: usize = 3, "laws", BLIND;
    /// A force that starts at this part of its regression does next to nothing.
    NEUTRAL: f64 = 0.05, "of the start", BLIND;
    /// Most effects of one model.
    MOST_EFFECTS: usize = 4, "effects", Basis::Judgement("four free curves fit anything, see ELEPHANT");
    /// Single laws, and pairs, that are fitted in full.
    FITTED_IN_FULL: usize = 6, "models", BLIND;
    /// What a new effect must gain.
    WORTH: f64 = 10.0, "BIC", Basis::Convention("very strong evidence, Kass and Raftery 1995, doi 10.1080/01621459.1995.10476572");
    /// A simpler description within this is preferred.
    SIMPLER: f64 = 3.0, "BIC", Basis::Convention("a difference of 2 to 6 is positive evidence, Kass and Raftery 1995");
    /// An effect that leaves more of the gap on Validate records explains nothing of note.
    SHRINKS: f64 = 0.98, "of the gap", BLIND;
    /// A round that leaves more of a gap far above the noise is a weak one; after two of them nothing in the catalogue helps.
    WEAK_ROUND: f64 = 0.8, "of the gap", BLIND;
    /// A model far from the noise that brings the gap on Fit records to this part is on the way, whatever Validate records say.
    ON_THE_WAY: f64 = 0.5, "of the gap", BLIND;
    /// How often a family of friction laws is tried again from a new leader.
    FAMILY_ROUNDS: usize = 2, "rounds", BLIND;
    /// A model whose cost over segments is this many times that of the best is not fitted in full.
    RACE: f64 = 3.0, "factor", BLIND;
    /// Models within this factor of the best gap, or of the noise, are fitted from more starts ...
    WORTH_STARTS: f64 = 2.0, "factor", BLIND;
    /// ... so many of them at most.
    MORE_STARTS: usize = 4, "models", Basis::Judgement("cost");
    /// Rivals that a round tells.
    RIVALS: usize = 5, "rivals", Basis::Judgement("what a reader reads");
    /// Gaps on Validate records within this factor are the same.
    SAME_GAP: f64 = 1.02, "factor", BLIND;
    /// A gap on Fit records below this is near the noise.
    NEAR_NOISE: f64 = 1.5, "of the noise", BLIND;
    /// A richer law must lower the gap on Validate records to this part, where more than noise is left.
    RICHER: f64 = 0.95, "of the gap", BLIND;
    /// The starts of one law are compared on every third segment.
    SEEDED_STRIDE: usize = 3, "segments", Basis::Judgement("cost");
    /// Starts of a law that a spec names that are fitted in full.
    REQUESTED_STARTS: usize = 3, "starts", BLIND;
    // Scores.

    /// A rise of chi square by more than this is no chance.
    CHOW: f64 = 5.0, "standard deviations", Basis::Convention("five sigma of chi square, mean n and variance 2 n");
    /// A model that explains a record leaves less.
    EXPLAINED: f64 = 1.08, "of the noise", BLIND;
    /// A larger gap on Fit records is far from the noise: more than one effect is missing.
    FAR_OFF: f64 = 2.0, "of the noise", BLIND;
    /// Price of a sensor, which is the worse story where a force does as well.
    SENSOR_PRICE: f64 = 6.0, "BIC", BLIND;
    /// Price of a sensor that would have to be early.
    EARLY_PRICE: f64 = 15.0, "BIC", BLIND;
    /// Residuals of which at least this part is independent count in full.
    INDEPENDENT: f64 = 0.6, "of the samples", BLIND;
    /// Where Fit records leave less, what Validate records leave may be the uncertainty of the fit.
    LITTLE_LEFT: f64 = 1.1, "of the noise", BLIND;
    /// A column with a larger NRMSE is not followed.
    STANDS_STILL: f64 = 0.95, "NRMSE", Basis::Derived("a model that stands still has the NRMSE 1");
    // Evidence.

    /// An elastic contact that gives way less than this part of what the law asks for does not give way.
    GIVES_WAY: f64 = 0.3, "of the law", Basis::SetOn("the frame with stick-slip and blind sets with presliding");
    /// Friction that gives back a larger part of the energy that it takes is none.
    GIVES_BACK: f64 = 0.01, "of the energy", BLIND;
    /// A parameter beyond this part of what its law allows has no end.
    NO_END: f64 = 0.5, "of the bound", Basis::Judgement("bounds of laws are far beyond any rig");
    /// An elastic contact whose force stays below this never slips.
    SLIPS: f64 = 0.5, "of the level", BLIND;
    // The end.

    /// So many effects cover up whatever is missing.
    ELEPHANT: usize = 4, "effects", Basis::Convention("J. von Neumann: with four parameters I can fit an elephant");
    /// One effect fewer must leave no more on Fit records.
    CLEAN_FIT: f64 = 1.02, "of the noise", Basis::SetOn("blind sets with two springs of the fifth power");
    /// So many elastic effects at one place draw any curve.
    BENT: usize = 3, "effects", Basis::SetOn("blind sets with two springs of the fifth power");
    /// An effect that leaves more is no help on data not used.
    HELPS: f64 = 0.95, "of the gap", BLIND;
    /// An effect is kept although something else is missing if each one so far has brought the gap down by this factor.
    SUBSTANTIAL: f64 = 3.0, "factor", BLIND;
    /// A larger gap on Fit records is not the work of one constant.
    ONE_CONSTANT: f64 = 5.0, "of the noise", BLIND;
    /// A part of the motion is told if its share of the gap exceeds its share of the samples by this.
    SURPLUS: f64 = 0.15, "of the gap", Basis::Judgement("a smaller surplus says little");
    /// Samples of a record in a picture of a force.
    PICTURE_SAMPLES: usize = 4_000, "samples", Basis::Judgement("more would not show");
    // Other explanations.

    /// A constant that the spec holds may be off by this part.
    CONSTANT_OFF: f64 = 0.3, "of a constant", Basis::Judgement("a larger mistake would be seen by hand");
    /// Models with a free constant that are fitted in full.
    CONSTANTS_FITTED: usize = 6, "models", BLIND;
    /// Constants beside which the catalogue is screened anew.
    CONSTANTS_SCREENED: usize = 2, "constants", Basis::Judgement("cost");
    /// The time of the drive may run slower or faster by this part.
    CLOCK_OFF: f64 = 0.1, "factor", Basis::Judgement("a larger mistake would be seen by hand");
    /// A frequency that lowers the gap to this part may be what the search went astray on.
    CLOCK_HELPS: f64 = 0.9, "of the gap", BLIND;
    /// A gap that falls to this part has found its cause, whatever else is missing.
    CLOCK_CAUSE: f64 = 0.333_333_333_333_333_3, "of the gap", BLIND;
    /// Two starts as near as this are one.
    SAME_RATIO: f64 = 1e-3, "factor", Basis::Judgement("the fit moves further than that");
    /// A tone, or a drift, that holds at least this part of a residual is told.
    MOST_OF_RESIDUAL: f64 = 0.5, "of the power", Basis::Judgement("it is then the larger part");
    /// Noise of inputs that accounts for this part of a gap is told.
    INPUT_NOISE_PART: f64 = 0.25, "of the gap", BLIND;
    /// How often as much noise is drawn: a rig that swings at one frequency answers each draw otherwise.
    INPUT_NOISE_DRAWS: usize = 4, "draws", Basis::Judgement("cost");
    /// An input that changes by more from sample to sample is rough by itself.
    ROUGH_INPUT: f64 = 0.2, "of a standard deviation", BLIND;
    /// A column that is this many times what the model gives, in its very shape, has the wrong unit.
    WRONG_UNIT: f64 = 5.0, "factor", BLIND;
    /// A model that moves this many times as much as the rig, or as much less, lacks no effect: a unit is wrong.
    OUT_OF_PROPORTION: f64 = 300.0, "factor", BLIND;
    /// The motion of a rig that is not at rest is larger.
    MOVES: f64 = 10.0, "of the noise", Basis::Judgement("ten times the noise is a motion");
    /// Two curves with a larger correlation have one shape.
    ONE_SHAPE: f64 = 0.95, "correlation", BLIND;
    /// A column with a smaller correlation does not follow its own model.
    OTHER_SHAPE: f64 = 0.8, "correlation", BLIND;
}
