//! From the calibrated eyes to the directions that the core tells: rig, orientation boards, table,
//! look-up, each beside the truth.

use image::GrayImage;
use nalgebra::Vector3;
use tectum_bake::{BakeOptions, Format, Pair, Pass, bake, output_map, stitch};
use tectum_calibrate::BoardSize;
use tectum_calibrate::detect::chessboard::detect_all;
use tectum_calibrate::stereo::StereoCalibration;
use tectum_core::{BinaryAngle, Direction, Lookup, Sampler, Tables};
use tectum_optics::convention::{angle_between, direction};
use tectum_optics::design::OrientationBoard;
use tectum_optics::{Field, Pose, Projection, Rig, Side};
use tectum_scene::{Medium, PanelPose, Scene, SceneDescription, Seen};
use tectum_stitch::orientation::{Alignment, Correction, Placement, Shot, align, corrected};

use tectum_tests::rig_of_eyes;

use crate::fish::{Eye, SIZE_PX, pool_with};

/// Fine enough that the far columns of the orientation boards are found.
const OUTPUT_PX: [u16; 2] = [2048, 1024];
const STITCH_DISTANCE_M: f64 = 2.0;
const ORIGIN: [u16; 2] = [2, 2];

/// The paper's orientation board: rows -2 to 5, columns -2 to 8.
fn placement() -> Placement {
    let board = BoardSize {
        columns: 11,
        rows: 8,
    };
    let geometry = OrientationBoard::new(0.16, 0.035).expect("a board");
    Placement::new(board, ORIGIN, geometry).expect("its origin")
}

/// The pool with that board on one side.
fn beside(side: Side, medium: Medium) -> Scene {
    let placement = placement();
    let BoardSize { columns, rows } = placement.board();
    let corner = |at| placement.corner_m(side, placement.ij(at));
    let middle = (corner([0, 0]) + corner([columns - 1, rows - 1])) / 2.0;
    pool_with(
        medium,
        tectum_scene::Board {
            columns: columns.into(),
            rows: rows.into(),
            square_mm: placement.geometry_m().square() * 1e3,
            pose: PanelPose {
                position_m: middle.into(),
                yaw_deg: if side == Side::Left { -90.0 } else { 90.0 },
                pitch_deg: 0.0,
                roll_deg: 0.0,
            },
        },
    )
}

/// The rig of two lenses at their poses.
fn rig(models: [tectum_optics::CameraModel; 2], eyes: &[Eye; 2], poses: [Pose; 2]) -> Rig {
    let eye = |k: usize| {
        let eye = tectum_optics::Eye {
            size_px: SIZE_PX.map(|side| side as u16),
            model: models[k].clone(),
            field: Field::new(vec![eyes[k].half_field_deg.to_radians()]).expect("a field"),
        };
        (eye, poses[k])
    };
    let eyes = [eye(0), eye(1)];
    rig_of_eyes(tectum_optics::Medium::Water, STITCH_DISTANCE_M, &eyes)
}

fn table(rig: &Rig) -> Vec<u8> {
    let output = Projection::Equirect.output_map(OUTPUT_PX).expect("a size");
    let options = BakeOptions {
        output,
        max_error_px: 0.1,
        feather_rad: 0.05,
    };
    bake(rig, &options).expect("a table").bytes
}

/// Both eyes' pictures of a scene as the core stitches them.
fn stitched(tables: &Tables<'_>, eyes: &[Eye; 2], scene: &Scene, seed: u32) -> GrayImage {
    let [left, right] = [0, 1].map(|k: usize| eyes[k].picture(scene, seed + k as u32).into_raw());
    let pair = Pair {
        left: &left,
        right: &right,
    };
    let bytes = stitch(tables, Format::Gray8, Sampler::Bilinear, Pass::Both, pair);
    let [width, height] = OUTPUT_PX.map(u32::from);
    GrayImage::from_raw(width, height, bytes.expect("stitches")).expect("its size")
}

/// The eye that a place of the stitched picture shows alone.
fn shown_by(tables: &Tables<'_>, [x, y]: [f64; 2]) -> Option<usize> {
    let mut runs = tables.runs(y.round() as u16);
    let x = x.round() as u32;
    let run = runs.find(|run| (run.start..run.start + run.len).contains(&x))?;
    match run.kind {
        tectum_tables::RunKind::Left => Some(0),
        tectum_tables::RunKind::Right => Some(1),
        _ => None,
    }
}

fn aligned(rig: &Rig, bytes: &[u8], eyes: &[Eye; 2], scenes: &[Scene; 2]) -> Alignment {
    let tables = Tables::parse(bytes).expect("parses");
    let shots = [(Side::Left, 0), (Side::Right, 1)].map(|(side, k)| {
        let picture = stitched(&tables, eyes, &scenes[k], 900 + 10 * k as u32);
        Shot::detect(format!("{side:?}"), side, &picture, &placement()).expect("a board")
    });
    let map = output_map(&tables);
    align(rig, &map, |at| shown_by(&tables, at), &placement(), &shots).expect("aligns")
}

/// RMS and worst of angles, degrees, and how many.
struct Angles(Vec<f64>);

impl Angles {
    fn rms(&self) -> f64 {
        let sum: f64 = self.0.iter().map(|a| a * a).sum();
        (sum / self.0.len() as f64).sqrt()
    }

    fn worst(&self) -> f64 {
        self.0.iter().copied().fold(0.0, f64::max)
    }
}

impl std::fmt::Display for Angles {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{:.4} RMS, {:.4} worst of {}",
            self.rms(),
            self.worst(),
            self.0.len()
        )
    }
}

fn vector(found: Direction) -> Vector3<f64> {
    let [yaw, pitch] = [found.yaw, found.pitch].map(BinaryAngle::degrees);
    direction(f64::from(yaw).to_radians(), f64::from(pitch).to_radians())
}

fn q8(pixel: [f64; 2]) -> [i32; 2] {
    pixel.map(|p| (p * 256.0).round() as i32)
}

/// The direction in which a picture for one distance shows a point that an eye sees: where the line from
/// the eye to it, in units of that distance, meets the unit sphere about the body's origin.
fn at_stitch_distance(eye: &Eye, point: &Vector3<f64>) -> Vector3<f64> {
    let ray = (point - eye.position_m).normalize();
    let start = eye.position_m / STITCH_DISTANCE_M;
    let along = start.dot(&ray);
    let length = (along * along + 1.0 - start.norm_squared()).sqrt() - along;
    start + ray * length
}

/// What the core tells of every pixel of an eye that shows a board or something afloat, beside the
/// truth of the renderer; and the same without taking out parallax to the body's origin.
fn raw_pixels(tables: &Tables<'_>, eyes: &[Eye; 2], scene: &Scene) -> [Angles; 2] {
    let lookup = Lookup::new(tables);
    let mut angles = [Angles(Vec::new()), Angles(Vec::new())];
    for (k, eye) in eyes.iter().enumerate() {
        let rendered = eye.render(scene, 700 + k as u32);
        for (index, truth) in rendered.truth.iter().enumerate().step_by(7) {
            let Some(truth) = truth else { continue };
            if !matches!(truth.seen, Seen::Board(_) | Seen::Solid(_)) {
                continue;
            }
            let index = index as u32;
            let pixel = [index % SIZE_PX[0], index / SIZE_PX[0]].map(f64::from);
            let which = [tectum_core::Eye::Left, tectum_core::Eye::Right][k];
            let Some(found) = lookup.direction_of_eye_pixel(which, q8(pixel)) else {
                continue;
            };
            let found = vector(found);
            let point = eye.position_m + Vector3::from(truth.direction) * truth.range_m;
            let shown = at_stitch_distance(eye, &point);
            angles[0].0.push(angle_between(&found, &shown).to_degrees());
            angles[1].0.push(angle_between(&found, &point).to_degrees());
        }
    }
    angles
}

/// Corners of the pool's boards, found in the stitched picture and looked up by the core.
fn stitched_corners(tables: &Tables<'_>, eyes: &[Eye; 2], scene: &Scene) -> Angles {
    let lookup = Lookup::new(tables);
    let picture = stitched(tables, eyes, scene, 800);
    let size = BoardSize {
        columns: 8,
        rows: 6,
    };
    let truth: Vec<Vector3<f64>> = (0..3)
        .flat_map(|board| (0..48).map(move |n| (board, n % 8, n / 8)))
        .filter_map(|(board, i, j)| scene.board_corner_m(board, i, j))
        .map(|point| point.coords)
        .collect();
    let mut angles = Angles(Vec::new());
    for corner in detect_all(&picture, size)
        .iter()
        .flat_map(|view| &view.corners)
    {
        let Some(k) = shown_by(tables, corner.position_px) else {
            continue;
        };
        let Some(found) = lookup.direction_of_pixel(q8(corner.position_px)) else {
            continue;
        };
        let found = vector(found);
        // The nearest of the true corners: squares are 3 degrees and more.
        let off = truth
            .iter()
            .map(|point| angle_between(&found, &at_stitch_distance(&eyes[k], point)).to_degrees())
            .fold(f64::INFINITY, f64::min);
        angles.0.push(off);
    }
    angles
}

/// Prints and checks what the core tells at the end of the chain.
pub fn directions(eyes: &[Eye; 2], tied: &StereoCalibration, medium: Medium) {
    let boards = [Side::Left, Side::Right].map(|side| beside(side, medium));
    let pool = Scene::new(&SceneDescription::furnished(medium)).expect("a pool");

    let calibrated = rig([tied.left.clone(), tied.right.clone()], eyes, tied.poses());
    let found = aligned(&calibrated, &table(&calibrated), eyes, &boards);
    let put_right = corrected(&calibrated, &found, &Correction::Turn, [256, 128]);
    let bytes = table(&put_right.expect("a rig").rig);
    let tables = Tables::parse(&bytes).expect("parses");
    let [pixels, unparallaxed] = raw_pixels(&tables, eyes, &pool);
    let corners = stitched_corners(&tables, eyes, &pool);
    let name = match medium {
        Medium::Air => "air",
        Medium::Water(_) => "water",
    };
    println!(
        "{name}: orientation boards: {:.3} degrees RMS off, {:.3} after a turn of {:.3}\n\
         raw pixels of boards and floating things: {pixels} degrees (with parallax to the body's \
         origin: {unparallaxed})\ncorners in the stitched picture: {corners} degrees",
        found.rms_rad.to_degrees(),
        found.turned.rms_rad.to_degrees(),
        found.turned.turn.angle().to_degrees(),
    );

    // The paper's way: lenses as on their data sheets, the mount as drawn, the eyes taken to be at the
    // body's origin, and the boards' own scale.
    let nominal = [Side::Left, Side::Right].map(|side| Pose {
        rotation: Pose::mount_rotation(side, 25.7f64.to_radians(), 29.15f64.to_radians()),
        position_m: Vector3::zeros(),
    });
    let lens = |eye: &Eye| {
        let focal = 297.0 / eye.half_field_deg.to_radians();
        let centre = SIZE_PX.map(|side| (f64::from(side) - 1.0) / 2.0);
        tectum_optics::CameraModel::Equidistant(
            tectum_optics::camera::Equidistant::new(focal, centre).expect("a lens"),
        )
    };
    let nominal = rig([lens(&eyes[0]), lens(&eyes[1])], eyes, nominal);
    let found = aligned(&nominal, &table(&nominal), eyes, &boards);
    let scale = found.own_scale().expect("a scale");
    let left_out = scale.left_out_rms_rad.to_degrees();
    let own = corrected(&nominal, &found, &Correction::Scale(scale), [256, 128]);
    let own = own.expect("a rig");
    let warp = own.warp.expect("a bend").map().expect("its size");
    let stitching = tectum_optics::Stitching {
        warp: Some(warp),
        ..Default::default()
    };
    let own = own.rig.with_stitching(stitching, Default::default());
    let bytes = table(&own);
    let alone = stitched_corners(&Tables::parse(&bytes).expect("parses"), eyes, &pool);
    println!(
        "{name}: by boards alone, no calibration: {:.3} degrees RMS off before, {left_out:.3} at corners left \
         out, {alone} degrees at the pool's boards",
        found.rms_rad.to_degrees(),
    );

    // What is asked of the whole chain.
    assert!(pixels.rms() < 0.1 && pixels.worst() < 0.3, "{pixels}");
    assert!(corners.rms() < 0.1 && corners.worst() < 0.3, "{corners}");
    assert!(corners.0.len() > 60, "{corners}");
    // Calibration must be worth it.
    assert!(alone.rms() > corners.rms(), "{alone} {corners}");
}
