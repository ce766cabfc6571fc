//! How far the model predicts, in a sentence.

use crate::table::short;
use phisindy_learn::Horizon;

/// `predicts x of run 1 to 0.2 % of its motion 0.02 s ahead, to 1.2 % 10 s ahead; a linear model to 0.3 % and 28 %`:
/// the column that is predicted worst so far ahead, among the records that the model has not seen if there are any.
pub(super) fn words(all: &[Horizon], unseen: &[&str]) -> Option<String> {
    let judged = |h: &&Horizon| unseen.is_empty() || unseen.contains(&h.record.as_str());
    let farthest = all.iter().filter(judged).map(|h| h.seconds).fold(0.0, f64::max);
    let last = all.iter().filter(judged).filter(|h| h.seconds == farthest);
    let worst = last.max_by(|a, b| a.nrmse.total_cmp(&b.nrmse))?;
    let same = |h: &&Horizon| (&h.record, &h.column) == (&worst.record, &worst.column);
    let first = all.iter().find(same)?;
    let percent = |part: f64| format!("{} %", short(two_digits(100.0 * part)));
    let linear = match (first.baseline, worst.baseline) {
        (Some(near), Some(far)) => format!("; a linear model to {} and {}", percent(near), percent(far)),
        _ => String::new(),
    };
    Some(format!(
        "predicts {} of {} to {} of its motion {} s ahead, to {} {} s ahead{linear}",
        worst.column,
        worst.record,
        percent(first.nrmse),
        short(first.seconds),
        percent(worst.nrmse),
        short(worst.seconds),
    ))
}

/// An error is not known better.
fn two_digits(x: f64) -> f64 {
    format!("{x:.1e}").parse().unwrap_or(x)
}
