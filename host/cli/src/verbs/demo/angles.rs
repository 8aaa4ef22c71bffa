//! Do the angles that the table gives agree with the world that was photographed?

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;
use serde::Serialize;
use tectum_bake::ErrorSummary;
use tectum_bake::reference::position_q8;
use tectum_core::{Direction, Eye, Lookup, Tables};
use tectum_optics::convention::{angle_between, direction};
use tectum_optics::{Rig, RigEye};
use tectum_scene::{Ray, Scene, SceneDescription};
use tectum_tables::RunKind;

/// How far in front of a known point, m, what a ray meets may lie: rounding of a few metres.
const HIDDEN_M: f64 = 1e-6;

/// Angles between looked-up and true directions.
#[derive(Debug, Serialize)]
pub struct AngleCheck {
    /// Directions compared.
    pub count: usize,
    /// Least and greatest distance of what they show from the body's origin, m; infinity, which
    /// JSON writes as null, for the hall around an empty pool.
    pub range_m: [f64; 2],
    /// Against the direction of the eye's ray at the stitch distance: the table's own error.
    pub table_deg: ErrorSummary,
    /// Against the direction of the thing itself, which is not at the stitch distance: parallax
    /// comes on top.
    pub with_parallax_deg: ErrorSummary,
}

/// One comparison.
struct Sample {
    range_m: f64,
    table_rad: f64,
    parallax_rad: f64,
}

impl AngleCheck {
    fn of(samples: &[Sample]) -> Self {
        let summary = |error: fn(&Sample) -> f64| {
            let degrees = || samples.iter().map(|sample| error(sample).to_degrees());
            let mean_square = degrees().map(|e| e * e).sum::<f64>() / samples.len().max(1) as f64;
            ErrorSummary {
                max: degrees().fold(0.0, f64::max),
                rms: mean_square.sqrt(),
            }
        };
        let ranges = || samples.iter().map(|sample| sample.range_m);
        Self {
            count: samples.len(),
            range_m: [
                ranges().fold(f64::INFINITY, f64::min),
                ranges().fold(0.0, f64::max),
            ],
            table_deg: summary(|sample| sample.table_rad),
            with_parallax_deg: summary(|sample| sample.parallax_rad),
        }
    }
}

/// Corners of boards and markers, looked up through the raw pixel that shows them.
pub fn printed_corners(
    scene: &Scene,
    description: &SceneDescription,
    rig: &Rig,
    tables: &Tables<'_>,
) -> AngleCheck {
    let boards = description
        .boards
        .iter()
        .enumerate()
        .flat_map(|(k, board)| {
            (0..board.rows).flat_map(move |j| {
                (0..board.columns).filter_map(move |i| scene.board_corner_m(k, i, j))
            })
        });
    let markers = (0..description.markers.len())
        .flat_map(|k| scene.marker_corners_m(k).into_iter().flatten());
    let samples: Vec<Sample> = boards
        .chain(markers)
        .flat_map(|point| eyes(rig).map(move |(side, eye)| (point, side, eye)))
        .filter_map(|(point, side, eye)| corner(scene, rig, tables, side, eye, point))
        .collect();
    AngleCheck::of(&samples)
}

fn corner(
    scene: &Scene,
    rig: &Rig,
    tables: &Tables<'_>,
    side: Eye,
    eye: &RigEye,
    point: Point3<f64>,
) -> Option<Sample> {
    let origin_m = Point3::from(eye.pose.position_m);
    let sight = point - origin_m;
    let hit = scene.trace(&Ray::new(origin_m, sight)).ok()?;
    if hit.range_m < sight.norm() - HIDDEN_M {
        return None;
    }
    let pixel = eye
        .eye
        .project(&(eye.pose.rotation.inverse() * sight))
        .ok()?;
    let pixel_q8 = pixel.map(|p| (p * 256.0).round() as i32);
    let found = Lookup::new(tables).direction_of_eye_pixel(side, pixel_q8)?;
    sample(rig, eye, found, pixel, (point.coords, point.coords.norm()))
}

/// Every pixel of the stitched picture, against what the eye's ray there really meets.
pub fn stitched_pixels(scene: &Scene, rig: &Rig, tables: &Tables<'_>) -> AngleCheck {
    let samples: Vec<Sample> = (0..tables.output_height_px())
        .into_par_iter()
        .flat_map_iter(|y| {
            tables.runs(y).flat_map(move |run| {
                let shown = move |side| match run.kind {
                    RunKind::Void => false,
                    RunKind::Left => side == Eye::Left,
                    RunKind::Right => side == Eye::Right,
                    RunKind::Blend(_) => true,
                };
                eyes(rig)
                    .filter(move |(side, _)| shown(*side))
                    .flat_map(move |(side, eye)| {
                        let columns = run.start..run.start + run.len;
                        columns.filter_map(move |x| {
                            stitched_pixel(scene, rig, tables, (side, eye), [x as usize, y.into()])
                        })
                    })
            })
        })
        .collect();
    AngleCheck::of(&samples)
}

fn stitched_pixel(
    scene: &Scene,
    rig: &Rig,
    tables: &Tables<'_>,
    (side, eye): (Eye, &RigEye),
    [x, y]: [usize; 2],
) -> Option<Sample> {
    let pixel = position_q8(tables, side, x, y)?.map(|q8| f64::from(q8) / 256.0);
    let ray = eye.pose.rotation * eye.eye.unproject(pixel).ok()?;
    let ray = Ray::new(Point3::from(eye.pose.position_m), ray);
    let hit = scene.trace(&ray).ok()?;
    let seen = if hit.range_m.is_finite() {
        let point = ray.at(hit.range_m).coords;
        (point, point.norm())
    } else {
        (ray.direction.into_inner(), f64::INFINITY)
    };
    let found = Lookup::new(tables).direction_of_pixel([x as i32 * 256, y as i32 * 256])?;
    sample(rig, eye, found, pixel, seen)
}

/// `found` for an eye's `pixel` that shows what lies in the direction `seen` from the body's
/// origin, `range_m` from it.
fn sample(
    rig: &Rig,
    eye: &RigEye,
    found: Direction,
    pixel: [f64; 2],
    (seen, range_m): (Vector3<f64>, f64),
) -> Option<Sample> {
    let [yaw, pitch] = [found.yaw, found.pitch].map(|angle| f64::from(angle.rad()));
    let found = direction(yaw, pitch);
    let at_distance = eye.direction_of(pixel, rig.stitch_distance_m).ok()?;
    Some(Sample {
        range_m,
        table_rad: angle_between(&found, &at_distance),
        parallax_rad: angle_between(&found, &seen),
    })
}

fn eyes(rig: &Rig) -> impl Iterator<Item = (Eye, &RigEye)> {
    let left = rig.left.as_ref().map(|eye| (Eye::Left, eye));
    let right = rig.right.as_ref().map(|eye| (Eye::Right, eye));
    left.into_iter().chain(right)
}
