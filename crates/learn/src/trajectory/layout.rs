//! The unknowns of a trajectory fit as one vector: coefficients, shared parameters, then for each record its
//! own parameters, its free sensor parameters, and a start state for each of its segments.

use crate::decisions::SEGMENT_SAMPLES;
use phisindy_phys::{Record, SensorParameter, SensorPart, System};

/// Some of the sensor parameters, in the order of [`SensorPart::ALL`].
pub(crate) const GAIN: usize = SensorPart::Gain as usize;
pub(crate) const DELAY: usize = SensorPart::Delay as usize;
pub(crate) const CLOCK: usize = SensorPart::Clock as usize;
pub(crate) const LAG: usize = SensorPart::Lag as usize;

/// A run of samples with a start state of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Segment {
    pub(crate) record: usize,
    /// First and one past the last sample.
    pub(crate) samples: (usize, usize),
    /// Where its start state stands among the unknowns.
    pub(crate) start: usize,
}

/// Where a number of the model comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Source {
    Unknown(usize),
    Number(f64),
}

/// Where the numbers of a sensor come from, in the order of [`SensorPart::ALL`].
pub(crate) type SensorSources = [Source; SensorPart::ALL.len()];

/// Where the unknowns of a sensor stand among those of a run; `usize::MAX` for a number that is known.
pub(crate) type SensorSlots = [usize; SensorPart::ALL.len()];

/// Which unknowns there are, and where they enter each record.
pub(crate) struct Layout {
    pub(crate) bounds: Vec<(f64, f64)>,
    /// Belief beforehand: unknown, centre, standard deviation.
    pub(crate) priors: Vec<(usize, f64, f64)>,
    /// For each record, the parameters of the model.
    pub(crate) model: Vec<Vec<Source>>,
    /// For each record, the sensor parameters of each state, each output, then each input.
    pub(crate) sensors: Vec<Vec<SensorSources>>,
    pub(crate) segments: Vec<Segment>,
}

impl Layout {
    /// For a choice of terms and records; each record is cut into `pieces[r]` segments of equal length.
    pub(crate) fn new(system: &System, terms: &[usize], records: &[&Record], pieces: &[usize]) -> Layout {
        let mut layout = Layout {
            bounds: terms.iter().map(|&t| system.terms[t].within).collect(),
            priors: vec![],
            model: vec![],
            sensors: vec![],
            segments: vec![],
        };
        let shared: Vec<Option<Source>> = system
            .parameters
            .iter()
            .map(|p| (!p.each).then(|| layout.unknown(p.within, p.start, p.sigma)))
            .collect();
        for (r, record) in records.iter().enumerate() {
            let parameters = layout.parameters(system, &shared);
            let sensors = layout.sensors_of(system, &parameters, record);
            let coefficients = (0..terms.len()).map(Source::Unknown);
            let constants = record.constants.iter().map(|&c| Source::Number(c));
            layout.model.push(coefficients.chain(parameters).chain(constants).collect());
            layout.sensors.push(sensors);
            layout.cut(r, record, pieces[r], system);
        }
        layout
    }

    /// One more unknown.
    fn unknown(&mut self, within: (f64, f64), centre: f64, sigma: Option<f64>) -> Source {
        self.bounds.push(within);
        self.priors.extend(sigma.map(|s| (self.bounds.len() - 1, centre, s)));
        Source::Unknown(self.bounds.len() - 1)
    }

    /// The system's parameters in a record: the shared ones, and those that each record has.
    fn parameters(&mut self, system: &System, shared: &[Option<Source>]) -> Vec<Source> {
        let each = system.parameters.iter().zip(shared);
        each.map(|(p, shared)| shared.unwrap_or_else(|| self.unknown(p.within, p.start, p.sigma))).collect()
    }

    /// The sensors of a record: of its states, its outputs, then its inputs.
    fn sensors_of(&mut self, system: &System, parameters: &[Source], record: &Record) -> Vec<SensorSources> {
        let n = system.columns();
        let mut of = |s: &SensorParameter, free: bool| match (s.shared, s.within) {
            (Some(p), _) => parameters[p],
            (None, Some(within)) if free => self.unknown(within, s.start, s.sigma),
            _ => Source::Number(s.start),
        };
        let mut all: Vec<SensorSources> = Vec::new();
        for (k, sensor) in record.sensors[..n].iter().enumerate() {
            all.push(sensor.parameters().map(|s| of(s, record.columns[k].is_some())));
        }
        for sensor in &record.sensors[n..] {
            let own = sensor.follows.is_none();
            all.push(sensor.parameters().map(|s| if own { of(s, true) } else { Source::Number(s.start) }));
        }
        // What is derived from an input has its gain, its delay and its clock.
        for (k, of) in record.sensors[n..].iter().enumerate().filter_map(|(k, s)| Some((k, s.follows?))) {
            for which in [GAIN, DELAY, CLOCK] {
                all[n + k][which] = all[n + of][which];
            }
        }
        all
    }

    /// Cuts a record into segments of equal length, with a start state each.
    fn cut(&mut self, r: usize, record: &Record, pieces: usize, system: &System) {
        let count = pieces.clamp(1, (record.len() / SEGMENT_SAMPLES).max(1));
        for piece in 0..count {
            let samples = (piece * record.len() / count, (piece + 1) * record.len() / count);
            self.segments.push(Segment { record: r, samples, start: self.bounds.len() });
            for state in &system.states {
                // Elements of one law that act in parallel: their sum is seen, each alone hardly.
                self.unknown((f64::NEG_INFINITY, f64::INFINITY), 0.0, state.memory);
            }
        }
    }
}
