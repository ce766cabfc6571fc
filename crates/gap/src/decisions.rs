//! Every threshold and limit of this crate, in the order of the pipeline: what it decides, its unit, and its
//! basis. A value is a judgement where the history names no data that it was set on.

use phisindy_phys::{Basis, Decision, decisions};

/// The blind sets of the README, with hidden effects and with nothing hidden.
const BLIND: Basis =
    Basis::SetOn("blind sets with and without hidden effects (`phisindy-blind hidden`, seeds before 1907)");

/// Every decision of this crate as data: name, value, unit, meaning, basis.
pub fn decisions() -> &'static [Decision] {
    DECISIONS
}

decisions! {
    // Noise and whiteness.

    /// Smallest noise of a column that is assumed.
    CLEAN_COLUMN: f64 = 1e-5, "of a standard deviation", Basis::Derived("the local error of the simulation, added up along a record");
    /// Order of the differences that show whether the noise grows with the signal; odd.
    NOISE_ORDER: usize = 9, "differences", Basis::Derived("of a motion with twenty samples in a period they keep a millionth");
    /// Groups of samples by the size of the signal, in each of which the noise is measured.
    NOISE_GROUPS: usize = 8, "groups", Basis::Judgement("more would scatter, fewer would not show a form");
    /// Levels of noise within this factor of a form are described by it; the groups must differ by the square
    /// of it.
    NOISE_FORM: f64 = 1.5, "factor", Basis::Derived("two and a half standard errors of a median of a hundred differences that share samples");
    /// A residual with a larger whiteness score is more than noise.
    NOT_WHITE: f64 = 6.0, "standard deviations", Basis::Convention("six sigma; white residuals stay below 4 in simulation");
    /// A column with a larger fraction of noise shows no motion to explain.
    MOSTLY_NOISE: f64 = 0.8, "of a standard deviation", Basis::Judgement("the motion is then below three quarters of the noise");
    /// A shorter record cannot tell noise from motion.
    FEWEST_SAMPLES: usize = 64, "samples", Basis::Derived("the spectrum above the motion needs some tens of lines");
    /// Samples of all Fit records that a search uses; the final parameters come from all samples.
    SEARCHED_SAMPLES: usize = 6_000, "samples", Basis::Judgement("time of a search; more samples change no choice on the blind sets");
    // Repeatability.

    /// Step of the grid on which a period is searched for before it is refined.
    PERIOD_STEP: f64 = 1e-3, "of the period", Basis::Judgement("a record of some ten cycles tells the period better");
    /// The same for the period that predicts the record that continues.
    PERIOD_FINE_STEP: f64 = 2e-4, "of the period", Basis::Judgement("over twenty cycles it is a fortieth of a radian");
    /// A motion is periodic if its best periodic prediction has a smaller error.
    PERIODIC: f64 = 0.1, "of a standard deviation", BLIND;
    /// A larger ratio of the scatter in the two halves of a record means a transient.
    STEADY: f64 = 3.0, "factor", BLIND;
    /// A larger correlation of successive differences of cycles means a trend.
    TREND: f64 = 0.4, "correlation", Basis::Derived("those of independent cycles have the correlation -1/2, those of a transient point one way");
    /// A periodic motion is explained if the gap is at most this many times its repeatability.
    REPEATS: f64 = 1.25, "of the repeatability", Basis::SetOn("the frame with stick-slip (specs/frame_gap.ron)");
    /// A motion whose cycles differ by more has scatter of its own.
    SCATTERS: f64 = 5.0, "of the noise", Basis::SetOn("the frame with stick-slip (specs/frame_gap.ron)");
    // Drive.

    /// Spectral lines that are looked for in each rate.
    DRIVE_LINES: usize = 6, "lines", Basis::Judgement("a multisine of more tones is broadband, and no tone stands for it");
    /// Two frequencies are equal if their phases drift apart by less along a record.
    SAME_LINE: f64 = 1.0, "rad", Basis::Derived("the resolution of a record");
    /// Times at which a drive is compared with itself one period later.
    DRIVE_TIMES: usize = 400, "times", Basis::Judgement("cost");
    /// A drive repeats if it differs by less after a period.
    DRIVE_REPEATS: f64 = 0.05, "of its swing", BLIND;
    /// A spectral line of the drive has at least this fraction of the power of a rate.
    DRIVE_LINE: f64 = 0.05, "of the power", Basis::Judgement("noise has peaks too");
    /// Records whose drives differ by less are driven at one frequency.
    SAME_FREQUENCY: f64 = 0.05, "of the frequency", Basis::Judgement("stiffness and inertia need a wider spread to part");
    // Motion and rest.

    /// A smoothed velocity is at rest below this many standard errors ...
    REST_NOISE: f64 = 3.0, "standard errors", Basis::Convention("three sigma");
    /// ... or below this fraction of its rms value.
    REST_PART: f64 = 0.02, "of the rms velocity", BLIND;
    /// A shorter stop does not count in the screening ...
    SHORT_REST: f64 = 0.04, "of a period", BLIND;
    /// ... nor in the evidence from stops.
    SHORT_STOP: f64 = 0.06, "of a period", BLIND;
    /// A run comes to rest if more than one part in this many is at rest.
    RESTS: usize = 50, "1/part", Basis::Judgement("two per cent of a record");
    // Screen.

    /// Most rows of the regression.
    REGRESSION_ROWS: usize = 20_000, "rows", Basis::Judgement("cost; more rows change no order on the blind sets");
    /// Further starts that are kept for a law with grid parameters.
    GRID_STARTS: usize = 3, "starts", BLIND;
    /// The same for laws that oscillate.
    TONE_STARTS: usize = 8, "starts", BLIND;
    /// Most combinations of grid values that are tried.
    GRID_VALUES: usize = 200, "values", Basis::Judgement("cost");
    /// Most values of one grid parameter whose scale does not say how many.
    GRID_AXIS: usize = 12, "values", Basis::Judgement("neighbours then differ by less than a factor of two");
    /// Quantile of a quantity of the motion that counts as its maximum.
    TOP_QUANTILE: f64 = 0.99, "of the samples", Basis::Judgement("leaves out outliers");
    /// Speeds that are tried for a speed.
    GRID_SPEEDS: [f64; 9] = [0.01, 0.02, 0.04, 0.07, 0.12, 0.2, 0.3, 0.45, 0.7], "of the highest speed", Basis::Judgement("two decades, neighbours within a factor of two");
    /// Deflections of a contact that are tried where the law's file has a `screen` entry.
    GRID_DEFLECTIONS: [f64; 9] = [0.001, 0.003, 0.01, 0.02, 0.04, 0.08, 0.15, 0.3, 0.6], "of the largest displacement", Basis::Judgement("a contact that slips gives way by less than the motion");
    /// Clearances that are tried.
    GRID_GAPS: [f64; 13] = [0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95], "of the largest displacement", Basis::Judgement("nearly even: a clearance may be anywhere in the motion");
    /// Offsets from a spectral line that are tried for a frequency.
    BESIDE_LINE: [f64; 5] = [-0.5, -0.25, 0.0, 0.25, 0.5], "of the resolution of the record", Basis::Derived("lines are told apart at one resolution, and a response is lost beyond a quarter");
    /// Lengths that are tried for a law with memory: first and last.
    GRID_LENGTHS: [f64; 2] = [0.005, 1.0], "of the motion's length", Basis::Judgement("a shorter one is a jump, a longer one a spring");
    /// Times that are tried: first and last.
    GRID_TIMES: [f64; 2] = [0.03, 30.0], "of length over speed of the motion", Basis::Judgement("a shorter one is no memory, a longer one a constant");
    /// Ratios of two forces of one law that are tried: first and last.
    GRID_FORCES: [f64; 2] = [0.5, 3.0], "factor", Basis::Judgement("levels of one contact are of one size");
    /// Quarter periods along the swing that are tried for a force that is periodic in the position: first,
    /// and the one after the last.
    GRID_QUARTERS: [usize; 2] = [2, 120], "quarters", Basis::Judgement("half a period, to thirty periods");
    /// A number without a unit is tried up to this, and down to its inverse.
    MOST_NUMBER: f64 = 100.0, "factor", Basis::Judgement("ratios of one law are not larger");
    /// A step of an internal state that would cross a point of rest is halved so often.
    HALVINGS: usize = 20, "halvings", Basis::Derived("to a millionth of the step, the accuracy of numbers that are starts");
    /// Points of a grid of several axes that are followed to where the law explains most.
    FOLLOWED: usize = 3, "starts", Basis::Judgement("cost; the best points of a grid lie in one or two valleys");
    /// Steps by which they are followed, one after the other.
    FOLLOWS: [f64; 3] = [0.5, 0.25, 0.1], "of the step of a grid", Basis::Judgement("a fit goes on from there");
    /// Laws are followed that explain this much of what the best law explains.
    FOLLOWED_FROM: f64 = 0.8, "of the gain", Basis::Judgement("cost; on the right point a law gains a tenth more than beside it");
    /// A step that gains less ends there.
    FOLLOWED_GAIN: f64 = 1e-4, "of the gain", Basis::Judgement("less than two laws of one family differ by");
    /// Starts of a law that enter the joint regression, best first.
    GRID_KEPT: usize = 9, "starts", Basis::Judgement("cost; the others are worse in the regression of the law alone");
    /// A body rests in a record where its smoothed speed is below this part of its standard deviation.
    RESTS_BELOW: f64 = 0.1, "part", Basis::Judgement("what smoothing leaves of a speed after a stop");
    /// A column is degenerate if projecting out the free columns leaves less.
    DEGENERATE: f64 = 1e-7, "of a column", Basis::Derived("rounding of a Gram matrix of some thousand rows");
    /// Decay rate of the linear response of a body that comes to rest.
    FORGETS_PER_PERIOD: f64 = 4.0, "1/period", BLIND;
    /// A mode of the known part this much slower than the motion sums up its forces, and is made to decay.
    DRIFTS: f64 = 0.1, "of the motion's frequency", Basis::Judgement("a decade: slower than any spring that moves the body");
    /// A start from the force of a sibling is fitted if it explains this fraction of what the best one does.
    NEARLY_BEST: f64 = 0.9, "of the gain", BLIND;
    /// Below this speed the motion counts as resting for such a start.
    SLOW: f64 = 2e-3, "of the highest speed", Basis::Judgement("three decades below the motion");
    /// Speed of a contact that has just begun to slip.
    JUST_SLIPS: f64 = 1e-5, "of the highest speed", Basis::Judgement("far below any speed that a law resolves");
    /// A start meets the condition of its law by this margin.
    INSIDE: f64 = 0.25, "of the level", Basis::Judgement("on the border the numbers that shape the law have no say");
    // Search.

    /// Pairs with a plain law are fitted if a richer law of its family gains this much.
    PLAIN_GAIN: f64 = 0.5, "of the best gain", BLIND;
    /// Leading laws whose whole family is fitted.
    LEADERS: usize = 3, "laws", BLIND;
    /// A neutral start of a force is this fraction of its regression and has almost no influence.
    NEUTRAL: f64 = 0.05, "of the start", BLIND;
    /// Most effects of one model.
    MOST_EFFECTS: usize = 4, "effects", Basis::Judgement("four free curves fit anything, see ELEPHANT");
    /// Leading single laws of a screening that are fitted.
    FITTED_IN_FULL: usize = 6, "models", BLIND;
    /// Leading pairs of a screening that enter the race. A rich law beside any other law leads the list, so a
    /// catalogue of more laws needs a longer one.
    PAIRS_RACED: usize = 24, "models", BLIND;
    /// Least gain of a new effect.
    WORTH: f64 = 10.0, "BIC", Basis::Convention("very strong evidence, Kass and Raftery 1995, doi 10.1080/01621459.1995.10476572");
    /// A simpler model within this distance is preferred.
    SIMPLER: f64 = 3.0, "BIC", Basis::Convention("a difference of 2 to 6 is positive evidence, Kass and Raftery 1995");
    /// An effect that leaves a larger fraction of the gap on Validate records explains nothing.
    SHRINKS: f64 = 0.98, "of the gap", BLIND;
    /// A round is weak if it leaves a larger fraction of a gap far above the noise. After two weak rounds the
    /// search ends.
    WEAK_ROUND: f64 = 0.8, "of the gap", BLIND;
    /// A model far from the noise makes progress if it lowers the gap on Fit records to this, whatever the
    /// gap on Validate records is.
    ON_THE_WAY: f64 = 0.5, "of the gap", BLIND;
    /// Rounds in which a family of friction laws is fitted again from a new leader.
    FAMILY_ROUNDS: usize = 2, "rounds", BLIND;
    /// A model is fitted in full if its segment cost is within this factor of the best.
    RACE: f64 = 3.0, "factor", BLIND;
    /// A rival whose segments leave more than this times what the runs of a fitted model leave is not fitted
    /// to the end.
    SEGMENTS_END: f64 = 1.02, "of chi square", Basis::Derived("the fit of segments ends within some thousandths of its least cost");
    /// Models within this factor of the best gap, or of the noise, are fitted from more starts ...
    WORTH_STARTS: f64 = 2.0, "factor", BLIND;
    /// ... at most this many of them.
    MORE_STARTS: usize = 4, "models", Basis::Judgement("cost");
    /// Rivals that a round reports.
    RIVALS: usize = 5, "rivals", Basis::Judgement("what a reader reads");
    /// Gaps on Validate records within this factor count as equal.
    SAME_GAP: f64 = 1.02, "factor", BLIND;
    /// A smaller gap on Fit records is near the noise.
    NEAR_NOISE: f64 = 1.5, "of the noise", BLIND;
    /// A richer law must lower the gap on Validate records to this where the residual is not white.
    RICHER: f64 = 0.95, "of the gap", BLIND;
    /// The starts of one law are compared on every third segment.
    SEEDED_STRIDE: usize = 3, "segments", Basis::Judgement("cost");
    /// Starts of a requested law, and of laws with memory where one of them leads, that are fitted in full.
    STARTS_WITH_MEMORY: usize = 3, "starts", BLIND;
    // Scores.

    /// The logarithm of a number inside a law is uniform over a range of at most this factor.
    INNER_RANGE: f64 = 1e3, "factor", Basis::Convention("from what a record resolves to its motion, three decades; the price changes with the logarithm of the logarithm");
    /// A larger rise of chi square is not chance.
    CHOW: f64 = 5.0, "standard deviations", Basis::Convention("five sigma of chi square, mean n and variance 2 n");
    /// A model that explains a record has a smaller gap.
    EXPLAINED: f64 = 1.08, "of the noise", BLIND;
    /// The mean square of noise may be larger by this by chance.
    CHANCE: f64 = 3.0, "standard deviations", Basis::Convention("three sigma; the mean of n squares of noise has the standard deviation sqrt(2/n)");
    /// A larger gap on Fit records is far from the noise: more than one effect is missing.
    FAR_OFF: f64 = 2.0, "of the noise", BLIND;
    /// Price of a sensor property, the less plausible explanation where a force does as well.
    SENSOR_PRICE: f64 = 6.0, "BIC", BLIND;
    /// Price of a property of an input: where a sensor property does as well, it is named, by more than
    /// `SIMPLER`.
    INPUT_PRICE: f64 = 10.0, "BIC", Basis::Derived("SENSOR_PRICE and SIMPLER, and one more so that ties are clear");
    /// Price of a negative sensor delay.
    EARLY_PRICE: f64 = 15.0, "BIC", BLIND;
    /// Residuals with a larger fraction of independent samples count in full.
    INDEPENDENT: f64 = 0.6, "of the samples", BLIND;
    /// With a smaller gap on Fit records, the gap on Validate records may come from the uncertainty of the
    /// fit.
    LITTLE_LEFT: f64 = 1.1, "of the noise", BLIND;
    /// The model does not follow a column with a larger NRMSE.
    STANDS_STILL: f64 = 0.95, "NRMSE", Basis::Derived("a model that stands still has the NRMSE 1");
    // Formulas.

    /// Most rows of the response in which formulas are sought; neighbouring rows are averaged.
    FORMULA_ROWS: usize = 2_400, "rows", Basis::Judgement("cost; a motion has some tens of periods of which each needs some tens of rows");
    /// Error of the linear response: no column is taken for cleaner than this where formulas are ranked.
    RESPONSE_ERROR: f64 = 1e-3, "of the standard deviation", Basis::Judgement("of clean data, the error that the right formula leaves is about this large");
    /// Symbols of which expressions are made: the price of one is twice the logarithm of this.
    FORMULA_ALPHABET: usize = 18, "symbols", Basis::Derived("operations, functions, variables and numbers that occur in the table of atoms");
    /// Most terms of a formula.
    FORMULA_TERMS: usize = 4, "terms", Basis::Judgement("four free curves fit anything, see ELEPHANT");
    /// Sums that are kept at each length of the selection.
    FORMULA_BEAM: usize = 60, "sums", Basis::Judgement("cost");
    /// Sums whose inner numbers are refined.
    FORMULA_REFINED: usize = 80, "sums", Basis::Judgement("cost");
    /// Columns of each shape that begin a sum: the best of its grid.
    FORMULA_SINGLES: usize = 3, "columns", Basis::Judgement("cost; the best alone, and its neighbours");
    /// Formulas that are fitted in full in a pass.
    FORMULAS_FITTED: usize = 12, "models", Basis::Judgement("cost");
    /// Passes: each one goes along the run of the best formula of the one before.
    FORMULA_PASSES: usize = 3, "passes", Basis::Judgement("the run of the second is within the noise of that of the third");
    /// Knots of a force without a formula over one quantity.
    FORCE_KNOTS: [usize; 4] = [4, 8, 16, 32], "knots", Basis::Judgement("the description length chooses among them");
    /// Knots of a force over displacement and velocity, of each.
    FORCE_SURFACE_KNOTS: [usize; 3] = [4, 7, 11], "knots", Basis::Judgement("the description length chooses among them; cost");
    /// At a place that rests a force may be all that is missing if it leaves this, or what is far from the
    /// noise elsewhere.
    FORCE_AT_REST: f64 = 0.1, "of the gap", Basis::SetOn("blind sets with friction that holds, where the response is not exact");
    /// Deflections at which springs slip, for a force that remembers.
    FORCE_DEFLECTIONS: [f64; 5] = [0.05, 0.1, 0.2, 0.4, 0.8], "of the largest displacement", Basis::Judgement("octaves: their sum is any hysteresis");
    /// Times after which springs behind dashpots forget.
    FORCE_TIMES: [f64; 5] = [0.05, 0.15, 0.5, 1.5, 5.0], "of half a swing", Basis::Judgement("half decades: their sum is any relaxation");
    /// Knots of a spline over the time, for a force that drifts.
    FORCE_TIME_KNOTS: usize = 4, "knots", Basis::Judgement("a drift is slow");
    // Evidence.

    /// A contact is not elastic if its deflection is a smaller fraction of the predicted one.
    GIVES_WAY: f64 = 0.3, "of the law", Basis::SetOn("the frame with stick-slip and blind sets with presliding");
    /// A friction law is ruled out if it returns a larger fraction of the energy that it dissipates.
    GIVES_BACK: f64 = 0.01, "of the energy", BLIND;
    /// A resistance must take energy at this many times the measured speeds too.
    FAR_ABOVE: f64 = 10.0, "factor", Basis::Judgement("a law that is right does not end a decade above the record");
    /// An elastic contact whose force stays below this never slips.
    SLIPS: f64 = 0.5, "of the level", BLIND;
    /// Models whose residuals differ by less in all records together are one there.
    SAME_MOTION: f64 = 0.1, "chi square", Basis::Derived("it changes the odds of two models by a factor of 1.4 at most: exp(sqrt(0.1))");
    /// Forces that differ by less are one: a law's and another one, a damper's at slow and at quick motion.
    SAME_FORCE: f64 = 0.05, "of the force", Basis::Convention("forces that differ by less than a twentieth are one");
    // The end.

    /// This number of effects can hide whatever is missing.
    ELEPHANT: usize = 4, "effects", Basis::Convention("J. von Neumann: with four parameters I can fit an elephant");
    /// With one effect fewer, the gap on Fit records must be below this.
    CLEAN_FIT: f64 = 1.02, "of the noise", Basis::SetOn("blind sets with two springs of the fifth power");
    /// This number of elastic effects at one place can describe any curve.
    BENT: usize = 3, "effects", Basis::SetOn("blind sets with two springs of the fifth power");
    /// An effect that leaves a larger fraction does not help on data not used.
    HELPS: f64 = 0.95, "of the gap", BLIND;
    /// Effects are kept although something else is missing if they reduce the gap by this factor each.
    SUBSTANTIAL: f64 = 3.0, "factor", BLIND;
    /// Two constants, or two columns, are mixed up if the exchange leaves a smaller fraction of the gap.
    EXCHANGED: f64 = 0.333_333_333_333_333_3, "of the gap", Basis::Judgement("nine tenths of the squared gap are then gone, without a new number");
    /// Two effects cancel each other if the rms of their sum is a smaller fraction of that of the smaller
    /// one.
    CANCELS: f64 = 0.5, "of a force", Basis::Judgement("the smaller one is then mostly taken up by the other");
    /// A sensor may bend its scale by this much.
    SENSOR_LINEARITY: f64 = 0.005, "of a standard deviation", Basis::Convention("accuracy class 0.5 of measuring instruments, IEC 60051");
    /// Searches without the laws that the records do not determine or that evidence rules out at the end.
    SEARCHES_AGAIN: usize = 2, "searches", Basis::Judgement("time of a search");
    /// A part of the motion is reported if its share of the gap exceeds its share of the samples by this.
    SURPLUS: f64 = 0.15, "of the gap", Basis::Judgement("a smaller surplus says little");
    /// Samples of a record in a plot of a force.
    PICTURE_SAMPLES: usize = 4_000, "samples", Basis::Judgement("more would not show");
    // Other explanations.

    /// A fixed constant may be wrong by this factor.
    CONSTANT_OFF: f64 = 3.0, "factor", Basis::Judgement("a larger mistake would be seen by hand");
    /// Most constants of the spec that have changed.
    MOST_CHANGED: usize = 3, "constants", Basis::Judgement("with more of them it is another rig");
    /// The speeds about a turn: of so many samples on either side, and of those beyond, up to so many.
    TURN_SAMPLES: [usize; 2] = [3, 6], "samples", Basis::Judgement("three samples tell a slope; a bounce lasts longer than twelve");
    /// A turn is an impact if this part of the change of speed happens within the shorter time.
    SUDDEN: f64 = 0.7, "part", Basis::Derived("half way from 0.4, a steady acceleration, to 1, an impact");
    /// Choices of changed constants beside which another one is freed.
    CHANGES_KEPT: usize = 3, "models", Basis::Judgement("a mass and a stiffness do nearly the same to a resonance");
    /// Models with a free constant that are fitted in full.
    CONSTANTS_FITTED: usize = 6, "models", BLIND;
    /// Constants with which the catalogue is screened again.
    CONSTANTS_SCREENED: usize = 2, "constants", Basis::Judgement("cost");
    /// The clock of the drive may be slower or faster by this fraction.
    CLOCK_OFF: f64 = 0.1, "factor", Basis::Judgement("a larger mistake would be seen by hand");
    /// The search is repeated with another drive frequency if that alone lowers the gap to this.
    CLOCK_HELPS: f64 = 0.9, "of the gap", BLIND;
    /// Another drive frequency is reported as a cause if it lowers the gap to this, whatever else is missing.
    CLOCK_CAUSE: f64 = 0.333_333_333_333_333_3, "of the gap", BLIND;
    /// Two start values closer than this count as one.
    SAME_RATIO: f64 = 1e-3, "factor", Basis::Judgement("the fit moves further than that");
    /// A tone or a drift with at least this fraction of a residual is reported.
    MOST_OF_RESIDUAL: f64 = 0.5, "of the power", Basis::Judgement("it is then the larger part");
    /// Noise of inputs that accounts for this fraction of a gap is reported.
    INPUT_NOISE_PART: f64 = 0.25, "of the gap", BLIND;
    /// Number of noise draws: what is left is larger than all of them by chance once in twenty times.
    INPUT_NOISE_DRAWS: usize = 19, "draws", Basis::Convention("a Monte Carlo test at 5 %, A. C. A. Hope 1968");
    /// So many are made at once; their mean says whether more are worth it.
    INPUT_NOISE_BLOCK: usize = 4, "draws", Basis::Judgement("a mean of four is known to a half");
    /// A law is sure beside its rivals from this probability on.
    SURE: f64 = 0.95, "probability", Basis::Convention("one in twenty");
    /// Most pushes in a record, on average: a force that comes oftener is looked for as a law.
    MOST_PUSHES: usize = 3, "pushes", Basis::Convention("few enough to be told one by one");
    /// Most of a record that pushes may take.
    PUSHED_PART: f64 = 0.5, "of the samples", Basis::Convention("the larger part is what the model is judged on");
    /// A column with the shape of the model's, but larger or smaller by this factor, has a wrong unit.
    WRONG_UNIT: f64 = 5.0, "factor", BLIND;
    /// If model and rig differ by more in size, a unit is wrong and no effect is missing.
    OUT_OF_PROPORTION: f64 = 300.0, "factor", BLIND;
    /// A model that moves a column by less says nothing of it.
    SAYS_NOTHING: f64 = 1e-12, "of the column", Basis::Judgement("from nano to kilo: no two units in use are further apart");
    /// A column with a larger standard deviation moves.
    MOVES: f64 = 10.0, "of the noise", Basis::Judgement("ten times the noise is a motion");
    /// Bumps over the range of a speed or a displacement, where a force has no form.
    NONE_BUMPS: usize = 9, "bumps", Basis::Judgement("a friction curve has three to five features between its ends");
    /// Sizes of such a force between the least that is seen and the whole force on the body.
    NONE_SIZES: usize = 13, "sizes", Basis::Judgement("three to four in a decade; the average changes little with more");
    /// Two curves with a larger correlation have the same shape.
    ONE_SHAPE: f64 = 0.95, "correlation", BLIND;
    /// A column with a smaller correlation does not follow its own model.
    OTHER_SHAPE: f64 = 0.8, "correlation", BLIND;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_every_decision_is_documented() {
        for (k, d) in decisions().iter().enumerate() {
            assert!(decisions()[..k].iter().all(|other| other.name != d.name), "{} occurs twice", d.name);
            assert!(!d.value.is_empty() && d.value.iter().all(|v| v.is_finite()), "{d:?}");
            assert!(!d.unit.is_empty() && d.meaning.len() > 10, "{d:?}");
        }
    }
}
