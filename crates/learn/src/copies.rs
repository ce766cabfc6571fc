//! Records that are listed twice: counted once, for a copy is no second measurement.

use crate::result::identified::Identified;
use crate::result::quantity::ParameterId;
use crate::result::record_fit::RecordFit;
use crate::result::warning::Warning;
use phisindy_phys::Record;
use phisindy_phys::spec::Role;

/// For each record the one of which it is a copy, with the same samples, times and constants: the first one that
/// is fitted, or else the first.
pub(crate) fn copies(records: &[Record]) -> Vec<Option<usize>> {
    let same =
        |a: &Record, b: &Record| a.time == b.time && a.columns == b.columns && a.constants == b.constants;
    let first = |k: usize| {
        let all = (0..records.len()).filter(|&j| same(&records[j], &records[k]));
        all.min_by_key(|&j| (records[j].role != Role::Fit, j)).filter(|&j| j != k)
    };
    (0..records.len()).map(first).collect()
}

/// The records without these copies.
pub(crate) fn without(records: &[Record], copies: &[Option<usize>]) -> Vec<Record> {
    let kept = records.iter().zip(copies).filter(|(_, of)| of.is_none()).map(|(record, _)| record.clone());
    let mut kept: Vec<Record> = kept.collect();
    for record in &mut kept {
        record.continues = record.continues.map(|k| place(copies, copies[k].unwrap_or(k)));
    }
    kept
}

/// The place of a record among those without copies.
fn place(copies: &[Option<usize>], k: usize) -> usize {
    copies[..k].iter().filter(|of| of.is_none()).count()
}

/// Puts the copies back into a result: each is met as its original, and told.
pub(crate) fn restored(mut found: Identified, records: &[Record], copies: &[Option<usize>]) -> Identified {
    let kept: Vec<usize> = (0..records.len()).filter(|&k| copies[k].is_none()).collect();
    let moved = |id: &mut ParameterId| id.owner.iter_mut().for_each(|owner| owner.index = kept[owner.index]);
    found.parameters.iter_mut().for_each(|p| moved(&mut p.id));
    let adapted = found.records.iter_mut().filter_map(|r| r.adapted.as_mut());
    adapted.for_each(|a| a.values.iter_mut().for_each(|v| moved(&mut v.id)));
    let originals = found.records.clone();
    for (k, of) in copies.iter().enumerate().filter_map(|(k, of)| Some((k, (*of)?))) {
        let record = records[k].name.clone();
        found.records.insert(k, RecordFit { name: record.clone(), ..originals[place(copies, of)].clone() });
        found.warnings.push(Warning::Copy { record, of: records[of].name.clone() });
    }
    found
}
