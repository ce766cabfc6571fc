//! A function of one variable from the points of a file, as operations of the graph.
//!
//! Straight between its points it is `y + s (x - a) + sum ds_k pos(x - x_k)`: a corner at each point, which runs locate as
//! every other. Smooth it is the natural cubic spline (C. de Boor, A Practical Guide to Splines, 1978, IV) in truncated
//! powers, `sum dc_k pos(x - x_k)^3`. Sums go from the middle to both sides, so that little cancels. Beyond the points
//! either goes on with the slope of its end.

use crate::system::equations::{System, TableRead};
use crate::system::record::Record;
use crate::text::files::Numbers;
use crate::units::unit::Unit;
use phisindy_expr::{Graph, Id, Scratch, Tape, Unary};
use std::fmt;

/// Fewest and most points.
const POINTS: (usize, usize) = (2, 200);

/// The points of a function, in SI, the first coordinate growing.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Curve {
    x: Vec<f64>,
    y: Vec<f64>,
}

/// Why a file holds no function.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum NoCurve {
    /// So many columns.
    Columns(usize),
    /// So many points.
    Points(usize),
    /// The first column does not go on in one direction at this row.
    Order(usize, f64),
    /// A heading states a unit that is none.
    Unit(String),
}

impl fmt::Display for NoCurve {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NoCurve::Columns(count) => write!(f, "a table has two columns, and this file {count}"),
            NoCurve::Points(count) => {
                write!(f, "a table has {} to {} points, and this file {count}", POINTS.0, POINTS.1)
            }
            NoCurve::Order(row, x) => {
                write!(f, "the first column of a table goes up or down throughout, and row {row} has {x}")
            }
            NoCurve::Unit(unit) => {
                write!(f, "the heading of this table has the unit `{unit}`, which is not known")
            }
        }
    }
}

impl System {
    /// What of a record lies beyond the points of a table, in words, as far as its columns tell.
    pub fn beyond_tables(&self, record: &Record) -> Vec<String> {
        let measured = |k: usize| record.columns[k].as_deref();
        let states =
            (0..self.states.len()).filter_map(|k| Some((self.states[k].node, measured(k)?.to_vec())));
        let inputs =
            (0..self.inputs.len()).map(|k| (self.inputs[k].node, record.input_samples(k).into_owned()));
        let known: Vec<(Id, Vec<f64>)> =
            states.chain(inputs).chain([(self.time, record.time.to_vec())]).collect();
        let nodes: Vec<Id> = known.iter().map(|(node, _)| *node).collect();
        let beyond = |table: &TableRead| {
            let tape = Tape::compile(&self.graph, &nodes, &[table.of]).ok()?;
            let mut scratch = Scratch::<1>::new(&tape);
            let mut range = (f64::INFINITY, f64::NEG_INFINITY);
            for i in 0..record.len() {
                scratch.at(known.iter().map(|(_, column)| column[i]));
                let value = scratch.output(0)[0];
                range = (range.0.min(value), range.1.max(value));
            }
            let (low, high) = table.within;
            let told = range.0 < low || range.1 > high;
            told.then(|| {
                format!(
                    "the table `{}` holds {low:.4} to {high:.4}, and the record goes from {:.4} to {:.4} (SI): beyond its ends it goes on with their slopes",
                    table.path, range.0, range.1
                )
            })
        };
        self.tables.iter().filter_map(beyond).collect()
    }
}

impl Curve {
    /// The first two columns of a file.
    pub(crate) fn of(numbers: &Numbers) -> Result<Curve, NoCurve> {
        let count = numbers.rows();
        if numbers.columns < 2 {
            return Err(NoCurve::Columns(numbers.columns));
        }
        if count < POINTS.0 || count > POINTS.1 {
            return Err(NoCurve::Points(count));
        }
        let column = |k: usize| {
            let unit = numbers.headings.get(k).and_then(|(_, unit)| unit.as_deref()).unwrap_or("");
            let factor = Unit::parse(unit).map_err(|_| NoCurve::Unit(unit.to_owned()))?.factor;
            Ok((0..count).map(|row| factor * numbers.at(row, k)).collect::<Vec<f64>>())
        };
        let (mut x, mut y) = (column(0)?, column(1)?);
        if x[1] < x[0] {
            x.reverse();
            y.reverse();
        }
        if let Some(k) = (1..count).find(|&k| x[k] <= x[k - 1]) {
            let row = if numbers.at(1, 0) < numbers.at(0, 0) { count - k } else { k + 1 };
            return Err(NoCurve::Order(row, numbers.at(row - 1, 0)));
        }
        Ok(Curve { x, y })
    }

    /// The first and the last point.
    pub(crate) fn within(&self) -> (f64, f64) {
        (self.x[0], self.x[self.x.len() - 1])
    }

    /// The value at a node.
    pub(crate) fn value(&self, graph: &mut Graph, of: Id, cubic: bool) -> Id {
        let curvature = if cubic { self.curvature() } else { vec![0.0; self.x.len()] };
        let (x, y, last) = (&self.x, &self.y, self.x.len() - 1);
        let step = |k: usize| x[k + 1] - x[k];
        let slope = |k: usize| (y[k + 1] - y[k]) / step(k);
        // Half of the second derivative at each point; a sixth of the third, and the slope at the start of each piece.
        let third = |k: usize| (curvature[k + 1] - curvature[k]) / (6.0 * step(k));
        let start = |k: usize| slope(k) - step(k) * (2.0 * curvature[k] + curvature[k + 1]) / 6.0;
        let middle = last / 2;
        let offset = |graph: &mut Graph, a: f64| {
            let a = graph.constant(a);
            graph.sub(of, a)
        };
        let powers = if cubic {
            [start(middle), curvature[middle] / 2.0, third(middle)]
        } else {
            [slope(middle), 0.0, 0.0]
        };
        let from = offset(graph, x[middle]);
        // Horner's scheme.
        let mut sum = graph.constant(0.0);
        for power in powers.into_iter().rev() {
            let power = graph.constant(power);
            sum = graph.mul(sum, from);
            sum = graph.add(sum, power);
        }
        sum = graph.mul(sum, from);
        let level = graph.constant(y[middle]);
        sum = graph.add(sum, level);
        // Beyond the ends nothing bends.
        let bend = |k: usize| match cubic {
            true => (if k == last { 0.0 } else { third(k) }) - if k == 0 { 0.0 } else { third(k - 1) },
            false if k == 0 || k == last => 0.0,
            false => slope(k) - slope(k - 1),
        };
        for (k, &at) in x.iter().enumerate() {
            let (by, below) = (bend(k), k <= middle);
            if by == 0.0 {
                continue;
            }
            let mut beyond = offset(graph, at);
            if below {
                beyond = graph.neg(beyond);
            }
            beyond = graph.unary(Unary::Pos, beyond);
            if cubic {
                let square = graph.mul(beyond, beyond);
                beyond = graph.mul(square, beyond);
            }
            // The same from either side: what is taken off an odd power is added to its mirror image.
            let by = graph.constant(by);
            beyond = graph.mul(by, beyond);
            sum = graph.add(sum, beyond);
        }
        sum
    }

    /// The second derivatives of the natural spline at its points, by elimination in one band.
    fn curvature(&self) -> Vec<f64> {
        let (x, y, n) = (&self.x, &self.y, self.x.len());
        let mut found = vec![0.0; n];
        let (mut upper, mut right) = (vec![0.0; n], vec![0.0; n]);
        for k in 1..n - 1 {
            let (before, after) = (x[k] - x[k - 1], x[k + 1] - x[k]);
            let pivot = 2.0 * (before + after) - before * upper[k - 1];
            let jump = (y[k + 1] - y[k]) / after - (y[k] - y[k - 1]) / before;
            upper[k] = after / pivot;
            right[k] = (6.0 * jump - before * right[k - 1]) / pivot;
        }
        for k in (1..n - 1).rev() {
            found[k] = right[k] - upper[k] * found[k + 1];
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use phisindy_expr::Names;

    const X: [f64; 7] = [-2.0, -1.2, -0.5, 0.1, 0.9, 1.5, 3.0];
    const Y: [f64; 7] = [-5.0, -1.0, 0.3, 0.2, 1.7, 1.1, 4.0];

    /// Value and two derivatives.
    fn at(cubic: bool, at: f64) -> [f64; 3] {
        let (mut graph, mut names) = (Graph::default(), Names::default());
        let symbol = names.intern("x");
        let x = graph.symbol(symbol);
        let values = X.iter().zip(&Y).flat_map(|(x, y)| [*x, *y]).collect();
        let curve = Curve::of(&Numbers { columns: 2, values, headings: vec![] }).expect("a curve");
        let value = curve.value(&mut graph, x, cubic);
        let slope = graph.gradient(value, &[x])[0];
        let second = graph.gradient(slope, &[x])[0];
        let tape = Tape::compile(&graph, &[x], &[value, slope, second]).expect("a tape");
        let mut scratch = Scratch::<1>::new(&tape);
        scratch.at([at]);
        [0, 1, 2].map(|k| scratch.output(k)[0])
    }

    /// `numpy.interp` inside, and the slopes of the ends outside.
    #[test]
    fn a_linear_table_goes_through_its_points_and_on() {
        for k in 0..X.len() {
            approx::assert_relative_eq!(at(false, X[k])[0], Y[k], epsilon = 1e-14);
        }
        for (x, y) in [
            (-0.9, -0.44285714285714284),
            (0.5, 0.95),
            (2.0, 2.0666666666666664),
            (-3.0, -10.0),
            (4.0, 5.933333333333334),
        ] {
            approx::assert_relative_eq!(at(false, x)[0], y, max_relative = 1e-14);
        }
    }

    /// `scipy.interpolate.CubicSpline(x, y, bc_type="natural")` with its derivatives inside.
    #[test]
    fn a_cubic_table_is_the_natural_spline() {
        for (x, of) in SPLINE {
            let own = at(true, x);
            (0..3).for_each(|k| {
                approx::assert_relative_eq!(own[k], of[k], max_relative = 1e-11, epsilon = 1e-12)
            });
        }
        // Straight beyond the ends.
        let (end, beyond) = (at(true, 3.0), at(true, 5.0));
        approx::assert_relative_eq!(beyond[0], end[0] + 2.0 * end[1], max_relative = 1e-12);
        approx::assert_relative_eq!(beyond[2], 0.0, epsilon = 1e-11);
    }

    const SPLINE: [(f64, [f64; 3]); 7] = [
        (-1.7, [-3.3257475387258264, 5.390747943463299, -1.9009359411728015]),
        (-0.9, [-0.13457508325298326, 2.118176882496168, -5.131147145041809]),
        (-0.2, [0.18125712757214468, -0.5037373022995515, 1.5276193872856743]),
        (0.05, [0.16158011542508777, 0.5803980354237104, 7.145463314500424]),
        (0.5, [1.0079894102331766, 2.474593315190538, -0.7248676279147066]),
        (1.1, [1.6167926696480146, -1.0479658566085845, -4.619554394843466]),
        (2.3, [1.8829811420797027, 2.4168355323413135, 2.6034733792737423]),
    ];
}
