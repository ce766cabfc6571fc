//! The linear response of the known part: how a force over the true motion changes the measured columns.

use super::rig::Rig;

/// The known part, discretised for forces that are linear between samples.
pub(super) struct Linear {
    n: usize,
    masses: usize,
    /// Derivatives of the rates by the states, row-major, and one over each mass.
    rates: Vec<f64>,
    mobility: Vec<f64>,
    /// One step of the states, row-major.
    step: Vec<f64>,
    /// For each mass: the response to the force at the beginning of a step, and to its change.
    force: Vec<(Vec<f64>, Vec<f64>)>,
}

impl Linear {
    /// The known part of a rig without its drive.
    pub(super) fn new(rig: &Rig, step: f64) -> Linear {
        let (masses, n) = (rig.count(), 2 * rig.count());
        let mut rates = vec![0.0; n * n];
        let mut pull = |row: usize, column: usize, k: f64, c: f64| {
            rates[(masses + row) * n + column] += k / rig.mass[row];
            rates[(masses + row) * n + masses + column] += c / rig.mass[row];
        };
        let (k, c) = (&rig.spring, &rig.damper);
        pull(0, 0, -k[0], -c[0]);
        if masses == 2 {
            for (row, column, sign) in [(0, 0, -1.0), (0, 1, 1.0), (1, 0, 1.0), (1, 1, -1.0)] {
                pull(row, column, sign * k[1], sign * c[1]);
            }
            if rig.both_walls() {
                pull(1, 1, -k[2], -c[2]);
            }
        }
        (0..masses).for_each(|i| rates[i * n + masses + i] = 1.0);
        let mobility = rig.mass.iter().map(|m| 1.0 / m).collect();
        let mut linear = Linear { n, masses, rates: rates.clone(), mobility, step: vec![], force: vec![] };
        for mass in 0..masses {
            // The force and its slope as two more states.
            let m = n + 2;
            let mut wide = vec![0.0; m * m];
            (0..n).for_each(|i| (0..n).for_each(|j| wide[i * m + j] = rates[i * n + j] * step));
            wide[(masses + mass) * m + n] = step / rig.mass[mass];
            wide[n * m + n + 1] = 1.0;
            let all = exponential(&wide, m);
            let column = |j: usize| (0..n).map(|i| all[i * m + j]).collect();
            linear.force.push((column(n), column(n + 1)));
            linear.step = (0..n * n).map(|e| all[e / n * m + e % n]).collect();
        }
        linear
    }

    /// The response at rest to forces on masses: columns of the states, then the accelerations.
    pub(super) fn response(&self, forces: &[(usize, f64)], values: &[f64]) -> Vec<Vec<f64>> {
        self.run(vec![0.0; self.n], forces, values)
    }

    /// The response to a state at the beginning.
    pub(super) fn start(&self, state: usize, samples: usize) -> Vec<Vec<f64>> {
        let mut x = vec![0.0; self.n];
        x[state] = 1.0;
        self.run(x, &[], &vec![0.0; samples])
    }

    fn run(&self, mut x: Vec<f64>, forces: &[(usize, f64)], values: &[f64]) -> Vec<Vec<f64>> {
        let n = self.n;
        let (mut begin, mut change) = (vec![0.0; n], vec![0.0; n]);
        for &(mass, sign) in forces {
            for i in 0..n {
                begin[i] += sign * self.force[mass].0[i];
                change[i] += sign * self.force[mass].1[i];
            }
        }
        let mut out = vec![Vec::with_capacity(values.len()); n + self.masses];
        let mut next = vec![0.0; n];
        for (k, f) in values.iter().enumerate() {
            out.iter_mut().zip(&x).for_each(|(column, x)| column.push(*x));
            for mass in 0..self.masses {
                let row = &self.rates[(self.masses + mass) * n..][..n];
                let pulled: f64 = row.iter().zip(&x).map(|(a, x)| a * x).sum();
                let pushed: f64 = forces.iter().filter(|(m, _)| *m == mass).map(|(_, sign)| sign * f).sum();
                out[n + mass].push(pulled + pushed * self.mobility[mass]);
            }
            let d = values.get(k + 1).unwrap_or(f) - f;
            for i in 0..n {
                let row = &self.step[i * n..(i + 1) * n];
                next[i] = row.iter().zip(&x).map(|(a, x)| a * x).sum::<f64>() + begin[i] * f + change[i] * d;
            }
            x.copy_from_slice(&next);
        }
        out
    }
}

/// The exponential of a small matrix, by scaling and squaring of a Taylor series.
fn exponential(matrix: &[f64], n: usize) -> Vec<f64> {
    let size = matrix.iter().fold(0.0_f64, |m, x| m.max(x.abs())) * n as f64;
    let halvings = size.max(1e-9).log2().ceil().max(0.0) as i32 + 4;
    let small: Vec<f64> = matrix.iter().map(|x| x / 2f64.powi(halvings)).collect();
    let product = |a: &[f64], b: &[f64]| -> Vec<f64> {
        (0..n * n).map(|e| (0..n).map(|k| a[e / n * n + k] * b[k * n + e % n]).sum()).collect()
    };
    let one: Vec<f64> = (0..n * n).map(|e| f64::from(u8::from(e / n == e % n))).collect();
    let mut sum = one.clone();
    let mut term = one;
    for k in 1..14 {
        term = product(&term, &small).into_iter().map(|x| x / f64::from(k)).collect();
        sum.iter_mut().zip(&term).for_each(|(s, t)| *s += t);
    }
    for _ in 0..halvings {
        sum = product(&sum, &sum);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exponential_of_a_rotation() {
        let e = exponential(&[0.0, 3.0, -3.0, 0.0], 2);
        for (have, want) in e.iter().zip([3f64.cos(), 3f64.sin(), -3f64.sin(), 3f64.cos()]) {
            assert!((have - want).abs() < 1e-12);
        }
    }
}
