//! Detection as data and as pictures.

use std::fs;

use crate::boards;
use crate::common::Bench;

#[test]
fn corners_come_as_json_csv_and_drawings() {
    let bench = Bench::new();
    boards::write(&bench.path("shots"), &boards::session([8, 6])[..2]);
    let json = bench.json("detect shots/00.png shots/01.png --board 8x6 -o found --csv all.csv");
    let pictures = json["pictures"].as_array().unwrap();
    assert_eq!(pictures.len(), 2);
    let mut rows = 1;
    for (picture, name) in pictures.iter().zip(["shots/00.png", "shots/01.png"]) {
        assert_eq!(picture["file"], name);
        let corners = picture["corners"].as_array().unwrap();
        assert_eq!(corners.len(), 48, "{picture}");
        for key in ["i", "j", "x", "y"] {
            assert!(corners[0][key].is_number(), "{picture}");
        }
        rows += corners.len();
    }
    // The board's middle, seen straight ahead, is in the lens's centre to a tenth of a pixel:
    // between the four corners around it.
    let corners = pictures[0]["corners"].as_array().unwrap();
    let mean = |key: &str| {
        let middle = corners.iter().filter(|corner| {
            let at = |key: &str| corner[key].as_u64().unwrap();
            (3..=4).contains(&at("i")) && (2..=3).contains(&at("j"))
        });
        middle
            .map(|corner| corner[key].as_f64().unwrap())
            .sum::<f64>()
            / 4.0
    };
    let [cx, cy] = boards::CENTRE_PX;
    // Tilts of 10 degrees bend the mean of the four by 0.2 px.
    assert!(
        (mean("x") - cx).hypot(mean("y") - cy) < 0.5,
        "{} {}",
        mean("x"),
        mean("y")
    );
    for file in ["all.csv", "found/corners.csv"] {
        let table = fs::read_to_string(bench.path(file)).unwrap();
        assert_eq!(table.lines().count(), rows, "{table}");
    }
    assert_eq!(bench.picture_size("found/00.png"), (480, 360));
    assert!(bench.path("found/corners.json").exists());
    let text = bench.done("detect shots --board 7x5 -o found");
    assert!(text.contains("a board of 8x6"), "{text}");
}

#[test]
fn markers_are_found_beside_no_board() {
    let bench = Bench::new();
    bench.done("simulate rig.toml -o pool --samples 2");
    let json = bench.json("detect pool/left.png --markers DICT_4X4_50");
    assert!(json["pictures"][0]["markers"].is_array(), "{json}");
    assert_eq!(json["pictures"][0]["corners"].as_array().unwrap().len(), 0);
}

#[test]
fn wrong_arguments_are_refused() {
    let bench = Bench::new();
    bench.refused(2, "detect shots");
    bench.refused(2, "detect --board 8x6");
    bench.refused(2, "detect shots --board 8by6");
    let message = bench.refused(2, "detect shots --markers DICT_5");
    assert!(message.contains("DICT_4X4_50"), "{message}");
    let message = bench.refused(1, "detect shots --board 8x6");
    assert!(message.contains("shots: cannot be read"), "{message}");
}
