//! Results as text. Functions take results and return strings: nothing here reads or writes a file, prints,
//! or looks at a clock.
//!
//! ```text
//! Identified --> RunReport --+--> text, LaTeX, JSON          (run)
//! Gap --------> GapReport ---+--> text, JSON, completed spec (gap)
//!                            +--> HtmlReport: page, figures  (html <-- chart <-- markup)
//! Identified --> identified spec                             (spec_text)
//! runs of a sweep --> Statistics --> table, JSON             (sweep)
//! Comparison, Fleet --> CompareReport --> text, JSON, HtmlReport (compare)
//! a model without unknown part --> Python, C, Modelica, JSON (export)
//! RunReport, GapReport --> Folder: the files of `--out`
//! laws --> list, gallery, pictures                           (laws)
//! spec, case --> the model as a picture and as lines         (sketch)
//! records --> whether they tell the missing force well enough (coverage)
//! ```

mod chart;
mod compare;
mod coverage;
mod equation;
pub mod export;
mod folder;
mod format;
pub mod gap;
mod horizon;
pub mod html;
mod input;
pub mod laws;
mod markup;
mod measured_force;
mod next;
pub mod run;
mod seen;
mod sketch;
pub mod spec_text;
mod stretch;
pub mod sweep;
pub mod table;
mod terminal;
mod tied;

pub use compare::{CompareReport, force_curves};
pub use coverage::{Coverage, Node as CoverageNode, coverage};
pub use equation::{Equation, equations};
pub use folder::{Folder, PROVENANCE, RESULT, SPEC};
pub use format::Format;
pub use gap::GapReport;
pub use html::HtmlReport;
pub use input::{Ending, Input, Invocation, StopReason};
pub use next::{NextReport, Outcome as PlannedOutcome, Plan, Predicted, QuantityShown, model_name};
pub use run::RunReport;
pub use seen::Shown;
pub use sketch::{EditableSketch, SketchBody, SketchEnd, SketchPart, editable_sketch, sketch, sketch_style};
pub use terminal::Look;
