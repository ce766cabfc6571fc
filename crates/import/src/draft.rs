//! The content of a spec for a data file: records, model and start values.

use crate::headings::{COUNT, Heading, Quantity, factor};
use crate::merged::thinned;
use crate::no_draft::{NoDraft, blocking, channel_of_each_row};
use crate::question::{Answers, Counted, Question};
use crate::records::{RecordDraft, Records};
use crate::remarks::Remark;
use crate::rig::Rig;
use crate::roles::{Doubt, ENCODERS, Evidence, Input, LENGTHS, Roles};
use crate::start_values::{Drive, Estimate, Motion, loses};
use crate::statistics::{Statistics, Stops, stops};
use crate::table::{Column, Table};
use crate::time_column::{NoTime, TimeColumn, is_whole, names_time};
use crate::usage::Usage;
use phisindy_phys::{Wrap, wraps};
use phisindy_signal::{integral, moves_by_jumps, strongest_line, twice_integrated};
use std::ops::Range;

/// Samples of a record beyond which a fit takes longer and hardly improves.
pub(crate) const PLENTY: usize = 25_000;
/// Amplitude in radian beyond which an angle is not small.
const LARGE_ANGLE: f64 = 0.5;
/// Amplitude in radian from which an angle is that of a rotor, which no gravity pulls back.
const ROUND: f64 = 2.0 * std::f64::consts::PI;

/// Least share of a line of a spectrum that is shown as the frequency of a column.
const LINE: f64 = 0.1;

/// A draft of a spec.
#[derive(Debug)]
pub struct Draft {
    /// The data of the file.
    pub table: Table,
    /// The time column.
    pub time: TimeColumn,
    /// Statistics of each column.
    pub statistics: Vec<Statistics>,
    /// Roles of the columns.
    pub roles: Roles,
    /// Use of each column.
    pub usages: Vec<Usage>,
    /// The records.
    pub records: Vec<RecordDraft>,
    /// Number of rows that `decimate` averages, 1 for none.
    pub decimate: usize,
    /// Motion of the first record, in SI.
    pub motion: Motion,
    /// Start values.
    pub estimate: Estimate,
    /// Whether a measured force drives the motion.
    pub drive: Drive,
    /// Where the motion of the first record is at rest.
    pub stops: Stops,
    /// Smallest and greatest displacement of the first record, in SI.
    pub extent: (f64, f64),
    /// Remarks for the user.
    pub remarks: Vec<Remark>,
    /// What the user has to say before a search.
    pub questions: Vec<Question>,
    /// What is told of a merged log, whose channels have times of their own; its table holds the rows of one.
    pub merged: Option<String>,
}

impl Draft {
    /// Drafts a spec for a table.
    ///
    /// # Errors
    /// No column can be time or motion, or a column that a model may need holds text.
    pub fn of(table: Table) -> Result<Draft, NoDraft> {
        Draft::with_answers(table, &Answers::default(), &|_| {})
    }

    /// The same with what the user says beside the file, and tells how much of the work is done, from 0 to 1.
    ///
    /// # Errors
    /// As [`Draft::of`].
    pub fn with_answers(mut table: Table, answers: &Answers, tell: &dyn Fn(f64)) -> Result<Draft, NoDraft> {
        name_columns(&mut table, &answers.columns).map_err(NoDraft::Columns)?;
        counts(&mut table, answers);
        for column in &mut table.columns {
            if let Some((_, unit)) = answers.units.iter().find(|(heading, _)| *heading == column.heading.raw)
            {
                column.heading = column.heading.clone().with_unit(unit);
            }
        }
        let time = match TimeColumn::find(&mut table, answers.rate) {
            Ok(time) => time,
            Err(why) => return Draft::without_times(table, answers, why),
        };
        let time = time.with_unit(&mut table, answers.time_unit.as_deref());
        let time = time.usable(&table).map_err(NoDraft::Time)?;
        let merged = if time.reversals.is_empty() { thinned(&mut table, time.column) } else { None };
        let time = if merged.is_some() { time.thinned(&table) } else { time };
        let runs = time.runs(table.rows());
        let longest = runs.iter().max_by_key(|r| r.len()).cloned().unwrap_or(0..table.rows());
        let times = &table.columns[time.column].values;
        // The statistics of all columns are about half of the work.
        let steps = (2 * table.columns.len()).max(1) as f64;
        let of = |(k, c): (usize, &Column)| {
            tell(k as f64 / steps);
            Statistics::of(times, &c.values, longest.clone())
        };
        let statistics: Vec<Statistics> = table.columns.iter().enumerate().map(of).collect();
        tell(0.5);
        if let Some(mistake) = blocking(&table, &statistics) {
            return Err(NoDraft::Text(Box::new(mistake)));
        }
        if let Some((heading, names)) = channel_of_each_row(&table, &time) {
            return Err(NoDraft::ChannelOfEachRow { heading, names });
        }
        let longest_run = longest.clone();
        let guessed = |table: &Table| {
            let evidence = Evidence { table, time: &time, statistics: &statistics, run: &longest };
            Roles::guess(&evidence, answers.rig).map_err(NoDraft::Motion)
        };
        let mut roles = guessed(&table)?;
        let mut questions = vec![];
        questions.extend(time.question(&table));
        // What moves is counted: what the user says of counts is said of it.
        let base = Some(roles.input).filter(|input| matches!(input, Input::Base(_))).and_then(Input::column);
        let moving: Vec<usize> = roles.moving().into_iter().chain(base).collect();
        let counted = |table: &Table, c: usize| is_counted(&table.columns[c].heading);
        let said = moving.first().is_none_or(|&c| counted(&table, c));
        for &c in &moving {
            let column = &table.columns[c];
            let whole = column.heading.unit.is_none() && statistics[c].values.is_none() && is_whole(column);
            if counted(&table, c) || (whole && Some(c) != roles.velocity && Some(c) == roles.moving()) {
                let unit = answers.unit_of(&column.heading).map(str::to_owned);
                count(&mut table.columns[c], unit.as_deref());
            }
        }
        roles = guessed(&table)?;
        if let Some(c) = roles.moving().filter(|&c| counted(&table, c)) {
            let accelerates = roles.displacement.or(roles.velocity).is_none();
            let of = if accelerates { Counted::Acceleration } else { Counted::Motion { said } };
            questions.push(Question::Counts { heading: table.columns[c].heading.raw.clone(), of });
        }
        let evidence = Evidence { table: &table, time: &time, statistics: &statistics, run: &longest };
        let untold = roles.untold(&evidence);
        if !untold.is_empty() {
            let headings = untold.iter().map(|&k| evidence.name(k).to_owned()).collect();
            let all = table.columns.len() - usize::from(time.counted);
            questions.push(Question::Columns { headings, all });
        }
        // Who names the columns, or the rig, has seen the numbers.
        let open = questions.is_empty() && answers.columns.is_empty() && answers.rig.is_none();
        questions.extend(if open { open_unit(&evidence, &roles) } else { None });
        let Records { records, first, longest, remarks } = Records::of(&evidence, &roles, &runs);
        let mut draft = Draft {
            time,
            statistics,
            roles,
            usages: vec![],
            records,
            decimate: 1,
            motion: Motion::default(),
            estimate: Estimate { stiffness: None, damping: 0.0, input_gain: None, rest: 0.0 },
            drive: Drive::Body,
            stops: Stops::default(),
            extent: (0.0, 0.0),
            remarks: vec![],
            questions,
            merged,
            table,
        };
        draft.remarks = draft
            .shared_headings()
            .chain(draft.of_the_file())
            .chain(draft.guessed_unit())
            .chain(draft.motion_unit())
            .chain(draft.coarse_time())
            .chain(draft.stated_rate())
            .chain(draft.not_read(answers.rig))
            .chain(draft.wrapped(&longest_run))
            .chain(remarks)
            .collect();
        if let Some((good, moving)) = first {
            draft.estimate_start(good, moving, answers.rig);
            draft.decimate = draft.decimation(longest);
        }
        let alone = matches!(draft.roles.input, Input::None) && draft.roles.selector.is_none();
        if answers.rig.is_none() && draft.questions.is_empty() {
            let motion = draft.raw(draft.moving()).to_owned();
            draft.questions.extend(match (&draft.roles.input_doubt, draft.roles.input) {
                (Some(Doubt::Base(base)), _) => Some(Question::Base { body: motion, base: base.clone() }),
                (_, Input::Force(c)) if draft.roles.displacement.is_some() && draft.drive == Drive::Open => {
                    Some(Question::Force { motion, force: draft.raw(c).to_owned() })
                }
                // Who names the columns has named no drive.
                _ if alone && answers.columns.is_empty() && !draft.motion.dies_out() => {
                    let others = &draft.roles.accelerations;
                    let other = others.iter().find(|k| Some(**k) == draft.roles.acceleration);
                    let beside = other.and_then(|own| others.iter().find(|k| *k != own));
                    let beside = beside.map(|&k| draft.raw(k).to_owned());
                    Some(Question::Drive { heading: motion, beside })
                }
                _ => None,
            });
        }
        // A tester is known by its numbers alone.
        draft.usages = draft.usages(&longest_run);
        Ok(draft)
    }

    /// The draft of a file without times: that of slow cycles of a tester, whose force hangs on the order of the rows
    /// alone.
    fn without_times(table: Table, answers: &Answers, why: NoTime) -> Result<Draft, NoDraft> {
        let of_tester = matches!(answers.rig, None | Some(Rig::Tester));
        // Rows that are counted were sampled in time.
        let none = matches!(&why, NoTime::NoRate { counter: None, stated } if stated.is_empty());
        if !none || !of_tester || answers.rate.is_some() {
            return Err(NoDraft::Time(why));
        }
        let counted = Answers { rate: Some(1.0), columns: vec![], rig: Some(Rig::Tester), ..answers.clone() };
        let is_one = |draft: &Draft| {
            let (Some(way), Input::Reaction(force)) = (draft.roles.displacement, draft.roles.input) else {
                return false;
            };
            let measures = |c: usize| draft.table.columns[c].heading.quantity;
            let known = [(Quantity::Length, Quantity::Force), (Quantity::Angle, Quantity::Torque)];
            known.contains(&(measures(way), measures(force)))
                && draft.motion.drive() != Drive::Body
                && loses(draft.values(way), draft.values(force))
        };
        let mut draft = match Draft::with_answers(table, &counted, &|_| {}) {
            Ok(draft) if is_one(&draft) => draft,
            _ => return Err(NoDraft::Time(why)),
        };
        if let Drive::Tester { damping, .. } = &mut draft.drive {
            *damping = None;
        }
        draft.questions.push(Question::Rate);
        Ok(draft)
    }

    /// The use of each column; `run` is the longest range of rows in which time does not go back.
    fn usages(&self, run: &Range<usize>) -> Vec<Usage> {
        let evidence = Evidence { table: &self.table, time: &self.time, statistics: &self.statistics, run };
        (0..self.table.columns.len()).map(|k| Usage::of(k, &evidence, &self.roles)).collect()
    }

    /// The values of a column.
    pub(crate) fn values(&self, column: usize) -> &[f64] {
        &self.table.columns[column].values
    }

    /// Times in the unit of the file.
    pub(crate) fn times(&self) -> &[f64] {
        self.values(self.time.column)
    }

    /// The column of the motion: displacement, or else velocity, or else acceleration.
    pub(crate) fn moving(&self) -> usize {
        self.roles.moving().unwrap_or(self.time.column)
    }

    /// The heading of a column.
    pub(crate) fn raw(&self, column: usize) -> &str {
        &self.table.columns[column].heading.raw
    }

    /// The frequency of a column (Hz), if one line of its spectrum has a tenth of what moves.
    pub fn frequency(&self, column: usize) -> Option<f64> {
        let line = self.statistics[column].line.filter(|l| column != self.time.column && l.share > LINE)?;
        Some(line.frequency / self.factor(self.time.column))
    }

    /// The factor from the unit of a column to SI.
    pub(crate) fn factor(&self, column: usize) -> f64 {
        factor(self.table.columns[column].heading.unit.as_deref())
    }

    /// Columns of the model that share their heading with another column.
    fn shared_headings(&self) -> impl Iterator<Item = Remark> {
        let shared = |name: &str| (0..self.table.columns.len()).filter(|&k| self.raw(k) == name).count() > 1;
        let needed = self.roles.used().chain([self.time.column]).map(|c| self.raw(c));
        needed.filter(move |name| shared(name)).map(|name| Remark::SharedHeading(name.to_owned()))
    }

    /// Remarks on other sheets and on what was done to read the file.
    fn of_the_file(&self) -> Vec<Remark> {
        let (sheets, notes) = (&self.table.other_sheets, &self.table.notes);
        let sheets = (!sheets.is_empty()).then(|| Remark::OtherSheets(sheets.clone()));
        sheets.into_iter().chain(notes.iter().chain(&self.merged).cloned().map(Remark::Note)).collect()
    }

    /// A remark if the unit of the time is a guess.
    fn guessed_unit(&self) -> Option<Remark> {
        let heading = &self.table.columns[self.time.column].heading;
        // Of a unit that makes no record the question tells.
        let guessed = self.time.unit_guessed && self.time.implausible_unit.is_none();
        guessed.then(|| Remark::TimeUnit {
            heading: heading.raw.clone(),
            step: self.time.step,
            unit: heading.unit.clone().unwrap_or_default(),
        })
    }

    /// A remark if the motion has no unit.
    fn motion_unit(&self) -> Option<Remark> {
        let of_angles = self.roles.is_angle;
        let unit = match (self.roles.displacement, self.roles.velocity) {
            (Some(_), _) => {
                if of_angles {
                    "rad"
                } else {
                    "m"
                }
            }
            (None, Some(_)) => {
                if of_angles {
                    "rad/s"
                } else {
                    "m/s"
                }
            }
            (None, None) => {
                if of_angles {
                    "rad/s^2"
                } else {
                    "m/s^2"
                }
            }
        };
        let heading = self.raw(self.moving()).to_owned();
        (!self.has_unit()).then_some(Remark::MotionUnit { heading, unit })
    }

    /// Remarks on positions of the model that wrap: a force that changes its sign where the motion turns
    /// jumps alike.
    fn wrapped(&self, run: &Range<usize>) -> Vec<Remark> {
        let of = |c: usize| {
            let Wrap { period, first, count } = wraps(&self.values(c)[run.clone()])?;
            let (heading, line) = (self.raw(c).to_owned(), self.table.row_numbers[run.start + first + 1]);
            Some(Remark::Wraps { heading, period, count, line })
        };
        let base = match self.roles.input {
            Input::Base(column) => Some(column),
            _ => None,
        };
        self.roles.displacement.into_iter().chain(base).filter_map(of).collect()
    }

    /// A remark if the stamps are coarser than the rows.
    fn coarse_time(&self) -> Option<Remark> {
        self.time.coarse.clone().map(Remark::CoarseTime)
    }

    /// A remark on the rate that the header states: it is used, or the times say otherwise.
    fn stated_rate(&self) -> Option<Remark> {
        let stated = self.time.stated.clone()?;
        if self.time.counted {
            return Some(Remark::StatedRate(stated));
        }
        let seen = 1.0 / (self.time.step * self.factor(self.time.column));
        let differs = (seen / stated.rate - 1.0).abs() > 0.02;
        differs.then_some(Remark::RateDiffers { stated, seen })
    }

    /// Remarks on columns that have no part because of what the user says.
    fn not_read(&self, rig: Option<Rig>) -> Vec<Remark> {
        let heading = |c: usize| self.raw(c).to_owned();
        let times = self.time.told.then(|| self.table.columns.iter().position(names_time)).flatten();
        let times = times.filter(|&c| c != self.time.column);
        let drive = self.roles.denied.zip(rig);
        let times = times.map(|c| Remark::TimesNotRead { heading: heading(c) });
        times
            .into_iter()
            .chain(drive.map(|(c, rig)| Remark::DriveNotRead { heading: heading(c), rig }))
            .collect()
    }

    /// Estimates the start values from the first record: from its good rows, and of these from the rows in
    /// motion.
    fn estimate_start(&mut self, good: Range<usize>, moving: Range<usize>, rig: Option<Rig>) {
        // A stretch without gaps may be too short to tell anything: then the rows that have all numbers must
        // do.
        let used: Vec<usize> = self.roles.used().chain([self.time.column]).collect();
        let is_there = |r: &usize| used.iter().all(|&c| self.values(c)[*r].is_finite());
        let rows: Vec<usize> = moving.filter(is_there).collect();
        let column = |c: usize| {
            let (unit, values) = (self.factor(c), self.values(c));
            rows.iter().map(|&r| values[r] * unit).collect::<Vec<f64>>()
        };
        let mut time = column(self.time.column);
        let displacement = match (self.roles.displacement, self.roles.velocity) {
            (Some(c), _) => column(c),
            (None, Some(c)) => integral(&time, &column(c)),
            (None, None) => self.roles.acceleration.map_or(vec![], |c| twice_integrated(&time, &column(c))),
        };
        let acceleration = self.roles.acceleration.map(column);
        let (base, force) = match self.roles.input {
            Input::None => (None, None),
            Input::Base(c) => (Some(column(c)), None),
            Input::BaseAcceleration(c) => (Some(twice_integrated(&time, &column(c))), None),
            Input::Force(c) | Input::Drive(c) | Input::Reaction(c) => (None, Some(column(c))),
        };
        let whole = self.displacement_range();
        let large = || (LARGE_ANGLE..ROUND).contains(&(0.5 * (whole.1 - whole.0)));
        let hangs = rig.and_then(Rig::hangs).unwrap_or_else(large);
        let is_pendulum = self.roles.is_angle && self.roles.displacement.is_some() && hangs;
        let grow = time.windows(2).position(|w| w[1] <= w[0]).map_or(time.len(), |k| k + 1);
        time.truncate(grow);
        let line = strongest_line(&time, &displacement[..grow.min(displacement.len())]);
        // Periods per unit of the file's time.
        let frequency = line.map(|l| l.frequency * self.factor(self.time.column));
        let there: Vec<usize> = good.filter(is_there).collect();
        let of = |c: usize| there.iter().map(|&r| self.values(c)[r]).collect::<Vec<f64>>();
        self.stops = stops(&of(self.time.column), &of(self.moving()), frequency);
        self.extent =
            displacement.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)));
        self.motion = Motion {
            time,
            displacement,
            acceleration,
            base,
            force,
            is_pendulum,
            frequency: line.map(|l| l.frequency),
        };
        self.estimate = self.motion.estimate();
        if rig == Some(Rig::Motor) {
            self.estimate.stiffness = None;
        }
        match (self.roles.input, self.roles.displacement, self.roles.is_angle) {
            (Input::Reaction(_), ..) => self.drive = self.motion.tester(),
            (Input::Force(c), Some(_), false) if rig.is_none() => {
                self.drive = self.motion.drive();
                if let Drive::Tester { .. } = self.drive {
                    self.roles.input = Input::Reaction(c);
                }
            }
            _ => {}
        }
    }

    fn displacement_range(&self) -> (f64, f64) {
        let Some(c) = self.roles.displacement else { return (0.0, 0.0) };
        (self.statistics[c].min * self.factor(c), self.statistics[c].max * self.factor(c))
    }

    /// Number of rows to average so that a record has few samples, but at least forty in a period.
    fn decimation(&self, samples: usize) -> usize {
        let wanted = samples.div_ceil(PLENTY).max(1);
        let step = self.time.step * self.factor(self.time.column);
        let allowed = self.motion.frequency.map_or(1.0, |f| (1.0 / (40.0 * f * step)).floor()) as usize;
        wanted.min(allowed.max(1))
    }

    /// Whether the motion is driven and no single frequency dominates it.
    pub(crate) fn is_rich(&self) -> bool {
        let driven = matches!(self.roles.input, Input::Force(_) | Input::Drive(_));
        driven && self.statistics[self.moving()].line.is_some_and(|l| l.share < 0.3)
    }

    /// Whether the force holds its value between jumps, as a relay does.
    pub(crate) fn is_held(&self) -> bool {
        self.motion.force.as_ref().is_some_and(|force| moves_by_jumps(force))
    }

    /// Whether the heading of the motion states a unit.
    pub(crate) fn has_unit(&self) -> bool {
        !matches!(self.table.columns[self.moving()].heading.quantity, Quantity::Unknown)
    }
}

/// The question for the unit of a displacement that has none, where its name says neither length nor angle, or where its
/// numbers are too large to be metres or radians.
fn open_unit(evidence: &Evidence<'_>, roles: &Roles) -> Option<Question> {
    let column = roles.displacement?;
    let (heading, statistics) = (evidence.heading(column), &evidence.statistics[column]);
    let taken = if roles.is_angle { "rad" } else { "m" };
    let most = if roles.is_angle { 2.0 * std::f64::consts::PI } else { FAR };
    let named = roles.is_angle || heading.has_word(LENGTHS);
    let large = statistics.max - statistics.min > most;
    let open = heading.quantity == Quantity::Unknown && (!named || large);
    open.then(|| Question::Unit { heading: heading.raw.clone(), taken })
}

/// A rig whose body moves by more than this (m) is rare: the numbers may be millimetres.
const FAR: f64 = 10.0;

/// Gives the columns the names that the user says, and leaves out those called `-`. They are still found in
/// the file by their own.
pub(crate) fn name_columns(table: &mut Table, names: &[String]) -> Result<(), (usize, usize)> {
    if names.is_empty() {
        return Ok(());
    }
    if names.len() != table.columns.len() {
        return Err((names.len(), table.columns.len()));
    }
    for (column, name) in table.columns.iter_mut().zip(names) {
        // Who names a column alone does not take its unit away.
        let unit = column.heading.unit.clone();
        let named = Heading { raw: column.heading.raw.clone(), ..Heading::parse(name) };
        column.heading = match unit.filter(|_| named.unit.is_none()) {
            Some(unit) => named.with_unit(&unit),
            None => named,
        };
    }
    let mut used = names.iter().map(|name| name != "-");
    table.columns.retain(|_| used.next().unwrap_or(true));
    Ok(())
}

/// Writes into the headings which columns count, and what a count is if the user says it of this column. An
/// encoder counts if it has no unit and whole numbers.
pub(crate) fn counts(table: &mut Table, answers: &Answers) {
    for column in &mut table.columns {
        let encoder = column.heading.unit.is_none() && column.heading.has_word(ENCODERS) && is_whole(column);
        if is_counted(&column.heading) || encoder {
            count(column, answers.own_unit_of(&column.heading));
        }
    }
}

/// Gives a column the unit of its counts, as far as it is said.
pub(crate) fn count(column: &mut Column, unit: Option<&str>) {
    let unit = unit.unwrap_or(COUNT);
    // `count/s` becomes `rev/4096/s`.
    let rest = column.heading.unit.as_deref().and_then(|own| own.strip_prefix(COUNT)).unwrap_or_default();
    column.heading = Heading { unit: None, ..column.heading.clone() }.with_unit(&format!("{unit}{rest}"));
}

/// Whether a column is in counts, or in counts per second.
pub(crate) fn is_counted(heading: &Heading) -> bool {
    heading
        .unit
        .as_deref()
        .and_then(|own| own.strip_prefix(COUNT))
        .is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
}
