//! Boards before two eyes, with truth.

use nalgebra::{Rotation3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tectum_calibrate::detect::marker::MarkerView;
use tectum_calibrate::target::{Marker, OverlapTarget};
use tectum_calibrate::{Board, BoardPose, BoardSize, Corner, View};
use tectum_optics::{Rig, RigEye, rotation_vector};

use super::{Placement, SeenBoard, SeenMarker, Sighting};
use crate::Eyes;

/// The paper's fish with pictures of 952 px.
pub fn rig() -> Rig {
    let eye = "size_px = [960, 960]\nfield_deg = 210.0\nlens = { model = 'equidistant', \
        focal_px_per_rad = 259.740867, centre_px = [479.5, 479.5] }\n";
    let text = format!(
        "name = 'fish'\nmedium = 'water'\nstitch_distance_m = 2.0\n[mount]\npsi_deg = 25.7\n\
         tau_deg = 29.15\nlateral_mm = 30.0\n[left]\n{eye}[right]\n{eye}"
    );
    Rig::from_toml(&text, "fish").unwrap()
}

pub fn eyes(rig: &Rig) -> Eyes<&RigEye> {
    [rig.left.as_ref().unwrap(), rig.right.as_ref().unwrap()]
}

/// A board of 20 mm squares with marker `id` of 60 mm to its left.
pub fn target(columns: u16, rows: u16, id: u32) -> OverlapTarget {
    let board = Board {
        size: BoardSize { columns, rows },
        square_mm: 20.0,
    };
    let marker = Marker {
        dictionary: "DICT_4X4_50".into(),
        id,
        side_mm: 60.0,
    };
    OverlapTarget::beside(board, marker).unwrap()
}

/// Normal noise.
pub struct Noise(ChaCha8Rng);

impl Noise {
    pub fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    /// Between -1 and 1.
    pub fn even(&mut self) -> f64 {
        self.0.random_range(-1.0..1.0)
    }

    /// Of standard deviation 1: the sum of twelve.
    pub fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.even()).sum::<f64>() / 2.0
    }

    pub fn vector(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.even())
    }

    fn near(&mut self, pixel: [f64; 2], sigma_px: f64) -> [f64; 2] {
        pixel.map(|p| p + sigma_px * self.normal())
    }
}

/// A board (body <- board) whose middle lies `range_m` from the body's origin, `off` (rotation vector)
/// from the middle of the overlap, facing the body but for a tilt of up to 0.4 rad, turned by `roll`.
pub fn pose(
    target: &OverlapTarget,
    range_m: f64,
    off: &Vector3<f64>,
    roll: f64,
    noise: &mut Noise,
) -> BoardPose {
    let axes = eyes(&rig()).map(|eye| eye.pose.optical_axis());
    let towards = rotation_vector(off) * (axes[0] + axes[1]).normalize();
    // Board z away from the body, x to the right of one who looks at it.
    let right = towards.cross(&Vector3::z()).normalize();
    let frame = nalgebra::Matrix3::from_columns(&[right, towards.cross(&right), towards]);
    let facing = Rotation3::from_matrix_unchecked(frame);
    let tilt = rotation_vector(&(noise.vector() * 0.25));
    let rotation = facing * tilt * rotation_vector(&(Vector3::z() * roll));
    let size = target.board.size;
    let middle = target.board.corner_mm(size.columns - 1, size.rows - 1) / 2.0;
    BoardPose {
        rotation,
        position_mm: towards * range_m * 1000.0 - rotation * middle,
    }
}

/// Pixel of a point of the board, if the eye shows it.
pub fn pixel(eye: &RigEye, pose: &BoardPose, point_mm: &Vector3<f64>) -> Option<[f64; 2]> {
    let from_eye = pose.apply(point_mm) / 1000.0 - eye.pose.position_m;
    eye.eye
        .project(&(eye.pose.rotation.inverse() * from_eye))
        .ok()
}

/// How an eye's detector labels what it sees.
pub struct Labelling<'a> {
    /// Corners that are seen.
    pub keep: &'a dyn Fn(u16, u16) -> bool,
    /// Quarter turns of the labels.
    pub turns: u8,
    /// Whether the marker is seen.
    pub marker: bool,
    pub sigma_px: f64,
}

/// What an eye sees of a board: labels turned, and counted from the least.
pub fn sighting(
    eye: &RigEye,
    target: &OverlapTarget,
    pose: &BoardPose,
    how: &Labelling<'_>,
    noise: &mut Noise,
) -> Sighting {
    let size = target.board.size;
    let turn = Placement {
        turns: how.turns,
        shift: [0, 0],
    };
    let mut seen = Vec::new();
    for j in 0..size.rows {
        for i in 0..size.columns {
            let at = pixel(eye, pose, &target.board.corner_mm(i, j));
            if let Some(at) = at.filter(|_| (how.keep)(i, j)) {
                let label = turn.apply([i32::from(i), i32::from(j)]);
                seen.push((label, noise.near(at, how.sigma_px)));
            }
        }
    }
    let least = |k: usize| seen.iter().map(|(label, _)| label[k]).min().unwrap_or(0);
    let (mut i0, j0) = (least(0), least(1));
    // As the detector does where the colours tell which way round the board is.
    if (size.columns + size.rows) % 2 == 1 && (i0 + j0).rem_euclid(2) != i32::from(how.turns % 2) {
        i0 -= 1;
    }
    let corner = |(label, position_px): &([i32; 2], [f64; 2])| Corner {
        i: (label[0] - i0) as u16,
        j: (label[1] - j0) as u16,
        position_px: *position_px,
        sigma_px: how.sigma_px,
    };
    let mut corners: Vec<Corner> = seen.iter().map(corner).collect();
    corners.sort_by_key(|corner| (corner.j, corner.i));
    let marker = target
        .marker_corners_mm()
        .map(|point| pixel(eye, pose, &point));
    let markers = match marker {
        [Some(a), Some(b), Some(c), Some(d)] if how.marker => vec![SeenMarker {
            dictionary: target.dictionary.clone(),
            view: MarkerView {
                id: target.id,
                corners_px: [a, b, c, d].map(|at| noise.near(at, how.sigma_px)),
                hamming: 0,
                edge_rms_px: 0.1,
            },
        }],
        _ => Vec::new(),
    };
    let boards = match corners.len() {
        0..9 => Vec::new(),
        _ => vec![SeenBoard {
            size,
            view: View { corners },
        }],
    };
    Sighting {
        boards,
        markers,
        mirrored: false,
    }
}
