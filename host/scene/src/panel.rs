//! Flat printed panels: chessboards and ArUco markers.

use crate::cells::box_mean;
use crate::contact::{Contact, Seen};
use crate::description::{Board, Marker, PanelPose};
use crate::ray::{Ray, body_axes};
use nalgebra::{Point3, Vector3};

/// OpenCV's `DICT_4X4_50`: inner bits of ids 0 to 49, row by row, most significant bit first,
/// 1 is white (figures of `predefined_dictionaries.hpp`; its bytes 181, 50 are id 0 here).
const DICT_4X4_50: [u16; 50] = [
    0xB532, 0x0F9A, 0x332D, 0x9946, 0x549E, 0x79CD, 0x9E2E, 0xC4F2, 0xFEDA, 0xCF56, //
    0xF991, 0x11A7, 0x0EB7, 0x2A0F, 0x24B1, 0x263E, 0x4665, 0x6600, 0x6C5E, 0x76AF, //
    0x868B, 0xB02B, 0xCCD5, 0xDD82, 0xFE47, 0x9471, 0xACE4, 0xA554, 0x2123, 0x346F, //
    0x4415, 0x57B2, 0x9ECF, 0xF0CB, 0x08AE, 0x0929, 0x1875, 0x04FF, 0x0DF6, 0x1C5A, //
    0x1718, 0x2A28, 0x328C, 0x38B2, 0x24E8, 0x2EEB, 0x2D3F, 0x4B64, 0x502E, 0x5013,
];

/// Reflectance of black and white print (matt laminate).
const INK: f64 = 0.03;
const PAPER: f64 = 0.80;

#[derive(Debug, Clone, Copy)]
enum Print {
    Chess,
    Code(u16),
}

/// A panel in the world.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Panel {
    seen: Seen,
    center: Point3<f64>,
    /// The panel's x (right), y (down) and z (into the panel) in the world.
    axes: [Vector3<f64>; 3],
    half_m: [f64; 2],
    cell_m: f64,
    cells: [u32; 2],
    print: Print,
}

impl Panel {
    pub fn board(index: usize, board: &Board) -> Self {
        let cells = [board.columns + 1, board.rows + 1];
        Self::new(
            Seen::Board(index),
            &board.pose,
            board.square_mm,
            cells,
            1.0,
            Print::Chess,
        )
    }

    pub fn marker(index: usize, marker: &Marker) -> Self {
        // The id was checked against the dictionary's size with the rest of the description.
        let print = Print::Code(DICT_4X4_50[marker.id as usize]);
        Self::new(
            Seen::Marker(index),
            &marker.pose,
            marker.size_mm / 6.0,
            [6, 6],
            2.0,
            print,
        )
    }

    fn new(
        seen: Seen,
        pose: &PanelPose,
        cell_mm: f64,
        cells: [u32; 2],
        margin_cells: f64,
        print: Print,
    ) -> Self {
        let facing = body_axes(pose.yaw_deg, pose.pitch_deg, 0.0);
        // A reader looks along -forward, so the body's left is to the reader's right.
        let (right, down) = (
            facing.column(1).into_owned(),
            -facing.column(2).into_owned(),
        );
        let (sr, cr) = libm::sincos(pose.roll_deg.to_radians());
        let cell_m = cell_mm / 1000.0;
        Self {
            seen,
            center: Point3::from(pose.position_m),
            axes: [
                right * cr + down * sr,
                down * cr - right * sr,
                -facing.column(0).into_owned(),
            ],
            half_m: cells.map(|n| (f64::from(n) + margin_cells) * cell_m / 2.0),
            cell_m,
            cells,
            print,
        }
    }

    /// A corner of the cell grid, `(0, 0)` at the top left, `(1, 1)` a chessboard's first inner
    /// corner, in the world.
    pub fn grid_corner(&self, i: u32, j: u32) -> Point3<f64> {
        let along = |k: u32, n: u32| (f64::from(k) - f64::from(n) / 2.0) * self.cell_m;
        let x = along(i, self.cells[0]);
        let y = along(j, self.cells[1]);
        self.center + self.axes[0] * x + self.axes[1] * y
    }

    /// The grid's size in cells, columns and rows.
    pub fn cells(&self) -> [u32; 2] {
        self.cells
    }

    /// Range at which a ray meets the panel, if that is below `max_range_m`.
    pub fn range_m(&self, ray: &Ray, max_range_m: f64) -> Option<f64> {
        let away = self.center - ray.origin_m;
        let range_m = away.dot(&self.axes[2]) / ray.direction.dot(&self.axes[2]);
        // An edge-on panel gives an infinite or undefined range, which no comparison lets through.
        if !(range_m > 1e-6 && range_m < max_range_m) {
            return None;
        }
        let local = ray.direction.into_inner() * range_m - away;
        let inside = |k: usize| local.dot(&self.axes[k]).abs() <= self.half_m[k];
        (inside(0) && inside(1)).then_some(range_m)
    }

    /// The surface point that [`Panel::range_m`] found.
    pub fn contact(&self, ray: &Ray, range_m: f64) -> Contact {
        let point = ray.at(range_m);
        let front = ray.direction.dot(&self.axes[2]) > 0.0;
        Contact {
            seen: if front { self.seen } else { Seen::Backing },
            range_m,
            point,
            normal: if front { -self.axes[2] } else { self.axes[2] },
            u_axis: self.axes[0],
            v_axis: self.axes[1],
            uv_m: [0, 1].map(|k| (point - self.center).dot(&self.axes[k])),
        }
    }

    /// Mean reflectance of the print over a footprint around `uv_m`.
    pub fn reflectance(&self, uv_m: [f64; 2], footprint_m: [f64; 2]) -> f64 {
        let at = [0, 1].map(|k| uv_m[k] / self.cell_m + f64::from(self.cells[k]) / 2.0);
        let width = footprint_m.map(|f| f / self.cell_m);
        let white = box_mean(at, width, self.cells, 1.0, |i, j| {
            f64::from(self.white(i, j))
        });
        INK + (PAPER - INK) * white
    }

    fn white(&self, i: u32, j: u32) -> bool {
        match self.print {
            Print::Chess => (i + j) % 2 == 1,
            Print::Code(bits) => {
                let inner = |k: u32| (1..5).contains(&k);
                inner(i) && inner(j) && bits >> (15 - (4 * (j - 1) + (i - 1))) & 1 == 1
            }
        }
    }
}
