//! Comparison with sums in twice the precision of a double.

use super::{FAR, cos, exp, ln, sin};

/// An unevaluated sum of two doubles (T. J. Dekker, Numer. Math. 18 (1971) 224-242).
#[derive(Clone, Copy)]
struct Double(f64, f64);

impl Double {
    fn from(a: f64) -> Double {
        Double(a, 0.0)
    }

    fn sum(a: f64, b: f64) -> Double {
        let s = a + b;
        let t = s - a;
        Double(s, (a - (s - t)) + (b - t))
    }

    fn add(self, b: Double) -> Double {
        let (s, t) = (Double::sum(self.0, b.0), Double::sum(self.1, b.1));
        let s = Double::sum(s.0, s.1 + t.0);
        Double::sum(s.0, s.1 + t.1)
    }

    fn mul(self, b: Double) -> Double {
        let p = self.0 * b.0;
        let e = self.0.mul_add(b.0, -p) + self.0 * b.1 + self.1 * b.0;
        Double::sum(p, e)
    }

    fn div(self, b: Double) -> Double {
        let q = self.0 / b.0;
        let rest = self.add(b.mul(Double(-q, 0.0)));
        let r = (rest.0 + rest.1) / b.0;
        Double::sum(q, r)
    }

    fn scaled(self, by: f64) -> Double {
        Double(self.0 * by, self.1 * by)
    }
}

const LN2: Double = Double(std::f64::consts::LN_2, 2.319_046_813_846_299_6e-17);
/// pi/2 in three doubles.
const HALF_PI: [f64; 3] =
    [std::f64::consts::FRAC_PI_2, 6.123_233_995_736_766e-17, -1.497_384_904_859_169_8e-33];

/// `sum x^k / k!` over the given powers, for small `x`; `signs` alternate for angles.
fn series(x: Double, first: u32, step: u32, sign: f64) -> Double {
    let mut term = Double::from(1.0);
    (1..=first).for_each(|_| term = term.mul(x));
    let (mut sum, mut k) = (term, first);
    while k < 40 {
        for _ in 0..step {
            k += 1;
            term = term.mul(x).div(Double::from(f64::from(k)));
        }
        term = term.scaled(sign);
        sum = sum.add(term);
    }
    sum
}

fn true_exp(x: f64) -> Double {
    let k = (x / LN2.0).round();
    let r = Double::from(x).add(LN2.mul(Double(-k, 0.0)));
    let y = series(r, 0, 1, 1.0);
    let half = (k / 2.0).round();
    y.scaled(half.exp2()).scaled((k - half).exp2())
}

fn true_ln(x: f64) -> Double {
    let y = Double::from(x.ln());
    // One step of Halley's method triples the digits.
    let e = true_exp(y.0);
    let x = Double::from(x);
    y.add(x.add(e.scaled(-1.0)).scaled(2.0).div(x.add(e)))
}

/// Sine, or cosine for `quarter` 1.
fn true_sine(x: f64, quarter: i64) -> Double {
    let k = (x / HALF_PI[0]).round();
    let part = |p: f64| Double::from(p).mul(Double(-k, 0.0));
    let r = Double::from(x).add(part(HALF_PI[0])).add(part(HALF_PI[1])).add(part(HALF_PI[2]));
    let turns = k as i64 + quarter;
    let y = if turns % 2 == 0 { series(r, 1, 2, -1.0) } else { series(r, 0, 2, -1.0) };
    if turns.rem_euclid(4) < 2 { y } else { y.scaled(-1.0) }
}

/// Error in units in the last place of the result.
fn ulps(got: f64, due: Double) -> f64 {
    let unit = f64::from_bits(due.0.abs().to_bits() + 1) - due.0.abs();
    ((got - due.0) - due.1).abs() / unit
}

/// Numbers in (0, 1), the same in every run.
fn scatter(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    ((*seed >> 11) as f64 + 0.5) / (1u64 << 53) as f64
}

/// The largest error over many numbers, and its argument.
fn worst(numbers: impl Fn(f64) -> f64, got: fn(f64) -> f64, due: impl Fn(f64) -> Double) -> (f64, f64) {
    let mut seed = 1;
    (0..100_000)
        .map(|_| numbers(scatter(&mut seed)))
        .map(|x| (ulps(got(x), due(x)), x))
        .fold((0.0, 0.0), |a, b| if b.0 > a.0 { b } else { a })
}

fn within_one(name: &str, found: (f64, f64)) {
    assert!(found.0 < 1.0, "{name}({:e}) is off by {:.3} units", found.1, found.0);
    assert!(found.0 > 0.3, "{name}: {:.3} is too good to have been tested", found.0);
}

#[test]
fn exponentials() {
    within_one("exp", worst(|u| 1400.0 * u - 700.0, exp, true_exp));
    within_one("exp", worst(|u| 2.0 * u - 1.0, exp, true_exp));
    assert_eq!([exp(0.0), exp(710.0), exp(-746.0), exp(f64::NEG_INFINITY)], [1.0, f64::INFINITY, 0.0, 0.0]);
    assert_eq!(exp(-745.0), 5e-324);
    assert!(exp(f64::NAN).is_nan());
}

#[test]
fn logarithms() {
    within_one("ln", worst(|u| (1400.0 * u - 700.0).exp(), ln, true_ln));
    within_one("ln", worst(|u| 0.5 + u, ln, true_ln));
    within_one("ln", worst(|u| 1.0 + 1e-6 * (u - 0.5), ln, true_ln));
    assert_eq!([ln(1.0), ln(0.0), ln(f64::INFINITY)], [0.0, f64::NEG_INFINITY, f64::INFINITY]);
    assert_eq!(ln(5e-324), -744.440_071_921_381_2);
    assert!(ln(-1.0).is_nan() && ln(f64::NAN).is_nan());
}

#[test]
fn sines_and_cosines() {
    for (name, function, quarter) in [("sin", sin as fn(f64) -> f64, 0), ("cos", cos, 1)] {
        for range in [1.0, 10.0, FAR] {
            within_one(name, worst(|u| range * (2.0 * u - 1.0), function, |x| true_sine(x, quarter)));
        }
        // Close to multiples of pi/2, where everything cancels.
        let near = |u: f64| (f64::floor(1e6 * u) * HALF_PI[0]) * (1.0 + 4e-16 * (u - 0.5).round());
        within_one(name, worst(near, function, |x| true_sine(x, quarter)));
        assert_eq!(function(1e10), if quarter == 0 { 1e10_f64.sin() } else { 1e10_f64.cos() });
        assert!(function(f64::INFINITY).is_nan() && function(f64::NAN).is_nan());
    }
    assert_eq!([sin(0.0), cos(0.0)], [0.0, 1.0]);
}
