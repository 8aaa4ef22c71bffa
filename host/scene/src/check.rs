//! Refusal of descriptions with impossible numbers.

use crate::description::{Board, Marker, PanelPose, Pool, SceneDescription, Shape, Solid};
use crate::error::Error;
use crate::medium::Medium;

/// Refuses `value` outside `[min, max]`, and NaN.
pub(crate) fn within(
    name: impl Into<String>,
    value: f64,
    [min, max]: [f64; 2],
) -> Result<(), Error> {
    if value >= min && value <= max {
        return Ok(());
    }
    Err(Error::OutOfRange {
        name: name.into(),
        value,
        min,
        max,
    })
}

fn all_within(name: &str, values: [f64; 3], range: [f64; 2]) -> Result<(), Error> {
    (0..3).try_for_each(|k| within(format!("{name}[{k}]"), values[k], range))
}

const PLACE_M: [f64; 2] = [-1000.0, 1000.0];
const ANGLE_DEG: [f64; 2] = [-3600.0, 3600.0];
const PRINT_MM: [f64; 2] = [0.1, 1e4];
const BODY_MM: [f64; 2] = [1.0, 1e5];

/// Checks every number of a description against the range that its documentation states.
pub(crate) fn description(scene: &SceneDescription) -> Result<(), Error> {
    pool(&scene.pool)?;
    medium(&scene.medium)?;
    within(
        "the number of boards",
        scene.boards.len() as f64,
        [0.0, 256.0],
    )?;
    within(
        "the number of markers",
        scene.markers.len() as f64,
        [0.0, 256.0],
    )?;
    within(
        "the number of solids",
        scene.solids.len() as f64,
        [0.0, 1024.0],
    )?;
    scene
        .boards
        .iter()
        .enumerate()
        .try_for_each(|(k, b)| board(k, b))?;
    scene
        .markers
        .iter()
        .enumerate()
        .try_for_each(|(k, m)| marker(k, m))?;
    scene
        .solids
        .iter()
        .enumerate()
        .try_for_each(|(k, s)| solid(k, s))
}

fn pool(pool: &Pool) -> Result<(), Error> {
    within("pool.length_m", pool.length_m, [0.1, 1000.0])?;
    within("pool.width_m", pool.width_m, [0.1, 1000.0])?;
    within("pool.depth_m", pool.depth_m, [0.1, 1000.0])?;
    within("pool.freeboard_m", pool.freeboard_m, [0.0, 10.0])?;
    within("pool.tile_mm", pool.tile_mm, [10.0, 1e4])
}

fn medium(medium: &Medium) -> Result<(), Error> {
    let Medium::Water(water) = medium else {
        return Ok(());
    };
    within(
        "medium.refractive_index",
        water.refractive_index,
        [1.0, 2.0],
    )?;
    all_within(
        "medium.attenuation_per_m",
        water.attenuation_per_m,
        [0.0, 100.0],
    )?;
    all_within(
        "medium.backscatter_per_m",
        water.backscatter_per_m,
        [0.0, 100.0],
    )?;
    all_within("medium.veiling_light", water.veiling_light, [0.0, 100.0])?;
    within("medium.wave_slope", water.wave_slope, [0.0, 0.3])
}

fn board(k: usize, board: &Board) -> Result<(), Error> {
    within(
        format!("boards[{k}].columns"),
        board.columns.into(),
        [1.0, 100.0],
    )?;
    within(format!("boards[{k}].rows"), board.rows.into(), [1.0, 100.0])?;
    within(format!("boards[{k}].square_mm"), board.square_mm, PRINT_MM)?;
    pose(&format!("boards[{k}].pose"), &board.pose)
}

fn marker(k: usize, marker: &Marker) -> Result<(), Error> {
    if marker.dictionary != "DICT_4X4_50" {
        return Err(Error::UnknownDictionary {
            index: k,
            name: marker.dictionary.clone(),
        });
    }
    within(format!("markers[{k}].id"), marker.id.into(), [0.0, 49.0])?;
    within(format!("markers[{k}].size_mm"), marker.size_mm, PRINT_MM)?;
    pose(&format!("markers[{k}].pose"), &marker.pose)
}

fn pose(name: &str, pose: &PanelPose) -> Result<(), Error> {
    all_within(&format!("{name}.position_m"), pose.position_m, PLACE_M)?;
    within(format!("{name}.yaw_deg"), pose.yaw_deg, ANGLE_DEG)?;
    within(format!("{name}.pitch_deg"), pose.pitch_deg, ANGLE_DEG)?;
    within(format!("{name}.roll_deg"), pose.roll_deg, ANGLE_DEG)
}

fn solid(k: usize, solid: &Solid) -> Result<(), Error> {
    let name = |field: &str| format!("solids[{k}].{field}");
    all_within(&name("color"), solid.color, [0.0, 1.0])?;
    all_within(&name("band_color"), solid.band_color, [0.0, 1.0])?;
    within(name("band_mm"), solid.band_mm, BODY_MM)?;
    match solid.shape {
        Shape::Sphere {
            center_m,
            radius_mm,
        } => {
            all_within(&name("center_m"), center_m, PLACE_M)?;
            within(name("radius_mm"), radius_mm, BODY_MM)
        }
        Shape::Pole {
            from_m,
            to_m,
            radius_mm,
        } => {
            all_within(&name("from_m"), from_m, PLACE_M)?;
            all_within(&name("to_m"), to_m, PLACE_M)?;
            if from_m == to_m {
                return Err(Error::PoleWithoutLength { index: k });
            }
            within(name("radius_mm"), radius_mm, BODY_MM)
        }
        Shape::Box {
            center_m,
            size_mm,
            yaw_deg,
        } => {
            all_within(&name("center_m"), center_m, PLACE_M)?;
            all_within(&name("size_mm"), size_mm, BODY_MM)?;
            within(name("yaw_deg"), yaw_deg, ANGLE_DEG)
        }
    }
}
