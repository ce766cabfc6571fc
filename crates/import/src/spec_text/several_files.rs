//! One spec for several files of one rig: their records, and what differs between them.

use crate::draft::Draft;
use crate::roles::Input;
use phisindy_phys::unit::Unit;

/// How a draft takes its file: what the columns of the model are called and what they are.
#[derive(PartialEq)]
struct Reading {
    columns: Vec<(String, Option<String>)>,
    input: std::mem::Discriminant<Input>,
    time: Option<(String, Option<String>)>,
}

fn reading(draft: &Draft) -> Reading {
    let column = |c: usize| {
        let heading = &draft.table.columns[c].heading;
        (heading.raw.clone(), heading.unit.clone())
    };
    Reading {
        columns: draft.roles.used().map(column).collect(),
        input: std::mem::discriminant(&draft.roles.input),
        time: (!draft.time.counted).then(|| column(draft.time.column)),
    }
}

/// Why two files are not of one rig with one spec, in words.
pub(super) fn unlike((one, first): (&Draft, &str), (other, file): (&Draft, &str)) -> Option<String> {
    let (a, b) = (reading(one), reading(other));
    let list = |reading: &Reading| {
        let names = reading.time.iter().chain(&reading.columns);
        let named = |(name, unit): &(String, Option<String>)| match unit {
            Some(unit) => format!("`{name}` in {unit}"),
            None => format!("`{name}`"),
        };
        names.map(named).collect::<Vec<_>>().join(", ")
    };
    (a != b).then(|| {
        format!("`{file}` is read in another way than `{first}`: {} there, {} here", list(&a), list(&b))
    })
}

/// What differs between files: numbers in their names, and columns of one value that is another one in each file.
pub(super) fn differences(drafts: &[(&Draft, &str)]) -> Vec<String> {
    let mut told = vec![];
    let numbers: Vec<Vec<String>> = drafts.iter().map(|(_, file)| numbers(file)).collect();
    let count = numbers[0].len();
    if numbers.iter().all(|own| own.len() == count) {
        for k in (0..count).filter(|&k| numbers.iter().any(|own| own[k] != numbers[0][k])) {
            let own: Vec<&str> = numbers.iter().map(|own| own[k].as_str()).collect();
            told.push(format!("the names of the files: {}", own.join(", ")));
        }
    }
    for (k, column) in drafts[0].0.table.columns.iter().enumerate() {
        let value = |draft: &Draft| {
            let own = draft.table.columns.iter().position(|c| c.heading.raw == column.heading.raw)?;
            let statistics = &draft.statistics[own];
            statistics.is_constant().then_some(statistics.min).filter(|value| value.is_finite())
        };
        let values: Option<Vec<f64>> = drafts.iter().map(|(draft, _)| value(draft)).collect();
        let Some(values) = values.filter(|values| values.iter().any(|value| *value != values[0])) else {
            continue;
        };
        let list = values.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
        told.push(format!("`{}`: {list}", drafts[0].0.raw(k)));
    }
    told
}

/// The masses in the names of the files (kg), where these are loads: the inertias that regressions on the files find
/// differ as they do.
pub(super) fn loads(drafts: &[(&Draft, &str)]) -> Option<Vec<f64>> {
    let masses: Vec<Vec<f64>> = drafts.iter().map(|(_, file)| masses(file)).collect();
    let named: Vec<f64> = masses.iter().map(|own| own.first().copied()).collect::<Option<_>>()?;
    let inertia =
        |(draft, _): &(&Draft, &str)| draft.estimate.input_gain.filter(|b| *b > 0.0).map(f64::recip);
    let moved: Vec<f64> = drafts.iter().map(inertia).collect::<Option<_>>()?;
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let (x, y) = (mean(&named), mean(&moved));
    let power: f64 = named.iter().map(|m| (m - x).powi(2)).sum();
    let slope = named.iter().zip(&moved).map(|(m, own)| (m - x) * (own - y)).sum::<f64>() / power;
    let is_force = matches!(drafts[0].0.roles.input, Input::Force(_)) && !drafts[0].0.roles.is_angle;
    (is_force && ALIKE.contains(&slope)).then_some(named)
}

/// One kilogram more in a name is about that much more inertia, as regressions tell it.
const ALIKE: std::ops::RangeInclusive<f64> = 0.5..=2.0;

/// The masses in the name of a file (kg).
fn masses(file: &str) -> Vec<f64> {
    let mass = |word: &String| {
        let (number, unit) = word.split_at(word.find(|c: char| c.is_alphabetic())?);
        let (number, unit) = (number.parse::<f64>().ok()?, Unit::parse(unit).ok()?);
        (unit.dimension == Unit::parse("kg").ok()?.dimension).then_some(number * unit.factor)
    };
    numbers(file).iter().filter_map(mass).collect()
}

/// The numbers in the name of a file, with the letters behind them: `250g` of `stickslip_250g.csv`.
fn numbers(file: &str) -> Vec<String> {
    let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
    let words = stem.split(|c: char| !c.is_alphanumeric() && c != '.');
    words.filter(|word| word.starts_with(|c: char| c.is_ascii_digit())).map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_files_hold_numbers() {
        assert_eq!(numbers("stickslip_250g_run2.csv"), ["250g"]);
        assert_eq!(numbers("3.5bar-02.txt"), ["3.5bar", "02"]);
        assert_eq!(numbers("rig.csv"), Vec::<String>::new());
        assert_eq!((masses("load_1.5kg.csv"), masses("250g_3bar.csv")), (vec![1.5], vec![0.25]));
    }
}
