//! `phisindy-blind noise`: do intervals hold the truth where noise is not white, and where the model lacks a sensor
//! or a force?
//!
//! ```text
//! slider --simulated in ms--> x --sensor, noise of a kind--> every tenth sample --identify--> k, c, Fc: held?
//! ```

use crate::args::{NoiseArgs, Options};
use crate::dice::Dice;
use crate::interrupt;
use crate::markdown::markdown;
use crate::progress::Progress;
use crate::table::Table;
use anyhow::{Result, anyhow};
use phisindy::files::{Purpose, Request, open_text};
use phisindy_learn::{Estimate, Identified, LearnOptions, Warning};
use phisindy_phys::Record;
use phisindy_signal::{Interpolation, Signal, standard_deviation};
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::ops::ControlFlow;
use std::path::Path;

/// The numbers of the slider: stiffness, damping, friction.
const TRUTH: [(&str, f64); 3] = [("k", 800.0), ("c", 1.5), ("Fc", 1.2)];
/// Samples of the simulation for one of the record.
const EVERY: usize = 10;
/// Step of the simulation (s).
const STEP: f64 = 0.001;
/// Size of the noise in parts of the motion.
const SIZE: f64 = 0.02;

/// What makes a column of the exact one, all in units of its standard deviation.
type Sensor = fn(&mut Dice, &[f64]) -> Vec<f64>;

/// What is not as the model has it.
enum Odd {
    /// The sensor of the displacement.
    Sensor(Sensor),
    /// The measured drive, with noise of this part of it.
    Input(f64),
    /// A force that nobody measures.
    Force,
}

/// The kinds, in the order of the table.
const KINDS: &[(&str, Odd)] = &[
    ("white", Odd::Sensor(|dice, x| sampled(x).zip(white(dice)).map(|(x, e)| x + SIZE * e).collect())),
    ("AR(1), 0.8", Odd::Sensor(|dice, x| coloured(dice, x, 0.8, 0.6))),
    ("random walk", Odd::Sensor(|dice, x| coloured(dice, x, 1.0, 0.1))),
    ("hum of 50 Hz", Odd::Sensor(|dice, x| beside(dice, x, |t| (TAU * 49.3 * t).cos()))),
    ("drift", Odd::Sensor(|dice, x| beside(dice, x, |t| t - 2.5))),
    (
        "Student t, 2 degrees",
        Odd::Sensor(|dice, x| {
            let scaled = |(x, e): (f64, f64), u: f64| x + 0.5 * SIZE * e / (-u.ln()).sqrt();
            let draws: Vec<f64> = (0..x.len()).map(|_| dice.unit().max(1e-12)).collect();
            sampled(x).zip(white(dice)).zip(draws).map(|(of, u)| scaled(of, u)).collect()
        }),
    ),
    ("encoder, steps of 8 %", Odd::Sensor(|_, x| sampled(x).map(|x| (x / 0.08).round() * 0.08).collect())),
    ("encoder, steps of 1 %", Odd::Sensor(|_, x| sampled(x).map(|x| (x / 0.01).round() * 0.01).collect())),
    (
        "in proportion",
        Odd::Sensor(|dice, x| sampled(x).zip(white(dice)).map(|(x, e)| x * (1.0 + SIZE * e)).collect()),
    ),
    (
        "0.5 % outliers of 20 sigma",
        Odd::Sensor(|dice, x| {
            let hit: Vec<f64> = (0..x.len()).map(|_| if dice.chance(0.005) { 20.0 } else { 1.0 }).collect();
            sampled(x).zip(white(dice)).zip(hit).map(|((x, e), by)| x + SIZE * e * by).collect()
        }),
    ),
    (
        "jitter of the clock",
        Odd::Sensor(|dice, x| {
            let moved: Vec<f64> = white(dice).take(x.len()).collect();
            let at = |k: usize| (k as f64 + moved[k]).round().clamp(0.0, (x.len() - 1) as f64) as usize;
            (0..x.len())
                .step_by(EVERY)
                .map(|k| x[at(k)])
                .zip(white(dice))
                .map(|(x, e)| x + SIZE * e)
                .collect()
        }),
    ),
    ("noise of the input, 3 %", Odd::Input(0.03)),
    (
        "a filter of 20 Hz",
        Odd::Sensor(|dice, x| {
            let follow = (-STEP * TAU * 20.0).exp();
            let mut held = x[0];
            let filtered: Vec<f64> = x
                .iter()
                .map(|x| {
                    held = follow * held + (1.0 - follow) * x;
                    held
                })
                .collect();
            sampled(&filtered).zip(white(dice)).map(|(x, e)| x + SIZE * e).collect()
        }),
    ),
    (
        "half a sample late",
        Odd::Sensor(|dice, x| {
            let late = (0..x.len()).step_by(EVERY).map(|k| x[k.saturating_sub(EVERY / 2)]);
            late.zip(white(dice)).map(|(x, e)| x + SIZE * e).collect()
        }),
    ),
    ("a slow force of a tenth", Odd::Force),
];

/// Every tenth value.
fn sampled(x: &[f64]) -> impl Iterator<Item = f64> {
    x.iter().step_by(EVERY).copied()
}

/// Normal numbers (Box and Muller).
pub(crate) fn white(dice: &mut Dice) -> impl Iterator<Item = f64> {
    let mut own = Dice::new(dice.seed(), "white");
    std::iter::repeat_with(move || (-2.0 * (1.0 - own.unit()).ln()).sqrt() * (TAU * own.unit()).cos())
}

/// A first-order process beside the motion.
fn coloured(dice: &mut Dice, x: &[f64], stays: f64, new: f64) -> Vec<f64> {
    let mut state = first_order(stays, new, 0.0);
    sampled(x).zip(white(dice)).map(|(x, e)| x + SIZE * state(e)).collect()
}

/// A first-order process by its white noise, of which `stays` stays from sample to sample.
pub(crate) fn first_order(stays: f64, new: f64, mut state: f64) -> impl FnMut(f64) -> f64 {
    move |e| {
        state = stays * state + new * e;
        state
    }
}

/// Something of the size of the noise beside it.
fn beside(dice: &mut Dice, x: &[f64], of: fn(f64) -> f64) -> Vec<f64> {
    let with = |(k, (x, e)): (usize, (f64, f64))| x + SIZE * (0.5 * e + of(k as f64 * STEP * EVERY as f64));
    sampled(x).zip(white(dice)).enumerate().map(with).collect()
}

/// The table of all kinds.
///
/// # Errors
/// A slider cannot be simulated.
pub(crate) fn table(args: &NoiseArgs, options: &Options) -> Result<Option<Table>> {
    let progress = Progress::new("noise", args.sets * KINDS.len(), options.quiet);
    let row = |(name, odd): &(&str, Odd)| -> Result<Vec<String>> {
        let of = |set: usize| {
            let found = found(name, odd, args.seed.unwrap_or(0), set);
            progress.step();
            found
        };
        let all: Vec<Option<Found>> = (0..args.sets).into_par_iter().map(of).collect::<Result<_>>()?;
        Ok(line(name, &all))
    };
    let rows: Vec<Vec<String>> = KINDS.iter().map(row).collect::<Result<_>>()?;
    drop(progress);
    let head = [
        "what is odd",
        "sets",
        "identified or named",
        "told",
        "k",
        "c",
        "Fc",
        "errors of k, c, Fc in standard errors",
        "half-widths",
    ];
    Ok((!interrupt::requested()).then(|| Table::new("noise", markdown(&head, &rows))))
}

/// What was found of a set.
struct Found {
    verdict: &'static str,
    doubted: bool,
    estimates: [Estimate; 3],
}

/// A set: the record of a slider, and what the program makes of it; `None` if the user stopped it, or nothing
/// was found.
fn found(name: &str, odd: &Odd, seed: u64, set: usize) -> Result<Option<Found>> {
    if interrupt::requested() {
        return Ok(None);
    }
    let mut dice = Dice::new(seed, &format!("noise {name} {set}"));
    let [a, b] = [dice.between(10.0, 16.0), dice.between(23.0, 32.0)];
    let force = if matches!(odd, Odd::Force) { "+ 0.6*cos(0.82*t) + 0.4*cos(1.9*t+1)" } else { "" };
    let text = format!(
        r#"(constants: {{ "m": (2.0, "kg"), "k": Find(start: 700.0, unit: "N/m", within: (10.0, 1e4)), "c": Find(start: 3.0, unit: "N*s/m", within: (0.0, 100.0)) }},
            states: {{ "x": "m", "v": "m/s" }}, inputs: {{ "F": "N" }}, known: {{ "x": "v", "v": "(F - k*x - c*v)/m" }}, inertia: {{ "v": "m" }},
            unknown: {{ "v": (factor: "-sgn(v)/m", candidates: ["1"]) }}, contacts: ["v"],
            data: [Synthetic(truth: {{ "v": "(-(800-k)*x - (1.5-c)*v - 1.2*sgn(v) {force})/m" }}, start: {{ "x": 0.01, "v": 0.0 }}, duration: 5.0, step: {STEP},
                measure: ["x"], inputs: {{ "F": Formula("6*cos({a}*t) + 4*cos({b}*t+1)") }})])"#
    );
    let mut loaded = open_text(&text, Path::new(name), &Request::default(), Purpose::Run)
        .map_err(|why| anyhow!("{name}, set {set}: {why}"))?;
    loaded.records = vec![measured(&loaded.records[0], odd, &mut dice)?];
    let found = loaded.identified(&LearnOptions::default(), &mut |_| ControlFlow::Continue(()));
    Ok(found.ok().and_then(|(_, found)| {
        let parameter =
            |name: &str| found.parameters.iter().find(|p| p.id.to_string() == name).map(|p| p.estimate);
        let friction = found.terms.first().map(|t| t.coefficient)?;
        let estimates = [parameter("k")?, parameter("c")?, friction];
        let doubted = found.warnings.iter().any(tells);
        Some(Found { verdict: word(&found), doubted, estimates })
    }))
}

/// Whether a warning tells of something that the model lacks.
fn tells(warning: &Warning) -> bool {
    warning.doubts_residual() || matches!(warning, Warning::Late { .. })
}

fn word(found: &Identified) -> &'static str {
    found.verdict.word()
}

/// The record that the sensors make of the exact one.
fn measured(exact: &Record, odd: &Odd, dice: &mut Dice) -> Result<Record> {
    let x = exact.columns[0].as_deref().unwrap_or_default();
    let size = standard_deviation(x);
    let scaled: Vec<f64> = x.iter().map(|x| x / size).collect();
    let column = match odd {
        Odd::Sensor(sensor) => sensor(dice, &scaled),
        Odd::Input(_) | Odd::Force => sampled(&scaled).zip(white(dice)).map(|(x, e)| x + SIZE * e).collect(),
    };
    let time: Vec<f64> = exact.time.iter().step_by(EVERY).copied().collect();
    let mut record = exact.clone();
    record.columns[0] = Some(column.into_iter().map(|x| x * size).collect());
    if let Odd::Input(part) = odd {
        let drive: Vec<f64> = time.iter().map(|&t| exact.inputs[0].value(t)).collect();
        let noise = part * standard_deviation(&drive);
        let drive: Vec<f64> = drive.into_iter().zip(white(dice)).map(|(f, e)| f + noise * e).collect();
        record.inputs[0] =
            Signal::new(time.clone().into(), drive, Interpolation::Cubic).map_err(|e| anyhow!("{e}"))?;
    }
    record.time = time.into();
    Ok(record)
}

/// A row of the table.
fn line(name: &str, all: &[Option<Found>]) -> Vec<String> {
    let seen: Vec<&Found> = all.iter().flatten().collect();
    let count = |of: &dyn Fn(&Found) -> bool| seen.iter().filter(|f| of(f)).count();
    let holds = |k: usize| {
        count(&|f| (f.estimates[k].ci95.0..=f.estimates[k].ci95.1).contains(&TRUTH[k].1)).to_string()
    };
    let mean =
        |of: &dyn Fn(&Found) -> f64| seen.iter().map(|f| of(f)).sum::<f64>() / seen.len().max(1) as f64;
    let error =
        |k: usize| mean(&|f| ((f.estimates[k].value - TRUTH[k].1) / f.estimates[k].std_error).powi(2)).sqrt();
    let width = |k: usize| mean(&|f| 50.0 * (f.estimates[k].ci95.1 - f.estimates[k].ci95.0) / TRUTH[k].1);
    vec![
        name.to_owned(),
        seen.len().to_string(),
        count(&|f| matches!(f.verdict, "identified" | "named")).to_string(),
        count(&|f| f.doubted || f.verdict == "named").to_string(),
        holds(0),
        holds(1),
        holds(2),
        format!("{:.1}, {:.1}, {:.1}", error(0), error(1), error(2)),
        format!("{:.2} %, {:.1} %, {:.1} %", width(0), width(1), width(2)),
    ]
}
