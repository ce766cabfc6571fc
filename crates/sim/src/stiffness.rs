//! The choice of the method of the next step.
//!
//! An explicit step of a stiff model is short because a longer one would be unstable, not because it would be
//! inaccurate: then `h |lambda|` is at the border of the domain of stability, step by step. An implicit step
//! is as long as accuracy permits, and costs several explicit ones; where explicit steps could be nearly as
//! long, they are cheaper.

use crate::decisions::{CALM_STEPS, CHANGE_STEPS, IMPLICIT_COST, MOST_DOUBLINGS, STABLE, STIFF};
use crate::step::Method;

/// What the last steps say about the method of the next one.
#[derive(Default)]
pub(crate) struct Watch {
    /// Steps that the other method would make better.
    other: usize,
    /// Steps since the last of them.
    calm: usize,
    /// Whether an implicit step was longer than explicit ones of the same cost, since the last change.
    paid: bool,
    /// How often implicit steps did not pay, one time after the other.
    in_vain: u32,
}

impl Watch {
    /// Notes `h |lambda|` of an accepted step; returns whether the other method is the better one.
    pub(crate) fn note(&mut self, method: Method, stiffness: f64) -> bool {
        let pays = stiffness >= IMPLICIT_COST * STABLE;
        let (other, needed) = match method {
            Method::Explicit => (stiffness > STIFF, CHANGE_STEPS << self.in_vain),
            Method::Implicit => (!pays, CHANGE_STEPS),
        };
        self.paid |= method == Method::Implicit && pays;
        if other {
            (self.other, self.calm) = (self.other + 1, 0);
        } else {
            self.calm += 1;
            if self.calm == CALM_STEPS {
                self.other = 0;
            }
        }
        self.other >= needed
    }

    /// The method changes from this one.
    pub(crate) fn change(&mut self, from: Method) {
        let in_vain = match (from, self.paid) {
            (Method::Explicit, _) => self.in_vain,
            (Method::Implicit, true) => 0,
            (Method::Implicit, false) => (self.in_vain + 1).min(MOST_DOUBLINGS),
        };
        *self = Watch { in_vain, ..Watch::default() };
    }
}
