//! Ways of matching, side by side.

use crate::common::Bench;

const PAIR: &str = "--left left.png --right right.png";

#[test]
fn matchers_are_measured_and_drawn() {
    let bench = Bench::new();
    bench.done("simulate rig.toml -o . --samples 1");
    let json = bench.json(&format!(
        "match rig.toml {PAIR} --matcher rootsift,orb -o found.png"
    ));
    let rows = json["rows"].as_array().unwrap();
    let names: Vec<String> = rows
        .iter()
        .map(|row| format!("{} {}", row["pictures"], row["matcher"]).replace('"', ""))
        .collect();
    let expected = [
        "raw rootsift",
        "raw orb",
        "calibrated rootsift",
        "calibrated orb",
    ];
    assert_eq!(names, expected);
    for row in rows {
        let share = |key: &str| row[key].as_f64().unwrap();
        for key in [
            "right_share",
            "chance_share",
            "homography_share",
            "ray_share",
        ] {
            assert!((0.0..=1.0).contains(&share(key)), "{row}");
        }
        assert!(row["right"].as_u64() <= row["matches"].as_u64(), "{row}");
    }
    let (width, height) = bench.picture_size("found.png");
    assert!(width == 1800 && height > 4 * 900, "{height}");
    // The pool has no board: the row is there, empty, and says why.
    let board = "--board 8x6 --square-mm 30";
    let json = bench.json(&format!(
        "match rig.toml {PAIR} --matcher orb --raw {board}"
    ));
    let row = &json["rows"][1];
    assert_eq!(
        (&row["matcher"], &row["matches"]),
        (&"boards".into(), &0.into())
    );
    let refused = json["refused"][0].as_str().unwrap();
    assert!(refused.starts_with("pair 1: "), "{refused}");
    let text = bench.done(&format!("match rig.toml {PAIR} --matcher orb --raw"));
    assert_eq!(text.lines().count(), 2, "{text}");
    assert!(
        text.contains("orb") && !text.contains("calibrated"),
        "{text}"
    );
}

/// The farther off the board, the less one pair tells a turn of the eyes from a shift: it is said.
#[test]
fn one_pair_with_a_board_says_how_sure_the_rotation_is() {
    let bench = Bench::new();
    for (ahead_m, is_sure) in [(0.6, true), (0.8, false)] {
        std::fs::write(
            bench.path("board.toml"),
            format!(
                "texture_seed = 1\nmedium = {{ kind = \"air\" }}\n\
                 pool = {{ length_m = 6.0, width_m = 6.0, depth_m = 4.0, freeboard_m = 0.3, \
                 tile_mm = 150.0 }}\n[[boards]]\ncolumns = 8\nrows = 6\nsquare_mm = 60.0\n\
                 pose = {{ position_m = [{ahead_m}, 0.1, 0.1], yaw_deg = 175, pitch_deg = 20 }}\n"
            ),
        )
        .unwrap();
        bench.done("simulate rig.toml -o . --scene board.toml");
        let board = "--board 8x6 --square-mm 60";
        let found = format!("match rig.toml {PAIR} --matcher orb --raw {board}");
        let json = bench.json(&found);
        let row = &json["rows"][1];
        assert_eq!(row["matches"], 48, "{row}");
        let [off, sigma] = ["rotation_off_deg", "rotation_standard_error_deg"]
            .map(|key| row[key].as_f64().unwrap());
        assert!(off < 4.0 * sigma, "{ahead_m}: {off} {sigma}");
        let text = bench.done(&found);
        assert_eq!(text.contains("take more pairs"), !is_sure, "{text}");
    }
}

#[test]
fn what_cannot_be_matched_is_refused() {
    let bench = Bench::new();
    bench.done("simulate rig.toml -o . --samples 1");
    image::GrayImage::new(30, 20)
        .save(bench.path("small.png"))
        .unwrap();
    for (code, arguments, says) in [
        (2, "match rig.toml --left left.png", "--right"),
        (
            1,
            "match rig.toml --left left.png left.png --right right.png",
            "belong together",
        ),
        (
            2,
            "match rig.toml --left left.png --right right.png --matcher surf",
            "surf",
        ),
        (
            1,
            "match rig.toml --left left.png --right small.png",
            "30x20 px",
        ),
        (
            1,
            "match no.toml --left left.png --right right.png",
            "no.toml",
        ),
        (
            1,
            "match rig.toml --left no.png --right right.png",
            "no.png",
        ),
        (
            1,
            "match rig.toml --left left.png --right right.png -o found.gif",
            "found.gif",
        ),
        (
            1,
            "match rig.toml --left left.png --right right.png --matcher superpoint",
            "superpoint",
        ),
    ] {
        let message = bench.refused(code, arguments);
        assert!(message.contains(says), "{arguments}: {message}");
    }
}
