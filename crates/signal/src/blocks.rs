//! Decimation of streamed rows: groups of rows are replaced by their mean.

/// A time step of this many times the one before is a gap, over which nothing is averaged.
const GAP_RATIO: f64 = 5.0;

/// Replaces `size` rows by one: the mean of their times and of every column.
///
/// The mean is a low-pass filter. Noise falls by the square root of `size`, while skipping rows would alias
/// it. A frequency `f` loses about `(pi f size step)^2 / 6` of its amplitude, in states and inputs alike.
/// Incomplete blocks before a gap in time and at the end are dropped.
///
/// ```
/// let mut blocks = phisindy_signal::Blocks::new(2);
/// assert_eq!(blocks.push(0.0, &[1.0]), None);
/// assert_eq!(blocks.push(0.1, &[3.0]), Some((0.05, [2.0].as_slice())));
/// ```
#[derive(Clone, Debug)]
pub struct Blocks {
    size: usize,
    count: usize,
    time: f64,
    last: f64,
    step: f64,
    sums: Vec<f64>,
    means: Vec<f64>,
}

impl Blocks {
    /// Blocks of `size` rows; zero counts as one.
    pub fn new(size: usize) -> Blocks {
        let (sums, means) = (vec![], vec![]);
        Blocks { size: size.max(1), count: 0, time: 0.0, last: f64::NAN, step: f64::NAN, sums, means }
    }

    /// Adds a row. Returns the time and the values of the mean row if the block is complete.
    pub fn push(&mut self, time: f64, row: &[f64]) -> Option<(f64, &[f64])> {
        let step = time - self.last;
        if step > GAP_RATIO * self.step {
            self.count = 0;
        } else if step > 0.0 {
            // The step before a gap remains the reference after it.
            self.step = step;
        }
        self.last = time;
        if self.count == 0 {
            (self.time, self.sums) = (0.0, vec![0.0; row.len()]);
        }
        self.count += 1;
        self.time += time;
        self.sums.iter_mut().zip(row).for_each(|(sum, x)| *sum += x);
        if self.count < self.size {
            return None;
        }
        let n = self.count as f64;
        self.count = 0;
        self.means = self.sums.iter().map(|sum| sum / n).collect();
        Some((self.time / n, &self.means))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(size: usize, times: &[f64]) -> Vec<(f64, f64)> {
        let mut blocks = Blocks::new(size);
        times.iter().filter_map(|&t| blocks.push(t, &[10.0 * t]).map(|(t, row)| (t, row[0]))).collect()
    }

    #[test]
    fn blocks_of_one_change_nothing() {
        assert_eq!(all(1, &[0.0, 1.0, 7.0]), [(0.0, 0.0), (1.0, 10.0), (7.0, 70.0)]);
    }

    #[test]
    fn a_line_stays_a_line_and_the_rest_is_left_out() {
        assert_eq!(all(3, &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0]), [(1.0, 10.0), (4.0, 40.0)]);
    }

    #[test]
    fn nothing_is_averaged_across_a_gap() {
        assert_eq!(all(2, &[0.0, 1.0, 2.0, 100.0, 101.0, 102.0]), [(0.5, 5.0), (100.5, 1005.0)]);
    }
}
