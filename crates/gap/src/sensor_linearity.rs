//! A sensor whose scale bends. A spring that bends the motion a little looks like a sensor whose reading is
//! not quite in proportion: y = x + a x^2 + b x^3. Sensors are good to some tenths of a per cent of their
//! range.

use crate::decisions::{SAME_GAP, SENSOR_LINEARITY};
use crate::model::{Fitted, TrialModel, current, is_sure};
use crate::place::Effect;
use crate::result::{Cause, Named, PlacedLaw, SensorNonlinearity};
use phisindy_learn::Effort;
use phisindy_phys::spec::Role;
use phisindy_signal::{effective_samples, standard_deviation};
use std::sync::Arc;

/// The first effect of a model, by index, that a bent scale of the sensors would replace: without it the
/// model is as good on columns from which a parabola and a cubic are taken, each no larger than the linearity
/// of a good sensor.
pub(crate) fn sensor_nonlinearity(last: &Fitted, noise: &[Vec<f64>]) -> Option<(usize, SensorNonlinearity)> {
    let effects = current(last);
    let bends = |e: &Effect| e.entry.law.is_spring() && !e.entry.law.is_linear_spring();
    (0..effects.len()).filter(|&k| bends(&effects[k])).find_map(|k| {
        let rest: Vec<Effect> =
            effects.iter().enumerate().filter(|(j, _)| *j != k).map(|(_, e)| e.clone()).collect();
        let mut model = last.model.without_effects().with_all(&rest).ok()?;
        last.starts(&mut model);
        let plain = Fitted::new(model, noise, Effort::Plain).ok()?;
        let (straight, of, bend) = straightened(&plain)?;
        let fitted = Fitted::new(straight, noise, Effort::Plain).ok()?;
        (fitted.score.gap() < SAME_GAP * last.score.gap())
            .then(|| (k, SensorNonlinearity { law: PlacedLaw::of(&effects[k]), of, bend }))
    })
}

/// A model on columns from which the parabola and the cubic in the column are taken that its residual holds,
/// with the column that bends most and its bend, the rms of both over the standard deviation. `None` if a
/// bend is larger than that of a good sensor.
fn straightened(of: &Fitted) -> Option<(TrialModel, Named, f64)> {
    let mut model = of.settled();
    let mut worst: Option<(f64, Named)> = None;
    for (state, (name, _)) in of.model.system.quantities().take(of.model.system.columns()).enumerate() {
        let Some(Bend { of: [a, b], .. }) = Bend::new(of, state) else { continue };
        for (r, record) in of.model.records.iter().enumerate() {
            let Some(column) = &record.columns[state] else { continue };
            let off_line: Vec<f64> = bends(column).iter().map(|p| a * p[0] + b * p[1]).collect();
            let size = standard_deviation(&off_line) / standard_deviation(column);
            if size > SENSOR_LINEARITY {
                return None;
            }
            if worst.as_ref().is_none_or(|(most, _)| size > *most) {
                worst = Some((size, Named { record: record.name.clone(), column: name.to_owned() }));
            }
            let mean = column.iter().sum::<f64>() / column.len().max(1) as f64;
            let bend = column.iter().map(|y| a * (y - mean).powi(2) + b * (y - mean).powi(3));
            let bend: Vec<f64> = bend.collect();
            for records in [&mut model.records, &mut model.smooth] {
                if let Some(own) = &mut Arc::make_mut(records)[r].columns[state] {
                    own.iter_mut().zip(&bend).for_each(|(y, bend)| *y -= bend);
                }
            }
        }
    }
    let (bend, named) = worst?;
    Some((model, named, bend))
}

/// The parabola and the cubic in a column that its residual holds.
struct Bend {
    of: [f64; 2],
    /// The part of the residual's power that they are.
    share: f64,
    /// By how much they lower the criterion.
    gain: f64,
}

impl Bend {
    /// One sensor reads the column in all records: its bend is found on the Fit records. `None` where nothing bends.
    fn new(of: &Fitted, state: usize) -> Option<Bend> {
        let (mut normal, mut right, mut power) = ([[0.0; 2]; 2], [0.0; 2], 0.0);
        let mut independent = 0.0;
        let records = of.model.records.iter().zip(&of.cal.records);
        for (record, fit) in records.filter(|(r, _)| r.role == Role::Fit) {
            let Some((_, column)) = record.own_column(state) else { continue };
            let residual = fit.own_residual(state);
            independent += effective_samples(&residual);
            for (powers, e) in bends(&column).into_iter().zip(residual.iter()) {
                power += e * e;
                for i in 0..2 {
                    right[i] += powers[i] * e;
                    (0..2).for_each(|j| normal[i][j] += powers[i] * powers[j]);
                }
            }
        }
        let determinant = normal[0][0] * normal[1][1] - normal[0][1] * normal[1][0];
        if determinant <= 0.0 {
            return None;
        }
        let a = (right[0] * normal[1][1] - right[1] * normal[0][1]) / determinant;
        let b = (right[1] * normal[0][0] - right[0] * normal[1][0]) / determinant;
        let share = (a * right[0] + b * right[1]) / power;
        Some(Bend { of: [a, b], share, gain: -independent * (1.0 - share).ln() - 2.0 * independent.ln() })
    }
}

/// The columns whose residual is sure to bend with them: noise does not know the motion.
pub(crate) fn bent_columns(of: &Fitted) -> impl Iterator<Item = Cause> {
    let columns = of.model.system.quantities().take(of.model.system.columns()).enumerate();
    columns.filter_map(|(state, (name, _))| {
        let bend = Bend::new(of, state).filter(|bend| is_sure(bend.gain, [0.0].into_iter()))?;
        Some(Cause::Bend { column: name.to_owned(), share: bend.share })
    })
}

/// The square and the cube of a column about its mean, each without the straight line in the column that is
/// nearest to it: a line is a gain and an offset, which the fit may have taken up.
fn bends(column: &[f64]) -> Vec<[f64; 2]> {
    let n = column.len().max(1) as f64;
    let mean = column.iter().sum::<f64>() / n;
    let power = column.iter().map(|y| (y - mean).powi(2)).sum::<f64>();
    let without_line = |exponent: i32| -> Vec<f64> {
        let values: Vec<f64> = column.iter().map(|y| (y - mean).powi(exponent)).collect();
        let level = values.iter().sum::<f64>() / n;
        let slope = values.iter().zip(column).map(|(v, y)| v * (y - mean)).sum::<f64>() / power;
        values.iter().zip(column).map(|(v, y)| v - level - slope * (y - mean)).collect()
    };
    without_line(2).into_iter().zip(without_line(3)).map(|(a, b)| [a, b]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_models::{effect, model, with_effects};

    /// A free oscillation whose sensor bends by a fifth of a per cent: a quadratic spring fits as well, but
    /// is not what the record tells. A spring that bends the motion by more than a sensor may is.
    #[test]
    fn a_bent_scale_is_no_spring() {
        let of = |truth: &str| {
            model(&format!(
                r#"(states: {{ "x": "m", "v": "m/s" }}, constants: {{ "k": (6.0, "1/s^2"), "c": (0.02, "1/s") }}, known: {{ "x": "v", "v": "-k*x - c*v" }}, unknown: {{}},
                data: [ Synthetic(truth: {{ {truth} }}, start: {{ "x": 1.0, "v": 0.0 }}, duration: 30.0, step: 0.03, noise: Additive(0.002), seed: 1, measure: ["x"]) ])"#
            ))
        };
        let (plain, noise) = of("");
        assert_eq!(bent_columns(&with_effects(&plain, &[], &noise)).count(), 0);
        let spring = include_str!("../../phys/laws/quadratic-stiffness.ron");
        let at = |model: &TrialModel, noise: &[Vec<f64>], start: f64| {
            let effect = effect(model, "quadratic-stiffness", spring, "v", &[start]);
            with_effects(model, &[effect], noise)
        };
        let (mut straight, noise) = of("");
        for records in [&mut straight.records, &mut straight.smooth] {
            let column = Arc::make_mut(records)[0].columns[0].as_mut().expect("a column");
            column.iter_mut().for_each(|x| *x += 0.004 * *x * *x);
        }
        assert_eq!(bent_columns(&with_effects(&straight, &[], &noise)).count(), 1);
        let found =
            sensor_nonlinearity(&at(&straight, &noise, 0.01), &noise).map(|(k, curve)| (k, curve.bend));
        assert!(found.is_some_and(|(k, bend)| k == 0 && bend > 5e-4 && bend < SENSOR_LINEARITY), "{found:?}");
        let (soft, noise) = of(r#""v": "-0.6*x^2""#);
        assert_eq!(sensor_nonlinearity(&at(&soft, &noise, 0.5), &noise), None);
    }
}
