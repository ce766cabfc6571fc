//! Least squares by inner products of columns.

/// The inner product.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Takes off the part along a direction of length one.
pub(super) fn remove(from: &mut [f64], direction: &[f64]) {
    let share = dot(from, direction);
    from.iter_mut().zip(direction).for_each(|(x, d)| *x -= share * d);
}

/// Gram and Schmidt; what is nothing new becomes zero.
pub(super) fn orthonormal(columns: &mut [Vec<f64>]) {
    for k in 0..columns.len() {
        let (done, rest) = columns.split_at_mut(k);
        let before = dot(&rest[0], &rest[0]);
        // Twice is enough.
        for _ in 0..2 {
            done.iter().for_each(|d| remove(&mut rest[0], d));
        }
        let after = dot(&rest[0], &rest[0]);
        let scale = if after > 1e-14 * before && after > 0.0 { 1.0 / after.sqrt() } else { 0.0 };
        rest[0].iter_mut().for_each(|x| *x *= scale);
    }
}

/// How much of the target's square some columns explain, from products of columns of length one. Columns that
/// add nothing new are left out.
pub(super) fn explained(products: &[Vec<f64>], loads: &[f64], chosen: &[usize]) -> f64 {
    let n = chosen.len();
    let mut factor = vec![0.0; n * n];
    let mut sum = 0.0;
    let mut solved = vec![0.0; n];
    for i in 0..n {
        let mut load = loads[chosen[i]];
        for j in 0..=i {
            let (high, low) = (chosen[i].max(chosen[j]), chosen[i].min(chosen[j]));
            let mut entry = products[high][low];
            entry -= (0..j).map(|k| factor[i * n + k] * factor[j * n + k]).sum::<f64>();
            if j < i {
                factor[i * n + j] = if factor[j * n + j] > 0.0 { entry / factor[j * n + j] } else { 0.0 };
                load -= factor[i * n + j] * solved[j];
            } else if entry > 1e-9 {
                factor[i * n + i] = entry.sqrt();
                solved[i] = load / factor[i * n + i];
                sum += solved[i] * solved[i];
            }
        }
    }
    sum
}
