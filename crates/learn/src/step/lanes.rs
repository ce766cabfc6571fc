//! Sums over the data: kept for each lane and added in the order of the data, so that the number of threads
//! does not change a bit.

/// Samples per block.
pub(crate) const LANES: usize = 64;

/// One number for each sample of a block.
pub(crate) type Lane = [f64; LANES];

/// Adds up what the threads summed, in the order of the data: the same bits for any number of threads.
pub(crate) fn in_order(partial: Vec<Vec<f64>>, size: usize) -> Vec<f64> {
    let mut total = vec![0.0; size];
    for sums in partial {
        total.iter_mut().zip(sums).for_each(|(t, s)| *t += s);
    }
    total
}

/// Adds one residual lane to `[loss, triangle of J^T J, J^T e]`, lane by lane.
#[inline(always)]
pub(crate) fn accumulate<'a>(error: &Lane, column: impl Fn(usize) -> &'a Lane, p: usize, sums: &mut [Lane]) {
    let dot = |a: &Lane, b: &Lane, sum: &mut Lane| (0..LANES).for_each(|l| sum[l] += a[l] * b[l]);
    dot(error, error, &mut sums[0]);
    let mut at = 1;
    for i in 0..p {
        for j in i..p {
            dot(column(i), column(j), &mut sums[at]);
            at += 1;
        }
    }
    for i in 0..p {
        dot(column(i), error, &mut sums[at + i]);
    }
}
