//! No doubled edges outside the feather, while something near moves through the overlap.
//!
//! The criterion: a pixel is a ghost if its luma is more than 8 grey levels from both eyes' (or
//! farther from both than they are from each other, and 8 more): `seam::ghosts`. An edge that both
//! eyes show at different places, mixed, makes ghosts of the pixels between. Outside the feather,
//! where one eye has the whole share, there must be none in any frame; inside, less than half of
//! what a straight feather of 18 degrees between the axes has on the same frames.

mod common;

use common::{baked, stitched};
use image::{Rgb, RgbImage};
use nalgebra::Vector3;
use tectum_optics::convention::yaw_pitch;
use tectum_optics::{Projection, Rig, Stitching};
use tectum_stitch::Views;
use tectum_stitch::seam::{Gray, Overlap, Seam, SeamOptions, band, ghosts};

const OUTPUT_PX: [u16; 2] = [512, 256];
const FRAMES: usize = 6;

/// Opposite eyes 12 cm apart.
fn rig() -> Rig {
    let eye = |yaw_deg: f64, left_mm: f64| {
        format!(
            "size_px = [320, 320]\nfield_deg = 208.0\n\
             pose = {{ yaw_deg = {yaw_deg}, pitch_deg = 0.0, position_mm = [0.0, {left_mm}, 0.0] }}\n\
             lens = {{ model = 'equidistant', focal_px_per_rad = 86.0, centre_px = [159.5, 159.5] }}\n"
        )
    };
    let text = format!(
        "name = 'pair'\nmedium = 'air'\nstitch_distance_m = 3.0\n[left]\n{}[right]\n{}",
        eye(90.0, 60.0),
        eye(-90.0, -60.0)
    );
    Rig::from_toml(&text, "pair").unwrap()
}

/// A hall 3 m around, patterned, and a striped ball that crosses ahead at half a metre.
fn luma(origin: &Vector3<f64>, ray: &Vector3<f64>, frame: usize) -> f64 {
    let hits = |centre: &Vector3<f64>, radius: f64, inside: bool| {
        let to = origin - centre;
        let along = to.dot(ray);
        let room = along * along - to.norm_squared() + radius * radius;
        let distance = if inside {
            room.sqrt() - along
        } else {
            -room.sqrt() - along
        };
        (room > 0.0 && distance > 0.0).then(|| (to + ray * distance) / radius)
    };
    let yaw_rad = 0.5 - 0.2 * frame as f64;
    let ball = Vector3::new(0.5 * yaw_rad.cos(), 0.5 * yaw_rad.sin(), 0.05);
    if let Some(point) = hits(&ball, 0.1, false) {
        return if (point.z * 4.0).floor() as i64 % 2 == 0 {
            210.0
        } else {
            60.0
        };
    }
    let point = hits(&Vector3::zeros(), 3.0, true).expect("the hall is all around");
    let (yaw, pitch) = yaw_pitch(&point);
    120.0 + 45.0 * (9.0 * yaw + 3.0 * (5.0 * pitch).sin()).sin() * (7.0 * pitch).cos()
}

fn picture(rig: &Rig, eye: usize, frame: usize) -> RgbImage {
    let camera = [&rig.left, &rig.right][eye].as_ref().unwrap();
    RgbImage::from_fn(320, 320, |x, y| {
        // Four samples a pixel.
        let sample = |k: u32| {
            let at = [
                f64::from(x) - 0.25 + 0.5 * f64::from(k % 2),
                f64::from(y) - 0.25 + 0.5 * f64::from(k / 2),
            ];
            let ray = camera.eye.unproject(at).ok()?;
            Some(luma(
                &camera.pose.position_m,
                &(camera.pose.rotation * ray),
                frame,
            ))
        };
        let sum: f64 = (0..4).filter_map(sample).sum();
        Rgb([(sum / 4.0).round() as u8; 3])
    })
}

#[test]
fn no_doubled_edges_outside_the_feather() {
    let mut rig = rig();
    let frames: Vec<[RgbImage; 2]> = (0..FRAMES)
        .map(|frame| [0, 1].map(|eye| picture(&rig, eye, frame)))
        .collect();
    let output = Projection::Equirect.output_map(OUTPUT_PX).unwrap();
    let straight = baked(&rig, &output, 18f64.to_radians());

    // The seam knows every second frame only.
    let frame = band(&rig, OUTPUT_PX[0]).unwrap();
    let shots: Vec<Views> = (frames.iter().step_by(2))
        .map(|pictures| Views::render(&rig, pictures.each_ref(), &frame))
        .collect();
    let overlap = Overlap::new(&shots[0], 2.0);
    let seam = Seam::find(&shots, overlap, &SeamOptions::default()).unwrap();
    let shares = seam.shares.seam_map(OUTPUT_PX).unwrap();
    let share: Vec<f64> = (0..512 * 256)
        .map(|i| shares.left_share(&output.ray(f64::from(i % 512), f64::from(i / 512)).unwrap()))
        .collect();
    rig.stitching = Some(Stitching {
        seam: Some(shares),
        ..Stitching::default()
    });
    let cut = baked(&rig, &output, 0.0);

    let (mut inside, mut of_straight) = (0, 0);
    for pictures in &frames {
        let views = Views::render(&rig, pictures.each_ref(), &output);
        let gray = |colours: &[[f32; 3]]| Gray::luma([512, 256], true, colours);
        let eyes = [0, 1].map(|eye| gray(&views.eyes[eye].colours));
        let ghosts_of = |table| {
            let result = gray(&stitched(table, pictures.each_ref()));
            let ghosts = ghosts(&result, eyes.each_ref());
            (0..ghosts.len())
                .filter(|i| ghosts[*i] && views.both(*i))
                .collect::<Vec<usize>>()
        };
        let ours = ghosts_of(&cut);
        let outside = ours
            .iter()
            .filter(|i| share[**i] <= 0.0 || share[**i] >= 1.0)
            .count();
        assert_eq!(outside, 0);
        inside += ours.len();
        of_straight += ghosts_of(&straight).len();
    }
    println!("ghosts in {FRAMES} frames: {inside}; with a straight feather: {of_straight}");
    assert!(of_straight > 500, "the scene has parallax: {of_straight}");
    assert!(2 * inside < of_straight, "{inside} of {of_straight}");
}
