//! Trends: the mean or the straight line of a column.

/// The kind of trend that is removed from a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Detrend {
    /// The mean.
    Mean,
    /// The straight line by least squares.
    Linear,
}

/// `offset + slope * (time - at)`
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trend {
    /// The mean of the times.
    pub at: f64,
    /// The value at that time.
    pub offset: f64,
    /// Change per unit of time; zero for a mean.
    pub slope: f64,
}

impl Trend {
    /// The trend of a column by least squares.
    ///
    /// ```
    /// use phisindy_signal::{Detrend, Trend};
    /// let trend = Trend::of(&[0.0, 1.0, 2.0], &[1.0, 3.0, 5.0], Detrend::Linear);
    /// assert_eq!((trend.at, trend.offset, trend.slope), (1.0, 3.0, 2.0));
    /// ```
    pub fn of(time: &[f64], values: &[f64], kind: Detrend) -> Trend {
        let n = time.len().min(values.len()).max(1) as f64;
        let (at, offset) = (time.iter().sum::<f64>() / n, values.iter().sum::<f64>() / n);
        let slope = match kind {
            Detrend::Mean => 0.0,
            Detrend::Linear => {
                let (moment, spread) = time.iter().zip(values).fold((0.0, 0.0), |(m, s), (t, x)| {
                    (m + (t - at) * (x - offset), s + (t - at) * (t - at))
                });
                if spread > 0.0 { moment / spread } else { 0.0 }
            }
        };
        Trend { at, offset, slope }
    }

    /// Subtracts the trend from a column.
    pub fn remove(&self, time: &[f64], values: &mut [f64]) {
        for (t, x) in time.iter().zip(values) {
            *x -= self.offset + self.slope * (t - self.at);
        }
    }
}

/// A column less its straight line by least squares, each sample one unit of time after the one before.
///
/// A line leaks into a spectrum more than anything else.
pub(crate) fn without_line(values: &[f64]) -> Vec<f64> {
    let index: Vec<f64> = (0..values.len()).map(|i| i as f64).collect();
    let trend = Trend::of(&index, values, Detrend::Linear);
    values.iter().zip(&index).map(|(x, i)| x - trend.offset - trend.slope * (i - trend.at)).collect()
}
