//! Vectors and matrices of three.

use super::functions::sqrt;

/// Numbers in Q30.
pub fn q30<const N: usize>(values: [i32; N]) -> [f32; N] {
    values.map(|v| v as f32 / (1u32 << 30) as f32)
}

/// Scalar product.
pub fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// A matrix, row by row, times a vector.
pub fn rotate(r: [f32; 9], v: [f32; 3]) -> [f32; 3] {
    let [a, b, c, d, e, f, g, h, i] = r;
    [dot([a, b, c], v), dot([d, e, f], v), dot([g, h, i], v)]
}

/// The transposed matrix.
pub fn transpose([a, b, c, d, e, f, g, h, i]: [f32; 9]) -> [f32; 9] {
    [a, d, g, b, e, h, c, f, i]
}

/// Vector product.
pub fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// Length.
pub fn norm(v: [f32; 3]) -> f32 {
    sqrt(dot(v, v))
}

/// Angle between vectors of any length, rad; exact for small angles, unlike an arc cosine.
pub fn angle_between(a: [f32; 3], b: [f32; 3]) -> f32 {
    libm::atan2f(norm(cross(a, b)), dot(a, b))
}
