use super::*;
use std::f64::consts::TAU;

/// A grid whose steps differ by a factor of three.
fn uneven(n: usize) -> Arc<[f64]> {
    (0..n).map(|i| 0.05 * (i as f64 + 0.25 * (1.7 * i as f64).sin())).collect()
}

fn signal(time: &Arc<[f64]>, f: impl Fn(f64) -> f64, kind: Interpolation) -> Signal {
    Signal::new(time.clone(), time.iter().map(|&t| f(t)).collect(), kind).unwrap()
}

#[test]
fn a_cubic_polynomial_is_its_own_spline() {
    let (f, df) = (|t: f64| 1.0 - t + 2.0 * t * t - 3.0 * t.powi(3), |t: f64| -1.0 + 4.0 * t - 9.0 * t * t);
    for n in [4, 5, 40] {
        let spline = signal(&uneven(n), f, Interpolation::Cubic);
        let (start, end) = (spline.time()[0], spline.time()[n - 1]);
        for k in 0..=100 {
            let t = start + (end - start) * k as f64 / 100.0;
            assert!((spline.value(t) - f(t)).abs() < 1e-11, "{n} {t}");
            assert!((spline.slope(t) - df(t)).abs() < 1e-10, "{n} {t}");
        }
    }
    let parabola = signal(&uneven(3), |t| t * t, Interpolation::Cubic);
    assert!((parabola.slope(0.06) - 0.12).abs() < 1e-14);
}

#[test]
fn a_sine_at_twenty_samples_a_period() {
    let time: Arc<[f64]> = (0..=200).map(|i| f64::from(i) / 20.0).collect();
    let spline = signal(&time, |t| (TAU * t).sin(), Interpolation::Cubic);
    let (mut value, mut slope) = (0.0_f64, 0.0_f64);
    for k in 0..=5000 {
        let t = 1.0 + 8.0 * f64::from(k) / 5000.0;
        value = value.max((spline.value(t) - (TAU * t).sin()).abs());
        slope = slope.max((spline.slope(t) - TAU * (TAU * t).cos()).abs() / TAU);
    }
    // h^4/384 of the fourth derivative; the slope of the Hermite cubic is off by h^3/(72 sqrt 3) in the
    // middle.
    let h = TAU / 20.0;
    assert!(value < 1.15 * h.powi(4) / 384.0 && value > 0.5 * h.powi(4) / 384.0, "{value:e}");
    assert!(slope < 1.15 * h.powi(3) / (72.0 * 3f64.sqrt()), "{slope:e}");
}

#[test]
fn the_slope_is_the_derivative_of_the_value() {
    let time = uneven(30);
    for kind in [Interpolation::Hold, Interpolation::Linear, Interpolation::Cubic] {
        let s = signal(&time, |t| (9.0 * t).sin() + t, kind);
        for k in 0..400 {
            let t = -0.2 + 0.0047 * f64::from(k) + 1.3e-4;
            if time.iter().any(|&knot| (knot - t).abs() < 2e-6) {
                continue;
            }
            let difference = (s.value(t + 1e-6) - s.value(t - 1e-6)) / 2e-6;
            assert!((s.slope(t) - difference).abs() < 1e-7, "{kind:?} {t}");
        }
    }
}

#[test]
fn a_hint_changes_nothing_but_the_cost() {
    let s = signal(&uneven(50), |t| (5.0 * t).cos(), Interpolation::Cubic);
    let mut hint = 7;
    for k in 0..2000 {
        let t = 1.3 + 1.6 * (0.013 * f64::from(k)).sin() * f64::from(k % 3 - 1);
        assert_eq!(s.value_and_slope(t, &mut hint), (s.value(t), s.slope(t)));
    }
}

#[test]
fn samples_are_returned_and_the_outside_is_as_documented() {
    let time: Arc<[f64]> = Arc::from([0.0, 0.1, 0.3, 0.7, 0.8]);
    let values = vec![1.0, -2.0, 0.3, 0.1, 0.5];
    for kind in [Interpolation::Hold, Interpolation::Linear, Interpolation::Cubic] {
        let s = Signal::new(time.clone(), values.clone(), kind).unwrap();
        for (t, v) in time.iter().zip(&values) {
            assert!((s.value(*t) - v).abs() < 1e-15, "{kind:?}");
        }
        let (before, after) = match kind {
            Interpolation::Hold => (1.0, 0.5),
            _ => (1.0 - 2.0 * s.slope(0.0), 0.5 + 2.0 * s.slope(0.8)),
        };
        assert!((s.value(-2.0) - before).abs() < 1e-12 && (s.value(2.8) - after).abs() < 1e-12, "{kind:?}");
    }
    let held = Signal::new(time, values, Interpolation::Hold).unwrap();
    assert_eq!(held.value(0.29), -2.0);
    assert!(held.value(f64::NAN).is_nan());
}

#[test]
fn bad_samples_are_named() {
    let make = |t: &[f64], v: &[f64]| Signal::new(Arc::from(t), v.to_vec(), Interpolation::Cubic).map(|_| ());
    assert_eq!(make(&[], &[]), Err(SignalError::TooShort { samples: 0, needed: 1 }));
    assert_eq!(make(&[0.0], &[]), Err(SignalError::LengthMismatch { times: 1, values: 0 }));
    assert_eq!(make(&[0.0, 1.0, 1.0], &[0.0; 3]), Err(SignalError::NotIncreasing { index: 2 }));
    assert_eq!(make(&[0.0, 1.0], &[0.0, f64::NAN]), Err(SignalError::NotFinite { index: 1 }));
    assert_eq!(make(&[3.0], &[2.0]), Ok(()));
}

#[test]
fn one_sample_is_a_constant_and_two_are_a_line() {
    for kind in [Interpolation::Hold, Interpolation::Linear, Interpolation::Cubic] {
        let one = Signal::new(Arc::from([1.0]), vec![3.0], kind).unwrap();
        for t in [-5.0, 1.0, 7.0] {
            assert_eq!((one.value(t), one.slope(t)), (3.0, 0.0), "{kind:?} {t}");
        }
    }
    let line = Signal::new(Arc::from([0.0, 2.0]), vec![1.0, 5.0], Interpolation::Cubic).unwrap();
    for t in [-1.0, 0.0, 0.7, 2.0, 3.0] {
        assert!(
            (line.value(t) - (1.0 + 2.0 * t)).abs() < 1e-14 && (line.slope(t) - 2.0).abs() < 1e-14,
            "{t}"
        );
    }
}

#[test]
fn samples_that_are_no_signal_are_told() {
    let said = |time: &[f64], values: &[f64]| {
        Signal::new(Arc::from(time), values.to_vec(), Interpolation::Linear).unwrap_err().to_string()
    };
    assert_eq!(said(&[], &[]), "0 samples, but at least 1 are needed");
    assert_eq!(said(&[0.0, 1.0], &[1.0]), "2 times but 1 values");
    assert_eq!(said(&[0.0, 1.0], &[1.0, f64::NAN]), "sample 1 is not a finite number");
    assert_eq!(said(&[0.0, 1.0, 1.0], &[0.0; 3]), "the time of sample 2 is not later than the one before it");
}
