//! When a residual counts as more than noise.

pub(crate) use phisindy_signal::{
    mean_step, strongest_lines as lines, tone_share as share, whiteness_score as score,
};
