//! Method trajectory: the event-located simulation fitted to the records.
//!
//! ```text
//! layout --> problem --> cost (least squares) --> fit --> select --> method --> report --> Identified
//!                        initial ------------------^                             error_bars, free_run, agreement, ...
//!                                                 fit --> calibrate --> Calibration
//! ```

pub(crate) mod agreement;
pub(crate) mod analogues;
pub(crate) mod calibrate;
pub(crate) mod chain;
pub(crate) mod chain_selection;
pub(crate) mod chaos;
pub(crate) mod contradiction;
pub(crate) mod cost;
pub(crate) mod delayed_samples;
pub(crate) mod description;
mod elasticities;
pub(crate) mod error_bars;
pub(crate) mod filter;
pub(crate) mod fit;
pub(crate) mod follower;
pub(crate) mod free_run;
mod growing_record;
pub(crate) mod horizon;
pub(crate) mod initial;
pub(crate) mod input_sensors;
pub(crate) mod jacobian;
pub(crate) mod jumps;
pub(crate) mod kalman_smoother;
mod late_column;
pub(crate) mod layout;
pub(crate) mod method;
pub(crate) mod noise;
pub(crate) mod problem;
pub(crate) mod products;
pub(crate) mod profile;
pub(crate) mod quadratic;
pub(crate) mod random_force;
pub(crate) mod regular_start;
pub(crate) mod remainder;
pub(crate) mod report;
pub(crate) mod select;
pub(crate) mod separability;
mod side_minima;
pub(crate) mod state_scale;
pub(crate) mod tally;
pub(crate) mod term_sizes;
pub(crate) mod unknowns;
pub(crate) mod validated_chain;
mod window_means;
pub(crate) mod worth_of_laws;
