//! Linear start (Scaramuzza, Martinelli & Siegwart 2006): each view's pose up to its distance
//! from the tangential equations, then the polynomial and all distances from one stacked least
//! squares.

use nalgebra::{DMatrix, DVector, Matrix3, SMatrix, Vector2, Vector3};

use super::sight::{Pose, Sight, nearest_rotation};

/// Coefficients of the start: `b0, b2, b3, b4`.
const TERMS: usize = 4;
/// Powers of rho beside them.
const POWERS: [i32; TERMS] = [0, 2, 3, 4];

/// A view's pose but for the distance along the axis and the sign of its tilt.
struct Partial {
    /// First two columns of the rotation, third row for one of the two tilts.
    columns: [Vector3<f64>; 2],
    /// Position, the third coordinate unknown.
    t: Vector2<f64>,
    /// Distance eliminated: normal equations of the polynomial.
    normal: DMatrix<f64>,
    right: DVector<f64>,
    square: f64,
    /// Distance along the axis: `mean_row . b - sign mean_right`.
    mean_row: DVector<f64>,
    mean_right: f64,
}

/// What the linear equations give.
#[derive(Debug)]
pub struct LinearStart {
    /// `f(rho) = s (b0 + b2 (rho/s)^2 + b3 (rho/s)^3 + b4 (rho/s)^4)`.
    pub polynomial: [f64; TERMS],
    /// By sight; `None` where the equations are degenerate.
    pub poses: Vec<Option<Pose>>,
}

/// Solves all views about a centre; `scale_px` is about the radius of the image. `None` if no
/// lens comes out.
pub fn solve(sights: &[Sight], centre: Vector2<f64>, scale_px: f64) -> Option<LinearStart> {
    let partials: Vec<Option<Partial>> = sights
        .iter()
        .map(|sight| partial(sight, centre, scale_px))
        .collect();
    let known: Vec<&Partial> = partials.iter().flatten().collect();
    let mut signs: Vec<f64> = known.iter().map(|view| tilt_sign(view)).collect();
    let mut best = stacked(&known, &signs)?;
    // A view whose tilt was guessed wrong: flip it where that fits better. A pass over all views
    // mends them; three are more than ever needed.
    for _ in 0..3 {
        let before = best.0;
        for view in 0..known.len() {
            signs[view] = -signs[view];
            match stacked(&known, &signs) {
                Some(other) if other.0 < best.0 => best = other,
                _ => signs[view] = -signs[view],
            }
        }
        if best.0 >= before {
            break;
        }
    }
    let mut b = best.1;
    // All tilts and the polynomial can change sign together: a lens looks ahead.
    if b[0] < 0.0 {
        b = -b;
        signs.iter_mut().for_each(|sign| *sign = -*sign);
    }
    let mut signs = signs.into_iter();
    let poses = partials.iter().map(|view| {
        let view = view.as_ref()?;
        view.pose(signs.next()?, &b)
    });
    Some(LinearStart {
        polynomial: [b[0], b[1], b[2], b[3]],
        poses: poses.collect(),
    })
}

/// Sign that makes the view's own second-degree fit a lens: f(rho) / rho falls at the corners.
fn tilt_sign(view: &Partial) -> f64 {
    let normal = view.normal.view((0, 0), (2, 2)).into_owned();
    let right = view.right.rows(0, 2).into_owned();
    match normal.lu().solve(&right) {
        // f - rho f' = b0 - b2 x^2 at a typical corner.
        Some(b) if b[0] - 0.25 * b[1] < 0.0 => -1.0,
        _ => 1.0,
    }
}

/// Least squares of all views: residual and polynomial.
fn stacked(views: &[&Partial], signs: &[f64]) -> Option<(f64, DVector<f64>)> {
    let mut normal = DMatrix::zeros(TERMS, TERMS);
    let mut right = DVector::zeros(TERMS);
    let mut square = 0.0;
    for (view, sign) in views.iter().zip(signs) {
        normal += &view.normal;
        right += &view.right * *sign;
        square += view.square;
    }
    // A trace of a ridge: narrow lenses leave the higher powers open.
    let ridge = 1e-9 * normal.trace();
    for k in 0..TERMS {
        normal[(k, k)] += ridge;
    }
    let b = normal.cholesky()?.solve(&right);
    let residual = square - b.dot(&right);
    residual.is_finite().then_some((residual, b))
}

impl Partial {
    fn pose(&self, sign: f64, b: &DVector<f64>) -> Option<Pose> {
        let [mut r1, mut r2] = self.columns;
        r1.z *= sign;
        r2.z *= sign;
        let t3 = self.mean_row.dot(b) - self.mean_right * sign;
        let matrix = Matrix3::from_columns(&[r1, r2, r1.cross(&r2)]);
        Some(Pose {
            rotation: nearest_rotation(&matrix)?,
            position: Vector3::new(self.t.x, self.t.y, t3),
        })
    }
}

fn partial(sight: &Sight, centre: Vector2<f64>, scale_px: f64) -> Option<Partial> {
    let mut normal = SMatrix::<f64, 6, 6>::zeros();
    let ideal = |pixel: Vector2<f64>| (pixel - centre) / scale_px;
    for target in sight.used() {
        let (m, x) = (ideal(target.pixel), target.point);
        // m x (R point + t) = 0, third coordinate.
        let row =
            SMatrix::<f64, 1, 6>::new(x.x * m.y, x.y * m.y, -x.x * m.x, -x.y * m.x, m.y, -m.x);
        normal += row.transpose() * row;
    }
    if sight.count() < 6 || !normal.iter().all(|x| x.is_finite()) {
        return None;
    }
    let eigen = normal.symmetric_eigen();
    let mut h = eigen
        .eigenvectors
        .column(eigen.eigenvalues.imin())
        .into_owned();
    let planar = |h: &SMatrix<f64, 6, 1>, x: &Vector3<f64>| {
        Vector2::new(
            h[0] * x.x + h[1] * x.y + h[4],
            h[2] * x.x + h[3] * x.y + h[5],
        )
    };
    let ahead: f64 = sight
        .used()
        .map(|target| ideal(target.pixel).dot(&planar(&h, &target.point)).signum())
        .sum();
    if ahead < 0.0 {
        h = -h;
    }
    let [r11, r12, r21, r22] = [h[0], h[1], h[2], h[3]];
    // Orthonormal columns: r32^2 is the root of u^2 + (cc - bb) u - aa^2 = 0.
    let aa = r11 * r12 + r21 * r22;
    let (bb, cc) = (r11 * r11 + r21 * r21, r12 * r12 + r22 * r22);
    let u = ((bb - cc + libm::hypot(bb - cc, 2.0 * aa)) / 2.0).max(0.0);
    let r31 = (u + cc - bb).max(0.0).sqrt();
    let r32 = if aa > 0.0 { -u.sqrt() } else { u.sqrt() };
    let length = (bb + r31 * r31).sqrt();
    if !(length.is_finite() && length > 1e-12) {
        return None;
    }
    let h = h / length;
    let columns = [
        Vector3::new(h[0], h[2], r31 / length),
        Vector3::new(h[1], h[3], r32 / length),
    ];
    distances(
        sight,
        &ideal,
        &|x| planar(&h, x),
        columns,
        Vector2::new(h[4], h[5]),
    )
}

/// Rows `(m . M / rho) f(rho) - rho t3 = rho (r31 X + r32 Y)` with t3 eliminated.
fn distances(
    sight: &Sight,
    ideal: &dyn Fn(Vector2<f64>) -> Vector2<f64>,
    planar: &dyn Fn(&Vector3<f64>) -> Vector2<f64>,
    columns: [Vector3<f64>; 2],
    t: Vector2<f64>,
) -> Option<Partial> {
    let count = sight.count();
    let mut rows = DMatrix::zeros(count, TERMS);
    let (mut right, mut radii) = (DVector::zeros(count), DVector::zeros(count));
    let mut size = 0.0;
    for (i, target) in sight.used().enumerate() {
        let m = ideal(target.pixel);
        let rho = m.norm().max(1e-9);
        let along = m.dot(&planar(&target.point)) / rho;
        for (k, power) in POWERS.iter().enumerate() {
            rows[(i, k)] = along * rho.powi(*power);
        }
        right[i] = rho * (columns[0].z * target.point.x + columns[1].z * target.point.y);
        radii[i] = rho;
        size += along.abs() + rho;
    }
    // Near and far boards weigh the same.
    let weight = count as f64 / size;
    rows *= weight;
    right *= weight;
    let length = radii.norm_squared();
    let mean_row = rows.tr_mul(&radii) / length;
    let mean_right = radii.dot(&right) / length;
    rows -= &radii * mean_row.transpose();
    right -= &radii * mean_right;
    let partial = Partial {
        columns,
        t,
        normal: rows.tr_mul(&rows),
        right: rows.tr_mul(&right),
        square: right.norm_squared(),
        mean_row: mean_row / weight,
        mean_right: mean_right / weight,
    };
    partial.square.is_finite().then_some(partial)
}
