//! A pool with the overlap's target in it, as the paper's fish sees it.

use image::RgbImage;
use nalgebra::{Point3, Vector3};
use tectum_calibrate::Board;
use tectum_calibrate::target::{Marker, OverlapTarget};
use tectum_optics::convention::angle_between;
use tectum_optics::{Rig, RigEye};
use tectum_scene::{
    Board as PoolBoard, Marker as PoolMarker, Medium, PanelPose, Pool, Ray, RenderOptions, Scene,
    SceneDescription, render,
};

/// The paper's fish with pictures of 952 px.
pub fn rig() -> Rig {
    let eye = "size_px = [960, 960]\nfield_deg = 210.0\nlens = { model = 'equidistant', \
        focal_px_per_rad = 259.740867, centre_px = [479.5, 479.5] }\n";
    let text = format!(
        "name = 'fish'\nmedium = 'air'\nstitch_distance_m = 2.0\n[mount]\npsi_deg = 25.7\n\
         tau_deg = 29.15\nlateral_mm = 30.0\n[left]\n{eye}[right]\n{eye}"
    );
    Rig::from_toml(&text, "fish").unwrap()
}

pub fn eyes(rig: &Rig) -> [&RigEye; 2] {
    [rig.left.as_ref().unwrap(), rig.right.as_ref().unwrap()]
}

pub fn target() -> OverlapTarget {
    let board = Board {
        size: "8x6".parse().unwrap(),
        square_mm: 24.0,
    };
    let marker = Marker {
        dictionary: "DICT_4X4_50".into(),
        id: 3,
        side_mm: 72.0,
    };
    OverlapTarget::beside(board, marker).unwrap()
}

/// A pool with the target in it: the board's middle at `at`, its print turned by `roll_deg`.
pub fn scene(target: &OverlapTarget, at: Vector3<f64>, roll_deg: f64) -> Scene {
    let towards = -at.normalize();
    let pose = |position_m: [f64; 3]| PanelPose {
        position_m,
        // Facing the fish but for some degrees.
        yaw_deg: libm::atan2(towards.y, towards.x).to_degrees() + 10.0,
        pitch_deg: -libm::asin(towards.z).to_degrees() - 8.0,
        roll_deg,
    };
    let size = target.board.size;
    let mut description = SceneDescription {
        texture_seed: 1,
        pool: Pool {
            length_m: 12.0,
            width_m: 12.0,
            depth_m: 12.0,
            freeboard_m: 0.3,
            tile_mm: 200.0,
        },
        medium: Medium::Air,
        boards: vec![PoolBoard {
            columns: size.columns.into(),
            rows: size.rows.into(),
            square_mm: target.board.square_mm,
            pose: pose(at.into()),
        }],
        markers: vec![],
        solids: vec![],
    };
    let board = Scene::new(&description).unwrap();
    let corner = |i, j| board.board_corner_m(0, i, j).unwrap();
    let (x, y) = (corner(1, 0) - corner(0, 0), corner(0, 1) - corner(0, 0));
    let [first, _, third, _] = target.marker_corners_mm();
    let middle = (first + third) / 2.0 / target.board.square_mm;
    let place = corner(0, 0) + x * middle.x + y * middle.y;
    description.markers.push(PoolMarker {
        dictionary: target.dictionary.clone(),
        id: target.id,
        size_mm: target.marker_side_mm,
        pose: pose(place.into()),
    });
    Scene::new(&description).unwrap()
}

/// What an eye sees less than `off_rad` from a place, black elsewhere.
pub fn taken(scene: &Scene, eye: &RigEye, near: Vector3<f64>, off_rad: f64, seed: u32) -> RgbImage {
    let camera = |x_px: f64, y_px: f64| {
        let ray = eye.pose.rotation * eye.eye.unproject([x_px, y_px]).ok()?;
        let off = angle_between(&ray, &(near - eye.pose.position_m));
        (off < off_rad).then(|| Ray::new(Point3::from(eye.pose.position_m), ray))
    };
    let [width, height] = eye.eye.size_px.map(u32::from);
    let picture = render(
        scene,
        width,
        height,
        &camera,
        &RenderOptions::real_camera(seed),
    )
    .unwrap();
    RgbImage::from_raw(width, height, picture.rgb).unwrap()
}
