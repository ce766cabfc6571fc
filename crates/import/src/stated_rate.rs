//! The sampling rate that the header of a file states: `# fs = 1000 Hz`, `Abtastrate: 1 kHz`, `dt;0,001;s`.

use crate::headings::{Heading, normalized};
use phisindy_phys::unit::Unit;

/// A rate, and where it stands.
#[derive(Clone, Debug, PartialEq)]
pub struct StatedRate {
    /// Rows per second.
    pub rate: f64,
    /// Number of the line in the file, counted from 1.
    pub line: usize,
    /// The line.
    pub text: String,
}

/// What a word is followed by.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// Rows per second; hertz where no unit follows.
    Rate,
    /// Rows per second, if a unit says so: `sampled at 50 degC`.
    RateWithUnit,
    /// Seconds between two rows; without a unit a short time is in seconds.
    Step,
    /// Seconds between two rows, if a unit says so: `Ts = 0.5 Nm` is none.
    StepWithUnit,
}

/// Words of headers, in lower case.
const WORDS: &[(Kind, &[&str])] = &[
    (
        Kind::Rate,
        &[
            "fs",
            "f_s",
            "fsample",
            "f_sample",
            "fsamp",
            "f_samp",
            "sampling rate",
            "sampling_rate",
            "samplingrate",
            "sample rate",
            "sample_rate",
            "samplerate",
            "sampling frequency",
            "sampling_frequency",
            "sampling freq",
            "sample frequency",
            "sample_frequency",
            "sampling",
            "acquisition rate",
            "data rate",
            "scan rate",
            "frame rate",
            "framerate",
            "logging rate",
            "recording rate",
            "update rate",
            "output data rate",
            "odr",
            "fps",
            "samples per second",
            "samples/s",
            "samples/sec",
            "abtastrate",
            "abtastfrequenz",
            "abtastung",
            "messrate",
            "messfrequenz",
            "aufzeichnungsrate",
            "aufnahmerate",
            "datenrate",
            "bildrate",
            "fréquence d'échantillonnage",
            "frequence d'echantillonnage",
        ],
    ),
    (
        Kind::RateWithUnit,
        &[
            "sampled at",
            "sampled with",
            "recorded at",
            "recorded with",
            "logged at",
            "abgetastet mit",
            "aufgezeichnet mit",
            "rate",
        ],
    ),
    (
        Kind::Step,
        &[
            "dt",
            "d_t",
            "delta t",
            "delta_t",
            "deltat",
            "delta_x",
            "time step",
            "time_step",
            "timestep",
            "sample interval",
            "sample_interval",
            "sampling interval",
            "sampling_interval",
            "sample period",
            "sampling period",
            "sampling_period",
            "sample time",
            "sample_time",
            "sampling time",
            "sampletime",
            "wf_increment",
            "xincr",
            "xincrement",
            "x_increment",
            "abtastintervall",
            "abtastzeit",
            "abtastperiode",
            "abtastschritt",
            "zeitschritt",
            "zeitschrittweite",
            "messintervall",
            "période d'échantillonnage",
        ],
    ),
    (Kind::StepWithUnit, &["ts", "t_s", "interval", "period", "intervall", "schrittweite"]),
];
/// Units of a rate, in lower case, and rows per second.
const RATES: &[(&str, f64)] = &[
    ("hz", 1.0),
    ("hertz", 1.0),
    ("khz", 1e3),
    ("mhz", 1e6),
    ("s/s", 1.0),
    ("sa/s", 1.0),
    ("ks/s", 1e3),
    ("ksa/s", 1e3),
    ("sps", 1.0),
    ("ksps", 1e3),
    ("fps", 1.0),
    ("1/s", 1.0),
    ("samples/s", 1.0),
    ("samples/sec", 1.0),
    ("samples/second", 1.0),
    ("samples", 1.0),
    ("werte/s", 1.0),
];
/// A step without a unit is in seconds where it is shorter: 5 may be milliseconds.
const SECONDS: f64 = 0.2;
/// Between a word and its number stand at most so many characters that are neither.
const NEAR: usize = 24;
/// Rates of loggers of a motion.
const PLAUSIBLE: std::ops::RangeInclusive<f64> = 1e-2..=1e8;

/// The rate that a line states; `line` is its number.
pub(crate) fn stated_rate(text: &str, line: usize) -> Option<StatedRate> {
    // Cells are joined; a sign of comment is no part of a word.
    let plain: String =
        text.chars().map(|c| if c.is_control() || "\"';|".contains(c) { ' ' } else { c }).collect();
    // A letter for each letter, so that places agree.
    let lower: String = plain.chars().map(|c| c.to_lowercase().next().unwrap_or(c)).collect();
    let mut best: Option<(usize, usize, f64)> = None;
    for (kind, words) in WORDS {
        for word in *words {
            let Some(end) = found(&lower, word) else { continue };
            let starts = lower[..end - word.len()].trim_matches(|c: char| !c.is_alphanumeric()).is_empty();
            if *word == "rate" && !starts {
                continue;
            }
            let Some(rate) = rate_after(&lower[end..], *kind) else { continue };
            // Of `sampling` and `sampling rate` the longer one says more.
            if best.is_none_or(|(_, length, _)| word.len() > length) {
                best = Some((end, word.len(), rate));
            }
        }
    }
    let rate = best.map(|(.., rate)| rate).or_else(|| rate_before(&lower))?;
    PLAUSIBLE.contains(&rate).then(|| StatedRate { rate, line, text: shown(&plain) })
}

/// The rate that a column states whose one value is constant, or stands in its first rows alone: `Ts` of a
/// benchmark, `fs`. `row` is the number of the first row.
pub(crate) fn rate_of_column(heading: &Heading, values: &[f64], row: usize) -> Option<StatedRate> {
    let first = values.first().copied().filter(|x| *x > 0.0)?;
    if values.iter().any(|x| x.is_finite() && *x != first) {
        return None;
    }
    let unit = heading.unit.as_deref().or(heading.has_word(&["ts"]).then_some("s")).unwrap_or_default();
    stated_rate(&format!("{} = {first} {unit}", heading.name), row)
}

/// Where a whole word ends in a text.
fn found(text: &str, word: &str) -> Option<usize> {
    let part_of_word = |c: char| c.is_alphanumeric() || c == '_';
    text.match_indices(word).map(|(at, _)| (at, at + word.len())).find_map(|(at, end)| {
        let free = !text[..at].ends_with(part_of_word) && !text[end..].starts_with(part_of_word);
        free.then_some(end)
    })
}

/// The rate in what follows a word: ` [Hz]: 1000`, ` = 1 kHz`, ` is 0,001 s`.
fn rate_after(text: &str, kind: Kind) -> Option<f64> {
    let from = text.find(|c: char| c.is_ascii_digit()).filter(|at| *at <= NEAR)?;
    let between = &text[..from];
    // A unit in brackets before the number; other words belong to something else.
    let words: Vec<&str> =
        between.split(|c: char| " :=,()[]{}<>\t".contains(c)).filter(|w| !w.is_empty()).collect();
    let (unit_before, other): (Vec<&str>, Vec<&str>) =
        words.iter().partition(|word| unit_of(word, kind).is_some());
    let filler = ["is", "of", "at", "in", "ist", "von", "mit", "@", "~", "ca.", "approx.", "."];
    if other.iter().any(|word| !filler.contains(word)) {
        return None;
    }
    let (number, rest) = number(&text[from..])?;
    let word: String = rest
        .trim_start_matches(|c: char| c == ' ' || "[(<,".contains(c))
        .chars()
        .take_while(|c| !c.is_whitespace() && !"])>,;".contains(*c))
        .collect();
    let word = word.trim_end_matches('.');
    let factor = match (unit_of(word, kind), unit_before.first().and_then(|u| unit_of(u, kind))) {
        (Some(factor), _) | (None, Some(factor)) => factor,
        // In another unit it is something else.
        (None, None) if !word.is_empty() && normalized(word).is_some() => return None,
        (None, None) => match kind {
            Kind::Rate => 1.0,
            Kind::Step if number < SECONDS => 1.0,
            _ => return None,
        },
    };
    let value = number * factor;
    let rate = match kind {
        Kind::Rate | Kind::RateWithUnit => value,
        Kind::Step | Kind::StepWithUnit => rounded(1.0 / value),
    };
    (rate.is_finite() && rate > 0.0).then_some(rate)
}

/// `1 kHz sampling`: the number stands before the word.
fn rate_before(text: &str) -> Option<f64> {
    let says = ["sampling", "sample rate", "samplerate", "abtastrate", "abtastung", "abtastfrequenz"];
    let end = says.iter().find_map(|word| found(text, word).map(|end| end - word.len()))?;
    let mut words = text[..end].split_whitespace().rev();
    let (unit, digits) = (words.next()?, words.next());
    // `1000Hz` is one word.
    let at = unit.find(|c: char| c.is_alphabetic())?;
    let (digits, unit) = if at > 0 { (&unit[..at], &unit[at..]) } else { (digits?, unit) };
    let factor = unit_of(unit, Kind::RateWithUnit)?;
    let (x, rest) = number(digits)?;
    (rest.is_empty() && x > 0.0).then_some(x * factor)
}

/// The factor of a unit of a rate, or of a time.
fn unit_of(word: &str, kind: Kind) -> Option<f64> {
    match kind {
        Kind::Rate | Kind::RateWithUnit => RATES.iter().find(|(unit, _)| *unit == word).map(|(_, f)| *f),
        Kind::Step | Kind::StepWithUnit => {
            let unit = Unit::parse(&normalized(word)?).ok()?;
            let second = Unit::parse("s").ok()?;
            (unit.dimension == second.dimension).then_some(unit.factor)
        }
    }
}

/// The number at the start of a text, with point or comma, and what follows. None where a comma may be one of
/// thousands: `1,000`.
fn number(text: &str) -> Option<(f64, &str)> {
    let exponent = |at: usize| {
        let rest = &text[at + 1..];
        text[..at].ends_with(|c: char| c.is_ascii_digit())
            && rest.trim_start_matches(['-', '+']).starts_with(|c: char| c.is_ascii_digit())
            && rest.find(|c: char| c.is_ascii_digit()).is_some_and(|k| k <= 1)
    };
    let mut end = 0;
    for (at, c) in text.char_indices() {
        let sign = matches!(c, '-' | '+') && text[..at].ends_with('e');
        if !(c.is_ascii_digit() || matches!(c, '.' | ',') || sign || (c == 'e' && exponent(at))) {
            break;
        }
        end = at + c.len_utf8();
    }
    let digits = text[..end].trim_end_matches(['.', ',']);
    let (commas, points) = (digits.matches(',').count(), digits.matches('.').count());
    let plain = match (commas, points) {
        (0, _) => digits.to_owned(),
        (1, 0) => {
            let (whole, part) = digits.split_once(',')?;
            if part.len() == 3 && !whole.starts_with('0') {
                return None;
            }
            digits.replace(',', ".")
        }
        _ => return None,
    };
    Some((plain.parse().ok()?, &text[end..]))
}

/// `1/0.001` is 1000.
fn rounded(rate: f64) -> f64 {
    let whole = rate.round();
    if (rate / whole - 1.0).abs() < 1e-9 { whole } else { rate }
}

/// The line as messages show it.
fn shown(text: &str) -> String {
    let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
    if words.chars().count() > 60 { words.chars().take(57).chain("...".chars()).collect() } else { words }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_state_the_rate_in_many_ways() {
        for (text, rate) in [
            ("# fs = 1000 Hz", 1000.0),
            ("# Fs=1 kHz", 1000.0),
            ("% Sampling rate: 1 kHz", 1000.0),
            ("Sampling Rate [Hz];512", 512.0),
            ("Abtastrate: 2,5 kHz", 2500.0),
            ("Abtastfrequenz;1000,0;Hz", 1000.0),
            ("// dt = 0.001 s", 1000.0),
            ("dt (ms) = 4", 250.0),
            ("# dt=2e-3", 500.0),
            ("Zeitschritt: 0,005 s", 200.0),
            ("Sample Interval,0.0004,", 2500.0),
            ("Delta_X\t0.001000\t0.001000", 1000.0),
            ("; sampled at 250 Hz on Monday", 250.0),
            ("# 1 kHz sampling, IEPE", 1000.0),
            ("# recorded with 12.5 kHz", 12500.0),
            ("# ODR: 6.66 kHz", 6660.0),
            ("# rate 500 S/s", 500.0),
            ("\"Sample rate\",\"100.000\",\"Hz\"", 100.0),
            ("# Ts = 10 ms", 100.0),
            ("# fs = 1000 Hz, fc = 80 Hz", 1000.0),
        ] {
            assert_eq!(stated_rate(text, 3).map(|r| (r.rate, r.line)), Some((rate, 3)), "{text}");
        }
    }

    #[test]
    fn a_column_of_one_value_states_the_rate() {
        let rate = |heading: &str, values: &[f64]| {
            rate_of_column(&Heading::parse(heading), values, 2).map(|stated| stated.rate)
        };
        assert_eq!(rate("Ts", &[4.0, f64::NAN, f64::NAN]), Some(0.25));
        assert_eq!(rate("fs", &[500.0; 3]), Some(500.0));
        assert_eq!(rate("dt [ms]", &[2.0; 3]), Some(500.0));
        assert_eq!(rate("dt", &[0.01, 0.01, 0.02]), None);
        assert_eq!(rate("x", &[0.01; 3]), None);
        assert_eq!(rate("fs", &[]), None);
    }

    #[test]
    fn what_is_no_rate_is_left_alone() {
        for text in [
            "",
            "# Ts = 0.5 Nm, static",
            "# dt = 5",
            "# offset = 3",
            "# lowpass 100 Hz",
            "# baud rate: 9600",
            "# Sampling rate: 1,000 Hz",
            "# excitation frequency = 5 Hz",
            "# sampled at 20 degC",
            "# sampling: see sheet 2",
            "# fs = 0 Hz",
            "# fs = 1e999 Hz",
            "# fs = -5 Hz",
            "fs é 1000",
            "# sampling",
            "µ sampling",
            "Hz sampling",
            "# dt = 0 s",
        ] {
            assert_eq!(stated_rate(text, 1), None, "{text}");
        }
    }
}
