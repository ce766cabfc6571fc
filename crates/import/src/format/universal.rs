//! Universal files of modal analysis: the functions of time in their datasets 58 and 58b.

use crate::bytes::{Bytes, Kind};
use crate::channel::{Channel, Clock, MOST_CHANNELS, Values};
use crate::refusal::Refusal;

const FORMAT: &str = "universal (UFF)";
/// Begins and ends a dataset.
const MARK: &[u8] = b"-1";
/// Lines of the head of a dataset 58.
const HEAD: usize = 11;
/// The abscissa is a time.
const TIME: usize = 17;

/// Whether a file begins with a dataset.
pub(super) fn begins(start: &[u8]) -> bool {
    let mut lines = start.split(|b| *b == b'\n').map(<[u8]>::trim_ascii).skip_while(|line| line.is_empty());
    let (mark, kind) = (lines.next(), lines.next().unwrap_or(b""));
    let digits = kind.iter().take_while(|b| b.is_ascii_digit()).count();
    mark == Some(MARK) && digits > 0 && matches!(kind.get(digits), None | Some(b'b' | b' '))
}

/// The functions of time.
pub(super) fn channels(bytes: &[u8]) -> Result<Vec<Channel>, Refusal> {
    let mut lines = Lines { bytes, at: 0, number: 0 };
    let (mut channels, mut others) = (vec![], 0);
    while let Some(line) = lines.next() {
        if line.trim_ascii() != MARK {
            continue;
        }
        let Some(kind) = lines.next() else { break };
        let text = String::from_utf8_lossy(kind).into_owned();
        let kind = text.trim();
        if kind == "58" || kind.starts_with("58b") || kind.starts_with("58 ") {
            let first = lines.number;
            match dataset(&mut lines, &text)? {
                Some(channel) => channels.push(channel),
                None => others += 1,
            }
            if channels.len() > MOST_CHANNELS {
                break;
            }
            if lines.next().is_none_or(|line| line.trim_ascii() != MARK) {
                return Err(cut(first, "does not end with -1"));
            }
        } else {
            while lines.next().is_some_and(|line| line.trim_ascii() != MARK) {}
        }
    }
    if channels.is_empty() && others > 0 {
        return Err(Refusal::file(
            format!("its {others} functions are none of time, but of frequency or complex"),
            "export the time histories: a record is motion over time",
        ));
    }
    Ok(channels)
}

fn cut(line: usize, what: &str) -> Refusal {
    Refusal::broken(FORMAT, format!("the dataset of line {line} {what}"))
}

/// The function of a dataset that begins with the line before; none if it is no function of time.
fn dataset(lines: &mut Lines<'_>, kind: &str) -> Result<Option<Channel>, Refusal> {
    let first = lines.number;
    let head: Vec<String> = (0..HEAD)
        .map_while(|_| lines.next())
        .map(|line| String::from_utf8_lossy(line).into_owned())
        .collect();
    let [_, _, _, _, _, place, form, abscissa, ordinate, _, _] = head.as_slice() else {
        return Err(cut(first, "is cut off"));
    };
    let form =
        Form::of(form).ok_or_else(|| cut(first, "has a head that says not how its numbers are stored"))?;
    let ends = || cut(first, &format!("ends before its {} numbers", form.count));
    let all = match kind.trim_start().strip_prefix("58b") {
        // The order of the bytes comes first: 1 begins with the lowest.
        Some(rest) => form.binary(lines, !rest.trim_start().starts_with('1')),
        None => form.written(lines),
    };
    let all = all.ok_or_else(ends)?;
    let of_time =
        field(abscissa, 0, 10).and_then(|t| t.parse().ok()) == Some(TIME) && !form.complex && form.count > 1;
    if !of_time {
        return Ok(None);
    }
    let (clock, values) = if form.even {
        (Clock::Even(form.start, form.step), all)
    } else {
        let every = |k: usize| all.iter().skip(k).step_by(2).copied().collect();
        (Clock::Listed(every(0)), every(1))
    };
    let text = |line: &str, from: usize, to: usize| {
        field(line, from, to).filter(|t| *t != "NONE" && !t.is_empty()).map(str::to_owned)
    };
    let quantity = text(ordinate, 26, 46).unwrap_or_else(|| quantity(field(ordinate, 0, 10)).to_owned());
    let body = text(place, 31, 41).map(|name| format!(" {name}")).unwrap_or_default();
    let node = text(place, 41, 51).unwrap_or_default();
    let name = format!("{quantity}{body} {node}{}", direction(field(place, 51, 55)));
    let unit = text(ordinate, 47, 67);
    Ok(Some(Channel {
        group: String::new(),
        name,
        unit,
        values: Values::Numbers(values),
        clock: Some(clock),
    }))
}

/// How the numbers of a dataset are stored.
struct Form {
    double: bool,
    complex: bool,
    count: usize,
    even: bool,
    start: f64,
    step: f64,
}

impl Form {
    fn of(line: &str) -> Option<Form> {
        let whole = |from: usize, to: usize| field(line, from, to)?.parse::<usize>().ok();
        let kind = whole(0, 10).filter(|kind| matches!(kind, 2 | 4 | 5 | 6))?;
        let even = whole(20, 30)? == 1;
        let (start, step) = (real(field(line, 30, 43)?)?, real(field(line, 43, 56)?)?);
        (!even || step > 0.0).then_some(())?;
        Some(Form {
            double: kind % 2 == 0 && kind > 2,
            complex: kind > 4,
            count: whole(10, 20)?,
            even,
            start,
            step,
        })
    }

    /// Numbers of a sample.
    fn width(&self) -> usize {
        usize::from(!self.even) + if self.complex { 2 } else { 1 }
    }

    fn binary(&self, lines: &mut Lines<'_>, big: bool) -> Option<Vec<f64>> {
        let kind = if self.double { Kind::F64 } else { Kind::F32 };
        let mut bytes = Bytes::new(lines.rest(), big);
        let all = kind.read_many(&mut bytes, self.count.checked_mul(self.width())?)?;
        lines.at = lines.bytes.len() - bytes.rest().len();
        // Some programs end the line there.
        if lines.rest().starts_with(b"\n") || lines.rest().starts_with(b"\r") {
            lines.next();
        }
        Some(all)
    }

    /// Numbers as text in fields of fixed width, which may touch each other.
    fn written(&self, lines: &mut Lines<'_>) -> Option<Vec<f64>> {
        let widths: &[usize] = match (self.double, self.even, self.complex) {
            (false, ..) => &[13],
            (true, true, _) => &[20],
            (true, false, false) => &[13, 20],
            (true, false, true) => &[13, 20, 20],
        };
        let wanted = self.count.checked_mul(self.width())?;
        let mut all = vec![];
        while all.len() < wanted {
            let line = lines.next()?;
            let line = std::str::from_utf8(line).ok()?.trim_end();
            let (mut at, mut k) = (0, 0);
            while at < line.len() && all.len() < wanted {
                let end = (at + widths[k % widths.len()]).min(line.len());
                all.push(real(line.get(at..end)?.trim())?);
                (at, k) = (end, k + 1);
            }
            if k == 0 {
                return None;
            }
        }
        Some(all)
    }
}

/// What stands in these columns of a line.
fn field(line: &str, from: usize, to: usize) -> Option<&str> {
    line.get(from..to.min(line.len())).map(str::trim)
}

/// A number as Fortran writes it.
fn real(text: &str) -> Option<f64> {
    text.replace(['D', 'd'], "e").parse::<f64>().ok().filter(|x| x.is_finite())
}

/// The quantity of a code, where no words say it.
fn quantity(code: Option<&str>) -> &'static str {
    match code {
        Some("8") => "displacement",
        Some("9" | "13") => "force",
        Some("11") => "velocity",
        Some("12") => "acceleration",
        Some("15") => "pressure",
        _ => "channel",
    }
}

/// The direction of a code: 3 is `Z+`.
fn direction(code: Option<&str>) -> &'static str {
    match code {
        Some("1") => "X+",
        Some("-1") => "X-",
        Some("2") => "Y+",
        Some("-2") => "Y-",
        Some("3") => "Z+",
        Some("-3") => "Z-",
        Some("4") => "RX+",
        Some("-4") => "RX-",
        Some("5") => "RY+",
        Some("-5") => "RY-",
        Some("6") => "RZ+",
        Some("-6") => "RZ-",
        _ => "",
    }
}

/// Lines of bytes, of which some hold numbers instead.
struct Lines<'a> {
    bytes: &'a [u8],
    at: usize,
    number: usize,
}

impl<'a> Lines<'a> {
    fn rest(&self) -> &'a [u8] {
        &self.bytes[self.at..]
    }

    fn next(&mut self) -> Option<&'a [u8]> {
        let rest = self.rest();
        if rest.is_empty() {
            return None;
        }
        let end = rest.iter().position(|b| *b == b'\n').unwrap_or(rest.len() - 1);
        self.at += end + 1;
        self.number += 1;
        Some(rest[..=end].strip_suffix(b"\n").unwrap_or(&rest[..=end]))
    }
}
