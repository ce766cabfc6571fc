//! Mistakes in a data file that no missing effect explains: columns of two bodies exchanged, a wrong unit.

use crate::decisions::{MOVES, ONE_SHAPE, OTHER_SHAPE, OUT_OF_PROPORTION, SAYS_NOTHING, WRONG_UNIT};
use crate::model::Fitted;
use crate::result::{DataMistake, Named};
use phisindy_signal::{noise_level, standard_deviation};
use std::borrow::Cow;

/// Mistakes that the records show when compared with a fitted model.
pub(crate) fn data_mistakes(base: &Fitted) -> Vec<DataMistake> {
    let quantities: Vec<(&str, &str)> = base.model.system.quantities().collect();
    let mut mistakes = Vec::new();
    for (record, fit) in base.model.records.iter().zip(&base.cal.records) {
        let simulated = |k: usize| -> Option<Vec<f64>> {
            let (column, residual) = (record.columns[k].as_ref()?, &fit.residuals[k]);
            let all: Vec<f64> = column.iter().zip(residual).map(|(y, e)| y - e).collect();
            (residual.len() == column.len()).then(|| record.own_times.of(k, &all).into_owned())
        };
        let all: Vec<(usize, Cow<'_, [f64]>, Vec<f64>)> = (0..record.columns.len())
            .filter_map(|k| Some((k, record.own_column(k)?.1, simulated(k)?)))
            .collect();
        for (i, (a, measured, own)) in all.iter().enumerate() {
            let (slope, alike) = agreement(own, measured);
            let of = || Named { record: record.name.clone(), column: quantities[*a].0.to_owned() };
            if alike > ONE_SHAPE && !(1.0 / WRONG_UNIT..WRONG_UNIT).contains(&slope) {
                mistakes.push(DataMistake::Scale { of: of(), factor: slope });
            }
            let larger = standard_deviation(own) / standard_deviation(measured);
            // A model that says nothing of a column has no unit that could be wrong.
            let far =
                larger > SAYS_NOTHING && !(1.0 / OUT_OF_PROPORTION..OUT_OF_PROPORTION).contains(&larger);
            if alike <= ONE_SHAPE && far && standard_deviation(measured) > MOVES * noise_level(measured) {
                mistakes.push(DataMistake::Proportion { of: of(), factor: larger });
            }
            for (b, other, theirs) in
                all[i + 1..].iter().filter(|(b, ..)| quantities[*b].1 == quantities[*a].1)
            {
                let now = alike.min(agreement(theirs, other).1);
                let swapped = agreement(own, other).1.min(agreement(theirs, measured).1);
                if swapped > ONE_SHAPE && now < OTHER_SHAPE {
                    mistakes.push(DataMistake::Swapped { of: of(), other: quantities[*b].0.to_owned() });
                }
            }
        }
    }
    mistakes
}

/// Slope of `y` against `x`, and their correlation, both about their means.
fn agreement(x: &[f64], y: &[f64]) -> (f64, f64) {
    let n = x.len().max(1) as f64;
    let (mx, my) = (x.iter().sum::<f64>() / n, y.iter().sum::<f64>() / n);
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (x, y) in x.iter().zip(y) {
        xx += (x - mx).powi(2);
        xy += (x - mx) * (y - my);
        yy += (y - my).powi(2);
    }
    if xx > 0.0 && yy > 0.0 { (xy / xx, xy / (xx * yy).sqrt()) } else { (1.0, 0.0) }
}
