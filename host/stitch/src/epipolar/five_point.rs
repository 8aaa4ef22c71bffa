//! Relative poses of five correspondences (Nistér 2004), by the action matrix of Stewénius, Engels &
//! Nistér 2006.
//!
//! The essential matrices that fit five correspondences are `x X + y Y + z Z + W`; ten cubics in
//! x, y, z say that such a matrix is essential. Eliminating the ten cubic monomials leaves the matrix
//! that multiplies the ten lower ones by x; its eigenvectors are the solutions.

use nalgebra::{Matrix3, Rotation3, SMatrix, SVector, Schur, Vector3};

use super::{Baseline, RayPair, RelativePose};

type Matrix10 = SMatrix<f64, 10, 10>;
type Vector10 = SVector<f64, 10>;

/// Powers of x, y, z: ten cubic monomials, then the basis of what is left.
const MONOMIALS: [[u8; 3]; 20] = [
    [3, 0, 0],
    [2, 1, 0],
    [2, 0, 1],
    [1, 2, 0],
    [1, 1, 1],
    [1, 0, 2],
    [0, 3, 0],
    [0, 2, 1],
    [0, 1, 2],
    [0, 0, 3],
    [2, 0, 0],
    [1, 1, 0],
    [1, 0, 1],
    [0, 2, 0],
    [0, 1, 1],
    [0, 0, 2],
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
    [0, 0, 0],
];

/// Index of each product of two monomials; 20 where it is of no use (degree above 3).
const PRODUCTS: [[usize; 20]; 20] = products();

const fn products() -> [[usize; 20]; 20] {
    let mut table = [[20; 20]; 20];
    let mut i = 0;
    while i < 400 {
        let [a, b] = [MONOMIALS[i / 20], MONOMIALS[i % 20]];
        let mut k = 0;
        while k < 20 {
            let c = MONOMIALS[k];
            if a[0] + b[0] == c[0] && a[1] + b[1] == c[1] && a[2] + b[2] == c[2] {
                table[i / 20][i % 20] = k;
            }
            k += 1;
        }
        i += 1;
    }
    table
}

/// A polynomial of degree up to 3.
#[derive(Clone, Copy)]
struct Cubic([f64; 20]);

impl Cubic {
    const ZERO: Self = Self([0.0; 20]);

    fn plus(mut self, other: &Self, factor: f64) -> Self {
        for (a, b) in self.0.iter_mut().zip(other.0) {
            *a += factor * b;
        }
        self
    }

    fn times(&self, other: &Self) -> Self {
        let mut product = Self::ZERO;
        for (i, a) in self.0.iter().enumerate().filter(|(_, a)| **a != 0.0) {
            for (j, b) in other.0.iter().enumerate().filter(|(_, b)| **b != 0.0) {
                if let Some(sum) = product.0.get_mut(PRODUCTS[i][j]) {
                    *sum += a * b;
                }
            }
        }
        product
    }
}

/// All relative poses that fit five correspondences exactly with every point ahead of both eyes:
/// none for most wrong samples, up to ten.
pub fn poses(sample: &[RayPair; 5]) -> Vec<RelativePose> {
    essential_matrices(sample)
        .into_iter()
        .flat_map(|essential| decompositions(&essential))
        .filter(|pose| sample.iter().all(|pair| pose.is_ahead(pair)))
        .collect()
}

/// All `E` with `left . E right = 0`.
fn essential_matrices(sample: &[RayPair; 5]) -> Vec<Matrix3<f64>> {
    let Some(space) = null_space(sample) else {
        return Vec::new();
    };
    let entry = |i: usize, j: usize| {
        let mut cubic = Cubic::ZERO;
        for (k, matrix) in space.iter().enumerate() {
            cubic.0[16 + k] = matrix[(i, j)];
        }
        cubic
    };
    let e: [[Cubic; 3]; 3] = std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)));
    let Some(action) = action_matrix(&constraints(&e)) else {
        return Vec::new();
    };
    // Enough for any 10x10 matrix that converges at all.
    const MOST_ITERATIONS: usize = 500;
    let Some(schur) = Schur::try_new(action, f64::EPSILON, MOST_ITERATIONS) else {
        return Vec::new();
    };
    let eigenvalues = schur.complex_eigenvalues();
    let real = eigenvalues
        .iter()
        .filter(|v| v.im.abs() <= 1e-8 * v.re.abs().max(1.0));
    real.filter_map(|value| {
        let v = eigenvector(&action, value.re)?;
        let [x, y, z] = [6, 7, 8].map(|k| v[k] / v[9]);
        let essential = space[0] * x + space[1] * y + space[2] * z + space[3];
        essential.iter().all(|v| v.is_finite()).then_some(essential)
    })
    .collect()
}

/// Four matrices that span what the five equations leave.
fn null_space(sample: &[RayPair; 5]) -> Option<[Matrix3<f64>; 4]> {
    let mut equations = SMatrix::<f64, 9, 9>::zeros();
    for (row, pair) in sample.iter().enumerate() {
        for k in 0..9 {
            equations[(row, k)] = pair.left[k / 3] * pair.right[k % 3];
        }
    }
    let v_t = equations.try_svd(false, true, f64::EPSILON, 500)?.v_t?;
    // Singular values come sorted: the last four are those of the empty rows.
    Some(std::array::from_fn(|i| {
        Matrix3::from_fn(|r, c| v_t[(5 + i, 3 * r + c)])
    }))
}

/// `det E = 0` and `2 E E' E - tr(E E') E = 0` (Nistér 2004, Eq. 5-6).
fn constraints(e: &[[Cubic; 3]; 3]) -> [Cubic; 10] {
    let minor = |a: usize, b: usize| {
        let (first, second) = (e[1][a].times(&e[2][b]), e[1][b].times(&e[2][a]));
        first.plus(&second, -1.0)
    };
    let determinant = e[0][0]
        .times(&minor(1, 2))
        .plus(&e[0][1].times(&minor(0, 2)), -1.0)
        .plus(&e[0][2].times(&minor(0, 1)), 1.0);
    let mut square = [[Cubic::ZERO; 3]; 3];
    for (i, row) in square.iter_mut().enumerate() {
        for (j, sum) in row.iter_mut().enumerate() {
            *sum = (0..3).fold(Cubic::ZERO, |s, k| s.plus(&e[i][k].times(&e[j][k]), 1.0));
        }
    }
    let trace = square[0][0]
        .plus(&square[1][1], 1.0)
        .plus(&square[2][2], 1.0);
    std::array::from_fn(|n| {
        if n == 9 {
            return determinant;
        }
        let (i, j) = (n / 3, n % 3);
        let product = (0..3).fold(Cubic::ZERO, |s, k| {
            s.plus(&square[i][k].times(&e[k][j]), 2.0)
        });
        product.plus(&trace.times(&e[i][j]), -1.0)
    })
}

/// The matrix A with `A v = x v` for the vector v of the ten lower monomials.
fn action_matrix(constraints: &[Cubic; 10]) -> Option<Matrix10> {
    let cubic = Matrix10::from_fn(|i, j| constraints[i].0[j]);
    let lower = Matrix10::from_fn(|i, j| constraints[i].0[10 + j]);
    let reduced = cubic.lu().solve(&lower)?;
    Some(Matrix10::from_fn(|i, j| {
        // x times the basis monomial i: a cubic monomial, which is minus its reduced row, or another
        // one of the basis.
        match PRODUCTS[16][10 + i] {
            product @ 0..10 => -reduced[(product, j)],
            product => f64::from(u8::from(product == 10 + j)),
        }
    }))
}

/// By inverse iteration.
fn eigenvector(action: &Matrix10, value: f64) -> Option<Vector10> {
    // Off by a hair, so that the matrix can be inverted.
    let shifted = value + 1e-10 * value.abs().max(1e-3);
    let lu = (action - Matrix10::identity() * shifted).lu();
    let mut v = Vector10::repeat(1.0);
    for _ in 0..3 {
        v = lu.solve(&v)?.normalize();
    }
    (v[9].abs() > 1e-12).then_some(v)
}

/// The four poses of an essential matrix `[b]x R` (Hartley & Zisserman 2004, Sec. 9.6.2).
fn decompositions(essential: &Matrix3<f64>) -> Vec<RelativePose> {
    let Some(svd) = essential.try_svd(true, true, f64::EPSILON, 500) else {
        return Vec::new();
    };
    let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else {
        return Vec::new();
    };
    let w = Matrix3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
    let baseline: Vector3<f64> = u.column(2).into_owned();
    let mut poses = Vec::with_capacity(4);
    for turn in [w, w.transpose()] {
        let matrix = u * turn * v_t;
        let rotation = Rotation3::from_matrix_unchecked(matrix * matrix.determinant().signum());
        for sign in [1.0, -1.0] {
            poses.push(RelativePose {
                rotation,
                baseline: Baseline::Towards(baseline * sign),
            });
        }
    }
    poses
}
