//! The paper's fish, baked: does it meet the budgets of the design, and is it what it claims?

use tectum_bake::{BakeError, BakeOptions, Baked, bake};
use tectum_core::{BinaryAngle, Direction, Eye, Lookup, Tables};
use tectum_optics::{OutputMap, Projection, Rig, convention};

fn fish(side_px: u32) -> Rig {
    let centre = f64::from(side_px - 1) / 2.0;
    let focal = f64::from(side_px) * (238.0 / 480.0) / 105f64.to_radians();
    let eye = format!(
        "size_px = [{side_px}, {side_px}]\nfield_deg = 210.0\nlens = {{ model = 'equidistant', \
         focal_px_per_rad = {focal}, centre_px = [{centre}, {centre}] }}\n"
    );
    let text = format!(
        "name = 'paper-fish'\nmedium = 'water'\nstitch_distance_m = 2.0\n[mount]\n\
         psi_deg = 25.7\ntau_deg = 29.15\nlateral_mm = 30.0\n[left]\n{eye}[right]\n{eye}"
    );
    Rig::from_toml(&text, "fish").expect("a sound rig")
}

fn equirect(size_px: [u16; 2]) -> OutputMap {
    Projection::Equirect
        .output_map(size_px)
        .expect("a sound size")
}

fn baked(rig: &Rig, output: OutputMap, max_error_px: f64) -> Result<Baked, BakeError> {
    bake(
        rig,
        &BakeOptions {
            output,
            max_error_px,
            feather_rad: 4f64.to_radians(),
        },
    )
}

#[test]
fn the_small_table_meets_its_budget() {
    let report = baked(&fish(480), equirect([640, 320]), 0.05)
        .unwrap()
        .report;
    println!("{report:?}");
    assert!(report.bytes.mesh_left <= 4096 && report.bytes.mesh_right <= 4096);
    assert!(report.bytes.runs <= 5 * 1024, "{}", report.bytes.runs);
    assert!(report.coordinate_error_px.max <= 0.05);
    assert!(report.coordinate_error_px.rms <= 0.01);
}

#[test]
fn the_large_table_meets_its_budget() {
    let report = baked(&fish(960), equirect([1280, 640]), 0.035)
        .unwrap()
        .report;
    println!("{report:?}");
    assert!(report.bytes.mesh_left <= 14_643 && report.bytes.mesh_right <= 14_643);
    assert!(report.coordinate_error_px.max <= 0.035);
}

#[test]
fn baking_twice_gives_the_same_bytes() {
    let [a, b] = [0, 1].map(|_| baked(&fish(240), equirect([320, 160]), 0.1).unwrap().bytes);
    assert_eq!(a, b);
}

#[test]
fn what_cannot_be_met_is_refused_with_what_can() {
    let error = baked(&fish(480), equirect([320, 160]), 0.01)
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("step 8 gives") && error.contains("--max-error"),
        "{error}"
    );
    let coarse = baked(&fish(960), equirect([64, 32]), 1.0)
        .unwrap_err()
        .to_string();
    assert!(coarse.contains("100 source px apart"), "{coarse}");
    assert!(matches!(
        baked(&fish(240), equirect([320, 160]), f64::NAN),
        Err(BakeError::MaxError(_))
    ));
}

/// Greatest angle that a look-up on the core may be off, degrees (design, section 8).
const LOOKUP_LIMIT_DEG: f64 = 0.02;

fn angle_deg(direction: Direction, truth: &nalgebra::Vector3<f64>) -> f64 {
    let [yaw, pitch] = [direction.yaw, direction.pitch].map(|a| f64::from(a.rad()));
    convention::angle_between(&convention::direction(yaw, pitch), truth).to_degrees()
}

#[test]
fn output_pixels_are_looked_up_within_the_limit_in_every_projection() {
    let rig = fish(240);
    let rotation = tectum_optics::Pose::axis_rotation(0.4, -0.3, 0.2)
        * tectum_optics::Pose::axis_rotation(0.0, 0.0, 0.0).inverse();
    for projection in [
        Projection::Equirect,
        rig.design_projection().unwrap(),
        Projection::Cylindrical {
            half_height_rad: 1.0,
        },
        Projection::Fisheye {
            rotation,
            field_rad: 2.6,
        },
        Projection::Perspective {
            rotation,
            width_rad: 1.5,
        },
    ] {
        let output = projection.output_map([320, 160]).unwrap();
        let baked = baked(&rig, output, 0.5).unwrap();
        let tables = Tables::parse(&baked.bytes).unwrap();
        let lookup = Lookup::new(&tables);
        let (mut worst, mut returned) = (0f64, 0);
        for (x, y) in (0..320)
            .step_by(7)
            .flat_map(|x| (0..160).step_by(5).map(move |y| (x, y)))
        {
            let truth = output.ray(f64::from(x), f64::from(y));
            let found = lookup.direction_of_pixel([x * 256, y * 256]);
            let (Some(truth), Some(found)) = (truth, found) else {
                assert!(truth.is_none() && found.is_none(), "{projection:?} {x} {y}");
                continue;
            };
            worst = worst.max(angle_deg(found, &truth));
            // There and back; compared as directions, since a pole is a whole row of pixels.
            let Some(back) = lookup.pixel_of_direction(found) else {
                continue;
            };
            let again = lookup.direction_of_pixel(back).expect("in the picture");
            worst = worst.max(angle_deg(again, &truth));
            returned += 1;
        }
        println!("{projection:?}: {worst:.5} degrees");
        // All but directions that rounding puts across a border.
        assert!(returned > 1200, "{projection:?}: {returned}");
        assert!(worst <= LOOKUP_LIMIT_DEG, "{projection:?}: {worst}");
    }
}

#[test]
fn raw_eye_pixels_are_looked_up_within_the_limit() {
    raw_pixels_are_right(&fish(480));
}

#[test]
fn raw_pixels_of_a_decentred_skewed_lens_are_looked_up_within_the_limit() {
    // Half a pixel of decentring at the rim.
    let eye = "size_px = [480, 480]\nfield_deg = 208.0\nlens = { model = 'ocam', \
               direct = [-130.0, 0.0, 2.56e-3, 0.0, 1.0e-8], centre_row_column = [241.0, 238.5], \
               affine = [1.002, 0.001, -0.002], decentring_per_px = [3e-6, -2e-6] }\n";
    let text = format!(
        "name = 'decentred'\nmedium = 'water'\nstitch_distance_m = 2.0\n[mount]\n\
         psi_deg = 25.7\ntau_deg = 29.15\nlateral_mm = 30.0\n[left]\n{eye}[right]\n{eye}"
    );
    raw_pixels_are_right(&Rig::from_toml(&text, "decentred").expect("a sound rig"));
}

fn raw_pixels_are_right(rig: &Rig) {
    let baked = baked(rig, equirect([640, 320]), 0.05).unwrap();
    let tables = Tables::parse(&baked.bytes).unwrap();
    let lookup = Lookup::new(&tables);
    let mut worst: f64 = 0.0;
    for (eye, truth) in [(Eye::Left, &rig.left), (Eye::Right, &rig.right)] {
        let truth = truth.as_ref().unwrap();
        for (x, y) in (0..480)
            .step_by(9)
            .flat_map(|x| (0..480).step_by(11).map(move |y| (x, y)))
        {
            let found = lookup.direction_of_eye_pixel(eye, [x * 256, y * 256]);
            let exact = truth.direction_of([f64::from(x), f64::from(y)], rig.stitch_distance_m);
            match (found, exact) {
                (Some(found), Ok(exact)) => worst = worst.max(angle_deg(found, &exact)),
                (found, exact) => assert!(found.is_none() && exact.is_err(), "{x} {y}"),
            }
        }
    }
    println!("raw eye pixels: {worst:.5} degrees");
    assert!(worst <= LOOKUP_LIMIT_DEG, "{worst}");
    assert_eq!(lookup.direction_of_eye_pixel(Eye::Left, [0, 0]), None);
}

#[test]
fn forward_is_in_the_middle() {
    let baked = baked(&fish(240), equirect([320, 160]), 0.5).unwrap();
    let tables = Tables::parse(&baked.bytes).unwrap();
    let ahead = Direction {
        yaw: BinaryAngle(0),
        pitch: BinaryAngle(0),
    };
    let pixel = Lookup::new(&tables).pixel_of_direction(ahead);
    // Column 159.5, row 79.5 in Q8.
    assert_eq!(pixel, Some([40_832, 20_352]));
}
