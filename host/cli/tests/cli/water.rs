//! `tectum water`: an eye in air to an eye in water.

use std::fs;

use crate::common::Bench;

const EYE: &str = "medium = \"air\"\n\n[eye]\nsize_px = [960, 960]\nfield_deg = 210.0\n\n\
                   [eye.lens]\nmodel = \"equidistant\"\nfocal_px_per_rad = 250.0\n\
                   centre_px = [479.5, 479.5]\n";

#[test]
fn an_eye_of_210_degrees_sees_156_in_water() {
    let bench = Bench::new();
    fs::write(bench.path("eye.toml"), EYE).unwrap();
    let json = bench.json("water eye.toml --air-deg 105 --water-deg 77.92 -o wet.toml");
    // Half of the last digit given, doubled.
    assert!((json["field_water_deg"].as_f64().unwrap() - 155.84).abs() < 0.01);
    assert!((json["kappa"].as_f64().unwrap() - 0.694).abs() < 1e-3);
    assert!(json["misfit_deg"].as_f64().unwrap() < 1e-3, "{json}");
    assert_eq!(json["prediction"], true);
    let text = fs::read_to_string(bench.path("wet.toml")).unwrap();
    assert!(
        text.contains("medium = \"water\"") && text.contains("prediction"),
        "{text}"
    );
    // It was converted already.
    let message = bench.refused(1, "water wet.toml --kappa 0.5 -o again.toml");
    assert!(message.contains("calibrated in air"), "{message}");
}

#[test]
fn bad_requests_say_what_is_allowed() {
    let bench = Bench::new();
    fs::write(bench.path("eye.toml"), EYE).unwrap();
    for (code, arguments, part) in [
        (2, "water eye.toml -o wet.toml", "--kappa"),
        (2, "water eye.toml --air-deg 105 -o wet.toml", "--water-deg"),
        (
            2,
            "water eye.toml --kappa 0.5 --air-deg 9 --water-deg 8 -o wet.toml",
            "--kappa",
        ),
        (1, "water eye.toml --kappa 1.5 -o wet.toml", "flat port"),
        (1, "water eye.toml --kappa nan -o wet.toml", "flat port"),
        (
            1,
            "water eye.toml --kappa 0.9 -o wet.toml",
            "too large for this lens",
        ),
        (
            1,
            "water eye.toml --air-deg 105 --water-deg 20 -o wet.toml",
            "105.00",
        ),
        (1, "water none.toml --kappa 0.5 -o wet.toml", "none.toml"),
    ] {
        let message = bench.refused(code, arguments);
        assert!(message.contains(part), "{arguments}: {message}");
    }
}
