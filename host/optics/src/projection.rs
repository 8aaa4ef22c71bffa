//! What the stitched picture is: output pixel to direction and back, and nothing else.

mod range;
mod rows;

pub use range::ViewRange;
pub use rows::RowRays;

use nalgebra::{Rotation3, Vector3};

use crate::convention::{angle_between, yaw_pitch};

/// Formula from view-plane coordinates (u right, v down) to a direction in the view frame (x
/// forward, y left, z up). The table's output map uses the same ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ViewFormula {
    /// u = -yaw, v = pitch, rad.
    Equirect,
    /// u = -yaw in rad, v = tan(pitch).
    Cylindrical,
    /// (u, v) = angle off the x axis in rad times (right, down).
    Fisheye,
    /// (u, v) = (-y/x, -z/x).
    Perspective,
}

/// A projection with its parameters; turn it into an [`OutputMap`] with a picture size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Projection {
    /// Yaw and pitch on straight axes, body frame: 360 x 180 degrees.
    Equirect,
    /// The same about the plane through both optical axes: the middle of the picture is the
    /// middle of the overlap (Tong et al. 2024, Fig. 9-10). The frame is body <- view.
    Design(Rotation3<f64>),
    /// A full turn on a cylinder about the body's z; rows are tangents of the pitch.
    Cylindrical {
        /// Pitch of the upper and lower border, rad, below pi/2.
        half_height_rad: f64,
    },
    /// Equidistant fisheye picture about any axis.
    Fisheye {
        /// Body <- view.
        rotation: Rotation3<f64>,
        /// Angle across the smaller side, rad, at most 2 pi.
        field_rad: f64,
    },
    /// Perspective picture about any axis: a virtual gimbal camera.
    Perspective {
        /// Body <- view.
        rotation: Rotation3<f64>,
        /// Angle across the width, rad.
        width_rad: f64,
    },
}

/// Why a projection cannot be had.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ProjectionError {
    /// An angle out of range.
    #[error("{what} of {degrees} degrees is not allowed ({allowed})")]
    Angle {
        /// Which angle.
        what: &'static str,
        /// Its value.
        degrees: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A range of yaw or pitch that no picture can show.
    #[error("the range of {what} from {from_deg} to {to_deg} degrees is not allowed ({allowed})")]
    Range {
        /// Which angle.
        what: &'static str,
        /// Its first value.
        from_deg: f64,
        /// Its second value.
        to_deg: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A projection about an axis, which has a field instead of ranges.
    #[error(
        "ranges of yaw and pitch go with the equirect, cylindrical and design projections: a \
         fisheye or perspective picture has an axis and a field"
    )]
    NoRange,
    /// A width or height of 0.
    #[error("the picture must be at least 1x1 px")]
    Size,
    /// The optical axes are parallel: there is no plane through both.
    #[error("the optical axes are parallel or opposite: no design plane; use another projection")]
    NoDesignPlane,
}

/// Greatest pitch of a cylinder's border, rad: its rows are tangents.
const MAX_CYLINDER_PITCH_RAD: f64 = 1.44;
/// A projection fitted to a picture: `u = u0 + x du`, `v = v0 + y dv`, then the formula, then the
/// rotation into the body frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutputMap {
    /// Width and height, px.
    pub size_px: [u16; 2],
    /// Formula.
    pub formula: ViewFormula,
    /// Body <- view.
    pub rotation: Rotation3<f64>,
    /// `[u0, du]`: of pixel column 0, and to a pixel.
    pub u: [f64; 2],
    /// `[v0, dv]`: of pixel row 0, and to a pixel.
    pub v: [f64; 2],
}

impl Projection {
    /// The frame of [`Projection::Design`] for two optical axes: x to the middle of the overlap,
    /// y in the plane towards the left eye, z normal to the plane.
    ///
    /// # Errors
    /// [`ProjectionError::NoDesignPlane`] if the axes span no plane.
    pub fn design(left: &Vector3<f64>, right: &Vector3<f64>) -> Result<Self, ProjectionError> {
        let (middle, across) = (left + right, left - right);
        // Below a thousandth the plane would be noise.
        if middle.norm() < 1e-3 || across.norm() < 1e-3 {
            return Err(ProjectionError::NoDesignPlane);
        }
        let x = middle.normalize();
        // Unit vectors: their sum and difference are at right angles.
        let y = across.normalize();
        let columns = [x, y, x.cross(&y)];
        Ok(Self::Design(Rotation3::from_matrix_unchecked(
            nalgebra::Matrix3::from_columns(&columns),
        )))
    }

    /// Fits the projection to a picture of `size_px`.
    ///
    /// # Errors
    /// [`ProjectionError`] if an angle or the size is out of range.
    pub fn output_map(&self, size_px: [u16; 2]) -> Result<OutputMap, ProjectionError> {
        use std::f64::consts::{PI, TAU};
        if size_px.contains(&0) {
            return Err(ProjectionError::Size);
        }
        let [width, height] = size_px.map(f64::from);
        let check = |what, rad: f64, max_rad: f64, allowed| {
            if rad > 0.0 && rad < max_rad {
                Ok(())
            } else {
                Err(ProjectionError::Angle {
                    what,
                    degrees: rad.to_degrees(),
                    allowed,
                })
            }
        };
        let identity = Rotation3::identity();
        // Extents of u and v over the whole picture, centred on the view axis.
        let (formula, rotation, u, v) = match *self {
            Self::Equirect => (ViewFormula::Equirect, identity, TAU, PI),
            Self::Design(rotation) => (ViewFormula::Equirect, rotation, TAU, PI),
            Self::Cylindrical { half_height_rad } => {
                check(
                    "half height",
                    half_height_rad,
                    MAX_CYLINDER_PITCH_RAD,
                    "above 0, below 82.5",
                )?;
                (
                    ViewFormula::Cylindrical,
                    identity,
                    TAU,
                    2.0 * libm::tan(half_height_rad),
                )
            }
            Self::Fisheye {
                rotation,
                field_rad,
            } => {
                check("field", field_rad, TAU + 1e-9, "above 0, at most 360")?;
                let scale = field_rad / width.min(height);
                (
                    ViewFormula::Fisheye,
                    rotation,
                    scale * width,
                    scale * height,
                )
            }
            Self::Perspective {
                rotation,
                width_rad,
            } => {
                check("field", width_rad, 2.88, "above 0, below 165")?;
                let u = 2.0 * libm::tan(width_rad / 2.0);
                (ViewFormula::Perspective, rotation, u, u * height / width)
            }
        };
        let [du, dv] = [u / width, v / height];
        Ok(OutputMap {
            size_px,
            formula,
            rotation,
            u: [(du - u) / 2.0, du],
            v: [(dv - v) / 2.0, dv],
        })
    }
}

impl OutputMap {
    /// Unit direction in the body frame of picture position (x, y); `None` where the projection
    /// holds none.
    pub fn ray(&self, x: f64, y: f64) -> Option<Vector3<f64>> {
        let (u, v) = (self.u[0] + x * self.u[1], self.v[0] + y * self.v[1]);
        let view = match self.formula {
            ViewFormula::Equirect => {
                // The half-pixel beyond a pole would be the other side of the sphere.
                let inside = v.abs() <= std::f64::consts::FRAC_PI_2 + 1e-12;
                inside.then(|| crate::convention::direction(-u, v))?
            }
            ViewFormula::Cylindrical => Vector3::new(libm::cos(u), -libm::sin(u), -v).normalize(),
            ViewFormula::Fisheye => {
                let theta = libm::hypot(u, v);
                if theta > std::f64::consts::PI {
                    return None;
                }
                let k = if theta > 0.0 {
                    libm::sin(theta) / theta
                } else {
                    1.0
                };
                Vector3::new(libm::cos(theta), -k * u, -k * v)
            }
            ViewFormula::Perspective => Vector3::new(1.0, -u, -v).normalize(),
        };
        Some(self.rotation * view)
    }

    /// Whether the picture is a full turn, so that its left and right border are neighbours.
    pub fn wraps(&self) -> bool {
        let turn = f64::from(self.size_px[0]) * self.u[1];
        matches!(
            self.formula,
            ViewFormula::Equirect | ViewFormula::Cylindrical
        ) && (turn - std::f64::consts::TAU).abs() < 1e-9
    }

    /// Picture position of a body-frame direction of any length; `None` if it lies outside the
    /// picture, which covers -0.5 to size - 0.5.
    pub fn pixel(&self, direction: &Vector3<f64>) -> Option<[f64; 2]> {
        let view = self.rotation.inverse() * direction;
        let (yaw, pitch) = yaw_pitch(&view);
        let [u, v] = match self.formula {
            ViewFormula::Equirect => [-yaw, pitch],
            ViewFormula::Cylindrical => [-yaw, -view.z / libm::hypot(view.x, view.y)],
            ViewFormula::Fisheye => {
                let across = libm::hypot(view.y, view.z);
                let theta = angle_between(&view, &Vector3::x());
                let k = if across > 0.0 { theta / across } else { 0.0 };
                [-k * view.y, -k * view.z]
            }
            ViewFormula::Perspective if view.x > 0.0 => [-view.y / view.x, -view.z / view.x],
            ViewFormula::Perspective => return None,
        };
        // A range of yaw may cross the back, where the angle starts anew.
        let turns: &[f64] = match self.formula {
            ViewFormula::Equirect | ViewFormula::Cylindrical => {
                &[0.0, std::f64::consts::TAU, -std::f64::consts::TAU]
            }
            ViewFormula::Fisheye | ViewFormula::Perspective => &[0.0],
        };
        let inside = |p: f64, side: u16| (-0.5..=f64::from(side) - 0.5).contains(&p);
        turns
            .iter()
            .map(|turn| {
                [
                    (u + turn - self.u[0]) / self.u[1],
                    (v - self.v[0]) / self.v[1],
                ]
            })
            .find(|[x, y]| inside(*x, self.size_px[0]) && inside(*y, self.size_px[1]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pose::{Pose, Side, rotation_vector};

    fn maps() -> Vec<OutputMap> {
        let rotation = rotation_vector(&Vector3::new(0.3, -0.8, 1.1));
        let axis = |side| Pose::mount_rotation(side, 0.45, 0.51) * Vector3::z();
        let projections = [
            Projection::Equirect,
            Projection::design(&axis(Side::Left), &axis(Side::Right)).unwrap(),
            Projection::Cylindrical {
                half_height_rad: 1.1,
            },
            Projection::Fisheye {
                rotation,
                field_rad: 3.9,
            },
            Projection::Perspective {
                rotation,
                width_rad: 1.7,
            },
        ];
        let parts = [
            ([-2.3, 2.3], [-1.2, 0.9]),
            // Across the back, and from a pole.
            ([1.4, 4.9], [-std::f64::consts::FRAC_PI_2, 0.2]),
            ([-6.0, -0.5], [-0.1, 1.1]),
        ];
        let mut maps: Vec<OutputMap> = projections
            .iter()
            .map(|p| p.output_map([64, 40]).unwrap())
            .collect();
        for (yaw_rad, mut pitch_rad) in parts {
            for projection in &projections[..3] {
                if matches!(projection, Projection::Cylindrical { .. }) {
                    pitch_rad = pitch_rad.map(|rad| rad.max(-1.4));
                }
                let range = ViewRange { yaw_rad, pitch_rad };
                maps.push(projection.output_map_of_range([64, 40], &range).unwrap());
            }
        }
        maps
    }

    #[test]
    fn rows_of_rays_are_the_rays_to_the_bit() {
        for map in maps() {
            let rays = RowRays::new(&map);
            for y in 0..usize::from(map.size_px[1]) {
                let row = rays.row(y);
                for x in 0..usize::from(map.size_px[0]) {
                    assert_eq!(row(x), map.ray(x as f64, y as f64), "{map:?} {x} {y}");
                }
            }
        }
    }

    #[test]
    fn the_whole_range_is_the_whole_picture_to_the_bit() {
        for projection in [
            Projection::Equirect,
            Projection::Design(rotation_vector(&Vector3::new(0.3, -0.8, 1.1))),
            Projection::Cylindrical {
                half_height_rad: 1.1,
            },
        ] {
            for size_px in [[640, 320], [123, 77]] {
                let whole = projection.whole_range().unwrap();
                let part = projection.output_map_of_range(size_px, &whole).unwrap();
                assert_eq!(part, projection.output_map(size_px).unwrap());
                assert!(part.wraps());
            }
        }
    }

    #[test]
    fn borders_of_a_range_are_borders_of_the_picture() {
        let deg = |range: [f64; 2]| range.map(f64::to_radians);
        let range = ViewRange {
            yaw_rad: deg([90.0, 250.0]),
            pitch_rad: deg([-60.0, 40.0]),
        };
        for projection in [
            Projection::Equirect,
            Projection::Cylindrical {
                half_height_rad: 1.0,
            },
        ] {
            let map = projection.output_map_of_range([320, 200], &range).unwrap();
            assert!(!map.wraps());
            let found = map.range().unwrap();
            for (found, wanted) in [
                (found.yaw_rad, range.yaw_rad),
                (found.pitch_rad, range.pitch_rad),
            ] {
                for k in 0..2 {
                    assert!((found[k] - wanted[k]).abs() < 1e-12, "{found:?} {wanted:?}");
                }
            }
            // 250 degrees is -110: on the left border, and 90 on the right one.
            let at = |yaw: f64| {
                let direction = crate::convention::direction(yaw.to_radians(), 0.0);
                map.pixel(&direction).map(|[x, _]| x)
            };
            assert!((at(-110.001).unwrap() + 0.5).abs() < 0.01);
            assert!((at(90.001).unwrap() - 319.5).abs() < 0.01);
            assert_eq!(at(89.0), None);
            assert_eq!(at(-109.0), None);
        }
    }

    #[test]
    fn ranges_that_no_picture_can_show_are_refused() {
        let turn = [-3.0, 3.0];
        let rows = [-1.0, 1.0];
        for (yaw_rad, pitch_rad) in [
            ([1.0, 1.0], rows),
            ([2.0, -2.0], rows),
            ([-4.0, 4.0], rows),
            ([-7.0, -6.0], rows),
            ([f64::NAN, 1.0], rows),
            (turn, [0.5, -0.5]),
            (turn, [-1.6, 0.0]),
            (turn, [-1.0, f64::INFINITY]),
        ] {
            let range = ViewRange { yaw_rad, pitch_rad };
            let refused = Projection::Equirect.output_map_of_range([64, 32], &range);
            assert!(
                matches!(refused, Err(ProjectionError::Range { .. })),
                "{range:?}"
            );
        }
        let range = ViewRange {
            yaw_rad: turn,
            pitch_rad: [-1.5, 1.5],
        };
        let cylinder = Projection::Cylindrical {
            half_height_rad: 1.0,
        };
        let refused = cylinder.output_map_of_range([64, 32], &range);
        assert!(matches!(refused, Err(ProjectionError::Range { .. })));
        let axis = Projection::Perspective {
            rotation: Rotation3::identity(),
            width_rad: 1.0,
        };
        let refused = axis.output_map_of_range([64, 32], &range);
        assert_eq!(refused, Err(ProjectionError::NoRange));
    }

    #[test]
    fn there_and_back() {
        for map in maps() {
            for y in 0..40 {
                for x in 0..64 {
                    let (x, y) = (f64::from(x), f64::from(y));
                    let Some(ray) = map.ray(x, y) else { continue };
                    let [px, py] = map.pixel(&ray).unwrap_or_else(|| panic!("{map:?} {x} {y}"));
                    // Rounding of a few dozen operations on numbers up to 64.
                    assert!(
                        (px - x).abs() < 1e-9 && (py - y).abs() < 1e-9,
                        "{map:?} {x} {y}"
                    );
                }
            }
        }
    }

    #[test]
    fn equirect_has_left_on_the_left_and_up_on_top() {
        let map = Projection::Equirect.output_map([640, 320]).unwrap();
        let [x, y] = map.pixel(&Vector3::x()).unwrap();
        assert!((x - 319.5).abs() < 1e-9 && (y - 159.5).abs() < 1e-9);
        let [x, _] = map.pixel(&Vector3::y()).unwrap();
        assert!((x - 159.5).abs() < 1e-9);
        let ray = map.ray(0.0, 0.0).unwrap();
        assert!(ray.z > 0.99);
    }

    #[test]
    fn design_puts_the_axes_on_the_equator_half_of_gamma_apart() {
        let (psi, tau) = (25.7f64.to_radians(), 29.15f64.to_radians());
        let [left, right] = [Side::Left, Side::Right]
            .map(|side| Pose::mount_rotation(side, psi, tau) * Vector3::z());
        let map = Projection::design(&left, &right)
            .unwrap()
            .output_map([3600, 1800])
            .unwrap();
        let [lx, ly] = map.pixel(&left).unwrap();
        let [rx, ry] = map.pixel(&right).unwrap();
        // gamma = 116.745 degrees at 10 px to a degree; the paper's angles have 3 digits.
        assert!((rx - lx - 1167.45).abs() < 0.01, "{}", rx - lx);
        assert!((ly - 899.5).abs() < 1e-6 && (ry - 899.5).abs() < 1e-6);
        assert_eq!(
            Projection::design(&left, &left),
            Err(ProjectionError::NoDesignPlane)
        );
    }

    #[test]
    fn absurd_angles_are_refused() {
        for projection in [
            Projection::Perspective {
                rotation: Rotation3::identity(),
                width_rad: 3.1,
            },
            Projection::Fisheye {
                rotation: Rotation3::identity(),
                field_rad: f64::NAN,
            },
            Projection::Cylindrical {
                half_height_rad: 0.0,
            },
        ] {
            assert!(matches!(
                projection.output_map([10, 10]),
                Err(ProjectionError::Angle { .. })
            ));
        }
        assert_eq!(
            Projection::Equirect.output_map([0, 3]),
            Err(ProjectionError::Size)
        );
    }
}
