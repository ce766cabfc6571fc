//! The missing part of a mechanical model - above all friction, sticking included - from measured motion in
//! memory.
//!
//! ```text
//! text --Case::read--> Case --Case::record--> Record: arrays by name --+--identify--> Identified: equations, numbers, verdict
//!                       |                                              +--gap-------> Gap: laws that the model lacks
//!                       +-----Case::synthetic-> Record: simulated -----+--simulate--> Motion: what the model predicts
//! ```
//!
//! A mass on a spring, released at 2 m. Its friction is to be found:
//!
//! ```
//! use phisindy::{Case, Options, identify};
//! use std::f64::consts::PI;
//! let case = Case::read(
//!     r#"(states: { "x": "m", "v": "m/s" }, constants: { "k": (1.0, "1/s^2") },
//!         known: { "x": "v", "v": "-k*x" }, contacts: ["v"],
//!         unknown: { "v": (factor: "-sgn(v)", candidates: ["1", "|v|"]) })"#,
//! )?;
//! // Measured: friction of 0.3 m/s^2 moves the centre of each half swing.
//! let t: Vec<f64> = (0..900).map(|k| 0.01 * f64::from(k)).collect();
//! let swing = |t: &f64| (t / PI).floor();
//! let exact = |t: &f64| 0.3 * (-1f64).powf(swing(t)) + (1.7 - 0.6 * swing(t)) * t.cos();
//! let x: Vec<f64> = t.iter().map(|t| (1e3 * exact(t)).round() / 1e3).collect();
//! let record = case.record(&[("t", &t), ("x", &x)])?;
//! let found = identify(&case, &[record], &Options::default())?;
//! println!("{}", found.latex());
//! let terms = found.terms();
//! assert!(terms.len() == 1 && (terms[0].coefficient.value - 0.3).abs() < 0.001);
//! # Ok::<(), phisindy::Error>(())
//! ```
//!
//! The text is a spec as `docs/reference.md` describes it, without `data`. Columns are given by the names of
//! states and inputs, `t` is the time in
//! seconds; numbers are in the units that the spec states for these names. A state without a column is not
//! measured; at least one state must be.
//! Results are in SI.
//!
//! Only [`files`] reads files; nothing here prints or looks at a clock. The same records give the same bits
//! for any number of threads.

mod arrays;
mod case;
mod error;
pub mod files;
mod gap;
mod identify;
mod late_sensor;
mod laws;
mod loaded;
mod options;
mod rates;
mod record;
mod simulate;

pub use case::Case;
pub use error::{Error, SimulationError, SpecError};
pub use gap::{Gap, gap};
pub use identify::{Equation, Identified, Term, identify};
pub use laws::{Catalogue, LawError};
pub use loaded::{Loaded, record_named};
pub use options::{Observer, Options, Progress};
pub use record::{Record, RecordError};
pub use simulate::{Motion, simulate};

pub use phisindy_gap::{GapError, Rival, Status, Step, StepParameter};
pub use phisindy_learn::{Estimate, FoundParameter, LearnError, RecordFit, Verdict};
pub use phisindy_phys::LawEntry;
pub use phisindy_phys::spec::{Method, Role};
pub use phisindy_phys::{Diagnostic, Files, NamedFile, Numbers, Sources, named_files};
pub use phisindy_report::{Folder, Format, Shown};
