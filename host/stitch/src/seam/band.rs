//! The frame in which the cut is sought.

use nalgebra::{Matrix3, Rotation3, Vector3};
use tectum_optics::{OutputMap, Projection, Rig, RigEye};

use super::SeamError;

/// Columns and rows of the look-out for the overlap.
const COARSE_PX: [u16; 2] = [360, 180];
/// Degrees, and rows of the look-out, kept about the overlap.
const SPARE_ROWS: usize = 2;

/// Least and greatest width of a frame that is as fine as the eyes, px a turn.
const WIDTHS_PX: [f64; 2] = [640.0, 2048.0];
/// Step of an angle over which an eye's resolution is measured, rad.
const STEP_RAD: f64 = 0.01;

/// Width of a frame as fine as the finer eye sees, px a turn, a multiple of 8: pixels beyond what a lens
/// resolves take their time and show nothing. Within 640 and 2048 px.
pub fn fine_width_px(rig: &Rig) -> u16 {
    let eyes = [&rig.left, &rig.right].into_iter().flatten();
    let finest = eyes.map(px_per_rad).fold(0.0, f64::max);
    let [least, greatest] = WIDTHS_PX;
    let width = (finest * std::f64::consts::TAU).clamp(least, greatest);
    // At most 2048.
    libm::ceil(width / 8.0) as u16 * 8
}

/// Mean pixels a radian that an eye has from its axis to the border of its field; 0 where it sees nothing.
fn px_per_rad(eye: &RigEye) -> f64 {
    let ray = |angle: f64, around: f64| {
        let [sin, cos] = [libm::sin(angle), libm::cos(angle)];
        Vector3::new(sin * libm::cos(around), sin * libm::sin(around), cos)
    };
    let pixel = |angle, around| eye.eye.project(&ray(angle, around)).ok();
    let slopes: Vec<f64> = (0..4)
        .flat_map(|quarter| {
            let around = f64::from(quarter) * std::f64::consts::FRAC_PI_2;
            (0..16).map(move |i| (0.1 * f64::from(i), around))
        })
        .filter_map(|(angle, around)| {
            let [a, b] = [pixel(angle, around)?, pixel(angle + STEP_RAD, around)?];
            Some(libm::hypot(b[0] - a[0], b[1] - a[1]) / STEP_RAD)
        })
        .collect();
    slopes.iter().sum::<f64>() / slopes.len().max(1) as f64
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_as_fine_as_the_eyes() {
        let width = |focal: f64| {
            let eye = |yaw: f64| {
                format!(
                    "size_px = [480, 480]\nfield_deg = 210.0\npose = {{ yaw_deg = {yaw}, pitch_deg = 0.0, \
                     position_mm = [0.0, 0.0, 0.0] }}\nlens = {{ model = \"equidistant\", \
                     focal_px_per_rad = {focal:?}, centre_px = [239.5, 239.5] }}\n"
                )
            };
            let text = format!(
                "name = \"two\"\nmedium = \"air\"\nstitch_distance_m = inf\n[left]\n{}[right]\n{}",
                eye(90.0),
                eye(-90.0)
            );
            fine_width_px(&Rig::from_toml(&text, "two").unwrap())
        };
        // 128 px a radian are 804.2 px a turn.
        assert_eq!(width(128.0), 808);
        assert_eq!([width(20.0), width(900.0)], [640, 2048]);
    }
}
