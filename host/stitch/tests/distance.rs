//! The stitch distance of a hall whose walls are known, and of pictures that tell none.

use image::{Rgb, RgbImage};
use nalgebra::Vector3;
use tectum_optics::Rig;
use tectum_optics::convention::yaw_pitch;
use tectum_stitch::Eyes;
use tectum_stitch::distance::{Toward, scene_distance};

/// Opposite eyes 12 cm apart.
fn rig(distance: &str) -> Rig {
    let eye = |yaw_deg: f64, left_mm: f64| {
        format!(
            "size_px = [480, 480]\nfield_deg = 208.0\n\
             pose = {{ yaw_deg = {yaw_deg}, pitch_deg = 0.0, position_mm = [0.0, {left_mm}, 0.0] }}\n\
             lens = {{ model = 'equidistant', focal_px_per_rad = 130.0, centre_px = [239.5, 239.5] }}\n"
        )
    };
    let text = format!(
        "name = 'pair'\nmedium = 'air'\nstitch_distance_m = {distance}\n[left]\n{}[right]\n{}",
        eye(90.0, 60.0),
        eye(-90.0, -60.0)
    );
    Rig::from_toml(&text, "pair").unwrap()
}

/// Both pictures of a round hall patterned all around, the right one darker by a fifth.
fn hall(rig: &Rig, radius_m: f64, contrast: f64) -> Eyes<RgbImage> {
    [(&rig.left, 1.0), (&rig.right, 0.8)].map(|(eye, gain)| {
        let eye = eye.as_ref().unwrap();
        RgbImage::from_fn(480, 480, |x, y| {
            let Ok(ray) = eye.eye.unproject([f64::from(x), f64::from(y)]) else {
                return Rgb([0; 3]);
            };
            let ray: Vector3<f64> = eye.pose.rotation * ray;
            let along = eye.pose.position_m.dot(&ray);
            let room = along * along - eye.pose.position_m.norm_squared() + radius_m * radius_m;
            let (yaw, pitch) = yaw_pitch(&(eye.pose.position_m + ray * (room.sqrt() - along)));
            let wave = (23.0 * yaw + 3.0 * (5.0 * pitch).sin()).sin() * (17.0 * pitch).cos()
                + 0.5 * (41.0 * yaw - 29.0 * pitch).sin();
            Rgb([(gain * (120.0 + contrast * wave)).round() as u8; 3])
        })
    })
}

#[test]
fn the_walls_distance_is_found_whatever_the_rig_says() {
    for (radius_m, said) in [(1.5, "inf"), (1.0, "inf"), (1.5, "0.5"), (400.0, "1.0")] {
        let rig = rig(said);
        let pictures = hall(&rig, radius_m, 60.0);
        let found = scene_distance(&rig, &[pictures.each_ref()], Toward::Everywhere)
            .unwrap()
            .unwrap();
        println!(
            "walls at {radius_m} m, the rig says {said}: {} m, SSIM {:.3} instead of {:.3} (± {:.3})",
            found.distance_m, found.ssim, found.ssim_of_rig, found.gain_standard_error
        );
        assert!(found.is_clear, "{found:?}");
        // Half a step of parallax, which is a pixel of 512 a turn.
        let off = 0.12 * (1.0 / found.distance_m - 1.0 / radius_m);
        assert!(off.abs() < 0.5 * std::f64::consts::TAU / 512.0, "{found:?}");
    }
}

#[test]
fn nothing_is_changed_without_evidence() {
    // The rig is right.
    let right = rig("1.5");
    let pictures = hall(&right, 1.5, 60.0);
    let found = scene_distance(&right, &[pictures.each_ref()], Toward::Everywhere)
        .unwrap()
        .unwrap();
    assert!(!found.is_clear, "{found:?}");
    // Walls nearer than the overlap can be pushed.
    let far = rig("inf");
    let pictures = hall(&far, 0.6, 60.0);
    let found = scene_distance(&far, &[pictures.each_ref()], Toward::Everywhere)
        .unwrap()
        .unwrap();
    assert!(!found.is_clear, "{found:?}");
    // Bare walls.
    let pictures = hall(&far, 1.5, 0.0);
    let found = scene_distance(&far, &[pictures.each_ref()], Toward::Everywhere)
        .unwrap()
        .unwrap();
    assert!(!found.is_clear, "{found:?}");
    // Eyes in one place have no parallax.
    let text = far.to_toml().unwrap();
    let text = text.replace("60.0", "0.0").replace("-0.0", "0.0");
    let one = Rig::from_toml(&text, "one").unwrap();
    assert_eq!(
        scene_distance(&one, &[pictures.each_ref()], Toward::Everywhere),
        Ok(None)
    );
}
