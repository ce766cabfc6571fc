//! Columns that begin anew after a turn, such as the angle of an encoder.

use phisindy_phys::spec::CsvSpec;

/// Counts the turns of a column from its first row.
pub(super) struct Turns {
    /// What it moves by in a turn (SI).
    period: f64,
    last: Option<f64>,
    count: f64,
}

impl Turns {
    /// Of a state, output or input, if its sensor says that it begins anew.
    pub(super) fn of(csv: &CsvSpec, name: &str) -> Option<Turns> {
        let (_, sensor) = csv.sensors.iter().find(|(n, _)| n.value == name)?;
        Some(Turns { period: sensor.unwrap.as_ref()?.value, last: None, count: 0.0 })
    }

    /// The next number, with the turns before it: it moves by less than half a turn from row to row.
    pub(super) fn unwrapped(&mut self, x: f64) -> f64 {
        let step = self.last.replace(x).map_or(0.0, |last| x - last);
        self.count -= (step / self.period).round();
        x + self.count * self.period
    }
}
