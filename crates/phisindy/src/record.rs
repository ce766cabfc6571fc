//! A record: columns by name, and what the model should know about how they were measured.

use phisindy_phys::spec::Role;
use std::fmt;

/// What is measured in one run, or how it is simulated.
#[derive(Clone, Debug)]
pub struct Record {
    pub(crate) name: Option<String>,
    /// Fields of the record in the language of specs, in the order in which they were set.
    pub(crate) fields: Vec<(String, String)>,
    pub(crate) data: Data,
}

/// Where the numbers of a record come from.
#[derive(Clone, Debug)]
pub(crate) enum Data {
    /// Measured: seconds, and columns by name in the units of the spec.
    Columns { time: Vec<f64>, columns: Vec<(String, Vec<f64>)> },
    /// Simulated from an entry of the spec's `data`.
    Synthetic { entry: String, seed: Option<u64> },
}

impl Record {
    pub(crate) fn measured<C: AsRef<[f64]>>(
        given: &[(&str, C)],
        names: &[&str],
    ) -> Result<Record, RecordError> {
        let mut time = None;
        let mut columns: Vec<(String, Vec<f64>)> = Vec::new();
        for (name, values) in given {
            let values = values.as_ref().to_vec();
            if let Some(row) = values.iter().position(|x| !x.is_finite()) {
                return Err(RecordError::NotFinite { column: (*name).to_owned(), row });
            }
            let twice = if *name == "t" {
                time.replace(values).is_some()
            } else if names.contains(name) {
                let twice = columns.iter().any(|(n, _)| n == name);
                columns.push(((*name).to_owned(), values));
                twice
            } else {
                return Err(RecordError::unknown(name, names));
            };
            if twice {
                return Err(RecordError::Repeated((*name).to_owned()));
            }
        }
        let time = time.ok_or(RecordError::NoTime)?;
        if let Some((column, values)) = columns.iter().find(|(_, values)| values.len() != time.len()) {
            return Err(RecordError::Length {
                column: column.clone(),
                rows: values.len(),
                times: time.len(),
            });
        }
        if let Some(before) = time.windows(2).position(|pair| pair[1] <= pair[0]) {
            return Err(RecordError::TimeOrder { row: before + 1 });
        }
        Ok(Record { name: None, fields: vec![], data: Data::Columns { time, columns } })
    }

    pub(crate) fn synthetic(name: String, entry: &str, seed: Option<u64>) -> Record {
        Record { name: Some(name), fields: vec![], data: Data::Synthetic { entry: entry.to_owned(), seed } }
    }

    /// The record under a name of its own, which results use; without, records are called `record 1`, `record
    /// 2`, ... An entry `Arrays` of this name
    /// in the spec says what the record is like.
    pub fn named(mut self, name: &str) -> Record {
        self.name = Some(name.to_owned());
        self
    }

    /// The record kept for validation: only its start state is fitted.
    pub fn validate(self) -> Record {
        self.role(Role::Validate)
    }

    /// The record in this role.
    pub fn role(self, role: Role) -> Record {
        self.with(
            "role",
            match role {
                Role::Fit => "Fit",
                Role::Validate => "Validate",
            },
        )
    }

    /// The record with a field in the language of specs: `start`, `sensors`, `derive`, `interpolate`,
    /// `constants` (`docs/reference.md`, `Arrays`).
    /// A mistake in it is an error of the function that uses the record.
    ///
    /// ```
    /// # let case = phisindy::Case::read(r#"(states: { "x": "m", "v": "m/s" }, known: { "x": "v", "v": "-x" })"#)?;
    /// # let (t, x) = (vec![0.0, 0.1], vec![1.0, 0.9]);
    /// let record = case.record(&[("t", &t), ("x", &x)])?.with("start", r#"{ "v": 0.0 }"#);
    /// # Ok::<(), phisindy::Error>(())
    /// ```
    pub fn with(mut self, field: &str, value: &str) -> Record {
        self.fields.retain(|(other, _)| other != field);
        self.fields.push((field.to_owned(), value.to_owned()));
        self
    }

    /// What it is called among the records of a case.
    pub(crate) fn name_at(&self, index: usize) -> String {
        self.name.clone().unwrap_or_else(|| format!("record {}", index + 1))
    }
}

/// Why arrays make no record. Rows are counted from 0.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum RecordError {
    /// There is no column `t`.
    NoTime,
    /// A column is neither the time nor a state nor an input.
    UnknownColumn {
        /// Its name.
        column: String,
        /// The name that was perhaps meant.
        nearest: Option<String>,
        /// All names of the case.
        names: Vec<String>,
    },
    /// A state or an input has no column.
    Missing(String),
    /// Two columns have this name.
    Repeated(String),
    /// A column is longer or shorter than the time.
    Length {
        /// Its name.
        column: String,
        /// Its number of rows.
        rows: usize,
        /// Those of the time.
        times: usize,
    },
    /// A number is NaN or infinite.
    NotFinite {
        /// Name of its column.
        column: String,
        /// Its row.
        row: usize,
    },
    /// The time of a row is not later than that of the row before.
    TimeOrder {
        /// The later row.
        row: usize,
    },
    /// No records were given.
    NoRecords,
    /// No state is measured in a record that is to be compared with a model.
    NoState {
        /// The record, counted from 0.
        record: usize,
    },
}

impl RecordError {
    pub(crate) fn unknown(column: &str, names: &[&str]) -> RecordError {
        let nearest = phisindy_expr::nearest(column, names.iter().copied()).map(str::to_owned);
        let names = names.iter().map(|&n| n.to_owned()).collect();
        RecordError::UnknownColumn { column: column.to_owned(), nearest, names }
    }
}

impl fmt::Display for RecordError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            RecordError::NoTime => f.write_str("there is no column `t`, the time in seconds"),
            RecordError::UnknownColumn { column, nearest, names } => {
                write!(f, "`{column}` is neither `t` nor a state nor an input; ")?;
                match nearest {
                    Some(near) => write!(f, "did you mean `{near}`?"),
                    None => write!(f, "there is: {}", names.join(", ")),
                }
            }
            RecordError::Missing(column) => write!(f, "there is no column `{column}`"),
            RecordError::Repeated(column) => write!(f, "the column `{column}` is given twice"),
            RecordError::Length { column, rows, times } => {
                write!(f, "the column `{column}` has {rows} rows, the time `t` has {times}")
            }
            RecordError::NotFinite { column, row } => {
                write!(
                    f,
                    "row {row} of the column `{column}` is not a finite number: leave the row out, a gap in time does no harm"
                )
            }
            RecordError::TimeOrder { row } => {
                write!(f, "the time of row {row} is not later than that of the row before")
            }
            RecordError::NoRecords => f.write_str("there are no records"),
            RecordError::NoState { record } => {
                write!(
                    f,
                    "no column of record {record} measures a state, so there is nothing to compare with"
                )
            }
        }
    }
}

impl std::error::Error for RecordError {}
