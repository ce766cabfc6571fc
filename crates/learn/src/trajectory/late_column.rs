//! Columns whose sensors look late: what the residuals say of a delay that the spec does not have.
//!
//! With a delay of each column as one more unknown beside those of a fit, `(A, g)` are the normal equations at its
//! minimum. All others follow (Schur's complement `s`), so the cost falls by `g^2/s` at the delay `-g/s`: the score
//! test (C. R. Rao, Proc. Cambridge Phil. Soc. 44 (1948) 50-57). A lag shows as a delay, to first order.

use crate::decisions::{BLIND_PART, LATE_REACH, SURE};
use crate::linear::solve_damped;
use crate::result::late_column::LateColumn;
use crate::trajectory::fit::{Context, Fit, transfer};
use crate::trajectory::layout::DELAY;
use crate::trajectory::problem::{Meaning, Problem};
use crate::trajectory::select::price;
use faer::Mat;
use phisindy_phys::Record;
use phisindy_signal::mean_step;

/// The column that looks late most, if the records ask for its delay; `None` of records in segments.
pub(crate) fn late_column(context: &Context<'_>, fit: &Fit<'_>) -> Option<LateColumn> {
    if fit.most_pieces() > 1 || fit.problem.chained {
        return None;
    }
    let n = context.system.columns();
    let columns: Vec<usize> = (0..n).filter(|&k| is_open(&context.records, k)).collect();
    let needed = price(1, columns.len(), fit.effective) + 2.0 * (SURE / (1.0 - SURE)).ln();
    let most = columns.iter().filter_map(|&k| Some((k, delay_of(context, fit, k)?)));
    let (column, (delay, gain)) = most.max_by(|a, b| a.1.1.total_cmp(&b.1.1))?;
    let name = context.system.measured(column).0.to_owned();
    (gain / fit.inflation() > needed).then_some(LateColumn { column, name, delay, reach: LATE_REACH, needed })
}

/// Whether a column is measured, and its delay is neither stated nor looked for.
fn is_open(records: &[&Record], k: usize) -> bool {
    let unstated = |r: &&&Record| {
        let delay = &r.sensors[k].delay;
        delay.within.is_none() && delay.shared.is_none() && delay.start == 0.0
    };
    let mut having = records.iter().filter(|r| r.columns[k].is_some()).peekable();
    having.peek().is_some() && having.all(|r| unstated(&r))
}

/// The delay of a column in all records, and by how much the cost falls with it.
fn delay_of(context: &Context<'_>, fit: &Fit<'_>, column: usize) -> Option<(f64, f64)> {
    let late = |r: &&Record| {
        let mut record = (*r).clone();
        let reach = mean_step(&record.time) * record.len() as f64;
        record.sensors[column].delay.within = Some((-reach, reach));
        record
    };
    let records: Vec<Record> = context.records.iter().map(late).collect();
    let own = &fit.problem;
    let mut problem =
        Problem::new(own.system, &own.terms, &records.iter().collect::<Vec<_>>(), &fit.pieces).ok()?;
    problem.belief = own.belief;
    let mut x = vec![0.0; problem.unknowns];
    x[..own.terms.len()].copy_from_slice(&fit.x[..own.terms.len()]);
    transfer(own, &fit.x, &problem, &mut x);
    for (a, b) in own.segments.iter().zip(&problem.segments) {
        let n = own.system.states.len();
        x[b.start..b.start + n].copy_from_slice(&fit.x[a.start..a.start + n]);
    }
    let normal = problem.normal(&x, &fit.weights).ok()?;
    let meanings = problem.meanings();
    let delays: Vec<usize> = (0..meanings.len())
        .filter(|&k| matches!(meanings[k], Meaning::Sensor(_, c, DELAY) if c == column))
        .collect();
    // What has run into a bound stays there.
    let follows = |k: usize| {
        let (low, high) = problem.bounds[k];
        !delays.contains(&k) && x[k] > low && x[k] < high
    };
    let others: Vec<usize> = (0..problem.unknowns).filter(|&k| follows(k)).collect();
    let along = |i: usize| delays.iter().map(|&d| normal.matrix[(i, d)]).sum::<f64>();
    let right: Vec<f64> = others.iter().map(|&i| along(i)).collect();
    let inner = Mat::from_fn(others.len(), others.len(), |i, j| normal.matrix[(others[i], others[j])]);
    let moved = solve_damped(&inner, &right, 0.0)?;
    let through = |of: &dyn Fn(usize) -> f64| others.iter().zip(&moved).map(|(&i, m)| of(i) * m).sum::<f64>();
    let gradient = delays.iter().map(|&d| normal.gradient[d]).sum::<f64>() - through(&|i| normal.gradient[i]);
    let whole = delays.iter().map(|&d| along(d)).sum::<f64>();
    let curvature = whole - through(&along);
    // A delay that start states or other delays make good says nothing.
    (curvature > BLIND_PART * whole).then(|| (-gradient / curvature, gradient * gradient / curvature))
}
