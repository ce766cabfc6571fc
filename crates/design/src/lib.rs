//! The next run of a rig, within its limits: the one after which most is known.
//!
//! ```text
//! Rivals (models, how probable, what of their numbers is uncertain) --+
//! Limits of the rig --Trials: tones, sweeps, steps, ring-downs -------+--predicted--> Responses --information--> ranked Runs
//! ```

mod information;
mod limits;
mod rival;
mod search;
mod trial;

pub use information::{Narrowed, Separation, narrowed, separation};
pub use limits::{Limits, Range, step};
pub use rival::{Noise, Response, Rival};
pub use search::{Activity, Aim, Design, Failure, Run, design, possible};
pub use trial::{Shape, Trial, Waveform};

/// A question is open while two answers have more than a twentieth, as where an interval holds 95 %: it is decided above this.
pub const DECIDED: f64 = 0.95;
