//! Motions with known velocity, and noise, for tests.

/// Standard normal numbers: SplitMix64 and the method of Box and Muller.
pub fn gaussian(count: usize, seed: u64) -> Vec<f64> {
    let mut state = seed.wrapping_mul(0x2545_f491_4f6c_dd1d);
    let mut uniform = || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    };
    (0..count)
        .map(|_| {
            let radius = (-2.0 * (1.0 - uniform()).ln()).sqrt();
            radius * (std::f64::consts::TAU * uniform()).cos()
        })
        .collect()
}

/// A mass on a spring and damper with dry friction on the ground: `x'' = drive(t) - c x' - k x - friction sgn
/// x'`.
pub struct Slider {
    pub c: f64,
    pub k: f64,
    pub friction: f64,
    pub substeps: usize,
}

impl Slider {
    /// Displacement and velocity every `step`, by many small steps. A reversal within a small step is tested
    /// for sticking.
    pub fn run(&self, drive: impl Fn(f64) -> f64, step: f64, count: usize) -> (Vec<f64>, Vec<f64>) {
        let h = step / self.substeps as f64;
        let (mut x, mut v) = (0.0_f64, 0.0_f64);
        let (mut xs, mut vs) = (Vec::new(), Vec::new());
        for i in 0..count {
            xs.push(x);
            vs.push(v);
            for j in 0..self.substeps {
                let t = (i * self.substeps + j) as f64 * h;
                let free = drive(t + 0.5 * h) - self.k * (x + 0.5 * h * v);
                let sign = if v != 0.0 { v.signum() } else { free.signum() };
                if v == 0.0 && free.abs() <= self.friction {
                    continue;
                }
                let accelerate = |v: f64| free - self.c * v - self.friction * sign;
                let next = v + h * accelerate(v + 0.5 * h * accelerate(v));
                let next = if next * sign < 0.0 { 0.0 } else { next };
                x += 0.5 * h * (v + next);
                v = next;
            }
        }
        (xs, vs)
    }
}

/// A simulation of the laboratory rig (cases 8-10): base `amplitude cos(omega t)`, 2 kHz, 10 s. Returns time,
/// x and x'.
pub fn rig_twin(amplitude: f64, omega: f64) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let (c, k) = (0.0658, 386.36);
    let slider = Slider { c, k, friction: 0.0856, substeps: 20 };
    let drive = move |t: f64| amplitude * (k * (omega * t).cos() - c * omega * (omega * t).sin());
    let (x, v) = slider.run(drive, 5e-4, 20_000);
    ((0..20_000).map(|i| f64::from(i) * 5e-4).collect(), x, v)
}

/// A small version of case 1 of the paper: stick-slip under forcing similar to `cos t`, 5000 samples at 0.01
/// s.
pub fn stick_slip() -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let slider = Slider { c: 0.2, k: 1.0, friction: 0.5, substeps: 100 };
    let (x, v) = slider.run(|t| (0.6 * t).cos(), 0.01, 5000);
    ((0..5000).map(|i| f64::from(i) * 0.01).collect(), x, v)
}

pub fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0), |(sum, count), v| (sum + v * v, count + 1));
    f64::sqrt(sum / f64::from(count.max(1)))
}

pub fn noisy(values: &[f64], sigma: f64, seed: u64) -> Vec<f64> {
    values.iter().zip(gaussian(values.len(), seed)).map(|(v, z)| v + sigma * z).collect()
}
