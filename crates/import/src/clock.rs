//! Times of day and dates in a time column, as seconds from the first row.

/// Nanoseconds of a second and of a day.
const SECOND: i128 = 1_000_000_000;
const DAY: i128 = 86_400 * SECOND;

/// Reads the stamps of a column in order: `2024-05-17T10:32:07.125Z`, `17.05.2024 10:32:07,125`,
/// `10:32:07.125`.
///
/// A stamp without a date that is more than half a day before the last one belongs to the next day. Fractions
/// are exact to a nanosecond, however late the date.
#[derive(Clone, Debug, Default)]
pub(crate) struct Clock {
    /// The first stamp and the last one, in nanoseconds.
    first_last: Option<(i128, i128)>,
}

impl Clock {
    /// Seconds from the first stamp; none if the text is no stamp.
    pub(crate) fn seconds(&mut self, text: &str) -> Option<f64> {
        let (date, mut now) = stamp(text)?;
        let (first, last) = self.first_last.unwrap_or((now, now));
        if date.is_none() {
            now += (last - now + DAY / 2).div_euclid(DAY).max(0) * DAY;
        }
        self.first_last = Some((first, now));
        let apart = now - first;
        Some((apart / SECOND) as f64 + (apart % SECOND) as f64 / SECOND as f64)
    }
}

/// Whether a text is a time of day, with or without a date.
pub(crate) fn is_stamp(text: &str) -> bool {
    stamp(text).is_some()
}

/// Nanoseconds since the start of 1970 as a stamp that [`Clock`] reads.
pub(crate) fn stamp_text(nanoseconds: i128) -> String {
    let (days, time) = (nanoseconds.div_euclid(DAY), nanoseconds.rem_euclid(DAY));
    // Eras of 400 years, whose years begin in March.
    let from_march = days + 719_468;
    let (era, day) = (from_march.div_euclid(146_097), from_march.rem_euclid(146_097));
    let year = (day - day / 1_460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let (day, month) = (day - (153 * month + 2) / 5 + 1, if month < 10 { month + 3 } else { month - 9 });
    let year = year + 400 * era + i128::from(month < 3);
    let (seconds, fraction) = (time / SECOND, time % SECOND);
    let (hour, minute, second) = (seconds / 3600, seconds / 60 % 60, seconds % 60);
    format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}.{fraction:09}")
}

/// The day (if there is a date) and the nanoseconds since day 0.
fn stamp(text: &str) -> Option<(Option<i128>, i128)> {
    // Quick: most cells are numbers.
    text.contains(':').then_some(())?;
    let text = text.trim();
    let (date, time) = match text.split_once(['T', ' ']) {
        Some((date, time)) if date.contains(':') => (None, [date, " ", time].concat()),
        Some((date, time)) if is_unclear_day(date) => (None, time.trim().to_owned()),
        Some((date, time)) => (Some(day(date)?), time.trim().to_owned()),
        None => (None, text.to_owned()),
    };
    let (time, half) = half_day(&time);
    let (time, zone) = zone(time)?;
    let time = time_of_day(time)?;
    let noon = DAY / 2;
    let time = match half {
        None => time,
        // Twelve o'clock is the first hour of each half.
        Some(half) if (SECOND * 3600..noon + SECOND * 3600).contains(&time) => time % noon + half,
        Some(_) => return None,
    };
    Some((date, date.unwrap_or(0) * DAY + time - zone))
}

/// A time of twelve hours without its `AM` or `PM`, and where that half of the day begins.
fn half_day(text: &str) -> (&str, Option<i128>) {
    let Some(at) = text.len().checked_sub(2).filter(|at| text.is_char_boundary(*at)) else {
        return (text, None);
    };
    match text[at..].to_ascii_lowercase().as_str() {
        "am" => (text[..at].trim_end(), Some(0)),
        "pm" => (text[..at].trim_end(), Some(DAY / 2)),
        _ => (text, None),
    }
}

/// Whether a date begins with the day or the month, and none knows which: the time of the day alone counts then.
fn is_unclear_day(text: &str) -> bool {
    let parts: Vec<&str> = text.split('/').collect();
    let number = |(part, most): (&&str, i128)| whole(part, 2).is_some_and(|n| (1..=most).contains(&n));
    matches!(parts[..], [a, b, year] if [&a, &b].into_iter().zip([31, 31]).all(number) && matches!(year.len(), 2 | 4)
        && whole(year, 4).is_some())
}

/// The time without its zone, and the zone's distance from Greenwich in nanoseconds.
fn zone(text: &str) -> Option<(&str, i128)> {
    if let Some(time) = text.strip_suffix(['Z', 'z']) {
        return Some((time, 0));
    }
    let Some(at) = text.find(['+', '-']) else { return Some((text, 0)) };
    let digits: String = text[at + 1..].chars().filter(|c| *c != ':').collect();
    let minutes: i128 = match (digits.len(), digits.parse::<i128>().ok()?) {
        (2, hours) => 60 * hours,
        (4, both) => both / 100 * 60 + both % 100,
        _ => return None,
    };
    let sign = if text[at..].starts_with('-') { -1 } else { 1 };
    Some((text[..at].trim(), sign * minutes * 60 * SECOND))
}

/// `10:32:07.125` or `10:32`, in nanoseconds.
fn time_of_day(text: &str) -> Option<i128> {
    let mut parts = text.split(':');
    let (hours, minutes) = (whole(parts.next()?, 2)?, whole(parts.next()?, 2)?);
    let rest = parts.next().unwrap_or("0");
    if parts.next().is_some() || hours > 24 || minutes > 59 {
        return None;
    }
    let (seconds, fraction) = rest.split_once(['.', ',']).unwrap_or((rest, ""));
    let seconds = whole(seconds, 2).filter(|s| *s <= 60)?;
    let digits: String = fraction.chars().chain("000000000".chars()).take(9).collect();
    let nano = if fraction.is_empty() { 0 } else { whole(&digits, 9)? };
    Some(((hours * 60 + minutes) * 60 + seconds) * SECOND + nano)
}

/// The number of a day: year, month, day, or day, month, year with points.
fn day(text: &str) -> Option<i128> {
    let of = |mark: char| -> Option<[&str; 3]> { text.split(mark).collect::<Vec<_>>().try_into().ok() };
    let (year, month, day) = match (of('-').or_else(|| of('/')), of('.')) {
        (Some([y, m, d]), _) if y.len() == 4 => (y, m, d),
        (_, Some([d, m, y])) if y.len() == 4 => (y, m, d),
        _ => return None,
    };
    let (year, month, day) = (whole(year, 4)?, whole(month, 2)?, whole(day, 2)?);
    ((1..=12).contains(&month) && (1..=31).contains(&day)).then(|| {
        // Years that begin in March: the day of a leap year is the last one.
        let (y, m) = if month > 2 { (year, month - 3) } else { (year - 1, month + 9) };
        365 * y + y / 4 - y / 100 + y / 400 + (153 * m + 2) / 5 + day
    })
}

/// Digits alone, not more than `most`.
fn whole(text: &str, most: usize) -> Option<i128> {
    let good = !text.is_empty() && text.len() <= most && text.bytes().all(|b| b.is_ascii_digit());
    good.then(|| text.parse().ok()).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seconds(stamps: &[&str]) -> Vec<f64> {
        let mut clock = Clock::default();
        stamps.iter().map(|s| clock.seconds(s).expect("a stamp")).collect()
    }

    #[test]
    fn stamps_are_seconds_from_the_first() {
        for stamps in [
            ["2024-02-28T23:59:59.750", "2024-02-29T00:00:00.002", "2024-03-01T00:00:00.002"],
            ["2024-02-28 23:59:59.750Z", "2024-02-29 00:00:00.002Z", "2024-03-01 02:00:00.002+02:00"],
            ["28.02.2024 23:59:59,75", "29.02.2024 00:00:00,002", "01.03.2024 00:00:00,002"],
            ["2024/02/28 23:59:59.75", "2024/02/29 00:00:00.002", "2024/03/01 00:00:00.002"],
        ] {
            assert_eq!(seconds(&stamps), [0.0, 0.252, 86400.252], "{stamps:?}");
        }
        // Over midnight, twice.
        let days = ["23:59:59.9", "00:00:00.1", "12:00:00", "23:00:00", "01:00:00"];
        assert_eq!(seconds(&days), [0.0, 0.2, 43200.1, 82800.1, 90000.1]);
        assert_eq!(seconds(&["2025-12-31T23:59:59", "2026-01-01T00:00:00.000001"]), [0.0, 1.000001]);
        // Of the month before the day or the day before the month the time is the same.
        let unclear = [
            "03/11/2024 11:59:59.5 PM",
            "03/12/2024 12:00:00 AM",
            "03/12/2024 11:30:00 am",
            "3/12/24 1:00 PM",
        ];
        assert_eq!(seconds(&unclear), [0.0, 0.5, 41400.5, 46800.5]);
        // A logger that repeats or mixes up rows is not set to the next day.
        assert_eq!(seconds(&["10:00:01", "10:00:01", "10:00:00"]), [0.0, 0.0, -1.0]);
    }

    #[test]
    fn a_stamp_is_written_as_it_is_read() {
        for (nanoseconds, text) in [
            (0, "1970-01-01T00:00:00.000000000"),
            (951_782_400 * SECOND + 5, "2000-02-29T00:00:00.000000005"),
            (-1, "1969-12-31T23:59:59.999999999"),
            (1_735_689_599 * SECOND, "2024-12-31T23:59:59.000000000"),
        ] {
            assert_eq!(stamp_text(nanoseconds), text);
        }
        let mut clock = Clock::default();
        let times = [0, DAY, 60 * DAY, 1000 * DAY + 7 * SECOND, 200_000 * DAY];
        for time in times {
            assert_eq!(clock.seconds(&stamp_text(time)), Some((time / SECOND) as f64));
        }
    }

    #[test]
    fn other_texts_are_none() {
        for text in [
            "",
            ":",
            "1:2:3:4",
            "abc",
            "12",
            "1e3",
            "10:61:00",
            "10:00:61",
            "45/06/2024 10:00:00",
            "13:00:00 PM",
            "0:30 AM",
            "2024-13-01 10:00:00",
            "10:-1:00",
            "a:b",
            "2024-01-01",
            "é:é",
            "10:00:0é",
        ] {
            assert!(!is_stamp(text), "{text}");
        }
    }
}
