//! View-plane coordinates of the stitched picture and rays in the view frame.

use tectum_tables::{OutputMap, ProjectionKind};

use super::functions::{sin_cos, sqrt};

/// Ray in the view frame (x forward, y left, z up) at view-plane coordinates.
pub fn view_ray(kind: ProjectionKind, [u, v]: [f32; 2]) -> Option<[f32; 3]> {
    match kind {
        ProjectionKind::Equirect => {
            let inside = v.abs() <= core::f32::consts::FRAC_PI_2 + 1e-6;
            inside.then(|| {
                let ([sin_u, cos_u], [sin_v, cos_v]) = (sin_cos(u), sin_cos(v));
                [cos_v * cos_u, -cos_v * sin_u, -sin_v]
            })
        }
        ProjectionKind::Cylindrical => {
            let [sin_u, cos_u] = sin_cos(u);
            Some([cos_u, -sin_u, -v])
        }
        ProjectionKind::Fisheye => {
            let theta = sqrt(u * u + v * v);
            let [sine, cosine] = sin_cos(theta);
            let k = sine / theta.max(f32::MIN_POSITIVE);
            (theta <= core::f32::consts::PI).then_some([cosine, -k * u, -k * v])
        }
        ProjectionKind::Perspective => Some([1.0, -u, -v]),
    }
}

/// View-plane coordinates of a ray in the view frame.
pub fn view_plane(kind: ProjectionKind, [x, y, z]: [f32; 3]) -> Option<[f32; 2]> {
    match kind {
        ProjectionKind::Equirect => {
            Some([-libm::atan2f(y, x), libm::atan2f(-z, sqrt(x * x + y * y))])
        }
        ProjectionKind::Cylindrical => Some([-libm::atan2f(y, x), -z / sqrt(x * x + y * y)]),
        ProjectionKind::Fisheye => {
            let sine = sqrt(y * y + z * z);
            let k = libm::atan2f(sine, x) / sine.max(f32::MIN_POSITIVE);
            Some([-k * y, -k * z])
        }
        ProjectionKind::Perspective => (x > 0.0).then(|| [-y / x, -z / x]),
    }
}

/// `[[u0, du], [v0, dv]]`.
pub fn plane(map: &OutputMap<'_>) -> [[f32; 2]; 2] {
    [map.u_q28(), map.v_q28()].map(|axis| axis.map(|v| v as f32 / (1u32 << 28) as f32))
}
