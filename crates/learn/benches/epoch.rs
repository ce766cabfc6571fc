//! One epoch of the step method: loss and gradient of all samples, and an update.
#[path = "../tests/common/mod.rs"]
mod common;
use phisindy_learn::{StepOptions, train};
use phisindy_phys::Record;
use std::ops::ControlFlow;
use std::time::Instant;

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
        let none = (0..5).map(|_| run(0).0).fold(f64::INFINITY, f64::min);
        let best = (0..5).map(|_| run(1000).0).fold(f64::INFINITY, f64::min);
        println!("{name}: {} operations, {:.1} us an epoch, {:.1} ms before", run(0).1, (best - none) * 1e3, none * 1e3);
    }
}
