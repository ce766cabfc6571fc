//! Random rigs with laws of the catalogue: energy is accounted for, what sticks can be held, and the step
//! does not show.
//!

//! A few dozen in the ordinary tests; `PHISINDY_MODELS=1000` makes it a thousand.

use crate::random::{Acting, Dice, Place, Rig};
use phisindy_phys::Model;
use phisindy_sim::{Automaton, Drive, Options, SimError, Trajectory, simulate};

const MODELS: u64 = 40;

fn models() -> std::ops::Range<u64> {
    let wanted =
        std::env::var("PHISINDY_MODELS").ok().map(|n| n.parse().expect("PHISINDY_MODELS is a number"));
    0..wanted.unwrap_or(MODELS)
}

fn automaton(rig: &Rig) -> Automaton {
    let (names, rates) = (rig.names(), rig.rates(&|_| false));
    let (names, rates): (Vec<&str>, Vec<&str>) =
        (names.iter().map(String::as_str).collect(), rates.iter().map(String::as_str).collect());
    let model = Model::build(&names, &[], &[], &rates).unwrap();
    Automaton::new(&model).unwrap()
}

fn run(rig: &Rig, start: &[f64], times: &[f64], tolerance: f64) -> Result<Trajectory, SimError> {
    let options = Options { tolerance, max_steps: 200_000, ..Options::default() };
    simulate(&automaton(rig), &Drive { inputs: &[], parameters: &[] }, 0.0, start, times, &options)
}

fn row(run: &Trajectory, k: usize) -> &[f64] {
    &run.states[k * run.n..(k + 1) * run.n]
}

/// The force of a law at a state; a friction in the direction of `sign`, or of the velocity. (What sticks has
/// none, and whatever force, it does no work.)
fn force(law: &Acting, rig: &Rig, t: f64, state: &[f64], sign: Option<f64>) -> f64 {
    let n = rig.count();
    let (x, v) = (law.place.relative(&state[..n]), law.place.relative(&state[n..2 * n]));
    let z = law.internal.map_or(0.0, |k| state[2 * n + k]);
    law.force(t, x, v, sign.unwrap_or(v.signum()), z)
}

/// Power of everything but inertia and springs.
fn power(rig: &Rig, t: f64, state: &[f64]) -> f64 {
    let n = rig.count();
    let speed = |place: &Place| place.relative(&state[n..2 * n]);
    let drive = rig.push(t) * state[n + rig.drive.0];
    let dampers: f64 = rig.springs.iter().map(|(p, _, c)| c * speed(p).powi(2)).sum();
    let laws: f64 = rig.laws.iter().map(|l| force(l, rig, t, state, None) * speed(&l.place)).sum();
    drive - dampers - laws
}

#[test]
fn energy_is_accounted_for() {
    let (mut checked, mut events) = (0, 0);
    for seed in models() {
        let rig = Rig::draw(&mut Dice::new(seed));
        let coarse: Vec<f64> = (0..=3000).map(|k| rig.duration * f64::from(k) / 3000.0).collect();
        let Ok(first) = run(&rig, &rig.start, &coarse, 1e-10) else { continue };
        // The power has corners where something stops, turns, or meets a stop: a node at each, and one in the
        // middle of each interval for Simpson's rule. Near rest some friction goes with the logarithm of the
        // speed: nodes ever closer to each event.
        let near =
            |t: f64| (0..7).flat_map(move |j| [-1.0, 1.0].map(|side| t + side * 0.01 * 0.5_f64.powi(j)));
        let graded = first.events.iter().map(|e| e.time).chain([0.0]).flat_map(|t| near(t).chain([t]));
        let corners =
            graded.filter(|t| (0.0..rig.duration).contains(t)).chain(touches(&rig, &first, &coarse));
        let mut nodes: Vec<f64> = coarse.iter().copied().chain(corners).collect();
        nodes.sort_by(f64::total_cmp);
        nodes.dedup_by(|a, b| *a - *b < 1e-12);
        let times: Vec<f64> =
            nodes.windows(2).flat_map(|w| [w[0], 0.5 * (w[0] + w[1])]).chain(nodes.last().copied()).collect();
        let fine = run(&rig, &rig.start, &times, 1e-10)
            .unwrap_or_else(|e| panic!("model {seed}, sampled at its events: {e}\n{rig:?}"));
        let at = |k: usize| power(&rig, times[k], row(&fine, k));
        let (mut work, mut throughput) = (0.0, rig.energy(row(&fine, 0)));
        for k in (0..times.len() - 2).step_by(2) {
            let h = times[k + 2] - times[k];
            let part = h / 6.0 * (at(k) + 4.0 * at(k + 1) + at(k + 2));
            (work, throughput) = (work + part, throughput + part.abs());
            let gained = rig.energy(row(&fine, k + 2)) - rig.energy(row(&fine, 0));
            // Local errors of 1e-10 add up over thousands of steps, Simpson's are smaller.
            assert!(
                (gained - work).abs() < 1e-6 * (throughput + 1e-3),
                "model {seed} at {}: gained {gained}, work {work}, turned over {throughput}\n{rig:?}",
                times[k + 2]
            );
        }
        checked += 1;
        events += fine.events.len();
    }
    assert!(checked * 10 >= models().end * 9 && events > checked as usize, "{checked} runs, {events} events");
}

/// When a displacement passes the gap of a law, by the cubic through displacements and velocities of
/// neighbouring samples.
fn touches(rig: &Rig, run: &Trajectory, times: &[f64]) -> Vec<f64> {
    let n = rig.count();
    let gaps = rig.laws.iter().filter(|l| l.numbers.iter().any(|(name, _)| *name == "gap"));
    let sides = gaps.flat_map(|l| [1.0, -1.0].map(|side| (l.place, side * l.number("gap"))));
    let mut out = Vec::new();
    for (place, gap) in sides {
        for k in 0..times.len() - 1 {
            let at =
                |k: usize| (place.relative(&row(run, k)[..n]) - gap, place.relative(&row(run, k)[n..2 * n]));
            let (((a, da), (b, db)), h) = ((at(k), at(k + 1)), times[k + 1] - times[k]);
            if a * b >= 0.0 {
                continue;
            }
            let cubic = |u: f64| {
                let (p, q) = (u * u * (3.0 - 2.0 * u), u * (1.0 - u));
                a + (b - a) * p + h * q * (da * (1.0 - u) - db * u)
            };
            let (mut low, mut high) = (0.0, 1.0);
            for _ in 0..40 {
                let middle = 0.5 * (low + high);
                if cubic(middle) * a > 0.0 { low = middle } else { high = middle }
            }
            out.push(times[k] + low * h);
        }
    }
    out
}

/// Contacts of a rig: the law and its switch.
fn contacts<'a>(rig: &'a Rig, automaton: &Automaton) -> Vec<(&'a Acting, usize)> {
    let of = |law: &'a Acting| {
        let text = law.place.named("v");
        let switch = automaton.switches.iter().position(|s| s.text == text);
        (law, switch.unwrap_or_else(|| panic!("{text} is no switch")))
    };
    rig.laws.iter().filter(|l| l.holds()).map(of).collect()
}

/// Those with mode 0.
fn stuck<'a>(contacts: &[(&'a Acting, f64)]) -> Vec<&'a Acting> {
    contacts.iter().filter(|(_, mode)| *mode == 0.0).map(|(l, _)| *l).collect()
}

/// What each contact that sticks must bear so that none of them moves, `d (M^-1 (F - d' load)) = 0`, by
/// elimination; the others slip as their modes say.
fn loads(rig: &Rig, t: f64, state: &[f64], contacts: &[(&Acting, f64)]) -> Vec<f64> {
    let n = rig.count();
    let mut push = vec![0.0; n];
    push[rig.drive.0] = rig.push(t);
    let mut act = |place: &Place, force: f64| {
        (0..n).for_each(|i| push[i] += place.sign(i) * force);
    };
    for (place, k, c) in &rig.springs {
        act(place, k * place.relative(&state[..n]) + c * place.relative(&state[n..2 * n]));
    }
    for law in &rig.laws {
        let mode = contacts.iter().find(|(l, _)| std::ptr::eq(*l, law)).map(|(_, mode)| *mode);
        if mode != Some(0.0) {
            act(&law.place, force(law, rig, t, state, mode));
        }
    }
    let stuck: Vec<&Acting> = stuck(contacts);
    let free: Vec<f64> = push.iter().zip(&rig.mass).map(|(f, m)| f / m).collect();
    let m = stuck.len();
    let mut a: Vec<Vec<f64>> = (0..m)
        .map(|i| {
            let (p, row) = (stuck[i].place, 0..m);
            let mut row: Vec<f64> = row
                .map(|j| {
                    let q = stuck[j].place;
                    (0..n).map(|b| p.sign(b) * q.sign(b) / rig.mass[b]).sum::<f64>()
                })
                .collect();
            row.push(p.relative(&free));
            row
        })
        .collect();
    for i in 0..m {
        let pivot = (i..m).max_by(|&p, &q| a[p][i].abs().total_cmp(&a[q][i].abs())).unwrap();
        a.swap(i, pivot);
        for r in 0..m {
            if r != i {
                let f = a[r][i] / a[i][i];
                (i..=m).for_each(|c| a[r][c] -= f * a[i][c]);
            }
        }
    }
    (0..m).map(|i| a[i][m] / a[i][i]).collect()
}

#[test]
fn what_sticks_can_be_held_and_what_slips_goes_its_way() {
    let (mut stuck_samples, mut together) = (0, 0);
    for seed in models() {
        let rig = Rig::draw(&mut Dice::new(seed));
        let automaton = automaton(&rig);
        let contacts = contacts(&rig, &automaton);
        let times: Vec<f64> = (0..=1500).map(|k| rig.duration * f64::from(k) / 1500.0).collect();
        let Ok(run) = run(&rig, &rig.start, &times, 1e-10) else { continue };
        let (n, switches) = (rig.count(), automaton.switches.len());
        for (k, &t) in times.iter().enumerate() {
            let (state, modes) = (row(&run, k), &run.modes[k * switches..(k + 1) * switches]);
            let contacts: Vec<(&Acting, f64)> =
                contacts.iter().map(|(l, c)| (*l, f64::from(modes[*c]))).collect();
            let stuck = stuck(&contacts);
            for &(law, mode) in &contacts {
                let w = law.place.relative(&state[n..2 * n]);
                assert!(
                    // Two bodies that stick together both move: rounding.
                    if mode == 0.0 { w.abs() < 1e-13 } else { mode * w > -1e-9 },
                    "model {seed} at {t}: {} has mode {mode} and speed {w:e}\n{rig:?}",
                    law.place.named("v")
                );
            }
            stuck_samples += stuck.len();
            together += usize::from(stuck.len() > 1);
            for (law, load) in stuck.iter().zip(loads(&rig, t, state, &contacts)) {
                let (least, most) = law.hold(law.place.relative(&state[..n]));
                // A release is located to rounding; the states carry the error of the run.
                let slack = 1e-6;
                assert!(
                    least - slack <= load && load <= most + slack,
                    "model {seed} at {t}: {} of {} bears {load}, holds {least} to {most}\n{rig:?}",
                    law.id,
                    law.place.named("v")
                );
            }
        }
    }
    assert!(stuck_samples > 1000 && together > 100, "{stuck_samples} samples stuck, {together} together");
}

/// Relative change of what is perturbed.
const NUDGE: f64 = 1e-8;
/// Motions that magnify a nudge by more than this are compared until they do.
const WILD: f64 = 1e4;
/// Errors of a step are relative to its tolerance, and there are hundreds of steps.
const STEPS: f64 = 300.0;

/// The motion does not depend on the step: two tolerances differ by no more than the tolerance, times the
/// number of steps, times what the motion itself makes of a small change.
#[test]
fn the_step_does_not_show() {
    let (mut whole, mut worst) = (0, (0.0_f64, 0));
    let mut count = 0;
    for seed in models() {
        let rig = Rig::draw(&mut Dice::new(seed));
        let times: Vec<f64> = (0..=600).map(|k| rig.duration * f64::from(k) / 600.0).collect();
        let Ok(fine) = run(&rig, &rig.start, &times, 1e-11) else { continue };
        let coarse = run(&rig, &rig.start, &times, 1e-8).unwrap();
        let nudged = nudges(&rig)
            .into_iter()
            .map(|(rig, start)| run(&rig, &start, &times, 1e-11).unwrap())
            .collect::<Vec<_>>();
        let apart = |a: &Trajectory, b: &Trajectory, k: usize| {
            row(a, k).iter().zip(row(b, k)).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()))
        };
        let mut growth: f64 = 1.0;
        let mut all = true;
        for (k, t) in times.iter().enumerate() {
            growth = nudged.iter().map(|n| apart(n, &fine, k) / NUDGE).fold(growth, f64::max);
            if growth > WILD {
                all = false;
                break;
            }
            let apart = apart(&coarse, &fine, k);
            let ratio = apart / (1e-8 * growth);
            if ratio > worst.0 {
                worst = (ratio, seed);
            }
            assert!(
                ratio < STEPS,
                "model {seed} at {}: {apart:e} between tolerances, a nudge grows by {growth}\n{rig:?}",
                t
            );
        }
        whole += u64::from(all);
        count += 1;
    }
    assert!(whole * 10 >= count * 8, "{whole} of {count} compared to their end, worst {worst:?}");
}

/// Rigs a little different: in the start, in the drive, in the strength of each law.
fn nudges(rig: &Rig) -> Vec<(Rig, Vec<f64>)> {
    let mut out = Vec::new();
    for body in 0..2 * rig.count() {
        let mut start = rig.start.clone();
        start[body] += NUDGE;
        out.push((rig.clone(), start));
    }
    let mut other = rig.clone();
    other.drive.1.iter_mut().for_each(|l| l[0] *= 1.0 + NUDGE);
    out.push((other, rig.start.clone()));
    let mut other = rig.clone();
    other.laws.iter_mut().for_each(|l| l.numbers[0].1 *= 1.0 + NUDGE);
    out.push((other, rig.start.clone()));
    let mut other = rig.clone();
    other.springs.iter_mut().for_each(|s| s.1 *= 1.0 + NUDGE);
    out.push((other, rig.start.clone()));
    out
}
