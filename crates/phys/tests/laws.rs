//! What the laws of the catalogue are, asked of their graphs, against their values at random points.

use phisindy_expr::{Id, Parity, Scratch, Tape};
use phisindy_phys::{BUILT_IN, Law, LawEntry};

/// Points at which each law is evaluated.
const POINTS: usize = 3000;

/// Numbers between 0 and 1, always the same ones (splitmix64).
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.roll()
    }
}

fn catalogue() -> Vec<LawEntry> {
    BUILT_IN.iter().map(|(id, text)| LawEntry::read(id, text).expect("a law of the catalogue")).collect()
}

/// Force and rates of a law at random points, once as they are and once with some symbols turned: `(speed,
/// values, turned)`.
fn sampled(law: &Law, turned: &[Id]) -> Vec<(f64, Vec<f64>, Vec<f64>)> {
    let of = law.nodes();
    let roots: Vec<Id> = of.force.into_iter().chain(of.rates.iter().copied()).collect();
    let symbols: Vec<Id> = {
        let mut graph = of.graph.clone();
        graph.symbols(&roots).into_iter().map(|s| graph.symbol(s)).collect()
    };
    let mut scratch =
        Scratch::<1>::new(&Tape::compile(&of.graph, &symbols, &roots).expect("its own symbols"));
    let mut dice = Dice(7);
    let mut out = Vec::new();
    for _ in 0..POINTS {
        let at: Vec<f64> = symbols
            .iter()
            .map(|id| match of.parameters.iter().position(|p| p == id) {
                Some(k) => {
                    let (low, high) = law.parameters[k].1.within;
                    let size = 10_f64.powf(dice.between(-3.0, 3.0));
                    let sign = if dice.roll() < 0.5 { 1.0 } else { -1.0 };
                    (sign * size).clamp(low, high)
                }
                None => dice.between(-4.0, 4.0),
            })
            .collect();
        let speed = symbols
            .iter()
            .position(|id| Some(*id) == of.velocity)
            .map_or_else(|| dice.between(-4.0, 4.0), |k| at[k]);
        let mut values = |turn: bool| -> Vec<f64> {
            let sign = |id: &Id| if turn && turned.contains(id) { -1.0 } else { 1.0 };
            scratch.at(symbols.iter().zip(&at).map(|(id, x)| sign(id) * x));
            (0..roots.len()).map(|k| scratch.output(k)[0]).collect()
        };
        let (values, opposite) = (values(false), values(true));
        if values.iter().chain(&opposite).all(|x| x.is_finite()) {
            out.push((speed, values, opposite));
        }
    }
    assert!(out.len() > POINTS / 2, "most points have a value");
    out
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * (a.abs() + b.abs())
}

#[test]
fn parity_and_dissipation_are_those_of_the_values() {
    for LawEntry { id, law, .. } in catalogue() {
        let of = law.nodes();
        if of.force.is_none() {
            assert_eq!((law.parity(), law.dissipates()), (None, None), "{id} is no force");
            continue;
        }
        let motion: Vec<Id> =
            of.displacement.into_iter().chain(of.velocity).chain(of.internal.clone()).collect();
        let points = sampled(&law, &motion);
        let all = |same: &dyn Fn(f64, f64) -> bool| {
            points.iter().all(|(_, a, b)| a.iter().zip(b).all(|(a, b)| same(*a, *b)))
        };
        match law.parity() {
            Some(Parity::Odd) => assert!(all(&|a, b| near(a, -b)), "{id} is odd"),
            Some(Parity::Even) => assert!(all(&|a, b| near(a, b)), "{id} is even"),
            None => {}
        }
        let largest = points.iter().fold(0.0_f64, |most, (v, f, _)| most.max((f[0] * v).abs()));
        let gives = points.iter().any(|(v, force, _)| force[0] * v < -1e-9 * largest);
        match law.dissipates() {
            Some(true) => assert!(!gives, "{id} takes energy"),
            Some(false) => assert!(gives, "{id} gives energy"),
            None => {}
        }
    }
}

/// What cannot be told is told of no force that a textbook knows: a change of this list is a change of the
/// catalogue.
#[test]
fn the_catalogue_is_what_textbooks_say() {
    let laws = catalogue();
    let of = |holds: &dyn Fn(&Law) -> bool| -> Vec<&str> {
        laws.iter().filter(|e| holds(&e.law)).map(|e| e.id.as_str()).collect()
    };
    assert_eq!(
        of(&|law| law.dissipates() == Some(true)),
        [
            "asymmetric-coulomb",
            "breakaway",
            "coulomb",
            "digressive-damping",
            "geared-stribeck",
            "load-dependent-friction",
            "power-law-damping",
            "stribeck"
        ]
    );
    // With memory it stores energy; a drift of unknown duration may turn the sign.
    let unknown = |law: &Law| law.nodes().force.is_some() && !law.has_memory() && law.dissipates().is_none();
    assert_eq!(of(&unknown), ["drifting-friction"]);
    assert_eq!(of(&|law| law.parity() == Some(Parity::Even)), ["quadratic-stiffness"]);
    assert_eq!(
        of(&|law| law.nodes().force.is_some() && law.parity().is_none()),
        [
            "asymmetric-coulomb",
            "bilinear-damping",
            "bilinear-stiffness",
            "cogging",
            "harmonic-force",
            "offset",
            "one-sided-stop",
            "position-dependent-friction"
        ]
    );
}
