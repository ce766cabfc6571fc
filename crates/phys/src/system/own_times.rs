//! Which samples of a record each of its columns has.

use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

/// Which samples of a record each of its columns has. Where all were sampled together, every column has all of them.
///
/// ```
/// use phisindy_phys::OwnTimes;
///
/// // A camera beside an accelerometer that is four times as fast.
/// let own = OwnTimes::new(vec![Some([true, false, false, false, true].into()), None]);
/// assert!(!own.has(0, 1) && own.has(1, 1));
/// assert_eq!(*own.of(0, &[0.0, 0.1, 0.2, 0.3, 0.4]), [0.0, 0.4]);
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OwnTimes(Vec<Option<Arc<[bool]>>>);

impl OwnTimes {
    /// For each column whether it has each sample; `None` of a column that has all of them.
    pub fn new(columns: Vec<Option<Arc<[bool]>>>) -> OwnTimes {
        if columns.iter().all(Option::is_none) { OwnTimes::default() } else { OwnTimes(columns) }
    }

    fn column(&self, column: usize) -> Option<&[bool]> {
        self.0.get(column)?.as_deref()
    }

    /// Whether all columns have the same samples.
    pub fn are_common(&self) -> bool {
        self.0.is_empty()
    }

    /// Whether a column has every sample.
    pub fn all(&self, column: usize) -> bool {
        self.column(column).is_none()
    }

    /// Whether a column has a sample.
    ///
    /// # Panics
    /// The record has no such sample.
    pub fn has(&self, column: usize, sample: usize) -> bool {
        self.column(column).is_none_or(|own| own[sample])
    }

    /// What `values`, one for each sample of the record, hold at the samples of a column.
    pub fn of<'a>(&self, column: usize, values: &'a [f64]) -> Cow<'a, [f64]> {
        match self.column(column) {
            None => Cow::Borrowed(values),
            Some(own) => values.iter().zip(own).filter_map(|(value, own)| own.then_some(*value)).collect(),
        }
    }

    /// How many of these samples a column has.
    ///
    /// # Panics
    /// The record is shorter.
    pub fn count(&self, column: usize, samples: Range<usize>) -> usize {
        let count = |own: &[bool]| own[samples.clone()].iter().filter(|own| **own).count();
        self.column(column).map_or(samples.len(), count)
    }

    /// Of some samples alone.
    ///
    /// # Panics
    /// The record is shorter.
    pub fn within(&self, samples: Range<usize>) -> OwnTimes {
        OwnTimes(self.0.iter().map(|own| own.as_ref().map(|own| own[samples.clone()].into())).collect())
    }

    /// With one more column before the one at `place`, which has all samples.
    ///
    /// # Panics
    /// There are fewer columns.
    pub fn insert(&mut self, place: usize) {
        if !self.are_common() {
            self.0.insert(place, None);
        }
    }

    /// The columns at these places alone.
    pub fn at(&self, places: impl Iterator<Item = Option<usize>>) -> OwnTimes {
        OwnTimes::new(places.map(|place| self.0.get(place?)?.clone()).collect())
    }
}
