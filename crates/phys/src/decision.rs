//! Decisions: numbers that decide something and are no law of nature, with the reason why they are what they
//! are. Each crate has one table of them, from which the page about the method is made.

use std::fmt;

/// Why a number is what it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Basis {
    /// It follows from something else: how.
    Derived(&'static str),
    /// Others use it: who.
    Convention(&'static str),
    /// It was set on data: which.
    SetOn(&'static str),
    /// It was set by judgement, and no record tells of data: for which reason.
    Judgement(&'static str),
}

impl fmt::Display for Basis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Basis::Derived(how) => write!(f, "derived: {how}"),
            Basis::Convention(whose) => write!(f, "convention: {whose}"),
            Basis::SetOn(data) => write!(f, "set on {data}"),
            Basis::Judgement(why) => write!(f, "judgement: {why}"),
        }
    }
}

/// A number that decides something.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decision {
    /// Name of the constant in the code.
    pub name: &'static str,
    /// Its value; the values of a schedule or a grid.
    pub value: &'static [f64],
    /// What it counts or measures: `samples`, `NRMSE`, `part of ...`.
    pub unit: &'static str,
    /// What it decides.
    pub meaning: &'static str,
    /// Why it is what it is.
    pub basis: Basis,
}

/// A table of decisions: a constant for each row, and the rows as data in `DECISIONS`.
///
/// ```
/// use phisindy_phys::{Basis, Decision, decisions};
/// decisions! {
///     /// A free run worse than this is no model.
///     WORST_NRMSE: f64 = 0.5, "NRMSE", Basis::Judgement("half of the motion is missed");
///     /// Segments of the stages of a fit.
///     STAGES: [usize; 3] = [20, 5, 1], "segments", Basis::Judgement("each stage is a few times longer");
/// }
/// let Decision { name, value, meaning, .. } = DECISIONS[0];
/// assert_eq!((name, value, meaning), ("WORST_NRMSE", &[WORST_NRMSE][..], "A free run worse than this is no model."));
/// assert_eq!(DECISIONS[1].value, [20.0, 5.0, 1.0]);
/// assert_eq!(STAGES[0], 20);
/// ```
#[macro_export]
macro_rules! decisions {
    ($($(#[doc = $meaning:literal])+ $name:ident: $type:ty = $value:tt, $unit:literal, $basis:expr;)+) => {
        $($(#[doc = $meaning])+ pub(crate) const $name: $type = $value;)+

        /// Every decision of this crate.
        pub(crate) static DECISIONS: &[$crate::Decision] = &[$($crate::Decision {
            name: stringify!($name),
            value: $crate::decisions!(@values $value),
            unit: $unit,
            meaning: concat!($($meaning),+).trim_ascii(),
            basis: $basis,
        }),+];
    };
    (@values [$($value:expr),+ $(,)?]) => { &[$($value as f64),+] };
    (@values $value:tt) => { &[$value as f64] };
}
