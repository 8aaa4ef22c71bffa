//! The stitched picture's geometry between the host's f64 and the table's fixed point.

use nalgebra::{Matrix3, Rotation3};
use tectum_core::Tables;
use tectum_optics::{OutputMap, ViewFormula};
use tectum_tables::ProjectionKind;
use tectum_tables::builder::OutputMapData;

use crate::rays::{quantise, rotation_q30};

/// The map in fixed point; `None` if its numbers do not fit.
pub fn to_table(map: &OutputMap) -> Option<OutputMapData> {
    let axis = |[start, step]: [f64; 2]| Some([quantise(start, 28)?, quantise(step, 28)?]);
    Some(OutputMapData {
        kind: match map.formula {
            ViewFormula::Equirect => ProjectionKind::Equirect,
            ViewFormula::Cylindrical => ProjectionKind::Cylindrical,
            ViewFormula::Fisheye => ProjectionKind::Fisheye,
            ViewFormula::Perspective => ProjectionKind::Perspective,
        },
        rotation_q30: rotation_q30(&map.rotation),
        u_q28: axis(map.u)?,
        v_q28: axis(map.v)?,
    })
}

/// Exactly what the fixed-point numbers say, for a picture of `size_px`.
pub fn from_table(map: &OutputMapData, size_px: [u16; 2]) -> OutputMap {
    let q28 = |axis: [i32; 2]| axis.map(|v| f64::from(v) / f64::from(1 << 28));
    let rotation = map.rotation_q30.map(|v| f64::from(v) / f64::from(1 << 30));
    OutputMap {
        size_px,
        formula: match map.kind {
            ProjectionKind::Equirect => ViewFormula::Equirect,
            ProjectionKind::Cylindrical => ViewFormula::Cylindrical,
            ProjectionKind::Fisheye => ViewFormula::Fisheye,
            ProjectionKind::Perspective => ViewFormula::Perspective,
        },
        rotation: Rotation3::from_matrix_unchecked(Matrix3::from_row_slice(&rotation)),
        u: q28(map.u_q28),
        v: q28(map.v_q28),
    }
}

/// The output map of a table, as the host's.
pub fn output_map(tables: &Tables<'_>) -> OutputMap {
    let map = tables.output_map();
    let data = OutputMapData {
        kind: map.kind(),
        rotation_q30: map.rotation_q30(),
        u_q28: map.u_q28(),
        v_q28: map.v_q28(),
    };
    from_table(&data, [tables.output_width_px(), tables.output_height_px()])
}
