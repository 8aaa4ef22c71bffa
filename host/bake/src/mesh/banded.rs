//! Cholesky decomposition of a symmetric banded matrix.

use super::FitError;

/// Lower band of a symmetric positive definite matrix: row i holds columns i - band ..= i.
pub struct Banded {
    order: usize,
    band: usize,
    rows: Vec<f64>,
}

impl Banded {
    /// # Errors
    /// [`FitError::Memory`] if there is not enough.
    pub fn zero(order: usize, band: usize) -> Result<Self, FitError> {
        let count = order * (band + 1);
        let mut rows = Vec::new();
        rows.try_reserve_exact(count)
            .map_err(|_| FitError::Memory(count * size_of::<f64>() / 1_000_000))?;
        rows.resize(count, 0.0);
        Ok(Self { order, band, rows })
    }

    /// Adds to element (i, j), j <= i, i - j <= band.
    pub fn add(&mut self, i: usize, j: usize, value: f64) {
        self.rows[i * (self.band + 1) + self.band + j - i] += value;
    }

    /// Replaces the matrix by its Cholesky factor. `None` if it is not positive definite.
    pub fn factor(mut self) -> Option<Factor> {
        let width = self.band + 1;
        for i in 0..self.order {
            let (done, row) = self.rows.split_at_mut(i * width);
            let row = &mut row[..width];
            let first = i.saturating_sub(self.band);
            for j in first..i {
                let above = &done[j * width..(j + 1) * width];
                // Columns that both rows hold: from `first` on.
                let row_start = self.band + first - i;
                let row_j = self.band + j - i;
                let above_start = self.band + first - j;
                let dot = dot(&row[row_start..row_j], &above[above_start..self.band]);
                row[row_j] = (row[row_j] - dot) / above[self.band];
            }
            let left = &row[self.band + first - i..self.band];
            let pivot = row[self.band] - dot(left, left);
            if pivot.is_nan() || pivot <= 0.0 {
                return None;
            }
            row[self.band] = pivot.sqrt();
        }
        Some(Factor(self))
    }
}

/// A sum in a fixed order of eight partial sums: fast, and the same on every machine.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (a8, a_rest) = a.as_chunks::<8>();
    let (b8, b_rest) = b.as_chunks::<8>();
    let mut partial = [0.0; 8];
    for (a, b) in a8.iter().zip(b8) {
        for i in 0..8 {
            partial[i] += a[i] * b[i];
        }
    }
    partial.iter().sum::<f64>() + a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum::<f64>()
}

/// A Cholesky factor.
pub struct Factor(Banded);

impl Factor {
    /// Solves for one right-hand side, in place.
    pub fn solve(&self, x: &mut [f64]) {
        let Banded { order, band, rows } = &self.0;
        let width = band + 1;
        for i in 0..*order {
            let row = &rows[i * width..(i + 1) * width];
            let first = i.saturating_sub(*band);
            x[i] = (x[i] - dot(&row[band + first - i..*band], &x[first..i])) / row[*band];
        }
        for i in (0..*order).rev() {
            let row = &rows[i * width..(i + 1) * width];
            x[i] /= row[*band];
            let first = i.saturating_sub(*band);
            for j in first..i {
                x[j] -= row[band + j - i] * x[i];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_a_banded_system() {
        let (n, band) = (40, 5);
        let element = |i: usize, j: usize| match i - j {
            0 => 12.0 + i as f64,
            d if d <= band => 1.0 / (d as f64 + j as f64 * 0.1),
            _ => 0.0,
        };
        let mut matrix = Banded::zero(n, band).expect("some bytes");
        for i in 0..n {
            for j in i.saturating_sub(band)..=i {
                matrix.add(i, j, element(i, j));
            }
        }
        let truth: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
        let mut x: Vec<f64> = (0..n)
            .map(|i| (0..n).map(|j| element(i.max(j), i.min(j)) * truth[j]).sum())
            .collect();
        matrix.factor().expect("positive definite").solve(&mut x);
        for (x, truth) in x.iter().zip(truth) {
            // The matrix is well conditioned: a few units in the last place of numbers near 1.
            assert!((x - truth).abs() < 1e-13);
        }
    }

    #[test]
    fn an_indefinite_matrix_is_refused() {
        let mut matrix = Banded::zero(2, 1).expect("some bytes");
        matrix.add(0, 0, 1.0);
        matrix.add(1, 0, 2.0);
        matrix.add(1, 1, 1.0);
        assert!(matrix.factor().is_none());
    }
}
