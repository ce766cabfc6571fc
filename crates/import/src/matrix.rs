//! Vectors and matrices of a file as channels.

use crate::channel::{Channel, MOST_CHANNELS, Values};

/// The name of a group within another one, which may be nothing.
pub(crate) fn inner(group: &str, name: &str) -> String {
    if group.is_empty() { name.to_owned() } else { format!("{group}.{name}") }
}

/// A channel of numbers without unit.
pub(crate) fn channel(group: &str, name: &str, numbers: Vec<f64>) -> Channel {
    let (group, name, values) = (group.to_owned(), name.to_owned(), Values::Numbers(numbers));
    Channel { group, name, unit: None, values, clock: None }
}

/// The channels of a matrix of `rows` times `columns` numbers, which the file stores row by row or else
/// column by column. A vector is one channel in `group`; the columns of a matrix have numbers from 1 in a
/// group of their own. A number alone is a constant, and what has too many columns is a picture: neither is a
/// channel.
pub(crate) fn channels(
    group: &str,
    name: &str,
    (rows, columns): (usize, usize),
    by_rows: bool,
    all: Vec<f64>,
) -> Vec<Channel> {
    let (samples, count) = (rows.max(columns), rows.min(columns));
    if samples < 2 || count == 0 || count > MOST_CHANNELS || rows.checked_mul(columns) != Some(all.len()) {
        return vec![];
    }
    if count == 1 {
        return vec![channel(group, name, all)];
    }
    let inner = inner(group, name);
    // The longer side counts the samples, which stand side by side where it is the one that the file runs
    // along.
    let together = (rows >= columns) != by_rows;
    let of = |k: usize| {
        let column = if together {
            all[k * samples..(k + 1) * samples].to_vec()
        } else {
            all.iter().skip(k).step_by(count).copied().collect()
        };
        channel(&inner, &(k + 1).to_string(), column)
    };
    (0..count).map(of).collect()
}
