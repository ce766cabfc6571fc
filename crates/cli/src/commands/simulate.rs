//! `phisindy simulate`: simulated runs as CSV. Synthetic data (time, noisy columns, exact states, inputs), or
//! the free run of a model without unknown part along a measured record.

use super::spec_file::{failed, loaded};
use crate::args::Options;
use crate::draw;
use crate::terminal::{INPUT, NUMERICS, STDOUT};
use anyhow::{Context, Result, anyhow};
use phisindy::files::Purpose;
use phisindy::{Loaded, Motion};
use phisindy_phys::Sources;
use std::io::{self, Write};
use std::path::Path;

/// Simulates the records of a spec, prints them as CSV, and returns the exit code.
pub(crate) fn simulate(spec: &Path, record: Option<&str>, options: &Options) -> Result<u8> {
    let mut loaded = match loaded(spec, options, Purpose::Simulate, None) {
        Ok(loaded) => loaded,
        Err(code) => return Ok(code),
    };
    if loaded.records.is_empty() {
        return Err(anyhow!(
            "{}: the model has an unknown part and no `Synthetic` record: identify it first (`phisindy run {} --out DIR`), then simulate \
             DIR/identified.ron",
            loaded.spec,
            loaded.spec
        ));
    }
    if let Some(record) = record {
        loaded = match loaded.only(record) {
            Ok(loaded) => loaded,
            Err(mistake) => {
                draw::show([&mistake], &Sources::default());
                return Ok(INPUT);
            }
        };
    }
    let runs = match loaded.simulate() {
        Ok(runs) => runs,
        Err(why) => {
            failed(&loaded.spec, &why.to_string(), why.diverged());
            return Ok(NUMERICS);
        }
    };
    let mut out = io::BufWriter::new(io::stdout().lock());
    write(&loaded, &runs, &mut out).and_then(|()| Ok(out.flush()?)).context(STDOUT)?;
    Ok(0)
}

/// Writes all records of the case below one another; several are told apart by a first column.
fn write(loaded: &Loaded, runs: &[Motion], out: &mut dyn Write) -> Result<()> {
    let system = &loaded.case.system;
    let columns = 0..system.columns();
    let measured: Vec<usize> =
        columns.clone().filter(|&k| loaded.records.iter().any(|r| r.columns[k].is_some())).collect();
    // A motion leaves columns out: see `System::motion_column`.
    let names: Vec<String> = columns.filter_map(|k| system.motion_column(k)).collect();
    let several = loaded.records.len() > 1;
    let kinds: Vec<bool> =
        [false, true].into_iter().filter(|&kind| runs.iter().any(|r| r.predicted == kind)).collect();
    let mut writer = csv::Writer::from_writer(out);
    let mut header: Vec<String> = Vec::new();
    if several {
        header.push("record".to_owned());
    }
    header.push("t".to_owned());
    header.extend(measured.iter().map(|&k| system.measured(k).0.to_owned()));
    for &predicted in &kinds {
        let ending = if predicted { "model" } else { "true" };
        header.extend(names.iter().map(|name| format!("{name}_{ending}")));
    }
    header.extend(system.inputs.iter().map(|u| u.name.clone()));
    writer.write_record(&header)?;
    for (record, run) in loaded.records.iter().zip(runs) {
        for i in 0..record.len() {
            let mut row: Vec<String> = Vec::with_capacity(header.len());
            if several {
                row.push(record.name.clone());
            }
            row.push(number(record.time[i]));
            row.extend(
                measured.iter().map(|&k| record.columns[k].as_ref().map_or(String::new(), |c| number(c[i]))),
            );
            for &predicted in &kinds {
                let cell = |k: usize| {
                    if run.predicted == predicted { number(run.columns[k].1[i]) } else { String::new() }
                };
                row.extend((0..names.len()).map(cell));
            }
            row.extend(record.inputs.iter().map(|signal| number(signal.value(record.time[i]))));
            writer.write_record(&row)?;
        }
    }
    writer.flush()?;
    Ok(())
}

/// The shortest text that reads back as the same number.
fn number(x: f64) -> String {
    let size = x.abs();
    if size != 0.0 && !(1e-4..1e15).contains(&size) { format!("{x:e}") } else { format!("{x}") }
}
