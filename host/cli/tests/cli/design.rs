//! `tectum design`: mounts, what they see, and fields measured in a tank.

use serde_json::Value;

use crate::common::Bench;

const PAPER: &str = "design --psi 25.7 --tau 29.15 --theta 210";

#[track_caller]
fn near(value: &Value, expected: f64, tolerance: f64) {
    let has = value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is no number"));
    assert!(
        (has - expected).abs() <= tolerance,
        "{has} is not {expected}"
    );
}

#[test]
fn the_papers_fish() {
    let bench = Bench::new();
    let json = bench.json(PAPER);
    // Half of the last digit printed.
    near(&json["xi_deg"], 64.91, 0.005);
    near(&json["zeta_deg"], 68.26, 0.005);
    near(&json["phi_deg"], 93.26, 0.005);
    near(&json["theta_total_deg"], 326.74, 0.005);
    near(&json["paper"]["phi_deg"], 55.7, 0.005);
    near(&json["paper"]["theta_total_deg"], 364.3, 0.005);
    near(&json["horizontal"]["outer_deg"], 360.0, 1e-9);
    near(&json["horizontal"]["front_overlap_deg"], 60.2, 0.05);
    near(&json["sphere"]["seen"], 0.936, 0.0005);
    near(&json["sphere"]["both"], 0.323, 0.0005);
    assert_eq!(json["blind_zones"].as_array().unwrap().len(), 1);
    // sin(water) = sin(air) / 1.333 at grazing.
    near(&json["water"]["flat_port"]["theta_deg"], 97.2, 0.05);
    near(&json["water"]["bare"]["theta_deg"], 155.84, 0.05);
    near(&json["water"]["dome"]["theta_total_deg"], 326.74, 0.005);
    let text = bench.done(PAPER);
    for part in [
        "93.26",
        "55.70",
        "326.74",
        "364.30",
        "tau 0 only",
        "blind zone",
    ] {
        assert!(text.contains(part), "no {part} in {text}");
    }
}

#[test]
fn a_rig_an_eye_and_the_hulls_normal_are_mounts_too() {
    let bench = Bench::new();
    let rig = bench.json("design --rig rig.toml");
    near(&rig["psi_deg"], 25.7, 1e-9);
    near(&rig["phi_deg"], 93.26, 0.005);
    // The shipped fish's lenses were made in water.
    assert_eq!(
        (&rig["medium"], &rig["water"]),
        (&"water".into(), &Value::Null)
    );
    let eye = "medium = \"air\"\n\n[eye]\nsize_px = [480, 360]\nfield_deg = 210.0\n\n[eye.lens]\n\
               model = \"equidistant\"\nfocal_px_per_rad = 130.9625\ncentre_px = [239.5, 179.5]\n";
    std::fs::write(bench.path("eye.toml"), eye).unwrap();
    // psi = 180 - 2 atan2(1, 0.2), tau = 0; a circle of 480 px clipped to 360 px.
    let by_eye =
        bench.json("design --normal 0.2,1,0 --eye eye.toml --plane 0 --plane-normal 0,0,1");
    near(&by_eye["psi_deg"], 22.6199, 1e-3);
    let by_sensor = bench.json("design --normal 0.2,1,0 --theta 210 --sensor 4:3");
    for key in ["seen", "both"] {
        // Two numerical spheres; half a pixel of the border.
        let expected = by_sensor["sphere"][key].as_f64().unwrap();
        near(&by_eye["sphere"][key], expected, 2e-3);
    }
    let planes = by_eye["planes"].as_array().unwrap();
    for plane in planes {
        let expected = by_eye["horizontal"]["seen_deg"].as_f64().unwrap();
        near(&plane["seen_deg"], expected, 1e-6);
    }
    assert_eq!((planes.len(), &planes[1]["normal"][2]), (2, &1.0.into()));
}

#[test]
fn wishes_are_fulfilled_by_the_mounts_that_are_named() {
    let bench = Bench::new();
    let json = bench.json("design --theta 180 --want front=40 --want zeta=30..60 --count 3");
    let mounts = json["mounts"].as_array().unwrap();
    assert_eq!(mounts.len(), 3);
    for mount in mounts {
        let [psi, tau] = ["psi_deg", "tau_deg"].map(|key| mount[key].as_f64().unwrap());
        let forward = bench.json(&format!("design --psi {psi} --tau {tau} --theta 180"));
        // What is promised.
        near(&forward["horizontal"]["front_overlap_deg"], 40.0, 0.01);
        let zeta = forward["zeta_deg"].as_f64().unwrap();
        assert!((29.99..60.01).contains(&zeta), "{zeta}");
    }
    assert_eq!(json["trade_offs"].as_array().unwrap().len(), 3);
    let text = bench
        .done("design --theta 150..210 --medium bare --margin 2 --want front=5.. --best margin");
    assert!(
        text.contains("trade-offs") && text.contains("held back"),
        "{text}"
    );
}

#[test]
fn the_papers_tank_is_explained() {
    let bench = Bench::new();
    let walls = "--wall-distance-mm 300 --wall-horizontal-mm 302 --wall-design-mm 755";
    let json = bench.json(&format!("{PAPER} {walls}"));
    let measured = &json["measured"];
    near(&measured["horizontal"]["measured_deg"], 306.5647, 5e-5);
    near(&measured["design"]["measured_deg"], 256.95, 0.005);
    let list = measured["explanations"].as_array().unwrap();
    let of = |sensor: &str| {
        let is = |e: &&Value| e["sensor"] == sensor && e["fitted_on"] == "horizontal";
        list.iter().find(is).unwrap()
    };
    near(&of("not clipped")["kappa"], 0.694, 5e-4);
    near(&of("not clipped")["predicted_deg"], 272.6, 0.05);
    near(&of("clipped 5:4")["predicted_deg"], 258.6, 0.05);
    near(&of("clipped 4:3")["error_deg"], 251.3 - 256.95, 0.05);
    let rig = bench.json(
        "design --rig rig.toml --wall-distance-mm 300 --edge-left 60,190 --edge-right 180,190",
    );
    let edges = &rig["measured"]["edges"];
    assert!(edges["outer_deg"].as_f64().unwrap() > 180.0, "{edges}");
    assert!(edges["wall"]["width_mm"].as_f64().unwrap() > 0.0, "{edges}");
}

#[test]
fn pictures_are_drawn_in_both_formats() {
    let bench = Bench::new();
    let json = bench.json(&format!(
        "{PAPER} --sensor 5:4 --medium bare --plane -20 --plane-normal 1,0,0 --pictures seen"
    ));
    let files = json["files"].as_array().unwrap();
    assert_eq!(files.len(), 14);
    for file in files {
        let name = format!("seen/{}", file.as_str().unwrap());
        if name.ends_with(".png") {
            assert!(bench.picture_size(&name).0 >= 700, "{name}");
        } else {
            let svg = std::fs::read_to_string(bench.path(&name)).unwrap();
            assert!(
                svg.starts_with("<svg ") && svg.ends_with("</svg>\n"),
                "{name}"
            );
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "{name}");
        }
    }
}

#[test]
fn impossible_designs_say_why() {
    let bench = Bench::new();
    let tank = format!("{PAPER} --wall-distance-mm");
    let one_eye = std::fs::read_to_string(bench.path("rig.toml")).unwrap();
    let one_eye = one_eye.split("[right]").next().unwrap();
    std::fs::write(bench.path("one.toml"), one_eye).unwrap();
    for (code, arguments, part) in [
        (1, "design --psi 180 --tau 0 --theta 210", "psi of 180"),
        (1, "design --psi 20 --tau -90 --theta 210", "tau of -90"),
        (1, "design --psi 20 --tau 20 --theta 0", "theta of 0"),
        (1, "design --psi 20 --tau 20 --theta 359", "at most 358"),
        (1, "design --normal 0,0,0 --theta 210", "hull's normal"),
        (1, "design --normal 1,0,0 --theta 210", "left eye"),
        (1, "design --rig one.toml", "both eyes"),
        (1, "design --rig none.toml", "none.toml"),
        (
            1,
            "design --psi 9 --tau 9 --theta 99 --plane-normal 0,0,0",
            "plane's normal",
        ),
        (
            1,
            "design --psi 9 --tau 9 --theta 99 --sensor 0:3",
            "sensor of 0:3",
        ),
        (
            1,
            "design --psi 9 --tau 9 --theta 210 --medium bare --kappa 0.9",
            "too large",
        ),
        (
            1,
            "design --psi 9 --tau 9 --theta 99 --kappa 2",
            "flat port",
        ),
        (
            1,
            &format!("{tank} 0 --wall-horizontal-mm 302"),
            "distance of 0",
        ),
        (
            1,
            &format!("{tank} -30 --wall-design-mm 302"),
            "distance of -30",
        ),
        (
            1,
            &format!("{tank} 300 --wall-horizontal-mm -1"),
            "points on the wall",
        ),
        (
            1,
            "design --rig rig.toml --edge-left 0,0 --edge-right 9,9",
            "0,0 of the left eye",
        ),
        (1, "design --theta 210 --want total=400", "0 to 360"),
        (
            1,
            "design --theta 210 --want phi=90 --want total=300",
            "nearest",
        ),
        (
            1,
            "design --theta 210 --psi 0..400 --want phi=90",
            "-179 to 179",
        ),
        (
            1,
            "design --theta 210 --want phi=90 --margin 90",
            "margin of 90",
        ),
        (2, "design", "--psi"),
        (2, "design --psi 25.7 --tau 29.15", "--theta"),
        (2, "design --psi 20..30 --tau 29.15 --theta 210", "range"),
        (2, "design --psi x --tau 29.15 --theta 210", "LOW..HIGH"),
        (2, "design --want front=40", "--theta"),
        (2, "design --theta 210 --want back=40", "front=40"),
        (2, "design --theta 210 --want front=..", "front=40"),
        (2, &format!("{PAPER} --margin 2"), "--want"),
        (
            2,
            &format!("{PAPER} --wall-horizontal-mm 302"),
            "--wall-distance-mm",
        ),
        (2, &format!("{tank} 300"), "--wall-horizontal-mm"),
        (2, "design --rig rig.toml --psi 3", "--psi"),
        (
            2,
            "design --rig rig.toml --medium dome",
            "calibrated in water",
        ),
        (
            2,
            "design --theta 210 --want phi=90 --pictures p",
            "--pictures",
        ),
    ] {
        let message = bench.refused(code, arguments);
        assert!(message.contains(part), "{arguments}: {message}");
    }
}
