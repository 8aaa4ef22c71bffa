//! `tectum align`: orientation boards beside the simulated fish.

use serde_json::Value;

use crate::common::Bench;

const BOARD: &str = "--board 7x5 --square-mm 60 --distance-mm 250 --origin 2,1";

/// A scene with a board on one side: columns -2 to 4, rows -1 to 3 of 60 mm squares, 250 mm away.
fn scene(out: f64) -> String {
    format!(
        "texture_seed = 1\npool = {{ length_m = 6.0, width_m = 6.0, depth_m = 4.0, \
         freeboard_m = 0.3, tile_mm = 150.0 }}\nmedium = {{ kind = \"air\" }}\n[[boards]]\n\
         columns = 7\nrows = 5\nsquare_mm = 60.0\n\
         pose = {{ position_m = [0.06, {}, 0.06], yaw_deg = {} }}\n",
        0.25 * out,
        -90.0 * out
    )
}

/// With `left.png` and `right.png`: stitched pictures of the board on each side, the body turned by
/// `attitude` while the boards stand still.
fn with_boards(attitude: &str) -> Bench {
    let bench = Bench::new();
    bench.done("bake rig.toml -o fish.tct --size 640x320 --max-error 0.2");
    stitch_boards(&bench, &format!("rig.toml --attitude {attitude}"));
    bench
}

/// Stitches the board on each side as the eyes of `truth`, a rig and options of `simulate`, see it.
fn stitch_boards(bench: &Bench, truth: &str) {
    for (side, out) in [("left", 1.0), ("right", -1.0)] {
        std::fs::write(bench.path("scene.toml"), scene(out)).unwrap();
        bench.done(&format!("simulate {truth} -o {side} --scene scene.toml"));
        bench.done(&format!(
            "stitch fish.tct --left {side}/left.png --right {side}/right.png -o {side}.png"
        ));
    }
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value}"))
}

#[test]
fn a_head_that_is_turned_in_the_body_is_put_right() {
    // Eyes that look 2 degrees to the left, 1 up and lean 3 degrees in a body that does not.
    let bench = with_boards("2,-1,3");
    let align = format!(
        "align fish.tct --rig rig.toml --board-left left.png --board-right right.png {BOARD}"
    );
    let json = bench.json(&format!("{align} -o aligned.toml --picture check.png"));
    assert_eq!((&json["pairs"], &json["inliers"]), (&70.into(), &70.into()));
    assert!(number(&json["rms_deg"]) > 2.0, "{json}");
    // Corners of small pictures are good to 0.1 px of 0.56 degrees each; 70 of them fix the turn.
    for (about, wanted) in [("yaw", 2.0), ("pitch", -1.0), ("roll", 3.0)] {
        let has = number(&json["turn_deg"][about]);
        // Rotations of several degrees do not commute: 0.05 degrees.
        assert!((has - wanted).abs() < 0.1, "{about} {has}");
    }
    assert!(number(&json["turned_rms_deg"]) < 0.1, "{json}");
    let first = &json["corners"][0];
    assert!(first["yaw_deg"].is_number() && first["shown_pitch_deg"].is_number());
    assert!(bench.path("check.png").exists());

    // The rig put right, baked and used again, says the truth.
    bench.done("bake aligned.toml -o fish.tct --size 640x320 --max-error 0.2");
    for side in ["left", "right"] {
        bench.done(&format!(
            "stitch fish.tct --left {side}/left.png --right {side}/right.png -o {side}.png"
        ));
    }
    let again = align.replace("rig.toml", "aligned.toml");
    let json = bench.json(&again);
    assert!(number(&json["rms_deg"]) < 0.1, "{json}");
    let text = bench.done(&format!("{again} --convention paper"));
    assert!(text.contains("best turn"), "{text}");

    // A scale of its own goes into the rig as a bend, and the table takes it.
    bench.done(&format!("{again} -o own.toml --correct scale"));
    assert!(
        bench
            .files()
            .iter()
            .any(|file| file.starts_with("own-warp-"))
    );
    bench.done("bake own.toml -o own.tct --size 640x320 --max-error 0.2");
}

/// Turned by 2 degrees, each eye in its place or the body with both: both are found, and told apart.
#[test]
fn eyes_turned_in_place_are_told_from_a_turned_body() {
    let bench = Bench::new();
    bench.done("bake rig.toml -o fish.tct --size 640x320 --max-error 0.2");
    let mount = "[mount]\npsi_deg = 25.7\ntau_deg = 29.15\nlateral_mm = 30.0\n";
    let mut truth = std::fs::read_to_string(bench.path("rig.toml")).unwrap();
    assert!(truth.contains(mount), "{truth}");
    truth = truth.replace(mount, "");
    for (eye, yaw_deg, y_mm) in [("left", 79.15, 30.0), ("right", -75.15, -30.0)] {
        let pose = format!(
            "[{eye}]\npose = {{ yaw_deg = {yaw_deg}, pitch_deg = -29.15, position_mm = [0.0, {y_mm:.1}, \
             0.0] }}\n"
        );
        truth = truth.replace(&format!("[{eye}]\n"), &pose);
    }
    std::fs::write(bench.path("truth.toml"), truth).unwrap();
    let align = format!(
        "align fish.tct --rig rig.toml --board-left left.png --board-right right.png {BOARD}"
    );
    for (turned, truth) in [
        ("eyes", "truth.toml"),
        ("body", "rig.toml --attitude 2,0,0"),
    ] {
        stitch_boards(&bench, truth);
        let json = bench.json(&align);
        assert_eq!(json["turned"], turned, "{json}");
        assert_eq!(json["undecided"], false);
        for (about, wanted) in [("yaw", 2.0), ("pitch", 0.0), ("roll", 0.0)] {
            let has = number(&json["turn_deg"][about]);
            assert!((has - wanted).abs() < 0.02, "{turned}: {about} {has}");
        }
    }
}

#[test]
fn what_cannot_be_is_refused() {
    let bench = with_boards("0,0,0");
    let align = "align fish.tct --rig rig.toml --board-left left.png";
    let refused = |arguments: &str, says: &str| {
        let message = bench.refused(1, arguments);
        assert!(message.contains(says), "{arguments}: {message}");
    };
    refused(
        &format!("{align} --board 7x5 --square-mm 60 --distance-mm 250 --origin 7,1"),
        "not on a board of 7x5",
    );
    refused(
        &format!("{align} --board 9x5 --square-mm 60 --distance-mm 250 --origin 2,1"),
        "only 7x5",
    );
    refused(
        &format!("align fish.tct --rig rig.toml --board-right left.png {BOARD}"),
        "not on the fish's right side",
    );
    refused(
        &format!("{align} --board-left right.png {BOARD}"),
        "not on the fish's left side",
    );
    refused(
        &format!("align fish.tct --rig rig.toml --board-left left/left.png {BOARD}"),
        "the picture is 240x240 px",
    );
    let blank = image::GrayImage::from_pixel(640, 320, image::Luma([90]));
    blank.save(bench.path("blank.png")).unwrap();
    refused(
        &format!("align fish.tct --rig rig.toml --board-left blank.png {BOARD}"),
        "no chessboard found",
    );
    std::fs::copy(bench.path("rig.toml"), bench.path("other.toml")).unwrap();
    let text = std::fs::read_to_string(bench.path("rig.toml")).unwrap();
    std::fs::write(bench.path("other.toml"), text.replace("29.15", "20.0")).unwrap();
    refused(
        &format!("{align} {BOARD}").replace("rig.toml", "other.toml"),
        "was not baked from",
    );
    let usage = bench.refused(2, &format!("{align} {BOARD}").replace("250", "0"));
    assert!(usage.contains("a distance and a square"), "{usage}");
}
