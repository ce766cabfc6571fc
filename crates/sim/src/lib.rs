//! Event-located simulation of a model with friction: stick, slip, crossing.
//!
//! ```text
//! Model --Automaton::new--> Automaton (tapes with modes)
//!       --simulate--> Trajectory (samples, modes, events, sensitivities)
//! ```
//!
//! Every sign in the rates is a *switch*: a surface `w = 0` with a mode `s` in {-1, 0, +1}. One rule
//! decides what happens on the surface (Filippov's, the same in fit and simulation): with `r+` and `r-` the
//! rate of `w` on either side, the contact sticks while `r+ <= 0 <= r-`.
//!
//! States may jump: where a gap closes (`impact`), and at the times of a sampled controller (`held`). Both are a reset
//! `x+ = G(t, x-, p)` with its derivatives (`resets`).

mod arguments;
mod assembly;
mod automaton;
mod columns;
mod contact;
mod decisions;
mod dense;
mod dopri;
mod elimination;
mod events;
mod excitation;
mod factors;
mod field;
mod flow;
mod held;
mod impact;
mod jacobian;
mod kinks;
mod linearisation;
mod noise;
mod observer;
mod output;
mod radau;
mod resets;
mod run;
mod sensitivity;
mod state;
mod step;
mod step_control;
mod stiffness;
mod stop;
mod switched;
mod synthetic;
mod trajectory;

pub use assembly::Assembly;
pub use automaton::Automaton;
pub use decisions::decisions;
pub use excitation::{ExcitationError, Multisine};
pub use noise::{Noise, Streams, add_noise};
pub use observer::{Observer, Shown};
pub use run::{at_rest, observe, simulate};
pub use stop::Stop;
pub use switched::{Switch, Switched};
pub use synthetic::{SyntheticError, synthesize};
pub use trajectory::{DIVERGED, Drive, Event, Hit, Jump, MovingSteps, Options, SimError, Trajectory};
