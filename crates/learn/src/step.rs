//! Method step: the one-step prediction of the paper, trained on all samples.

pub(crate) mod batch;
pub(crate) mod descent;
pub(crate) mod onestep;
pub(crate) mod rollout;
pub(crate) mod train;
