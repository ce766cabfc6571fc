//! Products of the rows of `J`: `J^T J` and `J^T e`, gathered from many rows at a time.

use phisindy_expr::wide;

/// Columns are taken by whole vectors.
const VECTOR: usize = 8;
/// Rows that are gathered before they are multiplied: they and the tiles of the matrix stay in the caches.
const BATCH: usize = 64;
/// Rows of a tile whose sums are held together.
const TILE: usize = 4;

/// `J^T J` (upper triangle) and `J^T e`; for the meat of a sandwich each row is multiplied by its residual.
pub(crate) struct Products {
    count: usize,
    /// `count`, rounded up to whole vectors: what is beyond is zero.
    width: usize,
    meat: bool,
    /// For a meat: the inverse of `J^T J`, by which each residual is divided by `1 - h`, `h` the leverage of
    /// its row.
    inverse: Option<Vec<f64>>,
    rows: Vec<f64>,
    residuals: Vec<f64>,
    matrix: Vec<f64>,
    gradient: Vec<f64>,
}

impl Products {
    /// Of rows of `count` numbers.
    pub(crate) fn new(count: usize, meat: bool) -> Products {
        // Where nothing is free there still are rows.
        let width = count.max(1).next_multiple_of(VECTOR);
        Products {
            count,
            width,
            meat,
            inverse: None,
            rows: Vec::with_capacity(BATCH * width),
            residuals: Vec::with_capacity(BATCH),
            matrix: vec![0.0; width * width],
            gradient: vec![0.0; width],
        }
    }

    /// For the meat of a sandwich: the inverse of the whole `J^T J`, row by row. The residual of a row that
    /// decides much is small, for the fit goes through it; divided by `1 - h` it is what the fit without that
    /// row would leave there (HC3, MacKinnon and White, Journal of Econometrics 29 (1985) 305-325).
    pub(crate) fn with_leverage(self, inverse: Vec<f64>) -> Products {
        Products { inverse: Some(inverse), ..self }
    }

    /// The next row, of zeros, for this residual.
    pub(crate) fn row(&mut self, residual: f64) -> &mut [f64] {
        if self.residuals.len() == BATCH {
            self.multiply();
        }
        self.residuals.push(residual);
        let from = self.rows.len();
        self.rows.resize(from + self.width, 0.0);
        &mut self.rows[from..][..self.count]
    }

    /// Adds those of other rows.
    pub(crate) fn add(&mut self, mut other: Products) {
        self.multiply();
        other.multiply();
        self.matrix.iter_mut().zip(&other.matrix).for_each(|(a, b)| *a += b);
        self.gradient.iter_mut().zip(&other.gradient).for_each(|(a, b)| *a += b);
    }

    /// All rows multiplied: the element of the matrix in its upper triangle, and the gradient.
    pub(crate) fn finish(&mut self) -> (impl Fn(usize, usize) -> f64, &[f64]) {
        self.multiply();
        let (matrix, width) = (&self.matrix, self.width);
        (move |a: usize, b: usize| matrix[a * width + b], &self.gradient[..self.count])
    }

    fn multiply(&mut self) {
        wide(
            #[inline(always)]
            || self.multiply_batch(),
        );
        self.rows.clear();
        self.residuals.clear();
    }

    /// Each sum is taken in the order of the rows. Vectors of columns that are zero in all rows are left out:
    /// a start state or a friction level that nothing has coupled to these samples yet.
    #[inline(always)]
    fn multiply_batch(&mut self) {
        let Products { count, width, meat, inverse, rows, residuals, matrix, gradient } = self;
        for (row, &e) in rows.chunks_exact_mut(*width).zip(&*residuals) {
            if *meat {
                let h = inverse.as_ref().map_or(0.0, |inverse| leverage(&row[..*count], inverse));
                let e = e / (1.0 - h).max(f64::EPSILON.sqrt());
                row.iter_mut().for_each(|j| *j *= e);
            }
            gradient.iter_mut().zip(&*row).for_each(|(g, j)| *g += j * e);
        }
        let mut sizes = vec![0.0; *width];
        for row in rows.chunks_exact(*width) {
            sizes.iter_mut().zip(row).for_each(|(size, j)| *size += j.abs());
        }
        let rows = rows.as_chunks::<VECTOR>().0;
        let vectors = *width / VECTOR;
        let sizes = sizes.as_chunks::<VECTOR>().0;
        let used: Vec<usize> = (0..vectors).filter(|&v| sizes[v] != [0.0; VECTOR]).collect();
        for (k, &left) in used.iter().enumerate() {
            for first in [0, TILE] {
                for &right in &used[k..] {
                    let at = |i: usize| (left * VECTOR + first + i) * vectors + right;
                    let tiles = matrix.as_chunks_mut::<VECTOR>().0;
                    let mut sums: [[f64; VECTOR]; TILE] = std::array::from_fn(|i| tiles[at(i)]);
                    for row in rows.chunks_exact(vectors) {
                        let (left, right) = (&row[left], &row[right]);
                        for (i, sum) in sums.iter_mut().enumerate() {
                            let factor = left[first + i];
                            (0..VECTOR).for_each(|l| sum[l] += factor * right[l]);
                        }
                    }
                    (0..TILE).for_each(|i| tiles[at(i)] = sums[i]);
                }
            }
        }
    }
}

/// `j^T A^-1 j`.
fn leverage(row: &[f64], inverse: &[f64]) -> f64 {
    let along = |line: &[f64]| line.iter().zip(row).map(|(a, j)| a * j).sum::<f64>();
    row.iter().zip(inverse.chunks_exact(row.len().max(1))).map(|(j, line)| j * along(line)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// More rows than a batch, columns that are not whole vectors, and a vector of columns that is zero at
    /// first.
    #[test]
    fn products_are_those_of_the_definition() {
        for (count, rows, meat) in [(3, 5, false), (21, 150, false), (21, 150, true), (8, 64, false)] {
            let entry = |r: usize, c: usize| {
                if c >= 8 && r < 70 { 0.0 } else { ((r * 31 + c * 17) as f64).sin() }
            };
            let residual = |r: usize| ((r * 7) as f64).cos();
            let mut products = Products::new(count, meat);
            for r in 0..rows {
                let row = products.row(residual(r));
                row.iter_mut().enumerate().for_each(|(c, j)| *j = entry(r, c));
            }
            let mut parts = Products::new(count, meat);
            parts.add(products);
            let (matrix, gradient) = parts.finish();
            let scale = |r: usize| if meat { residual(r) } else { 1.0 };
            for (a, &slope) in gradient.iter().enumerate() {
                for b in a..count {
                    let due: f64 = (0..rows).map(|r| scale(r).powi(2) * entry(r, a) * entry(r, b)).sum();
                    assert_relative_eq!(matrix(a, b), due, epsilon = 1e-12, max_relative = 1e-12);
                }
                let due: f64 = (0..rows).map(|r| scale(r) * entry(r, a) * residual(r)).sum();
                assert_relative_eq!(slope, due, epsilon = 1e-12, max_relative = 1e-12);
            }
        }
    }

    /// Two rows, of which the second alone tells the second number: its leverage is one, and its residual is
    /// divided by nearly nothing. The first shares its number with a third.
    #[test]
    fn a_residual_is_what_the_fit_without_its_row_leaves() {
        let rows = [([1.0, 0.0], 0.2), ([3.0, 0.0], -0.1), ([0.0, 2.0], 0.0)];
        let mut products = Products::new(2, true).with_leverage(vec![0.1, 0.0, 0.0, 0.25]);
        for (row, e) in rows {
            products.row(e).copy_from_slice(&row);
        }
        let (matrix, _) = products.finish();
        // Leverages 0.1, 0.9 and 1.
        assert_relative_eq!(
            matrix(0, 0),
            (0.2f64 / 0.9).powi(2) + (3.0f64 * 0.1 / 0.1).powi(2),
            max_relative = 1e-12
        );
        assert_eq!(matrix(1, 1), 0.0);
    }
}
