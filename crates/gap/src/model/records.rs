//! Preparation of records for a search: their noise, and shorter versions of long ones.

use crate::decisions::{CLEAN_COLUMN, SEARCHED_SAMPLES};
use crate::model::noise_form::growing_noise;
use phisindy_phys::Record;
use phisindy_phys::spec::Role;
use phisindy_signal::{noise_level, standard_deviation};

/// Noise of every measured column by record, from the spectrum above the motion: it needs no model. Of noise that
/// grows with the signal it is the root mean square along the record.
pub(crate) fn noise_of(records: &[Record]) -> Vec<Vec<f64>> {
    let of = |c: &Vec<f64>| {
        let level = growing_noise(c, c).unwrap_or(0.0).max(noise_level(c));
        level.max(CLEAN_COLUMN * standard_deviation(c)).max(f64::MIN_POSITIVE)
    };
    records.iter().map(|r| r.columns.iter().flatten().map(of).collect()).collect()
}

/// Records cut to the length that the search uses; `None` if none is long.
pub(crate) fn shortened(records: &[Record]) -> Option<Vec<Record>> {
    let fits = records.iter().filter(|r| r.role == Role::Fit).count().max(1);
    let most = SEARCHED_SAMPLES / fits;
    let long = records.iter().any(|r| r.len() > most + most / 2);
    let cut = |r: &Record| {
        let n = r.len().min(most);
        let columns = r.columns.iter().map(|c| c.as_ref().map(|c| c[..n].to_vec())).collect();
        // A cut record does not continue another one.
        Record { time: r.time[..n].into(), columns, continues: None, ..r.clone() }
    };
    long.then(|| records.iter().map(cut).collect())
}
