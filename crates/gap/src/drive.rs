//! The drive of a record: the known rates as functions of time while all states are zero.

use crate::decisions::{DRIVE_LINE, DRIVE_LINES, DRIVE_REPEATS, DRIVE_TIMES, SAME_LINE};
use crate::whiteness::{lines, mean_step, share};
use phisindy_expr::{Scratch, Tape};
use phisindy_phys::{Record, System};

/// The known rates with all states at zero, as functions of time.
pub(crate) struct Drive<'a> {
    system: &'a System,
    record: &'a Record,
    scratch: Scratch<1>,
}

impl<'a> Drive<'a> {
    /// `None` where the known rates depend on something that is not among their arguments.
    pub(crate) fn new(system: &'a System, record: &'a Record) -> Option<Drive<'a>> {
        let tape = Tape::compile(&system.graph, &system.arguments(), &system.known).ok()?;
        Some(Drive { system, record, scratch: Scratch::new(&tape) })
    }

    /// The rate of each state at a time.
    pub(crate) fn at(&mut self, t: f64) -> Vec<f64> {
        let inputs = self.record.inputs.iter().map(|u| u.value(t));
        let still = self.system.states.iter().map(|_| 0.0);
        let numbers = self.system.parameters.iter().map(|p| p.start);
        let numbers = numbers.chain(self.record.constants.iter().copied());
        self.scratch.at([t].into_iter().chain(still).chain(inputs).chain(numbers));
        (0..self.system.known.len()).map(|k| self.scratch.output(k)[0]).collect()
    }

    /// Whether there is a drive and it repeats with this period (s). Without a drive a motion decays. Under
    /// two incommensurate tones the cycles of a motion differ although nothing is random.
    pub(crate) fn repeats(&mut self, period: f64) -> bool {
        let (first, last) = (self.record.time[0], self.record.time[self.record.len() - 1]);
        let time = |i: usize| first + (last - first - period) * i as f64 / DRIVE_TIMES as f64;
        let now: Vec<Vec<f64>> = (0..DRIVE_TIMES).map(|i| self.at(time(i))).collect();
        let later: Vec<Vec<f64>> = (0..DRIVE_TIMES).map(|i| self.at(time(i) + period)).collect();
        let (mut swing, mut apart) = (0.0, 0.0);
        for k in 0..self.system.known.len() {
            let mean = now.iter().map(|rates| rates[k]).sum::<f64>() / DRIVE_TIMES as f64;
            for (a, b) in now.iter().zip(&later) {
                if a[k].is_finite() && b[k].is_finite() && mean.is_finite() {
                    swing += (a[k] - mean).powi(2);
                    apart += (a[k] - b[k]).powi(2);
                }
            }
        }
        // A rate that is constant up to rounding is no drive.
        let level = now.iter().flatten().filter(|r| r.is_finite()).map(|r| r * r).sum::<f64>();
        swing > 1e-20 * level && apart <= DRIVE_REPEATS * DRIVE_REPEATS * swing
    }

    /// The spectral line of the drive (rad/s) of which `frequency` is a multiple, with that multiple.
    /// Anything nonlinear puts the multiples of a drive into the motion. A drive of many tones has no such line: any
    /// frequency is near a multiple of one of them. Then its strongest lines are not the larger part of its power.
    pub(crate) fn multiple_at(&mut self, frequency: f64) -> Option<(f64, u32)> {
        let apart = SAME_LINE / span(self.record);
        let larger = |all: &Vec<(f64, f64)>| all.iter().map(|(_, share)| share).sum::<f64>() > 0.5;
        let mut lines = self.lines_with_shares().into_iter().filter(larger).flatten();
        lines.find_map(|(line, _)| Some((line, multiple(frequency, (line, line), u32::MAX, apart)?)))
    }

    /// Whether nothing drives the model: its known rates do not change while all states are zero.
    pub(crate) fn is_still(&mut self) -> bool {
        let (first, last) = (self.record.time[0], self.record.time[self.record.len() - 1]);
        let time = |i: usize| first + (last - first) * i as f64 / DRIVE_TIMES as f64;
        let rates: Vec<Vec<f64>> = (0..DRIVE_TIMES).map(|i| self.at(time(i))).collect();
        rates.iter().all(|now| now == &rates[0])
    }

    /// The spectral lines of the drive (rad/s), rate by rate.
    pub(crate) fn lines(&mut self) -> Vec<f64> {
        self.lines_with_shares().into_iter().flatten().map(|(line, _)| line).collect()
    }

    /// The spectral lines of each rate (rad/s), with the share of its power that each holds.
    fn lines_with_shares(&mut self) -> Vec<Vec<(f64, f64)>> {
        let (n, first) = (self.record.len(), self.record.time[0]);
        let step = mean_step(&self.record.time);
        let rates: Vec<Vec<f64>> = (0..n).map(|i| self.at(first + i as f64 * step)).collect();
        let of = |k: usize| {
            let rate: Vec<f64> = rates.iter().map(|r| r[k]).collect();
            let moves = rate.iter().all(|r| r.is_finite()) && rate.iter().any(|r| *r != rate[0]);
            let candidates = if moves { lines(&rate, step, DRIVE_LINES, 0) } else { vec![] };
            let with_share = candidates.into_iter().map(|line| (line, share(&rate, line * step)));
            with_share.filter(|(_, share)| *share > DRIVE_LINE).collect()
        };
        (0..self.system.known.len()).map(of).collect()
    }
}

/// A free oscillation of which a frequency is a multiple.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct OfOscillation {
    /// Its frequency (rad/s), the mean of both halves of the record.
    pub(crate) line: f64,
    /// The multiple.
    pub(crate) times: u32,
    /// Whether the frequency is a multiple of that mean; otherwise only of a frequency between those of the
    /// halves, for the frequency of an oscillation may change while it decays.
    pub(crate) exactly: bool,
}

/// The free oscillation of a record of which `frequency` (rad/s) is a multiple up to `most`.
pub(crate) fn multiple_of_oscillation(record: &Record, frequency: f64, most: u32) -> Option<OfOscillation> {
    let apart = SAME_LINE / span(record);
    (0..record.columns.len()).find_map(|k| {
        let (time, column) = record.own_column(k)?;
        let step = mean_step(&time);
        let (early, late) = column.split_at(column.len() / 2);
        let own = |part: &[f64]| lines(part, step, 1, 0).first().copied();
        let (a, b) = (own(early)?, own(late)?);
        let line = 0.5 * (a + b);
        let times = multiple(frequency, (a.min(b), a.max(b)), most, apart)?;
        let exactly = multiple(frequency, (line, line), most, apart).is_some();
        Some(OfOscillation { line, times, exactly })
    })
}

/// Duration of a record (s).
fn span(record: &Record) -> f64 {
    record.time[record.len() - 1] - record.time[0]
}

/// The multiple of a band of frequencies, up to `most`, that a frequency is no farther `apart` from.
fn multiple(frequency: f64, (low, high): (f64, f64), most: u32, apart: f64) -> Option<u32> {
    let times = (frequency / (0.5 * (low + high))).round().max(1.0);
    let within = frequency > times * low - apart && frequency < times * high + apart;
    (low > apart && within && times <= f64::from(most)).then_some(times as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An oscillator under a drive.
    fn driven(by: &str) -> (System, Record) {
        let text = format!(
            r#"(states: {{ "x": "m", "v": "m/s" }}, constants: {{ "k": (4.0, "1/s^2") }}, known: {{ "x": "v", "v": "-k*x + {by}" }}, unknown: {{}},
            data: [ Synthetic(truth: {{}}, start: {{ "x": 2.0, "v": 0.0 }}, duration: 120.0, step: 0.05, noise: Additive(0.02), seed: 1) ])"#
        );
        let (model, _) = crate::test_models::model(&text);
        let record = model.records[0].clone();
        (model.system, record)
    }

    #[test]
    fn only_what_moves_repeats() {
        let tone = std::f64::consts::TAU / 0.7;
        for (by, period, repeats) in [
            ("1*cos(0.7*t)", tone, true),
            ("9.81 + 1*cos(0.7*t)", tone, true),
            ("1*cos(0.7*t)", 1.1 * tone, false),
            ("1*cos(0.7*t) + 0.3*cos(1.3*t)", tone, false),
            ("0*t", 3.0, false),
            ("9.81", 3.0, false),
        ] {
            let (system, record) = driven(by);
            let found = Drive::new(&system, &record).expect("a drive").repeats(period);
            assert_eq!(found, repeats, "{by} after {period}");
        }
    }

    #[test]
    fn lines_of_the_drive_are_known() {
        let (system, record) = driven("1*cos(0.7*t) + 0.3*cos(1.3*t)");
        let mut drive = Drive::new(&system, &record).expect("a drive");
        for (frequency, line, multiple) in
            [(0.7, 0.7, 1), (0.705, 0.7, 1), (1.3, 1.3, 1), (1.4, 0.7, 2), (3.9, 1.3, 3)]
        {
            let found = drive.multiple_at(frequency).unwrap_or((f64::NAN, 0));
            assert!((found.0 - line).abs() < 0.005 && found.1 == multiple, "{frequency}: {found:?}");
        }
        // No match: the frequency of the free motion, a frequency close to a line.
        for frequency in [2.0, 0.72, 0.9, 1.27, 3.0] {
            assert_eq!(drive.multiple_at(frequency), None, "{frequency}");
        }
        assert!(!drive.is_still());
    }

    #[test]
    fn no_tone_stands_for_a_drive_of_many() {
        let tones = |n: usize| {
            let tone = |k: usize| format!("1*cos({:.3}*t + {k})", 0.4 + 0.37 * k as f64);
            (0..n).map(tone).collect::<Vec<_>>().join(" + ")
        };
        let of = |n: usize| {
            let (system, record) = driven(&tones(n));
            Drive::new(&system, &record).expect("a drive").multiple_at(0.8).map(|(_, times)| times)
        };
        assert_eq!([of(3), of(2 * DRIVE_LINES + 2)], [Some(2), None]);
    }

    #[test]
    fn multiples_of_a_free_oscillation_are_known() {
        let (system, record) = driven("0*t");
        assert!(Drive::new(&system, &record).expect("a drive").is_still());
        for (frequency, multiple) in
            [(2.0, Some(1)), (4.0, Some(2)), (6.005, Some(3)), (3.0, None), (4.1, None)]
        {
            assert_eq!(
                multiple_of_oscillation(&record, frequency, 3).map(|o| o.times),
                multiple,
                "{frequency}"
            );
        }
    }
}
