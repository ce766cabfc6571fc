//! One epoch of the step method (loss and gradient of all samples, one update of RAdam) in microseconds, as
//! `bench/race.py` reads it; what part of the machine that uses; and the whole solve by Gauss-Newton. The
//! shortest of many runs counts: whatever else the machine does can only make one longer.

#![allow(clippy::print_stdout)] // its output is what it is for

#[path = "../tests/common/mod.rs"]
mod common;

use phisindy_expr::{Cost, wide};
use phisindy_learn::{StepFit, StepOptions, train};
use phisindy_phys::spec::Optimiser;
use phisindy_phys::{Case, Record};
use pulp::{Arch, Simd, WithSimd};
use std::hint::black_box;
use std::ops::ControlFlow;
use std::time::Instant;

/// Epochs of one run, and runs.
const EPOCHS: u32 = 200;
const RUNS: usize = 25;

fn main() {
    let threads = rayon::current_num_threads();
    let (peak, moved) = (on_all_threads(fused), on_all_threads(streamed));
    println!(
        "machine threads={threads} gflops={:.0} (fused products and sums) first_cache_gbytes_per_s={:.0} (two loads, one product, one store)",
        1e-9 * peak,
        1e-9 * moved
    );
    for name in ["case1a", "case1b"] {
        let (case, records) = common::load(name, &[]);
        let run = |epochs: u32| {
            timed(&case, &records, &StepOptions { epochs: vec![epochs], cutoff: 0.0, ..Default::default() })
        };
        let least = |epochs: u32| (0..RUNS).map(|_| run(epochs).0).fold(f64::INFINITY, f64::min);
        let epoch = (least(EPOCHS) - least(0)) / f64::from(EPOCHS);
        let samples: usize = records.iter().map(Record::len).sum();
        let Cost { instructions, flops, loads, stores } = run(0).1.cost;
        println!(
            "phisindy {name} samples={samples} instructions={instructions} us_per_epoch={:.0}",
            1e6 * epoch
        );
        // Forward and backward.
        let each_second = |count: usize| 2.0 * (samples * count) as f64 / epoch;
        let (arithmetic, bytes) = (each_second(flops), 8.0 * each_second(loads + stores));
        println!(
            "  {flops} operations, {loads} loads, {stores} stores per sample and direction: {:.1} GFLOP/s, {:.0} % of fused products and sums; {:.0} GB/s, {:.0} % of the first cache",
            1e-9 * arithmetic,
            100.0 * arithmetic / peak,
            1e-9 * bytes,
            100.0 * bytes / moved
        );
        let options = StepOptions { optimiser: Optimiser::GaussNewton, ..Default::default() };
        let solve = (0..RUNS).map(|_| timed(&case, &records, &options).0).fold(f64::INFINITY, f64::min);
        println!("  solve by Gauss-Newton, cuts included: {:.1} ms", 1e3 * solve);
    }
}

/// A training and how long it takes.
fn timed(case: &Case, records: &[Record], options: &StepOptions) -> (f64, StepFit) {
    let records: Vec<&Record> = records.iter().collect();
    let begin = Instant::now();
    let fit = train(&case.system, &records, options, &mut |_| ControlFlow::Continue(()));
    (begin.elapsed().as_secs_f64(), fit)
}

/// What all threads do together in a second, each in its best run.
fn on_all_threads(work: impl Fn() -> f64 + Sync) -> f64 {
    rayon::broadcast(|_| (0..RUNS).map(|_| work()).fold(0.0, f64::max)).into_iter().sum()
}

/// Rounds of a kernel: some milliseconds.
const ROUNDS: usize = 1_000_000;

/// Fused products and sums in a second that wait for nothing: each counts as two operations.
fn fused() -> f64 {
    struct Kernel;
    /// As many as hide how long one takes.
    const CHAINS: usize = 16;
    impl WithSimd for Kernel {
        type Output = usize;
        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> usize {
            let (a, b) = (simd.splat_f64s(black_box(0.999)), simd.splat_f64s(black_box(0.001)));
            let mut sums = [simd.splat_f64s(1.0); CHAINS];
            for _ in 0..ROUNDS {
                sums.iter_mut().for_each(|s| *s = simd.mul_add_f64s(*s, a, b));
            }
            black_box(sums);
            2 * S::F64_LANES * CHAINS * ROUNDS
        }
    }
    let begin = Instant::now();
    let operations = Arch::new().dispatch(Kernel);
    operations as f64 / begin.elapsed().as_secs_f64()
}

/// Bytes in a second between registers and the first cache, in products of lanes as a tape makes them: two
/// loads and a store each.
fn streamed() -> f64 {
    const LANES: usize = 64;
    /// Slots of a tape of middling size: 12 kB.
    const SLOTS: usize = 24;
    #[repr(align(64))]
    struct Slots([[f64; LANES]; SLOTS]);
    let (from, mut to) = (Slots([[1.0; LANES]; SLOTS]), Slots([[0.0; LANES]; SLOTS]));
    let rounds = ROUNDS / LANES;
    let begin = Instant::now();
    for _ in 0..rounds {
        wide(
            #[inline(always)]
            || {
                for k in 0..SLOTS {
                    let (a, b) = (&from.0[k], &from.0[(k + 1) % SLOTS]);
                    (0..LANES).for_each(|l| to.0[k][l] = a[l] * b[l]);
                }
            },
        );
        black_box(&mut to);
    }
    (3 * 8 * LANES * SLOTS * rounds) as f64 / begin.elapsed().as_secs_f64()
}
