//! The basin: where a ray leaves it and what its tiles look like.

use crate::contact::{Contact, Seen, Wall};
use crate::description::Pool;
use crate::noise::{cell_hash, gradient, octaves, unit};
use crate::pattern::{band, bands};
use crate::ray::Ray;
use nalgebra::{Point3, Vector3};

/// Joint between tiles, as a share of a tile.
const GROUT: f64 = 0.06;
/// Mean of the eighth power of a noise ridge, measured over the floor.
const RIDGE_MEAN: f64 = 0.297;
/// Width of the dark lane line on the floor, m.
const LANE_M: f64 = 0.25;

/// The basin, ready for tracing.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Basin {
    /// Half length, half width, half depth of the water, m.
    pub half_m: Vector3<f64>,
    /// Height of the rim, m.
    pub rim_z_m: f64,
    tile_m: f64,
    seed: u64,
}

impl Basin {
    pub fn new(pool: &Pool, texture_seed: u32) -> Self {
        let half_m = Vector3::new(pool.length_m, pool.width_m, pool.depth_m) / 2.0;
        Self {
            half_m,
            rim_z_m: half_m.z + pool.freeboard_m,
            tile_m: pool.tile_mm / 1000.0,
            seed: texture_seed.into(),
        }
    }

    /// The floor or wall that a ray from inside reaches, or `None` when it leaves through the top.
    pub fn meet(&self, ray: &Ray) -> Option<Contact> {
        let to_side = |k: usize| {
            let speed = ray.direction[k];
            (self.half_m[k].copysign(speed) - ray.origin_m[k]) / speed
        };
        // Along an axis with no speed the range is infinite (or 0/0, which `<` never picks).
        let axis = if to_side(0) < to_side(1) || ray.direction.y == 0.0 {
            0
        } else {
            1
        };
        let side_m = if ray.direction[axis] == 0.0 {
            f64::INFINITY
        } else {
            to_side(axis)
        };
        let floor_m = (-self.half_m.z - ray.origin_m.z) / ray.direction.z;
        if ray.direction.z < 0.0 && floor_m <= side_m {
            let point = ray.at(floor_m);
            return Some(Contact {
                seen: Seen::Floor,
                range_m: floor_m,
                point,
                normal: Vector3::z(),
                u_axis: Vector3::x(),
                v_axis: Vector3::y(),
                uv_m: [point.x, point.y],
            });
        }
        let point = ray.at(side_m);
        // Straight up there is no side, and no height at which it is met.
        if side_m.is_infinite() || point.z > self.rim_z_m {
            return None;
        }
        let positive = ray.direction[axis] > 0.0;
        let wall = match (axis, positive) {
            (0, true) => Wall::Front,
            (0, false) => Wall::Back,
            (_, true) => Wall::Left,
            (_, false) => Wall::Right,
        };
        let mut normal = Vector3::zeros();
        normal[axis] = if positive { -1.0 } else { 1.0 };
        let u_axis = if axis == 0 {
            Vector3::y()
        } else {
            Vector3::x()
        };
        Some(Contact {
            seen: Seen::Wall(wall),
            range_m: side_m,
            point,
            normal,
            u_axis,
            v_axis: Vector3::z(),
            uv_m: [point[1 - axis], point.z],
        })
    }

    /// Reflectance of a floor or wall (`None`: the floor) over a footprint.
    pub fn reflectance(
        &self,
        wall: Option<Wall>,
        [u, v]: [f64; 2],
        [fu, fv]: [f64; 2],
    ) -> Vector3<f64> {
        let face = wall.map_or(0, |w| 1 + w as u64);
        let seed = self.seed << 8 | face;
        let footprint = fu.max(fv);
        let tile = self.tile_m;
        let (column, row) = ((u / tile).floor(), (v / tile).floor());
        let shade = unit(cell_hash(seed, column as i64, row as i64)) - 0.5;
        let pick = unit(cell_hash(!seed, column as i64, row as i64));
        // Tiles smaller than the footprint melt into their mean.
        let sharp = (tile / footprint.max(1e-9) / 2.0 - 0.5).clamp(0.0, 1.0);

        let (base, lines) = match wall {
            None => (
                Vector3::new(0.39, 0.49, 0.53),
                self.lane_lines([u, v], [fu, fv]),
            ),
            Some(wall) => (
                Vector3::new(0.56, 0.66, 0.68),
                self.wall_lines(wall, [u, v], [fu, fv]),
            ),
        };
        let accent = wall.map_or(Vector3::new(0.10, 0.32, 0.50), accent);
        let mosaic = if pick < 0.07 {
            sharp * 0.55
        } else {
            0.07 * 0.55 * (1.0 - sharp)
        };
        let glaze = base.lerp(&accent, mosaic) * (1.0 + 0.30 * shade * sharp);
        let ink = Vector3::new(0.02, 0.07, 0.20) * (1.0 + 0.4 * shade * sharp);
        let tile_color = glaze.lerp(&ink, lines);

        let joint = GROUT * tile;
        let grout_u = bands(u + joint / 2.0, fu, tile, joint);
        let grout_v = bands(v + joint / 2.0, fv, tile, joint);
        let grout = 1.0 - (1.0 - grout_u) * (1.0 - grout_v);
        let color = tile_color.lerp(&Vector3::new(0.24, 0.28, 0.28), grout);
        // Dirt and lime, from metres down to millimetres.
        color * (1.0 + 0.30 * octaves(seed, [u, v], 1.6, 10, footprint)).max(0.25)
    }

    /// Three dark lines along the pool, each ending in a T before the end walls, and a short line
    /// across the middle.
    fn lane_lines(&self, [u, v]: [f64; 2], [fu, fv]: [f64; 2]) -> f64 {
        let half = LANE_M / 2.0;
        let end_m = self.half_m.x * 0.84;
        let along = band(u, fu, -end_m, end_m);
        let tee = band(u.abs(), fu, end_m - LANE_M, end_m);
        let spacing = self.half_m.y * 0.5;
        [-spacing, 0.0, spacing].iter().fold(0.0, |ink: f64, lane| {
            let line = band(v, fv, lane - half, lane + half) * along;
            let bar = band(v, fv, lane - 0.5, lane + 0.5) * tee;
            ink.max(line).max(bar)
        })
    }

    /// A dark waterline, crosses where the lanes end, a ladder of depth marks on the long walls.
    fn wall_lines(&self, wall: Wall, [u, v]: [f64; 2], [fu, fv]: [f64; 2]) -> f64 {
        let top = self.half_m.z;
        let waterline = band(v, fv, top - 0.16, top - 0.04);
        let marks = match wall {
            Wall::Front | Wall::Back => {
                let spacing = self.half_m.y * 0.5;
                let middle = -0.1 * self.half_m.z;
                [-spacing, 0.0, spacing].iter().fold(0.0, |ink: f64, lane| {
                    let upright = band(u, fu, lane - 0.09, lane + 0.09)
                        * band(v, fv, middle - 0.45, middle + 0.45);
                    let across = band(u, fu, lane - 0.4, lane + 0.4)
                        * band(v, fv, middle - 0.09, middle + 0.09);
                    ink.max(upright).max(across)
                })
            }
            Wall::Left | Wall::Right => {
                // Every metre a stroke, from the floor up to half height.
                bands(u + 0.04, fu, 1.0, 0.08) * band(v, fv, -2.0 * top, -0.35 * top)
            }
        };
        waterline.max(marks)
    }

    /// Darkening in the edges between floor and walls, 0.6 to 1: light from half the sides is missing.
    pub fn openness(&self, point: &Point3<f64>) -> f64 {
        let gaps = [
            self.half_m.x - point.x.abs(),
            self.half_m.y - point.y.abs(),
            point.z + self.half_m.z,
        ];
        gaps.iter().fold(1.0, |light, gap| {
            let gap = gap.max(0.0);
            // The face that the point is on has gap 0: a factor of 0.6 that the division below
            // takes back.
            light * (0.6 + 0.4 * gap / (gap + 0.12))
        }) / 0.6
    }

    /// Brightness of the light web that waves throw on surfaces, mean about 1.
    pub fn caustics(&self, point: &Point3<f64>, footprint_m: f64) -> f64 {
        // Light comes down a little slanted: on walls the web becomes long streaks.
        let drop = self.half_m.z - point.z;
        let (x, y) = (point.x - 0.4 * drop, point.y + 0.2 * drop);
        let seed = self.seed << 8 | 0xCA;
        let bend = gradient(seed, x / 0.9, y / 0.9);
        let (x, y) = (x + 0.22 * bend, y - 0.19 * bend);
        let web = |seed: u64, wavelength_m: f64| {
            let keep = (wavelength_m / footprint_m.max(1e-9) / 6.0 - 1.0).clamp(0.0, 1.0);
            let ridge = 1.0
                - gradient(seed, x / wavelength_m, y / wavelength_m)
                    .abs()
                    .min(1.0);
            let ridge4 = ridge * ridge * ridge * ridge;
            RIDGE_MEAN + keep * (ridge4 * ridge4 - RIDGE_MEAN)
        };
        0.35 + 0.65 * (web(seed ^ 1, 0.55) + web(seed ^ 2, 0.36)) / (2.0 * RIDGE_MEAN)
    }
}

/// The colour that tells one wall from another.
fn accent(wall: Wall) -> Vector3<f64> {
    match wall {
        Wall::Front => Vector3::new(0.72, 0.30, 0.08),
        Wall::Back => Vector3::new(0.42, 0.16, 0.44),
        Wall::Left => Vector3::new(0.70, 0.58, 0.10),
        Wall::Right => Vector3::new(0.08, 0.42, 0.24),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::SceneDescription;
    use crate::medium::Medium;

    fn basin() -> Basin {
        let description = SceneDescription::furnished(Medium::Air);
        Basin::new(&description.pool, description.texture_seed)
    }

    #[test]
    fn caustics_move_light_about_and_make_none() {
        let basin = basin();
        let at = |k: i32| {
            let (i, j) = (f64::from(k % 200), f64::from(k / 200));
            basin.caustics(&Point3::new(i * 0.0591 - 5.9, j * 0.0391 - 3.9, -1.2), 0.0)
        };
        let light: Vec<f64> = (0..40_000).map(at).collect();
        let mean = light.iter().sum::<f64>() / light.len() as f64;
        // Some 300 by 300 mm cells of noise fill the floor: its mean is good to a few per cent.
        assert!((mean - 1.0).abs() < 0.06, "{mean}");
        assert!(light.iter().all(|l| *l >= 0.35 && *l < 2.6));
        let blurred = basin.caustics(&Point3::origin(), 1.0);
        assert!(
            (blurred - 1.0).abs() < 1e-12,
            "too fine for the footprint: the mean"
        );
    }

    #[test]
    fn lane_lines_are_dark_and_straight() {
        let basin = basin();
        let green = |u, v| basin.reflectance(None, [u, v], [0.01, 0.01]).y;
        for k in 0..40 {
            // Middle of tiles (150 mm), off the joints, along the middle lane and between lanes.
            let u = 0.075 + 0.15 * f64::from(k - 20);
            assert!(green(u, 0.075) < 0.2, "lane line at {u}");
            assert!(green(u, 1.125) > 0.2, "plain floor at {u}");
        }
    }

    #[test]
    fn edges_are_darker_than_the_middle_of_the_floor() {
        let basin = basin();
        let middle = basin.openness(&Point3::new(0.0, 0.0, -1.2));
        let edge = basin.openness(&Point3::new(6.0, 0.0, -1.2));
        assert!(edge < 0.65 * middle && middle < 1.0 && edge > 0.3);
    }
}
