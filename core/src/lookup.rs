//! Where a pixel looks, and which pixel looks there. Queries, not per-pixel work: f32 with `libm`,
//! so the same on every machine.

use tectum_tables::{Eye, EyeRays, OutputMap, ProjectionKind, Tables};

use crate::Direction;

const TURN: f32 = 2.0 * core::f32::consts::PI;

/// Answers direction queries with one table.
///
/// Pixel coordinates are in Q8 (256 to a pixel); an integer pixel is a pixel's centre.
#[derive(Debug, Clone, Copy)]
pub struct Lookup<'t> {
    tables: &'t Tables<'t>,
}

impl<'t> Lookup<'t> {
    /// Lookup with `tables`.
    pub fn new(tables: &'t Tables<'t>) -> Self {
        Self { tables }
    }

    /// Direction that an output pixel shows. `None` outside the picture, or where its projection
    /// holds no direction.
    pub fn direction_of_pixel(&self, pixel_q8: [i32; 2]) -> Option<Direction> {
        if !self.holds(pixel_q8) {
            return None;
        }
        let map = self.tables.output_map();
        let [x, y] = pixel_q8.map(|p| p as f32 / 256.0);
        let [[u0, du], [v0, dv]] = plane(map);
        let view = view_ray(map.kind(), [u0 + x * du, v0 + y * dv])?;
        Some(Direction::of(rotate(q30(map.rotation_q30()), view)))
    }

    /// Output pixel that shows a direction. `None` if it lies outside the picture.
    pub fn pixel_of_direction(&self, direction: Direction) -> Option<[i32; 2]> {
        let map = self.tables.output_map();
        let view = rotate(transpose(q30(map.rotation_q30())), direction.vector());
        let [u, v] = view_plane(map.kind(), view)?;
        let [[u0, du], [v0, dv]] = plane(map);
        let turns: &[f32] = match map.kind() {
            ProjectionKind::Equirect | ProjectionKind::Cylindrical => &[0.0, TURN, -TURN],
            ProjectionKind::Fisheye | ProjectionKind::Perspective => &[0.0],
        };
        turns
            .iter()
            .map(|turn| [(u + turn - u0) / du, (v - v0) / dv])
            .map(|pixel| pixel.map(|p| libm::floorf(p * 256.0 + 0.5) as i32))
            .find(|pixel| self.holds(*pixel))
    }

    /// Direction, seen from the body's origin, of what a raw pixel of an eye shows, at the
    /// table's stitch distance. `None` outside the eye's field or if the table has no such data.
    pub fn direction_of_eye_pixel(&self, eye: Eye, pixel_q8: [i32; 2]) -> Option<Direction> {
        let rays = self.tables.eye_rays(eye)?;
        let centre = rays.centre_q16().map(|c| c as f32 / 65536.0);
        let [dx, dy] = [0, 1].map(|i| pixel_q8[i] as f32 / 256.0 - centre[i]);
        let [a, b, c, d] = rays.affine_q28().map(|v| v as f32 / (1u32 << 28) as f32);
        let shifted = [a * dx + b * dy, c * dx + d * dy];
        let ideal = rays
            .decentring_q44()
            .map_or(shifted, |t| centred(t, shifted));
        let ray = camera_ray(rays, ideal)?;
        let ray = rotate(q30(rays.rotation_q30()), ray);
        let eye_at = q30(rays.position_q30());
        let along = dot(eye_at, ray);
        let to_sphere = libm::sqrtf(along * along + 1.0 - dot(eye_at, eye_at)) - along;
        Some(Direction::of(
            [0, 1, 2].map(|i| eye_at[i] + to_sphere * ray[i]),
        ))
    }

    fn holds(&self, pixel_q8: [i32; 2]) -> bool {
        let size = [
            self.tables.output_width_px(),
            self.tables.output_height_px(),
        ];
        let inside = |p: i32, side: u16| (-128..i32::from(side) * 256 - 128).contains(&p);
        inside(pixel_q8[0], size[0]) && inside(pixel_q8[1], size[1])
    }
}

/// The offset that decentring moves to `shifted`. A lens shifts by a pixel or a few and by a
/// hundredth of that more a pixel further on: three rounds leave less than f32 holds.
fn centred(t_q44: [i32; 2], shifted: [f32; 2]) -> [f32; 2] {
    let [t1, t2] = t_q44.map(|t| t as f32 / (1u64 << 44) as f32);
    let mut ideal = shifted;
    for _ in 0..3 {
        let [x, y] = ideal;
        let (square, product) = (x * x + y * y, 2.0 * x * y);
        ideal = [
            shifted[0] - (t1 * product + t2 * (square + 2.0 * x * x)),
            shifted[1] - (t1 * (square + 2.0 * y * y) + t2 * product),
        ];
    }
    ideal
}

/// Unit ray in the camera frame (x right, y down, z forward) at an offset from the optical axis.
fn camera_ray(rays: &EyeRays<'_>, [x, y]: [f32; 2]) -> Option<[f32; 3]> {
    let rho = libm::sqrtf(x * x + y * y);
    let radius = rays.radius_q16() as f32 / 65536.0;
    if rho > radius {
        return None;
    }
    let node = rho / radius * f32::from(rays.nodes().saturating_sub(1));
    let first = node as i32;
    let t = node - first as f32;
    let [p0, p1, p2, p3] = [-1, 0, 1, 2].map(|i| rays.angle_q14(first + i) as f32 / 16384.0);
    let cubic = [
        p2 - p0,
        2.0 * p0 - 5.0 * p1 + 4.0 * p2 - p3,
        3.0 * (p1 - p2) + p3 - p0,
    ];
    let theta = p1 + 0.5 * t * (cubic[0] + t * (cubic[1] + t * cubic[2]));
    // On the axis any azimuth does: the sine is 0.
    let k = libm::sinf(theta) / rho.max(f32::MIN_POSITIVE);
    Some([k * x, k * y, libm::cosf(theta)])
}

/// Ray in the view frame (x forward, y left, z up) at view-plane coordinates.
fn view_ray(kind: ProjectionKind, [u, v]: [f32; 2]) -> Option<[f32; 3]> {
    match kind {
        ProjectionKind::Equirect => {
            let cos_v = libm::cosf(v);
            let inside = v.abs() <= core::f32::consts::FRAC_PI_2 + 1e-6;
            inside.then(|| {
                [
                    cos_v * libm::cosf(u),
                    -cos_v * libm::sinf(u),
                    -libm::sinf(v),
                ]
            })
        }
        ProjectionKind::Cylindrical => Some([libm::cosf(u), -libm::sinf(u), -v]),
        ProjectionKind::Fisheye => {
            let theta = libm::sqrtf(u * u + v * v);
            let k = libm::sinf(theta) / theta.max(f32::MIN_POSITIVE);
            (theta <= core::f32::consts::PI).then(|| [libm::cosf(theta), -k * u, -k * v])
        }
        ProjectionKind::Perspective => Some([1.0, -u, -v]),
    }
}

/// View-plane coordinates of a ray in the view frame.
fn view_plane(kind: ProjectionKind, [x, y, z]: [f32; 3]) -> Option<[f32; 2]> {
    match kind {
        ProjectionKind::Equirect => Some([
            -libm::atan2f(y, x),
            libm::atan2f(-z, libm::sqrtf(x * x + y * y)),
        ]),
        ProjectionKind::Cylindrical => Some([-libm::atan2f(y, x), -z / libm::sqrtf(x * x + y * y)]),
        ProjectionKind::Fisheye => {
            let sine = libm::sqrtf(y * y + z * z);
            let k = libm::atan2f(sine, x) / sine.max(f32::MIN_POSITIVE);
            Some([-k * y, -k * z])
        }
        ProjectionKind::Perspective => (x > 0.0).then(|| [-y / x, -z / x]),
    }
}

fn plane(map: &OutputMap<'_>) -> [[f32; 2]; 2] {
    [map.u_q28(), map.v_q28()].map(|axis| axis.map(|v| v as f32 / (1u32 << 28) as f32))
}

fn q30<const N: usize>(values: [i32; N]) -> [f32; N] {
    values.map(|v| v as f32 / (1u32 << 30) as f32)
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn rotate(r: [f32; 9], v: [f32; 3]) -> [f32; 3] {
    let [a, b, c, d, e, f, g, h, i] = r;
    [dot([a, b, c], v), dot([d, e, f], v), dot([g, h, i], v)]
}

fn transpose([a, b, c, d, e, f, g, h, i]: [f32; 9]) -> [f32; 9] {
    [a, d, g, b, e, h, c, f, i]
}
