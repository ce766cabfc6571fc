//! How the time grows with samples, candidates and bodies. `bench/scaling.py` runs each case in a process of
//! its own, so that its peak memory is its own:
//!
//! ```text
//! cargo bench -p phisindy-learn --bench scaling -- fit 100000
//! ```
//!
//! Without a kind and a size: a small round of all kinds. A line says the kind, the size, the shortest time
//! in seconds, and (0 where there is none) the unknowns that it is about.

#![allow(clippy::print_stdout)] // its output is what it is for

#[path = "../tests/common/mod.rs"]
mod common;

use common::{load_text, prepare};
use phisindy_learn::{LearnOptions, StepOptions, identify, train};
use phisindy_phys::{Case, Origin, Record};
use phisindy_sim::{Automaton, Drive, Options, simulate, synthesize};
use std::ops::ControlFlow;
use std::time::Instant;

/// Samples of the records of which something else grows.
const SAMPLES: usize = 2000;
/// Runs go on until they took this many seconds together; the shortest counts.
const LONG_ENOUGH: f64 = 1.0;

/// The oscillator of case 1a.
const OSCILLATOR: &str = r#"(
    states: { "x": "", "y": "" },
    known: { "x": "y", "y": "-0.1*y - x + cos(0.3*t)" },
    unknown: { "y": (factor: "-sgn(y)", candidates: [CANDIDATES]) },
    contacts: ["y"],
    data: [ Synthetic(truth: { "y": "-0.5*sgn(y)" }, start: { "x": 0.1, "y": 0.1 }, duration: 50.0, step: 0.01, noise: Relative(0.1), seed: 42) ],
    learn: (selection: SELECTION),
)"#;

fn main() {
    let args: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    match args.as_slice() {
        [kind, size] => line(kind, size.parse().expect("a size: a whole number")),
        _ => {
            let round = [
                ("loss", 10_000),
                ("chain", 2),
                ("fit", 2_000),
                ("candidates", 5),
                ("run", 5),
                ("bodies", 2),
            ];
            round.into_iter().for_each(|(kind, size)| line(kind, size));
        }
    }
}

fn line(kind: &str, size: usize) {
    let (seconds, unknowns) = match kind {
        "loss" => loss(size),
        "chain" => chain_loss(size),
        "fit" => fit(size),
        "candidates" => candidates(size),
        "run" => run(size),
        "bodies" => bodies(size),
        other => panic!("`{other}` is none of loss, chain, fit, candidates, run, bodies"),
    };
    println!("scaling {kind} size={size} seconds={seconds:.3e} unknowns={unknowns}");
}

/// The shortest time of `work` in seconds.
fn shortest(mut work: impl FnMut()) -> f64 {
    let (begin, mut best) = (Instant::now(), f64::INFINITY);
    while best.is_infinite() || begin.elapsed().as_secs_f64() < LONG_ENOUGH {
        let begin = Instant::now();
        work();
        best = best.min(begin.elapsed().as_secs_f64());
    }
    best
}

fn oscillator(candidates: &str, selection: &str) -> String {
    OSCILLATOR.replace("CANDIDATES", candidates).replace("SELECTION", selection)
}

/// A case with its record, of so many samples: a spec may ask for two million, the libraries have no limit.
fn with_samples(text: &str, samples: usize) -> (Case, Vec<Record>) {
    let mut case = prepare(text, &[]);
    let Origin::Synthetic(truth) = &mut case.records[0].origin else { panic!("a measured record") };
    truth.duration = samples as f64 * truth.step;
    let (truth, plan) = (truth.clone(), &case.records[0]);
    let (record, _) = synthesize(plan, &truth, &case.system, None, &|_| Err("no files here".into())).unwrap();
    (case, vec![record])
}

/// One loss and gradient of the step method.
fn loss(samples: usize) -> (f64, usize) {
    let text = oscillator(r#""1", "x", "y", "x^2", "x*y", "y^2""#, "All");
    let (case, records) = with_samples(&text, samples);
    epoch(&case, &records, samples)
}

/// One loss and gradient of the step method for the friction levels of the chain.
fn chain_loss(bodies: usize) -> (f64, usize) {
    let (case, records) = load_text(&chain(bodies), &[]);
    epoch(&case, &records, SAMPLES * bodies)
}

/// The shortest time of an epoch, and its unknowns; `work` numbers have to be gone through in it.
fn epoch(case: &Case, records: &[Record], work: usize) -> (f64, usize) {
    let records: Vec<&Record> = records.iter().collect();
    // A training is told of its progress once in so many epochs: the time from word to word is theirs alone.
    let (mut times, mut last) = (Vec::new(), None::<(Instant, f64)>);
    let epochs = (20_000_000 / work).clamp(64, 4096) as u32;
    let options = StepOptions { epochs: vec![epochs], rates: vec![0.1], cutoff: 0.0, ..Default::default() };
    train(&case.system, &records, &options, &mut |part| {
        if let Some((then, before)) = last.replace((Instant::now(), part)) {
            times.push(then.elapsed().as_secs_f64() / ((part - before) * f64::from(epochs)));
        }
        ControlFlow::Continue(())
    });
    (times.into_iter().fold(f64::INFINITY, f64::min), case.system.terms.len())
}

/// The trajectory fit of one free run, its terms given: friction and two start values.
fn fit(samples: usize) -> (f64, usize) {
    let (case, records) = with_samples(&oscillator(r#""1""#, "All"), samples);
    (identified(&case, &records), 3)
}

/// A whole identification, with the choice of terms.
fn candidates(count: usize) -> (f64, usize) {
    let waves =
        (1..).flat_map(|k| ["x", "y"].map(|v| [format!("\"sin({k}*{v})\""), format!("\"cos({k}*{v})\"")]));
    let powers = ["1", "x", "y", "x^2", "x*y", "y^2"].map(|c| format!("\"{c}\""));
    let all: Vec<String> = powers.into_iter().chain(waves.flatten()).take(count).collect();
    let (case, records) = with_samples(&oscillator(&all.join(", "), "Auto"), SAMPLES);
    (identified(&case, &records), count)
}

fn identified(case: &Case, records: &[Record]) -> f64 {
    let work = || {
        let found =
            identify(case, records, &LearnOptions::default(), &mut |_| ControlFlow::Continue(())).unwrap();
        assert!((found.terms[0].coefficient.value - 0.5).abs() < 0.1, "{:?}", found.terms);
    };
    shortest(work)
}

/// A chain of masses between springs and dampers, each rubbing on the wall, pushed at the first one.
fn chain(bodies: usize) -> String {
    let each = |text: &dyn Fn(usize) -> String| (1..=bodies).map(text).collect::<Vec<_>>().join(", ");
    let x = |k: usize| if k == 0 || k > bodies { "0".to_owned() } else { format!("x{k}") };
    let y = |k: usize| if k == 0 || k > bodies { "0".to_owned() } else { format!("y{k}") };
    let force = |k: usize| {
        let (x0, x1, x2, y0, y1, y2) = (x(k - 1), x(k), x(k + 1), y(k - 1), y(k), y(k + 1));
        let push = format!("1.5*cos(0.6*t + {k})");
        format!("\"y{k}\": \"{x0} - 2*{x1} + {x2} + 0.1*({y0} - 2*{y1} + {y2}) + {push}\"")
    };
    format!(
        r#"( states: {{ {}, {} }}, known: {{ {}, {} }}, unknown: {{ {} }}, contacts: [{}],
             data: [ Synthetic(truth: {{ {} }}, start: {{ {}, {} }}, duration: 20.0, step: 0.01, noise: Additive(0.02), seed: 1) ],
             learn: (selection: All) )"#,
        each(&|k| format!("\"x{k}\": \"\"")),
        each(&|k| format!("\"y{k}\": \"\"")),
        each(&|k| format!("\"x{k}\": \"y{k}\"")),
        each(&force),
        each(&|k| format!("\"y{k}\": (factor: \"-sgn(y{k})\", candidates: [\"1\"])")),
        each(&|k| format!("\"y{k}\"")),
        each(&|k| format!("\"y{k}\": \"-0.3*sgn(y{k})\"")),
        each(&|k| format!("\"x{k}\": 0.0")),
        each(&|k| format!("\"y{k}\": 0.0")),
    )
}

/// One simulation of the chain with the derivatives by all start values and friction levels.
fn run(bodies: usize) -> (f64, usize) {
    let (case, records) = load_text(&chain(bodies), &[]);
    let terms: Vec<usize> = (0..case.system.terms.len()).collect();
    let automaton = Automaton::new(&case.system.model(&terms)).unwrap();
    let levels = vec![0.3; bodies];
    let drive = Drive { inputs: &[], parameters: &levels };
    let options =
        Options { tolerance: 1e-7, sensitivities: Some((0..bodies).collect()), ..Options::default() };
    let work = || {
        simulate(&automaton, &drive, 0.0, &vec![0.0; 2 * bodies], &records[0].time, &options).unwrap();
    };
    (shortest(work), 3 * bodies)
}

/// The trajectory fit of all friction levels and start values of the chain.
fn bodies(bodies: usize) -> (f64, usize) {
    let (case, records) = load_text(&chain(bodies), &[]);
    let work = || {
        let found =
            identify(&case, &records, &LearnOptions::default(), &mut |_| ControlFlow::Continue(())).unwrap();
        assert!(found.terms.iter().all(|t| (t.coefficient.value - 0.3).abs() < 0.1), "{:?}", found.terms);
    };
    (shortest(work), 3 * bodies)
}
