use super::*;

fn case4(gamma: f64) -> Multisine {
    Multisine::jonswap(10.0, 0.5, gamma, 0.1, 50.0, 0.1, 3).unwrap()
}

fn variance(m: &Multisine) -> f64 {
    m.amplitudes().iter().map(|a| a * a / 2.0).sum()
}

#[test]
fn without_peak_enhancement_the_variance_is_the_closed_integral() {
    // The integral of A w^-5 exp(-B w^-4) from a to b is [exp(-B w^-4)]/(4B).
    let (hs, tp) = (10.0_f64, 0.5_f64);
    let (a, b) = (320.0 * (hs / (tp * tp)).powi(2), 1.25 * (TAU / tp).powi(4));
    let exact = a / (4.0 * b) * ((-b / 50.05_f64.powi(4)).exp() - (-b / 0.05_f64.powi(4)).exp());
    assert!((variance(&case4(1.0)) / exact - 1.0).abs() < 1e-5);
}

#[test]
fn with_gamma_3_3_the_height_is_the_significant_height() {
    let m = case4(3.3);
    assert_eq!((m.omegas().len(), m.omegas()[0]), (500, 0.1));
    assert!((m.omegas()[499] - 50.0).abs() < 1e-12);
    assert!((4.0 * variance(&m).sqrt() / 10.0 - 1.0).abs() < 0.01);
    let peak = m.amplitudes().iter().zip(m.omegas()).max_by(|p, q| p.0.total_cmp(q.0)).unwrap().1;
    assert!((peak - TAU / 0.5).abs() < 0.1);
    // One hand-computed line on each side of the peak: w = 12 and 13, wp = 12.566370614359172.
    let line = |i: usize| m.amplitudes()[i].powi(2) / (2.0 * 0.1);
    for (index, w, sigma) in [(119, 12.0_f64, 0.07), (129, 13.0, 0.09)] {
        let wp = 12.566_370_614_359_172_f64;
        let s = 320.0
            * 1600.0
            * w.powi(-5)
            * (-1.25 * (wp / w).powi(4)
                + 3.3_f64.ln() * (-(w - wp).powi(2) / (2.0 * sigma * sigma * wp * wp)).exp())
            .exp();
        assert!((line(index) / s - 1.0).abs() < 1e-10, "{w}");
    }
}

#[test]
fn a_band_has_its_rms_over_a_common_period() {
    let m = Multisine::band(0.7, 1.0, 2.0, 11, 5).unwrap();
    // All frequencies are multiples of 0.1 Hz: the mean square over 10 s is exact on any grid above Nyquist.
    let values = m.values_on_grid(0.0, 0.01, 1000);
    let rms = (values.iter().map(|v| v * v).sum::<f64>() / 1000.0).sqrt();
    assert!((rms - 0.7).abs() < 1e-12);
    let outside = [0.9, 2.1].map(|f| {
        let (re, im) = values.iter().enumerate().fold((0.0, 0.0), |(re, im), (i, v)| {
            let angle = TAU * f * 0.01 * i as f64;
            (re + v * angle.cos(), im + v * angle.sin())
        });
        f64::hypot(re, im) / 1000.0
    });
    assert!(outside.iter().all(|power| *power < 1e-12));
}

#[test]
fn the_slope_is_the_derivative_of_the_value() {
    let m = case4(3.3);
    for t in [0.0, 1.234, 47.9] {
        let h = 1e-4;
        let five = (m.value(t - 2.0 * h) - 8.0 * m.value(t - h) + 8.0 * m.value(t + h)
            - m.value(t + 2.0 * h))
            / (12.0 * h);
        assert!((m.slope(t) / five - 1.0).abs() < 1e-7, "{t}");
    }
}

#[test]
fn the_grid_agrees_with_the_exact_value() {
    let m = case4(3.3);
    let total: f64 = m.amplitudes().iter().sum();
    let (start, step) = (-3.0, 0.005);
    for (i, v) in m.values_on_grid(start, step, 10_001).into_iter().enumerate() {
        assert!((v - m.value(start + i as f64 * step)).abs() < 1e-13 * total, "{i}");
    }
    let one = Multisine::new([(2.0, TAU, 0.0)]);
    assert!((one.max_abs(0.25, 1.0, 0.25) - 2.0).abs() < 1e-12);
    assert!((one.max_abs(0.1, 0.4, 0.15) - 2.0 * (0.2 * std::f64::consts::PI).cos()).abs() < 1e-12);
    assert_eq!(one.max_abs(0.0, 1.0, 0.0), 0.0);
}

#[test]
fn the_seed_decides_the_phases_and_they_are_uniform() {
    assert_eq!(case4(3.3), case4(3.3));
    let other = Multisine::jonswap(10.0, 0.5, 3.3, 0.1, 50.0, 0.1, 4).unwrap();
    assert_ne!(other.phases(), case4(3.3).phases());
    let many = Multisine::band(1.0, 1.0, 2.0, 100_000, 1).unwrap();
    for harmonic in 1..4 {
        let (c, s) = many.phases().iter().fold((0.0, 0.0), |(c, s), p| {
            (c + (f64::from(harmonic) * p).cos(), s + (f64::from(harmonic) * p).sin())
        });
        // Each sum has variance n/2.
        assert!(c.abs().max(s.abs()) < 4.5 * (50_000f64).sqrt());
    }
}

#[test]
fn bad_parameters_are_named() {
    let jonswap = |tp, hi, dw| Multisine::jonswap(1.0, tp, 3.3, 0.1, hi, dw, 0).map(|_| ());
    assert_eq!(
        jonswap(0.0, 1.0, 0.1),
        Err(ExcitationError::NotPositive { parameter: "the peak period", value: 0.0 })
    );
    assert_eq!(jonswap(1.0, 0.05, 0.1), Err(ExcitationError::EmptyBand { low: 0.1, high: 0.05 }));
    assert!(matches!(jonswap(1.0, 50.0, 1e-9), Err(ExcitationError::Count(_))));
    assert!(matches!(jonswap(f64::NAN, 1.0, 0.1), Err(ExcitationError::NotPositive { .. })));
    assert!(matches!(Multisine::band(1.0, 1.0, 2.0, 0, 0), Err(ExcitationError::Count(_))));
}

/// One wrong number at a time, and its message.
#[test]
fn every_bad_parameter_is_told_by_its_name() {
    let jonswap =
        |hs, tp, gamma, low, high, step| Multisine::jonswap(hs, tp, gamma, low, high, step, 0).unwrap_err();
    let band = |rms, low, high, count| Multisine::band(rms, low, high, count, 0).unwrap_err();
    for (error, told) in [
        (jonswap(-1.0, 0.5, 3.3, 0.1, 50.0, 0.1), "the significant height must be a positive number, not -1"),
        (jonswap(1.0, 0.0, 3.3, 0.1, 50.0, 0.1), "the peak period must be a positive number, not 0"),
        (jonswap(1.0, 0.5, f64::NAN, 0.1, 50.0, 0.1), "gamma must be a positive number, not NaN"),
        (jonswap(1.0, 0.5, 3.3, 0.1, 50.0, 0.0), "the frequency step must be a positive number, not 0"),
        (jonswap(1.0, 0.5, 3.3, 0.0, 50.0, 0.1), "the lowest frequency must be a positive number, not 0"),
        (
            jonswap(1.0, 0.5, 3.3, 0.1, f64::INFINITY, 0.1),
            "the highest frequency must be a positive number, not inf",
        ),
        (jonswap(1.0, 0.5, 3.3, 2.0, 1.0, 0.1), "the band from 2 to 1 is empty"),
        (band(0.0, 1.0, 2.0, 3), "the rms must be a positive number, not 0"),
        (band(1.0, 2.0, 1.0, 3), "the band from 2 to 1 is empty"),
        (band(1.0, 1.0, 2.0, 200_000), "200000 sines asked for; 1 to 100000 are possible"),
    ] {
        assert_eq!(error.to_string(), told);
    }
}

#[test]
fn a_single_sine_sits_in_the_middle_of_its_band() {
    let one = Multisine::band(0.7, 1.0, 3.0, 1, 5).unwrap();
    assert_eq!(one.omegas(), [TAU * 2.0]);
    // The standard deviation of a sine is its amplitude over root 2.
    assert!((one.amplitudes()[0] - 0.7 * 2f64.sqrt()).abs() < 1e-15);
}
