//! Where model and data disagree, which effect of the catalogue is missing, and what adding it does.
//!
//! ```text
//! spec + records --calibrate--> residual --whiteness--> nothing missing
//!                      ^            |
//!                      |            +--screen--> every law at every place, by the linear response to the measured motion
//!                      |                              |
//!                      +--- best, if Validate says so --- full fits of the best few, evidence, simplification
//! ```
//!
//! The crate reads no files: it takes the text of a spec with its records and gives back a text with effects written into it.

mod along;
mod asked;
mod causes;
mod clock;
mod course;
mod draft;
mod drive;
mod effect;
mod evidence;
mod fitted;
mod found;
mod held;
mod mistaken;
mod motion;
mod need;
mod place;
mod proposals;
mod recipe;
mod refine;
mod region;
mod repeat;
mod response;
mod screen;
mod search;
mod verdict;
mod whiteness;
mod workflow;

pub use asked::{asked, written_in};
pub use course::{Course, course};
pub use draft::Draft;
pub use effect::{Effect, Entry};
pub use found::{Gap, GapError, Rival, Simulated, Status, Step, StepParameter};
pub use place::{Place, Site, places};
pub use region::Region;
pub use repeat::{Repeat, repeatability};
pub use workflow::gap;
