use super::*;
use crate::autocorrelation::effective_samples;
use crate::test_signals::{gaussian, noisy, rig_twin, rms, stick_slip};

fn deviation(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    rms(values.iter().map(|v| v - mean))
}

/// Statistical spread for 5000 samples is 1 to 1.5 %; the mean over seeds shows the bias.
#[test]
fn stick_slip_with_additive_noise() {
    let (_, x, v) = stick_slip();
    for column in [&x, &v] {
        for share in [0.02, 0.2] {
            let sigma = share * deviation(column);
            let ratios: Vec<f64> =
                (1..=40).map(|seed| noise_level(&noisy(column, sigma, seed)) / sigma - 1.0).collect();
            let bias = ratios.iter().sum::<f64>() / 40.0;
            assert!(bias.abs() < 0.006, "{share}: bias {bias}");
            assert!(rms(ratios.iter().copied()) < 0.018, "{share}: {:?}", ratios);
        }
    }
}

#[test]
fn a_micrometre_on_the_rig() {
    let (_, x, _) = rig_twin(0.443e-3, 2.948);
    for seed in 1..=5 {
        let level = noise_level(&noisy(&x, 1e-6, seed));
        assert!((level / 1e-6 - 1.0).abs() < 0.02, "{level:e}");
    }
}

#[test]
fn clean_data_have_no_noise() {
    let (_, x, _) = stick_slip();
    let (_, y, _) = rig_twin(0.443e-3, 5.897);
    let sine = |n: u32| (0..n).map(|i| 7.0 + (0.05 * f64::from(i)).sin()).collect::<Vec<f64>>();
    for column in [x, y, sine(50), sine(250), sine(5000)] {
        let level = noise_level(&column);
        assert!(level < 1e-6 * deviation(&column), "{} samples: {:e}", column.len(), level);
    }
}

#[test]
fn short_records_and_lines_and_steps() {
    let swing = |n: u32| (0..n).map(|i| (0.1 * f64::from(i)).sin()).collect::<Vec<f64>>();
    // 100 samples: 1.2/sqrt(n) and the correlation of the differences.
    let short: Vec<f64> = (1..=50).map(|seed| noise_level(&noisy(&swing(100), 0.01, seed)) / 0.01).collect();
    let mean = short.iter().sum::<f64>() / 50.0;
    assert!((mean - 1.0).abs() < 0.08 && short.iter().all(|r| (0.6..1.6).contains(r)), "{mean} {short:?}");
    // A line in the upper band, mains hum say, is motion, not noise.
    let hum: Vec<f64> = noisy(&swing(5000), 0.01, 3)
        .iter()
        .enumerate()
        .map(|(i, v)| v + 0.1 * (2.5 * i as f64).sin())
        .collect();
    assert!((noise_level(&hum) / 0.01 - 1.0).abs() < 0.04, "{}", noise_level(&hum));
    // Quantisation of a moving signal.
    let steps: Vec<f64> = swing(5000).iter().map(|v| (v / 1e-3).round() * 1e-3).collect();
    assert!((noise_level(&steps) / (1e-3 / 12f64.sqrt()) - 1.0).abs() < 0.1);
}

#[test]
fn no_column_panics() {
    for n in 0..300 {
        let found = noise_level(&vec![1.0; n]);
        assert_eq!(found, 0.0, "{n}");
        assert!(noise_level(&gaussian(n, 1)).is_finite());
        let effective = effective_samples(&vec![2.5; n]);
        assert_eq!(effective, n as f64);
    }
    assert!(noise_level(&[f64::NAN; 10]).is_nan() && effective_samples(&[f64::INFINITY]).is_nan());
}

/// First-order autoregression: the exact inflation is (1 + a)/(1 - a).
#[test]
fn effective_samples_of_coloured_noise() {
    let n = 40_000;
    for a in [0.0_f64, 0.5, 0.9, 0.98] {
        let mut last = 0.0;
        let residual: Vec<f64> = gaussian(n, 2)
            .into_iter()
            .map(|z| {
                last = a * last + (1.0 - a * a).sqrt() * z;
                last
            })
            .collect();
        let exact = n as f64 * (1.0 - a) / (1.0 + a);
        let found = effective_samples(&residual);
        assert!((found / exact - 1.0).abs() < 0.15, "{a}: {found} for {exact}");
    }
    let alternating: Vec<f64> = (0..1000).map(|i| if i % 2 == 0 { 1.0 } else { -1.0 }).collect();
    assert_eq!(effective_samples(&alternating), 1000.0);
}

/// A block of the spectrum that stands out by chance does not end the flat part.
#[test]
fn the_level_of_short_records() {
    let motion: Vec<f64> = (0..1412).map(|i| 10.0 * (0.05 * f64::from(i)).sin()).collect();
    let off = |seed| noise_level(&noisy(&motion, 1.0, seed)).ln().abs();
    let worst = (1..=2000).map(off).fold(0.0, f64::max);
    // 2.5 % is what 1412 samples give at best; the worst of 2000 may be three and a half of that.
    assert!(worst < 0.1, "off by {worst}");
}

/// A friction tester: the force steps from one side to the other at each turn of the motion.
#[test]
fn steps_of_a_force_are_no_noise() {
    let noise = noisy(&vec![0.0; 6000], 1.0, 7);
    let side = |i: usize| (0.01 * i as f64 + 3e-6 * (i * i) as f64).sin().signum();
    let column: Vec<f64> = noise.iter().enumerate().map(|(i, e)| 60.0 * side(i) + e).collect();
    let (with, without) = (noise_level(&column), noise_level(&noise));
    assert!((with - without).abs() < 0.1 * without, "{with} instead of {without}");
}

/// A logger that loses rows moves the motion from sample to sample more than its noise does.
#[test]
fn lost_rows_are_no_noise() {
    let (time, x, _) = stick_slip();
    let sigma = 1e-3 * deviation(&x);
    for share in [0.01, 0.05] {
        let ratios: Vec<f64> = (1..=20)
            .map(|seed| {
                let column = noisy(&x, sigma, seed);
                let kept: Vec<usize> = gaussian(x.len(), 100 + seed)
                    .iter()
                    .enumerate()
                    .filter(|(_, g)| erf_share(**g) > share)
                    .map(|(k, _)| k)
                    .collect();
                let (t, c): (Vec<f64>, Vec<f64>) = kept.iter().map(|&k| (time[k], column[k])).unzip();
                noise_level_at(&t, &c) / sigma
            })
            .collect();
        let mean = ratios.iter().sum::<f64>() / 20.0;
        assert!((mean - 1.0).abs() < 0.1, "{share}: {mean} {ratios:?}");
    }
}

/// The part of normal numbers below `x`, by the logistic approximation: good to 0.01.
fn erf_share(x: f64) -> f64 {
    1.0 / (1.0 + (-1.702 * x).exp())
}
