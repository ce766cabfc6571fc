//! What the spec will say: the records with their rows and windows, and the model with its numbers.

mod trouble;

use crate::csv::Survey;
use crate::headings::{Kind, factor};
use crate::roles::{Input, Roles};
use crate::start_values::{Estimate, Motion};
use crate::statistics::{Look, Stops, stops};
use crate::time_column::Clock;
use std::ops::Range;
pub use trouble::Trouble;

/// More samples than this in a record make a fit slow and hardly better.
const PLENTY: usize = 25_000;
/// More trials than this are not written out.
const MOST_TRIALS: usize = 6;
/// A swing of more than this is no small angle, in radian.
const LARGE_ANGLE: f64 = 0.5;

/// A record of the spec.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    /// What it is called.
    pub(crate) name: String,
    /// Headings and values that select its rows.
    pub(crate) rows: Vec<(String, f64)>,
    /// Which run of the file, where no column counts them.
    pub(crate) run: Option<usize>,
    /// Times as the file has them.
    pub(crate) window: Option<(f64, f64)>,
    /// Whether it is fitted.
    pub(crate) fit: bool,
}

/// Everything that the spec says.
#[derive(Debug)]
pub struct Draft {
    /// The file.
    pub(crate) survey: Survey,
    /// Its time.
    pub(crate) clock: Clock,
    /// For each column.
    pub(crate) looks: Vec<Look>,
    /// What the columns are.
    pub(crate) roles: Roles,
    /// The records.
    pub(crate) parts: Vec<Part>,
    /// Mean of so many rows.
    pub(crate) decimate: usize,
    /// The first record's motion, in SI.
    pub(crate) motion: Motion,
    /// Numbers to start from.
    pub(crate) estimate: Estimate,
    /// Where the motion stands still, in the first record's stretch.
    pub(crate) stops: Stops,
    /// Smallest and greatest place in the records, in SI.
    pub(crate) extent: (f64, f64),
    /// What should be known, in sentences; those that stop a run begin with `EDIT`.
    pub(crate) remarks: Vec<String>,
}

impl Draft {
    /// From the columns of a file.
    pub fn of(mut survey: Survey) -> Result<Draft, Trouble> {
        let clock = Clock::find(&mut survey).map_err(|message| Trouble {
            message,
            help: "add a column `time_s`, in seconds from the start, that grows from row to row".to_owned(),
            mistake: None,
        })?;
        let clock = clock.refined(&mut survey);
        let runs = clock.runs(survey.rows());
        let longest = runs.iter().max_by_key(|r| r.len()).cloned().unwrap_or(0..survey.rows());
        let time = &survey.columns[clock.column].values;
        let looks: Vec<Look> =
            survey.columns.iter().map(|c| Look::at(time, &c.values, longest.clone())).collect();
        if let Some(mistake) = blocking(&survey, &looks) {
            return Err(mistake);
        }
        let roles = Roles::guess(&survey, &clock, &looks, &longest).map_err(|message| Trouble {
            message,
            help: "a record needs a column of displacement or velocity; say which one in the heading, as in `x_mm` or `v [m/s]`".to_owned(),
            mistake: None,
        })?;
        let mut draft = Draft {
            clock,
            looks,
            roles,
            parts: vec![],
            decimate: 1,
            motion: Motion::default(),
            estimate: Estimate { spring: None, damper: 0.0, force: None, rest: 0.0 },
            stops: Stops::default(),
            extent: (0.0, 0.0),
            remarks: vec![],
            survey,
        };
        draft.twins();
        if draft.clock.fine {
            let unit = draft.survey.columns[draft.clock.column].heading.unit.clone().unwrap_or_default();
            draft.remarks.push(format!(
                "EDIT: the heading `{}` gives no unit: its steps of {} are taken for {unit} (for seconds write \"s\" in the place of \"{unit}\" in the records)",
                draft.raw(draft.clock.column),
                draft.clock.step
            ));
        }
        draft.records(&runs);
        Ok(draft)
    }

    /// The values of a column.
    pub(crate) fn values(&self, column: usize) -> &[f64] {
        &self.survey.columns[column].values
    }

    /// Time as the file has it.
    pub(crate) fn time(&self) -> &[f64] {
        self.values(self.clock.column)
    }

    /// The column of the displacement, or else of the velocity.
    pub(crate) fn moving(&self) -> usize {
        self.roles.place.or(self.roles.speed).unwrap_or(self.clock.column)
    }

    /// The heading of a column.
    pub(crate) fn raw(&self, column: usize) -> &str {
        &self.survey.columns[column].heading.raw
    }

    fn unit(&self, column: usize) -> f64 {
        factor(self.survey.columns[column].heading.unit.as_deref())
    }

    /// Says so if a column that is needed shares its heading with another one.
    fn twins(&mut self) {
        for c in self.roles.used().chain([self.clock.column]).collect::<Vec<_>>() {
            let name = self.raw(c).to_owned();
            if (0..self.survey.columns.len()).filter(|&k| self.raw(k) == name).count() > 1 {
                self.remarks.push(format!(
                    "EDIT: two columns are called `{name}`: rename one of them in the file before you run this"
                ));
            }
        }
    }

    fn records(&mut self, runs: &[Range<usize>]) {
        let trials = if runs.len() > 1 { self.trial_column(runs) } else { None };
        if runs.len() > 1 && trials.is_none() {
            let line = self.survey.lines[runs[1].start];
            self.remarks.push(format!(
                "EDIT: time goes back at line {line}{}: the file holds {} runs, and no column tells them apart. They are counted from 0: `run: 0`, \
                 `run: 1`, ...; if it is one run, correct the times in the file",
                if runs.len() > 2 { " and later" } else { "" },
                runs.len()
            ));
        }
        let counted = runs.len() > 1 && trials.is_none();
        let mut firsts = Vec::new();
        for (k, run) in runs.iter().enumerate().take(MOST_TRIALS) {
            let chosen = self.chosen(run.clone());
            if chosen.len() < 20 {
                continue;
            }
            let mut rows = Vec::new();
            if let Some(column) = trials {
                rows.push((self.raw(column).to_owned(), self.values(column)[chosen.start]));
            }
            if let Some(flag) = &self.roles.flag {
                rows.push((self.raw(flag.column).to_owned(), flag.value));
            }
            firsts.push((chosen, run.clone(), rows, counted.then_some(k)));
        }
        if runs.len() > MOST_TRIALS {
            self.remarks.push(format!(
                "the file holds {} trials, of which the first {MOST_TRIALS} are written out",
                runs.len()
            ));
        }
        let Some((first, ..)) = firsts.first() else {
            self.parts.push(Part {
                name: "all".to_owned(),
                rows: vec![],
                run: None,
                window: None,
                fit: true,
            });
            return;
        };
        let first = first.clone();
        self.study(first);
        let several = firsts.len() > 1;
        for (k, (chosen, run, rows, number)) in firsts.iter().enumerate() {
            let moving = self.trimmed(chosen.clone());
            let selected = self.selected(run.clone());
            let whole = selected.len() == moving.len();
            let time = |row: usize| self.time()[row.min(self.survey.rows() - 1)];
            let (a, b) = (time(moving.start), time(moving.end - 1));
            if several {
                let name = match (rows.first(), number) {
                    (_, Some(run)) => format!("run {run}"),
                    (Some((name, value)), None) => format!("{name} {value}"),
                    (None, None) => format!("trial {k}"),
                };
                let window = (!whole).then_some((a, b));
                let fit = k + 1 < firsts.len();
                self.parts.push(Part { name, rows: rows.clone(), run: *number, window, fit });
            } else {
                let middle = time(moving.start + moving.len() / 2);
                let part = |name: &str, window, fit| Part {
                    name: name.to_owned(),
                    rows: rows.clone(),
                    run: *number,
                    window: Some(window),
                    fit,
                };
                let (fit, rest) =
                    (part("first half", (a, middle), true), part("second half", (middle, b), false));
                self.parts.extend([fit, rest]);
            }
        }
        let longest = firsts.iter().map(|(c, ..)| c.len()).max().unwrap_or(0);
        let each = if several { longest } else { longest / 2 };
        self.decimate = self.thinning(each);
    }

    /// The column that tells the runs of a file apart: whole numbers, one for each.
    fn trial_column(&self, runs: &[Range<usize>]) -> Option<usize> {
        (0..self.survey.columns.len()).find(|&c| {
            let values = self.values(c);
            let own: Vec<f64> = runs.iter().map(|r| values[r.start]).collect();
            let constant = runs.iter().zip(&own).all(|(r, x)| values[r.clone()].iter().all(|y| y == x));
            let distinct = own.iter().enumerate().all(|(k, x)| x.fract() == 0.0 && !own[..k].contains(x));
            c != self.clock.column && constant && distinct
        })
    }

    /// Rows of a run that the flag takes.
    fn selected(&self, run: Range<usize>) -> Vec<usize> {
        let flag = self.roles.flag.as_ref();
        run.filter(|&r| flag.is_none_or(|f| self.values(f.column)[r] == f.value)).collect()
    }

    /// The longest stretch of rows of a run that the flag takes and in which nothing is missing or repeated.
    fn chosen(&mut self, run: Range<usize>) -> Range<usize> {
        let used: Vec<usize> = self.roles.used().chain([self.clock.column]).collect();
        let rows = self.selected(run.clone());
        let good = |r: usize, before: Option<usize>| {
            let there = used.iter().all(|&c| self.values(c)[r].is_finite());
            let later = before.is_none_or(|b| b + 1 == r && self.time()[r] > self.time()[b]);
            (there, later)
        };
        let (mut best, mut start, mut before) = (0..0, None, None);
        let (mut lost, mut repeated) = (None, None);
        for &r in &rows {
            let (there, later) = good(r, before);
            if !there {
                (start, before) = (None, None);
                lost = lost.or(Some(r));
                continue;
            }
            if !later {
                start = None;
                repeated = repeated.or(Some(r).filter(|_| before.is_some_and(|b| b + 1 == r)));
            }
            let from = *start.get_or_insert(r);
            before = Some(r);
            if r + 1 - from > best.len() {
                best = from..r + 1;
            }
        }
        // A window is two times, so that no row outside may have the time of the first or last one inside.
        let time = self.time();
        while best.len() > 1 && best.start > run.start && time[best.start - 1] == time[best.start] {
            best.start += 1;
        }
        while best.len() > 1 && best.end < run.end && time[best.end] == time[best.end - 1] {
            best.end -= 1;
        }
        let enough = best.len() * 5 >= rows.len();
        let lines = |r: usize| self.survey.lines[r];
        let mut said = Vec::new();
        if let Some(r) = lost {
            said.push(format!("values are missing (first in line {})", lines(r)));
        }
        if let Some(r) = repeated.filter(|_| self.clock.backs.is_empty()) {
            said.push(format!("a time stands twice (first in line {})", lines(r)));
        }
        if !said.is_empty() {
            let what = said.join(" and ");
            self.remarks.push(if enough {
                format!(
                    "EDIT: {what}: the windows take the longest stretch without, rows {} to {} of {}. To use all, delete the bad lines in the file",
                    best.start + 1,
                    best.end,
                    self.survey.rows()
                )
            } else {
                format!("EDIT: {what}, so often that no long stretch is left: delete those lines in the file before you run this")
            });
        }
        if enough { best } else { rows.first().map_or(0..0, |a| *a..rows[rows.len() - 1] + 1) }
    }

    /// A free motion without the rest before it starts and most of that after it ended.
    fn trimmed(&self, rows: Range<usize>) -> Range<usize> {
        if self.roles.input != Input::None || rows.len() < 100 {
            return rows;
        }
        let (time, x) = (&self.time()[rows.clone()], &self.values(self.moving())[rows.clone()]);
        let stops = stops(time, x, None);
        let near = rows.len() / 100 + 1;
        let mut kept = 0..rows.len();
        if let Some(first) =
            stops.stretches.first().filter(|s| s.start < near && s.len() > near && s.end + near < rows.len())
        {
            kept.start = first.end;
        }
        if let Some(last) =
            stops.stretches.last().filter(|s| s.end + near > rows.len() && s.start > kept.start)
        {
            kept.end = (last.start + (last.start - kept.start) / 20).min(rows.len());
        }
        if kept.len() < 20 { rows } else { rows.start + kept.start..rows.start + kept.end }
    }

    /// The numbers to start from, out of what will be fitted.
    fn study(&mut self, chosen: Range<usize>) {
        let rows = self.trimmed(chosen.clone());
        let column = |c: usize| {
            let unit = self.unit(c);
            self.values(c)[rows.clone()].iter().map(|x| x * unit).collect::<Vec<f64>>()
        };
        let mut time = column(self.clock.column);
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
        let line = phisindy_signal::strongest_line(&time, &place[..grow.min(place.len())]);
        // Periods per unit of the file's time.
        let frequency = line.map(|l| l.frequency * self.unit(self.clock.column));
        self.stops = stops(&self.time()[chosen.clone()], &self.values(self.moving())[chosen], frequency);
        self.extent =
            place.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)));
        self.motion = Motion { time, place, base, force, swing, frequency: line.map(|l| l.frequency) };
        self.estimate = self.motion.estimate();
    }

    fn place_extent(&self) -> (f64, f64) {
        let Some(c) = self.roles.place else { return (0.0, 0.0) };
        (self.looks[c].min * self.unit(c), self.looks[c].max * self.unit(c))
    }

    /// How many rows to take the mean of, so that a record is quick to fit and keeps forty samples in a period.
    fn thinning(&self, samples: usize) -> usize {
        let wanted = samples.div_ceil(PLENTY).max(1);
        let step = self.clock.step * self.unit(self.clock.column);
        let allowed = self.motion.frequency.map_or(1.0, |f| (1.0 / (40.0 * f * step)).floor()) as usize;
        wanted.min(allowed.max(1))
    }

    /// Whether the motion has many frequencies, none of which is most of it, and is driven.
    pub(crate) fn is_rich(&self) -> bool {
        let driven = matches!(self.roles.input, Input::Force(_) | Input::Drive(_));
        driven && self.looks[self.moving()].line.is_some_and(|l| l.share < 0.3)
    }

    /// Whether the model has the unit of the place from the heading.
    pub(crate) fn has_unit(&self) -> bool {
        !matches!(self.survey.columns[self.moving()].heading.kind, Kind::Unsaid)
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

/// Words in a column of nearly all numbers that a model may need: a run would stop there.
fn blocking(survey: &Survey, looks: &[Look]) -> Option<Trouble> {
    let good = |c: usize| survey.rows() - looks[c].missing;
    let needed = |c: usize| {
        !matches!(survey.columns[c].heading.kind, Kind::Electric | Kind::Acceleration | Kind::Other)
    };
    let mixed = |c: usize| survey.columns[c].words > 0 && good(c) > 9 * survey.columns[c].words;
    let column = (0..survey.columns.len()).find(|&c| needed(c) && mixed(c))?;
    let mut mistake = survey.columns[column].mistake.clone()?;
    let more = survey.columns[column].words - 1;
    if more > 0 {
        mistake = mistake.help(format!("{more} more cells of this column hold words"));
    }
    Some(Trouble { message: String::new(), help: String::new(), mistake: Some(Box::new(mistake)) })
}
