//! TODO
mod derivative;
mod diagnostic;
mod interpolate;
mod model;
mod noise_level;
pub use diagnostic::{Diagnostic, Label, Severity, Source, SourceId, Sources};
pub use interpolate::{Interpolation, Signal, SignalError};
pub use model::Model;
pub use derivative::{Differentiated, Differentiator, automatic, differentiate};
pub use noise_level::{effective_samples, noise_level};
