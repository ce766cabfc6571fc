//! One epoch of the step method (loss and gradient of all samples, one update of RAdam) in microseconds, as `bench/race.py` reads it.
//! The shortest of many runs counts: whatever else the machine does can only make one longer.

#![allow(clippy::print_stdout)] // its output is what it is for

#[path = "../tests/common/mod.rs"]
mod common;

use phisindy_learn::{StepOptions, train};
use phisindy_phys::Record;
use std::ops::ControlFlow;
use std::time::Instant;

/// Epochs of one run, and runs.
const EPOCHS: u32 = 200;
const RUNS: usize = 25;

fn main() {
    for name in ["case1a", "case1b"] {
        let (case, records) = common::load(name, &[]);
        let records: Vec<&Record> = records.iter().collect();
        let run = |epochs: u32| {
            let options = StepOptions { epochs: vec![epochs], cutoff: 0.0, ..Default::default() };
            let begin = Instant::now();
            let fit = train(&case.system, &records, &options, &mut |_| ControlFlow::Continue(()));
            (begin.elapsed().as_secs_f64(), fit.operations)
        };
        let least = |epochs: u32| (0..RUNS).map(|_| run(epochs).0).fold(f64::INFINITY, f64::min);
        let epoch = (least(EPOCHS) - least(0)) / f64::from(EPOCHS);
        println!(
            "phisindy {name} samples={} instructions={} us_per_epoch={:.0}",
            records.iter().map(|r| r.len()).sum::<usize>(),
            run(0).1,
            1e6 * epoch
        );
    }
}
