//! The streams of a record: each is read with its own times, then all are brought to one table.

use phisindy_phys::spec::{CsvSpec, StreamSpec, Text};
use phisindy_phys::unit::Unit;
use phisindy_phys::{Diagnostic, Samples, SourceId, System, Table, Units};
use phisindy_signal::{mean_step, on_straight_lines};

/// What is read at once: the rows of a record, or one of its streams.
pub(super) struct Part {
    /// As a record of its own.
    pub(super) csv: CsvSpec,
    pub(super) units: Units,
    /// Which of the record's columns it has, and whether each of them is an input.
    columns: Vec<(usize, bool)>,
    /// Of a stream, its name.
    stream: Option<Text>,
}

/// The parts of a record: without streams, its rows alone.
pub(super) fn parts(csv: &CsvSpec, units: &Units, system: &System) -> Vec<Part> {
    let input = |k: usize| system.input(&csv.columns[k].0.value).is_some();
    let part = |own: CsvSpec, time: Unit, all: Vec<usize>, stream: Option<&Text>| Part {
        csv: CsvSpec { columns: all.iter().map(|&k| csv.columns[k].clone()).collect(), ..own },
        units: Units { time, columns: all.iter().map(|&k| units.columns[k]).collect() },
        columns: all.into_iter().map(|k| (k, input(k))).collect(),
        stream: stream.cloned(),
    };
    if csv.streams.is_empty() {
        return vec![part(csv.clone(), units.time, (0..csv.columns.len()).collect(), None)];
    }
    let in_rows = |k: &usize| csv.streams.iter().all(|s| s.name.value != csv.columns[*k].0.value);
    // Inputs are known before the window, and between the rows that are averaged.
    let whole = CsvSpec { streams: vec![], window: None, ..csv.clone() };
    let rows: Vec<usize> = (0..csv.columns.len()).filter(in_rows).collect();
    let mut all = vec![];
    if !rows.is_empty() {
        all.push(part(whole.clone(), units.time, rows, None));
    }
    for stream in &csv.streams {
        let Some(k) = csv.columns.iter().position(|(n, _)| n.value == stream.name.value) else { continue };
        let decimate = csv.decimate.clone().filter(|_| !input(k));
        let own = CsvSpec { decimate, ..of_stream(stream, &whole) };
        let time = stream.time.unit.as_ref().and_then(|unit| Unit::parse(&unit.value).ok());
        all.push(part(own, time.unwrap_or(Unit::ONE), vec![k], Some(&stream.name)));
    }
    all
}

/// A stream as a record. Where its cell is empty it has no sample. How to read a file of its own is found out.
fn of_stream(stream: &StreamSpec, whole: &CsvSpec) -> CsvSpec {
    let (time, rate) = (stream.time.clone(), stream.rate.clone());
    let own = CsvSpec { time, rate, omits_missing: true, ..whole.clone() };
    let sheet = |own: &CsvSpec| stream.sheet.clone().or_else(|| own.sheet.clone());
    match &stream.path {
        None => CsvSpec { sheet: sheet(&own), ..own },
        Some(path) => CsvSpec {
            path: path.clone(),
            sheet: stream.sheet.clone(),
            rows: vec![],
            run: None,
            separator: None,
            decimal: None,
            header: None,
            skip: 0,
            ..own
        },
    }
}

/// One table of the parts: at the times of the slowest state or output, the other ones on straight lines between
/// their samples. Inputs keep their own samples beside that.
///
/// # Errors
/// No time lies in all parts.
pub(super) fn joined(
    csv: &CsvSpec,
    parts: &[Part],
    mut tables: Vec<(Table, Vec<Diagnostic>)>,
    source: SourceId,
) -> Result<(Table, Vec<Diagnostic>), Vec<Diagnostic>> {
    if csv.streams.is_empty() {
        return tables.pop().ok_or_else(Vec::new);
    }
    let (tables, warnings): (Vec<Table>, Vec<Vec<Diagnostic>>) = tables.into_iter().unzip();
    let (from, to) = overlap(csv, parts, &tables, source).map_err(|d| vec![d])?;
    let shows = |part: &Part| part.columns.iter().any(|(_, input)| !input);
    let showing = (0..parts.len()).filter(|&p| shows(&parts[p]));
    let step = |p: &usize| mean_step(&tables[*p].time);
    let base = showing.max_by(|a, b| step(a).total_cmp(&step(b))).unwrap_or(0);
    let (first, last) = csv.window.as_ref().map_or((from, to), |(a, b)| (a.value, b.value));
    let (first, last) = (first.max(from), last.min(to));
    let time = &tables[base].time;
    let rows = time.partition_point(|t| *t < first)..time.partition_point(|t| *t <= last);
    let rows = rows.start.min(rows.end)..rows.end;
    let time = time[rows.clone()].to_vec();
    let mut all = Table {
        lines: tables[base].lines[rows.clone()].to_vec(),
        columns: vec![vec![]; csv.columns.len()],
        own: vec![None; csv.columns.len()],
        extent: Some((from, to)),
        ..Table::default()
    };
    for (p, (part, table)) in parts.iter().zip(tables).enumerate() {
        for (&(k, input), values) in part.columns.iter().zip(table.columns) {
            all.columns[k] = match p == base {
                true => values[rows.clone()].to_vec(),
                false => on_straight_lines(&table.time, &values, &time),
            };
            all.own[k] = input.then(|| Samples { time: table.time.clone(), values });
        }
    }
    Ok((Table { time, ..all }, warnings.concat()))
}

/// First and last time that lie in all parts.
fn overlap(
    csv: &CsvSpec,
    parts: &[Part],
    tables: &[Table],
    source: SourceId,
) -> Result<(f64, f64), Diagnostic> {
    let ends = |table: &Table| Some((*table.time.first()?, *table.time.last()?));
    let ends: Vec<(f64, f64)> = tables.iter().map(|table| ends(table).unwrap_or((0.0, 0.0))).collect();
    let latest = (0..ends.len()).max_by(|&a, &b| ends[a].0.total_cmp(&ends[b].0)).unwrap_or(0);
    let earliest = (0..ends.len()).min_by(|&a, &b| ends[a].1.total_cmp(&ends[b].1)).unwrap_or(0);
    let (from, to) = (ends[latest].0, ends[earliest].1);
    if from < to {
        return Ok((from, to));
    }
    let name =
        |p: usize| parts[p].stream.as_ref().map_or("the rows".to_owned(), |name| format!("`{}`", name.value));
    let span = |p: usize| parts[p].stream.as_ref().map_or(csv.path.span, |name| name.span);
    let told = |p: usize| format!("its times run from {} s to {} s", ends[p].0, ends[p].1);
    let message = match from == to {
        true => format!("{} ends when {} begins: one time lies in both", name(earliest), name(latest)),
        false => format!("{} ends before {} begins: no time lies in both", name(earliest), name(latest)),
    };
    Err(Diagnostic::error(message)
        .at(source, span(earliest), told(earliest))
        .also(source, span(latest), told(latest))
        .help("write the unit of each `time`, as in (\"t\", \"ms\")")
        .help("or let the times of both count from one instant; what is left between two clocks a sensor finds: `delay: Find(...)`"))
}
