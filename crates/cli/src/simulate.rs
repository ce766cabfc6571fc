//! Synthetic data as CSV: time, the noisy columns of the record, the exact states, the inputs.

use crate::load::Loaded;
use anyhow::Result;
use phisindy_phys::{Origin, Record};
use phisindy_sim::Trajectory;
use std::io::Write;

/// Writes all records of the case below one another; several are told apart by a first column.
pub(crate) fn write(loaded: &Loaded, out: &mut dyn Write) -> Result<()> {
    let system = &loaded.case.system;
    let measured = |k: usize| loaded.records.iter().any(|r| r.columns[k].is_some());
    let several = loaded.records.len() > 1;
    let mut writer = csv::Writer::from_writer(out);
    let mut header: Vec<String> = Vec::new();
    if several {
        header.push("record".to_owned());
    }
    header.push("t".to_owned());
    header.extend((0..system.states.len()).filter(|&k| measured(k)).map(|k| system.states[k].name.clone()));
    header.extend(system.states.iter().map(|s| format!("{}_true", s.name)));
    header.extend(system.inputs.iter().map(|u| u.name.clone()));
    writer.write_record(&header)?;
    let synthetic: Vec<_> =
        loaded.case.records.iter().filter(|p| matches!(p.origin, Origin::Synthetic(_))).collect();
    for (record, (truth, plan)) in loaded.records.iter().zip(loaded.truths.iter().zip(synthetic)) {
        let (Some(truth), Origin::Synthetic(made)) = (truth, &plan.origin) else { continue };
        for k in 0..record.len() {
            let mut row: Vec<String> = Vec::with_capacity(header.len());
            if several {
                row.push(record.name.clone());
            }
            row.push(number(record.time[k]));
            let columns = (0..system.states.len()).filter(|&s| measured(s));
            row.extend(columns.map(|s| record.columns[s].as_ref().map_or(String::new(), |c| number(c[k]))));
            let sample = (record.time[k] / made.step).round() as usize;
            row.extend(exact(truth, sample).iter().map(|&x| number(x)));
            row.extend(inputs(record, k));
            writer.write_record(&row)?;
        }
    }
    writer.flush()?;
    Ok(())
}

fn exact(truth: &Trajectory, sample: usize) -> &[f64] {
    truth.states.get(sample * truth.n..(sample + 1) * truth.n).unwrap_or(&[])
}

fn inputs(record: &Record, k: usize) -> impl Iterator<Item = String> {
    record.inputs.iter().map(move |signal| number(signal.value(record.time[k])))
}

/// The shortest text that reads back as the same number.
fn number(x: f64) -> String {
    let size = x.abs();
    if size != 0.0 && !(1e-4..1e15).contains(&size) { format!("{x:e}") } else { format!("{x}") }
}
