use super::*;

const FISH: &str = r#"
name = "fish"
medium = "water"
stitch_distance_m = 2.0
[mount]
psi_deg = 25.7
tau_deg = 29.15
lateral_mm = 30.0
[left]
size_px = [480, 480]
field_deg = 210.0
lens = { model = "equidistant", focal_px_per_rad = 129.9, centre_px = [239.5, 239.5] }
[right]
size_px = [480, 480]
half_angles_deg = [105.0, 100.0, 105.0, 100.0]
[right.lens]
model = "ocam"
direct = [-130.0, 0.0, 1e-3]
centre_row_column = [239.0, 240.0]
affine = [1.0, 0.001, -0.001]
"#;

fn message(text: &str) -> String {
    Rig::from_toml(text, "rig.toml").unwrap_err().to_string()
}

#[test]
fn a_rig_is_written_and_read_equal() {
    let rig = Rig::from_toml(FISH, "rig.toml").unwrap();
    let again = Rig::from_toml(&rig.to_toml().unwrap(), "again").unwrap();
    assert_eq!(rig, again);
    assert_eq!(rig.fingerprint(), again.fingerprint());
    let moved = FISH.replace("30.0", "31.0");
    assert_ne!(
        rig.fingerprint(),
        Rig::from_toml(&moved, "x").unwrap().fingerprint()
    );
}

#[test]
fn pixels_and_directions_are_inverse_at_the_stitch_distance() {
    let rig = Rig::from_toml(FISH, "rig.toml").unwrap();
    for (eye, distance) in [
        (&rig.left, 2.0),
        (&rig.right, 0.3),
        (&rig.left, f64::INFINITY),
    ] {
        let eye = eye.as_ref().unwrap();
        for pixel in [[239.5, 239.5], [100.25, 300.5], [400.0, 239.0]] {
            let direction = eye.direction_of(pixel, distance).unwrap();
            let [x, y] = eye.pixel_of(&direction, distance).unwrap();
            // 1e-9 rad is 1e-7 px here.
            assert!(
                (x - pixel[0]).hypot(y - pixel[1]) < 1e-7,
                "{pixel:?} at {distance} m"
            );
        }
    }
}

#[test]
fn errors_name_file_key_value_and_what_is_allowed() {
    let psi = message(&FISH.replace("psi_deg = 25.7", "psi_deg = 190.0"));
    assert_eq!(
        psi,
        "rig.toml: mount.psi_deg = 190.0 is not allowed: 0 to 180"
    );
    let tau = message(&FISH.replace("tau_deg = 29.15", "tau_deg = nan"));
    assert_eq!(
        tau,
        "rig.toml: mount.tau_deg = NaN is not allowed: -90 to 90"
    );
    let field = message(&FISH.replace("field_deg = 210.0", "field_deg = 400.0"));
    assert!(field.contains("left.field_deg = 400.0"), "{field}");
    let size = message(&FISH.replace("size_px = [480, 480]", "size_px = [0, 480]"));
    assert!(size.contains("left.size_px = [0, 480]"), "{size}");
    let distance = message(&FISH.replace("stitch_distance_m = 2.0", "stitch_distance_m = -1"));
    assert!(distance.contains("stitch_distance_m"), "{distance}");
    let near = message(&FISH.replace("stitch_distance_m = 2.0", "stitch_distance_m = 0.02"));
    assert!(near.contains("farther"), "{near}");
    let unknown = message(&FISH.replace("lateral_mm", "sideways_mm"));
    assert!(unknown.contains("sideways_mm"), "{unknown}");
    let missing = message(&FISH.replace("medium = \"water\"", ""));
    assert!(missing.contains("medium"), "{missing}");
    let lens = message(&FISH.replace("focal_px_per_rad = 129.9", "focal_px_per_rad = nan"));
    assert!(lens.contains("[left.lens] focal_px_per_rad"), "{lens}");
    let mirror = message(&FISH.replace("direct = [-130.0", "direct = [130.0"));
    assert!(mirror.contains("[right.lens] a0"), "{mirror}");
}

#[test]
fn a_field_wider_than_the_lens_model_is_refused() {
    // f(rho) = 130 - 1e-3 rho^2 + 2e-5 rho^3 turns back up well inside the frame.
    let text = FISH.replace(
        "direct = [-130.0, 0.0, 1e-3]",
        "direct = [-130.0, 0.0, 1e-3, -2e-5]",
    );
    let error = message(&text);
    assert!(
        error.contains("[right] the field reaches farther"),
        "{error}"
    );
    let off = message(&FISH.replace("centre_px = [239.5, 239.5]", "centre_px = [900.0, 239.5]"));
    assert!(off.contains("left.lens: centre = [900.0, 239.5]"), "{off}");
}

#[test]
fn distances_inside_the_rig_are_refused() {
    let left = Rig::from_toml(FISH, "rig.toml").unwrap().left.unwrap();
    for distance in [0.0, 0.01, -1.0, f64::NAN] {
        assert_eq!(
            left.direction_of([200.0, 200.0], distance),
            Err(SightError::TooNear)
        );
    }
}

#[test]
fn a_reference_frame_must_be_right_handed() {
    let with = |axes: &str| {
        let reference = format!("[reference]\naxes = {{ {axes} }}\n[mount]");
        FISH.replace("[mount]", &reference)
    };
    assert!(Rig::from_toml(&with("x='forward', y='down', z='left'"), "x").is_ok());
    assert!(message(&with("x='forward', y='down', z='right'")).contains("right-handed"));
    assert!(message(&with("x='forward', y='back', z='right'")).contains("right angles"));
}

#[test]
fn poses_in_a_reference_frame_are_turned_into_the_body() {
    // Reference: camera axes of a camera that looks left.
    let text = format!(
        "{}[right.pose]\nrotation_vector_rad = [0.0, 3.141592653589793, 0.0]\n\
         position_mm = [0.0, 0.0, -100.0]\n",
        FISH.replace(
            "[mount]",
            "[reference]\naxes = { x = 'forward', y = 'down', z = 'left' }\n[mount]"
        )
    );
    let right = Rig::from_toml(&text, "x").unwrap().right.unwrap();
    assert!((right.pose.optical_axis() + Vector3::y()).norm() < 1e-12);
    assert!((right.pose.position_m + Vector3::y() * 0.1).norm() < 1e-12);
}

proptest::proptest! {
    #[test]
    fn no_text_panics(text in "\\PC{0,200}") {
        let _ = Rig::from_toml(&text, "x");
        let _ = Rig::from_toml(&FISH.replace("25.7", &text), "x");
        let _ = Rig::from_toml(&FISH.replace("129.9", &text), "x");
    }
}
