//! A raw pixel of an eye and its ray in the camera frame (x right, y down, z forward).

use tectum_tables::EyeRays;

use super::functions::{floor, sin_cos, sqrt};

/// Ray of length 1 of a position in px. `None` outside the eye's field.
pub fn ray_of_pixel(rays: &EyeRays<'_>, pixel: [f32; 2]) -> Option<[f32; 3]> {
    let centre = centre(rays);
    let [dx, dy] = [0, 1].map(|i| pixel[i] - centre[i]);
    let [a, b, c, d] = affine(rays);
    let shifted = [a * dx + b * dy, c * dx + d * dy];
    let ideal = rays
        .decentring_q44()
        .map_or(shifted, |t| centred(t, shifted));
    camera_ray(rays, ideal)
}

/// Position in px of a ray of any length. `None` outside the eye's field.
pub fn pixel_of_ray(rays: &EyeRays<'_>, [x, y, z]: [f32; 3]) -> Option<[f32; 2]> {
    let across = sqrt(x * x + y * y);
    let rho = rho_of_angle(rays, libm::atan2f(across, z))?;
    // On the axis any azimuth does: rho is 0.
    let k = rho / across.max(f32::MIN_POSITIVE);
    let ideal = [k * x, k * y];
    let [sx, sy] = rays.decentring_q44().map_or(ideal, |t| {
        let moved = decentring(t, ideal);
        [0, 1].map(|i| ideal[i] + moved[i])
    });
    let [a, b, c, d] = affine(rays);
    let area = a * d - b * c;
    let centre = centre(rays);
    let offset = [(d * sx - b * sy) / area, (a * sy - c * sx) / area];
    let pixel = [0, 1].map(|i| centre[i] + offset[i]);
    pixel.iter().all(|p| p.is_finite()).then_some(pixel)
}

fn centre(rays: &EyeRays<'_>) -> [f32; 2] {
    rays.centre_q16().map(|c| c as f32 / 65536.0)
}

fn affine(rays: &EyeRays<'_>) -> [f32; 4] {
    rays.affine_q28().map(|v| v as f32 / (1u32 << 28) as f32)
}

/// How far decentring moves an offset.
fn decentring(t_q44: [i32; 2], [x, y]: [f32; 2]) -> [f32; 2] {
    let [t1, t2] = t_q44.map(|t| t as f32 / (1u64 << 44) as f32);
    let (square, product) = (x * x + y * y, 2.0 * x * y);
    [
        t1 * product + t2 * (square + 2.0 * x * x),
        t1 * (square + 2.0 * y * y) + t2 * product,
    ]
}

/// The offset that decentring moves to `shifted`. A lens shifts by a pixel or a few and by a
/// hundredth of that more a pixel further on: three rounds leave less than f32 holds.
fn centred(t_q44: [i32; 2], shifted: [f32; 2]) -> [f32; 2] {
    let mut ideal = shifted;
    for _ in 0..3 {
        let moved = decentring(t_q44, ideal);
        ideal = [0, 1].map(|i| shifted[i] - moved[i]);
    }
    ideal
}

/// Ray at an offset from the optical axis.
fn camera_ray(rays: &EyeRays<'_>, [x, y]: [f32; 2]) -> Option<[f32; 3]> {
    let rho = sqrt(x * x + y * y);
    let radius = radius(rays);
    if rho > radius {
        return None;
    }
    let node = rho / radius * last_node(rays) as f32;
    let first = node as i32;
    let theta = angle(cubic(rays, first), node - first as f32);
    // On the axis any azimuth does: the sine is 0.
    let [sine, cosine] = sin_cos(theta);
    let k = sine / rho.max(f32::MIN_POSITIVE);
    Some([k * x, k * y, cosine])
}

fn radius(rays: &EyeRays<'_>) -> f32 {
    rays.radius_q16() as f32 / 65536.0
}

fn last_node(rays: &EyeRays<'_>) -> i32 {
    i32::from(rays.nodes()) - 1
}

/// Coefficients of the angle off the axis between node `first` and the next.
fn cubic(rays: &EyeRays<'_>, first: i32) -> [f32; 4] {
    let [p0, p1, p2, p3] = [-1, 0, 1, 2].map(|i| node_angle(rays, first + i));
    [
        p1,
        p2 - p0,
        2.0 * p0 - 5.0 * p1 + 4.0 * p2 - p3,
        3.0 * (p1 - p2) + p3 - p0,
    ]
}

/// Angle off the axis at `t` of the way between the nodes of a cubic.
#[inline(always)]
fn angle([p, a, b, c]: [f32; 4], t: f32) -> f32 {
    p + 0.5 * t * (a + t * (b + t * c))
}

fn node_angle(rays: &EyeRays<'_>, node: i32) -> f32 {
    rays.angle_q14(node) as f32 / 16384.0
}

/// Offset from the axis that has an angle off it; `None` beyond the last node.
fn rho_of_angle(rays: &EyeRays<'_>, theta: f32) -> Option<f32> {
    let last = last_node(rays);
    if theta > node_angle(rays, last) {
        return None;
    }
    // The node before: at most 257 are there. Whole numbers up to a number are those up to its floor.
    let theta_q14 = floor(theta * 16384.0);
    let mut first = 0;
    for bit in [128, 64, 32, 16, 8, 4, 2, 1] {
        let next = first + bit;
        if next < last && rays.angle_q14(next) <= theta_q14 {
            first = next;
        }
    }
    // The curve rises, so halving finds the place, whatever its shape; a chord of 1/32 of the few
    // pixels between nodes is within 1/10,000 px of a lens's curve.
    let cubic = cubic(rays, first);
    let [mut low, mut high] = [0, 1].map(|i| node_angle(rays, first + i));
    let (mut t, mut step) = (0.0, 1.0);
    for _ in 0..5 {
        step *= 0.5;
        let middle = angle(cubic, t + step);
        if middle <= theta {
            (t, low) = (t + step, middle);
        } else {
            high = middle;
        }
    }
    t += step * ((theta - low) / (high - low).max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
    Some((first as f32 + t) / last as f32 * radius(rays))
}
