//! The frame in which the cut is sought.

use nalgebra::{Matrix3, Rotation3, Vector3};
use tectum_optics::{OutputMap, Projection, Rig};

use super::SeamError;

/// Columns and rows of the look-out for the overlap.
const COARSE_PX: [u16; 2] = [360, 180];
/// Degrees, and rows of the look-out, kept about the overlap.
const SPARE_ROWS: usize = 2;

/// An equirect picture whose axis joins the eyes, left eye up, and whose middle is between their
/// optical axes; `width_px` a turn, cropped to the rows that both eyes see. An overlap of two eyes
/// that look apart is a band of it which runs all round; one in front is a piece in its middle.
///
/// # Errors
/// [`SeamError`]: no overlap.
pub fn band(rig: &Rig, width_px: u16) -> Result<OutputMap, SeamError> {
    let (Some(left), Some(right)) = (&rig.left, &rig.right) else {
        return Err(SeamError::OneEye);
    };
    let [a, b] = [left, right].map(|eye| eye.pose.optical_axis());
    if (a - b).norm() < 1e-3 {
        return Err(SeamError::SameAxis);
    }
    let up = (a - b).normalize();
    // Straight ahead, if the axes are opposite: any direction is as good.
    let ahead = [a + b, Vector3::x(), Vector3::z()]
        .map(|v| v - up * up.dot(&v))
        .into_iter()
        .find(|v| v.norm() > 1e-3)
        .unwrap_or_else(Vector3::x)
        .normalize();
    let columns = [ahead, up.cross(&ahead), up];
    let rotation = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&columns));
    let projection = Projection::Design(rotation);

    let coarse = projection
        .output_map(COARSE_PX)
        .map_err(|_| SeamError::Size)?;
    let [across, down] = COARSE_PX.map(usize::from);
    let seen = |ray: &Vector3<f64>, eye: usize| {
        let camera = [left, right][eye];
        let ray = rig.shown_ray(eye, ray);
        ray.is_some_and(|ray| camera.eye.project(&ray).is_ok())
    };
    let both = |x: usize, y: usize| {
        let ray = coarse.ray(x as f64, y as f64);
        ray.is_some_and(|ray| seen(&ray, 0) && seen(&ray, 1))
    };
    let has_both = |y: &usize| (0..across).any(|x| both(x, *y));
    let (Some(first), Some(last)) = ((0..down).find(has_both), (0..down).rev().find(has_both))
    else {
        return Err(SeamError::NoOverlap);
    };

    let height_px = width_px / 2;
    let mut map = projection
        .output_map([width_px, height_px])
        .map_err(|_| SeamError::Size)?;
    let rows_of = |coarse_row: usize| coarse_row * usize::from(height_px) / down;
    let top = rows_of(first.saturating_sub(SPARE_ROWS));
    let bottom = rows_of((last + 1 + SPARE_ROWS).min(down));
    map.v[0] += top as f64 * map.v[1];
    map.size_px[1] = (bottom - top) as u16;
    Ok(map)
}
