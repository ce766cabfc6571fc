//! Preparation of records for a search: their noise, and shorter versions of long ones.

use crate::decisions::{CLEAN_COLUMN, SEARCHED_SAMPLES};
use crate::model::noise_form::GrowingNoise;
use phisindy_phys::Record;
use phisindy_phys::spec::Role;

/// Noise of every measured column by record, from the spectrum above the motion: it needs no model. Of noise
/// that grows with the signal it is the root mean square along the record.
pub(crate) fn noise_of(records: &[Record]) -> Vec<Vec<f64>> {
    let growing = growing_noise(records, |r, k| records[r].columns[k].as_deref());
    let of = |record: &Record, k: usize| {
        let (_, own) = record.own_column(k)?;
        let level = growing[k].map_or(0.0, |form| form.root_mean_square(&own)).max(record.noise_level(k));
        Some(level.max(least_noise_of(record, k)))
    };
    records.iter().map(|r| (0..r.columns.len()).filter_map(|k| of(r, k)).collect()).collect()
}

/// The smallest noise of a column that is assumed.
pub(crate) fn least_noise_of(record: &Record, column: usize) -> f64 {
    (CLEAN_COLUMN * record.deviation(column)).max(f64::MIN_POSITIVE)
}

/// For each column how the noise of its sensor grows with the signal, by the first record that shows it;
/// `values` are the column or what a model leaves of it, at all samples. One that is short, or mostly at rest, does not show
/// it.
pub(crate) fn growing_noise<'a>(
    records: &[Record],
    values: impl Fn(usize, usize) -> Option<&'a [f64]>,
) -> Vec<Option<GrowingNoise>> {
    let columns = records.first().map_or(0, |r| r.columns.len());
    let shown = |r: usize, k: usize| {
        let (_, own) = records[r].own_column(k)?;
        GrowingNoise::of(&records[r].own_times.of(k, values(r, k)?), &own)
    };
    (0..columns).map(|k| (0..records.len()).find_map(|r| shown(r, k))).collect()
}

/// Records cut to the length that the search uses; `None` if none is long.
pub(crate) fn shortened(records: &[Record]) -> Option<Vec<Record>> {
    let fits = records.iter().filter(|r| r.role == Role::Fit).count().max(1);
    let most = SEARCHED_SAMPLES / fits;
    let long = records.iter().any(|r| r.len() > most + most / 2);
    let cut = |r: &Record| {
        let n = r.len().min(most);
        r.within(0..n)
    };
    long.then(|| records.iter().map(cut).collect())
}
