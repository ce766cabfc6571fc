//! Method step: Algorithm 2 of the paper.
//!
//! ```text
//! onestep (the Runge-Kutta step as a graph) --> windows (samples as data of steps) --> single, rollout (its loss) --> batch --> train --> method
//! ```

pub(crate) mod batch;
pub(crate) mod descent;
pub(crate) mod lanes;
pub(crate) mod method;
pub(crate) mod onestep;
pub(crate) mod options;
pub(crate) mod rollout;
pub(crate) mod single;
pub(crate) mod train;
pub(crate) mod windows;
