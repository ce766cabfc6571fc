//! Channels of a file that stores one by one: brought to one time where they have rates of their own.

use crate::channel::{Channel, Clock, MOST_CHANNELS, Values};
use crate::columns::{Column, Columns};
use crate::headings::{Heading, Quantity};
use crate::listing::marked;
use crate::refusal::{Refusal, Wanted};
use crate::sheet::{OwnChannel, Rows, Sheet};
use crate::time_column::is_named_time;
use phisindy_phys::unit::Unit;
use phisindy_signal::on_straight_lines;

/// The column of time of channels that have a first time and a step.
const TIME: &str = "time";

/// Channels with the same times.
struct Rate {
    columns: Vec<Column>,
    /// Of them, the column of time.
    time: Option<usize>,
    length: usize,
    clock: Option<Clock>,
}

impl Rate {
    fn times(&self) -> Option<&[f64]> {
        match &self.columns[self.time?].values {
            Values::Numbers(t) if t.windows(2).all(|w| w[1] > w[0]) => Some(t),
            _ => None,
        }
    }

    /// Whether it holds something that moves or pushes.
    fn moves(&self) -> bool {
        self.columns.iter().any(|c| {
            use Quantity::{Acceleration, Angle, AngularSpeed, Force, Length, Speed, Torque};
            let heading = Heading::parse(&c.name).with_unit(c.unit.as_deref().unwrap_or(""));
            matches!(heading.quantity, Length | Angle | Speed | AngularSpeed | Acceleration | Force | Torque)
        })
    }
}

/// The table that the channels of a file form.
///
/// # Errors
/// There are no channels, not the wanted group, or columns of different lengths without their times.
pub(crate) fn sheet(channels: Vec<Channel>, wanted: &Wanted<'_>) -> Result<Sheet, Refusal> {
    let (channels, name) = chosen(channels, wanted.sheet())?;
    let rates = rates(named(channels));
    let base = base(&rates, wanted)?;
    let Joined { columns, notes, own } = joined(rates, base, wanted)?;
    Ok(Sheet { name, others: vec![], notes, own, rows: Rows::Columns(columns) })
}

/// The channels of the wanted group, without its name; the name if there are several groups.
fn chosen(all: Vec<Channel>, group: Option<&str>) -> Result<(Vec<Channel>, Option<String>), Refusal> {
    if all.is_empty() {
        return Err(Refusal::file(
            "it holds no channel of two numbers or more",
            "give a file with the columns of a record",
        ));
    }
    if all.len() > MOST_CHANNELS {
        let message = format!("it holds {} channels, which are no columns of a record", all.len());
        return Err(Refusal::file(
            message,
            "save the time, the motion and the inputs in a file of their own",
        ));
    }
    let mut groups: Vec<&str> = vec![];
    for channel in &all {
        if !groups.contains(&channel.group.as_str()) {
            groups.push(&channel.group);
        }
    }
    let Some(group) = group else {
        // The only group need not be named.
        let alone = groups.len() == 1;
        let strip = |c: Channel| if alone { Channel { group: String::new(), ..c } } else { c };
        return Ok((all.into_iter().map(strip).collect(), None));
    };
    if !groups.contains(&group) {
        let list: Vec<String> = groups.iter().filter(|g| !g.is_empty()).map(|g| (*g).to_owned()).collect();
        return Err(Refusal::missing_sheet(group, &list));
    }
    let own = all.into_iter().filter(|c| c.group == group);
    Ok((own.map(|c| Channel { group: String::new(), ..c }).collect(), Some(group.to_owned())))
}

/// Every channel with a name that no other one has.
fn named(channels: Vec<Channel>) -> Vec<Channel> {
    let mut taken = std::collections::HashMap::new();
    let own = |mut c: Channel| {
        if !c.group.is_empty() {
            c.name = format!("{}.{}", c.group, c.name);
        }
        let count: &mut usize = taken.entry(c.name.clone()).or_insert(0);
        *count += 1;
        if *count > 1 {
            c.name = format!("{} ({count})", c.name);
        }
        c.unit = c.unit.filter(|u| Unit::parse(u.trim()).is_ok() && u.trim().parse::<f64>().is_err());
        c
    };
    channels.into_iter().map(own).collect()
}

/// The channels, each beside those with the same times; where the file gives a first time and a step, with a
/// column of time.
fn rates(channels: Vec<Channel>) -> Vec<Rate> {
    let mut rates: Vec<Rate> = vec![];
    for channel in channels {
        let (length, clock) = (channel.values.len(), channel.clock);
        let column = Column { name: channel.name, unit: channel.unit, values: channel.values };
        match rates.iter_mut().find(|r| r.length == length && r.clock == clock) {
            Some(rate) => rate.columns.push(column),
            None => rates.push(Rate { columns: vec![column], time: None, length, clock }),
        }
    }
    let clocks = rates.iter().filter(|r| r.clock.is_some()).count();
    let taken: Vec<String> = rates.iter().flat_map(|r| &r.columns).map(|c| c.name.clone()).collect();
    for rate in &mut rates {
        let Some(clock) = &rate.clock else {
            let named = |c: &Column| {
                is_named_time(&Heading::parse(&c.name).with_unit(c.unit.as_deref().unwrap_or("")))
            };
            rate.time = rate.columns.iter().position(named);
            continue;
        };
        let mut name =
            if clocks == 1 { TIME.to_owned() } else { format!("{TIME} of {}", rate.columns[0].name) };
        while taken.contains(&name) {
            name.push('_');
        }
        let times = match clock {
            Clock::Even(first, step) => (0..rate.length).map(|k| first + k as f64 * step).collect(),
            Clock::Listed(times) => times.clone(),
        };
        rate.columns.insert(0, Column { name, unit: Some("s".to_owned()), values: Values::Numbers(times) });
        rate.time = Some(0);
    }
    rates
}

/// The channels whose times are those of the rows.
fn base(rates: &[Rate], wanted: &Wanted<'_>) -> Result<usize, Refusal> {
    let with = |name: &str| rates.iter().position(|r| r.columns.iter().any(|c| c.name == name));
    Ok(match wanted {
        // A column that is missing is told with the heading.
        Wanted::Record(csv) => {
            let first = || csv.columns.iter().find_map(|(_, c)| with(&c.header.value));
            let time = csv.rate.is_none().then(|| with(&csv.time.header.value)).flatten();
            time.or_else(first).unwrap_or(0)
        }
        // Of what moves the slowest: then no number between two samples of a motion is invented.
        Wanted::All { .. } => {
            let timed = |r: &&(usize, &Rate)| r.1.times().is_some() && r.1.columns.len() > 1;
            let step = |r: &(usize, &Rate)| slowness(r.1.times().unwrap_or(&[]));
            let all: Vec<(usize, &Rate)> = rates.iter().enumerate().collect();
            let slowest = |test: &dyn Fn(&Rate) -> bool| {
                let fit = all.iter().filter(timed).filter(|r| test(r.1));
                fit.max_by(|a, b| step(a).total_cmp(&step(b))).map(|r| r.0)
            };
            let most = || all.iter().max_by_key(|r| (r.1.columns.len(), r.1.length)).map(|r| r.0);
            slowest(&Rate::moves).or_else(|| slowest(&|_| true)).or_else(most).unwrap_or(0)
        }
    })
}

/// The mean step of times.
fn slowness(times: &[f64]) -> f64 {
    let span = times.last().zip(times.first()).map_or(0.0, |(b, a)| b - a);
    span / times.len().saturating_sub(1).max(1) as f64
}

/// The columns of one rate, and those of others.
struct Joined {
    columns: Columns,
    notes: Vec<String>,
    own: Vec<OwnChannel>,
}

/// The columns of the base, and those of other rates at its times.
fn joined(mut rates: Vec<Rate>, base: usize, wanted: &Wanted<'_>) -> Result<Joined, Refusal> {
    let own = rates.remove(base);
    let (mut notes, mut own_times) = (vec![], vec![]);
    let needed = |name: &str| match wanted {
        Wanted::Record(csv) => {
            csv.columns.iter().any(|(_, c)| c.header.value == name)
                || csv.rows.iter().any(|(n, _)| n.value == name)
        }
        Wanted::All { .. } => true,
    };
    let (mut first, mut last) = (0, own.length);
    let mut further = vec![];
    for rate in rates {
        let asked: Vec<usize> = (0..rate.columns.len())
            .filter(|k| Some(*k) != rate.time && needed(&rate.columns[*k].name))
            .collect();
        if asked.is_empty() {
            continue;
        }
        let names: Vec<String> = asked.iter().map(|k| rate.columns[*k].name.clone()).collect();
        let names = marked(&names);
        let (Some(to), Some(from)) = (own.times(), rate.times()) else {
            if matches!(wanted, Wanted::All { .. }) {
                notes.push(format!("{names}: {} rows with no times of their own, left out", rate.length));
                continue;
            }
            let message = format!(
                "{names} has {} rows, and the other columns of the record {}",
                rate.length, own.length
            );
            let help =
                "give each rate a column of time that grows, with a name such as `t` or `time`, in the file";
            return Err(Refusal::file(message, help));
        };
        let inside = |t: &f64| *t >= from[0] && *t <= from[from.len() - 1];
        first = first.max(to.iter().position(inside).unwrap_or(to.len()));
        last = last.min(to.iter().rposition(inside).map_or(0, |k| k + 1));
        if matches!(wanted, Wanted::All { .. }) {
            notes.push(format!("{names}: has times of its own, and is read at these"));
        }
        for k in asked {
            let Column { name, unit, .. } = &rate.columns[k];
            let values = match &rate.columns[k].values {
                Values::Numbers(x) => {
                    if matches!(wanted, Wanted::Record(_)) {
                        own_times.push(OwnChannel {
                            name: name.clone(),
                            time: from.to_vec(),
                            values: x.clone(),
                        });
                    }
                    Values::Numbers(on_straight_lines(from, x, to))
                }
                Values::Words(_) => continue,
            };
            further.push(Column { name: name.clone(), unit: unit.clone(), values });
        }
    }
    let rows = last.saturating_sub(first);
    let mut columns: Vec<Column> = own.columns.into_iter().chain(further).collect();
    if rows < own.length {
        for column in &mut columns {
            match &mut column.values {
                Values::Numbers(x) => *x = x[first.min(x.len())..last.max(first).min(x.len())].to_vec(),
                Values::Words(x) => *x = x[first.min(x.len())..last.max(first).min(x.len())].to_vec(),
            }
        }
    }
    Ok(Joined { columns: Columns { columns, rows, first }, notes, own: own_times })
}
