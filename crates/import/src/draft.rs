//! What the spec for a file says: the records with their rows and windows, and the model with its numbers.

use crate::headings::{Quantity, factor};
use crate::records::{RecordDraft, Records};
use crate::remarks::Remark;
use crate::roles::{Evidence, Input, NoMotion, Roles};
use crate::start_values::{Estimate, Motion};
use crate::statistics::{Statistics, Stops, stops};
use crate::table::Table;
use crate::time_column::{NoTime, TimeColumn};
use crate::usage::Usage;
use phisindy_expr::Span;
use phisindy_phys::{Diagnostic, SourceId};
use phisindy_signal::strongest_line;
use std::ops::Range;

/// More samples than this in a record make a fit slow and hardly better.
const PLENTY: usize = 25_000;
/// A swing of more than this is no small angle, in radian.
const LARGE_ANGLE: f64 = 0.5;

/// Everything that the spec says.
#[derive(Debug)]
pub struct Draft {
    /// The file.
    pub table: Table,
    /// Its time.
    pub time: TimeColumn,
    /// Of each column.
    pub statistics: Vec<Statistics>,
    /// What the columns are.
    pub roles: Roles,
    /// What is said of each column.
    pub usages: Vec<Usage>,
    /// The records.
    pub records: Vec<RecordDraft>,
    /// Mean of so many rows.
    pub decimate: usize,
    /// The first record's motion, in SI.
    pub motion: Motion,
    /// Numbers to start from.
    pub estimate: Estimate,
    /// Where the motion stands still, in the first record's stretch.
    pub stops: Stops,
    /// Smallest and greatest place in the records, in SI.
    pub extent: (f64, f64),
    /// What should be known.
    pub remarks: Vec<Remark>,
}

impl Draft {
    /// From the columns of a file.
    ///
    /// # Errors
    /// No column is time or motion, or text stands in one that a model may need.
    pub fn of(mut table: Table) -> Result<Draft, NoDraft> {
        let time = TimeColumn::find(&mut table).map_err(NoDraft::Time)?.refined(&mut table);
        let runs = time.runs(table.rows());
        let longest = runs.iter().max_by_key(|r| r.len()).cloned().unwrap_or(0..table.rows());
        let times = &table.columns[time.column].values;
        let statistics: Vec<Statistics> =
            table.columns.iter().map(|c| Statistics::of(times, &c.values, longest.clone())).collect();
        if let Some(mistake) = blocking(&table, &statistics) {
            return Err(NoDraft::Text(Box::new(mistake)));
        }
        let evidence = Evidence { table: &table, time: &time, statistics: &statistics, run: &longest };
        let roles = Roles::guess(&evidence).map_err(NoDraft::Motion)?;
        let usages = (0..table.columns.len()).map(|k| Usage::of(k, &evidence, &roles)).collect();
        let Records { records, first, longest, remarks } = Records::of(&table, &time, &roles, &runs);
        let mut draft = Draft {
            time,
            statistics,
            roles,
            usages,
            records,
            decimate: 1,
            motion: Motion::default(),
            estimate: Estimate { spring: None, damper: 0.0, force: None, rest: 0.0 },
            stops: Stops::default(),
            extent: (0.0, 0.0),
            remarks: vec![],
            table,
        };
        draft.remarks = draft.shared_headings().chain(draft.guessed_unit()).chain(remarks).collect();
        if let Some((good, moving)) = first {
            draft.study(good, moving);
            draft.decimate = draft.thinning(longest);
        }
        Ok(draft)
    }

    /// The values of a column.
    pub(crate) fn values(&self, column: usize) -> &[f64] {
        &self.table.columns[column].values
    }

    /// Time as the file has it.
    pub(crate) fn times(&self) -> &[f64] {
        self.values(self.time.column)
    }

    /// The column of the displacement, or else of the velocity.
    pub(crate) fn moving(&self) -> usize {
        self.roles.moving().unwrap_or(self.time.column)
    }

    /// The heading of a column.
    pub(crate) fn raw(&self, column: usize) -> &str {
        &self.table.columns[column].heading.raw
    }

    /// What makes SI of a column.
    pub(crate) fn factor(&self, column: usize) -> f64 {
        factor(self.table.columns[column].heading.unit.as_deref())
    }

    /// Columns that are needed and share their heading with another one.
    fn shared_headings(&self) -> impl Iterator<Item = Remark> {
        let shared = |name: &str| (0..self.table.columns.len()).filter(|&k| self.raw(k) == name).count() > 1;
        let needed = self.roles.used().chain([self.time.column]).map(|c| self.raw(c));
        needed.filter(move |name| shared(name)).map(|name| Remark::SharedHeading(name.to_owned()))
    }

    /// Whether the unit of the time is a guess.
    fn guessed_unit(&self) -> Option<Remark> {
        let heading = &self.table.columns[self.time.column].heading;
        self.time.unit_guessed.then(|| Remark::TimeUnit {
            heading: heading.raw.clone(),
            step: self.time.step,
            unit: heading.unit.clone().unwrap_or_default(),
        })
    }

    /// The numbers to start from, out of what will be fitted: the rows `moving` out of the rows `good` of the first record.
    fn study(&mut self, good: Range<usize>, moving: Range<usize>) {
        let column = |c: usize| {
            let unit = self.factor(c);
            self.values(c)[moving.clone()].iter().map(|x| x * unit).collect::<Vec<f64>>()
        };
        let mut time = column(self.time.column);
        let place = match (self.roles.place, self.roles.speed) {
            (Some(c), _) => column(c),
            (None, Some(c)) => integral(&time, &column(c)),
            (None, None) => vec![],
        };
        let (base, force) = match self.roles.input {
            Input::None => (None, None),
            Input::Base(c) => (Some(column(c)), None),
            Input::Force(c) | Input::Drive(c) => (None, Some(column(c))),
        };
        let whole = self.place_extent();
        let swing = self.roles.angle && self.roles.place.is_some() && 0.5 * (whole.1 - whole.0) > LARGE_ANGLE;
        let grow = time.windows(2).position(|w| w[1] <= w[0]).map_or(time.len(), |k| k + 1);
        time.truncate(grow);
        let line = strongest_line(&time, &place[..grow.min(place.len())]);
        // Periods per unit of the file's time.
        let frequency = line.map(|l| l.frequency * self.factor(self.time.column));
        self.stops = stops(&self.times()[good.clone()], &self.values(self.moving())[good], frequency);
        self.extent =
            place.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)));
        self.motion = Motion { time, place, base, force, swing, frequency: line.map(|l| l.frequency) };
        self.estimate = self.motion.estimate();
    }

    fn place_extent(&self) -> (f64, f64) {
        let Some(c) = self.roles.place else { return (0.0, 0.0) };
        (self.statistics[c].min * self.factor(c), self.statistics[c].max * self.factor(c))
    }

    /// How many rows to take the mean of, so that a record is quick to fit and keeps forty samples in a period.
    fn thinning(&self, samples: usize) -> usize {
        let wanted = samples.div_ceil(PLENTY).max(1);
        let step = self.time.step * self.factor(self.time.column);
        let allowed = self.motion.frequency.map_or(1.0, |f| (1.0 / (40.0 * f * step)).floor()) as usize;
        wanted.min(allowed.max(1))
    }

    /// Whether the motion has many frequencies, none of which is most of it, and is driven.
    pub(crate) fn is_rich(&self) -> bool {
        let driven = matches!(self.roles.input, Input::Force(_) | Input::Drive(_));
        driven && self.statistics[self.moving()].line.is_some_and(|l| l.share < 0.3)
    }

    /// Whether the model has the unit of the place from the heading.
    pub(crate) fn has_unit(&self) -> bool {
        !matches!(self.table.columns[self.moving()].heading.quantity, Quantity::Unsaid)
    }
}

/// Why a readable file makes no spec.
#[derive(Debug)]
pub enum NoDraft {
    /// No column is time.
    Time(NoTime),
    /// No column is motion.
    Motion(NoMotion),
    /// Text stands in a column that a model may need.
    Text(Box<Diagnostic>),
}

impl NoDraft {
    /// As a mistake in the file `name`, which the user named at a place.
    pub fn diagnostic(self, name: &str, (source, at): (SourceId, Span)) -> Box<Diagnostic> {
        let (message, help) = match self {
            NoDraft::Time(why) => (
                why.to_string(),
                "add a column `time_s`, in seconds from the start, that grows from row to row",
            ),
            NoDraft::Motion(why) => (
                why.to_string(),
                "a record needs a column of displacement or velocity; say which one in the heading, as in `x_mm` or `v [m/s]`",
            ),
            NoDraft::Text(mistake) => return mistake,
        };
        Box::new(Diagnostic::error(format!("`{name}`: {message}")).at(source, at, "this file").help(help))
    }
}

/// By the trapezoidal rule.
fn integral(time: &[f64], rate: &[f64]) -> Vec<f64> {
    let mut sum = 0.0;
    let steps = time.windows(2).zip(rate.windows(2)).map(|(t, v)| {
        sum += 0.5 * (v[0] + v[1]) * (t[1] - t[0]);
        sum
    });
    [0.0].into_iter().chain(steps).take(rate.len()).collect()
}

/// Text in a column of nearly all numbers that a model may need: a run would stop there.
fn blocking(table: &Table, statistics: &[Statistics]) -> Option<Diagnostic> {
    let good = |c: usize| table.rows() - statistics[c].missing;
    let needed = |c: usize| {
        let quantity = table.columns[c].heading.quantity;
        !matches!(quantity, Quantity::Electric | Quantity::Acceleration | Quantity::Other)
    };
    let mixed = |c: usize| table.columns[c].text_cells > 0 && good(c) > 9 * table.columns[c].text_cells;
    let column = (0..table.columns.len()).find(|&c| needed(c) && mixed(c))?;
    let mistake = table.columns[column].first_text.clone()?;
    let more = table.columns[column].text_cells - 1;
    Some(if more > 0 {
        mistake.help(format!("{more} more cells of this column hold words"))
    } else {
        mistake
    })
}
