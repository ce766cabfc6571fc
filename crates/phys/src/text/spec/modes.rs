//! The modes of a structure, and its equations in coordinates of which the first are its points.
//!
//! With `K phi = w^2 M phi` and `phi' M phi = 1` the modal coordinates `a` obey `a'' + D a' + w^2 a = phi' f`, where `D =
//! phi' C phi` is diagonal for ratios (D. Ewins, Modal Testing, 2nd ed., 2.4). A point reads `p = P a`. It is a state
//! in the place of the mode that moves it most, so that it can be measured, pushed and looked at as any other state;
//! the rates of the other modes stay as short as they are: `y = T a`, `T = [P_S P_R; 0 s]`.

use crate::text::files::Numbers;
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use phisindy_expr::Span;
use std::f64::consts::TAU;
use std::fmt;

/// A row of a point below this part of its length adds nothing to those before it.
const DEPENDENT: f64 = 1e-9;
/// An eigenvalue of the stiffness may be negative by this part of the largest: rounding of a free body.
const ROUNDING: f64 = 1e-9;

/// How a structure is damped.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Damped {
    /// By a matrix, and where it is named.
    Matrix(Numbers, Span),
    /// By a ratio for each mode, of which the last counts for all others; none: not at all.
    Ratios(Vec<f64>),
}

/// What a structure is made of.
pub(super) struct Matrices<'a> {
    pub(super) mass: &'a Numbers,
    pub(super) stiffness: &'a Numbers,
    pub(super) damping: Damped,
    /// How far each point moves with each degree of freedom.
    pub(super) points: &'a [Vec<f64>],
}

/// A structure in coordinates of which the first are the displacements of its points, `y'' = -K y - D y' + B f` with
/// a force `f` at each point.
#[derive(Clone, Debug, PartialEq)]
pub struct Modes {
    /// Of the matrices.
    pub degrees: usize,
    /// How many modes they have.
    pub all: usize,
    /// Of the modes that are kept (Hz), in order.
    pub frequencies: Vec<f64>,
    /// The kept modes that are states beside the points, counted from 0 among all.
    pub beside: Vec<usize>,
    /// `K`, row by row.
    pub(crate) stiffness: Vec<Vec<f64>>,
    /// `D`, row by row.
    pub(crate) damping: Vec<Vec<f64>>,
    /// `B`, row by row: the rates that a force of 1 at each point makes.
    pub(crate) mobility: Vec<Vec<f64>>,
}

/// Why matrices make no structure.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum NoModes {
    /// This row of the mass matrix makes it indefinite.
    Mass(usize),
    /// An eigenvalue is negative (rad^2/s^2).
    Stiffness(f64),
    /// No mode is kept: the lowest and the highest frequency (Hz).
    Empty(f64, f64),
    /// A point moves with those before it, or with none of so many modes.
    Point(usize, usize),
}

impl NoModes {
    pub(super) fn of_point(&self) -> Option<usize> {
        if let NoModes::Point(k, _) = self { Some(*k) } else { None }
    }

    pub(super) fn is_of_mass(&self) -> bool {
        matches!(self, NoModes::Mass(_))
    }

    pub(super) fn advice(&self) -> &'static str {
        match self {
            NoModes::Mass(_) => {
                "every degree of freedom has a mass: condense those without one, and check the signs"
            }
            NoModes::Stiffness(_) => "a structure that buckles has no modes: check the signs of its entries",
            NoModes::Empty(..) => "choose a `band` in Hz that holds some of them",
            NoModes::Point(..) => {
                "keep more modes, or take the point out and write it by the others in `let`"
            }
        }
    }
}

impl fmt::Display for NoModes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NoModes::Mass(row) => {
                write!(f, "the mass matrix is not positive definite: row {} of it", row + 1)
            }
            NoModes::Stiffness(value) => {
                write!(f, "the stiffness matrix is not positive: a mode has w^2 = {value:.3e} rad^2/s^2")
            }
            NoModes::Empty(low, high) => {
                write!(f, "no mode lies in the band: the frequencies go from {low:.4} to {high:.4} Hz")
            }
            NoModes::Point(_, modes) => {
                write!(
                    f,
                    "this point does not move by itself: in {modes} modes it follows from the points before it"
                )
            }
        }
    }
}

impl Modes {
    /// Of matrices; reduced to the first `most` modes, and to those within a band (Hz).
    pub(super) fn new(
        of: &Matrices<'_>,
        most: Option<usize>,
        band: Option<(f64, f64)>,
    ) -> Result<Modes, NoModes> {
        let n = of.mass.rows();
        let (w2, phi) = eigen(of.mass, of.stiffness)?;
        let hertz: Vec<f64> = w2.iter().map(|w2| w2.max(0.0).sqrt() / TAU).collect();
        let inside = |f: f64| band.is_none_or(|(low, high)| (low..=high).contains(&f));
        let kept: Vec<usize> = (0..n).filter(|&k| inside(hertz[k])).take(most.unwrap_or(n)).collect();
        if kept.is_empty() {
            return Err(NoModes::Empty(hertz[0], hertz[n - 1]));
        }
        let m = kept.len();
        // Of each kept mode.
        let shapes = Mat::from_fn(n, m, |i, k| phi[(i, kept[k])]);
        let rows = Mat::from_fn(of.points.len(), n, |j, i| of.points[j][i]);
        let points = &rows * &shapes;
        let damping = match &of.damping {
            Damped::Matrix(c, _) => {
                let c = Mat::from_fn(n, n, |i, j| 0.5 * (c.at(i, j) + c.at(j, i)));
                let own = shapes.transpose() * c * &shapes;
                // What rounding leaves between modes that do not know of each other is nothing.
                let scale = |i: usize, j: usize| (own[(i, i)] * own[(j, j)]).abs().sqrt();
                Mat::from_fn(
                    m,
                    m,
                    |i, j| if own[(i, j)].abs() > 1e-11 * scale(i, j) { own[(i, j)] } else { 0.0 },
                )
            }
            Damped::Ratios(ratios) => {
                let ratio = |k: usize| ratios.get(k).or(ratios.last()).copied().unwrap_or(0.0);
                Mat::from_fn(m, m, |i, j| if i == j { 2.0 * ratio(i) * TAU * hertz[kept[i]] } else { 0.0 })
            }
        };
        let chosen = replaced(&points, &kept.iter().map(|&k| w2[k]).collect::<Vec<f64>>())?;
        let beside: Vec<usize> = (0..m).filter(|k| !chosen.contains(k)).collect();
        let order: Vec<usize> = chosen.iter().chain(&beside).copied().collect();
        let p = chosen.len();
        // A mode is measured by its largest displacement.
        let size = |k: usize| (0..n).fold(0.0_f64, |most, i| most.max(shapes[(i, k)].abs()));
        let to = Mat::from_fn(m, m, |i, j| match (i < p, i == j) {
            (true, _) => points[(i, order[j])],
            (false, true) => size(order[j]),
            (false, false) => 0.0,
        });
        let back = inverse(&to, p);
        let turned = |of: &dyn Fn(usize, usize) -> f64| {
            let inner = Mat::from_fn(m, m, |i, j| of(order[i], order[j]));
            let all = &to * inner * &back;
            (0..m).map(|i| (0..m).map(|j| all[(i, j)]).collect()).collect::<Vec<Vec<f64>>>()
        };
        let stiffness = turned(&|i, j| if i == j { w2[kept[i]].max(0.0) } else { 0.0 });
        let damping = turned(&|i, j| damping[(i, j)]);
        let shares = Mat::from_fn(m, p, |k, j| points[(j, order[k])]);
        let mobility = &to * shares;
        Ok(Modes {
            degrees: n,
            all: n,
            frequencies: kept.iter().map(|&k| hertz[k]).collect(),
            beside: beside.iter().map(|&k| kept[k]).collect(),
            stiffness,
            damping,
            mobility: (0..m).map(|i| (0..p).map(|j| mobility[(i, j)]).collect()).collect(),
        })
    }
}

/// The inverse of `[A B; 0 s]`, whose first block has `p` rows.
fn inverse(of: &Mat<f64>, p: usize) -> Mat<f64> {
    let m = of.nrows();
    let block = Mat::from_fn(p, p, |i, j| of[(i, j)]);
    let right = Mat::from_fn(p, m, |i, j| match (j < p, i == j) {
        (true, true) => 1.0,
        (true, false) => 0.0,
        (false, _) => -of[(i, j)] / of[(j, j)],
    });
    let top = block.partial_piv_lu().solve(&right);
    Mat::from_fn(m, m, |i, j| match (i < p, i == j) {
        (true, _) => top[(i, j)],
        (false, true) => 1.0 / of[(i, i)],
        (false, false) => 0.0,
    })
}

/// Squares of the frequencies, and the modes of mass 1 in columns, from slow to fast.
fn eigen(mass: &Numbers, stiffness: &Numbers) -> Result<(Vec<f64>, Mat<f64>), NoModes> {
    let n = mass.rows();
    let symmetric = |of: &Numbers| Mat::from_fn(n, n, |i, j| 0.5 * (of.at(i, j) + of.at(j, i)));
    let lower = cholesky(&symmetric(mass)).map_err(NoModes::Mass)?;
    // `L^-1 K L^-T`
    let half = solved(&lower, &symmetric(stiffness));
    let whole = solved(&lower, &half.transpose().to_owned());
    let whole = Mat::from_fn(n, n, |i, j| 0.5 * (whole[(i, j)] + whole[(j, i)]));
    let found = whole.self_adjoint_eigen(Side::Lower).map_err(|_| NoModes::Stiffness(f64::NAN))?;
    let w2: Vec<f64> = (0..n).map(|k| found.S()[k]).collect();
    let largest = w2.iter().fold(0.0_f64, |most, w2| most.max(w2.abs()));
    if let Some(&low) = w2.iter().find(|w2| w2.is_nan() || **w2 < -ROUNDING * largest) {
        return Err(NoModes::Stiffness(low));
    }
    // `L^-T` of the eigenvectors, from below.
    let mut phi = found.U().to_owned();
    for k in 0..n {
        for i in (0..n).rev() {
            let below: f64 = (i + 1..n).map(|j| lower[(j, i)] * phi[(j, k)]).sum();
            phi[(i, k)] = (phi[(i, k)] - below) / lower[(i, i)];
        }
    }
    Ok((w2, phi))
}

/// `L` of `A = L L'`, or the row whose pivot is not positive.
fn cholesky(a: &Mat<f64>) -> Result<Mat<f64>, usize> {
    let n = a.nrows();
    let mut l = Mat::<f64>::zeros(n, n);
    for i in 0..n {
        for j in 0..=i {
            let sum: f64 = (0..j).map(|k| l[(i, k)] * l[(j, k)]).sum();
            let rest = a[(i, j)] - sum;
            if i != j {
                l[(i, j)] = rest / l[(j, j)];
            } else if rest > 1e-13 * a[(i, i)].abs() {
                l[(i, i)] = rest.sqrt();
            } else {
                return Err(i);
            }
        }
    }
    Ok(l)
}

/// `L^-1 B`.
fn solved(lower: &Mat<f64>, b: &Mat<f64>) -> Mat<f64> {
    let mut x = b.clone();
    for c in 0..x.ncols() {
        for i in 0..x.nrows() {
            let above: f64 = (0..i).map(|j| lower[(i, j)] * x[(j, c)]).sum();
            x[(i, c)] = (x[(i, c)] - above) / lower[(i, i)];
        }
    }
    x
}

/// The mode in whose place each point stands: the one that moves it most under a force, of what the points before
/// it leave (elimination with pivots in rows).
fn replaced(points: &Mat<f64>, w2: &[f64]) -> Result<Vec<usize>, NoModes> {
    let (p, m) = (points.nrows(), points.ncols());
    let floor = 1e-6 * w2.iter().fold(f64::MIN_POSITIVE, |most, w2| most.max(*w2));
    let mut rows = Mat::from_fn(p, m, |j, k| points[(j, k)] / (w2[k].max(0.0) + floor).sqrt());
    let mut chosen: Vec<usize> = Vec::new();
    for j in 0..p {
        let length = (0..m).map(|k| rows[(j, k)].powi(2)).sum::<f64>().sqrt();
        for (i, &pivot) in chosen.iter().enumerate() {
            let factor = rows[(j, pivot)] / rows[(i, pivot)];
            (0..m).for_each(|k| rows[(j, k)] -= factor * rows[(i, k)]);
            rows[(j, pivot)] = 0.0;
        }
        let size = |k: &usize| rows[(j, *k)].abs();
        let best = (0..m).filter(|k| !chosen.contains(k)).max_by(|a, b| size(a).total_cmp(&size(b)));
        match best.filter(|k| size(k) > DEPENDENT * length) {
            Some(best) => chosen.push(best),
            None => return Err(NoModes::Point(j, m)),
        }
    }
    Ok(chosen)
}
