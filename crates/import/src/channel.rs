//! A channel of a file that stores one by one.

/// Most channels of a file: more are no columns of a record, but pictures or the like.
pub(crate) const MOST_CHANNELS: usize = 4096;

/// A channel as it is stored.
#[derive(Clone, Debug)]
pub(crate) struct Channel {
    /// The group, structure or array that holds it; empty if none does.
    pub(crate) group: String,
    /// Its name within the group.
    pub(crate) name: String,
    /// Its unit as the file spells it.
    pub(crate) unit: Option<String>,
    /// What it holds.
    pub(crate) values: Values,
    /// Its own times, if the file stores them with it.
    pub(crate) clock: Option<Clock>,
}

/// Times of a channel, in seconds.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Clock {
    /// The time of the first sample and the step.
    Even(f64, f64),
    /// Of each sample.
    Listed(Vec<f64>),
}

/// The samples of a channel.
#[derive(Clone, Debug)]
pub(crate) enum Values {
    /// Numbers.
    Numbers(Vec<f64>),
    /// Words and times of day.
    Words(Vec<String>),
}

impl Values {
    pub(crate) fn len(&self) -> usize {
        match self {
            Values::Numbers(x) => x.len(),
            Values::Words(x) => x.len(),
        }
    }
}
