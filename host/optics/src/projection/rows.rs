//! Directions of the pixels of whole rows.

use nalgebra::Vector3;

use super::{OutputMap, ViewFormula};

/// Directions of a picture's pixels, row by row: those of [`OutputMap::ray`], to the bit. Sines and
/// cosines that a whole column or row has in common are computed once.
#[derive(Debug, Clone)]
pub struct RowRays {
    map: OutputMap,
    /// Cosine and sine of each column's yaw; empty where the projection has none.
    yaw: Vec<[f64; 2]>,
}

impl RowRays {
    /// Of a picture.
    pub fn new(map: &OutputMap) -> Self {
        let columns = 0..usize::from(map.size_px[0]);
        let yaw = |x: usize| {
            let u = map.u[0] + x as f64 * map.u[1];
            [libm::cos(-u), libm::sin(-u)]
        };
        Self {
            map: *map,
            yaw: match map.formula {
                ViewFormula::Equirect => columns.map(yaw).collect(),
                _ => Vec::new(),
            },
        }
    }

    /// The directions of row `y`, by column: unit vectors in the body frame, `None` where the
    /// projection holds none.
    pub fn row(&self, y: usize) -> impl Fn(usize) -> Option<Vector3<f64>> + '_ {
        let v = self.map.v[0] + y as f64 * self.map.v[1];
        let [cos_pitch, sin_pitch] = [libm::cos(v), libm::sin(v)];
        move |x| match self.yaw.get(x) {
            Some([cos_yaw, sin_yaw]) if v.abs() <= std::f64::consts::FRAC_PI_2 => {
                let view = Vector3::new(cos_pitch * cos_yaw, cos_pitch * sin_yaw, -sin_pitch);
                Some(self.map.rotation * view)
            }
            _ => self.map.ray(x as f64, y as f64),
        }
    }
}
