//! Measured velocities that are not the rate of their displacement: a unit is wrong, a sensor is mounted the
//! other way round, or columns are swapped.

use super::words::Suspicion;
use crate::system::equations::System;
use crate::system::record::Record;
use phisindy_signal::{noise_level, standard_deviation};

/// A factor between rate and velocity beyond this is a wrong unit, not a sensor out of calibration.
const SCALE: f64 = 3.0;
/// Correlation above which two curves have one shape, and below which they have different shapes.
const ALIKE: f64 = 0.9;
const UNLIKE: f64 = 0.5;
/// Before an exchange the misfit between rate and velocity exceeds `APART` and `NEARER` times the misfit
/// after it, for bodies that move nearly alike.
const APART: f64 = 0.15;
const NEARER: f64 = 4.0;
/// An exchange whose misfit is below `ALSO.0` times the least plus `ALSO.1` is named too.
const ALSO: (f64, f64) = (1.2, 0.03);
/// A misfit below `SAME` is a match, with real sensors and noise; above `OTHER` it is none.
const SAME: f64 = 0.35;
const OTHER: f64 = 0.5;

/// Compares each measured velocity with the rate of its measured displacement. Returns whether anything was
/// found.
pub(super) fn rates(system: &System, record: &Record, found: &mut Vec<Suspicion>) -> bool {
    let before = found.len();
    let swapped = swapped(system, record);
    if let Some(finding) = &swapped.finding {
        found.push(finding.clone());
    }
    for (k, v) in pairs(system, record).filter(|pair| !swapped.pairs.contains(pair)) {
        let (Some(x), Some(y)) = (&record.columns[k], &record.columns[v]) else { continue };
        let (name, other) = (&system.states[k].name, &system.states[v].name);
        let Some(Rate { slope, correlation, .. }) = rate(record, x, y) else { continue };
        if correlation > ALIKE && !(1.0 / SCALE..SCALE).contains(&slope) {
            let (displacement, velocity) = (name.clone(), other.clone());
            found.push(Suspicion::RateScaled { displacement, velocity, factor: slope });
        } else if correlation < -ALIKE {
            let (displacement, velocity) = (name.clone(), other.clone());
            found.push(Suspicion::RateReversed { displacement, velocity });
        }
    }
    found.len() > before
}

/// Indices of the displacements and velocities that are both measured.
fn pairs(system: &System, record: &Record) -> impl Iterator<Item = (usize, usize)> {
    let measured = |k: usize| record.columns[k].is_some();
    let of = move |(k, velocity): (usize, Option<usize>)| {
        Some((k, velocity.filter(|&v| measured(k) && measured(v))?))
    };
    system.states.iter().map(|s| s.velocity).enumerate().filter_map(of)
}

/// Displacements and their velocities.
type Pairs = Vec<(usize, usize)>;

/// Exchanged columns, and the pairs that are wrong because of the exchange.
#[derive(Default)]
struct Swapped {
    finding: Option<Suspicion>,
    pairs: Pairs,
}

/// Searches two columns whose exchange makes each velocity the rate of its displacement.
fn swapped(system: &System, record: &Record) -> Swapped {
    let pairs: Pairs = pairs(system, record).collect();
    let states = system.states.iter().zip(&record.columns).map(|(s, c)| (&s.name, &s.unit, c.as_deref()));
    let derived = |k: usize| record.derivations.iter().any(|d| d.input == k);
    let samples: Vec<_> = (0..system.inputs.len()).map(|k| record.input_samples(k)).collect();
    let inputs = system.inputs.iter().zip(&samples).enumerate();
    let inputs = inputs.map(|(k, (u, samples))| (&u.name, &u.unit, (!derived(k)).then_some(&**samples)));
    let columns: Vec<(&String, &String, Option<&[f64]>)> = states.chain(inputs).collect();
    let rate_of = |k: usize, v: usize| rate(record, columns[k].2?, columns[v].2?);
    // First the two columns of one pair.
    for &(k, v) in &pairs {
        let (Some(straight), Some(crossed)) = (rate_of(k, v), rate_of(v, k)) else { continue };
        // In a free oscillation the rate of the velocity is proportional to minus the displacement: the size
        // of the slope decides.
        let off = |rate: &Rate| rate.slope.abs().ln().abs();
        let likelier = straight.correlation > -ALIKE || off(&crossed) < off(&straight);
        if straight.correlation < UNLIKE && crossed.correlation > ALIKE && likelier {
            let (displacement, velocity) = (columns[k].0.clone(), columns[v].0.clone());
            let finding = Suspicion::PairSwapped { displacement, velocity };
            return Swapped { finding: Some(finding), pairs: vec![(k, v)] };
        }
    }
    let mut best: Vec<(f64, [usize; 2], Pairs)> = Vec::new();
    for i in 0..columns.len() {
        for j in i + 1..columns.len() {
            let exchanged = |k: usize| {
                if k == i {
                    j
                } else if k == j {
                    i
                } else {
                    k
                }
            };
            let touched: Pairs =
                pairs.iter().copied().filter(|&(k, v)| [k, v].iter().any(|&c| exchanged(c) != c)).collect();
            // Exchanges within one pair are treated above.
            let alone = touched.contains(&(i, j)) || touched.contains(&(j, i));
            if alone || touched.is_empty() || columns[i].2.is_none() || columns[j].2.is_none() {
                continue;
            }
            let same_unit = columns[i].1 == columns[j].1;
            let good =
                |r: &Rate| if same_unit { r.misfit < SAME } else { r.correlation > ALIKE && r.slope > 0.0 };
            let all = |of: &dyn Fn(usize, usize) -> Option<Rate>| -> Option<Vec<Rate>> {
                touched.iter().map(|&(k, v)| of(k, v)).collect()
            };
            let now = all(&rate_of);
            let then = all(&|k, v| rate_of(exchanged(k), exchanged(v)));
            let (Some(now), Some(then)) = (now, then) else { continue };
            let misfit = then.iter().map(|r| r.misfit).fold(0.0, f64::max);
            let limit = OTHER.min(APART.max(NEARER * misfit));
            let bad = |r: &Rate| if same_unit { r.misfit > limit } else { r.correlation < UNLIKE };
            if now.iter().all(bad) && then.iter().all(good) {
                best.push((misfit, [i, j], touched));
            }
        }
    }
    best.sort_by(|a, b| a.0.total_cmp(&b.0));
    let Some((least, .., touched)) = best.first() else { return Swapped::default() };
    // With two bodies an exchange of the displacements and one of the velocities explain the same.
    let candidates: Vec<(String, String)> = best
        .iter()
        .filter(|(misfit, .., other)| *misfit < ALSO.0 * least + ALSO.1 && other == touched)
        .map(|(_, [i, j], _)| (columns[*i].0.clone(), columns[*j].0.clone()))
        .collect();
    Swapped { finding: Some(Suspicion::SwappedByRates { candidates }), pairs: touched.clone() }
}

/// The rate of a displacement compared with a velocity.
#[derive(Clone, Copy, Debug)]
struct Rate {
    slope: f64,
    correlation: f64,
    /// Root mean square of their difference without the noise of the displacement, relative to the larger of
    /// the two.
    misfit: f64,
}

/// Compares the rate of `x` with `y`, both integrated over a stretch that is long enough for noise not to
/// matter.
fn rate(record: &Record, x: &[f64], y: &[f64]) -> Option<Rate> {
    let (noise, size) = (noise_level(x), standard_deviation(x));
    if !(size > 0.0 && standard_deviation(y) > 0.0) || x.len() < 64 || noise > 0.2 * size {
        return None;
    }
    // The integral of the velocity over a stretch is the difference of the displacement over it.
    let mut sums = vec![0.0];
    for (w, t) in y.windows(2).zip(record.time.windows(2)) {
        sums.push(sums[sums.len() - 1] + 0.5 * (w[0] + w[1]) * (t[1] - t[0]));
    }
    // The shortest stretch over which the displacement moves well beyond its noise.
    let mut stretch = 1;
    while stretch < x.len() / 8 {
        let moved = (0..x.len() - stretch).map(|i| (x[i + stretch] - x[i]).powi(2)).sum::<f64>();
        if (moved / (x.len() - stretch) as f64).sqrt() > (10.0 * noise).min(0.5 * size) {
            break;
        }
        stretch += 1 + stretch / 8;
    }
    let pairs = (0..x.len() - stretch).map(|i| (sums[i + stretch] - sums[i], x[i + stretch] - x[i]));
    let (mut aa, mut ab, mut bb) = (0.0_f64, 0.0_f64, 0.0_f64);
    for (a, b) in pairs {
        aa += a * a;
        ab += a * b;
        bb += b * b;
    }
    let noise = 2.0 * noise * noise * (x.len() - stretch) as f64;
    (aa > 0.0 && bb > 0.0).then(|| Rate {
        slope: ab / aa,
        correlation: ab / (aa * bb).sqrt(),
        misfit: ((aa + bb - 2.0 * ab - noise).max(0.0) / aa.max(bb)).sqrt(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use phisindy_signal::test_signals::gaussian;

    /// The findings for two bodies and the base `u`, each with its own motion, in a file of which two columns
    /// may be exchanged.
    fn finding(exchange: Option<(usize, usize)>, modes: [[f64; 3]; 3]) -> String {
        let text = r#"(states: {"x1": "m", "x2": "m", "v1": "m/s", "v2": "m/s"}, inputs: {"u": "m"},
            known: {"x1": "v1", "x2": "v2", "v1": "u-x1", "v2": "-x2"}, unknown: {},
            data: [Csv(path: "a.csv", name: "a", time: "t", columns: {"x1": "a", "x2": "b", "v1": "c", "v2": "d", "u": "e"})])"#;
        let mut sources = crate::text::diagnostic::Sources::default();
        let id = sources.add("spec", text);
        let (spec, _) = crate::text::spec::read(text, id).unwrap();
        let (case, _) = crate::system::check::check(&spec, id).unwrap();
        let time: Vec<f64> = (0..2500).map(|i| 0.01 * f64::from(i)).collect();
        // Each motion is a sum of sines of 1.1, 2.9 and 5.3 rad/s.
        let motion = |body: usize, rate: bool, seed: u64| -> Vec<f64> {
            let at = |t: f64| -> f64 {
                let mode = |k: usize| {
                    let (w, phase) = ([1.1, 2.9, 5.3][k], k as f64);
                    modes[body][k] * if rate { w * (w * t + phase).cos() } else { (w * t + phase).sin() }
                };
                (0..3).map(mode).sum()
            };
            time.iter().zip(gaussian(2500, seed)).map(|(t, e)| at(*t) + 0.02 * e).collect()
        };
        let mut columns = vec![
            motion(0, false, 1),
            motion(1, false, 2),
            motion(0, true, 3),
            motion(1, true, 4),
            motion(2, false, 5),
        ];
        if let Some((i, j)) = exchange {
            columns.swap(i, j);
        }
        let table =
            crate::system::table::Table { time: time.clone(), columns, lines: vec![], ..Default::default() };
        let record = Record::from_table(&case.records[0], &table, &case.system, id).unwrap();
        let mut found = vec![];
        rates(&case.system, &record, &mut found);
        found.iter().map(Suspicion::to_string).collect::<Vec<_>>().join("; ")
    }

    const MOTIONS: [[f64; 3]; 3] = [[1.0, 0.6, 0.2], [0.5, -0.9, 0.3], [0.8, -0.2, -0.5]];

    #[test]
    fn any_two_columns_that_are_swapped_are_told() {
        assert_eq!(finding(None, MOTIONS), "");
        for (exchange, names) in [
            ((0, 1), "`x1` and `x2` (or `v1` and `v2`)"),
            ((2, 3), "`x1` and `x2` (or `v1` and `v2`)"),
            ((0, 3), "`x1` and `v2`"),
            ((1, 4), "`x2` and `u`"),
            ((1, 3), "`x2` is the rate of `v2`"),
            ((0, 2), "`x1` is the rate of `v1`"),
        ] {
            let said = finding(Some(exchange), MOTIONS);
            assert!(said.contains(names) && said.ends_with("swapped"), "{exchange:?}: {said}");
        }
    }

    /// Bodies that move alike cannot be distinguished; with different amplitudes they can.
    #[test]
    fn equal_motions_are_not_told() {
        let alike = |size: f64| [MOTIONS[0], MOTIONS[0].map(|a| size * a), MOTIONS[2]];
        assert_eq!(finding(Some((0, 1)), alike(1.1)), "");
        assert!(finding(Some((0, 1)), alike(2.5)).contains("`x1` and `x2`"));
        // Nearly alike, but the misfit is ten times larger before the exchange.
        assert!(finding(Some((0, 1)), alike(1.4)).contains("`x1` and `x2`"));
    }
}
