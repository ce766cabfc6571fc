//! Every number of this crate that decides something, in the order of the pipeline: what it decides, its unit
//! and its basis.
//!
//! The coefficients of published formulas (Dormand-Prince, JONSWAP) decide nothing and stand beside their
//! code.

use phisindy_phys::{Basis, Decision, decisions};

/// What separates a result from rounding errors.
const ROUNDING: Basis = Basis::Judgement("far above rounding errors, far below anything a record shows");
/// The rules of step control.
const HAIRER: Basis =
    Basis::Convention("Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, II.4");
/// Friction that is singular at rest: without these limits its derivatives are wrong by orders of magnitude.
const SINGULAR_FRICTION: Basis =
    Basis::SetOn("Dieterich-Ruina friction (`crates/sim/tests/work.rs`, `sensitivities.rs`)");

/// Every decision of this crate as data: name, value, unit, meaning, basis.
pub fn decisions() -> &'static [Decision] {
    DECISIONS
}

decisions! {
    // Friction near rest.

    /// The distance from the surface at which friction is evaluated if it is singular at zero speed.
    OFF_SURFACE: f64 = 1e-6, "speed scale", Basis::Judgement("far below the speeds of a motion, and friction is still finite there");
    /// The distance beyond its surface over which friction is continued smoothly.
    MARGIN: f64 = 1e-10, "speed scale", Basis::Judgement("above the error of a located event, far below `OFF_SURFACE`");
    /// The smallest speed that the step control distinguishes from rest.
    LEAST_SPEED: f64 = 1e-9, "speed scale", ROUNDING;

    // Contact rule.

    /// The stick test accepts a load that exceeds the friction limit by less than this part.
    STICK_SLACK: f64 = 1e-12, "part of the friction limit", Basis::Judgement("rounding must not release a contact at the instant at which it comes to rest");
    /// After a jump of an input, a contact further than this from rest no longer sticks.
    DETACHED: f64 = 1e-9, "speed scale", ROUNDING;
    /// A pivot below this part of the largest entry of the system for the sticking modes is zero: the other
    /// contacts decide this one.
    LEAST_PIVOT: f64 = 1e-13, "part of the largest entry", Basis::Derived("rounding of a system of a few unknowns");

    // Events.

    /// Within this distance a switch has not left its surface.
    ON_SURFACE: f64 = 1e-13, "largest speed so far", Basis::Derived("rounding of the state");
    /// Within this distance of the corner of a force either side of it is right.
    AT_KINK: f64 = 0.1, "tolerances of the scale", Basis::Derived("below the error of a step; what a wrong side does to the rates is continuous");
    /// The load above the friction limit at which a sticking contact slips.
    OVERLOAD: f64 = 1e-14, "part of the friction limit", Basis::Derived("just above rounding, so that the contact does not stick again at once");
    /// A bracket of an event ends at this width.
    ROOT_WIDTH: f64 = 1e-10, "part of the step", Basis::Derived("Newton's method locates the event exactly afterwards");
    /// Evaluations of the Illinois method at most.
    ROOT_ITERATIONS: usize = 80, "evaluations", Basis::Judgement("smooth functions take up to 25; the limit is for brackets that do not close");
    /// Evaluations of the golden section search for the peak of a load.
    PEAK_ITERATIONS: usize = 24, "evaluations", Basis::Derived("1e-5 of the interval");
    /// Steps of Newton's method on the length of a step that ends at an event.
    LOCATION_ITERATIONS: usize = 4, "steps", Basis::Judgement("convergence from the dense output is quadratic");
    /// Such a step of Newton's method changes the length by at most this part.
    LOCATION_CHANGE: f64 = 0.1, "part of the step", Basis::Judgement("a larger change leaves the event that was bracketed");
    /// A switch that returns to its surface within a shorter step than this has an event at the end of the
    /// step.
    SHORTEST_RETURN: f64 = 1e-9, "part of the run", ROUNDING;
    /// More events than this ...
    CHATTER_EVENTS: usize = 200, "events", Basis::Judgement("more than any mechanism shows");
    /// ... within this part of the run are chattering, and an error.
    CHATTER_SPAN: f64 = 1e-4, "part of the run", Basis::Judgement("far shorter than the motion");

    // Jumps of states.

    /// Within this distance of a multiple of its period what is held jumps.
    SAME_TICK: f64 = 1e-9, "part of the period", ROUNDING;
    /// So many impacts at one instant end at rest.
    MOST_STRIKES: usize = 100, "impacts", Basis::Judgement("a chain of bodies passes an impulse on once for each pair");

    // Step control.

    /// A step spans at most this many samples.
    SAMPLES_PER_STEP: f64 = 32.0, "samples", Basis::Judgement("a step must not skip a burst of force on a mass at rest");
    /// A step spans at most this many knots of a spline input.
    KNOTS_PER_STEP: f64 = 8.0, "knots", Basis::Judgement("a step must not skip a burst of force on a mass at rest");
    /// The permitted error of the load of a sticking contact.
    LOAD_RESOLUTION: f64 = 1e-3, "part of the friction limit", Basis::Judgement("while nothing moves, nothing else limits the step");
    /// The permitted error of the speed of a contact whose friction has a shape near rest, relative to that
    /// speed.
    SHAPE_RESOLUTION: f64 = 300.0, "tolerances", SINGULAR_FRICTION;
    /// The ratio by which a step may change the speed of such a contact.
    SPEED_RATIO: f64 = 4.0, "ratio", SINGULAR_FRICTION;
    /// A step that exceeds this ratio by less than this factor is accepted.
    SPEED_RATIO_SLACK: f64 = 1.2, "factor", Basis::Judgement("a repeated step costs more than a slightly long one");
    /// The ratio applies where friction changes within a step by more than this part of the acceleration.
    SHAPE_MATTERS: f64 = 1e-3, "part of the acceleration", SINGULAR_FRICTION;
    /// A step that is repeated for this ratio has a length between these parts of the old one.
    SHAPE_SHORTENING: [f64; 2] = [0.03, 0.9], "parts of the step", Basis::Judgement("neither many small steps nor the same one again");
    /// The safety factor of a new step length.
    STEP_SAFETY: f64 = 0.9, "factor", HAIRER;
    /// The least and largest growth of a step length after an accepted step.
    STEP_GROWTH: [f64; 2] = [0.2, 5.0], "factors", HAIRER;
    /// The least and largest reduction after a rejected step.
    STEP_REDUCTION: [f64; 2] = [0.1, 0.9], "factors", HAIRER;
    /// A step whose end is nearer than this to the end of the run or to a breakpoint is extended up to it.
    STEP_REMAINDER: f64 = 1e-3, "part of the step", Basis::Judgement("a step of this length costs as much as any other");
    /// A shorter step cannot advance time.
    SHORTEST_STEP: f64 = 1e-15, "part of the time", Basis::Derived("a few units in the last place");

    // Stiff rates.

    /// Beyond this the last two stages of an explicit step tell of a mode that takes no part in the motion
    /// and limits the step all the same.
    STIFF: f64 = 1.0, "step length times eigenvalue", Basis::Derived("a mode that takes part is resolved with less: the error estimate of a step is 0.0008 (h lambda)^5, which is a tolerance of 1e-4 at 0.6");
    /// A larger error of an explicit step of a derivative of the run tells of a mode in which the state
    /// rests.
    UNRESOLVED: f64 = 8e-4, "of the derivative", Basis::Derived("the error estimate 0.0008 (h lambda)^5 at STIFF");
    /// The border of the domain of stability of explicit steps.
    STABLE: f64 = 3.25, "step length times eigenvalue", Basis::Convention("Hairer, Wanner, Solving Ordinary Differential Equations II, IV.2");
    /// So many steps that the other method would make better are a reason to change the method ...
    CHANGE_STEPS: usize = 15, "steps", Basis::Convention("Hairer, Wanner, Solving Ordinary Differential Equations II, IV.2");
    /// ... unless so many others in a row lie between them.
    CALM_STEPS: usize = 6, "steps", Basis::Convention("Hairer, Wanner, Solving Ordinary Differential Equations II, IV.2");
    /// What an implicit step costs.
    IMPLICIT_COST: f64 = 4.0, "explicit steps", Basis::SetOn("LuGre friction (`crates/sim/tests/stiff.rs`): 25 evaluations of the rates and a matrix against 6; 3 with sensitivities");
    /// Implicit steps that did not pay double the steps before the next try, up to this many times.
    MOST_DOUBLINGS: u32 = 5, "doublings", Basis::Judgement("a try costs a few per cent of the steps between then");
    /// Products with the derivative of the rates that find its dominant eigenvalue; the second half counts.
    POWERS: usize = 8, "products", Basis::Judgement("they tell the fastest of modes a factor of two apart to a few per cent");
    /// Newton's method starts on the interpolant of the step before, if the step is at most this much longer.
    EXTRAPOLATION: f64 = 2.0, "steps", Basis::Judgement("further away a polynomial of the fifth degree leads astray");
    /// The permitted error of the stages of an implicit step.
    NEWTON_ERROR: f64 = 1e-3, "permitted errors of the step", Basis::Judgement("far below the error of the step");
    /// A smaller change of a state is rounding.
    NEWTON_ROUNDING: f64 = 1e-14, "part of the state", Basis::Derived("some units in the last place");
    /// Newton's method that reduces its change by less than this factor gets derivatives at the stages.
    NEWTON_SLOW: f64 = 0.1, "factor", Basis::Judgement("two more iterations cost as much as the derivatives");
    /// Iterations of Newton's method at most.
    NEWTON_ITERATIONS: usize = 10, "iterations", Basis::Convention("Hairer, Wanner, Solving Ordinary Differential Equations II, IV.8: 7; a few more after new derivatives");
    /// The change of the step length where Newton's method fails.
    NEWTON_SHORTENING: f64 = 0.5, "factor", Basis::Convention("Hairer, Wanner, Solving Ordinary Differential Equations II, IV.8");

    // Defaults of the options.

    /// Default of the local error of a step.
    DEFAULT_TOLERANCE: f64 = 1e-8, "size of each state", Basis::Judgement("far below the noise of any sensor");
    /// Default of the number of steps.
    DEFAULT_MAX_STEPS: usize = 2_000_000, "steps", Basis::Judgement("some seconds of work");
    /// Default of the size beyond which a state has diverged.
    DEFAULT_DIVERGED: f64 = 1e9, "scales of the state", Basis::Judgement("no mechanism moves so far");

    // Synthetic records.

    /// Local error of the simulation of the truth.
    TRUTH_TOLERANCE: f64 = 1e-10, "size of each state", Basis::Judgement("far below any noise");
    /// Local error of the first run, which finds the size of each state.
    COARSE_TOLERANCE: f64 = 1e-4, "size of each state", Basis::Judgement("a size needs a few digits only");
    /// The smallest sizes that the first run regards as motion, tried in turn.
    SMALLEST_SIZES: [f64; 4] = [1e-9, 1e-6, 1e-3, 1.0], "SI", Basis::Judgement("friction that is singular at rest is evaluated in units of them, and may be too steep for small ones");
    /// A state of the first run beyond this many of these sizes has diverged.
    COARSE_DIVERGED: f64 = 1e24, "smallest sizes", Basis::Judgement("the sizes are not known yet");
    /// Points of the table of a generated excitation for each sample.
    GRID_REFINEMENT: usize = 8, "points per sample", Basis::Judgement("the error of cubic interpolation falls with the fourth power");
    /// Sines times samples of a generated excitation at most.
    MOST_SINE_SAMPLES: usize = 1_000_000_000, "sines times samples", Basis::Judgement("some seconds of work");
    /// Sines of an excitation at most.
    MOST_SINES: f64 = 1e5, "sines", Basis::Judgement("more are a mistake in the frequency step");
    /// A window leaves at least this many samples.
    FEWEST_SAMPLES: usize = 10, "samples", Basis::Judgement("fewer are no record");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_decision_has_a_value_a_unit_and_a_meaning() {
        for (k, d) in decisions().iter().enumerate() {
            assert!(!d.value.is_empty() && d.value.iter().all(|v| v.is_finite()), "{d:?}");
            assert!(!d.unit.is_empty() && d.meaning.len() > 10, "{d:?}");
            assert!(decisions()[..k].iter().all(|other| other.name != d.name), "{} stands twice", d.name);
        }
    }
}
