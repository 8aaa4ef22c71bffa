//! The same point in both eyes, as registration sees it.

use nalgebra::{Matrix3, Rotation3, Vector3};
use tectum_optics::{CameraModel, Eye, Rig, RigEye, rotation_vector};

use crate::matching::{MatchedCorner, Outcome};
use crate::{Correspondence, Eyes};

/// How far away a point is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Range {
    /// Distance from each eye, m; may be infinite.
    Known(Eyes<f64>),
    /// A corner of a board.
    Board {
        /// Distance from each eye by the board's pose in that eye, m.
        ranges_m: Eyes<f64>,
        /// Which board in which shot: any number of its own.
        board: usize,
        /// Place on the board, mm.
        point_mm: [f64; 2],
    },
    /// Anything from the nearest range to infinity, as of a natural feature.
    Unknown,
}

/// A point in both eyes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tie {
    /// Where both eyes see it.
    pub pair: Correspondence,
    /// How far away it is.
    pub range: Range,
}

impl Range {
    /// Distance from each eye, if it is known, m.
    pub fn ranges_m(&self) -> Option<Eyes<f64>> {
        match self {
            Self::Known(ranges_m) | Self::Board { ranges_m, .. } => Some(*ranges_m),
            Self::Unknown => None,
        }
    }
}

impl Tie {
    /// The corners of all boards that were matched.
    pub fn of_boards(outcomes: &[Outcome]) -> Vec<Self> {
        let corners = outcomes.iter().enumerate().flat_map(|(board, outcome)| {
            let corners = outcome.corners().iter();
            corners.map(move |corner| (board, corner))
        });
        let tie = |(board, corner): (usize, &MatchedCorner)| Self {
            pair: corner.pair,
            range: Range::Board {
                ranges_m: corner.ranges_m,
                board,
                point_mm: corner.point_mm,
            },
        };
        corners.map(tie).collect()
    }
}

impl From<Correspondence> for Tie {
    fn from(pair: Correspondence) -> Self {
        Self {
            pair,
            range: Range::Unknown,
        }
    }
}

impl Tie {
    /// Where both eyes see it, px.
    pub(super) fn pixels(&self) -> Eyes<[f64; 2]> {
        [self.pair.left_px, self.pair.right_px]
    }
}

/// What registration changes of the rig: the eyes' rotations (body <- camera) and the logarithms of
/// their lenses' scales.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Look {
    pub rotations: Eyes<Rotation3<f64>>,
    pub log_scales: Eyes<f64>,
}

/// The fixed part of a rig: lenses, and where their centres are.
#[derive(Debug, Clone, Copy)]
pub struct Mount<'a> {
    pub eyes: Eyes<&'a Eye>,
    /// Centres of projection about the middle between them, m.
    pub centres_m: Eyes<Vector3<f64>>,
    /// Inverse of the nearest range of points whose range is not known, 1/m.
    pub most_inverse: f64,
}

/// A tie's rays with their derivatives by the logarithm of the lens's scale.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rays {
    pub rays: Eyes<Vector3<f64>>,
    pub by_scale: Eyes<Vector3<f64>>,
}

/// A tie's residual: difference of the unit directions, from the middle between the eyes, in which
/// both see the point (Eq. 6 of Tong et al. 2024 on rays). Its length is the chord of the angle,
/// 2 sin(angle / 2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Residual {
    pub off: Vector3<f64>,
    /// By a further small turn of each eye in the body frame.
    pub by_turn: Eyes<Matrix3<f64>>,
    /// By the logarithm of each lens's scale.
    pub by_scale: Eyes<Vector3<f64>>,
    /// Inverse distance from each eye, 1/m.
    pub inverse: Eyes<f64>,
}

impl<'a> Mount<'a> {
    pub fn new(eyes: Eyes<&'a RigEye>, nearest_m: f64) -> Self {
        let middle = (eyes[0].pose.position_m + eyes[1].pose.position_m) / 2.0;
        Self {
            eyes: eyes.map(|eye| &eye.eye),
            centres_m: eyes.map(|eye| eye.pose.position_m - middle),
            most_inverse: 1.0 / nearest_m,
        }
    }

    /// From the left centre to the right.
    pub fn baseline(&self) -> Vector3<f64> {
        self.centres_m[1] - self.centres_m[0]
    }

    /// Rays of a tie; `None` where a lens has none.
    pub fn rays(&self, tie: &Tie, log_scales: Eyes<f64>) -> Option<Rays> {
        /// Step of the derivative: lenses answer for pixels, not for slopes.
        const STEP: f64 = 1e-5;
        let pixels = tie.pixels();
        let at = |eye: usize, by: f64| {
            scaled_ray(&self.eyes[eye].model, pixels[eye], log_scales[eye] + by)
        };
        let slope = |eye| Some((at(eye, STEP)? - at(eye, -STEP)?) / (2.0 * STEP));
        Some(Rays {
            rays: [at(0, 0.0)?, at(1, 0.0)?],
            by_scale: [slope(0)?, slope(1)?],
        })
    }

    /// Residual of a tie whose rays are known.
    pub fn residual(&self, tie: &Tie, rays: &Rays, look: &Look) -> Residual {
        let turned = [0, 1].map(|eye| look.rotations[eye] * rays.rays[eye]);
        let slopes = [0, 1].map(|eye| look.rotations[eye] * rays.by_scale[eye]);
        let (arms, inverse, shift_by_scale) = match tie.range.ranges_m() {
            // The range of a board follows the scale of the lens that measured it.
            Some(ranges_m) => {
                let inverse =
                    [0, 1].map(|eye: usize| libm::exp(-look.log_scales[eye]) / ranges_m[eye]);
                let arms = [0, 1].map(|eye: usize| self.centres_m[eye] * inverse[eye]);
                (arms, inverse, arms.map(|arm| -arm))
            }
            None => {
                let inverse = self.nearest_inverse(&turned);
                let arm = self.baseline() * inverse;
                let point = turned[1] + arm;
                let inverses = [inverse / point.norm(), inverse];
                ([Vector3::zeros(), arm], inverses, [Vector3::zeros(); 2])
            }
        };
        let seen = [0, 1].map(|eye: usize| turned[eye] + arms[eye]);
        let project = seen.map(|point| {
            let direction = point.normalize();
            (Matrix3::identity() - direction * direction.transpose()) / point.norm()
        });
        let sign = [1.0, -1.0];
        Residual {
            off: seen[0].normalize() - seen[1].normalize(),
            by_turn: [0, 1]
                .map(|eye: usize| project[eye] * -turned[eye].cross_matrix() * sign[eye]),
            by_scale: [0, 1]
                .map(|eye: usize| project[eye] * (slopes[eye] + shift_by_scale[eye]) * sign[eye]),
            inverse,
        }
    }

    /// Inverse range from the right eye, 0 to the most, at which the right eye's point comes nearest
    /// to the left eye's line of sight, as seen from the left eye: the nearest place on the arc that
    /// the right ray draws there.
    fn nearest_inverse(&self, turned: &Eyes<Vector3<f64>>) -> f64 {
        let [seen, ray] = turned;
        let along = self.baseline();
        // The left ray in the plane of right ray and baseline is alpha ray + beta baseline.
        let (rb, bb) = (ray.dot(&along), along.norm_squared());
        let (rs, bs) = (ray.dot(seen), along.dot(seen));
        let determinant = bb - rb * rb;
        if determinant <= 1e-12 * bb.max(f64::MIN_POSITIVE) {
            return 0.0;
        }
        let (alpha, beta) = (rs * bb - bs * rb, bs - rs * rb);
        if alpha > 0.0 {
            return (beta / alpha).clamp(0.0, self.most_inverse);
        }
        let off = |inverse: f64| (ray + along * inverse).normalize().dot(seen);
        if off(self.most_inverse) > off(0.0) {
            self.most_inverse
        } else {
            0.0
        }
    }
}

/// Ray through a pixel of a lens whose picture is `exp(log_scale)` times as large about its
/// principal point.
fn scaled_ray(model: &CameraModel, pixel: [f64; 2], log_scale: f64) -> Option<Vector3<f64>> {
    let centre = model.principal_point_px();
    let shrink = libm::exp(-log_scale);
    let pixel = [0, 1].map(|k: usize| centre[k] + (pixel[k] - centre[k]) * shrink);
    model.unproject(pixel).ok()
}

/// Both eyes of a rig as they look, with a further turn of each (rotation vector, body frame).
pub fn turned(rig: &Eyes<&RigEye>, turns: &Eyes<Vector3<f64>>) -> Eyes<Rotation3<f64>> {
    [0, 1].map(|eye: usize| rotation_vector(&turns[eye]) * rig[eye].pose.rotation)
}

/// Both eyes of a rig.
pub fn both(rig: &Rig) -> Result<Eyes<&RigEye>, super::RegistrationError> {
    let missing = super::RegistrationError::NoEye;
    Ok([
        rig.left.as_ref().ok_or(missing("left"))?,
        rig.right.as_ref().ok_or(missing("right"))?,
    ])
}
