//! What other programs hand over: columns in memory.

use phisindy::files::{Columns, Purpose, Request, open_text};
use phisindy::{Case, Error, Loaded, Motion, Record, RecordError, record_named};
use std::path::Path;

/// Four specs: no record, a record of arrays, a record of a file, an unknown part.
const CASES: [&str; 4] = [
    r#"(states: { "x": "mm", "v": "mm/s" }, inputs: { "F": "N" }, constants: { "m": (2.0, "kg"), "k": (1.0, "N/m") }, known: { "x": "v", "v": "(F - k*x)/m" })"#,
    r#"(states: { "x": "m", "v": "m/s" }, constants: { "k": (1.0, "1/s^2") }, known: { "x": "v", "v": "-k*x - 0.1*sgn(v)" }, contacts: ["v"],
        data: [Arrays(name: "run", columns: ["x"], start: { "v": 0.0 }, sensors: { "x": (offset: Find(start: 0.0, unit: "m", within: (-1e-3, 1e-3))) })])"#,
    r#"(states: { "x": "m", "v": "m/s" }, constants: { "k": (1.0, "1/s^2") }, known: { "x": "v", "v": "-k*x" },
        data: [Csv(path: "a.csv", time: ("t", "ms"), columns: { "x": ("x", "mm") }, rows: { "n": 1.0 }, decimate: 2)])"#,
    r#"(states: { "x": "m", "v": "m/s" }, constants: { "k": (1.0, "1/s^2") }, known: { "x": "v", "v": "-k*x" }, contacts: ["v"],
        unknown: { "v": (factor: "-sgn(v)", candidates: ["1", "|v|"]) })"#,
];
/// Names of columns and records; after the last one, a name of the input's own.
const NAMES: [&str; 8] = ["t", "x", "v", "F", "n", "run", "", "\"x\"\t\n\0"];
/// Fields of a record.
const FIELDS: [&str; 7] = ["start", "sensors", "derive", "interpolate", "constants", "columns", "role"];
/// Numbers that nobody measures.
const ODD: [f64; 10] = [
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::MAX,
    f64::MIN,
    f64::MIN_POSITIVE,
    5e-324,
    -0.0,
    1e300,
    9_007_199_254_740_993.0,
];
/// A longer run may end at the limit of steps, after seconds that a fuzzer does not have.
const LONGEST_RUN: f64 = 1000.0;
/// Most rows of a column, and most columns and records.
const ROWS: usize = 40;
const MANY: usize = 6;

/// The input, from which all is drawn; zeros after its end.
struct Dice<'a>(&'a [u8]);

impl<'a> Dice<'a> {
    fn byte(&mut self) -> usize {
        self.0.split_off_first().copied().unwrap_or(0).into()
    }

    /// The text up to a zero, or as far as it is text.
    fn text(&mut self) -> &'a str {
        let end = self.0.iter().position(|&b| b == 0).unwrap_or(self.0.len());
        let (own, rest) = self.0.split_at(end);
        self.0 = rest.strip_prefix(b"\0").unwrap_or(rest);
        own.utf8_chunks().next().map_or("", |chunk| chunk.valid())
    }

    fn name(&mut self) -> &'a str {
        let k = self.byte();
        NAMES.get(k % (NAMES.len() + 1)).copied().unwrap_or_else(|| self.text())
    }

    /// A ramp, a swing, one number, an odd number among those of a ramp, or any bits.
    fn values(&mut self) -> Vec<f64> {
        let (rows, kind) = (self.byte() % (ROWS + 1), self.byte());
        let ramp = |k: usize| 0.1 * k as f64;
        match kind % 5 {
            0 => (0..rows).map(ramp).collect(),
            1 => (0..rows).map(|k| ramp(k).cos()).collect(),
            2 => vec![ODD[self.byte() % ODD.len()]; rows],
            3 => {
                let (at, odd) = (self.byte() % (ROWS + 1), ODD[self.byte() % ODD.len()]);
                (0..rows).map(|k| if k == at { odd } else { ramp(k) }).collect()
            }
            _ => (0..rows.min(8))
                .map(|_| f64::from_bits((0..8).fold(0, |bits, _| bits << 8 | self.byte() as u64)))
                .collect(),
        }
    }

    fn columns(&mut self) -> Vec<(&'a str, Vec<f64>)> {
        (0..self.byte() % (MANY + 1)).map(|_| (self.name(), self.values())).collect()
    }
}

/// Columns of any names, lengths and numbers, with fields of a record: what is no record is refused with a reason, and what is one is simulated at
/// as many times as it has, or not, with a reason.
pub fn arrays(input: &[u8]) {
    let mut dice = Dice(input);
    let case = Case::read(CASES[dice.byte() % CASES.len()]).expect("a spec");
    let (mut records, mut rows) = (vec![], vec![]);
    for _ in 0..1 + dice.byte() % 2 {
        let columns = dice.columns();
        rates(&case, &columns);
        tables(&case, &columns);
        match case.record(&columns) {
            Ok(record) => {
                let time = columns
                    .iter()
                    .find(|(name, _)| *name == "t")
                    .map(|(_, t)| t.as_slice())
                    .unwrap_or_default();
                assert!(time.windows(2).all(|t| t[0] < t[1]), "time does not grow: {time:?}");
                assert!(
                    columns.iter().all(|(_, c)| c.len() == time.len() && c.iter().all(|x| x.is_finite())),
                    "{columns:?}"
                );
                rows.push(time.len());
                records.push(dressed(record, &mut dice));
            }
            Err(why) => refused(&why, &columns),
        }
    }
    if let Err(why) = record_named(dice.name(), ["run", "1", ""].into_iter()) {
        assert!(!why.message.is_empty());
    }
    match Loaded::of(&case, &records) {
        Ok(loaded) => {
            assert_eq!(loaded.records.iter().map(|record| record.len()).collect::<Vec<_>>(), rows);
            let span = |t: &[f64]| t.first().zip(t.last()).map_or(0.0, |(a, b)| b - a);
            if loaded.records.iter().all(|record| span(&record.time) < LONGEST_RUN) {
                told(loaded.simulate().map(|motions| {
                    let whole = |m: &Motion| m.columns.iter().all(|(_, column)| column.len() == m.time.len());
                    assert!(motions.iter().all(whole));
                }));
            }
        }
        Err(why) => told(Err(why)),
    }
}

/// The record with a name, a role and fields.
fn dressed<'a>(record: Record, dice: &mut Dice<'a>) -> Record {
    let record = if dice.byte() % 2 == 1 { record.named(dice.name()) } else { record };
    let record = if dice.byte() % 2 == 1 { record.validate() } else { record };
    (0..dice.byte() % 3).fold(record, |record, _| {
        let field = FIELDS.get(dice.byte() % (FIELDS.len() + 1)).copied();
        let field = field.unwrap_or_else(|| dice.text());
        record.with(field, dice.text())
    })
}

/// The rates at the rows: one for each.
fn rates(case: &Case, columns: &[(&str, Vec<f64>)]) {
    let slices: Vec<(&str, &[f64])> =
        columns.iter().map(|(name, values)| (*name, values.as_slice())).collect();
    let rows = slices.first().map_or(0, |(_, values)| values.len());
    told(case.rates(&slices).map(|rates| assert!(rates.iter().all(|(_, rate)| rate.len() == rows))));
}

/// The columns in the place of the file that a case names.
fn tables(case: &Case, columns: &[(&str, Vec<f64>)]) {
    let table = Columns(columns.iter().map(|(name, values)| ((*name).to_owned(), values.clone())).collect());
    let request = Request { tables: vec![table], ..Request::default() };
    told(open_text(case.text(), Path::new("nowhere/a.ron"), &request, Purpose::Simulate).map(|loaded| {
        let numbers = loaded.records.iter().flat_map(|record| record.columns.iter().flatten());
        assert!(numbers.flat_map(|column| column.iter()).all(|x| x.is_finite()));
    }));
}

/// A reason that names what is there.
fn refused(why: &RecordError, columns: &[(&str, Vec<f64>)]) {
    assert!(!why.to_string().is_empty(), "refused without a reason");
    let rows = |name: &str| columns.iter().filter(|(n, _)| *n == name).map(|(_, values)| values.len()).max();
    match why {
        RecordError::NotFinite { column, row } => assert!(Some(*row) < rows(column), "{why}"),
        RecordError::TimeOrder { row } => assert!(Some(*row) < rows("t"), "{why}"),
        RecordError::Length { column, .. }
        | RecordError::Repeated(column)
        | RecordError::UnknownColumn { column, .. } => {
            assert!(rows(column).is_some(), "{why}");
        }
        _ => {}
    }
}

fn told(result: Result<(), Error>) {
    if let Err(why) = result {
        assert!(!why.to_string().is_empty(), "refused without a reason");
    }
}
