//! Look-up on the core, over the full field of every rig of the repository: within the limit of
//! what the rig itself says.

use std::path::Path;

use nalgebra::Vector3;
use tectum_bake::{BakeOptions, bake, output_map};
use tectum_core::{Direction, Eye, Lookup, Tables};
use tectum_optics::{Projection, Rig, convention};

/// Greatest angle that a look-up on the core may be off, degrees (design, section 8).
const LIMIT_DEG: f64 = 0.02;

fn rigs() -> Vec<Rig> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tables/rigs");
    let mut files: Vec<_> = std::fs::read_dir(folder)
        .expect("tables/rigs")
        .map(|entry| entry.expect("readable").path())
        .filter(|path| path.extension().is_some_and(|e| e == "toml"))
        .collect();
    files.sort();
    let rigs: Vec<Rig> = files
        .iter()
        .map(|path| Rig::load(path).expect("sound"))
        .collect();
    assert!(rigs.len() >= 7);
    rigs
}

fn table(rig: &Rig, projection: Projection) -> Vec<u8> {
    let options = BakeOptions {
        output: projection.output_map([640, 320]).expect("a sound size"),
        max_error_px: 0.2,
        feather_rad: 0.05,
    };
    let baked = bake(rig, &options);
    baked
        .unwrap_or_else(|error| panic!("{}: {error}", rig.name))
        .bytes
}

fn vector(direction: Direction) -> Vector3<f64> {
    let [yaw, pitch] = [direction.yaw, direction.pitch].map(|a| f64::from(a.rad()));
    convention::direction(yaw, pitch)
}

fn angle_deg(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    convention::angle_between(a, b).to_degrees()
}

#[test]
fn raw_pixels_of_every_rig_there_and_back() {
    for rig in rigs() {
        let bytes = table(&rig, Projection::Equirect);
        let tables = Tables::parse(&bytes).unwrap();
        let lookup = Lookup::new(&tables);
        let (mut there, mut back, mut seen) = (0f64, 0f64, 0);
        for (eye, truth) in [(Eye::Left, &rig.left), (Eye::Right, &rig.right)] {
            let truth = truth.as_ref().unwrap();
            let [width, height] = truth.eye.size_px;
            for x in (0..width).step_by(usize::from(width) / 70) {
                for y in (0..height).step_by(usize::from(height) / 70) {
                    let pixel = [x, y].map(f64::from);
                    let found =
                        lookup.direction_of_eye_pixel(eye, [x, y].map(|p| i32::from(p) << 8));
                    let Ok(exact) = truth.direction_of(pixel, rig.stitch_distance_m) else {
                        continue;
                    };
                    let found = found.unwrap_or_else(|| panic!("{}: {pixel:?}", rig.name));
                    there = there.max(angle_deg(&vector(found), &exact));
                    let Some(again) = lookup.eye_pixel_of_direction(eye, found) else {
                        // Half a unit of the angle may lie beyond the border of the field or frame.
                        continue;
                    };
                    let again = again.map(|q8| f64::from(q8) / 256.0);
                    if let Ok(exact) = truth.direction_of(again, rig.stitch_distance_m) {
                        back = back.max(angle_deg(&vector(found), &exact));
                        seen += 1;
                    }
                }
            }
        }
        println!(
            "{}: raw pixel to direction {there:.4}, back {back:.4} degrees, {seen} pixels",
            rig.name
        );
        assert!(
            there <= LIMIT_DEG && back <= LIMIT_DEG,
            "{}: {there} {back}",
            rig.name
        );
        assert!(seen > 1500, "{}: {seen}", rig.name);
    }
}

#[test]
fn output_pixels_of_every_rig_there_and_back() {
    for rig in rigs() {
        for projection in [
            Projection::Equirect,
            rig.design_projection().unwrap_or(Projection::Equirect),
        ] {
            let bytes = table(&rig, projection);
            let tables = Tables::parse(&bytes).unwrap();
            let (lookup, map) = (Lookup::new(&tables), output_map(&tables));
            let (mut there, mut back) = (0f64, 0f64);
            for (x, y) in (0..400)
                .step_by(7)
                .flat_map(|x| (0..320).step_by(7).map(move |y| (x, y)))
            {
                let exact = map.ray(f64::from(x), f64::from(y)).expect("a full sphere");
                let found = lookup
                    .direction_of_pixel([x * 256, y * 256])
                    .expect("a full sphere");
                there = there.max(angle_deg(&vector(found), &exact));
                if let Some([x, y]) = lookup.pixel_of_direction(found) {
                    let exact = map.ray(f64::from(x) / 256.0, f64::from(y) / 256.0);
                    back = exact.map_or(back, |exact| back.max(angle_deg(&vector(found), &exact)));
                }
            }
            println!(
                "{}: output pixel to direction {there:.4}, back {back:.4} degrees",
                rig.name
            );
            assert!(
                there <= LIMIT_DEG && back <= LIMIT_DEG,
                "{}: {there} {back}",
                rig.name
            );
        }
    }
}
