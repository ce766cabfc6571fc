//! A force of a machine as a function of the speed or the displacement that alone it depends on.

use crate::estimates::HALF_WIDTH_95;
use serde::{Deserialize, Serialize};

/// A force with its errors, in the units that stand beside it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ForceCurve {
    /// The state in whose rate it acts.
    pub at: String,
    /// The speed or displacement that it depends on, and its unit.
    pub over: (String, String),
    /// What it is called, and its unit.
    pub force: (String, String),
    /// Speed or displacement, force, standard error of the force; over what the records visited, rising.
    pub points: Vec<(f64, f64, f64)>,
}

impl ForceCurve {
    /// Whether both are the same force of two machines.
    pub fn is(&self, other: &ForceCurve) -> bool {
        (&self.at, &self.over, &self.force) == (&other.at, &other.over, &other.force)
    }

    /// Abscissa, and the ends of the 95 % band.
    pub fn band(&self) -> Vec<(f64, f64, f64)> {
        let ends = |&(x, f, s): &(f64, f64, f64)| (x, f - HALF_WIDTH_95 * s, f + HALF_WIDTH_95 * s);
        self.points.iter().map(ends).collect()
    }

    /// The force at a place, on a straight line between its neighbours; `None` beyond what was visited.
    pub fn at_place(&self, x: f64) -> Option<f64> {
        let above = self.points.partition_point(|p| p.0 < x);
        let (b, bf, _) = *self.points.get(above)?;
        if b == x {
            return Some(bf);
        }
        let (a, af, _) = *self.points.get(above.checked_sub(1)?)?;
        Some(af + (bf - af) * (x - a) / (b - a))
    }
}

/// The force of all machines at each place of a curve that at least two of them visited: place, mean, and the
/// standard deviation of a machine.
pub fn mean_curve(all: &[&ForceCurve], places: &[f64]) -> Vec<(f64, f64, f64)> {
    let of = |&x: &f64| {
        let forces: Vec<f64> = all.iter().filter_map(|curve| curve.at_place(x)).collect();
        let n = forces.len() as f64;
        let mean = forces.iter().sum::<f64>() / n;
        let squares: f64 = forces.iter().map(|f| (f - mean).powi(2)).sum();
        (n >= 2.0).then(|| (x, mean, (squares / (n - 1.0)).sqrt()))
    };
    places.iter().filter_map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(slope: f64, end: f64) -> ForceCurve {
        let points = [-end, 0.0, end].map(|x| (x, slope * x, 0.1)).to_vec();
        ForceCurve { points, ..ForceCurve::default() }
    }

    #[test]
    fn a_force_is_read_only_where_it_was_visited() {
        let curve = line(2.0, 1.0);
        let read = [-1.5, -1.0, -0.25, 0.0, 1.0, 1.1].map(|x| curve.at_place(x));
        assert_eq!(read, [None, Some(-2.0), Some(-0.5), Some(0.0), Some(2.0), None]);
        assert_eq!(curve.band()[1], (0.0, -0.1 * HALF_WIDTH_95, 0.1 * HALF_WIDTH_95));
    }

    #[test]
    fn the_mean_of_many_is_of_those_that_were_there() {
        let (a, b, short) = (line(2.0, 1.0), line(4.0, 1.0), line(9.0, 0.5));
        let mean = mean_curve(&[&a, &b, &short], &[-2.0, 0.25, 1.0]);
        assert_eq!((mean.len(), mean[0].0, mean[0].1), (2, 0.25, 1.25));
        assert_eq!((mean[1].0, mean[1].1), (1.0, 3.0));
        assert!((mean[1].2 - 2f64.sqrt()).abs() < 1e-12);
    }
}
