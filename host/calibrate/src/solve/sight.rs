//! A view as the solver sees it, and poses that move.

use nalgebra::{Matrix3, Rotation3, Vector2, Vector3, Vector6};

use crate::board_shape::{TERMS, Terms, by_terms, is_anchored};
use crate::{BoardPose, BoardSize, View};

/// A corner: where on the board (squares, about the view's mean), where in the picture (px).
#[derive(Debug, Clone, Copy)]
pub struct Target {
    /// On the board; z = 0 where that is flat.
    pub point: Vector3<f64>,
    /// The same by the terms of the board's shape; 0 where the view does not tell its place on it.
    pub by_shape: [Vector3<f64>; TERMS],
    /// In the picture, px.
    pub pixel: Vector2<f64>,
    /// Takes part.
    pub used: bool,
}

impl Target {
    /// Place on the board with a shape on top of that which it has.
    pub fn shaped(&self, shape: &Terms) -> Vector3<f64> {
        let moved = self.by_shape.iter().zip(shape.iter());
        self.point + moved.map(|(by, term)| by * *term).sum::<Vector3<f64>>()
    }
}

/// The corners of a view.
#[derive(Debug, Clone)]
pub struct Sight {
    /// In the order of the view.
    pub targets: Vec<Target>,
    /// What was taken off the labels, so that any origin of them gives the same numbers.
    pub origin: Vector3<f64>,
}

impl Sight {
    /// Corners of a view of a flat board, all in use.
    pub fn new(view: &View, board: BoardSize) -> Self {
        let anchored = is_anchored(view, board);
        let label = |c: &crate::Corner| Vector3::new(f64::from(c.i), f64::from(c.j), 0.0);
        let count = view.corners.len().max(1) as f64;
        let origin = view.corners.iter().map(label).sum::<Vector3<f64>>() / count;
        let targets = view.corners.iter().map(|c| Target {
            point: label(c) - origin,
            by_shape: match anchored {
                true => by_terms(board, c.i, c.j),
                false => [Vector3::zeros(); TERMS],
            },
            pixel: Vector2::from(c.position_px),
            used: true,
        });
        Self {
            targets: targets.collect(),
            origin,
        }
    }

    /// The same with a shape on top of that which the board has.
    pub fn shaped(mut self, shape: &Terms) -> Self {
        for target in &mut self.targets {
            target.point = target.shaped(shape);
        }
        self
    }

    /// Corners in use.
    pub fn used(&self) -> impl Iterator<Item = &Target> {
        self.targets.iter().filter(|target| target.used)
    }

    /// Number of corners in use.
    pub fn count(&self) -> usize {
        self.used().count()
    }
}

/// Camera <- board; lengths in squares.
#[derive(Debug, Clone, Copy)]
pub struct Pose {
    /// Rotation.
    pub rotation: Matrix3<f64>,
    /// Where the mean of the labels is.
    pub position: Vector3<f64>,
}

impl Pose {
    /// Turned by the rotation vector `step[0..3]` in the camera frame, then moved by `step[3..6]`.
    pub fn moved(&self, step: &Vector6<f64>) -> Self {
        let turn = rotation(&step.fixed_rows::<3>(0).into_owned());
        Self {
            rotation: turn * self.rotation,
            position: self.position + step.fixed_rows::<3>(3),
        }
    }

    /// A point of the board in the camera frame.
    pub fn apply(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.rotation * point + self.position
    }

    /// In the board's own labels and mm.
    pub fn to_board(self, sight: &Sight, square_mm: f64) -> BoardPose {
        BoardPose {
            rotation: Rotation3::from_matrix_unchecked(self.rotation),
            position_mm: (self.position - self.rotation * sight.origin) * square_mm,
        }
    }
}

/// Rotation matrix of a rotation vector, by Rodrigues' formula.
pub fn rotation(v: &Vector3<f64>) -> Matrix3<f64> {
    let angle = v.norm();
    let k = v.cross_matrix();
    // sin(x) / x and (1 - cos(x)) / x^2 by their series where the quotients lose digits.
    let (a, b) = if angle < 1e-4 {
        (1.0 - angle * angle / 6.0, 0.5 - angle * angle / 24.0)
    } else {
        let half = libm::sin(angle / 2.0) / angle;
        (libm::sin(angle) / angle, 2.0 * half * half)
    };
    Matrix3::identity() + k * a + k * k * b
}

/// The rotation next to a matrix in the sense of least squares; `None` if it is singular.
pub fn nearest_rotation(matrix: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let svd = matrix.try_svd(true, true, f64::EPSILON, 100)?;
    let (u, v_t) = (svd.u?, svd.v_t?);
    let mut flip = Matrix3::identity();
    flip[(2, 2)] = (u * v_t).determinant().signum();
    let nearest = u * flip * v_t;
    nearest.iter().all(|x| x.is_finite()).then_some(nearest)
}
