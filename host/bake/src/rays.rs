//! Raw eye pixel to direction, as a small curve for the core.

use nalgebra::{Matrix2, Rotation3, Vector2, Vector3};
use tectum_optics::{CameraModel, RigEye};
use tectum_tables::builder::EyeRaysData;

/// Nodes of the angle curve. With 65 the cubic's error is far below the 0.0035 degrees of a node's
/// own unit.
const NODES: usize = 65;
/// Step of the numeric derivative at the optical axis, rad: its error, of second order, is 1e-8 of
/// the scale.
const STEP_RAD: f64 = 1e-4;

/// The ray section of an eye at a stitch distance; `None` if its numbers do not fit the section
/// (a lens whose affine part cannot be inverted there).
pub fn eye_rays(eye: &RigEye, stitch_distance_m: f64) -> Option<EyeRaysData> {
    // Decentring is kept apart; it moves nothing at the centre.
    let (model, decentring) = match &eye.eye.model {
        CameraModel::Ocam(lens) => {
            let centred = CameraModel::Ocam(lens.without_decentring());
            (centred, lens.decentring_per_px())
        }
        other => (other.clone(), [0.0; 2]),
    };
    let centre = Vector2::from(model.project(&Vector3::z()).ok()?);
    let derivative = |axis: Vector3<f64>| {
        let ahead = model
            .project(&(Vector3::z() + axis * libm::tan(STEP_RAD)))
            .ok()?;
        let behind = model
            .project(&(Vector3::z() - axis * libm::tan(STEP_RAD)))
            .ok()?;
        Some((Vector2::from(ahead) - Vector2::from(behind)) / (2.0 * STEP_RAD))
    };
    let jacobian = Matrix2::from_columns(&[derivative(Vector3::x())?, derivative(Vector3::y())?]);
    // Pixels of the ideal image: the affine part keeps areas.
    let affine = jacobian / jacobian.determinant().abs().sqrt();
    // The model's own ideal pixels are smaller by the square root of its affine map's area.
    let scale = match &model {
        CameraModel::Ocam(lens) => {
            let [c, d, e] = lens.affine;
            (c - d * e).abs().sqrt()
        }
        _ => 1.0,
    };
    let to_ideal = affine.try_inverse()?;

    // The lens is symmetric about its axis once the affine part is gone: any azimuth will do.
    let widest = eye.eye.field.widest_rad();
    let ray = |theta: f64| Vector3::new(libm::sin(theta), 0.0, libm::cos(theta));
    let reach = (0..200).map(|i| widest * (1.0 - f64::from(i) * 1e-3));
    let edge = reach
        .map(|theta| model.project(&ray(theta)))
        .find_map(Result::ok)?;
    let radius = (to_ideal * (Vector2::from(edge) - centre)).norm();
    let angle = |i: usize| {
        // A hair inside the last node, where a model's domain may end.
        let rho = radius * (i as f64 / (NODES - 1) as f64).min(1.0 - 1e-9);
        let pixel = centre + affine * Vector2::new(rho, 0.0);
        let ray = model.unproject(pixel.into()).ok()?;
        let theta = libm::atan2(libm::hypot(ray.x, ray.y), ray.z);
        quantise(theta, 14).and_then(|q| u16::try_from(q).ok())
    };
    let q = |v: f64, bits| quantise(v, bits);
    Some(EyeRaysData {
        centre_q16: all([q(centre.x, 16), q(centre.y, 16)])?,
        affine_q28: all([
            q(to_ideal.m11, 28),
            q(to_ideal.m12, 28),
            q(to_ideal.m21, 28),
            q(to_ideal.m22, 28),
        ])?,
        rotation_q30: rotation_q30(&eye.pose.rotation),
        position_q30: all((eye.pose.position_m / stitch_distance_m).data.0[0].map(|v| q(v, 30)))?,
        radius_q16: u32::try_from(quantise(radius, 16)?).ok()?,
        decentring_q44: match decentring {
            [0.0, 0.0] => None,
            [t1, t2] => Some(all([q(t1 / scale, 44), q(t2 / scale, 44)])?),
        },
        angles_q14: (0..NODES).map(angle).collect::<Option<_>>()?,
    })
}

/// A rotation matrix row by row in Q30. Its elements are at most 1, which fits.
pub fn rotation_q30(rotation: &Rotation3<f64>) -> [i32; 9] {
    let m = rotation.matrix();
    std::array::from_fn(|i| libm::round(m[(i / 3, i % 3)] * f64::from(1 << 30)) as i32)
}

/// `value` in Q`bits`, if it fits.
pub fn quantise(value: f64, bits: i32) -> Option<i32> {
    let scaled = libm::round(libm::scalbn(value, bits));
    (scaled.abs() < 2_147_483_648.0).then_some(scaled as i32)
}

fn all<const N: usize>(values: [Option<i32>; N]) -> Option<[i32; N]> {
    values
        .iter()
        .all(Option::is_some)
        .then(|| values.map(Option::unwrap_or_default))
}
