//! The streams of a record: each is read with its own times, then all are brought to one table.

use phisindy_phys::spec::{CsvSpec, StreamSpec, Text};
use phisindy_phys::unit::Unit;
use phisindy_phys::{Diagnostic, OwnTimes, Samples, SourceId, System, Table, Units};
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

/// A column of a record with its samples.
struct Channel {
    /// Its place among the columns of the record.
    place: usize,
    input: bool,
    own: Samples,
    /// The lines of the file on which its samples stand.
    lines: Vec<usize>,
}

/// One table of the parts: at the times of all states and outputs, each of which is sampled at its own ones. Inputs keep
/// their own samples beside that.
///
/// # Errors
/// No time lies in all parts.
pub(super) fn joined(
    csv: &CsvSpec,
    parts: &[Part],
    mut tables: Vec<(Table, Vec<Diagnostic>)>,
    source: SourceId,
) -> Result<(Table, Vec<Diagnostic>), Vec<Diagnostic>> {
    if let ([part], true) = (parts, csv.streams.is_empty()) {
        let (table, warnings) = tables.pop().ok_or_else(Vec::new)?;
        return Ok((with_own_samples(table, part), warnings));
    }
    let (tables, warnings): (Vec<Table>, Vec<Vec<Diagnostic>>) = tables.into_iter().unzip();
    let (from, to) = overlap(csv, parts, &tables, source).map_err(|d| vec![d])?;
    let (first, last) = csv.window.as_ref().map_or((from, to), |(a, b)| (a.value, b.value));
    let channels = parts.iter().zip(tables).flat_map(|(part, table)| {
        let Table { time, columns, lines, .. } = table;
        part.columns.iter().zip(columns).map(move |(&(place, input), values)| Channel {
            place,
            input,
            own: Samples { time: time.clone(), values },
            lines: lines.clone(),
        })
    });
    let all = at_all_times(channels.collect(), (first.max(from), last.min(to)));
    Ok((Table { extent: Some((from, to)), ..all }, warnings.concat()))
}

/// The table of a file whose channels have times of their own, with the states and outputs at these.
fn with_own_samples(table: Table, part: &Part) -> Table {
    let has_own = |&(k, input): &(usize, bool)| !input && table.own.get(k).is_some_and(Option::is_some);
    let (Some(&first), Some(&last)) = (table.time.first(), table.time.last()) else { return table };
    // The mean of rows has no samples, and rows that are chosen are those of one clock.
    let chosen = part.csv.decimate.is_some() || part.csv.run.is_some() || !part.csv.rows.is_empty();
    if chosen || !part.columns.iter().any(has_own) {
        return table;
    }
    let channel = |(&(place, input), values): (&(usize, bool), &Vec<f64>)| {
        let before = if input { table.before.1.get(place) } else { None };
        let of_rows = || Samples {
            time: before.iter().flat_map(|_| &table.before.0).chain(&table.time).copied().collect(),
            values: before.into_iter().flatten().chain(values).copied().collect(),
        };
        let own = table.own[place].clone().unwrap_or_else(of_rows);
        let line =
            |t: &f64| table.lines[table.time.partition_point(|row| row < t).min(table.lines.len() - 1)];
        let lines = own.time.iter().map(line).collect();
        Channel { place, input, own, lines }
    };
    let all = at_all_times(part.columns.iter().zip(&table.columns).map(channel).collect(), (first, last));
    Table {
        time: all.time,
        columns: all.columns,
        lines: all.lines,
        own: all.own,
        own_times: all.own_times,
        ..table
    }
}

/// The channels, at all times of the states and outputs between two.
fn at_all_times(channels: Vec<Channel>, (first, last): (f64, f64)) -> Table {
    // Inputs alone are the times of a prediction.
    let nothing = channels.iter().all(|channel| channel.input);
    let rows = united(channels.iter().filter(|channel| nothing || !channel.input), first, last);
    let (time, lines): (Vec<f64>, Vec<usize>) = rows.into_iter().unzip();
    let (mut columns, mut own, mut own_times) =
        (vec![vec![]; channels.len()], vec![None; channels.len()], vec![None; channels.len()]);
    for Channel { place, input, own: samples, .. } in channels {
        columns[place] = on_straight_lines(&samples.time, &samples.values, &time);
        if input {
            own[place] = Some(samples);
        } else {
            let sampled = sampled_at(&samples.time, &time);
            own_times[place] = sampled.contains(&false).then(|| sampled.into());
        }
    }
    Table { time, lines, columns, own, own_times: OwnTimes::new(own_times), ..Table::default() }
}

/// The times of some channels, each once, and the lines on which they stand. Times that differ by less than the rounding of
/// stamps are one.
fn united<'a>(channels: impl Iterator<Item = &'a Channel>, first: f64, last: f64) -> Vec<(f64, usize)> {
    let mut all: Vec<(f64, usize)> = vec![];
    let mut step = f64::INFINITY;
    for Channel { own, lines, .. } in channels {
        let rows = own.time.iter().copied().zip(lines.iter().copied());
        all.extend(rows.filter(|(t, _)| (first..=last).contains(t)));
        step = step.min(mean_step(&own.time));
    }
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    all.dedup_by(|later, earlier| later.0 - earlier.0 <= ONE_TIME * step);
    all
}

/// Times of two streams that are nearer than this part of the shortest step are one: stamps are rounded.
const ONE_TIME: f64 = 1e-6;

/// Which of these times, which increase, are those of samples.
fn sampled_at(samples: &[f64], times: &[f64]) -> Vec<bool> {
    let step = mean_step(samples);
    let near = |t: &f64| {
        let k = samples.partition_point(|own| own < t);
        let gap = |k: usize| samples.get(k).map_or(f64::INFINITY, |own| (own - t).abs());
        gap(k).min(k.checked_sub(1).map_or(f64::INFINITY, gap)) <= ONE_TIME * step
    };
    times.iter().map(near).collect()
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
