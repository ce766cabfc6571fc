use super::*;
use crate::test_signals::*;

const ALL: [Differentiator; 3] =
    [Differentiator::SavitzkyGolay, Differentiator::Spline, Differentiator::Spectral];

fn error(found: &[f64], truth: &[f64]) -> f64 {
    rms(found.iter().zip(truth).map(|(a, b)| a - b))
}

fn column(time: &[f64], f: impl Fn(f64) -> f64) -> Vec<f64> {
    time.iter().map(|&t| f(t)).collect()
}

fn uniform_grid(n: u32, step: f64) -> Vec<f64> {
    (0..n).map(|i| f64::from(i) * step).collect()
}

/// Steps between 0.55 and 1.45 of the mean.
fn uneven_grid(n: u32, step: f64) -> Vec<f64> {
    (0..n).map(|i| step * (f64::from(i) + 0.3 * (1.5 * f64::from(i)).sin())).collect()
}

/// The rig's twin with the noise of its lasers. Measured: 3.4e-5, 1.9e-5, 1.4e-5 m/s for local cubics,
/// 4.8e-5, 2.3e-5, 2.0e-5 for the spline, 4.3e-5, 2.1e-5, 1.6e-5 for the Fourier series; the speed's rms is
/// 16, 2.3 and 1.0 mm/s.
#[test]
fn the_rig_twin_is_differentiated_to_a_hundredth_of_a_millimetre_per_second() {
    for (amplitude, omega, stops, limits) in [
        (0.886e-3, 13.5, false, [4.0e-5, 5.5e-5, 5.0e-5]),
        (0.443e-3, 5.897, true, [2.3e-5, 2.8e-5, 2.6e-5]),
        (0.443e-3, 2.948, true, [1.8e-5, 2.4e-5, 1.9e-5]),
    ] {
        let (time, x, v) = rig_twin(amplitude, omega);
        let stuck = v.iter().filter(|v| **v == 0.0).count() as f64 / v.len() as f64;
        assert_eq!(stuck > 0.45, stops, "the twin itself: {stuck}");
        for (how, limit) in ALL.into_iter().zip(limits) {
            let found = differentiate(&time, &noisy(&x, 1e-6, 3), how).unwrap();
            let wrong = error(&found.derivative, &v);
            assert!(wrong < limit, "{how:?} at {omega}: {wrong:e}, {}", found.smoothing);
            assert!(
                (0.8..1.8).contains(&(wrong / found.std_error)),
                "{how:?}: {wrong:e} of {:e}",
                found.std_error
            );
            assert!(error(&found.values, &x) < 3e-7, "{how:?} at {omega}");
        }
    }
}

#[test]
fn clean_data_are_not_smoothed() {
    let time = uniform_grid(2000, 0.01);
    let (x, v) = (column(&time, |t| (3.0 * t).sin()), column(&time, |t| 3.0 * (3.0 * t).cos()));
    let local = automatic(&time, &x).unwrap();
    // Cubics on five samples: h^4/30 of the fifth derivative in their middle, a few times more for those that
    // lean.
    let inside = 20..1980;
    let worst = inside.clone().fold(0.0_f64, |m, i| m.max((local.derivative[i] - v[i]).abs()));
    assert!(worst < 0.15 * 0.01_f64.powi(4) * 3f64.powi(5), "{worst:e}, {}", local.smoothing);
    assert!(error(&local.derivative, &v) < 1e-6);
    // The other two do not know the curvature at the ends; away from them they are exact too.
    for (how, limit) in [(Differentiator::Spline, 1e-6), (Differentiator::Spectral, 1e-3)] {
        let found = differentiate(&time, &x, how).unwrap();
        let wrong = error(&found.derivative[200..1800], &v[200..1800]);
        assert!(wrong < limit, "{how:?} {wrong:e} {}", found.smoothing);
    }
}

#[test]
fn a_cubic_is_exact_on_any_grid() {
    for time in [uniform_grid(300, 0.02), uneven_grid(300, 0.02)] {
        let (x, v) = (column(&time, |t| 5.0 - t + t.powi(3)), column(&time, |t| -1.0 + 3.0 * t * t));
        let found = automatic(&time, &x).unwrap();
        let worst = found.derivative.iter().zip(&v).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
        assert!(worst < 1e-9, "{worst:e} {}", found.smoothing);
    }
}

#[test]
fn an_uneven_grid_costs_little_accuracy() {
    let f = |t: f64| (2.0 * t).sin() + 0.3 * (7.0 * t).cos();
    let df = |t: f64| 2.0 * (2.0 * t).cos() - 2.1 * (7.0 * t).sin();
    for (how, limit) in ALL.into_iter().zip([0.009, 0.017, 0.014]) {
        let wrong = [uniform_grid(3000, 0.005), uneven_grid(3000, 0.005)].map(|time| {
            let found = differentiate(&time, &noisy(&column(&time, f), 1e-3, 5), how).unwrap();
            error(&found.derivative, &column(&time, df))
        });
        assert!(wrong[0] < limit && wrong[1] < 1.3 * wrong[0], "{how:?} {wrong:?}");
    }
}

/// A rough encoder: 6e-4 rad at 150 Hz, at rest for 2 s, then moving with corners. The plain difference
/// quotient is off by 0.04 rad/s.
#[test]
fn a_quantised_encoder() {
    let time = uniform_grid(1500, 1.0 / 150.0);
    let angle = |t: f64| 0.5 * (1.0 - (1.5 * t).cos()) + 0.1 * ((6.0 * t).cos() - 1.0);
    let speed = |t: f64| 0.75 * (1.5 * t).sin() - 0.6 * (6.0 * t).sin();
    let moving = |t: f64| (t - 2.0).max(0.0);
    let read = column(&time, |t| (angle(moving(t)) / 6e-4).round() * 6e-4);
    for (how, limit) in ALL.into_iter().zip([2.3e-3, 4e-3, 3.2e-3]) {
        let found = differentiate(&time, &read, how).unwrap();
        let wrong = error(&found.derivative, &column(&time, |t| speed(moving(t))));
        assert!(wrong < limit, "{how:?} {wrong:e} {}", found.smoothing);
    }
}

#[test]
fn the_stated_error_of_the_spline_is_that_of_repeated_noise() {
    let time = uniform_grid(400, 1.0);
    let slopes: Vec<f64> = (0..40)
        .flat_map(|seed| {
            let found = differentiate(
                &time,
                &noisy(&column(&time, |t| (0.02 * t).sin()), 0.1, seed),
                Differentiator::Spline,
            );
            let found = found.unwrap();
            found.derivative[50..350]
                .iter()
                .enumerate()
                .map(move |(i, d)| {
                    let truth = 0.02 * (0.02 * (i + 50) as f64).cos();
                    (d - truth) / found.std_error
                })
                .collect::<Vec<_>>()
        })
        .collect();
    // Bias comes on top of the noise.
    let ratio = rms(slopes.into_iter());
    assert!((0.9..1.6).contains(&ratio), "{ratio}");
}

#[test]
fn short_odd_and_bad_columns() {
    for how in ALL {
        for n in 5..40 {
            for time in [uniform_grid(n, 0.1), uneven_grid(n, 0.1)] {
                let found = differentiate(&time, &column(&time, |t| 2.0 - 3.0 * t), how).unwrap();
                assert_eq!((found.values.len(), found.derivative.len()), (n as usize, n as usize));
                assert!(
                    found.derivative.iter().all(|d| (d + 3.0).abs() < 1e-6),
                    "{how:?} {n} {:?}",
                    found.derivative
                );
                let flat = differentiate(&time, &column(&time, |_| 0.0), how).unwrap();
                assert!(flat.derivative.iter().all(|d| *d == 0.0), "{how:?} {n}");
            }
        }
        // Times that nearly coincide, and a gap: nothing to differentiate well, but an answer.
        let mut time = uniform_grid(100, 0.1);
        time[50] = time[49] + 1e-13;
        time.iter_mut().skip(70).for_each(|t| *t += 1e4);
        let found = differentiate(&time, &noisy(&vec![0.0; 100], 1.0, 1), how).unwrap();
        assert!(found.derivative.iter().all(|d| d.is_finite()), "{how:?}");
        assert_eq!(
            differentiate(&[0.0; 4], &[0.0; 4], how),
            Err(SignalError::TooShort { samples: 4, needed: 5 })
        );
        assert_eq!(
            differentiate(&[0.0, 1.0, 2.0, 2.0, 3.0], &[0.0; 5], how),
            Err(SignalError::NotIncreasing { index: 3 })
        );
    }
}
